"""Maneuvers: the samples that estimates are made from, cut from flights."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.aircraft.config import MassProperties
from gsapp.flight import Flight, load_flight
from gsapp.flight.air_data_histories import add_air_data
from gsapp.flight.flown_aircraft import FlownAircraft, apply_flight_info
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.maneuvers import (
    DetectedManeuver,
    collect_maneuvers,
    explain_no_maneuvers,
    parse_maneuver_windows,
)
from gsapp.flight.maneuvers.dead_instruments import (
    clipping_ranges,
    dead_instruments_text,
    find_dead_instruments,
    is_at_range_limit,
)
from gsapp.flight.maneuvers.flight_maneuvers import FlightManeuvers, ground_window_text
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT, assumed_aircraft_text, find_aircraft
from gsapp.flight.uniform_grid import median_step
from gsapp.foundation import FlightError
from gsapp.foundation.executors import WorkerLostError, WorkerPool, map_tasks
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.record_preparation import (
    advance_flags,
    aircraft_as_recorded,
    channel_delays,
    compensate_delays,
    correct_vane_zeros,
    interpolate_air_data,
    interpolate_held_samples,
    reconstruct_deflections,
    unmodeled_servos,
)
from gsapp.quantities import INSTRUMENTS, Block, BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY
from gsapp.quantities.fields import Position

StatusCallback = Callable[[str], object]
"""Told what is being done, in words."""
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Maneuver:
    """One maneuver of one flight."""

    id: str  # Number within its flight; with several flights ``K:number``.
    flight: str  # Name of the flight.
    aircraft: Aircraft  # As that flight flew it.
    block: Block
    """All channels of the flight within the maneuver, on an even grid; as measured, but for what
    the aircraft file says about how late instruments are (`cut_maneuver`)."""
    inputs: tuple[str, ...]  # Surfaces that were moved: of ``de``, ``da``, ``dr``.
    mass: float  # Of the aircraft at that time, kg.
    kind: str = ""  # ``doublet``, ``3-2-1-1``, ...; empty where nobody said.
    clipped: Mapping[str, BoolArray] = field(default_factory=dict)
    """Shape (n,). Samples at the end of an instrument's range, by channel."""
    cg_shift: Position = (0.0, 0.0, 0.0)
    """From the CG of the aircraft file, about which models hold, to the one flown, m."""
    remarks: tuple[str, ...] = ()
    """What its estimate should say of the aircraft: another mass or CG than the file's, instruments
    that were dead."""

    @property
    def t_start(self) -> float:
        """Return the time of the first sample, s of flight time."""
        return float(self.block.times[0])

    @property
    def t_end(self) -> float:
        return float(self.block.times[-1])

    @property
    def dt(self) -> float:
        return median_step(self.block.times)

    def has(self, channel: str) -> bool:
        """Return whether the channel holds any sample here."""
        return channel in self.block and bool(np.isfinite(self.block[channel]).any())

    def samples(self, channel: str) -> FloatArray:
        """Return a channel as measured with clipped samples missing, shape (n,).

        All NaN where the flight has no such channel.
        """
        if channel not in self.block:
            return np.full(len(self.block), np.nan)
        found = self.block[channel]
        clipped = self.clipped.get(channel)
        return found if clipped is None else np.where(clipped, np.nan, found)


def mass_over_flight(flight: Flight, aircraft: Aircraft) -> FloatArray:
    """Return the mass (kg) of the aircraft at every sample of a flight, shape (n,).

    Take-off and landing weight of ``flight.toml`` come first, or the fuel before and after, then
    the flows of the aircraft file with the fuel on board. Between the ends fuel burns as the
    throttle (where measured) asks, from ``fuel_flow_idle`` to ``fuel_flow_full``; else evenly in
    time.

    `aircraft`: as that flight flew it (`gsapp.flight.flown_aircraft`).
    """
    times = flight.block.times
    properties, info = aircraft.mass, flight.info
    start, fuel = takeoff_mass(aircraft, info)
    lost = _fuel_burned(info, start, fuel)
    if times.size < 2:
        return np.full(times.size, start)
    throttle = flight.block["throttle"] if "throttle" in flight.block else np.zeros(times.size)
    full = properties.fuel_flow_full
    flow = np.ones(times.size) if full == 0.0 else fuel_flow(throttle, properties)
    # A pause of the record (the night between two flights) burns nothing.
    steps = np.diff(times)
    steps = np.where(steps > 2.5 * median_step(times), 0.0, steps)
    burned = np.concatenate(([0.0], np.cumsum(0.5 * (flow[1:] + flow[:-1]) * steps)))
    if lost is not None and burned[-1] > 0.0:
        burned *= lost / burned[-1]
    elif full == 0.0:
        return np.full(times.size, start)
    else:
        burned = np.minimum(burned, fuel)
    return np.asarray(start - burned, dtype=np.float64)


def takeoff_mass(aircraft: Aircraft, info: FlightInfo | None) -> tuple[float, float]:
    """Return the mass at take-off and the fuel on board then, kg.

    `aircraft`, `info`: as for `mass_over_flight`.
    """
    mass, fuel = aircraft.mass.mass, aircraft.mass.fuel
    if info is not None and info.takeoff_weight is not None:
        mass = info.takeoff_weight / GRAVITY
    return mass, fuel if info is None or info.fuel is None else info.fuel


def fuel_flow(throttle: FloatArray, properties: MassProperties) -> FloatArray:
    """Return the fuel flow (kg/s) by the throttle (0 to 1), shape (n,); idle where it is NaN."""
    idle, full = properties.fuel_flow_idle, properties.fuel_flow_full
    return idle + (full - idle) * np.clip(np.nan_to_num(throttle), 0.0, 1.0)


def _fuel_burned(info: FlightInfo | None, start: float, fuel: float) -> float | None:
    """Return what the flight card says was burned, kg; None where it says nothing."""
    if info is None:
        return None
    if info.landing_weight is not None:
        return start - info.landing_weight / GRAVITY
    return None if info.fuel_end is None else fuel - info.fuel_end


def clipped_samples(block: Block, aircraft: Aircraft) -> dict[str, BoolArray]:
    """Return, by channel, the samples at the ends of the instrument's range.

    A sample counts as clipped within 1 % of the range's width from either end. Channels without
    such a sample are left out.
    """
    found: dict[str, BoolArray] = {}
    for name, limits in clipping_ranges(aircraft).items():
        if name in block:
            at_end = is_at_range_limit(block[name], limits)
            if at_end.any():
                found[name] = at_end
    return found


def cut_maneuver(
    flight: Flight,
    aircraft: Aircraft,
    t_start: float,
    t_end: float,
    *,
    id: str,  # noqa: A002 - the name in the fixed JSON
    inputs: Sequence[str],
    kind: str = "",
    mass: FloatArray | None = None,
) -> Maneuver:
    """Cut one maneuver from a flight, its channels brought to their right times.

    An attitude slower than the grid is curved between its samples. Surfaces recorded as commands
    are where servo and linkage of the aircraft file put them (`reconstruct_deflections`). Speed,
    dynamic pressure and density are added where they follow from what was measured. Instruments
    that were dead throughout are left out, and `Maneuver.remarks` says so.

    Parameters
    ----------
    aircraft : Aircraft
        As that flight flew it.
    t_start, t_end : float
        Flight time of the first and the last sample, s.
    inputs : sequence of str
        Surfaces that were moved.
    kind : str
        Shape of the input.
    mass : ndarray, shape (n,), optional
        `mass_over_flight`, where several maneuvers are cut from one flight.

    Raises
    ------
    FlightError
        If no sample lies between the two times.
    """
    times = flight.block.times
    low, high = np.searchsorted(times, (t_start - 1e-9, t_end + 1e-9))
    if high - low < 2:
        raise FlightError(
            f"the flight '{flight.name}' holds no samples from {t_start:g} to {t_end:g} s; it "
            f"runs from {times[0]:g} to {times[-1]:g} s"
            if times.size
            else f"the flight '{flight.name}' holds no samples"
        )
    aircraft = aircraft_as_recorded(flight.block, aircraft)
    wide = slice(
        max(0, int(low) - PREPARATION.margin_samples), int(high) + PREPARATION.margin_samples
    )
    around = Block(
        channels=flight.block.channels,
        times=times[wide],
        values=flight.block.values[wide],
    )
    inner = slice(int(low) - wide.start, int(high) - wide.start)
    weather = None if flight.info is None else flight.info.weather
    slow = interpolate_air_data(interpolate_held_samples(around))
    block = reconstruct_deflections(
        add_air_data(compensate_delays(correct_vane_zeros(slow, aircraft), aircraft), weather),
        aircraft,
    )
    block = Block(channels=block.channels, times=block.times[inner], values=block.values[inner])
    late, step = channel_delays(aircraft), median_step(around.times)
    clipped = {
        name: advance_flags(flags, late.get(name, 0.0) / step)[inner]
        for name, flags in clipped_samples(around, aircraft).items()
    }
    masses = mass_over_flight(flight, aircraft) if mass is None else mass
    dead = find_dead_instruments(
        lambda name: block[name] if name in block else np.empty(0), aircraft
    )
    gone = {name for names in dead.values() for name in names}
    # A flight keeps its maneuvers in memory: no estimate reads volts.
    left_out = gone | {f"{name}_volts" for name in INSTRUMENTS}
    block = block.select([name for name in block.channels if name not in left_out])
    return Maneuver(
        id=id,
        flight=flight.name,
        aircraft=aircraft,
        block=block,
        inputs=tuple(inputs),
        mass=float(masses[low:high].mean()),
        kind=kind,
        clipped={
            name: flags for name, flags in clipped.items() if flags.any() and name not in gone
        },
        remarks=(*_servo_text(block, aircraft), *((dead_instruments_text(dead),) if dead else ())),
    )


def _servo_text(block: Block, aircraft: Aircraft) -> tuple[str, ...]:
    names = unmodeled_servos(block, aircraft)
    if not names:
        return ()
    named = ", ".join(names)
    sections = ", ".join(f"[controls.{name}]" for name in names)
    return (
        f"{named}: the recorded signal is the command, and the aircraft file does not describe "
        "the servo; its lag biases damping and control derivatives, by tens of percent on a "
        f"light aircraft: measure it and write lag and delay under {sections}",
    )


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
    own = aircraft_as_recorded(flight.block, file or load_aircraft(DEFAULT_AIRCRAFT))
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
    doing: StatusCallback | None = None,
    pool: WorkerPool | None = None,
    keep_samples: bool = True,
) -> tuple[FlightWithManeuvers, ...]:
    """Open flights and cut their maneuvers.

    Parameters
    ----------
    doing : callable, optional
        Told what is being done, in words, before each step.
    pool : WorkerPool, optional
        Where flights are read, which then are without samples. In this process without it.
    keep_samples : bool
        Whether the flights hold their samples; maneuvers always do.

    Raises
    ------
    GroundStationError
        If a flight or file cannot be read, or a window cannot.
    """
    chosen = settings or ManeuverSettings()
    # A window that names no flight of these is told before anything is read.
    parse_maneuver_windows(chosen.maneuver_windows, len(paths))
    work = partial(
        _open_flight_with_maneuvers,
        tuple(paths),
        chosen,
        keep_samples=keep_samples and pool is None,
        doing=doing if pool is None else None,
    )
    return tuple(map_flights(pool, work, paths, doing))


def _open_flight_with_maneuvers(
    paths: Sequence[Path],
    chosen: ManeuverSettings,
    number: int,
    *,
    keep_samples: bool,
    doing: StatusCallback | None,
) -> FlightWithManeuvers:
    path, count = paths[number - 1], len(paths)
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
        opened.flight, opened.aircraft, given=chosen.maneuver_windows, number=number, flights=count,
        as_found=chosen.as_found,
    )  # fmt: skip
    windows = parse_maneuver_windows(chosen.maneuver_windows, count)
    every_grade = chosen.every_grade or any(window.flight == number for window in windows)
    prefix = f"{number}:" if count > 1 else ""
    found = cut_flight_maneuvers(opened, surveyed, prefix=prefix, every_grade=every_grade)
    return found if keep_samples else replace(found, flight=found.flight.without_samples())


def map_flights(
    pool: WorkerPool | None,
    work: Callable[[int], Result],
    paths: Sequence[Path],
    doing: StatusCallback | None,
) -> Iterator[Result]:
    """Yield what a function gives for the number of each flight, from 1, in their order.

    With a pool it runs there, and `doing` is told what is read.

    Raises `FlightError` if a flight ended two workers of the pool.
    """

    def numbers() -> Iterator[int]:
        for number, path in enumerate(paths, start=1):
            if pool is not None and doing is not None:
                doing(f"reading {path.name}")
            yield number

    for path, found in zip(paths, map_tasks(pool, work, numbers()), strict=True):
        if isinstance(found, WorkerLostError):
            raise FlightError(f"{path} cannot be read: {found}")
        yield found


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
        return "; ".join(ground_window_text(one, stands=True) for one in grounded)
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
