"""What instruments show of a motion: places, errors, noise, converter, rate of the recorder.

Vanes, pitot and accelerometers sit where the aircraft file says; local flow and felt acceleration
come from cross products. Every channel is sampled at its right time (no low-pass, no lag) unless
an error of the instrument is hidden there.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft
from gsapp.quantities import FloatArray
from tests.discrepancy.blind.engine import RATE
from tests.discrepancy.blind.jsbsim_aircraft import GRAVITY

DEGREE = math.pi / 180.0
AIR_CONSTANT = 287.05287

NOISE: Mapping[str, float] = {
    **dict.fromkeys(("alpha", "beta"), 0.1 * DEGREE),
    **dict.fromkeys("pqr", 1.0 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.005 * GRAVITY),
    **dict.fromkeys(("phi", "theta"), 0.2 * DEGREE),
    **dict.fromkeys(("de", "da", "dr"), 0.05 * DEGREE),
    "flap": 0.05 * DEGREE,
    "throttle": 0.0,
    "dynamic_pressure": 1.0,
    "static_pressure": 13.8,
}
"""Standard deviation of a sample with the source's noise (notes, section 2), SI."""
STEPS: Mapping[str, float] = {
    **dict.fromkeys(("alpha", "beta", "de", "da", "dr", "flap"), 60.0 * DEGREE / 4096),
    **dict.fromkeys("pqr", 180.0 * DEGREE / 3277),
    **dict.fromkeys(("ax", "ay", "an"), 5.0 / 4096 / 0.51 * GRAVITY),
    "dynamic_pressure": 2490.9 / 4096,
    "static_pressure": 103421.0 / 4096,
}
"""One count of the 12-bit converter, SI."""
ZERO: Mapping[str, float] = {
    **dict.fromkeys(("alpha", "beta"), 0.2 * DEGREE),
    **dict.fromkeys(("phi", "theta"), 0.3 * DEGREE),
    **dict.fromkeys("pqr", 0.2 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.01 * GRAVITY),
    "dynamic_pressure": 5.0,
}
"""Standard deviation of the zero error that a flight's calibration leaves, SI."""
COLORED = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an", "phi", "theta")
COLOR_TIME = 0.028
"""Time constant of colored noise, s: 0.7 from sample to sample at 100 Hz."""
AIR_BOX = ("alpha", "beta", "dynamic_pressure", "static_pressure")
SURFACES_BOX = ("de", "da", "dr", "flap")


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """Errors of instruments."""

    scale: Mapping[str, float] = field(default_factory=dict)
    bias: Mapping[str, float] = field(default_factory=dict)
    delay: Mapping[str, float] = field(default_factory=dict)
    lag: Mapping[str, float] = field(default_factory=dict)
    """By channel: recorded over true; SI; s; s."""
    reversed: tuple[str, ...] = ()
    swapped: tuple[tuple[str, str], ...] = ()  # Two channels whose wires were changed over.
    flexing: Mapping[str, float] = field(default_factory=dict)
    """Accelerometers on a structure with a mode at 4 Hz: share of the motion it adds."""


def exposed(aircraft: Aircraft, motion: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return what faultless instruments without noise show, 100 Hz, SI."""
    sensors = aircraft.sensors
    flow = np.column_stack([motion[one] for one in "uvw"])
    rates = np.column_stack([motion[one] for one in "pqr"])
    spin = np.column_stack([motion[f"{one}_dot"] for one in "pqr"])
    force = np.column_stack([motion[f"f{one}"] for one in "xyz"])

    def local(place: Sequence[float]) -> FloatArray:
        return flow + np.cross(rates, np.array(place))

    arm = np.array(sensors.accelerometer.position)
    felt = force + np.cross(spin, arm) + np.cross(rates, np.cross(rates, arm))
    vane, fin = local(sensors.alpha_vane.position), local(sensors.beta_vane.position)
    pitot = local(sensors.air_data.position)
    return {
        "alpha": np.arctan2(vane[:, 2], vane[:, 0]),
        "beta": np.arctan2(fin[:, 1], fin[:, 0]),
        **{name: motion[name] for name in "pqr"},
        "ax": felt[:, 0],
        "ay": felt[:, 1],
        "an": -felt[:, 2],
        **{name: motion[name] for name in ("phi", "theta", "de", "da", "dr", "flap", "throttle")},
        "dynamic_pressure": 0.5 * motion["density"] * np.sum(pitot * pitot, axis=1),
        "static_pressure": motion["static_pressure"],
        # A thermometer on board: with the field's, density is off by 0.02 % for every 10 m.
        "temperature": motion["temperature"],
    }


def _moved(history: FloatArray, delay: float) -> FloatArray:
    times = np.arange(history.size) / RATE
    return np.asarray(CubicSpline(times, history)(np.clip(times - delay, 0.0, times[-1])))


def _filtered(history: FloatArray, tau: float) -> FloatArray:
    ratio = 1.0 / (RATE * tau)
    decay = math.exp(-ratio)
    mean = (1.0 - decay) / ratio
    new, old = 1.0 - mean, mean - decay
    out, _ = lfilter([new, old], [1.0, -decay], history, zi=[(old + decay) * history[0]])
    return np.asarray(out)


def _flexed(history: FloatArray, share: float) -> FloatArray:
    omega, damping, dt = 2.0 * math.pi * 4.0, 0.05, 1.0 / RATE
    pole = np.exp(complex(-damping, math.sqrt(1.0 - damping**2)) * omega * dt)
    denominator = [1.0, -2.0 * pole.real, abs(pole) ** 2]
    # Shaken by changes of the acceleration; still at rest in steady flight.
    numerator = np.array([1.0, -1.0]) * omega * dt
    return history + share * np.asarray(lfilter(numerator, denominator, history - history[0]))


def with_zeros(faults: Faults, random: np.random.Generator) -> Faults:
    zeros = {name: size * float(random.standard_normal()) for name, size in ZERO.items()}
    return replace(faults, bias={**zeros, **faults.bias})


def with_faults(shown: Mapping[str, FloatArray], faults: Faults) -> dict[str, FloatArray]:
    """Return exposed channels after the errors of the instruments, in the order of a chain."""
    out = dict(shown)
    for name, share in faults.flexing.items():
        out[name] = _flexed(out[name], share)
    for name, tau in faults.lag.items():
        out[name] = _filtered(out[name], tau)
    for name, delay in faults.delay.items():
        out[name] = _moved(out[name], delay)
    for name, scale in faults.scale.items():
        out[name] = scale * out[name]
    for name, bias in faults.bias.items():
        out[name] = out[name] + bias
    for name in faults.reversed:
        out[name] = -out[name]
    for one, other in faults.swapped:
        out[one], out[other] = out[other], out[one]
    return out


def recorded(
    shown: Mapping[str, FloatArray],
    random: np.random.Generator,
    *,
    noise: float = 1.0,
    colored: bool = False,
    rate: int = RATE,
    attitude: bool = True,
) -> dict[str, FloatArray]:
    """Return what the recorder holds: noise, 12 bits, its own rate; density and V from pressures.

    Parameters
    ----------
    shown : mapping of str to ndarray, shape (n,)
        At 100 Hz.
    random : numpy Generator
    noise : float
        Times the source's; zero leaves the converter out too.
    colored : bool
        First-order noise of motion instruments, of the same size.
    rate : int
        100 or 50 Hz.
    attitude : bool
        Whether phi and theta are recorded.
    """
    every = RATE // rate
    out: dict[str, FloatArray] = {}
    for name, values in shown.items():
        if name in ("phi", "theta") and not attitude:
            continue
        taken = values[::every]
        size = NOISE.get(name, 0.0)
        if noise and size:
            error = random.standard_normal(taken.size + 100)
            if colored and name in COLORED:
                share = math.exp(-1.0 / (rate * COLOR_TIME))
                error = lfilter([math.sqrt(1.0 - share * share)], [1.0, -share], error)
            taken = taken + noise * size * error[100:]
            step = STEPS.get(name, 0.0)
            if step:
                taken = np.round(taken / step) * step
        out[name] = taken
    out["density"] = out["static_pressure"] / (AIR_CONSTANT * out["temperature"])
    out["qbar"] = out["dynamic_pressure"]
    out["V"] = np.sqrt(2.0 * np.maximum(out["qbar"], 0.0) / out["density"])
    return out
