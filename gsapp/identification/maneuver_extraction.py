"""Flights made into maneuvers: what estimation and the search for a missing effect begin with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight import Flight, load_flight
from gsapp.flight.flown_aircraft import FlownAircraft, apply_flight_info
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.maneuvers import (
    DetectedManeuver,
    collect_maneuvers,
    explain_no_maneuvers,
    parse_maneuver_windows,
)
from gsapp.flight.maneuvers.flight_maneuvers import FlightManeuvers, ground_window_text
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT, assumed_aircraft_text, find_aircraft
from gsapp.identification.maneuver import Maneuver, cut_maneuver, mass_over_flight
from gsapp.quantities import FloatArray
from gsapp.quantities.fields import Position


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OpenedFlight:
    """A flight that maneuvers can be cut from."""

    flight: Flight
    file_aircraft: Aircraft  # The aircraft by its file.
    as_flown: FlownAircraft  # The aircraft by the flight card.
    mass: FloatArray  # Shape (n,). At every sample, kg.
    assumed_aircraft_text: str = ""
    """Where nobody said which aircraft flew it: which one is taken, in words."""

    @property
    def aircraft(self) -> Aircraft:
        return self.as_flown.aircraft

    @property
    def remarks(self) -> tuple[str, ...]:
        assumed = (self.assumed_aircraft_text,) if self.assumed_aircraft_text else ()
        return (*assumed, *self.flight.remarks, *self.as_flown.remarks)

    def cut(
        self,
        id: str,  # noqa: A002 - the name in the fixed JSON
        t_start: float,
        t_end: float,
        inputs: Sequence[str],
        kind: str,
    ) -> Maneuver:
        """Return the maneuver from t_start to t_end, s; see `cut_maneuver`."""
        cut = cut_maneuver(
            self.flight, self.aircraft, t_start, t_end, id=id, inputs=inputs, kind=kind,
            mass=self.mass,
        )  # fmt: skip
        return correct_for_burned_fuel(cut, self.as_flown)


def open_flight(
    path: Path,
    *,
    aircraft: str | None = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> OpenedFlight:
    """Open a flight with the aircraft that flew it; see `open_flights_with_maneuvers`."""
    flight = load_flight(path, channel_map=channel_map, certificates=calibration, aircraft=aircraft)
    file = find_aircraft(path, aircraft)
    assumed = assumed_aircraft_text(flight.name, flight.info) if file is None else ""
    own = file or load_aircraft(DEFAULT_AIRCRAFT)
    carded = apply_flight_info(own, flight.info)
    return OpenedFlight(
        flight=flight,
        file_aircraft=own,
        as_flown=carded,
        mass=mass_over_flight(flight, carded.aircraft),
        assumed_aircraft_text=assumed,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightWithManeuvers:
    """A flight with its maneuvers."""

    flight: Flight
    file_aircraft: Aircraft  # The aircraft by its file.
    aircraft: Aircraft  # As that flight flew it.
    detected_maneuvers: tuple[DetectedManeuver, ...]  # All of the flight, ids within it.
    maneuvers: tuple[Maneuver, ...]
    """Those to be used; with several flights their ids begin with the flight's number."""
    remarks: tuple[str, ...]
    cg_shift: Position = (0.0, 0.0, 0.0)
    """From the CG of the aircraft file to the one at take-off, m."""
    assumed_aircraft_text: str = ""  # As in `OpenedFlight`; it stands among the remarks, too.
    no_maneuvers_text: str = ""  # Why there is no maneuver to use; empty where there is one.


def open_flights_with_maneuvers(
    paths: Sequence[Path],
    settings: ManeuverSettings | None = None,
    *,
    doing: Callable[[str], object] | None = None,
) -> tuple[FlightWithManeuvers, ...]:
    """Open flights and cut their maneuvers.

    `doing`: told what is being done, in words, before each step.

    Raises
    ------
    GroundStationError
        If a flight or file cannot be read, or a window cannot.
    """
    chosen = settings or ManeuverSettings()
    given, count = chosen.maneuver_windows, len(paths)
    # A window that names no flight of these is told before anything is read.
    windows = parse_maneuver_windows(given, count)
    flown: list[FlightWithManeuvers] = []
    for number, path in enumerate(paths, start=1):
        if doing is not None:
            doing(f"reading {path.name}")
        opened = open_flight(
            path,
            aircraft=chosen.aircraft or None,
            channel_map=chosen.channel_map or None,
            calibration=chosen.calibration or None,
        )
        if doing is not None:
            doing(f"looking for maneuvers in {path.name}")
        surveyed = collect_maneuvers(
            opened.flight, opened.aircraft, given=given, number=number, flights=count,
            as_found=chosen.as_found,
        )  # fmt: skip
        every_grade = chosen.every_grade or any(window.flight == number for window in windows)
        prefix = f"{number}:" if count > 1 else ""
        flown.append(cut_flight_maneuvers(opened, surveyed, prefix=prefix, every_grade=every_grade))
    return tuple(flown)


def cut_flight_maneuvers(
    opened: OpenedFlight, surveyed: FlightManeuvers, *, prefix: str = "", every_grade: bool = False
) -> FlightWithManeuvers:
    """Cut the maneuvers that were found in a flight.

    Parameters
    ----------
    surveyed : FlightManeuvers
        Of that flight.
    prefix : str
        Put before their ids: ``2:`` in the second of several flights.
    every_grade : bool
        Whether those stay in that are graded unfit (D), or that a person left out.
    """
    found = surveyed.maneuvers
    remarks = [*opened.remarks, *surveyed.remarks]
    if not every_grade:
        alone = len(found) == 1
        remarks += [
            f"maneuver {one.id} is not used: {_exclusion_reason(one)}"
            for one in found
            if not one.is_used(alone=alone)
        ]
        found = tuple(one for one in found if one.is_used(alone=alone))
    # Wheels and hands move it there: kinematics would blame instruments, a model its derivatives.
    grounded = [one for one in found if one.id in surveyed.on_ground]
    found = tuple(one for one in found if one not in grounded)
    return FlightWithManeuvers(
        flight=opened.flight,
        file_aircraft=opened.file_aircraft,
        aircraft=opened.aircraft,
        detected_maneuvers=surveyed.maneuvers,
        cg_shift=opened.as_flown.cg_shift,
        maneuvers=tuple(
            opened.cut(prefix + one.id, one.t_start, one.t_end, one.inputs, one.kind)
            for one in found
        ),
        remarks=tuple(remarks),
        assumed_aircraft_text=opened.assumed_aircraft_text,
        no_maneuvers_text="" if found else _why_none(opened.flight, surveyed, grounded),
    )


def _why_none(
    flight: Flight, surveyed: FlightManeuvers, grounded: Sequence[DetectedManeuver]
) -> str:
    if grounded:
        return "; ".join(ground_window_text(one) for one in grounded)
    return explain_no_maneuvers(flight, surveyed.maneuvers)


def no_maneuvers_text(flown: Sequence[FlightWithManeuvers]) -> str:
    """Return why none of some flights gives a maneuver, flight by flight."""
    return "; ".join(f"{one.flight.name}: {one.no_maneuvers_text}" for one in flown)


def _exclusion_reason(maneuver: DetectedManeuver) -> str:
    if maneuver.use is False:
        return "by hand"
    return "; ".join(maneuver.reasons) or "unfit"


def correct_for_burned_fuel(maneuver: Maneuver, carded: FlownAircraft) -> Maneuver:
    """Return a maneuver with the aircraft that was left when it was flown."""
    then = carded.after_fuel_burn(carded.aircraft.mass.mass - maneuver.mass)
    return replace(
        maneuver,
        aircraft=then.aircraft,
        cg_shift=then.cg_shift,
        remarks=(*carded.remarks, *maneuver.remarks),
    )
