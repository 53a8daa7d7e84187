"""What a request gave: content, tables and figures."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from gsapp.flight.flight import Flight
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.data_table import DataTable
from gsapp.foundation.files import format_json
from gsapp.foundation.name_suggestions import did_you_mean

if TYPE_CHECKING:
    import pandas

    from gsapp.report.document import DocumentFigure

Outcome = TypeVar("Outcome")
FlightSource = Flight | str | Path
"""An open flight, or the path of one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Result(Generic[Outcome]):
    """What a request gave.

    Jupyter shows ``summary``, ``remarks`` and all ``tables``. Each of ``figures`` shows itself and
    is drawn then; its ``to_figure`` returns a Matplotlib figure.
    """

    summary: str  # One sentence.
    outcome: Outcome  # All of it, as the window and the report use it.
    content: Mapping[str, Any] | Sequence[Any]
    tables: Mapping[str, DataTable]
    figures: Mapping[str, DocumentFigure] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()  # What to know of the result, in sentences.

    def to_dict(self) -> Any:
        """Return what the command writes with ``--json``: SI units, absent = None."""
        return json.loads(format_json(self.content))

    def to_dataframe(self, table: str = "") -> pandas.DataFrame:
        """Return a table as a pandas data frame.

        Parameters
        ----------
        table : str, optional
            One of ``tables``; by default the first. ``attrs["units"]`` holds the units.
        """
        name = table or next(iter(self.tables))
        if name not in self.tables:
            hint = did_you_mean(name, self.tables, f"there are {', '.join(self.tables)}")
            raise UnknownNameError(f"there is no table '{name}'; {hint}")
        return self.tables[name].to_dataframe()

    def __repr__(self) -> str:
        tables = ", ".join(f"{name} ({len(one)})" for name, one in self.tables.items())
        return f"<{self.summary.rstrip('.')}; tables: {tables}; {len(self.figures)} figures>"

    def _repr_html_(self) -> str:
        texts = "".join(f"<p>{escape(text)}</p>" for text in (self.summary, *self.remarks))
        return texts + "".join(one.to_html(name) for name, one in self.tables.items() if len(one))


def request_values(
    flights: FlightSource | Sequence[FlightSource], settings: Mapping[str, Any]
) -> tuple[tuple[Path, ...], dict[str, Any]]:
    """Return the paths of flights, and the settings with what the flights were opened with.

    Raises `FlightError` if flights were opened with different files, which one request cannot.
    """
    sources = (flights,) if isinstance(flights, (Flight, str, Path)) else tuple(flights)
    values = {
        name: str(value) if isinstance(value, Path) else value for name, value in settings.items()
    }
    opened = [one.opened_with if isinstance(one, Flight) else {} for one in sources]
    for name in dict.fromkeys(name for one in opened for name in one):
        given = {one.get(name, "") for one in opened}
        if name not in values and len(given) > 1:
            raise FlightError(
                f"the flights were opened with different values of {name}; give {name} here"
            )
        values.setdefault(name, *given)
    return tuple(one.path if isinstance(one, Flight) else Path(one) for one in sources), values


def table_of(columns: str, rows: Iterable[Sequence[Any]], **units: str) -> DataTable:
    """Return rows as a table; `columns` are names between blanks, `units` those of some of them."""
    found = list(rows)
    names = columns.split()
    return DataTable(
        columns={name: [row[place] for row in found] for place, name in enumerate(names)},
        units=units,
    )


def unit_system(units: str) -> Literal["US", "SI"]:
    """Return a system of units as results use it; raise `UnknownNameError` for any other."""
    match units.upper():
        case "US":
            return "US"
        case "SI":
            return "SI"
    raise UnknownNameError(f"no system of units is called '{units}'; use one of: us, si")
