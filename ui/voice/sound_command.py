"""A program of the system that is heard: started, cut off, told of when it ends."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping, Sequence

from PySide6.QtCore import QObject, QProcess, Signal

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

    def begin(self, text: str = "") -> None:
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
