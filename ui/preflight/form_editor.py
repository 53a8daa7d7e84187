"""A file of the flight as it is typed: what will do is kept, what will not is told. No Qt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from pydantic import BaseModel

from gsapp.flight.toml_document import KeyPath, TomlDocument
from gsapp.foundation import FileProblemsError, FlightError, UnitError
from ui.disk_checks import may_block
from ui.preflight.flight_card_fields import CardField, format_field, parse_field
from ui.translation import tr
from ui.undo import UndoCommand, UndoStack

Model = TypeVar("Model", bound=BaseModel)


class FormEditor(Generic[Model]):
    """One file and what is being typed into it."""

    def __init__(self, file: TomlDocument[Model]) -> None:
        self.file = file
        self.problems: dict[KeyPath, str] = {}
        self._pending: dict[KeyPath, tuple[CardField, str]] = {}
        self._undo_stack = UndoStack()
        self._merge_serial = 0

    # What stands there

    def field_text(self, value: CardField, system: str) -> str:
        """Return what stands in a field: what is in the file, or what is still wrong there."""
        if value.key in self._pending:
            return self._pending[value.key][1]
        return format_field(value, self.file.value(value.key), system)

    def stored_value(self, key: KeyPath) -> Any:
        """Return what is in the file at a path; None if nothing is."""
        return self.file.value(key)

    def reload_if_changed(self) -> bool:
        """Read the file again if another program changed it; return whether one did."""
        if not self.file.is_saved or may_block(self.file.path) or not self.file.reload_if_changed():
            return False
        self.problems.clear()
        self._pending.clear()
        self._undo_stack.clear()
        return True

    # Changes

    def enter_text(self, value: CardField, text: str, system: str) -> bool:
        """Take what was typed into a field; return whether it is in the file now.

        A table that is only valid as a whole waits until it is; the rest of the file does not.
        """
        self._pending[value.key] = (value, text)
        together = {
            key: known
            for key, known in self._pending.items()
            if known[0].validated_key == value.validated_key
        }
        written: dict[KeyPath, Any] = {}
        for key, (one, typed) in together.items():
            self.problems.pop(key, None)
            try:
                written[key] = parse_field(one, typed, system)
            except UnitError as error:
                self.problems[key] = str(error)
        typing = ".".join(value.key)
        if not any(key in self.problems for key in together):
            return self._change(written, together, typing)
        if not value.group:
            # The screen shows another value than the one before: that is not in the file either.
            problem, waiting = self.problems[value.key], self._pending[value.key]
            self._change({value.key: None}, together, typing)
            self.problems[value.key], self._pending[value.key] = problem, waiting
        return False

    def set_values(self, values: Mapping[KeyPath, Any]) -> bool:
        """Write values as they would stand in the file; return whether they will do."""
        for key in values:
            for waiting in [one for one in self._pending if one[: len(key)] == key]:
                del self._pending[waiting]
                self.problems.pop(waiting, None)
        return self._change(values, dict.fromkeys(values), typing="")

    def _change(
        self, values: Mapping[KeyPath, Any], keys: Mapping[KeyPath, object], typing: str
    ) -> bool:
        former = self.file.content
        try:
            self.file.change(values)
        except FileProblemsError as error:
            self._assign_problems(error, keys)
            return False
        for key in keys:
            self._pending.pop(key, None)
            self.problems.pop(key, None)
        now = self.file.content
        if now != former:
            command = UndoCommand(
                tr("edit"),
                lambda: self.file.restore(former),
                lambda: self.file.restore(now),
                f"{typing} {self._merge_serial}" if typing else "",
            )
            self._undo_stack.push(command)
        return True

    def _assign_problems(self, error: FileProblemsError, keys: Mapping[KeyPath, object]) -> None:
        """Tell each problem at the field it is about, else at the one typed into last."""
        last = list(keys)[-1]
        for problem in error.problems:
            sentence = f"{problem.what}; {problem.remedy}" if problem.remedy else problem.what
            fits = [key for key in keys if problem.where == ".".join(key)]
            self.problems[fits[0] if fits else last] = sentence

    def discard_group(self, group: KeyPath) -> None:
        """Drop what waits in a group that is not in the file."""
        for key in [
            one for one, (value, _) in self._pending.items() if value.validated_key == group
        ]:
            del self._pending[key]
            self.problems.pop(key, None)

    def end_merge(self) -> None:
        """Let what is typed next be a change of its own."""
        self._merge_serial += 1

    # Undo

    def canUndo(self) -> bool:
        return bool(self._pending) or self._undo_stack.canUndo()

    def canRedo(self) -> bool:
        return self._undo_stack.canRedo()

    def undoText(self) -> str:
        return tr("edit") if self._pending else self._undo_stack.undoText()

    def redoText(self) -> str:
        return self._undo_stack.redoText()

    def undo(self) -> None:
        """Undo the last change; what is still wrong goes first."""
        self.end_merge()
        if self._pending:
            self._pending.clear()
            self.problems.clear()
        else:
            self._undo_stack.undo()

    def redo(self) -> None:
        self.end_merge()
        self._undo_stack.redo()

    def save(self) -> None:
        """Write what changed to the disk."""
        if may_block(self.file.path):
            raise FlightError(
                tr("{path} does not respond; not saved yet").format(path=self.file.path)
            )
        self.file.save()
