"""Changes that can be undone: commands for Qt's undo stack, and its interface for other histories.

Histories that a file keeps are no stack of commands: `docs/decisions/0025-undo-in-the-window.md`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from PySide6.QtGui import QUndoCommand, QUndoStack

UNDO_LIMIT = 200  # Changes that can be undone.


class UndoHistory(Protocol):
    """What a page offers to undo: a `QUndoStack`, or something with these methods of it."""

    def canUndo(self) -> bool: ...
    def canRedo(self) -> bool: ...
    def undoText(self) -> str: ...
    def redoText(self) -> str: ...
    def undo(self) -> None: ...
    def redo(self) -> None: ...


class UndoCommand(QUndoCommand):
    """A change that is made already when it is pushed.

    `merge_key`: a change with the same key right before becomes one with this: letters typed into a
    field.
    """

    def __init__(
        self, text: str, undo: Callable[[], object], redo: Callable[[], object], merge_key: str = ""
    ) -> None:
        super().__init__(text)
        self._undo, self._redo = undo, redo
        self._merge_key = merge_key
        self._is_pushed = False
        self.error: Exception | None = None

    def id(self) -> int:
        return 1 if self._merge_key else -1

    def mergeWith(self, other: QUndoCommand) -> bool:
        if not isinstance(other, UndoCommand) or other._merge_key != self._merge_key:
            return False
        self._redo = other._redo
        return True

    def undo(self) -> None:
        self._run(self._undo)

    def redo(self) -> None:
        # Qt calls it when the command is pushed, too.
        if self._is_pushed:
            self._run(self._redo)
        self._is_pushed = True

    def _run(self, act: Callable[[], object]) -> None:
        # On its way through Qt an error would get another message; the stack raises it.
        try:
            act()
        except Exception as error:
            self.error = error


class UndoStack(QUndoStack):
    """Qt's undo stack; an error of a command is raised as it is."""

    def undo(self) -> None:
        super().undo()
        self._raise_error(self.index())

    def redo(self) -> None:
        super().redo()
        self._raise_error(self.index() - 1)

    def _raise_error(self, index: int) -> None:
        command = self.command(index) if index < self.count() else None
        if isinstance(command, UndoCommand) and command.error is not None:
            error, command.error = command.error, None
            raise error
