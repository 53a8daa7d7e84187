"""Fields in rows: the throws of the sticks, and lists that grow by a row when one is filled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QGridLayout, QLineEdit, QSizePolicy, QWidget

from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.preflight.form_fields import FormLineEdit, set_touch_height
from ui.translation import tr
from ui.widgets.labels import create_label

_MOST_ROWS = 6  # that grow


@dataclass(frozen=True, slots=True, kw_only=True)
class GridColumn:
    """One column of a list.

    Attributes
    ----------
    name : str
        Above it, and for those who hear it.
    choices : tuple of (str, str)
        Keys and words; empty for text.
    share : int
        Of the width.
    """

    name: str
    choices: tuple[tuple[str, str], ...] = ()
    share: int = 1


class FieldGrid(QWidget):
    """Fields in rows and columns with titles above and, if there are, names on the left.

    Attributes
    ----------
    cell_edited : Signal(int, int, str)
        Row, column and what stands there now.
    editing_finished : Signal
        The keyboard went elsewhere.
    """

    cell_edited = Signal(int, int, str)
    editing_finished = Signal()

    def __init__(
        self, look: DisplayStyle, columns: Sequence[GridColumn], names: Sequence[str] = ()
    ) -> None:
        super().__init__()
        self._look = look
        self._columns = tuple(columns)
        self._named = bool(names)
        self.cells: list[list[QLineEdit | QComboBox]] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self.titles = [create_label(column.name, "label") for column in columns]
        for place, (title, column) in enumerate(zip(self.titles, columns, strict=True)):
            self._grid.addWidget(title, 0, place + self._named)
            self._grid.setColumnStretch(place + self._named, column.share)
        self.message = FieldMessage()
        self.message.hide()
        for name in names:
            self.add_row(name)
        look.changed.connect(self._fit)
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

    def show_message(self, words: str, state: str = "") -> None:
        """Say something below, or nothing."""
        self.message.set_message(words, state)
        self.message.setVisible(bool(words))

    def _fit(self) -> None:
        px = self._look.px
        self._grid.setHorizontalSpacing(px(8))
        self._grid.setVerticalSpacing(px(4))


class GrowingFieldGrid(FieldGrid):
    """A list in rows, with an empty one below for the next entry.

    Attributes
    ----------
    rows_changed : Signal
        Other rows stand there now.
    """

    rows_changed = Signal()

    def __init__(self, look: DisplayStyle, columns: Sequence[GridColumn]) -> None:
        super().__init__(look, columns)
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
            for place, text in enumerate(row):
                self.set_text(number, place, text)

    def _grow(self, row: int, _place: int, _text: str) -> None:
        last = len(self.cells) - 1
        if row == last and len(self.cells) < _MOST_ROWS and len(self.rows) == len(self.cells):
            before = self.cells[last][-1]
            self.add_row()
            for cell in self.cells[-1]:
                QWidget.setTabOrder(before, cell)
                before = cell
        self.rows_changed.emit()
