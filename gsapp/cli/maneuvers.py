"""``gsapp maneuvers``: the maneuvers of a flight, found and graded."""

from __future__ import annotations

import json as json_module
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.flight import Flight
    from gsapp.flight.maneuvers import FlightManeuvers
    from gsapp.session import Session

_COLORS = {"A": "green", "B": "green", "C": "yellow", "D": "red"}


def run(
    *,
    flight: Path,
    aircraft: str | None = None,
    channel_map: str | None = None,
    calibration: str | None = None,
    as_found: bool = False,
    json: Path | None = None,
    catalog: Path | None = None,
) -> None:
    """Find the maneuvers of a flight and print them, changes by hand included.

    Parameters
    ----------
    flight : Path
        Folder or file.
    aircraft : str, optional
        Name or path; by default that in the flight folder, else ``b777``.
    channel_map : str, optional
        Name or path.
    calibration : str, optional
        Certificates in place of those kept with the flight: a folder, or a shipped set.
    as_found : bool
        Whether to leave out what was changed by hand.
    json : Path, optional
        Where to write the list for programs; ``-`` for the screen.
    catalog : Path, optional
        A catalog to store the flight and its maneuvers in; made if it does not exist.

    Raises
    ------
    GroundStationError
        If the flight cannot be read, has no surface, or a file cannot be written.
    """
    from gsapp.aircraft import load_aircraft
    from gsapp.cli._aircraft_text import print_aircraft_warnings
    from gsapp.cli._cards_text import print_card_status
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flight_text import check_catalog, print_calibration
    from gsapp.cli._json_output import is_stdout, write_json
    from gsapp.cli.debrief import replay_to_end
    from gsapp.flight.catalog import Catalog, store_maneuvers
    from gsapp.flight.flight_loader import load_flight
    from gsapp.flight.maneuvers import collect_maneuvers, read_recorded_verdicts
    from gsapp.flight.read_settings import (
        DEFAULT_AIRCRAFT,
        FlightReadSettings,
        assumed_aircraft_text,
    )

    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    with console.status(f"reading {flight.name}"):
        loaded = load_flight(
            flight, channel_map=channel_map, certificates=calibration, aircraft=aircraft
        )
        own = FlightReadSettings.load(flight, aircraft=aircraft).aircraft
        flown = own or load_aircraft(DEFAULT_AIRCRAFT)
    with console.status("looking for maneuvers"):
        found = collect_maneuvers(loaded, flown, as_found=as_found)
    if found.maneuvers and not read_recorded_verdicts(loaded):
        with (
            console.status("evaluating inputs"),
            closing(
                replay_to_end(flight, aircraft, None, channel_map, calibration, None)
            ) as session,
        ):
            found = _graded(found, session)
    if catalog is not None:
        with Catalog(catalog) as store:
            store_maneuvers(store, loaded, found.maneuvers, aircraft=flown.name)
    if json is not None:
        content = [maneuver.to_json() for maneuver in found.maneuvers]
        text = json_module.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
        write_json(json, text + "\n")
    print_calibration(console, [loaded])
    if not is_stdout(json):
        print_aircraft_warnings(console, [flown])
        _describe(console, loaded, found)
        if own is None and (assumed := assumed_aircraft_text(loaded.name, loaded.info)):
            print_sentence(console, assumed, "yellow")
        print_card_status(console, flight, found.maneuvers)
        for path in (json, catalog):
            if path is not None:
                console.print(f"written to {path}", highlight=False, soft_wrap=True)


def _graded(found: FlightManeuvers, session: Session) -> FlightManeuvers:
    """Return the maneuvers graded as the verdicts of a replay allow."""
    from dataclasses import replace

    from gsapp.flight.maneuvers import RecordedVerdict, apply_verdicts

    watch = session.cue_monitor
    verdicts = [
        RecordedVerdict(t_input=one.t_input, result=one.result, advice=one.advice, grade=one.grade)
        for one in (() if watch is None else watch.cueing.verdicts)
    ]
    return replace(found, maneuvers=tuple(apply_verdicts(one, verdicts) for one in found.maneuvers))


def _describe(console: Console, flight: Flight, found: FlightManeuvers) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from gsapp.cli._tables import print_unwrapped
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
    table = Table(
        title=f"{flight.name}: {count} maneuver{'' if count == 1 else 's'}",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    for heading in ("id", "start [s]", "end [s]", "inputs", "kind", "size [deg]", f"V [{speed}]"):
        right = heading.endswith("]")
        table.add_column(heading, justify="right" if right else "left")
    table.add_column("alpha [deg]", justify="right")
    table.add_column("grade")
    for one in found.maneuvers:
        table.add_row(
            one.id,
            f"{one.t_start:z.2f}",
            f"{one.t_end:z.2f}",
            "+".join(one.inputs) or "none",
            one.kind,
            _shown(one.amplitude, DEGREE),
            _shown(one.V, to_si(1.0, speed, "speed")),
            _shown(one.alpha, DEGREE),
            Text.assemble(
                (one.grade, _COLORS[one.grade]),
                " (manual)" if one.graded_by == GRADED_BY_CREW else "",
            ),
        )
    print_unwrapped(console, table)
    for one in found.maneuvers:
        if one.use is not None:
            words = "used in estimates" if one.use else "left out of estimates"
            console.print(f"{one.id}: {words}, by hand", highlight=False)
        if one.note:
            print_sentence(console, f"{one.id}: {one.note}")
        if one.reasons:
            print_sentence(console, f"{one.id}: {'; '.join(one.reasons)}")
    told = [
        *(f"{grade}: {words}" for grade, words in GRADES.items() if found.maneuvers),
        f"airborne detection by {found.airborne_criterion}; noise from {found.noise.source}",
    ]
    for sentence in told:
        print_sentence(console, sentence, "dim")
    remarks = [*found.remarks, *uncalibrated_text(flight)]
    if not found.maneuvers:
        remarks = [
            f"no maneuver was found: {explain_no_maneuvers(flight)}; name one with --maneuver "
            "START:STOP where "
            "a command takes it",
            *(one for one in found.remarks if one not in surface_remarks(flight)),
        ]
    for sentence in remarks:
        print_sentence(console, sentence, "yellow")


def _shown(value: float | None, unit: float) -> str:
    return "" if value is None else f"{value / unit:z.1f}"
