"""All that the crew is told, put together: trim, inputs, verdicts, cards, dangers, outlook."""

from gsapp.excitation.cueing.cue_generator import CueGenerator
from gsapp.excitation.cues import (
    VERDICT_DISPLAY_TIME,
    CueEvent,
    CueSnapshot,
    EventKind,
    NextCard,
)

__all__ = [
    "VERDICT_DISPLAY_TIME",
    "CueEvent",
    "CueGenerator",
    "CueSnapshot",
    "EventKind",
    "NextCard",
]
