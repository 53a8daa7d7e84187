"""A flight in a few lines on the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.flight import Flight


_MARKS = {"estimated": "est.", "derived": "calc."}
"""Beside what was not measured."""

_WIDE = 100


def describe(console: Console, flight: Flight) -> None:
    """Print length, channels with their sources, frames, and what was lost."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    from gsapp.flight.summary import summarize
    from gsapp.quantities import channel, from_si

    summary = summarize(flight)
    table = Table(
        title=f"{escape(flight.name)}: {summary['duration']:.1f} s, {flight.rate:.4g} per s",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
        expand=True,
    )
    for heading in ("channel", "unit", "samples", "min", "max", "gaps", ""):
        right = heading in ("samples", "min", "max", "gaps")
        table.add_column(heading, justify="right" if right else "left", no_wrap=True)
    wide = console.width >= _WIDE
    # The source takes what is left of a wide line.
    table.add_column("source" if wide else "", no_wrap=True, overflow="ellipsis", ratio=1)
    for name, numbers in summary["channels"].items():
        spec = channel(name)
        unit = spec.us_display
        digits = spec.decimals(unit)
        shown = [
            ""
            if numbers[key] is None
            else f"{from_si(float(numbers[key]), unit, spec.quantity):.{digits}f}"
            for key in ("min", "max")
        ]
        source = flight.sources.get(name)
        table.add_row(
            name,
            unit,
            str(numbers["count"]),
            *shown,
            str(numbers["gaps"]),
            _MARKS.get(source.kind, "") if source else "",
            escape(source.source) if source and wide else "",
        )
    console.print(table)
    frames = flight.frames
    if frames is not None:
        console.print(
            f"frames: {frames.good} good, {frames.damaged} damaged, {frames.unknown} unknown, "
            f"{frames.lost} lost",
            highlight=False,
        )
    for remark in flight.remarks:
        console.print(remark, style="yellow", highlight=False, markup=False)
