"""Files and folders dropped from a file manager."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QWidget

_DRAGS = (QEvent.Type.DragEnter, QEvent.Type.DragMove)


class FileDropFilter(QObject):
    """Takes what is dropped on a widget, or on what lies in it and takes nothing itself."""

    dropped = Signal(object)  # Paths, a tuple, once the file manager was answered.
    _taken = Signal(object)

    def __init__(self, target: QWidget) -> None:
        super().__init__(target)
        # A question asked within the event would hold up the file manager.
        self._taken.connect(self.dropped, Qt.ConnectionType.QueuedConnection)
        target.setAcceptDrops(True)
        target.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QDropEvent) and (paths := _paths(event)):
            # Whatever was proposed: moved, the flight would be taken away where it lay.
            event.setDropAction(Qt.DropAction.CopyAction)
            event.accept()
            if event.type() not in _DRAGS:
                self._taken.emit(paths)
            return True
        return super().eventFilter(watched, event)


def _paths(event: QDropEvent) -> tuple[Path, ...]:
    """Return the local files and folders among what is dragged."""
    urls = event.mimeData().urls()
    return tuple(Path(url.toLocalFile()) for url in urls if url.isLocalFile())
