"""Tones and spoken sentences with whatever this computer has; none of it can fail.

Qt's own sound and speech come with packages that need not be installed, and speech fails at import
without the sound library of the system. Else the programs that the system brings along play and
speak. Without those, Qt beeps, and a tone says at least that there is something to be read.
"""

from __future__ import annotations

import contextlib
import logging
import shutil
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QObject, QProcess, QTimer, Signal
from PySide6.QtWidgets import QApplication

from ui.voice.speech_queue import Utterance
from ui.voice.tones import PRIORITY_TONES, SAMPLE_RATE, TONES, tone_samples, tone_wav

SoundCommands = Mapping[str, tuple[tuple[str, ...], ...]]
"""Commands by `sys.platform`, the better first."""


class SoundCommand(QProcess):
    """A program that runs once and is gone afterwards."""

    ended = Signal(bool)  # It ended by itself: well or not. One that was cut off says nothing.

    def __init__(self, command: Sequence[str], parent: QObject) -> None:
        super().__init__(parent)
        self._cut_off = False
        self.setProgram(command[0])
        self.setArguments(list(command[1:]))
        self.finished.connect(self._finish)
        self.errorOccurred.connect(self._fail)

    def start_reading(self, text: str = "") -> None:
        """Start it, and let it read a text from its input."""
        self.start()
        if self.isOpen():  # not where it could not be started
            self.write(text.encode())
            self.closeWriteChannel()

    def abort(self) -> None:
        self._cut_off = True
        if self.state() == QProcess.ProcessState.NotRunning:
            self.deleteLater()
        else:
            self.kill()

    def _finish(self, code: int, _how: object) -> None:
        self._end(code == 0)

    def _fail(self, what: QProcess.ProcessError) -> None:
        if what == QProcess.ProcessError.FailedToStart:
            self._end(False)

    def _end(self, well: bool) -> None:
        if not self._cut_off:
            self.ended.emit(well)
        self.deleteLater()


def find_installed_command(programs: SoundCommands) -> tuple[str, ...] | None:
    """Return the first command for this system whose program is there; None for none."""
    for command in programs.get(sys.platform, ()):
        if shutil.which(command[0]) is not None:
            return command
    return None


log = logging.getLogger(__name__)

_PLAYER_COMMANDS: SoundCommands = {
    "linux": (("pw-play",), ("paplay",), ("aplay", "-q")),
    "darwin": (("afplay",),),
}
"""Programs that play the sound file named last."""


class TonePlayer(Protocol):
    """Makes tones heard."""

    def play(self, name: str) -> None:
        """Play a tone now, in place of the one that sounds."""

    def stop(self) -> None:
        """Fall silent at once."""


class Beeper:
    """One beep for every tone: what Qt can do without any sound of its own."""

    def play(self, name: str) -> None:  # noqa: ARG002  there is one beep only
        QApplication.beep()

    def stop(self) -> None:
        """Do nothing: a beep is over before one could."""


class _ToneFiles:
    """Tones as sound files, written when they are wanted, gone with the program."""

    def __init__(self) -> None:
        # Windows keeps the file that sounds when the program ends.
        self._folder = tempfile.TemporaryDirectory(
            prefix="gsapp-tones-", ignore_cleanup_errors=True
        )

    def path(self, name: str) -> str:
        file = Path(self._folder.name) / f"{name}.wav"
        if not file.exists():
            file.write_bytes(tone_wav(name))
        return str(file)


class CommandTonePlayer(QObject):
    """Plays tones with a program of the system; beeps where that fails.

    `command`: program and arguments; the sound file is added.
    """

    def __init__(self, command: Sequence[str], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._command = tuple(command)
        self._files = _ToneFiles()
        self._running: SoundCommand | None = None

    def play(self, name: str) -> None:
        self.stop()
        self._running = SoundCommand((*self._command, self._files.path(name)), self)
        self._running.ended.connect(self._over)
        self._running.start_reading()

    def stop(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.abort()

    def _over(self, well: bool) -> None:
        self._running = None
        if not well:
            QApplication.beep()


class WindowsTonePlayer:
    """Plays tones as Windows plays its own; beeps where it refuses.

    Raises `ImportError` on any other system.
    """

    def __init__(self) -> None:
        winsound: Any = import_module("winsound")
        self._play = winsound.PlaySound
        self._how = winsound.SND_FILENAME | winsound.SND_ASYNC | winsound.SND_NODEFAULT
        self._files = _ToneFiles()

    def play(self, name: str) -> None:
        try:
            self._play(self._files.path(name), self._how)
        except (RuntimeError, OSError):  # no loudspeaker, or none any more
            QApplication.beep()

    def stop(self) -> None:
        with contextlib.suppress(RuntimeError):
            self._play(None, 0)


class QtTonePlayer(QObject):
    """Plays tones through QtMultimedia.

    Raises `ImportError` if it is not installed, or a library of the system that it stands on is
    missing. Raises `OSError` if there is no loudspeaker, or none that takes these samples.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        from PySide6.QtMultimedia import QAudioFormat, QAudioSink, QMediaDevices

        device = QMediaDevices.defaultAudioOutput()
        form = QAudioFormat()
        form.setSampleRate(SAMPLE_RATE)
        form.setChannelCount(1)
        form.setSampleFormat(QAudioFormat.SampleFormat.Int16)
        if device.isNull() or not device.isFormatSupported(form):
            raise OSError("no audio output for tones")
        self._sink = QAudioSink(device, form, self)
        self._tones = {name: QByteArray(tone_samples(name).tobytes()) for name in TONES}
        self._buffer = QBuffer(self)

    def play(self, name: str) -> None:
        self.stop()
        self._buffer.setData(self._tones[name])
        self._buffer.open(QIODevice.OpenModeFlag.ReadOnly)
        self._sink.start(self._buffer)

    def stop(self) -> None:
        self._sink.reset()
        self._buffer.close()


def create_tone_player(parent: QObject | None = None) -> TonePlayer:
    """Return the best player that this computer has."""
    ways: list[Callable[[], TonePlayer]] = [lambda: QtTonePlayer(parent), WindowsTonePlayer]
    command = find_installed_command(_PLAYER_COMMANDS)
    if command is not None:
        ways.append(lambda: CommandTonePlayer(command, parent))
    for way in ways:
        try:
            return way()
        except (ImportError, OSError) as error:
            log.info("tones: %s", error)
    return Beeper()


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

_PAUSE_SECONDS = 0.15  # Seconds of silence after a tone that stands for words.


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
        self._running.start_reading(f"{utterance.text}\n")

    def stop(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.abort()

    def _over(self, well: bool) -> None:
        self._running = None
        (self.done if well else self.failed).emit(self._spoken)


class QtSpeaker(Speaker):
    """Speaks through QtTextToSpeech.

    Raises `ImportError` if it is not installed, or a library of the system that it stands on is
    missing. Raises `OSError` if there is no engine that speaks.
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
