"""All that the crew is told, put together: trim, inputs, verdicts, cards, dangers, outlook."""

from gsapp.excitation.cueing.cueing import Cueing
from gsapp.excitation.cues import (
    VERDICT_STANDS,
    CueEvent,
    CueSnapshot,
    EventKind,
    NextCard,
)

__all__ = ["VERDICT_STANDS", "CueEvent", "CueSnapshot", "Cueing", "EventKind", "NextCard"]
