"""A flight in a few lines on the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.flight import Flight


def describe(console: Console, flight: Flight) -> None:
    """Print length, channels with their sources, frames, and what was lost."""
    from rich.markup import escape
    from rich.table import Table

    from gsapp.flight.summary import summarize
    from gsapp.quantities import channel, from_si

    summary = summarize(flight)
    table = Table(title=f"{escape(flight.name)}: {summary['duration']:.1f} s", title_justify="left")
    for heading in ("channel", "unit", "samples", "per s", "min", "max", "gaps", "source"):
        right = heading in ("samples", "per s", "min", "max", "gaps")
        table.add_column(heading, justify="right" if right else "left")
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
        rate = "" if numbers["rate"] is None else f"{numbers['rate']:.4g}"
        source = escape(numbers["source"] or "")
        mark = "" if numbers["measured"] else " (not measured)"
        table.add_row(
            name, unit, str(numbers["count"]), rate, *shown, str(numbers["gaps"]), source + mark
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
