"""What commands print on: words stay as they are.

The library behind it takes words in square brackets for its own marks, and words between colons
for pictures: a flight called ``[x]fl`` lost half of its name.
"""

from __future__ import annotations

from typing import Any

from rich.console import Console, RenderableType
from rich.progress import TextColumn
from rich.status import Status
from rich.text import Text

from gsapp.cli._options import DISPLAY_UNITS


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
        super().__init__(stderr=stderr, markup=False, emoji=False, **options)

    def status(self, status: RenderableType, **options: Any) -> Status:
        """Return a line that says what is being done, for a while."""
        return _PlainStatus(status, console=self, **options)


class _PlainStatus(Status):
    """Such a line; its words, too, are plain."""

    def __init__(self, status: RenderableType, **options: Any) -> None:
        super().__init__(_plain(status), **options)

    def update(self, status: RenderableType | None = None, **options: Any) -> None:
        """Say something else."""
        super().update(None if status is None else _plain(status), **options)


def _plain(words: RenderableType) -> RenderableType:
    return Text(words) if isinstance(words, str) else words


def description_column() -> TextColumn:
    """Return the column of a progress bar that says what is being done."""
    return TextColumn("{task.description}", markup=False)


def print_sentence(console: Console, sentence: str, style: str = "") -> None:
    """Print a sentence in one line, with its values in the units of the call."""
    from gsapp.quantities import convert_text_units

    console.print(
        convert_text_units(sentence, DISPLAY_UNITS.get()),
        style=style,
        highlight=False,
        soft_wrap=True,
    )
