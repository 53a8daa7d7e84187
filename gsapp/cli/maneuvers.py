"""``gsapp maneuvers``: the maneuvers of a flight, found and graded."""

from __future__ import annotations

import json as json_module
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.cli._options import UNITS
from gsapp.cli._screen import say

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
    from gsapp.cli._aircraft_text import warn_of_aircraft
    from gsapp.cli._cards_text import describe_cards
    from gsapp.cli._flight_text import check_catalog, tell_calibration
    from gsapp.cli._results import on_screen, write_result
    from gsapp.cli._screen import Screen
    from gsapp.cli.debrief import replayed
    from gsapp.flight.catalog import Catalog, store_maneuvers
    from gsapp.flight.loading import load_flight
    from gsapp.flight.maneuvers import recorded_verdicts, survey
    from gsapp.flight.setting import USUAL_AIRCRAFT, Setting, assumed_words

    console = Screen(stderr=on_screen(json))
    check_catalog(catalog, calibration)
    with console.status(f"reading {flight.name}"):
        loaded = load_flight(
            flight, channel_map=channel_map, certificates=calibration, aircraft=aircraft
        )
        own = Setting.find(flight, aircraft=aircraft).aircraft
        flown = own or load_aircraft(USUAL_AIRCRAFT)
    with console.status("looking for maneuvers"):
        found = survey(loaded, flown, as_found=as_found)
    if found.maneuvers and not recorded_verdicts(loaded):
        with (
            console.status("judging inputs"),
            closing(replayed(flight, aircraft, None, channel_map, calibration, None)) as session,
        ):
            found = _judged(found, session)
    if catalog is not None:
        with Catalog(catalog) as store:
            store_maneuvers(store, loaded, found.maneuvers, aircraft=flown.name)
    if json is not None:
        content = [maneuver.to_json() for maneuver in found.maneuvers]
        text = json_module.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
        write_result(json, text + "\n")
    tell_calibration(console, [loaded])
    if not on_screen(json):
        warn_of_aircraft(console, [flown])
        _describe(console, loaded, found)
        if own is None and (assumed := assumed_words(loaded.name, loaded.info)):
            say(console, assumed, "yellow")
        describe_cards(console, flight, found.maneuvers)
        for path in (json, catalog):
            if path is not None:
                console.print(f"written to {path}", highlight=False, soft_wrap=True)


def _judged(found: FlightManeuvers, session: Session) -> FlightManeuvers:
    """Return the maneuvers graded as the verdicts of a replay allow."""
    from dataclasses import replace

    from gsapp.flight.maneuvers import RecordedVerdict, after_verdicts

    watch = session.cue_watch
    verdicts = [
        RecordedVerdict(t_input=one.t_input, result=one.result, advice=one.advice, grade=one.grade)
        for one in (() if watch is None else watch.cueing.verdicts)
    ]
    return replace(found, maneuvers=tuple(after_verdicts(one, verdicts) for one in found.maneuvers))


def _describe(console: Console, flight: Flight, found: FlightManeuvers) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from gsapp.cli._tables import print_whole
    from gsapp.flight.maneuvers import (
        CREW,
        GRADES,
        surface_remarks,
        uncalibrated_words,
        why_none,
    )
    from gsapp.quantities import channel, to_si
    from gsapp.quantities.constants import DEGREE

    speed = channel("V").display_unit(UNITS.get())

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
                (one.grade, _COLORS[one.grade]), " by hand" if one.graded_by == CREW else ""
            ),
        )
    print_whole(console, table)
    for one in found.maneuvers:
        if one.use is not None:
            words = "used in estimates" if one.use else "left out of estimates"
            console.print(f"{one.id}: {words}, by hand", highlight=False)
        if one.note:
            say(console, f"{one.id}: {one.note}")
        if one.reasons:
            say(console, f"{one.id}: {'; '.join(one.reasons)}")
    told = [
        *(f"{grade}: {words}" for grade, words in GRADES.items() if found.maneuvers),
        f"flying is judged by {found.judged_by}; noise from {found.noise.source}",
    ]
    for sentence in told:
        say(console, sentence, "dim")
    remarks = [*found.remarks, *uncalibrated_words(flight)]
    if not found.maneuvers:
        remarks = [
            f"no maneuver was found: {why_none(flight)}; name one with --maneuver START:STOP where "
            "a command takes it",
            *(one for one in found.remarks if one not in surface_remarks(flight)),
        ]
    for sentence in remarks:
        say(console, sentence, "yellow")


def _shown(value: float | None, unit: float) -> str:
    return "" if value is None else f"{value / unit:z.1f}"
