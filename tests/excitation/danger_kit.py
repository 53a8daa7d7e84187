"""Virtual flights, their records with instruments that fail, and what is said of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.reading import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.dynamics.pilot.airframe import TRUTH
from gsapp.dynamics.pilot.converter import DAQ, Converter
from gsapp.dynamics.pilot.faults import Failing, parse_fault
from gsapp.dynamics.pilot.flight import (
    FlightUnderWay,
    HandsMaker,
    Stretch,
    with_combined_surfaces,
)
from gsapp.dynamics.pilot.keyed import KeyedPilot
from gsapp.dynamics.pilot.plan import load_plan
from gsapp.excitation.dangers.watch import DangerWatch
from gsapp.excitation.rows import rows_of
from gsapp.quantities import Block, FloatArray

RATE = 100.0
TICK = 5
BARE = frozenset(("attitude", "position"))

Harm = Callable[["Flown", dict[str, FloatArray]], None]
"""Changes what the instruments show: channel -> samples, SI."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Flown:
    """A flight that was flown: what happened, what the converter read, what the board knew."""

    times: FloatArray
    truth: FloatArray
    volts: FloatArray
    board: FloatArray
    board_names: tuple[str, ...]
    phases: tuple[str, ...]

    def true(self, name: str) -> FloatArray:
        """Return a channel of the truth."""
        return self.truth[:, TRUTH.index(name)]

    def known(self, name: str) -> FloatArray:
        """Return what the board knew."""
        return self.board[:, self.board_names.index(name)]


def fly_whole(seed: int, gusts: float, plan: str = "default") -> Flown:
    """Fly a plan from engine start to engine stop."""
    flight = FlightUnderWay(
        load_plan(plan), aircraft=load_aircraft("b777"), seed=seed, turbulence=gusts
    )
    stretches = []
    while not flight.finished:
        stretches.append(flight.advance(1000))
    return _flown(stretches)


def fly_pattern(seed: int, gusts: float, seconds: float) -> Flown:
    """Fly the pattern from the air on, turns and legs, without a maneuver."""

    def make(plan, feel, random, dt):  # type: ignore[no-untyped-def]
        return KeyedPilot(plan, feel, random, dt, airborne=True)

    hands: HandsMaker = make
    flight = FlightUnderWay(
        load_plan("default"),
        aircraft=load_aircraft("b777"),
        seed=seed,
        turbulence=gusts,
        hands=hands,
        airborne=True,
    )
    return _flown([flight.advance(round(seconds * RATE))])


def _flown(stretches: Sequence[Stretch]) -> Flown:
    return Flown(
        times=np.concatenate([stretch.times for stretch in stretches]),
        truth=np.concatenate([stretch.truth for stretch in stretches]),
        volts=np.concatenate([stretch.volts for stretch in stretches]),
        board=np.concatenate([stretch.board for stretch in stretches]),
        board_names=stretches[0].board_names,
        phases=tuple(phase for stretch in stretches for phase in stretch.phases),
    )


_CONVERTER: list[Converter] = []


def record(
    flown: Flown,
    *,
    faults: Sequence[str] = (),
    harm: Harm | None = None,
    without: frozenset[str] = frozenset(),
) -> Block:
    """Return what the ground gets: the converter's volts through the certificates, and the board.

    Parameters
    ----------
    flown : Flown
    faults : sequence of str
        ``CHANNEL:KIND[:PARAM=VALUE,..]``, as the virtual aircraft has them.
    harm : callable, optional
        Other harm, to what the instruments show.
    without : frozenset of str
        ``attitude``, ``position``: what the board does not send.
    """
    if not _CONVERTER:
        _CONVERTER.append(Converter(load_certificates("b777")))
    converter = _CONVERTER[0]
    values = converter.measured(flown.volts)
    if faults or harm is not None:
        values = {name: samples.copy() for name, samples in values.items()}
        for number, text in enumerate(faults):
            failing = Failing(parse_fault(text), 1.0 / RATE, np.random.default_rng(number))
            name = failing.fault.channel
            values[name] = failing.act(values[name], 0)
        if harm is not None:
            harm(flown, values)
        values = converter.measured(converter.volts(values))
    columns = {name: values[name] for name in DAQ} | {"rc_rssi": flown.known("rc_rssi")}
    if "attitude" not in without:
        columns |= {name: flown.known(name) for name in ("phi", "theta", "psi")}
        columns |= {f"{name}.2": flown.known(name) for name in "pqr"}
    if "position" not in without:
        columns |= {
            name: flown.known(name)
            for name in ("latitude", "longitude", "height", "ground_speed", "climb_rate")
        }
        north, east = flown.known("velocity_north"), flown.known("velocity_east")
        columns["track"] = np.arctan2(east, north)
    return with_combined_surfaces(
        Block(
            channels=tuple(columns),
            times=flown.times,
            values=np.column_stack(list(columns.values())),
        )
    )


def watched(block: Block, *, cuts: Sequence[int] = (), known: bool = True) -> DangerWatch:
    """Return a watch that has seen a record, cut at these ticks, or tick by tick without any."""
    watch = DangerWatch(load_aircraft("b777") if known else None, RATE)
    rows = rows_of(block, RATE)
    edges = [TICK * cut for cut in cuts] if cuts else range(TICK, len(rows), TICK)
    start = 0
    for edge in (*edges, len(rows)):
        watch.take(rows.part(start, edge))
        start = edge
    return watch


def stuck_with_noise(name: str, at: float, noise: float, seed: int = 0) -> Harm:
    """Return the harm of a moving part that sticks, while its pick-off has noise as ever."""

    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        held = values[name][np.flatnonzero(after)[0]]
        random = np.random.default_rng(seed)
        values[name][after] = held + noise * random.standard_normal(int(after.sum()))

    return harm


def dead_gyro(name: str, at: float, seed: int = 0) -> Harm:
    """Return the harm of a gyro whose wheel stands: no rate, a little noise."""

    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        random = np.random.default_rng(seed)
        values[name][after] = math.radians(0.3) * random.standard_normal(int(after.sum()))

    return harm


def blocked_pitot(at: float, seed: int = 0) -> Harm:
    """Return the harm of a tube that holds its pressure: what is shown follows the height."""

    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        static = flown.true("static_pressure")
        first = np.flatnonzero(after)[0]
        held = values["dynamic_pressure"][first] + static[first]
        noise = np.random.default_rng(seed).standard_normal(int(after.sum()))
        values["dynamic_pressure"][after] = held - static[after] + noise

    return harm


def several(*harms: Harm) -> Harm:
    """Return all of these together."""

    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        for one in harms:
            one(flown, values)

    return harm
