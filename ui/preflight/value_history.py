"""Undo and redo of something that is changed as a whole."""

from __future__ import annotations

from typing import Generic, TypeVar

Value = TypeVar("Value")


class ValueHistory(Generic[Value]):
    """What something was before, and what it became.

    Parameters
    ----------
    value : Value
        As it is at first; never changed in place.
    """

    def __init__(self, value: Value) -> None:
        self.value = value
        self._past: list[Value] = []
        self._future: list[Value] = []
        self._typing = ""

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Return whether there is a change to make again."""
        return bool(self._future)

    def record(self, value: Value, typing: str = "") -> None:
        """Take another value.

        Parameters
        ----------
        value : Value
            As it is now.
        typing : str
            Field that is typed into: letters typed one after the other are one change.
        """
        if not (typing and typing == self._typing and self._past):
            self._past.append(self.value)
        self._typing = typing
        self._future.clear()
        self.value = value

    def end_merge(self) -> None:
        """Let what is typed next be a change of its own."""
        self._typing = ""

    def undo(self) -> bool:
        """Go back by one change; return whether there was one."""
        return self._move(self._past, self._future)

    def redo(self) -> bool:
        """Go on by one change; return whether there was one."""
        return self._move(self._future, self._past)

    def _move(self, source: list[Value], target: list[Value]) -> bool:
        self._typing = ""
        if not source:
            return False
        target.append(self.value)
        self.value = source.pop()
        return True
