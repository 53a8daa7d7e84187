"""Doublets flown open loop on the nonlinear simulator, for what is said of inputs beforehand."""

from collections.abc import Mapping
from functools import cache

import numpy as np

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.atmosphere import Atmosphere
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.simulation import ControlCommands, Simulator
from gsapp.dynamics.trim import Trim, trim
from gsapp.excitation.test_points.amplitudes import channel_noise
from gsapp.excitation.test_points.point import TestPoint
from gsapp.flight.maneuvers.input_measures import INPUT_CRITERIA, RESPONSE_CHANNELS
from gsapp.flight.maneuvers.input_shape import smooth_samples
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import FOOT
from gsapp.virtual.flight_plan import INPUT_SHAPES

RATE_OF = {"de": "q", "da": "p", "dr": "r"}
DT = 0.01
HEIGHT = 100.0
BEFORE = 1.0


@cache
def b777() -> tuple[Aircraft, Model]:
    return load_aircraft("b777"), load_model("b777")


def density() -> float:
    return float(Atmosphere().density(HEIGHT))


def point(speed: float) -> TestPoint:
    return TestPoint(
        speed=speed * FOOT, speed_tolerance=1.5, alpha_tolerance=0.03, density=density()
    )


def start(simulator: Simulator, level: Trim) -> dict[str, float]:
    """Begin in steady flight; return the controls that keep it."""
    polar = level.polar
    controls = {
        name: float(value)
        for name, value in level.controls.items()
        if name in ("de", "da", "dr", "flap", "throttle")
    }
    simulator.start_in_air(
        V=float(polar.V),
        alpha=float(polar.alpha),
        beta=float(polar.beta),
        attitude=(float(polar.phi), float(polar.theta), 0.0),
        height=HEIGHT,
        commands=ControlCommands(**controls),
    )
    return controls


def flown(
    speed: float,
    amplitudes: Mapping[str, float],
    width: float,
    *,
    kind: str = "doublet",
    after: float = 1.5,
    model: Model | None = None,
) -> dict[str, FloatArray]:
    """Return the true motion of inputs one after the other, from a second before.

    Parameters
    ----------
    speed : float
        ft/s.
    amplitudes : mapping of str to float
        By surface in the order in which they move, rad; negative ones go the other way first.
    width, after : float
        Of one step, and hands off, s.
    model : Model, optional
        Of the B777 by default.
    """
    aircraft = b777()[0]
    model = model or b777()[1]
    simulator = Simulator(aircraft, model, dt=DT)
    level = trim(FlightModel(aircraft, model), V=speed * FOOT, rho=density())
    controls = start(simulator, level)
    steps = INPUT_SHAPES[kind]
    length = len(steps) * width
    rows = []
    for row in range(round((BEFORE + len(amplitudes) * length + after) / DT)):
        moved = dict(controls)
        for index, (surface, size) in enumerate(amplitudes.items()):
            place = (row * DT - BEFORE - index * length) / width
            if -1e-9 < place < len(steps) - 1e-9:
                moved[surface] += steps[int(place + 1e-9)] * size
        simulator.step(ControlCommands(**moved))
        rows.append(simulator.sample())
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def nearest_limit(motion: Mapping[str, FloatArray]) -> float:
    aircraft, _ = b777()
    limits, sensors = aircraft.limits, aircraft.sensors
    shares = []
    for name, (low, high) in (("alpha", limits.alpha_linear), ("an", limits.load_factor)):
        at = float(motion[name][0])
        shares += [
            (float(motion[name].max()) - at) / (high - at),
            (at - float(motion[name].min())) / (at - low),
        ]
    shares.append(deviation(motion["beta"]) / limits.beta_linear)
    shares += [deviation(motion[name]) / (0.9 * sensors.gyro.range[1]) for name in "pqr"]
    shares.append(deviation(motion["ay"]) / (0.9 * sensors.accelerometer.range[1]))
    return max(shares)


def signal_to_noise(
    motion: Mapping[str, FloatArray], surface: str, width: float
) -> dict[str, float]:
    noise = channel_noise(b777()[0])
    heard = slice(round(BEFORE / DT), round((BEFORE + 2.0 * width + DETECTION.response_time) / DT))
    return {
        name: float(np.ptp(smooth_samples(motion[name][heard], DT))) / noise[name]
        for name in RESPONSE_CHANNELS[surface]
    }


def standing_out(motion: Mapping[str, FloatArray], surface: str, width: float) -> float:
    found = signal_to_noise(motion, surface, width)
    return min(
        found[RATE_OF[surface]] / INPUT_CRITERIA.faint_response,
        max(found.values()) / INPUT_CRITERIA.weak_response,
    )


def deviation(line: FloatArray) -> float:
    return float(np.max(np.abs(line - line[0])))
