"""The columns of the table of maneuvers: title, text, and what each is sorted by. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gsapp.quantities import channel
from gsapp.session.review.review import ManeuverRow
from ui.review.maneuvers_words import grade_text, inputs_text
from ui.words import clock_text, unit_text, value_text

_NOWHERE = -1e9
"""Sorts what is not known before everything."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column.

    Attributes
    ----------
    id, title : str
    width : int
        Points.
    key : callable
        What its rows are sorted by.
    text : callable or None
        What stands in a cell; None for a value in the units of the screen.
    quantity : str
        Channel whose unit that value has.
    hint : str
        Tool tip of the title.
    """

    id: str
    title: str
    width: int
    key: Callable[[ManeuverRow], object]
    text: Callable[[ManeuverRow], str] | None = None
    quantity: str = ""
    hint: str = ""

    @property
    def right(self) -> bool:
        """Return whether it holds numbers."""
        return self.text is None or self.id in ("start", "length")

    def heading(self, units: str) -> str:
        """Return the title with the unit."""
        if not self.quantity:
            return self.title
        return f"{self.title} [{unit_text(channel(self.quantity).display_unit(units))}]"

    def words(self, row: ManeuverRow, units: str) -> str:
        """Return what stands in a cell."""
        if self.text is not None:
            return self.text(row)
        value = _VALUES[self.id](row)
        return value_text(channel(self.quantity), value, units, unit=False)


_VALUES: dict[str, Callable[[ManeuverRow], float | None]] = {
    "size": lambda row: row.maneuver.amplitude,
    "V": lambda row: row.maneuver.V,
    "alpha": lambda row: row.maneuver.alpha,
}


def _place(row: ManeuverRow) -> tuple[int, float]:
    return row.number, row.maneuver.t_start


def _known(name: str) -> Callable[[ManeuverRow], object]:
    def key(row: ManeuverRow) -> float:
        value = _VALUES[name](row)
        return _NOWHERE if value is None else value

    return key


def _length(row: ManeuverRow) -> float:
    return row.maneuver.t_end - row.maneuver.t_start


def _told(row: ManeuverRow) -> str:
    return "" if row.verdict is None else row.verdict.advice or row.verdict.result


COLUMNS = (
    Column(
        id="use", title="Use", width=46, key=lambda row: not row.in_use, text=lambda _row: "",
        hint="Takes part in the estimate",
    ),
    Column(
        id="id", title="Id", width=64, key=_place, text=lambda row: row.id,
        hint="Its name, with several flights after the number of its own; press to change it",
    ),
    Column(
        id="flight", title="Flight", width=150, key=_place,
        text=lambda row: f"{row.number} {row.flight}",
    ),
    Column(
        id="start", title="Start", width=78, key=lambda row: row.maneuver.t_start,
        text=lambda row: clock_text(row.maneuver.t_start, decimals=1),
    ),
    Column(
        id="length", title="Length [s]", width=84, key=_length,
        text=lambda row: f"{_length(row):.1f}",
    ),
    Column(
        id="inputs", title="Inputs", width=70, key=lambda row: row.maneuver.inputs,
        text=lambda row: inputs_text(row.maneuver),
    ),
    Column(
        id="kind", title="Kind", width=80, key=lambda row: row.maneuver.kind,
        text=lambda row: row.maneuver.kind,
    ),
    Column(
        id="size", title="Size", width=74, key=_known("size"), quantity="de",
        hint="Half of peak to peak of the main input",
    ),
    Column(
        id="V", title="V", width=78, key=_known("V"), quantity="V",
        hint="True airspeed at the start",
    ),
    Column(
        id="alpha", title="α", width=66, key=_known("alpha"), quantity="alpha",
        hint="Angle of attack at the start",
    ),
    Column(
        id="grade", title="Grade", width=100, key=lambda row: (row.maneuver.grade, *_place(row)),
        text=lambda row: grade_text(row.maneuver),
    ),
    Column(id="told", title="The pilot was told", width=180, key=_told, text=_told),
    Column(
        id="note", title="Note", width=160, key=lambda row: row.maneuver.note,
        text=lambda row: row.maneuver.note, hint="Press to write",
    ),
)  # fmt: skip
"""From left to right."""

PLACES = {column.id: place for place, column in enumerate(COLUMNS)}
"""Where each stands."""

TYPED = ("id", "note")
"""Columns that people write in."""
