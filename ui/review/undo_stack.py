"""Changes of different kinds in the order in which they were made, taken back and made again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

_UNDO_LIMIT = 200
"""Changes that can be taken back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UndoCommand:
    """A change that was made: what takes it back, and what makes it again."""

    undo: Callable[[], object]
    redo: Callable[[], object]


class UndoStack:
    """What was done, and what was taken back."""

    def __init__(self) -> None:
        self._past: list[UndoCommand] = []
        self._future: list[UndoCommand] = []

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Return whether there is a change to make again."""
        return bool(self._future)

    def push(self, undo: Callable[[], object], redo: Callable[[], object]) -> None:
        """Note a change that was made just now."""
        self._past = [*self._past, UndoCommand(undo=undo, redo=redo)][-_UNDO_LIMIT:]
        self._future.clear()

    def undo(self) -> None:
        """Take the last change back, if there is one."""
        if self._past:
            deed = self._past.pop()
            self._future.append(deed)
            deed.undo()

    def redo(self) -> None:
        """Make the change again that was taken back last, if there is one."""
        if self._future:
            deed = self._future.pop()
            self._past.append(deed)
            deed.redo()
