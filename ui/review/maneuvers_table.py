"""The maneuvers of all flights in one table: sorted, selected, renamed, noted, used or not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QAction, QFontMetrics, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from gsapp.quantities import channel
from gsapp.session.review.review import ManeuverRow
from ui.display_style import DisplayStyle
from ui.number_format import channel_value_text, clock_text, unit_text
from ui.review.maneuver_text import GRADE_STATES, grade_text, surface_symbols_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import CellFormat, ModelIndex, TableRow, TableRowModel
from ui.widgets.table_view import TableRowView

_MISSING_SORT_VALUE = -1e9
"""Sorts what is not known before everything."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverColumn:
    """One column."""

    id: str
    title: str
    width: int
    text: Callable[[ManeuverRow], str] | None = None
    """What stands in a cell; None for a value in the units of the screen."""
    value: Callable[[ManeuverRow], float | None] | None = None
    key: Callable[[ManeuverRow], object] | None = None
    """What its rows are sorted by, if not by text or value."""
    quantity: str = ""
    hint: str = ""

    @property
    def is_right_aligned(self) -> bool:
        return self.text is None or self.id in ("start", "length")

    def heading(self, units: str) -> str:
        if not self.quantity:
            return tr(self.title)
        return f"{tr(self.title)} [{unit_text(channel(self.quantity).display_unit(units))}]"

    def cell_text(self, row: ManeuverRow, units: str) -> str:
        if self.text is not None:
            return self.text(row)
        return channel_value_text(channel(self.quantity), self._value(row), units, unit=False)

    def sort_value(self, row: ManeuverRow) -> object:
        by = self.key or self.text
        if by is not None:
            return by(row)
        value = self._value(row)
        return _MISSING_SORT_VALUE if value is None else value

    def _value(self, row: ManeuverRow) -> float | None:
        return None if self.value is None else self.value(row)


def _flight_order_key(row: ManeuverRow) -> tuple[int, float]:
    return row.flight_number, row.maneuver.t_start


def _maneuver_length(row: ManeuverRow) -> float:
    return row.maneuver.t_end - row.maneuver.t_start


def _pilot_verdict_text(row: ManeuverRow) -> str:
    return "" if row.verdict is None else row.verdict.advice or row.verdict.result


MANEUVER_COLUMNS = (
    ManeuverColumn(
        id="use", title=QT_TR_NOOP("Use"), width=46, key=lambda row: not row.in_use,
        text=lambda _row: "", hint=QT_TR_NOOP("Included in the estimate"),
    ),
    ManeuverColumn(
        id="id", title=QT_TR_NOOP("Id"), width=64, key=_flight_order_key, text=lambda row: row.id,
        hint=QT_TR_NOOP("Name, preceded by the flight number if there are several; click to edit"),
    ),
    ManeuverColumn(
        id="flight", title=QT_TR_NOOP("Flight"), width=150, key=_flight_order_key,
        text=lambda row: f"{row.flight_number} {row.flight}",
    ),
    ManeuverColumn(
        id="start", title=QT_TR_NOOP("Start"), width=78, key=lambda row: row.maneuver.t_start,
        text=lambda row: clock_text(row.maneuver.t_start, decimals=1),
    ),
    ManeuverColumn(
        id="length", title=QT_TR_NOOP("Length [s]"), width=84, key=_maneuver_length,
        text=lambda row: f"{_maneuver_length(row):.1f}",
    ),
    ManeuverColumn(
        id="inputs", title=QT_TR_NOOP("Inputs"), width=70, key=lambda row: row.maneuver.inputs,
        text=lambda row: surface_symbols_text(row.maneuver),
    ),
    ManeuverColumn(
        id="kind", title=QT_TR_NOOP("Kind"), width=80, text=lambda row: row.maneuver.kind,
    ),
    ManeuverColumn(
        id="size", title=QT_TR_NOOP("Size"), width=74, quantity="de",
        value=lambda row: None if row.maneuver.inputs == ("throttle",) else row.maneuver.amplitude,
        hint=QT_TR_NOOP("Half of peak to peak of the main input"),
    ),
    ManeuverColumn(
        id="V", title="V", width=78, value=lambda row: row.maneuver.V, quantity="V",
        hint=QT_TR_NOOP("True airspeed at the start"),
    ),
    ManeuverColumn(
        id="alpha", title="α", width=66, value=lambda row: row.maneuver.alpha, quantity="alpha",
        hint=QT_TR_NOOP("Angle of attack at the start"),
    ),
    ManeuverColumn(
        id="grade", title=QT_TR_NOOP("Grade"), width=100, key=lambda row: (row.maneuver.grade,
        *_flight_order_key(row)),
        text=lambda row: grade_text(row.maneuver),
    ),
    ManeuverColumn(id="told", title=QT_TR_NOOP("Cue to pilot"), width=180,
                   text=_pilot_verdict_text),
    ManeuverColumn(
        id="note", title=QT_TR_NOOP("Note"), width=160,
        text=lambda row: row.maneuver.note, hint=QT_TR_NOOP("Click to edit"),
    ),
)  # fmt: skip
"""From left to right."""

COLUMN_INDEXES = {column.id: place for place, column in enumerate(MANEUVER_COLUMNS)}
"""Where each stands."""

EDITABLE_COLUMNS = ("id", "note")
"""Columns that people write in."""


def build_maneuver_table_row(row: ManeuverRow, units: str) -> TableRow:
    """Return the row of a maneuver; its key is the number of the flight and the id within it."""
    maneuver = row.maneuver
    color = "" if row.in_use else "muted"
    formats = {
        index: CellFormat(color=color, detail=tr(column.hint), is_bold=column.id == "id")
        for index, column in enumerate(MANEUVER_COLUMNS)
    }
    use, name, grade = (COLUMN_INDEXES[column] for column in ("use", "id", "grade"))
    spoken = tr("used in the estimate") if row.in_use else tr("not used in the estimate")
    formats[use] = replace(formats[use], is_checked=row.in_use, accessible_text=spoken)
    # The number of the flight is not to be changed.
    formats[name] = replace(formats[name], edit_text=maneuver.id)
    reasons = "; ".join(maneuver.reasons) or tr("no objection")
    formats[grade] = CellFormat(is_bold=True, detail=reasons)
    return TableRow(
        key=(row.flight_number, maneuver.id),
        cells=tuple(column.cell_text(row, units) for column in MANEUVER_COLUMNS),
        state=GRADE_STATES[maneuver.grade],
        colored=frozenset({grade}),
        sort_values=tuple(column.sort_value(row) for column in MANEUVER_COLUMNS),
        formats=formats,
        value=row,
    )


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
    used = Signal(str, bool)

    def __init__(self, style: DisplayStyle, commands: Sequence[QAction] = ()) -> None:
        self._given: tuple[ManeuverRow, ...] = ()
        places = enumerate(MANEUVER_COLUMNS)
        model = TableRowModel(
            style,
            [column.title for column in MANEUVER_COLUMNS],
            right=frozenset(place for place, column in places if column.is_right_aligned),
            editable=frozenset(COLUMN_INDEXES[name] for name in EDITABLE_COLUMNS),
        )
        super().__init__(
            model, style, tr("Maneuvers"), wrap=False, row_height=30, commands=commands
        )
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
        self.setMinimumHeight(self._style.px(_MIN_HEIGHT))
        self.show_rows(self._given)

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(320), self._style.px(_MIN_HEIGHT))

    def _fit_columns(self) -> None:
        px = self._style.px
        several = len({row.flight_number for row in self._given}) > 1
        told = any(row.verdict is not None for row in self._given)
        self.setColumnHidden(COLUMN_INDEXES["flight"], not several)
        self.setColumnHidden(COLUMN_INDEXES["told"], not told)
        fixed = 0
        for index, column in enumerate(MANEUVER_COLUMNS):
            if column.id not in ("told", "note") and not self.isColumnHidden(index):
                width = self._id_width() if column.id == "id" else px(column.width)
                self.setColumnWidth(index, width)
                fixed += width
        room = self.viewport().width() - fixed
        wide = max(px(160), room // 2 if told else room)
        self.setColumnWidth(COLUMN_INDEXES["told"], wide)
        self.setColumnWidth(COLUMN_INDEXES["note"], max(px(160), room - wide if told else room))

    def _id_width(self) -> int:
        """Return the width that the longest id needs, as far as it leaves room for the rest."""
        letters = QFontMetrics(self._style.font("body", strong=True))
        wide = max((letters.horizontalAdvance(row.id) for row in self._given), default=0)
        least = self._style.px(MANEUVER_COLUMNS[COLUMN_INDEXES["id"]].width)
        most = max(self.viewport().width() // 4, least)
        return min(max(wide + self._style.px(_PADDING), least), most)

    # Rows

    def show_rows(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; those selected stay selected, and what is being typed goes on."""
        self._given = tuple(rows)
        units = self._style.units
        details = {index: tr(one.hint or one.title) for index, one in enumerate(MANEUVER_COLUMNS)}
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
        return self._campaign_id(self.current_key())

    @property
    def selected_ids(self) -> tuple[str, ...]:
        selected = {index.row() for index in self.selectionModel().selectedRows()}
        chosen = {self.row_model.rows[row].value.id for row in selected}
        return tuple(row.id for row in self._given if row.id in chosen)

    def edit_cell(self, campaign_id: str, column: str) -> None:
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
