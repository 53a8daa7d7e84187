"""A flight in a few lines on the screen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from gsapp.aircraft import Aircraft
    from gsapp.cli._console import PlainConsole
    from gsapp.decoding.pipeline import ChannelSource
    from gsapp.flight.flight import Flight
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.identification.maneuver import FlightWithManeuvers

_MARKS = {"estimated": "est.", "derived": "calc."}
_UNCALIBRATED = "uncal"
_WIDE = 100
_MOST_NOTICES = 20


def print_flight(console: PlainConsole, flight: Flight) -> None:
    """Print length, channels with their sources, frames, and what was lost."""
    from gsapp.decoding.decoder import NOTICE_KINDS
    from gsapp.flight.summary import summarize_flight
    from gsapp.quantities import channel, from_si

    summary = summarize_flight(flight)
    rate = f", {flight.rate:z.4g} per s" if math.isfinite(flight.rate) else ""
    table = console.create_table(
        title=f"{flight.name}: {summary['duration']:z.1f} s{rate}",
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
    console.print_unwrapped(table)
    frames = flight.frames
    if frames is not None:
        console.print(
            f"frames: {frames.good} good, {frames.damaged} damaged, {frames.unknown} unknown, "
            f"{frames.lost} lost"
        )
        if frames.lines or frames.bad_lines:
            console.print(f"lines: {frames.lines} good, {frames.bad_lines} excluded")
    noticed = [event for event in flight.events if event.kind in NOTICE_KINDS]
    remarks = [
        *flight.remarks,
        *(_at(event.time) + event.text for event in noticed[:_MOST_NOTICES]),
    ]
    for sentence in remarks:
        console.print_sentence(sentence, "yellow")
    if len(noticed) > _MOST_NOTICES:
        console.print(f"and {len(noticed) - _MOST_NOTICES} more like these", style="yellow")


def print_flights(console: PlainConsole, flights: Sequence[Flight], remarks: Sequence[str]) -> None:
    """Print a line for each of several flights, and what was lost."""
    table = console.create_table(title=f"{len(flights)} flights", padding=(0, 1, 0, 0))
    for heading in ("flight", "s", "Hz", "channels"):
        table.add_column(heading, justify="right" if heading in ("s", "Hz") else "left")
    for flight in flights:
        rate = f"{flight.rate:z.4g}" if math.isfinite(flight.rate) else ""
        channels = ", ".join(flight.block.channels)
        table.add_row(flight.name, f"{flight.duration:z.1f}", rate, channels)
    console.print(table)
    told = [f"{flight.name}: {text}" for flight in flights for text in flight.remarks]
    for sentence in (*remarks, *told):
        console.print_sentence(sentence, "yellow")


def _mark(source: ChannelSource) -> str:
    return _UNCALIBRATED if source.uncalibrated_channel else _MARKS.get(source.kind, "")


def print_calibration(console: PlainConsole, flights: Iterable[Flight]) -> None:
    """Say of each flight which channels are uncalibrated, and whose certificates were used."""
    from gsapp.flight.flight import calibration_sentences

    for sentence in calibration_sentences(flights):
        console.print_sentence(sentence, "yellow")


def _at(time: float | None) -> str:
    return "" if time is None else f"{time:z.2f} s: "


def print_aircraft_warnings(console: PlainConsole, aircraft: Iterable[Aircraft | None]) -> None:
    """Print a line for each possible but suspicious value of the user's own aircraft files.

    Parameters
    ----------
    aircraft : iterable of Aircraft or None
        As their files say; one that comes twice is warned about once.
    """
    from gsapp.aircraft import file_warnings

    sentences = [
        f"{one.name}: {sentence}"
        for one in aircraft
        if one is not None
        for sentence in file_warnings(one)
    ]
    for sentence in dict.fromkeys(sentences):
        console.print_sentence(sentence, "yellow")


def load_flown_flights(
    paths: Sequence[Path], settings: ManeuverSettings, console: PlainConsole
) -> tuple[FlightWithManeuvers, ...]:
    """Open flights and cut their maneuvers, telling a console what is being done."""
    from gsapp.identification import maneuver

    with console.status("reading") as status:
        return maneuver.open_flights_with_maneuvers(paths, settings, doing=status.update)
