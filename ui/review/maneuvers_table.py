"""The maneuvers of all flights in one table: sorted, selected, renamed, noted, used or not."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QAction, QFontMetrics, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from gsapp.session.review.review import ManeuverRow
from ui.display_style import DisplayStyle
from ui.review.maneuver_columns import (
    COLUMN_INDEXES,
    EDITABLE_COLUMNS,
    MANEUVER_COLUMNS,
    build_maneuver_table_row,
)
from ui.translation import tr
from ui.widgets.row_model import ModelIndex, TableRowModel
from ui.widgets.table_view import TableRowView

_MIN_HEIGHT = 150
"""Points of height of the head and four rows."""
_PADDING = 20
"""Points beside the letters of a cell."""


class ManeuversTable(TableRowView):
    """Space uses a maneuver or not, Enter zooms to it, Delete removes what is selected."""

    maneuver_selected = Signal(str)
    """Id in the campaign that the keyboard is on."""
    renamed = Signal(str, str)
    noted = Signal(str, str)
    """Id in the campaign, and the new name or note."""
    used = Signal(str, bool)
    """Id in the campaign, and whether it shall take part."""

    def __init__(self, look: DisplayStyle, commands: Sequence[QAction] = ()) -> None:
        self._given: tuple[ManeuverRow, ...] = ()
        places = enumerate(MANEUVER_COLUMNS)
        model = TableRowModel(
            look,
            [column.title for column in MANEUVER_COLUMNS],
            right=frozenset(place for place, column in places if column.is_right_aligned),
            editable=frozenset(COLUMN_INDEXES[name] for name in EDITABLE_COLUMNS),
        )
        super().__init__(model, look, tr("Maneuvers"), wrap=False, row_height=30, commands=commands)
        self.setSortingEnabled(True)
        self.sortByColumn(COLUMN_INDEXES["id"], Qt.SortOrder.AscendingOrder)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.SelectedClicked)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        self.row_changed.connect(lambda _key: self.maneuver_selected.emit(self.current))
        model.edited.connect(self._edited)
        model.checked.connect(lambda key, wanted: self.used.emit(self._campaign_id(key), wanted))

    def _restyle(self) -> None:
        super()._restyle()
        self.setMinimumHeight(self._look.px(_MIN_HEIGHT))
        self.show_rows(self._given)

    def sizeHint(self) -> QSize:
        return QSize(self._look.px(320), self._look.px(_MIN_HEIGHT))

    def _fit_columns(self) -> None:
        px = self._look.px
        several = len({row.flight_number for row in self._given}) > 1
        told = any(row.verdict is not None for row in self._given)
        self.setColumnHidden(COLUMN_INDEXES["flight"], not several)
        self.setColumnHidden(COLUMN_INDEXES["told"], not told)
        fixed = 0
        for place, column in enumerate(MANEUVER_COLUMNS):
            if column.id not in ("told", "note") and not self.isColumnHidden(place):
                width = self._id_width() if column.id == "id" else px(column.width)
                self.setColumnWidth(place, width)
                fixed += width
        room = self.viewport().width() - fixed
        wide = max(px(160), room // 2 if told else room)
        self.setColumnWidth(COLUMN_INDEXES["told"], wide)
        self.setColumnWidth(COLUMN_INDEXES["note"], max(px(160), room - wide if told else room))

    def _id_width(self) -> int:
        """Return the width that the longest id needs, as far as it leaves room for the rest."""
        letters = QFontMetrics(self._look.font("body", strong=True))
        wide = max((letters.horizontalAdvance(row.id) for row in self._given), default=0)
        least = self._look.px(MANEUVER_COLUMNS[COLUMN_INDEXES["id"]].width)
        most = max(self.viewport().width() // 4, least)
        return min(max(wide + self._look.px(_PADDING), least), most)

    # Rows

    def show_rows(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; those selected stay selected, and what is being typed goes on."""
        self._given = tuple(rows)
        units = self._look.units
        details = {place: tr(one.hint or one.title) for place, one in enumerate(MANEUVER_COLUMNS)}
        self._is_quiet = True
        self.row_model.set_titles([one.heading(units) for one in MANEUVER_COLUMNS], details)
        self.row_model.set_rows(build_maneuver_table_row(row, units) for row in rows)
        self._is_quiet = False
        self._fit_columns()

    def select_maneuver(self, campaign_id: str) -> None:
        """Put the keyboard's row on a maneuver; on none if it is not there."""
        if campaign_id == self.current and campaign_id in self.selected_ids:
            return
        self._is_quiet = True
        column = max(self.currentIndex().column(), 0)
        self.clearSelection()
        self.setCurrentIndex(QModelIndex())
        self.select_row(self._key(campaign_id), column)
        self.scrollTo(self.currentIndex())
        self._is_quiet = False

    def _key(self, campaign_id: str) -> object:
        return next((row.key for row in self.row_model.rows if row.value.id == campaign_id), None)

    def _campaign_id(self, key: object) -> str:
        row = self.row_model.find_row(key)
        return self.row_model.rows[row].value.id if row >= 0 else ""

    @property
    def current(self) -> str:
        """Return the id in the campaign that the keyboard is on; empty for none."""
        return self._campaign_id(self.current_key())

    @property
    def selected_ids(self) -> tuple[str, ...]:
        """Return the ids in the campaign that are selected, by flight and time."""
        selected = {index.row() for index in self.selectionModel().selectedRows()}
        chosen = {self.row_model.rows[row].value.id for row in selected}
        return tuple(row.id for row in self._given if row.id in chosen)

    def edit_cell(self, campaign_id: str, column: str) -> None:
        """Begin to type a name (``id``) or a ``note``."""
        self.setFocus()
        self.edit_row(self._key(campaign_id), COLUMN_INDEXES[column])

    def _edited(self, key: object, text: str, column: int) -> None:
        signal = self.renamed if column == COLUMN_INDEXES["id"] else self.noted
        signal.emit(self._campaign_id(key), text)

    def _double_clicked(self, index: ModelIndex) -> None:
        if MANEUVER_COLUMNS[index.column()].id not in (*EDITABLE_COLUMNS, "use"):
            super()._double_clicked(index)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space and self.current and not self.is_editing:
            wanted = not self.row_model.rows[self.currentIndex().row()].value.in_use
            for name in self.selected_ids or (self.current,):
                self.used.emit(name, wanted)
        else:
            super().keyPressEvent(event)
