"""Fields of the forms before a flight: high enough for gloves, alone and in grids."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pydantic import BaseModel
from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QLineEdit,
    QPlainTextEdit,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.flight.toml_document import KeyPath
from gsapp.foundation import UnitError
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.preflight.form_editor import FormEditor
from ui.translation import tr
from ui.widgets.labels import create_label

_NAME, _UNIT = 128, 40
"""Points for the name left of a field and for the unit right of it."""


def set_touch_height(widget: QWidget) -> None:
    """Let a control be as high as gloves need; the style sheet knows how high that is."""
    widget.setProperty("tall", True)


def _is_undo(event: QEvent) -> bool:
    """Return whether a key means undo or redo, which belong to the whole page."""
    return (
        event.type() == QEvent.Type.ShortcutOverride
        and isinstance(event, QKeyEvent)
        and any(
            event.matches(key)
            for key in (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
        )
    )


class FormLineEdit(QLineEdit):
    """One line of text."""

    editing_finished = Signal()

    def event(self, event: QEvent) -> bool:
        if _is_undo(event):
            event.ignore()
            return False
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.editing_finished.emit()


class FormTextEdit(QPlainTextEdit):
    """Some lines of text; Tab goes on to the next field."""

    editing_finished = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setTabChangesFocus(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def event(self, event: QEvent) -> bool:
        if _is_undo(event):
            event.ignore()
            return False
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.editing_finished.emit()


class _WidePopupComboBox(QComboBox):
    """A box in a narrow column, whose list is as wide as its longest line."""

    def showPopup(self) -> None:
        view = self.view()
        view.setMinimumWidth(view.sizeHintForColumn(0) + 2 * view.frameWidth())
        super().showPopup()


class FormField(QWidget):
    """A named field with a unit right of it and a sentence below it.

    Parameters
    ----------
    rows : int
        Lines of text in sight; 1 for a single one.
    choices : sequence of (str, str)
        Keys and words to choose from, in place of text.
    """

    text_edited = Signal(str)
    editing_finished = Signal()

    def __init__(
        self,
        style: DisplayStyle,
        name: str,
        *,
        rows: int = 1,
        choices: Sequence[tuple[str, str]] = (),
    ) -> None:
        super().__init__()
        self._style = style
        self._rows = rows
        self.name = create_label(tr(name), wrap=True)
        self.unit = create_label("", "muted")
        self.message = FieldMessage()
        self.message.hide()
        self.edit = self._create_edit(rows, choices)
        self.edit.setAccessibleName(tr(name))
        set_touch_height(self.edit)
        self.setFocusProxy(self.edit)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(1, 1)
        if rows == 1:
            self._grid.addWidget(self.name, 0, 0)
            self._grid.addWidget(self.edit, 0, 1)
            self._grid.addWidget(self.unit, 0, 2)
        else:
            self._grid.addWidget(self.name, 0, 0, 1, 3)
            self._grid.addWidget(self.edit, 1, 0, 1, 3)
        self._grid.addWidget(self.message, 2, 0 if rows > 1 else 1, 1, -1)
        style.changed.connect(self._fit)
        self._fit()

    def _create_edit(
        self, rows: int, choices: Sequence[tuple[str, str]]
    ) -> QComboBox | FormTextEdit | FormLineEdit:
        if choices:
            box = _WidePopupComboBox()
            box.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
            for key, text in choices:
                box.addItem(tr(text), key)
            box.activated.connect(lambda _index: self.text_edited.emit(self.text))
            return box
        if rows > 1:
            lines = FormTextEdit()
            lines.textChanged.connect(lambda: self.text_edited.emit(self.text))
            lines.editing_finished.connect(self.editing_finished)
            return lines
        line = FormLineEdit()
        line.textEdited.connect(self.text_edited)
        line.editing_finished.connect(self.editing_finished)
        return line

    @property
    def text(self) -> str:
        edit = self.edit
        if isinstance(edit, QComboBox):
            return str(edit.currentData() or "")
        return edit.toPlainText() if isinstance(edit, QPlainTextEdit) else edit.text()

    def set_text(self, text: str) -> None:
        """Show another text, or choice; emits nothing, and leaves the cursor where it was."""
        edit = self.edit
        if text == self.text:
            return
        edit.blockSignals(True)
        if isinstance(edit, QComboBox):
            edit.setCurrentIndex(max(edit.findData(text), 0))
        elif isinstance(edit, QPlainTextEdit):
            edit.setPlainText(text)
        else:
            edit.setText(text)
        edit.blockSignals(False)

    def set_choices(self, choices: Sequence[tuple[str, str]], chosen: str) -> None:
        """Show other choices with one of them chosen; emits nothing."""
        box = self.edit
        if isinstance(box, QComboBox):
            if [box.itemData(place) for place in range(box.count())] != [key for key, _ in choices]:
                box.clear()
                for key, text in choices:
                    box.addItem(tr(text), key)
            self.set_text(chosen)

    def select_all(self) -> None:
        """Let what is typed next replace what stands there."""
        if isinstance(self.edit, QLineEdit):
            self.edit.selectAll()

    def show_unit(self, unit: str) -> None:
        """Show another unit."""
        self.unit.setText(unit)
        self._fit()

    def show_hint(self, hint: str) -> None:
        """Show, where nothing was typed, what would stand there."""
        if isinstance(self.edit, (QLineEdit, QPlainTextEdit)):
            self.edit.setPlaceholderText(hint)

    def show_message(self, text: str, state: str = "") -> None:
        """Say something below the field, or nothing."""
        self.message.set_message(text, state)
        self.message.setVisible(bool(text))
        self.edit.setAccessibleDescription(text)

    def _fit(self) -> None:
        px = self._style.px
        self._grid.setHorizontalSpacing(px(8))
        self._grid.setVerticalSpacing(px(2))
        if self._rows > 1:
            self.edit.setFixedHeight(px(20 * self._rows + 16))
        else:
            self.name.setFixedWidth(px(_NAME))
            self.unit.setFixedWidth(px(_UNIT))
            self.unit.setVisible(bool(self.unit.text()))


_MOST_ROWS = 6  # that grow


@dataclass(frozen=True, slots=True, kw_only=True)
class GridColumn:
    """One column of a list."""

    name: str
    """Above it, and for those who hear it."""
    choices: tuple[tuple[str, str], ...] = ()
    """Keys and words; empty for text."""
    share: int = 1
    """Of the width."""


class FieldGrid(QWidget):
    """Fields in rows and columns with titles above and, if there are, names on the left."""

    cell_edited = Signal(int, int, str)  # row, column, text
    editing_finished = Signal()

    def __init__(
        self, style: DisplayStyle, columns: Sequence[GridColumn], names: Sequence[str] = ()
    ) -> None:
        super().__init__()
        self._style = style
        self._columns = tuple(columns)
        self._named = bool(names)
        self.cells: list[list[QLineEdit | QComboBox]] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self.titles = [create_label(column.name, "label") for column in columns]
        for index, (title, column) in enumerate(zip(self.titles, columns, strict=True)):
            self._grid.addWidget(title, 0, index + self._named)
            self._grid.setColumnStretch(index + self._named, column.share)
        self.message = FieldMessage()
        self.message.hide()
        for name in names:
            self.add_row(name)
        style.changed.connect(self._fit)
        self._fit()

    def add_row(self, name: str = "") -> None:
        """Add a row below."""
        row = len(self.cells)
        if self._named:
            self._grid.addWidget(create_label(name), row + 1, 0)
        cells = [self._cell(row, place, name) for place in range(len(self._columns))]
        self.cells.append(cells)
        for place, cell in enumerate(cells):
            set_touch_height(cell)
            self._grid.addWidget(cell, row + 1, place + self._named)
        self._grid.addWidget(self.message, row + 2, 0, 1, -1)
        self._fit()

    def remove_row(self) -> None:
        """Take the last row away."""
        for cell in self.cells.pop():
            cell.hide()
            cell.deleteLater()

    def _cell(self, row: int, place: int, name: str) -> QLineEdit | QComboBox:
        column = self._columns[place]
        spoken = (
            tr("{column} of {name}").format(column=column.name, name=name.lower())
            if name
            else tr("{name}, row {row}").format(name=column.name, row=row + 1)
        )
        if column.choices:
            box = QComboBox()
            for key, words in column.choices:
                box.addItem(tr(words), key)
            box.activated.connect(
                lambda _index: self.cell_edited.emit(row, place, str(box.currentData()))
            )
            box.setAccessibleName(spoken)
            box.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
            return box
        line = FormLineEdit()
        line.setAccessibleName(spoken)
        line.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        line.setMinimumWidth(1)
        line.textEdited.connect(lambda text: self.cell_edited.emit(row, place, text))
        line.editing_finished.connect(self.editing_finished)
        return line

    def text(self, row: int, place: int) -> str:
        """Return what stands in a cell; of choices the key."""
        cell = self.cells[row][place]
        return str(cell.currentData() or "") if isinstance(cell, QComboBox) else cell.text()

    def set_text(self, row: int, place: int, text: str) -> None:
        """Show another text or choice; emits nothing."""
        cell = self.cells[row][place]
        if isinstance(cell, QComboBox):
            cell.setCurrentIndex(max(cell.findData(text), 0))
        elif cell.text() != text:
            cell.setText(text)

    def show_message(self, text: str, state: str = "") -> None:
        """Say something below, or nothing."""
        self.message.set_message(text, state)
        self.message.setVisible(bool(text))

    def _fit(self) -> None:
        px = self._style.px
        self._grid.setHorizontalSpacing(px(8))
        self._grid.setVerticalSpacing(px(4))


class GrowingFieldGrid(FieldGrid):
    """A list in rows, with an empty one below for the next entry."""

    rows_changed = Signal()

    def __init__(self, style: DisplayStyle, columns: Sequence[GridColumn]) -> None:
        super().__init__(style, columns)
        self._empty = tuple(column.choices[0][0] if column.choices else "" for column in columns)
        self.add_row()
        self.cell_edited.connect(self._grow)

    @property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Return the rows that hold something."""
        every = (
            tuple(self.text(row, place) for place in range(len(self._columns)))
            for row in range(len(self.cells))
        )
        return tuple(row for row in every if row != self._empty)

    def show_rows(self, rows: Sequence[Sequence[str]]) -> None:
        """Show other rows."""
        if tuple(tuple(row) for row in rows) == self.rows:
            return
        # What a file holds is shown, however much: what is not would be lost with the next change.
        wanted = [*rows, self._empty][: max(_MOST_ROWS, len(rows))]
        while len(self.cells) > len(wanted):
            self.remove_row()
        while len(self.cells) < len(wanted):
            self.add_row()
        for number, row in enumerate(wanted):
            for index, text in enumerate(row):
                self.set_text(number, index, text)

    def _grow(self, row: int, _place: int, _text: str) -> None:
        last = len(self.cells) - 1
        if row == last and len(self.cells) < _MOST_ROWS and len(self.rows) == len(self.cells):
            before = self.cells[last][-1]
            self.add_row()
            for cell in self.cells[-1]:
                QWidget.setTabOrder(before, cell)
                before = cell
        self.rows_changed.emit()


T = TypeVar("T", bound=BaseModel)


class FormPart(QWidget, Generic[T]):
    """Part of the form of a file."""

    edited = Signal()
    editing_finished = Signal()

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._editor: FormEditor[T] | None = None
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)

    def validate(self) -> None:
        """Say what will not do."""

    def _store_rows(
        self,
        key: KeyPath,
        rows: Iterable[Sequence[str]],
        build: Callable[[Sequence[str]], Mapping[str, Any]],
        incomplete: str,
    ) -> None:
        """Put the rows on the card that are whole; say what is missing of the others."""
        editor = self._editor
        if editor is None:
            return
        items, problem = [], ""
        for row in rows:
            if not all(row):
                problem = incomplete
                continue
            try:
                items.append(build(row))
            except UnitError as error:
                problem = str(error)
        if editor.set_values({key: items or None}) and problem:
            editor.problems[key] = problem
        self.validate()
        self.edited.emit()
