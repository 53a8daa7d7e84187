"""The maneuvers of all flights in one table: sorted, chosen, renamed, noted, used or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import (
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QAction, QFontMetrics, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from gsapp.session.review.review import ManeuverRow
from ui.display_style import DisplayStyle
from ui.review.maneuver_columns import COLUMN_INDEXES, EDITABLE_COLUMNS, MANEUVER_COLUMNS
from ui.review.maneuvers_model import ManeuversModel, ManeuverSortProxy
from ui.widgets.table_menu import TableMenu
from ui.widgets.table_models import ModelIndex, TextEditDelegate

_MIN_HEIGHT = 150
"""Points of height of the head and four rows."""
_PADDING = 20
"""Points beside the letters of a cell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _PendingEdit:
    """What is being typed: the number of the flight, the maneuver's id within it, the field."""

    number: int
    name: str
    column: str
    text: str
    cursor: int


class _CellEditDelegate(TextEditDelegate):
    """Lets people type over the whole of a cell."""

    def updateEditorGeometry(
        self, editor: QWidget, option: QStyleOptionViewItem, _index: ModelIndex
    ) -> None:
        """Lay the field over the cell: the padding of the style would push it out."""
        editor.setGeometry(option.rect)


class ManeuversTable(QTableView):
    """The table. Space uses a maneuver or not, Enter zooms to it, Delete removes what is chosen.

    Parameters
    ----------
    look : DisplayStyle
        Colors and sizes.
    commands : sequence of QAction
        That the menu offers for a maneuver.

    Attributes
    ----------
    maneuver_selected : Signal(str)
        Id in the campaign that the keyboard is on.
    opened : Signal
        Enter, or a double press.
    deleted : Signal
        Delete.
    """

    maneuver_selected = Signal(str)
    opened = Signal()
    deleted = Signal()

    def __init__(self, look: DisplayStyle, commands: Sequence[QAction] = ()) -> None:
        super().__init__()
        self._look = look
        self._quiet = False
        self._kept = ""
        self.maneuvers = ManeuversModel(look)
        self._sorted = ManeuverSortProxy()
        self._sorted.setSourceModel(self.maneuvers)
        self.setModel(self._sorted)
        self.setItemDelegate(_CellEditDelegate(self))
        self.setAccessibleName("Maneuvers")
        self.menu = TableMenu(self, commands)
        self.setShowGrid(False)
        self.setSortingEnabled(True)
        self.sortByColumn(COLUMN_INDEXES["id"], Qt.SortOrder.AscendingOrder)
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
        self.setMinimumHeight(px(_MIN_HEIGHT))
        self.maneuvers.refresh()
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the words the room that is left."""
        super().resizeEvent(event)
        self._fit()

    def sizeHint(self) -> QSize:
        """Return what it would like: a few rows; the rest scrolls."""
        return QSize(self._look.px(320), self._look.px(_MIN_HEIGHT))

    def _fit(self) -> None:
        px = self._look.px
        several = len({row.flight_number for row in self.maneuvers.rows}) > 1
        told = any(row.verdict is not None for row in self.maneuvers.rows)
        self.setColumnHidden(COLUMN_INDEXES["flight"], not several)
        self.setColumnHidden(COLUMN_INDEXES["told"], not told)
        fixed = 0
        for place, column in enumerate(MANEUVER_COLUMNS):
            if column.id not in ("told", "note") and not self.isColumnHidden(place):
                width = self._named() if column.id == "id" else px(column.width)
                self.setColumnWidth(place, width)
                fixed += width
        room = self.viewport().width() - fixed
        wide = max(px(160), room // 2 if told else room)
        self.setColumnWidth(COLUMN_INDEXES["told"], wide)
        self.setColumnWidth(COLUMN_INDEXES["note"], max(px(160), room - wide if told else room))

    # Rows

    def _named(self) -> int:
        """Return the width that the longest name needs, as far as it leaves room for the rest."""
        letters = QFontMetrics(self._look.font("body", strong=True))
        wide = max((letters.horizontalAdvance(row.id) for row in self.maneuvers.rows), default=0)
        least = self._look.px(MANEUVER_COLUMNS[COLUMN_INDEXES["id"]].width)
        most = max(self.viewport().width() // 4, least)
        return min(max(wide + self._look.px(_PADDING), least), most)

    def show_rows(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; those chosen stay chosen, and what is being typed goes on."""
        chosen, current, begun = self.selected_ids, self.current, self._begun()
        self._quiet = True
        self.maneuvers.set_rows(rows)
        self._select([name for name in chosen if name != current], current)
        self._quiet = False
        self._fit()
        if begun is not None and self._field() is None:
            self._go_on(begun)

    def _field(self) -> QLineEdit | None:
        """Return the field that is being typed in."""
        field = self.indexWidget(self.currentIndex())
        editing = self.state() == QAbstractItemView.State.EditingState
        return field if editing and isinstance(field, QLineEdit) else None

    def _begun(self) -> _PendingEdit | None:
        field, index = self._field(), self.currentIndex()
        if field is None or not index.isValid():
            return None
        row = self._row(index)
        return _PendingEdit(
            number=row.flight_number,
            name=row.maneuver.id,
            column=MANEUVER_COLUMNS[index.column()].id,
            text=field.text(),
            cursor=field.cursorPosition(),
        )

    def _go_on(self, begun: _PendingEdit) -> None:
        """Open the field again that the rows took away: its maneuver has another id now.

        With a second flight all ids of the first begin with its number.
        """
        same = (row for row in self.maneuvers.rows
                if (row.flight_number, row.maneuver.id) == (begun.number, begun.name))  # fmt: skip
        row = next(same, None)
        if row is None:
            return
        self._quiet = True
        self.edit_cell(row.id, begun.column)
        self._quiet = False
        field = self._field()
        if field is not None:
            field.selectAll()
            field.insert(begun.text)
            field.setCursorPosition(begun.cursor)

    def select_maneuver(self, campaign_id: str) -> None:
        """Put the keyboard's row on a maneuver."""
        if campaign_id != self.current or campaign_id not in self.selected_ids:
            self._quiet = True
            self._select([], campaign_id)
            self._quiet = False

    def _select(self, others: Sequence[str], current: str) -> None:
        picked = QItemSelection()
        for name in (*others, current):
            index = self._index(name)
            if index.isValid():
                picked.merge(
                    QItemSelection(index, index.siblingAtColumn(len(MANEUVER_COLUMNS) - 1)),
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

    def _row(self, index: ModelIndex) -> ManeuverRow:
        return self.maneuvers.rows[self._sorted.mapToSource(index).row()]

    @property
    def current(self) -> str:
        """Return the id in the campaign that the keyboard is on; empty for none."""
        index = self.currentIndex()
        return self._row(index).id if index.isValid() else ""

    @property
    def selected_ids(self) -> tuple[str, ...]:
        """Return the ids in the campaign that are chosen, by flight and time."""
        indices = self.selectionModel().selectedRows()
        rows = sorted(
            (self._row(index) for index in indices), key=MANEUVER_COLUMNS[COLUMN_INDEXES["id"]].key
        )
        return tuple(row.id for row in rows)

    def edit_cell(self, campaign_id: str, column: str) -> None:
        """Begin to type a name (``id``) or a ``note``."""
        index = self._index(campaign_id)
        if index.isValid():
            cell = index.siblingAtColumn(COLUMN_INDEXES[column])
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
            self.maneuver_selected.emit(self._row(current).id)

    def _double(self, index: QModelIndex) -> None:
        if MANEUVER_COLUMNS[index.column()].id not in (*EDITABLE_COLUMNS, "use"):
            self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Use with Space, zoom with Enter, remove with Delete."""
        key = event.key()
        if self.state() == QAbstractItemView.State.EditingState or not self.current:
            super().keyPressEvent(event)
        elif key == Qt.Key.Key_Space:
            wanted = not self._row(self.currentIndex()).in_use
            for name in self.selected_ids or (self.current,):
                self.maneuvers.used.emit(name, wanted)
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.opened.emit()
        elif key == Qt.Key.Key_Delete:
            self.deleted.emit()
        else:
            super().keyPressEvent(event)
