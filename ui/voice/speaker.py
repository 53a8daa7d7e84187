"""Speaking one sentence at a time with whatever voice this computer has; none of it can fail.

Qt's own speech comes with a package that need not be installed, and fails at import without the
sound library of the system. Else the program that the system brings along speaks. Without any
voice a tone says at least that there is something to be read, and how urgent it is.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QTimer, Signal

from ui.voice.sound_command import SoundCommand, SoundCommands, find_installed_command
from ui.voice.speech_queue import Utterance
from ui.voice.tones import PRIORITY_TONES, TONES

log = logging.getLogger(__name__)

_SPEECH_COMMANDS: SoundCommands = {
    "linux": (("espeak-ng", "--stdin"), ("espeak", "--stdin")),
    "darwin": (("say",),),
    "win32": (
        (
            "powershell", "-NoProfile", "-Command",
            # Its own reader takes what comes for the old code page of the system.
            "Add-Type -AssemblyName System.Speech; (New-Object System.Speech.Synthesis."
            "SpeechSynthesizer).Speak((New-Object System.IO.StreamReader("
            "[Console]::OpenStandardInput(), [Text.Encoding]::UTF8)).ReadToEnd())",
        ),
    ),
}  # fmt: skip
"""Programs that speak what they read from their input."""

_PAUSE_SECONDS = 0.15
"""Seconds of silence after a tone that stands for words."""


class Speaker(QObject):
    """Speaks one utterance at a time."""

    done = Signal(object)  # An utterance was spoken to its end. One that was cut off says nothing.
    failed = Signal(object)  # This way of speaking does not work; the utterance that was not heard.

    def speak(self, utterance: Utterance) -> None:
        """Speak now, in place of what is being spoken."""
        raise NotImplementedError

    def stop(self) -> None:
        """Fall silent at once."""
        raise NotImplementedError


class ToneSpeaker(Speaker):
    """A tone in place of words, where there is no voice."""

    def __init__(self, sound: Callable[[str], object], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._sound = sound
        self._spoken: Utterance | None = None
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self._end)

    def speak(self, utterance: Utterance) -> None:
        name = PRIORITY_TONES[utterance.priority]
        self._spoken = utterance
        self._sound(name)
        self._timer.start(round(1000 * (TONES[name].duration + _PAUSE_SECONDS)))

    def stop(self) -> None:
        """Wait for nothing; a tone is over before it could be cut off."""
        self._timer.stop()
        self._spoken = None

    def _end(self) -> None:
        spoken, self._spoken = self._spoken, None
        self.done.emit(spoken)


class CommandSpeaker(Speaker):
    """Speaks with a program of the system, which reads the words from its input."""

    def __init__(self, command: Sequence[str], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._command = tuple(command)
        self._running: SoundCommand | None = None
        self._spoken: Utterance | None = None

    def speak(self, utterance: Utterance) -> None:
        self.stop()
        self._spoken = utterance
        self._running = SoundCommand(self._command, self)
        self._running.ended.connect(self._over)
        self._running.begin(f"{utterance.text}\n")

    def stop(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.abort()

    def _over(self, well: bool) -> None:
        self._running = None
        (self.done if well else self.failed).emit(self._spoken)


class QtSpeaker(Speaker):
    """Speaks through QtTextToSpeech.

    Raises
    ------
    ImportError
        If it is not installed, or a library of the system that it stands on is missing.
    OSError
        If there is no engine that speaks.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        from PySide6.QtTextToSpeech import QTextToSpeech

        # The mock engine, which is there for tests, waits as if it spoke.
        if not [name for name in QTextToSpeech.availableEngines() if name != "mock"]:
            raise OSError("no speech engine found")
        self._states = QTextToSpeech.State
        self._engine = QTextToSpeech(self)
        if self._engine.state() == self._states.Error:
            raise OSError(self._engine.errorString() or "the speech engine failed")
        self._spoken: Utterance | None = None
        self._began = False
        self._engine.stateChanged.connect(self._changed)

    def speak(self, utterance: Utterance) -> None:
        self.stop()
        self._spoken, self._began = utterance, False
        self._engine.say(utterance.text)

    def stop(self) -> None:
        if self._spoken is not None:
            self._spoken = None
            self._engine.stop()

    def _changed(self, state: object) -> None:
        if state == self._states.Speaking:
            self._began = True
            return
        over = state == self._states.Error or (state == self._states.Ready and self._began)
        if self._spoken is None or not over:
            return
        spoken, self._spoken = self._spoken, None
        (self.failed if state == self._states.Error else self.done).emit(spoken)


def create_speaker(sound: Callable[[str], object], parent: QObject | None = None) -> Speaker:
    """Return the best voice that this computer has; tones by `sound` where it has none."""
    ways: list[Callable[[], Speaker]] = [lambda: QtSpeaker(parent)]
    command = find_installed_command(_SPEECH_COMMANDS)
    if command is not None:
        ways.append(lambda: CommandSpeaker(command, parent))
    for way in ways:
        try:
            return way()
        except (ImportError, OSError) as error:
            log.info("voice: %s", error)
    return ToneSpeaker(sound, parent)
