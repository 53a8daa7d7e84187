"""The derivatives of the axis: free or held, where they start, what is known beforehand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QFontMetrics, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

from gsapp.identification.axes import axis_derivatives
from ui.display_style import DisplayStyle
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.number_format import MINUS, symbol_text, value_with_std_text
from ui.review.estimate_text import AS_MODEL_TEXT, TREATMENT_CHOICES
from ui.widgets.table_menu import TableMenu
from ui.widgets.table_models import TextEditDelegate

ModelIndex = QModelIndex | QPersistentModelIndex

ESTIMATE_COLUMN_TITLES: Final = ("", "Treated", "Last run", "Held at", "Start", "Known", "±")
(
    NAME_COLUMN,
    TREATMENT_COLUMN,
    LAST_COLUMN,
    VALUE_COLUMN,
    START_COLUMN,
    PRIOR_COLUMN,
    DEVIATION_COLUMN,
) = range(7)
_FIELDS: Final = {
    VALUE_COLUMN: "value",
    START_COLUMN: "start",
    PRIOR_COLUMN: "prior",
    DEVIATION_COLUMN: "deviation",
}
_COLUMN_DESCRIPTIONS: Final = {
    VALUE_COLUMN: "value that it is held at",
    START_COLUMN: "start value",
    PRIOR_COLUMN: "a-priori value",
    DEVIATION_COLUMN: "deviation of the a-priori value",
}
_ROW: Final = 30
_MOST_ROWS: Final = 12
_PADDING: Final = 14
"""Points beside the letters of a cell."""
_WIDEST: Final = 176
"""Points of the names of effects' parameters."""
_WIDTHS: Final = {
    NAME_COLUMN: 76,
    TREATMENT_COLUMN: 54,
    VALUE_COLUMN: 58,
    START_COLUMN: 50,
    PRIOR_COLUMN: 50,
    DEVIATION_COLUMN: 38,
}


class DerivativeModel(QAbstractTableModel):
    """One row for each derivative of the axis.

    Attributes
    ----------
    edited : Signal(object)
        The wishes with another one for a derivative.
    """

    edited = Signal(object)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.names: tuple[str, ...] = ()
        self.wishes = EstimateForm()
        self.last: Mapping[str, str] = {}
        self.effects: Mapping[str, float] = {}

    def set_form(self, wishes: EstimateForm) -> None:
        """Show other wishes."""
        axis = axis_derivatives("both" if wishes.six_degrees else wishes.axis)
        names = (*axis, *self.effects)
        if names != self.names:
            self.beginResetModel()
            self.names, self.wishes = names, wishes
            self.endResetModel()
        elif wishes != self.wishes:
            self.wishes = wishes
            self._repaint()

    def show_effects(self, effects: Mapping[str, float]) -> None:
        """Show the parameters of the model's effects below the derivatives, with their values."""
        self.effects = effects
        self.set_form(self.wishes)

    def show_last(self, last: Mapping[str, str]) -> None:
        """Show what the last run gave, in words."""
        if last != self.last:
            self.last = last
            self._repaint()

    def _repaint(self) -> None:
        self.dataChanged.emit(self.index(0, 0), self.index(len(self.names) - 1, DEVIATION_COLUMN))

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of derivatives."""
        return 0 if parent is not None and parent.isValid() else len(self.names)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of columns."""
        return 0 if parent is not None and parent.isValid() else len(ESTIMATE_COLUMN_TITLES)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return the title of a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return ESTIMATE_COLUMN_TITLES[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return int(_alignment(section))
        return None

    def entry_at(self, row: int) -> DerivativeEntry:
        """Return the wish of a row."""
        return self.wishes.derivative(self.names[row])

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return text, type, what is said of a cell."""
        name, column = self.names[index.row()], index.column()
        wish = self.wishes.derivative(name)
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return self._text(name, wish, column)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return int(_alignment(column))
        if role == Qt.ItemDataRole.FontRole:
            if column == NAME_COLUMN and name in self.effects:
                return self._look.font("small", strong=wish != DerivativeEntry())
            own = column == NAME_COLUMN and wish != DerivativeEntry()
            return self._look.font("body", strong=own)
        if role == Qt.ItemDataRole.ForegroundRole and not self._counts(wish, column):
            return QColor(self._look.color("muted"))
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleTextRole):
            return self._said(name, wish, column)
        return None

    def _text(self, name: str, wish: DerivativeEntry, column: int) -> str:
        if column == NAME_COLUMN:
            return symbol_text(name)
        if column == TREATMENT_COLUMN:
            usual = name in self.effects and wish.treated == "tables"
            return AS_MODEL_TEXT if usual else dict(TREATMENT_CHOICES)[wish.treated]
        if column == LAST_COLUMN:
            return self.last.get(name, "")
        if column == VALUE_COLUMN and name in self.effects and not wish.value:
            return f"{self.effects[name]:.4g}"
        return str(getattr(wish, _FIELDS[column]))

    def _counts(self, wish: DerivativeEntry, column: int) -> bool:
        """Return whether a cell says something that the run heeds."""
        if column == TREATMENT_COLUMN:
            return wish.treated != "tables"
        if column == VALUE_COLUMN:
            return wish.treated == "held"
        if column in (START_COLUMN, PRIOR_COLUMN, DEVIATION_COLUMN):
            return wish.treated != "held"
        return True

    def _said(self, name: str, wish: DerivativeEntry, column: int) -> str:
        text = self._text(name, wish, column)
        if column == TREATMENT_COLUMN:
            return f"{symbol_text(name)} {text}; Space changes it"
        if column in _COLUMN_DESCRIPTIONS:
            return f"{_COLUMN_DESCRIPTIONS[column]} of {symbol_text(name)}: {text or 'none'}"
        return f"{symbol_text(name)}, last run: {text}" if column == LAST_COLUMN and text else text

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        """Return whether a cell may be typed into."""
        flags = super().flags(index)
        if index.column() in _FIELDS:
            flags |= Qt.ItemFlag.ItemIsEditable
        return flags

    def setData(
        self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        """Take what was typed; a value to hold at holds the derivative."""
        if role != Qt.ItemDataRole.EditRole or index.column() not in _FIELDS:
            return False
        text = str(value).strip()
        wish = self.entry_at(index.row())
        changes = {_FIELDS[index.column()]: text}
        if index.column() == VALUE_COLUMN and text and text != wish.value:
            changes["treated"] = "held"
        self._change(index.row(), wish.model_copy(update=changes))
        return True

    def cycle_treatment(self, row: int) -> None:
        """Treat a derivative in the next way; held, it begins with what the last run gave."""
        wish = self.entry_at(row)
        ways = [key for key, _ in TREATMENT_CHOICES]
        treated = ways[(ways.index(wish.treated) + 1) % len(ways)]
        value = wish.value
        if treated == "held" and not value:
            name = self.names[row]
            value = self.last.get(name, "").partition(" ")[0].replace(MINUS, "-")
            if not value and name in self.effects:
                value = repr(self.effects[name])
        self._change(row, wish.model_copy(update={"treated": treated, "value": value}))

    def reset_row(self, row: int) -> None:
        """Take back everything that was wished for a derivative."""
        self._change(row, DerivativeEntry())

    def _change(self, row: int, wish: DerivativeEntry) -> None:
        if wish != self.entry_at(row):
            self.edited.emit(self.wishes.with_derivative(self.names[row], wish))


class DerivativeTable(QTableView):
    """The table; Space treats in the next way, typing writes, Delete takes all of a row back."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.model_of = DerivativeModel(look)
        self.setModel(self.model_of)
        self.setItemDelegate(TextEditDelegate(self))
        self.setAccessibleName("Derivatives")
        self.setProperty("role", "close")
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.AnyKeyPressed
            | QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self.setTabKeyNavigation(False)
        # Else a bound that has no room goes to a second line, where nobody sees it.
        self.setWordWrap(False)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.clicked.connect(self._clicked)
        self.menu = TableMenu(self)
        self.model_of.modelReset.connect(self._fit)
        self.model_of.dataChanged.connect(self._fit)
        look.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        px = self._look.px
        for column, width in _WIDTHS.items():
            self.setColumnWidth(column, px(width))
        # Strong, as they are once something is asked of them.
        own = QFontMetrics(self._look.font("body", strong=True))
        small = QFontMetrics(self._look.font("small", strong=True))
        names = [
            (small if name in self.model_of.effects else own).horizontalAdvance(symbol_text(name))
            + px(_PADDING)
            for name in self.model_of.names
        ]
        self.setColumnWidth(NAME_COLUMN, min(max([px(_WIDTHS[NAME_COLUMN]), *names]), px(_WIDEST)))
        letters = QFontMetrics(self._look.font("body"))
        written = map(letters.horizontalAdvance, self.model_of.last.values())
        least = max(written, default=0) + px(_PADDING)
        room = self.viewport().width() - sum(self.columnWidth(column) for column in _WIDTHS)
        self.setColumnWidth(LAST_COLUMN, max(room, least))
        self.horizontalHeader().setMinimumSectionSize(px(40))
        self.verticalHeader().setDefaultSectionSize(px(_ROW))
        rows = min(len(self.model_of.names), _MOST_ROWS)
        bar = self.horizontalScrollBar().sizeHint().height() if room < least else 0
        self.setFixedHeight(rows * px(_ROW) + px(34) + bar)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give what room is left to the last column."""
        super().resizeEvent(event)
        self._fit()

    def _clicked(self, index: QModelIndex) -> None:
        if index.column() == TREATMENT_COLUMN:
            self.model_of.cycle_treatment(index.row())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn with Space, take back with Delete, write with any other letter."""
        index = self.currentIndex()
        if self.state() == QAbstractItemView.State.EditingState:
            # Enter ends the typing and comes by here, too.
            super().keyPressEvent(event)
        elif index.isValid() and event.key() == Qt.Key.Key_Space:
            self.model_of.cycle_treatment(index.row())
        elif index.isValid() and event.key() == Qt.Key.Key_Delete:
            self.model_of.reset_row(index.row())
        elif index.isValid() and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if index.column() in _FIELDS:
                self.edit(index)
            else:
                self.model_of.cycle_treatment(index.row())
        else:
            super().keyPressEvent(event)


def format_last_values(
    names: Sequence[str], values: Mapping[str, tuple[float, float]]
) -> dict[str, str]:
    """Return what a run gave of each derivative, in words."""
    return {name: value_with_std_text(*values[name]) for name in names if name in values}


def _alignment(column: int) -> Qt.AlignmentFlag:
    side = (
        Qt.AlignmentFlag.AlignLeft
        if column in (NAME_COLUMN, TREATMENT_COLUMN)
        else Qt.AlignmentFlag.AlignRight
    )
    return side | Qt.AlignmentFlag.AlignVCenter
