"""The columns of the table of maneuvers: title, text, and what each is sorted by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from gsapp.quantities import channel
from gsapp.session.review.review import ManeuverRow
from ui.number_format import channel_value_text, clock_text, unit_text
from ui.review.maneuver_text import GRADE_STATES, grade_text, surface_symbols_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import CellFormat, TableRow

_MISSING_SORT_VALUE = -1e9
"""Sorts what is not known before everything."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverColumn:
    """One column."""

    id: str
    title: str
    width: int
    """Points."""
    key: Callable[[ManeuverRow], object]
    """What its rows are sorted by."""
    text: Callable[[ManeuverRow], str] | None = None
    """What stands in a cell; None for a value in the units of the screen."""
    quantity: str = ""
    hint: str = ""
    """Tool tip of the title."""

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
        value = _COLUMN_VALUES[self.id](row)
        return channel_value_text(channel(self.quantity), value, units, unit=False)


_COLUMN_VALUES: dict[str, Callable[[ManeuverRow], float | None]] = {
    "size": lambda row: row.maneuver.amplitude,
    "V": lambda row: row.maneuver.V,
    "alpha": lambda row: row.maneuver.alpha,
}


def _flight_order_key(row: ManeuverRow) -> tuple[int, float]:
    return row.flight_number, row.maneuver.t_start


def _numeric_sort_key(name: str) -> Callable[[ManeuverRow], object]:
    def key(row: ManeuverRow) -> float:
        value = _COLUMN_VALUES[name](row)
        return _MISSING_SORT_VALUE if value is None else value

    return key


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
        id="kind", title=QT_TR_NOOP("Kind"), width=80, key=lambda row: row.maneuver.kind,
        text=lambda row: row.maneuver.kind,
    ),
    ManeuverColumn(
        id="size", title=QT_TR_NOOP("Size"), width=74, key=_numeric_sort_key("size"), quantity="de",
        hint=QT_TR_NOOP("Half of peak to peak of the main input"),
    ),
    ManeuverColumn(
        id="V", title="V", width=78, key=_numeric_sort_key("V"), quantity="V",
        hint=QT_TR_NOOP("True airspeed at the start"),
    ),
    ManeuverColumn(
        id="alpha", title="α", width=66, key=_numeric_sort_key("alpha"), quantity="alpha",
        hint=QT_TR_NOOP("Angle of attack at the start"),
    ),
    ManeuverColumn(
        id="grade", title=QT_TR_NOOP("Grade"), width=100, key=lambda row: (row.maneuver.grade,
        *_flight_order_key(row)),
        text=lambda row: grade_text(row.maneuver),
    ),
    ManeuverColumn(id="told", title=QT_TR_NOOP("Cue to pilot"), width=180, key=_pilot_verdict_text,
    text=_pilot_verdict_text),
    ManeuverColumn(
        id="note", title=QT_TR_NOOP("Note"), width=160, key=lambda row: row.maneuver.note,
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
        place: CellFormat(color=color, detail=tr(column.hint), is_bold=column.id == "id")
        for place, column in enumerate(MANEUVER_COLUMNS)
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
        sort_values=tuple(column.key(row) for column in MANEUVER_COLUMNS),
        formats=formats,
        value=row,
    )
