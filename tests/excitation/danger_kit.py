"""Virtual flights, their records with instruments that fail, and what is said of them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.certificate_toml import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.excitation.alerts.alert_monitor import AlertMonitor
from gsapp.excitation.flight_rows import rows_from_block
from gsapp.quantities import Block, FloatArray
from gsapp.virtual.airframe import TRUTH_CHANNELS
from gsapp.virtual.flight_plan import load_flight_plan
from gsapp.virtual.instruments import (
    DAQ_CHANNELS,
    AnalogDigitalConverter,
    SensorFaultInjector,
    parse_sensor_fault,
)
from gsapp.virtual.keyboard_pilot import KeyboardPilot
from gsapp.virtual.virtual_flight import (
    FlightSegment,
    FlightSimulation,
    StickSourceFactory,
    combine_surfaces,
)

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
        return self.truth[:, TRUTH_CHANNELS.index(name)]

    def known(self, name: str) -> FloatArray:
        return self.board[:, self.board_names.index(name)]


def fly_whole(seed: int, gusts: float, plan: str = "default") -> Flown:
    flight = FlightSimulation(
        load_flight_plan(plan), aircraft=load_aircraft("b777"), seed=seed, turbulence=gusts
    )
    stretches = []
    while not flight.finished:
        stretches.append(flight.advance(1000))
    return _flown(stretches)


def fly_pattern(seed: int, gusts: float, seconds: float) -> Flown:
    def make(plan, feel, random, dt):  # type: ignore[no-untyped-def]
        return KeyboardPilot(plan, feel, random, dt, airborne=True)

    hands: StickSourceFactory = make
    flight = FlightSimulation(
        load_flight_plan("default"),
        aircraft=load_aircraft("b777"),
        seed=seed,
        turbulence=gusts,
        hands=hands,
        airborne=True,
    )
    return _flown([flight.advance(round(seconds * RATE))])


def _flown(stretches: Sequence[FlightSegment]) -> Flown:
    return Flown(
        times=np.concatenate([stretch.times for stretch in stretches]),
        truth=np.concatenate([stretch.truth for stretch in stretches]),
        volts=np.concatenate([stretch.volts for stretch in stretches]),
        board=np.concatenate([stretch.onboard for stretch in stretches]),
        board_names=stretches[0].onboard_names,
        phases=tuple(phase for stretch in stretches for phase in stretch.phases),
    )


_CONVERTER: list[AnalogDigitalConverter] = []


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
        _CONVERTER.append(AnalogDigitalConverter(load_certificates("b777")))
    converter = _CONVERTER[0]
    values = converter.convert_volts(flown.volts)
    if faults or harm is not None:
        values = {name: samples.copy() for name, samples in values.items()}
        for index, text in enumerate(faults):
            failing = SensorFaultInjector(
                parse_sensor_fault(text), 1.0 / RATE, np.random.default_rng(index)
            )
            name = failing.fault.channel
            values[name] = failing.apply(values[name], 0)
        if harm is not None:
            harm(flown, values)
        values = converter.convert_volts(converter.volts(values))
    columns = {name: values[name] for name in DAQ_CHANNELS} | {"rc_rssi": flown.known("rc_rssi")}
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
    return combine_surfaces(
        Block(
            channels=tuple(columns),
            times=flown.times,
            values=np.column_stack(list(columns.values())),
        )
    )


def watched(block: Block, *, cuts: Sequence[int] = (), known: bool = True) -> AlertMonitor:
    watch = AlertMonitor(load_aircraft("b777") if known else None, RATE)
    rows = rows_from_block(block, RATE)
    edges = [TICK * cut for cut in cuts] if cuts else range(TICK, len(rows), TICK)
    start = 0
    for edge in (*edges, len(rows)):
        watch.process_rows(rows.slice_rows(start, edge))
        start = edge
    return watch


def stuck_with_noise(name: str, at: float, noise: float, seed: int = 0) -> Harm:
    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        held = values[name][np.flatnonzero(after)[0]]
        random = np.random.default_rng(seed)
        values[name][after] = held + noise * random.standard_normal(int(after.sum()))

    return harm


def dead_gyro(name: str, at: float, seed: int = 0) -> Harm:
    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        random = np.random.default_rng(seed)
        values[name][after] = math.radians(0.3) * random.standard_normal(int(after.sum()))

    return harm


def blocked_pitot(at: float, seed: int = 0) -> Harm:
    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        after = flown.times >= at
        static = flown.true("static_pressure")
        first = np.flatnonzero(after)[0]
        held = values["dynamic_pressure"][first] + static[first]
        noise = np.random.default_rng(seed).standard_normal(int(after.sum()))
        values["dynamic_pressure"][after] = held - static[after] + noise

    return harm


def several(*harms: Harm) -> Harm:
    def harm(flown: Flown, values: dict[str, FloatArray]) -> None:
        for one in harms:
            one(flown, values)

    return harm
