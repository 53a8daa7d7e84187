"""Playing tones with whatever this computer has; none of it can fail.

Qt's own sound comes with a package that need not be installed. Else the program for sound files
that the system brings along plays the tones, and where there is none of that, Qt beeps.
"""

from __future__ import annotations

import contextlib
import logging
import tempfile
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QObject
from PySide6.QtWidgets import QApplication

from ui.voice.sound_command import SoundCommand, SoundCommands, find_installed_command
from ui.voice.tones import SAMPLE_RATE, TONES, tone_samples, tone_wav

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

    Parameters
    ----------
    command : sequence of str
        Program and arguments; the sound file is added.
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
        self._running.begin()

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

    Raises
    ------
    ImportError
        On any other system.
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

    Raises
    ------
    ImportError
        If it is not installed, or a library of the system that it stands on is missing.
    OSError
        If there is no loudspeaker, or none that takes these samples.
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
