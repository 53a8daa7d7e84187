"""Tables of results for pandas and for Jupyter, and what only notebooks need installed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

from gsapp.foundation.errors import GroundStationError

if TYPE_CHECKING:
    import pandas

_SHOWN_ROWS = 40


class MissingPackageError(GroundStationError, ImportError):
    """A package that is installed on request only is missing."""


def import_notebook_package(name: str) -> Any:
    """Return pandas or xarray, which the extra `notebook` installs.

    Raises `MissingPackageError` where it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingPackageError(
            f"{name} is not installed; install it with 'python3 packaging/bootstrap.py setup "
            "notebook' in the folder of the clone, or with 'pip install "
            "gsapp-ground-station[notebook]'"
        ) from error


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DataTable:
    """Columns of equal length."""

    columns: Mapping[str, Any]  # Sequences.
    units: Mapping[str, str] = field(default_factory=dict)  # Of columns that have one.
    index: str = ""  # The column that becomes the index of a data frame.

    def __len__(self) -> int:
        return max(map(len, self.columns.values()), default=0)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a data frame; ``attrs["units"]`` holds the unit of each column that has one."""
        frame = import_notebook_package("pandas").DataFrame(dict(self.columns))
        frame = frame.set_index(self.index) if self.index else frame
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_html(self, caption: str, most: int | None = _SHOWN_ROWS) -> str:
        """Return the first rows as HTML, or all (`most` None); headings with units."""
        rows = list(zip(*self.columns.values(), strict=True))
        heads = (
            f"{name} [{self.units[name]}]" if self.units.get(name) else name
            for name in self.columns
        )
        body = "".join(_row("td", map(_cell_text, row)) for row in rows[:most])
        more = (
            "" if most is None or len(rows) <= most else f", the first {most} of {len(rows)} rows"
        )
        return (
            f"<table><caption>{escape(caption + more)}</caption><thead>{_row('th', heads)}</thead>"
            f"<tbody>{body}</tbody></table>"
        )


def _row(tag: str, cells: Any) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _cell_text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" if isinstance(value, float) else str(value)
