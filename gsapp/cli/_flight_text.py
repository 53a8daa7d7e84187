"""A flight in a few lines on the screen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from rich.console import Console

    from gsapp.decoding.pipeline import ChannelSource
    from gsapp.flight.flight import Flight


_MARKS = {"estimated": "est.", "derived": "calc."}
_UNCALIBRATED = "uncal"
"""Beside what was not measured."""

_WIDE = 100
_MOST_NOTICES = 20


def print_flight(console: Console, flight: Flight) -> None:
    """Print length, channels with their sources, frames, and what was lost."""
    from rich import box
    from rich.table import Table

    from gsapp.cli._tables import print_unwrapped
    from gsapp.decoding.decoder import NOTICE_KINDS
    from gsapp.flight.summary import summarize_flight
    from gsapp.quantities import channel, from_si

    summary = summarize_flight(flight)
    rate = f", {flight.rate:z.4g} per s" if math.isfinite(flight.rate) else ""
    table = Table(
        title=f"{flight.name}: {summary['duration']:z.1f} s{rate}",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
        expand=True,
    )
    wide = console.width >= _WIDE
    # A narrow line has no room for the mean and the source; both stand in the JSON.
    figures = ("min", "max", "mean") if wide else ("min", "max")
    for heading in ("channel", "unit", "count", "Hz", *figures, "gaps", ""):
        right = heading not in ("channel", "unit", "")
        table.add_column(heading, justify="right" if right else "left")
    if wide:
        # The source takes what is left of the line.
        table.add_column("source", no_wrap=True, overflow="ellipsis", ratio=1)
    for name, numbers in summary["channels"].items():
        spec = channel(name)
        unit = spec.display_unit(DISPLAY_UNITS.get())
        digits = spec.decimals(unit)
        shown = [
            ""
            if numbers[key] is None
            else f"{from_si(float(numbers[key]), unit, spec.quantity):z.{digits}f}"
            for key in figures
        ]
        source = flight.sources.get(name)
        table.add_row(
            name,
            unit,
            str(numbers["count"]),
            "" if numbers["rate"] is None else f"{numbers['rate']:z.4g}",
            *shown,
            str(numbers["gaps"]),
            _mark(source) if source else "",
            *([source.source if source else ""] if wide else []),
        )
    print_unwrapped(console, table)
    frames = flight.frames
    if frames is not None:
        console.print(
            f"frames: {frames.good} good, {frames.damaged} damaged, {frames.unknown} unknown, "
            f"{frames.lost} lost",
            highlight=False,
        )
        if frames.lines or frames.bad_lines:
            console.print(
                f"lines: {frames.lines} good, {frames.bad_lines} excluded", highlight=False
            )
    noticed = [event for event in flight.events if event.kind in NOTICE_KINDS]
    told = [
        *flight.remarks,
        *(_at(event.time) + event.text for event in noticed[:_MOST_NOTICES]),
    ]
    for sentence in told:
        print_sentence(console, sentence, "yellow")
    if len(noticed) > _MOST_NOTICES:
        console.print(f"and {len(noticed) - _MOST_NOTICES} more like these", style="yellow")


def _mark(source: ChannelSource) -> str:
    return _UNCALIBRATED if source.uncalibrated_channel else _MARKS.get(source.kind, "")


def print_calibration(console: Console, flights: Iterable[Flight]) -> None:
    """Say of each flight which channels are uncalibrated, and whose certificates were used."""
    for sentence in calibration_sentences(flights):
        print_sentence(console, sentence, "yellow")


def calibration_sentences(flights: Iterable[Flight]) -> tuple[str, ...]:
    """Return what is to be said of the calibration of each flight, with its name."""
    return tuple(
        f"{flight.name}: {words}" for flight in flights for words in flight.calibration_remarks
    )


def calibration_json(flights: Iterable[Flight]) -> list[dict[str, Any]]:
    """Return the calibration behind each flight's numbers, for programs."""
    return [{"flight": flight.name, **flight.calibration_json()} for flight in flights]


def check_catalog(catalog: Path | None, calibration: str | None) -> None:
    """Raise `CommandUsageError` where results with other certificates would go into a catalog.

    A catalog keeps one set of maneuvers and estimates of a flight: those of its own certificates.
    """
    from gsapp.cli._usage_errors import CommandUsageError

    if catalog is not None and calibration is not None:
        raise CommandUsageError(
            f"{catalog} stores results with the certificates of the flights; omit --catalog or "
            "--calibration"
        )


def check_is_catalog(catalog: Path, remedy: str) -> None:
    """Raise `FlightError` where no catalog stands; what to do about it ends the sentence."""
    from gsapp.foundation import FlightError

    if catalog.is_dir():
        raise FlightError(f"{catalog} is a folder; name the file of a catalog")
    if not catalog.is_file():
        raise FlightError(f"there is no catalog {catalog}; {remedy}")


def _at(time: float | None) -> str:
    return "" if time is None else f"{time:z.2f} s: "
