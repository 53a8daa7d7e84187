"""Maneuvers of the virtual aircraft with known derivatives, made directly and cheaply.

The truth is integrated in body axes with a quaternion (`gsapp.dynamics.simulation.Simulator`), so
by other equations than those that estimators integrate. The instruments sit where the aircraft
file says; each shows its exposure plus noise (white, or colored by a first-order recursion),
through a 12-bit converter.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.atmosphere import DrydenTurbulence
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.sensors import (
    accelerations_at,
    alpha_vane,
    beta_vane,
    pitot_airspeed,
    velocity_at,
)
from gsapp.dynamics.simulation import ControlCommands, Simulator
from gsapp.dynamics.trim import trim
from gsapp.identification.axes import Axis, axis_derivatives
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY
from tests.dynamics.histories import run_simulation

NOISE: Mapping[str, float] = {
    "alpha": 0.1 * DEGREE,
    "beta": 0.1 * DEGREE,
    "p": 1.0 * DEGREE,
    "q": 1.0 * DEGREE,
    "r": 1.0 * DEGREE,
    "ax": 0.005 * GRAVITY,
    "ay": 0.005 * GRAVITY,
    "an": 0.005 * GRAVITY,
    "V": 0.1,
    "phi": 0.2 * DEGREE,
    "theta": 0.2 * DEGREE,
    "de": 0.05 * DEGREE,
    "da": 0.05 * DEGREE,
    "dr": 0.05 * DEGREE,
}
"""Standard deviation of each sample (notes, section 2), SI."""
STEPS: Mapping[str, float] = {
    "alpha": 60.0 * DEGREE / 4096,
    "beta": 60.0 * DEGREE / 4096,
    **dict.fromkeys("pqr", 180.0 * DEGREE / 3277),
    **dict.fromkeys(("ax", "ay", "an"), 5.0 / 4096 / 0.51 * GRAVITY),
    **dict.fromkeys(("de", "da", "dr"), 60.0 * DEGREE / 4096),
    "V": 0.02,
}
"""One count of the 12-bit converter, SI."""
COLORED = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an")
BIASED = ("an", "ay")
AXES: Mapping[str, Axis] = {"lon": "lon", "lat": "lat", "both": "both"}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Virtual:
    maneuver: Maneuver
    truth: Mapping[str, float]
    motion: Mapping[str, FloatArray]


def varied_model(random: np.random.Generator, share: float = 0.15) -> Model:
    base = load_model("b777")
    changed = {
        name: value * (1.0 + share * float(random.uniform(-1.0, 1.0)))
        for name, value in base.derivatives.items()
    }
    return base.with_derivatives(changed)


def pulses(times: FloatArray, start: float, widths: tuple[float, ...]) -> FloatArray:
    edges = start + np.concatenate(([0.0], np.cumsum(widths)))
    out = np.zeros_like(times)
    for index in range(len(widths)):
        inside = (times >= edges[index]) & (times < edges[index + 1])
        out[inside] = 1.0 if index % 2 == 0 else -1.0
    return out


def commands_for(
    kind: str, times: FloatArray, random: np.random.Generator
) -> dict[str, FloatArray]:
    """Return deflections (rad) about trim: ``lon`` an elevator, ``lat`` a combined maneuver.

    A doublet and a 3-2-1-1 take turns; amplitude, timing and direction are a pilot's.
    """
    zero = np.zeros_like(times)
    vary = random.uniform
    sign = float(random.choice((-1.0, 1.0)))
    start = float(vary(0.8, 1.4))
    out = {"de": zero, "da": zero, "dr": zero}

    def doublet(amplitude: float, width: float, begin: float) -> FloatArray:
        skew = float(vary(0.85, 1.15))
        return sign * amplitude * pulses(times, begin, (width, width * skew))

    if kind in ("lon", "both"):
        amplitude = float(vary(2.5, 5.0)) * DEGREE
        if random.random() < 0.5:
            width = float(vary(0.3, 0.5))
            out["de"] = doublet(amplitude, width, start) + doublet(amplitude, width, start + 3.5)
        else:
            unit = float(vary(0.25, 0.4))
            out["de"] = sign * amplitude * pulses(times, start, (3 * unit, 2 * unit, unit, unit))
    if kind in ("lat", "both"):
        width = float(vary(0.4, 0.7))
        rudder, aileron = float(vary(5.0, 10.0)) * DEGREE, float(vary(2.5, 5.0)) * DEGREE
        out["dr"] = doublet(rudder, width, start)
        out["da"] = doublet(aileron, 0.6 * width, start + 2.2 * width + float(vary(0.2, 1.0)))
        out["da"] = out["da"] - doublet(aileron, 0.6 * width, start + 4.2)
    hands = lfilter([0.02], [1.0, -0.98], random.standard_normal((3, times.size)), axis=1)
    for name, small in zip(out, hands, strict=True):
        out[name] = out[name] + 0.4 * DEGREE * small
    return out


def fly(
    seed: int,
    kind: str = "lon",
    *,
    color: float = 0.0,
    duration: float = 10.0,
    dt: float = 0.01,
    gust: float = 0.0,
    noise: float = 1.0,
    model: Model | None = None,
    aircraft: Aircraft | None = None,
    attitude: bool = True,
    still: Sequence[str] = (),
    rotating: bool = False,
) -> Virtual:
    """Fly one maneuver.

    Parameters
    ----------
    seed : int
    kind : {"lon", "lat", "both"}
    color : float
        Coefficient of the recursion that colors the noise; 0 is white. Its size stays.
    duration, dt : float
        s.
    gust : float
        Standard deviation of Dryden gusts, m/s.
    noise : float
        Scales all of `NOISE`; zero leaves the converter out too.
    model : Model, optional
        The truth; the shipped one, varied, by default.
    attitude : bool
        Whether phi and theta are measured.
    still : sequence of str
        Surfaces that are not touched at all.
    rotating : bool
        Whether gusts also turn the air (MIL-F-8785C).
    """
    flown = _flown if model is None and aircraft is None else _flown.__wrapped__
    plane, truth, motion, state = flown(
        seed, kind, duration, dt, gust, tuple(still), model, aircraft, rotating
    )
    random = np.random.default_rng(seed)
    random.bit_generator.state = state
    measured = _measured(plane, motion, random, color, noise)
    if not attitude:
        del measured["phi"], measured["theta"]
    block = Block(
        channels=tuple(measured), times=motion["time"], values=np.column_stack([*measured.values()])
    )
    inputs = {"lon": ("de",), "lat": ("da", "dr"), "both": ("de", "da", "dr")}[kind]
    inputs = tuple(name for name in inputs if name not in still)
    maneuver = Maneuver(
        id=str(seed),
        flight="virtual",
        aircraft=plane,
        block=block,
        inputs=inputs,
        mass=float(motion["mass"].mean()),
        kind="doublet",
    )
    known = {name: truth.derivative(name) for name in axis_derivatives(AXES[kind])}
    return Virtual(maneuver=maneuver, truth=known, motion=motion)


@lru_cache(maxsize=64)
def _flown(
    seed: int,
    kind: str,
    duration: float,
    dt: float,
    gust: float,
    still: tuple[str, ...],
    model: Model | None,
    aircraft: Aircraft | None,
    rotating: bool,
) -> tuple[Aircraft, Model, dict[str, FloatArray], dict[str, object]]:
    """Return the motion that `fly` measures, and where its random numbers go on.

    Flying takes 0.3 s, and tests fly the same maneuvers with other noise.
    """
    random = np.random.default_rng(seed)
    plane = aircraft or load_aircraft("b777")
    truth = model or varied_model(random)
    start = trim(FlightModel(plane, truth), V=float(random.uniform(27.0, 34.0)))
    controls, polar = start.controls, start.polar
    simulator = Simulator(
        plane,
        truth,
        turbulence=DrydenTurbulence(gust, seed=seed, span=plane.geometry.span if rotating else None)
        if gust
        else None,
        dt=dt,
        stall=False,
    )
    resting = {name: controls[name] for name in ("de", "da", "dr", "throttle")}
    simulator.start_in_air(
        V=float(polar.V),
        alpha=float(polar.alpha),
        beta=float(polar.beta),
        attitude=(float(polar.phi), float(polar.theta), 0.0),
        commands=ControlCommands(**resting),
    )
    times = dt * np.arange(round(duration / dt))
    histories = commands_for(kind, times, random)
    histories.update({name: np.zeros_like(times) for name in still})
    motion = run_simulation(
        simulator, {name: history + resting[name] for name, history in histories.items()}
    )
    return plane, truth, motion, dict(random.bit_generator.state)


def _measured(
    aircraft: Aircraft,
    motion: Mapping[str, FloatArray],
    random: np.random.Generator,
    color: float,
    noise: float,
) -> dict[str, FloatArray]:
    sensors = aircraft.sensors
    flow = (motion["u"], motion["v"], motion["w"])
    rates = (motion["p"], motion["q"], motion["r"])
    turned = tuple(motion[name] - motion[f"gust_{name}"] for name in "pqr")
    spin = (motion["p_dot"], motion["q_dot"], motion["r_dot"])
    force = (motion["ax"], motion["ay"], motion["an"])
    ax, ay, an = accelerations_at(sensors.accelerometer.position, force, rates, spin)
    exposed = {
        "V": pitot_airspeed(velocity_at(sensors.air_data.position, flow, turned)),
        "alpha": alpha_vane(velocity_at(sensors.alpha_vane.position, flow, turned)),
        "beta": beta_vane(velocity_at(sensors.beta_vane.position, flow, turned)),
        **dict(zip(("p", "q", "r"), rates, strict=True)),
        "ax": ax,
        "ay": ay,
        "an": an,
        **{name: motion[name] for name in ("phi", "theta", "de", "da", "dr")},
    }
    count = len(motion["time"])
    shown = {}
    for name, values in exposed.items():
        error = random.standard_normal(count + 200)
        if color and name in COLORED:
            error = lfilter([math.sqrt(1.0 - color * color)], [1.0, -color], error)
        bias = 0.02 * GRAVITY * random.standard_normal() if name in BIASED else 0.0
        found = values + noise * (NOISE[name] * error[200:] + bias)
        step = STEPS.get(name, 0.0) if noise else 0.0
        shown[name] = np.round(found / step) * step if step else found
    for name in ("density", "static_pressure", "temperature", "throttle"):
        shown[name] = motion[name]
    return shown


def every_tenth_sample(maneuver: Maneuver) -> Maneuver:
    block = maneuver.block
    slow = Block(channels=block.channels, times=block.times[::10], values=block.values[::10])
    return replace(maneuver, block=slow)


def edited(maneuver, **changes):
    """Return a maneuver with channels changed: new samples, or a function of the old ones."""
    values = np.array(maneuver.block.values)
    for name, change in changes.items():
        column = maneuver.block.channels.index(name)
        values[:, column] = change(values[:, column].copy()) if callable(change) else change
    block = Block(channels=maneuver.block.channels, times=maneuver.block.times, values=values)
    return replace(maneuver, block=block)


def without(maneuver: Maneuver, *names: str) -> Maneuver:
    kept = [name for name in maneuver.block.channels if name not in names]
    return replace(maneuver, block=maneuver.block.select(kept))
