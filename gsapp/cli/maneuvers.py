"""``gsapp maneuvers``: the maneuvers of a flight, found and graded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, CatalogFile, FlightPath, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.flight import Flight
    from gsapp.flight.maneuvers import DetectedManeuver, FlightManeuvers

_GRADE_COLORS = {"A": "green", "B": "green", "C": "yellow", "D": "red"}
_CARD_COLORS = {"done": "green", "begun": "yellow", "open": "red"}


@takes_settings(MANEUVER_SETTINGS, "aircraft", "as_found", "channel_map", "calibration")
def maneuvers(
    flight: FlightPath,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    aircraft: str | None = None,
    as_found: bool = False,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Find the maneuvers of a flight and grade them.

    What was changed by hand counts.

    Example: gsapp maneuvers flights/2026-05-12-a --json maneuvers.json
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_aircraft_warnings, print_calibration
    from gsapp.cli._usage_errors import check_catalog
    from gsapp.flight.catalog import Catalog, store_maneuvers
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.flight.read_settings import assumed_aircraft_text
    from gsapp.session.graded_maneuvers import find_graded_maneuvers

    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    settings = ManeuverSettings(
        aircraft=aircraft or "",
        as_found=as_found,
        channel_map=channel_map or "",
        calibration=calibration or "",
    )
    with console.status("reading") as status:
        graded = find_graded_maneuvers(flight, settings, doing=status.update)
    loaded, flown, found = graded.flight, graded.aircraft, graded.found
    if catalog is not None:
        with Catalog(catalog) as store:
            store_maneuvers(store, loaded, found.maneuvers, aircraft=flown.name)
    write_json(json, [maneuver.to_json() for maneuver in found.maneuvers])
    print_calibration(console, [loaded])
    if not is_stdout(json):
        print_aircraft_warnings(console, [flown])
        _describe(console, loaded, found)
        if not graded.is_aircraft_known and (
            assumed := assumed_aircraft_text(loaded.name, loaded.info)
        ):
            console.print_sentence(assumed, "yellow")
        print_card_status(console, flight, found.maneuvers)
        for path in (json, catalog):
            if path is not None:
                console.print(f"written to {path}", soft_wrap=True)


def _describe(console: PlainConsole, flight: Flight, found: FlightManeuvers) -> None:
    from rich.text import Text

    from gsapp.flight.maneuvers import (
        GRADED_BY_CREW,
        GRADES,
        explain_no_maneuvers,
        surface_remarks,
        uncalibrated_text,
    )
    from gsapp.quantities import channel, to_si
    from gsapp.quantities.constants import DEGREE

    speed = channel("V").display_unit(DISPLAY_UNITS.get())

    count = len(found.maneuvers)
    numbers = ("start [s]", "end [s]", "size [deg]", f"V [{speed}]", "alpha [deg]")
    table = console.create_table(
        f"{flight.name}: {count} maneuver{'' if count == 1 else 's'}",
        ("id", *numbers[:2], "inputs", "kind", *numbers[2:], "grade"),
        right=numbers,
    )
    for one in found.maneuvers:
        table.add_row(
            one.id,
            f"{one.t_start:z.2f}",
            f"{one.t_end:z.2f}",
            "+".join(one.inputs) or "none",
            one.kind,
            f"{_shown(one.amplitude, 0.01)} %"
            if one.inputs == ("throttle",)
            else _shown(one.amplitude, DEGREE),
            _shown(one.V, to_si(1.0, speed, "speed")),
            _shown(one.alpha, DEGREE),
            Text.assemble(
                (one.grade, _GRADE_COLORS[one.grade]),
                " (manual)" if one.graded_by == GRADED_BY_CREW else "",
            ),
        )
    console.print_unwrapped(table)
    for one in found.maneuvers:
        if one.use is not None:
            text = "used in estimates" if one.use else "left out of estimates"
            console.print(f"{one.id}: {text}, by hand")
        if one.note:
            console.print_sentence(f"{one.id}: {one.note}")
        if one.reasons:
            console.print_sentence(f"{one.id}: {'; '.join(one.reasons)}")
    told = [
        *(f"{grade}: {text}" for grade, text in GRADES.items() if found.maneuvers),
        f"airborne detection by {found.airborne_criterion}; noise from {found.noise.source}",
    ]
    for sentence in told:
        console.print_sentence(sentence, "dim")
    remarks = [*found.remarks, *uncalibrated_text(flight)]
    if not found.maneuvers:
        remarks = [
            f"no maneuver was found: {explain_no_maneuvers(flight)}; name one with --maneuver "
            "START:STOP where "
            "a command takes it",
            *(one for one in found.remarks if one not in surface_remarks(flight)),
        ]
    for sentence in remarks:
        console.print_sentence(sentence, "yellow")


def _shown(value: float | None, unit: float) -> str:
    return "" if value is None else f"{value / unit:z.1f}"


def print_card_status(
    console: PlainConsole, flight: Path, maneuvers: Sequence[DetectedManeuver]
) -> None:
    """Print how the test cards kept with a flight stand; nothing where it has none.

    Raises
    ------
    FileProblemsError
        If the cards hold mistakes.
    """
    from rich.text import Text

    from gsapp.flight.cards import match_cards
    from gsapp.flight.folder import FlightFolder

    cards = FlightFolder(path=flight).cards() if flight.is_dir() else None
    if cards is None:
        return
    flown = match_cards(cards, maneuvers)
    title = f"test cards {cards.name}".rstrip()
    table = console.create_table(title, ("card", "what", "flown", "state"))
    for one in flown.cards:
        table.add_row(
            one.card.id,
            one.card.display_title,
            f"{one.good_count} of {one.card.repeats}",
            Text(one.state, _CARD_COLORS[one.state]),
        )
    console.print_unwrapped(table)
    remarks = [
        f"{one.card.id}: maneuver {attempt.maneuver.id} not counted: {'; '.join(attempt.reasons)}"
        for one in flown.cards
        for attempt in one.attempts
        if not attempt.is_counted
    ]
    if flown.unplanned:
        remarks.append(f"not on a card: {', '.join(one.id for one in flown.unplanned)}")
    for sentence in remarks:
        console.print_sentence(sentence)
