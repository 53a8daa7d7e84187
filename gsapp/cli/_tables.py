"""Tables on the screen and in pipes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

_UNLIMITED_WIDTH = 10_000


def print_unwrapped(console: Console, table: Table) -> None:
    """Print a table whose cells stay in one piece, so that what looks for a name finds it.

    Where they do not fit, the columns move together; where that does not suffice, the lines are
    longer than the screen. A column with a ratio takes what is left of the line, and is cut; one
    that folds is prose, and takes more lines.
    """
    from rich.measure import Measurement
    from rich.text import Text

    for column in table.columns:
        if column.ratio is None and column.overflow != "fold":
            cells = (column.header, *column.cells)
            column.min_width = max(
                line.cell_len for cell in cells for line in Text(str(cell)).split()
            )
            column.no_wrap = True
    endless = console.options.update(max_width=_UNLIMITED_WIDTH)

    def needed() -> int:
        return Measurement.get(console, endless, table).minimum

    if needed() > console.width:
        table.padding = 0
        table.width = max(console.width, needed())
    console.print(table, crop=False, soft_wrap=True)
