"""The voice of the window: words and tones, one mute for both."""

from __future__ import annotations

import logging
import time

from PySide6.QtCore import QObject, Signal

from ui.voice.sound_output import (
    Speaker,
    TonePlayer,
    ToneSpeaker,
    create_speaker,
    create_tone_player,
)
from ui.voice.speech_queue import SpeechQueue, Utterance, UtterancePriority
from ui.voice.tones import TONES

log = logging.getLogger(__name__)


class Voice(QObject):
    """Says sentences by the rule of `ui.voice.speech_queue`, and plays tones.

    What the computer can do is looked for when something is to be heard for the first time:
    engines take a while to start, and most windows are muted or quiet.
    """

    spoken = Signal(str)  # A sentence begins; for those who would rather read it.

    def __init__(
        self,
        parent: QObject | None = None,
        *,
        muted: bool = False,
        player: TonePlayer | None = None,
        speaker: Speaker | None = None,
    ) -> None:
        super().__init__(parent)
        self._queue = SpeechQueue(time.monotonic)
        self._queue.set_muted(muted)
        self._player = player
        self._speaker: Speaker | None = None
        if speaker is not None:
            self._set_speaker(speaker)
        self._spoken: Utterance | None = None
        self._toned = ("", 0.0)

    @property
    def muted(self) -> bool:
        return self._queue.is_muted

    def say(
        self,
        text: str,
        priority: UtterancePriority = UtterancePriority.PROMPT,
        *,
        through: bool = False,
    ) -> None:
        """Say a sentence now, next or not at all, even in a hush if `through`."""
        self._queue.enqueue(text, priority, through=through)
        self._play_current()

    def set_quiet(self, hushed: bool) -> None:
        """Let nothing begin but what is said through it, until it ends; tones go on."""
        self._queue.set_quiet(hushed)
        self._play_current()

    def play_tone(self, name: str) -> None:
        """Play a tone of `ui.voice.tones`, at once and beside the words.

        A more urgent sentence is not disturbed, and a tone that sounds is not begun again.
        """
        tone = TONES[name]
        spoken = self._queue.speaking
        if not self.muted and (spoken is None or spoken.priority <= tone.priority):
            self._sound(name)

    def set_muted(self, muted: bool) -> None:
        """Fall silent at once, or be ready to be heard again."""
        self._queue.set_muted(muted)
        self._play_current()
        self._toned = ("", 0.0)
        if muted and self._player is not None:
            self._player.stop()

    def _sound(self, name: str) -> None:
        now = time.monotonic()
        sounding, until = self._toned
        if name != sounding or now >= until:
            self._toned = (name, now + TONES[name].duration)
            self._tones().play(name)

    def _tones(self) -> TonePlayer:
        if self._player is None:
            self._player = create_tone_player(self)
        return self._player

    def _voice(self) -> Speaker:
        return self._speaker or self._set_speaker(create_speaker(self._sound, self))

    def _set_speaker(self, speaker: Speaker) -> Speaker:
        if self._speaker is not None:
            # Not at once: it may be the one that is telling of its failure.
            self._speaker.deleteLater()
        speaker.setParent(self)
        self._speaker = speaker
        speaker.done.connect(self._done)
        speaker.failed.connect(self._failed)
        return speaker

    def _play_current(self) -> None:
        """Let be heard what the queue wants heard."""
        wanted = self._queue.speaking
        if wanted is self._spoken:
            return
        self._spoken = wanted
        if wanted is None:
            self._voice().stop()
            return
        self.spoken.emit(wanted.text)
        self._voice().speak(wanted)

    def _done(self, utterance: Utterance) -> None:
        self._queue.finished(utterance)
        self._play_current()

    def _failed(self, utterance: Utterance) -> None:
        """Go on with tones: a voice that failed once is not asked again."""
        log.warning("speech failed; using tones")
        self._set_speaker(ToneSpeaker(self._sound, self))
        if utterance is self._spoken:
            self._voice().speak(utterance)
