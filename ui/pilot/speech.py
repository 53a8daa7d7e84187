"""From what is to be heard of a flight to the voice of the window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from ui.display_limits import DISPLAY
from ui.voice.speech_queue import UtterancePriority
from ui.voice.voice import Voice

_PRIORITY: Final[Mapping[str, UtterancePriority]] = {
    "note": UtterancePriority.NOTE,
    "prompt": UtterancePriority.PROMPT,
    "warning": UtterancePriority.WARNING,
}


class FlightSpeech:
    """Says what is new, and keeps everything else silent while the hands are off.

    Which words those are was decided before (`gsapp.excitation.announcer`); of two at once the
    voice chooses.
    """

    def __init__(self, voice: Voice) -> None:
        self._voice = voice
        self._spoken_count = 0

    def restart(self, spoken: Sequence[Announcement] = ()) -> None:
        """Begin with another flight; what was to be heard of it before is not said."""
        self._spoken_count = len(spoken)
        self._voice.set_quiet(False)

    def speak_new_cues(
        self, cues: CueSnapshot | None, spoken: Sequence[Announcement], *, aloud: bool
    ) -> None:
        """Let be heard what is new."""
        if len(spoken) < self._spoken_count:
            self._spoken_count = 0  # a replay went back
        new, self._spoken_count = spoken[self._spoken_count :], len(spoken)
        under_way = cues.input_in_progress if aloud and cues is not None else None
        self._voice.set_quiet(under_way is not None and under_way.phase == "hands-off")
        if not aloud or cues is None or cues.time is None:
            return
        for one in new:
            if cues.time - one.time > DISPLAY.max_speech_delay:
                continue
            if one.tone:
                self._voice.play_tone(one.tone)
            if one.text:
                self._voice.say(one.text, _PRIORITY[one.priority], through=True)
                if one.tone:
                    # Where there is no voice a common tone has just taken its place.
                    self._voice.play_tone(one.tone)
