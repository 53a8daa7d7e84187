"""Commands on Qt's undo stack: made when pushed, merged while a field is typed into."""

from __future__ import annotations

import pytest

from gsapp.foundation import FlightError
from ui.undo import UndoCommand, UndoStack


class Value:
    """A number with a history."""

    def __init__(self) -> None:
        self.now = 0
        self.stack = UndoStack()

    def set(self, now: int, merge_key: str = "") -> None:
        """Change it, as the pages do: first the change, then the command."""
        former, self.now = self.now, now
        self.stack.push(
            UndoCommand(
                f"set {now}", lambda: self._restore(former), lambda: self._restore(now), merge_key
            )
        )

    def _restore(self, value: int) -> None:
        self.now = value


def test_another_change_leaves_nothing_to_redo() -> None:
    value = Value()
    value.set(1)
    value.set(2)
    assert (value.now, value.stack.undoText()) == (2, "set 2")
    value.stack.undo()
    assert (value.now, value.stack.redoText()) == (1, "set 2")
    value.set(3)
    assert not value.stack.canRedo()
    value.stack.undo()
    assert value.now == 1
    value.stack.redo()
    assert value.now == 3


def test_typing_into_one_field_is_one_change() -> None:
    value = Value()
    for now, key in ((1, "speed"), (12, "speed"), (120, "speed"), (121, "mass")):
        value.set(now, key)
    assert value.stack.count() == 2
    value.stack.undo()
    assert value.now == 120
    value.stack.undo()
    assert value.now == 0
    value.stack.redo()
    assert value.now == 120


def test_an_error_of_a_command_keeps_its_message() -> None:
    def fail() -> None:
        raise FlightError("the disk is full")

    stack = UndoStack()
    stack.push(UndoCommand("tick", fail, fail))
    with pytest.raises(FlightError, match=r"^the disk is full$"):
        stack.undo()
    with pytest.raises(FlightError, match=r"^the disk is full$"):
        stack.redo()
    assert stack.undoText() == "tick"
