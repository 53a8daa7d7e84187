"""All that the crew is told, put together: trim, inputs, verdicts, cards, dangers, outlook."""

from gsapp.excitation.cueing.cue_generator import CueGenerator

__all__ = ["CueGenerator"]
