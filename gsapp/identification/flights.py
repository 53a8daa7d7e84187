"""Flights made into maneuvers: what estimation and the search for a missing effect begin with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight import Flight, load_flight
from gsapp.flight.as_flown import AsFlown, as_flown
from gsapp.flight.maneuvers import FoundManeuver, parse_windows, survey
from gsapp.flight.setting import Setting
from gsapp.identification.maneuver import Maneuver, cut_maneuver, mass_over_flight
from gsapp.quantities.fields import Position

_USUAL_AIRCRAFT = "b777"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlownFlight:
    """A flight with its maneuvers.

    Attributes
    ----------
    flight : Flight
    aircraft : Aircraft
        As that flight flew it.
    surveyed : tuple of FoundManeuver
        All of the flight, ids within it.
    maneuvers : tuple of Maneuver
        Those to be used; with several flights their ids begin with the flight's number.
    remarks : tuple of str
    cg_shift : tuple of float
        From the CG of the aircraft file to the one at take-off, m.
    """

    flight: Flight
    aircraft: Aircraft
    surveyed: tuple[FoundManeuver, ...]
    maneuvers: tuple[Maneuver, ...]
    remarks: tuple[str, ...]
    cg_shift: Position = (0.0, 0.0, 0.0)


def flown_flights(
    paths: Sequence[Path],
    *,
    aircraft: str | None,
    channel_map: str | None = None,
    calibration: str | None = None,
    given: Sequence[str] = (),
    every_grade: bool = False,
    doing: Callable[[str], object] | None = None,
) -> tuple[FlownFlight, ...]:
    """Open flights and cut their maneuvers.

    Parameters
    ----------
    paths : sequence of Path
    aircraft : str or None
        Name or path; None takes the copy in each flight folder, else ``b777``.
    channel_map : str, optional
    calibration : str, optional
        Certificates in place of those kept with the flights: a folder, or a shipped set.
    given : sequence of str
        ``START:STOP`` or ``K:START:STOP`` in place of what would be found.
    every_grade : bool
        Whether maneuvers graded unfit (D) stay in.
    doing : callable, optional
        Told what is being done, in words, before each step.

    Raises
    ------
    GroundStationError
        If a flight or file cannot be read, or a window cannot.
    """
    count = len(paths)
    # A window that names no flight of these is told before anything is read.
    windows = parse_windows(given, count)
    flown: list[FlownFlight] = []
    for number, path in enumerate(paths, start=1):
        if doing is not None:
            doing(f"reading {path.name}")
        flight = load_flight(
            path, channel_map=channel_map, certificates=calibration, aircraft=aircraft
        )
        file = Setting.find(path, aircraft=aircraft).aircraft or load_aircraft(_USUAL_AIRCRAFT)
        carded = as_flown(file, flight.info)
        own = carded.aircraft
        if doing is not None:
            doing(f"looking for maneuvers in {path.name}")
        surveyed = survey(flight, own, given=given, number=number, flights=count)
        remarks = [*flight.remarks, *carded.remarks, *surveyed.remarks]
        found = surveyed.maneuvers
        named = any(window.flight == number for window in windows)
        # The only one there is stays in: what it cannot give is said by its estimate.
        if not named and not every_grade and len(found) > 1:
            remarks += [
                f"maneuver {one.id} is left out: {'; '.join(one.reasons) or 'unfit'}"
                for one in found
                if one.grade == "D"
            ]
            found = tuple(one for one in found if one.grade != "D")
        prefix = f"{number}:" if count > 1 else ""
        mass = mass_over_flight(flight, own)
        cut = [
            cut_maneuver(
                flight,
                own,
                one.t_start,
                one.t_end,
                id=prefix + one.id,
                inputs=one.inputs,
                kind=one.kind,
                mass=mass,
            )
            for one in found
        ]
        flown.append(
            FlownFlight(
                flight=flight,
                aircraft=own,
                surveyed=surveyed.maneuvers,
                cg_shift=carded.shift,
                maneuvers=tuple(with_fuel_left(one, carded) for one in cut),
                remarks=tuple(remarks),
            )
        )
    return tuple(flown)


def with_fuel_left(maneuver: Maneuver, carded: AsFlown) -> Maneuver:
    """Return a maneuver with the aircraft that was left when it was flown."""
    then = carded.after(carded.aircraft.mass.mass - maneuver.mass)
    return replace(
        maneuver,
        aircraft=then.aircraft,
        cg_shift=then.shift,
        remarks=(*carded.remarks, *maneuver.remarks),
    )
