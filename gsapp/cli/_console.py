"""What commands print on, and where ``--json`` goes: words stay as they are.

The library behind it takes words in square brackets for its own marks, and words between colons
for pictures: a flight called ``[x]fl`` lost half of its name.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rich import box
from rich.console import Console, RenderableType
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.status import Status
from rich.table import Table
from rich.text import Text

from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignProgressCallback, CampaignValue
    from gsapp.identification.maneuver import StatusCallback

WorkResult = TypeVar("WorkResult")

_UNLIMITED_WIDTH = 10_000
MEAN_HEADINGS = ("mean", "std. error", "scatter", "n")
MEAN_LEGEND = (
    "std. error: standard error of the mean; scatter: standard deviation from maneuver to maneuver"
)


class PlainConsole(Console):
    """A console on which no word has a second meaning; colors are those of `StatusText`.

    Parameters
    ----------
    stderr : bool
        Whether it prints there, instead of on the standard output.
    **options
        See `rich.console.Console`.
    """

    def __init__(self, *, stderr: bool = False, **options: Any) -> None:
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False, **options)

    def status(self, status: RenderableType, **options: Any) -> Status:
        return _PlainStatus(status, console=self, **options)

    def progress(self, *columns: ProgressColumn, **options: Any) -> Progress:
        """Return a progress bar after the words that say what is being done."""
        text = TextColumn("{task.description}", markup=False)
        return Progress(text, BarColumn(), *columns, console=self, transient=True, **options)

    def run_with_progress_bar(
        self, work: Callable[[StatusCallback, CampaignProgressCallback], WorkResult]
    ) -> WorkResult:
        """Return what a piece of work gives, showing how far it is.

        Parameters
        ----------
        work : callable
            Takes what it tells before the fits begin, and what it tells of them.
        """
        with self.progress(TimeRemainingColumn()) as bar:
            task = bar.add_task("reading", total=None)

            def doing(text: str) -> None:
                bar.update(task, total=None, description=text)

            def step(done: int, total: int, what: str) -> None:
                bar.update(task, completed=done, total=total, description=what or "done")

            return work(doing, step)

    def print_sentence(self, sentence: str, style: str = "") -> None:
        """Print a sentence in one line, with its values in the units of the call."""
        from gsapp.quantities import convert_text_units

        self.print(convert_text_units(sentence, DISPLAY_UNITS.get()), style=style, soft_wrap=True)

    def create_table(
        self,
        title: str = "",
        columns: Iterable[str] = (),
        right: Collection[str] = (),
        **options: Any,
    ) -> Table:
        """Return a table as all commands print them; columns named in `right` hold numbers."""
        options = {"title_justify": "left", "box": box.SIMPLE_HEAD, "pad_edge": False, **options}
        table = Table(title=title or None, **options)
        for name in columns:
            table.add_column(name, justify="right" if name in right else "left")
        return table

    def print_unwrapped(self, table: Table) -> None:
        """Print a table whose cells stay in one piece, so that what looks for a name finds it.

        Where they do not fit, the columns move together; where that does not suffice, the lines
        are longer than the screen. A column with a ratio takes what is left of the line, and is
        cut; one that folds is prose, and takes more lines.
        """
        for column in table.columns:
            if column.ratio is None and column.overflow != "fold":
                cells = (column.header, *column.cells)
                column.min_width = max(
                    line.cell_len for cell in cells for line in Text(str(cell)).split()
                )
                column.no_wrap = True
        endless = self.options.update(max_width=_UNLIMITED_WIDTH)

        def needed() -> int:
            return Measurement.get(self, endless, table).minimum

        if needed() > self.width:
            table.padding = 0
            table.width = max(self.width, needed())
        self.print(table, crop=False, soft_wrap=True)


class _PlainStatus(Status):
    """A line that says what is being done, for a while; its words, too, are plain."""

    def __init__(self, status: RenderableType, **options: Any) -> None:
        super().__init__(_plain(status), **options)

    def update(self, status: RenderableType | None = None, **options: Any) -> None:
        super().update(None if status is None else _plain(status), **options)


def _plain(words: RenderableType) -> RenderableType:
    return Text(words) if isinstance(words, str) else words


def is_stdout(json: Path | None) -> bool:
    """Return whether the result for programs is to stand alone on the screen."""
    return json is not None and str(json) == "-"


def write_json(json: Path | None, result: object) -> None:
    """Write the result of a command for programs; ``-`` is the screen, None nowhere.

    Raises
    ------
    GroundStationError
        If the file cannot be written.
    """
    from gsapp.foundation import GroundStationError, write_atomically
    from gsapp.foundation.errors import format_os_error
    from gsapp.foundation.files import format_json

    if json is None:
        return
    text = format_json(result)
    if is_stdout(json):
        if sys.stdout is None:
            raise GroundStationError("the standard output is closed; name a file instead of '-'")
        sys.stdout.write(text)
        return
    try:
        write_atomically(json, text)
    except OSError as error:
        raise GroundStationError(
            format_os_error(json, error, "choose a folder with write permission")
        ) from error


def format_value_and_bound(value: float, std: float, least: int = 4) -> tuple[str, str]:
    """Return a value and its bound: never a bound of zero for one that is small.

    Parameters
    ----------
    least : int
        Digits after the point, so that columns of usual values stand in line.
    """
    from gsapp.report.estimate_text import decimals_for_std

    digits = max(least, decimals_for_std(std))
    return f"{value:z.{digits}f}", f"{std:.{digits}f}"


def mean_cells(value: CampaignValue | None) -> list[str]:
    """Return the cells of a mean: value, standard error, scatter and number."""
    if value is None:
        return ["unknown", "", "", ""]
    mean, std = format_value_and_bound(value.mean, value.std)
    scatter = "" if value.scatter is None else format_value_and_bound(value.scatter, value.std)[0]
    return [mean, std, scatter, str(value.n)]
