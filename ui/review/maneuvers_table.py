"""The maneuvers of all flights in one table: sorted, chosen, renamed, noted, used or not."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QSize,
    QSortFilterProxyModel,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

from gsapp.session.review.review import ManeuverRow
from ui.flight.tables import Index
from ui.look import Look
from ui.review.maneuvers_columns import COLUMNS, PLACES, TYPED, Column
from ui.review.timeline_drawing import GRADE_STATES

_SORT = Qt.ItemDataRole.UserRole
_RIGHT = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
_HIGH = 150
"""Points of height of the head and four rows."""
_LEFT = int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)


class ManeuversModel(QAbstractTableModel):
    """A row for each maneuver.

    Attributes
    ----------
    renamed, noted : Signal(str, str)
        Id in the campaign, and the new name or note.
    used : Signal(str, bool)
        Id in the campaign, and whether it shall take part.
    """

    renamed = Signal(str, str)
    noted = Signal(str, str)
    used = Signal(str, bool)

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.rows: tuple[ManeuverRow, ...] = ()

    def show(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; where the maneuvers are the same ones, only what changed."""
        new, old = tuple(rows), self.rows
        if [row.id for row in new] != [row.id for row in old]:
            self.beginResetModel()
            self.rows = new
            self.endResetModel()
            return
        self.rows = new
        for place, (row, former) in enumerate(zip(new, old, strict=True)):
            if row != former:
                last = self.index(place, len(COLUMNS) - 1)
                self.dataChanged.emit(self.index(place, 0), last)

    def refresh(self) -> None:
        """Show everything again, in other units or sizes."""
        if self.rows:
            last = self.index(len(self.rows) - 1, len(COLUMNS) - 1)
            self.dataChanged.emit(self.index(0, 0), last)
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(COLUMNS) - 1)

    def rowCount(self, parent: Index | None = None) -> int:
        """Return the number of maneuvers."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index | None = None) -> int:
        """Return the number of columns."""
        return 0 if parent is not None and parent.isValid() else len(COLUMNS)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return title, unit and hint of a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        column = COLUMNS[section]
        if role == Qt.ItemDataRole.DisplayRole:
            return column.heading(self._look.units)
        if role == Qt.ItemDataRole.ToolTipRole:
            return column.hint or column.title
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if column.right else _LEFT
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return text, check mark, color, type of a cell."""
        row, column = self.rows[index.row()], COLUMNS[index.column()]
        if role == _SORT:
            return column.key(row)
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return column.words(row, self._look.units)
        if role == Qt.ItemDataRole.CheckStateRole and column.id == "use":
            return Qt.CheckState.Checked if row.in_use else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.AccessibleTextRole and column.id == "use":
            return "used in the estimate" if row.in_use else "not used in the estimate"
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if column.right else _LEFT
        if role == Qt.ItemDataRole.FontRole:
            return self._look.font("body", strong=column.id in ("id", "grade"))
        if role == Qt.ItemDataRole.ForegroundRole:
            return self._color(row, column.id)
        if role == Qt.ItemDataRole.ToolTipRole:
            return self._hint(row, column)
        return None

    def _color(self, row: ManeuverRow, column: str) -> QColor | None:
        if column == "grade":
            return self._look.state_color(GRADE_STATES[row.maneuver.grade])
        return None if row.in_use else self._look.color("muted")

    def _hint(self, row: ManeuverRow, column: Column) -> str:
        if column.id == "grade":
            return "; ".join(row.maneuver.reasons) or "nothing to object to"
        return column.hint or column.words(row, self._look.units)

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Return what can be done with a cell."""
        flags = super().flags(index)
        column = COLUMNS[index.column()].id
        if column in TYPED:
            flags |= Qt.ItemFlag.ItemIsEditable
        if column == "use":
            flags |= Qt.ItemFlag.ItemIsUserCheckable
        return flags

    def setData(self, index: Index, value: object, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Hand on what was typed or checked; the row changes when the review has taken it."""
        row, column = self.rows[index.row()], COLUMNS[index.column()].id
        if role == Qt.ItemDataRole.CheckStateRole and column == "use":
            self.used.emit(row.id, not row.in_use)
            return True
        text = str(value).strip()
        if role != Qt.ItemDataRole.EditRole or column not in TYPED:
            return False
        if text != self.data(index):
            (self.renamed if column == "id" else self.noted).emit(row.id, text)
        return True


class _Sorted(QSortFilterProxyModel):
    """Sorts by what a column says, not by its letters."""

    def lessThan(self, left: QModelIndex, right: QModelIndex) -> bool:
        """Compare two cells."""
        return bool(left.data(_SORT) < right.data(_SORT))


class ManeuversTable(QTableView):
    """The table. Space uses a maneuver or not, Enter zooms to it, Delete removes what is chosen.

    Attributes
    ----------
    chosen : Signal(str)
        Id in the campaign that the keyboard is on.
    opened : Signal
        Enter, or a double press.
    deleted : Signal
        Delete.
    """

    chosen = Signal(str)
    opened = Signal()
    deleted = Signal()

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._quiet = False
        self._kept = ""
        self.maneuvers = ManeuversModel(look)
        self._sorted = _Sorted()
        self._sorted.setSourceModel(self.maneuvers)
        self.setModel(self._sorted)
        self.setAccessibleName("Maneuvers")
        self.setShowGrid(False)
        self.setSortingEnabled(True)
        self.sortByColumn(PLACES["id"], Qt.SortOrder.AscendingOrder)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.SelectedClicked)
        self.setTabKeyNavigation(False)
        self.setWordWrap(False)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setMinimumSectionSize(16)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        self.selectionModel().currentChanged.connect(self._moved)
        self.doubleClicked.connect(self._double)
        look.changed.connect(self._resized)
        self._resized()

    def _resized(self) -> None:
        px = self._look.px
        self.verticalHeader().setMinimumSectionSize(px(28))
        self.verticalHeader().setDefaultSectionSize(px(30))
        self.setMinimumHeight(px(_HIGH))
        self.maneuvers.refresh()
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the words the room that is left."""
        super().resizeEvent(event)
        self._fit()

    def sizeHint(self) -> QSize:
        """Return what it would like: a few rows; the rest scrolls."""
        return QSize(self._look.px(320), self._look.px(_HIGH))

    def _fit(self) -> None:
        px = self._look.px
        several = len({row.number for row in self.maneuvers.rows}) > 1
        told = any(row.verdict is not None for row in self.maneuvers.rows)
        self.setColumnHidden(PLACES["flight"], not several)
        self.setColumnHidden(PLACES["told"], not told)
        fixed = 0
        for place, column in enumerate(COLUMNS):
            if column.id not in ("told", "note") and not self.isColumnHidden(place):
                self.setColumnWidth(place, px(column.width))
                fixed += px(column.width)
        room = self.viewport().width() - fixed
        wide = max(px(160), room // 2 if told else room)
        self.setColumnWidth(PLACES["told"], wide)
        self.setColumnWidth(PLACES["note"], max(px(160), room - wide if told else room))

    # Rows

    def show_rows(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; those chosen stay chosen."""
        chosen, current = self.ids, self.current
        self._quiet = True
        self.maneuvers.show(rows)
        self._select([name for name in chosen if name != current], current)
        self._quiet = False
        self._fit()

    def choose(self, campaign_id: str) -> None:
        """Put the keyboard's row on a maneuver."""
        if campaign_id != self.current or campaign_id not in self.ids:
            self._quiet = True
            self._select([], campaign_id)
            self._quiet = False

    def _select(self, others: Sequence[str], current: str) -> None:
        picked = QItemSelection()
        for name in (*others, current):
            index = self._index(name)
            if index.isValid():
                picked.merge(
                    QItemSelection(index, index.siblingAtColumn(len(COLUMNS) - 1)),
                    QItemSelectionModel.SelectionFlag.Select,
                )
        index = self._index(current)
        column = max(self.currentIndex().column(), 0)
        model = self.selectionModel()
        if index.isValid():
            at = index.siblingAtColumn(column)
            model.setCurrentIndex(at, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.scrollTo(at)
        else:
            model.clearCurrentIndex()
        model.select(picked, QItemSelectionModel.SelectionFlag.ClearAndSelect)

    def _index(self, campaign_id: str) -> QModelIndex:
        for place, row in enumerate(self.maneuvers.rows):
            if row.id == campaign_id:
                return self._sorted.mapFromSource(self.maneuvers.index(place, 0))
        return QModelIndex()

    def _row(self, index: Index) -> ManeuverRow:
        return self.maneuvers.rows[self._sorted.mapToSource(index).row()]

    @property
    def current(self) -> str:
        """Return the id in the campaign that the keyboard is on; empty for none."""
        index = self.currentIndex()
        return self._row(index).id if index.isValid() else ""

    @property
    def ids(self) -> tuple[str, ...]:
        """Return the ids in the campaign that are chosen, by flight and time."""
        indices = self.selectionModel().selectedRows()
        rows = sorted((self._row(index) for index in indices), key=COLUMNS[PLACES["id"]].key)
        return tuple(row.id for row in rows)

    def edit_cell(self, campaign_id: str, column: str) -> None:
        """Begin to type a name (``id``) or a ``note``."""
        index = self._index(campaign_id)
        if index.isValid():
            cell = index.siblingAtColumn(PLACES[column])
            self.setFocus()
            self.selectionModel().setCurrentIndex(
                cell,
                QItemSelectionModel.SelectionFlag.ClearAndSelect
                | QItemSelectionModel.SelectionFlag.Rows,
            )
            self.scrollTo(cell)
            self.edit(cell)

    def _moved(self, current: QModelIndex, _former: QModelIndex) -> None:
        if not self._quiet and current.isValid():
            self.chosen.emit(self._row(current).id)

    def _double(self, index: QModelIndex) -> None:
        if COLUMNS[index.column()].id not in (*TYPED, "use"):
            self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Use with Space, zoom with Enter, remove with Delete."""
        key = event.key()
        if self.state() == QAbstractItemView.State.EditingState or not self.current:
            super().keyPressEvent(event)
        elif key == Qt.Key.Key_Space:
            wanted = not self._row(self.currentIndex()).in_use
            for name in self.ids or (self.current,):
                self.maneuvers.used.emit(name, wanted)
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.opened.emit()
        elif key == Qt.Key.Key_Delete:
            self.deleted.emit()
        else:
            super().keyPressEvent(event)
