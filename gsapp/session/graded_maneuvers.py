"""Maneuvers of a flight, graded as the verdicts of the flight or of its replay allow."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.maneuvers import (
    FlightManeuvers,
    RecordedVerdict,
    apply_verdicts,
    collect_maneuvers,
    read_recorded_verdicts,
)
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT, FlightReadSettings
from gsapp.session.replay_runner import replay_to_end


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradedFlight:
    """A flight with its maneuvers."""

    flight: Flight
    aircraft: Aircraft
    is_aircraft_known: bool  # Else its limits are those of the default aircraft.
    found: FlightManeuvers


def find_graded_maneuvers(
    path: Path, settings: ManeuverSettings, *, doing: Callable[[str], object] = lambda _: None
) -> GradedFlight:
    """Find the maneuvers of a flight and grade them.

    `doing`: told what is being done, in words, before each step.

    Raises `GroundStationError` if the flight or a file cannot be read.
    """
    channel_map, calibration = settings.channel_map or None, settings.calibration or None
    aircraft = settings.aircraft or None
    doing(f"reading {path.name}")
    flight = load_flight(path, channel_map=channel_map, certificates=calibration, aircraft=aircraft)
    own = FlightReadSettings.load(path, aircraft=aircraft).aircraft
    flown = own or load_aircraft(DEFAULT_AIRCRAFT)
    doing("looking for maneuvers")
    found = collect_maneuvers(flight, flown, as_found=settings.as_found)
    if found.maneuvers and not read_recorded_verdicts(flight):
        doing("evaluating inputs")
        with closing(
            replay_to_end(path, aircraft, None, channel_map, calibration, None)
        ) as session:
            watch = session.cue_monitor
            verdicts = [
                RecordedVerdict(
                    t_input=one.t_input, result=one.result, advice=one.advice, grade=one.grade
                )
                for one in (() if watch is None else watch.cueing.verdicts)
            ]
        graded = tuple(apply_verdicts(one, verdicts) for one in found.maneuvers)
        found = replace(found, maneuvers=graded)
    return GradedFlight(
        flight=flight, aircraft=flown, is_aircraft_known=own is not None, found=found
    )
