"""Dirt: what real records suffer from and no aircraft file states, drawn by a seed.

A method that finds the derivatives of a clean flight may fail on the first real one. Each kind of
dirt is drawn from a random stream of its own, so that switched on alone it is the same as in
company. Positions, upwash and mass make the aircraft that flies differ from its file
(`Dirt.apply_to`), lags and another clock are hidden effects (`Dirt.effects`); the rest acts on the
samples, the messages, the air and the throttle.
"""

# ruff: noqa: ARG001 - all draws are called alike

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities.constants import GRAVITY
from gsapp.quantities.fields import Position

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft

DIRT_KINDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "positions": "vanes, pitot and accelerometers up to 5 cm from where the file puts them",
        "lags": "lags of 10 to 40 ms in three single channels",
        "accelerometers": "flexible-structure motion and offsets in the accelerometers",
        "quantization": "8 to 10 bits instead of 12 in a third of the channels",
        "upwash": "vanes show 0.9 to 1.2 times the flow angle",
        "bursts": "messages are sent four times a second",
        "stamps": "one message in 200 has no time stamp",
        "clock": "time stamps scatter by 0.5 to 2 ms; attitude is 10 to 40 ms late",
        "gusts": "turbulence of 0.05 to 0.3 m/s with rotational gusts",
        "precut": "the record holds the maneuvers only, from 0.2 to 0.5 s before them",
        "throttle": "throttle moves of 5 to 20 % every 8 s",
        "mass": "mass up to 5 % from that of the file",
    }
)
"""Each kind with what it draws."""

_ACCURACY: Final = (
    ("mass", 3, "%", ("mass",)),
    ("position", 3, "cm", ("positions",)),
    ("delay", 15, "ms", ("lags", "clock")),
    ("upwash", 10, "%", ("upwash",)),
    ("accelerometer_bias", 0.02, "g", ("accelerometers",)),
)
"""What an aircraft file states of its accuracy: standard deviation, unit, kinds that draw it."""
_LAGGED: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an", "V", "de", "da", "dr")
_COARSE: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an", "de", "da", "dr")
_POSITIONED: Final = ("alpha_vane", "beta_vane", "accelerometer", "air_data")
_DURATION: Final = 700.0  # s for which throttle moves are drawn.


@dataclass(frozen=True, slots=True, kw_only=True)
class StructuralMode:
    """A bending mode of the airframe as an accelerometer feels it."""

    channel: str
    frequency: float  # Hz.
    damping: float  # Share of critical damping.
    participation: float  # Acceleration of the mode over that of the aircraft, once excited.
    buffet: float  # Standard deviation of what engines and air shake up, m/s^2.


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrottleMove:
    """The throttle pushed or pulled for a while."""

    start: float
    end: float
    """s."""
    size: float  # Share of full throttle.


@dataclass(frozen=True, slots=True, kw_only=True)
class Dirt:
    """What was drawn for one flight, SI; a flight without dirt by default."""

    kinds: tuple[str, ...] = ()
    seed: int = 0
    positions: Mapping[str, Position] = field(default_factory=dict)
    """From where the aircraft file puts each instrument to where it sits, m."""
    lags: Mapping[str, float] = field(default_factory=dict)  # First-order time constants, s.
    offsets: Mapping[str, float] = field(default_factory=dict)  # Of the accelerometers, m/s^2.
    structure: tuple[StructuralMode, ...] = ()
    resolutions: Mapping[str, float] = field(
        default_factory=dict
    )  # One count of coarse channels, SI.
    upwash: Mapping[str, float] = field(default_factory=dict)  # Shown over true angle, by vane.
    burst_interval: float = 0.0  # s from one burst of messages to the next; 0 without bursts.
    unstamped_share: float = 0.0  # Of the messages.
    stamp_jitter: float = 0.0  # Standard deviation of the time stamps, s.
    attitude_delay: float = 0.0  # s.
    turbulence: float = 0.0  # Standard deviation of gusts that also rotate the air, m/s.
    lead: float = 0.0
    tail: float = 0.0
    """What a record cut to its maneuvers keeps before and after each, s; 0 for a whole record."""
    throttle: tuple[ThrottleMove, ...] = ()
    mass_factor: float = 1.0  # True mass over that of the file.

    @property
    def effects(self) -> tuple[str, ...]:
        """Return the hidden effects, ``ID:PARAM=VALUE``."""
        lags = [f"sensor.{name}.lag:tau={value!r}" for name, value in self.lags.items()]
        late = self.attitude_delay
        return (*lags, *([f"sensor.attitude.delay:delay={late!r}"] if late else ()))

    def apply_to(self, aircraft: Aircraft) -> Aircraft:
        """Return the aircraft as it is, of which the file says otherwise."""
        sensors = aircraft.sensors
        changes: dict[str, dict[str, Any]] = {name: {} for name in _POSITIONED}
        for name, off in self.positions.items():
            old = getattr(sensors, name).position
            changes[name]["position"] = tuple(a + b for a, b in zip(old, off, strict=True))
        for name, factor in self.upwash.items():
            changes[name]["upwash"] = getattr(sensors, name).upwash * factor
        if self.offsets:
            pairs = zip(sensors.accelerometer.bias, self.offsets.values(), strict=True)
            changes["accelerometer"]["bias"] = tuple(a + b for a, b in pairs)
        moved = {
            name: getattr(sensors, name).model_copy(update=update)
            for name, update in changes.items()
            if update
        }
        mass = aircraft.mass.model_copy(update={"mass": aircraft.mass.mass * self.mass_factor})
        return aircraft.model_copy(
            update={"sensors": sensors.model_copy(update=moved), "mass": mass}
        )

    @property
    def accuracy(self) -> dict[str, str]:
        """Return how well the aircraft file is known, in the words of its own section."""
        return {
            name: f"{std if set(kinds) & set(self.kinds) else 0} {unit}"
            for name, std, unit, kinds in _ACCURACY
        }

    def throttle_offset(self, time: float) -> float:
        """Return what is added to the throttle at a time (s)."""
        return sum(one.size for one in self.throttle if one.start <= time < one.end)

    def as_dict(self) -> dict[str, Any]:
        """Return what was drawn, for JSON."""
        plain = {
            name: dict(value) if isinstance(value, Mapping) else value
            for name in self.__slots__
            for value in (getattr(self, name),)
        }
        return {
            **plain,
            "structure": [asdict(one) for one in self.structure],
            "throttle": [asdict(one) for one in self.throttle],
        }


def parse_dirt_kinds(names: Sequence[str]) -> tuple[str, ...]:
    """Return the kinds of dirt named, in their order; ``all`` is every kind.

    Raise FlightError if there is no such kind.
    """
    for name in names:
        if name != "all" and name not in DIRT_KINDS:
            hint = did_you_mean(name, DIRT_KINDS, f"choose all or from {', '.join(DIRT_KINDS)}")
            raise FlightError(f"there is no dirt '{name}'; {hint}")
    return tuple(kind for kind in DIRT_KINDS if kind in names or "all" in names)


def draw_dirt(kinds: Sequence[str], seed: int, aircraft: Aircraft) -> Dirt:
    """Draw the dirt of one flight; kinds as `parse_dirt_kinds` takes them."""
    wanted = parse_dirt_kinds(kinds)
    drawn: dict[str, Any] = {}
    for index, kind in enumerate(DIRT_KINDS):
        if kind in wanted:
            drawn |= _DRAWS[kind](np.random.default_rng((seed, 0xD1, index)), aircraft)
    return Dirt(kinds=wanted, seed=seed, **drawn)


def _draw_positions(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    off = {name: tuple(random.uniform(-0.05, 0.05, 3).tolist()) for name in _POSITIONED}
    return {"positions": off}


def _draw_lags(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    late = random.choice(_LAGGED, 3, replace=False).tolist()
    return {"lags": {name: float(random.uniform(0.01, 0.04)) for name in late}}


def _draw_accelerometers(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    frequency, damping = float(random.uniform(8.0, 15.0)), float(random.uniform(0.02, 0.05))
    modes = tuple(
        StructuralMode(
            channel=channel,
            frequency=factor * frequency,
            damping=damping,
            participation=float(random.uniform(0.1, 0.4)),
            buffet=float(random.uniform(0.01, 0.03)) * GRAVITY,
        )
        # Wing bending, fuselage bending to the side and, weaker, along.
        for channel, factor in (("an", 1.0), ("ay", 1.3), ("ax", 1.0))
    )
    offsets = {
        name: 0.02 * GRAVITY * float(random.standard_normal()) for name in ("ax", "ay", "an")
    }
    return {"structure": modes, "offsets": offsets}


def _draw_quantization(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    sensors, controls = aircraft.sensors, aircraft.controls
    ranges = {
        "alpha": sensors.alpha_vane.range,
        "beta": sensors.beta_vane.range,
        **dict.fromkeys(("p", "q", "r"), sensors.gyro.range),
        **dict.fromkeys(("ax", "ay", "an"), sensors.accelerometer.range),
        **{name: getattr(controls, name).travel for name in ("de", "da", "dr")},
    }
    coarse = random.choice(_COARSE, 4, replace=False).tolist()
    bits = random.integers(8, 11, len(coarse)).tolist()
    return {
        "resolutions": {
            name: (ranges[name][1] - ranges[name][0]) / 2.0**count
            for name, count in zip(coarse, bits, strict=True)
        }
    }


def _draw_upwash(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {
        "upwash": {
            "alpha_vane": float(random.uniform(1.0, 1.2)),
            "beta_vane": float(random.uniform(0.9, 1.1)),
        }
    }


def _draw_clock(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {
        "stamp_jitter": float(random.uniform(5e-4, 2e-3)),
        "attitude_delay": float(random.uniform(0.01, 0.04)),
    }


def _draw_cut(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {"lead": float(random.uniform(0.2, 0.5)), "tail": float(random.uniform(0.3, 1.0))}


def _draw_throttle(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    moves, start = [], float(random.uniform(1.0, 5.0))
    while start < _DURATION:
        size = math.copysign(random.uniform(0.05, 0.2), random.uniform(-1.0, 1.0))
        length = float(random.uniform(0.8, 3.0))
        moves.append(ThrottleMove(start=start, end=start + length, size=size))
        start += length + float(random.exponential(6.0))
    return {"throttle": tuple(moves)}


def _draw_bursts(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {"burst_interval": 0.25}


def _draw_stamps(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {"unstamped_share": 0.005}


def _draw_gusts(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {"turbulence": float(random.uniform(0.05, 0.3))}


def _draw_mass(random: np.random.Generator, aircraft: Aircraft) -> dict[str, Any]:
    return {"mass_factor": float(random.uniform(0.95, 1.05))}


_DRAWS: Final = {
    "positions": _draw_positions,
    "lags": _draw_lags,
    "accelerometers": _draw_accelerometers,
    "quantization": _draw_quantization,
    "upwash": _draw_upwash,
    "bursts": _draw_bursts,
    "stamps": _draw_stamps,
    "clock": _draw_clock,
    "gusts": _draw_gusts,
    "precut": _draw_cut,
    "throttle": _draw_throttle,
    "mass": _draw_mass,
}
