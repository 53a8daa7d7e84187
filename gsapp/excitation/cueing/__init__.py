"""All that the crew is told, put together: trim, inputs, verdicts, cards, dangers, outlook."""

from gsapp.excitation.cueing.cue_generator import CueGenerator
from gsapp.excitation.cues import CueEvent, CueSnapshot, EventKind, NextCard

__all__ = [
    "CueEvent",
    "CueGenerator",
    "CueSnapshot",
    "EventKind",
    "NextCard",
]
