"""A file of pendulum swings, and the inertias with uncertainties that it means.

The aircraft swings in a cradle: as a compound pendulum about a fore-and-aft or a crosswise axis
for Ixx and Iyy, as a bifilar one about the vertical for Izz. What the cradle and the entrained air
add is taken off. Formulas are (3.6.1)-(3.6.3), notes section 7; SI and radians.

Every measured quantity is written as a value with its unit, ``"5.00 ft"``, or as a pair of value
and standard deviation, ``["5.00 ft", "0.01 ft"]``. Periods come from the times of several swings
and carry the scatter of these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import ValidationInfo, field_validator, model_validator

from gsapp.aircraft.ground_tests import (
    GROUND_TESTS,
    MeasuredAngle,
    MeasuredLength,
    MeasuredMass,
    MeasuredValue,
    MeasuredWeight,
)
from gsapp.foundation import FlightError, StrictModel, read_toml
from gsapp.quantities.constants import GRAVITY
from gsapp.quantities.fields import Angle, Density, Ratio, Time, Volume


def small_amplitude_period(period: float, amplitude: float = 0.0, damping: float = 0.0) -> float:
    """Return the period (s) of the same pendulum undamped and at vanishing amplitude.

    The amplitude is the mean angle to either side, rad; the damping the ratio zeta.
    """
    return period / (1.0 + amplitude**2 / 16.0) * math.sqrt(1.0 - damping**2)


class CompoundSwing(NamedTuple):
    """A compound pendulum: aircraft and cradle about one horizontal axis."""

    period: float
    cradle_period: float
    """Of aircraft and cradle together, and of the cradle alone, by `small_amplitude_period`, s."""
    aircraft_weight: float
    cradle_weight: float
    """N."""
    aircraft_arm: float
    cradle_arm: float
    """From the pivot down to the CG of each, vertical, m."""
    distance: float
    """From the pivot to the aircraft's CG, m; equal to `aircraft_arm` for a level aircraft that
    hangs plumb."""
    air_mass: float = 0.0  # Air that the aircraft displaces and drags along, kg.


class PendulumInertia(NamedTuple):
    """A moment of inertia and what it is the difference of, kg m^2."""

    whole: float  # Of all that swings, about the axis of the swing.
    cradle: float  # The cradle's part.
    transfer: float  # What the parallel-axis rule takes off, entrained air included.

    @property
    def value(self) -> float:
        """Return the aircraft's own, about its CG."""
        return self.whole - self.cradle - self.transfer


def compound_inertia(swing: CompoundSwing) -> PendulumInertia:
    """Return the inertia about an axis through the aircraft's CG, parallel to the pivot."""
    cradle = swing.cradle_weight * swing.cradle_arm
    stiffness = swing.aircraft_weight * swing.aircraft_arm + cradle
    moved = swing.aircraft_weight / GRAVITY + swing.air_mass
    return PendulumInertia(
        whole=stiffness * (swing.period / (2.0 * math.pi)) ** 2,
        cradle=cradle * (swing.cradle_period / (2.0 * math.pi)) ** 2,
        transfer=moved * swing.distance**2,
    )


class BifilarSwing(NamedTuple):
    """A bifilar pendulum: aircraft and cradle on two wires, turning about the vertical."""

    period: float
    cradle_period: float
    """As in `CompoundSwing`, s."""
    aircraft_weight: float
    cradle_weight: float
    """N."""
    stiffness: float
    """Restoring moment over angle and weight, m; see `parallel_wire_stiffness` and
    `slanted_wire_stiffness`."""
    aircraft_offset: float = 0.0
    cradle_offset: float = 0.0
    """Horizontal distance of each CG from the one of both together, m."""


def parallel_wire_stiffness(length: float, first: float, second: float) -> float:
    """Return the stiffness (m) of parallel wires at distances r1, r2 (m) from the combined CG."""
    return first * second / length


def slanted_wire_stiffness(height: float, upper: float, lower: float) -> float:
    """Return the stiffness (m) of wires spaced d1 above and d2 below, a height (m) apart."""
    return upper * lower / (4.0 * height)


def bifilar_inertia(swing: BifilarSwing) -> PendulumInertia:
    """Return the inertia about the vertical through the aircraft's CG."""
    weight = swing.aircraft_weight + swing.cradle_weight
    own = swing.cradle_weight * swing.stiffness * (swing.cradle_period / (2.0 * math.pi)) ** 2
    offsets = (
        swing.aircraft_weight * swing.aircraft_offset**2
        + swing.cradle_weight * swing.cradle_offset**2
    )
    return PendulumInertia(
        whole=weight * swing.stiffness * (swing.period / (2.0 * math.pi)) ** 2,
        cradle=own,
        transfer=offsets / GRAVITY,
    )


def product_of_inertia(vertical: float, ixx: float, izz: float, nose_up: float) -> float:
    """Return Ixz from the inertia about the vertical with the nose up by an angle (rad).

    `vertical` is by `bifilar_inertia`, tilted; all kg m^2.
    """
    s, c = math.sin(nose_up), math.cos(nose_up)
    return (vertical - ixx * s * s - izz * c * c) / (2.0 * s * c)


class _Timing(StrictModel):
    """Times of swings."""

    times: tuple[Time, ...]
    cradle_times: tuple[Time, ...] = ()
    """Each of `cycles` whole swings, with the aircraft and with the cradle alone, s."""
    cycles: int
    cradle_cycles: int | None = None
    amplitude: Angle = 0.0
    """Mean angle to either side, rad."""
    cradle_amplitude: Angle | None = None
    damping: Ratio = 0.0
    cradle_damping: Ratio = 0.0

    @field_validator("times", "cradle_times")
    @classmethod
    def _positive(cls, value: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        least, most = GROUND_TESTS.time_range
        if (not value and info.field_name == "times") or any(
            not least <= one <= most for one in value
        ):
            raise ValueError(
                f'must hold times from {least:g} s to {most:,.0f} s; write ["22.31 s", "22.28 s"]'
            )
        return value

    @field_validator("cycles", "cradle_cycles")
    @classmethod
    def _whole(cls, value: int | None) -> int | None:
        if value is not None and not 1 <= value <= GROUND_TESTS.max_cycles:
            raise ValueError(
                f"must be 1 to {GROUND_TESTS.max_cycles}; write how many whole swings each time "
                "covers"
            )
        return value

    @field_validator("damping", "cradle_damping")
    @classmethod
    def _ratio(cls, value: float) -> float:
        if not 0.0 <= value < 1.0:
            raise ValueError("must lie from 0 to below 1; it is the ratio zeta of the swing")
        return value

    @property
    def period(self) -> MeasuredValue:
        """Return the period with the aircraft, small and undamped, s."""
        return _period(self.times, self.cycles, self.amplitude, self.damping)

    @property
    def cradle_period(self) -> MeasuredValue:
        """Return the period of the cradle alone; zero where it was not swung."""
        if not self.cradle_times:
            return MeasuredValue(0.0)
        amplitude = self.amplitude if self.cradle_amplitude is None else self.cradle_amplitude
        cycles = self.cradle_cycles or self.cycles
        return _period(self.cradle_times, cycles, amplitude, self.cradle_damping)


def _period(
    times: tuple[float, ...], cycles: int, amplitude: float, damping: float
) -> MeasuredValue:
    correction = small_amplitude_period(1.0, amplitude, damping) / cycles
    scatter = float(np.std(times, ddof=1)) if len(times) > 1 else GROUND_TESTS.stopwatch_std
    return MeasuredValue(
        float(np.mean(times)) * correction, scatter / math.sqrt(len(times)) * correction
    )


class CompoundSwings(_Timing):
    """Swings about a horizontal axis."""

    pivot_to_cg: MeasuredLength  # From the pivot to the aircraft's CG, m.
    pivot_to_cg_vertical: MeasuredLength | None = None
    """Its vertical part, where the aircraft does not hang plumb, m."""
    pivot_to_cradle_cg: MeasuredLength = MeasuredValue(0.0)  # Vertical, m.
    additional_mass: MeasuredMass = MeasuredValue(0.0)
    """Of air that the swinging aircraft drags along, beyond what it displaces, kg."""


class BifilarSwings(_Timing):
    """Swings about the vertical, on two wires."""

    wire_length: MeasuredLength | None = None
    first_distance: MeasuredLength | None = None
    second_distance: MeasuredLength | None = None
    """Parallel wires: their length and distances from the combined CG, m."""
    height: MeasuredLength | None = None
    upper_spacing: MeasuredLength | None = None
    lower_spacing: MeasuredLength | None = None
    """Slanted wires instead, m."""
    aircraft_offset: MeasuredLength = MeasuredValue(0.0)
    cradle_offset: MeasuredLength = MeasuredValue(0.0)
    """Horizontal distance of each CG from the combined one, m."""

    @model_validator(mode="after")
    def _one_geometry(self) -> BifilarSwings:
        parallel = (self.wire_length, self.first_distance, self.second_distance)
        slanted = (self.height, self.upper_spacing, self.lower_spacing)
        whole = [group for group in (parallel, slanted) if None not in group]
        partly = [group for group in (parallel, slanted) if any(one is not None for one in group)]
        if len(whole) != 1 or len(partly) != 1:
            raise ValueError(
                "the wires are not described; give wire_length, first_distance and "
                "second_distance, or height, upper_spacing and lower_spacing"
            )
        if any(one is None or one.value <= 0.0 for one in whole[0]):
            raise ValueError("lengths and distances of the wires must be greater than zero")
        return self


class TiltedSwings(BifilarSwings):
    """Swings about the vertical with the nose up, for Ixz; the angle in rad."""

    nose_up: MeasuredAngle

    @field_validator("nose_up")
    @classmethod
    def _tilted(cls, value: MeasuredValue) -> MeasuredValue:
        if not 0.02 < abs(value.value) < 1.55:
            raise ValueError("must be an angle well away from 0 and 90 deg; 20 to 45 deg is good")
        return value


class SwungAircraft(StrictModel):
    """What swings."""

    weight: MeasuredWeight  # As flown, N.
    volume: Volume = 0.0  # Of the air it displaces, m^3.
    depth: MeasuredLength | None = None
    """Overall height of the aircraft, m: bounds how far mass can lie above and below the CG."""

    @field_validator("weight")
    @classmethod
    def _positive(cls, value: MeasuredValue) -> MeasuredValue:
        if not value.value > 0.0:
            raise ValueError("must be greater than zero; weigh the aircraft as flown")
        return value


class Cradle(StrictModel):
    """What holds the aircraft; `weight` in N."""

    weight: MeasuredWeight = MeasuredValue(0.0)


class Swings(StrictModel):
    """A whole file of swings."""

    name: str = ""
    air_density: Density = 1.225
    """kg/m^3."""
    aircraft: SwungAircraft
    cradle: Cradle = Cradle()
    x: CompoundSwings | None = None
    y: CompoundSwings | None = None
    z: BifilarSwings | None = None
    tilted: TiltedSwings | None = None
    """Needs x and z."""

    @model_validator(mode="after")
    def _consistent(self) -> Swings:
        if self.x is None and self.y is None and self.z is None:
            raise ValueError("holds no swings; add a table [x], [y] or [z]")
        if self.tilted is not None and (self.x is None or self.z is None):
            raise ValueError("Ixz needs [x] and [z] in addition to [tilted]; add them")
        swung = [one for one in (self.x, self.y, self.z, self.tilted) if one is not None]
        if self.cradle.weight.value > 0.0 and not all(one.cradle_times for one in swung):
            raise ValueError(
                "the cradle has mass but was not swung alone; add cradle_times to each table, "
                "or remove [cradle]"
            )
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class InertiaResult:
    """What swings mean."""

    values: Mapping[str, MeasuredValue]
    """``ixx``, ``iyy``, ``izz``, ``ixz`` as far as swung, kg m^2."""
    parts: Mapping[str, PendulumInertia]  # What each is the difference of.
    shares: Mapping[str, Mapping[str, float]]
    """Share of the variance of each value, by measured quantity."""
    mass: float  # kg.
    warnings: tuple[str, ...]


def load_swings(path: str | Path) -> Swings:
    """Read a file of swings.

    Raise FileProblemsError if the file holds mistakes; all are named.
    """
    return read_toml(Path(path), Swings)


def compute_inertia(swings: Swings) -> InertiaResult:
    """Evaluate swings; uncertainties by linear propagation of every quantity's own."""
    quantities = dict(_quantities(swings))
    values = {name: one.value for name, one in quantities.items()}
    parts = _parts(swings, values)
    names = list(_inertias(swings, parts, values))
    base = np.array(list(_inertias(swings, parts, values).values()))
    if not np.isfinite(base).all():
        raise FlightError("these swings give no finite inertia; correct amplitudes and air density")
    variance = np.zeros((len(quantities), base.size))
    for row, (name, one) in enumerate(quantities.items()):
        if one.std > 0.0:
            ends = []
            for sign in (1.0, -1.0):
                moved = {**values, name: one.value + sign * one.std}
                ends.append(list(_inertias(swings, _parts(swings, moved), moved).values()))
            variance[row] = (0.5 * (np.array(ends[0]) - np.array(ends[1]))) ** 2
    total = variance.sum(axis=0)
    result = {
        name: MeasuredValue(float(base[k]), float(np.sqrt(total[k])))
        for k, name in enumerate(names)
    }
    shares = {
        name: {
            quantity: float(variance[row, k] / total[k])
            for row, quantity in enumerate(quantities)
            if variance[row, k] > 0.0
        }
        for k, name in enumerate(names)
    }
    mass = swings.aircraft.weight.value / GRAVITY
    return InertiaResult(
        values=result,
        parts=parts,
        shares=shares,
        mass=mass,
        warnings=_warnings(swings, result, quantities, mass),
    )


def _quantities(swings: Swings) -> Mapping[str, MeasuredValue]:
    """Return every measured quantity by its key path."""
    found: dict[str, MeasuredValue] = {
        "aircraft.weight": swings.aircraft.weight,
        "cradle.weight": swings.cradle.weight,
    }
    for table in ("x", "y", "z", "tilted"):
        section = getattr(swings, table)
        if section is None:
            continue
        found[f"{table}.period"] = section.period
        found[f"{table}.cradle_period"] = section.cradle_period
        for key in type(section).model_fields:
            value = getattr(section, key)
            if isinstance(value, MeasuredValue):
                found[f"{table}.{key}"] = value
    return found


def _parts(swings: Swings, value: Mapping[str, float]) -> dict[str, PendulumInertia]:
    found: dict[str, PendulumInertia] = {}
    weight, cradle = value["aircraft.weight"], value["cradle.weight"]
    for table, name in (("x", "ixx"), ("y", "iyy")):
        if getattr(swings, table) is None:
            continue
        distance = value[f"{table}.pivot_to_cg"]
        found[name] = compound_inertia(
            CompoundSwing(
                period=value[f"{table}.period"],
                cradle_period=value[f"{table}.cradle_period"],
                aircraft_weight=weight,
                cradle_weight=cradle,
                aircraft_arm=value.get(f"{table}.pivot_to_cg_vertical", distance),
                cradle_arm=value[f"{table}.pivot_to_cradle_cg"],
                distance=distance,
                air_mass=swings.air_density * swings.aircraft.volume
                + value[f"{table}.additional_mass"],
            )
        )
    for table, name in (("z", "izz"), ("tilted", "vertical")):
        if getattr(swings, table) is None:
            continue
        if f"{table}.wire_length" in value:
            keys = ("wire_length", "first_distance", "second_distance")
            stiffness = parallel_wire_stiffness(*(value[f"{table}.{key}"] for key in keys))
        else:
            keys = ("height", "upper_spacing", "lower_spacing")
            stiffness = slanted_wire_stiffness(*(value[f"{table}.{key}"] for key in keys))
        found[name] = bifilar_inertia(
            BifilarSwing(
                period=value[f"{table}.period"],
                cradle_period=value[f"{table}.cradle_period"],
                aircraft_weight=weight,
                cradle_weight=cradle,
                stiffness=stiffness,
                aircraft_offset=value[f"{table}.aircraft_offset"],
                cradle_offset=value[f"{table}.cradle_offset"],
            )
        )
    return found


def _inertias(
    swings: Swings, parts: Mapping[str, PendulumInertia], value: Mapping[str, float]
) -> dict[str, float]:
    found = {name: part.value for name, part in parts.items() if name != "vertical"}
    if swings.tilted is not None:
        found["ixz"] = product_of_inertia(
            parts["vertical"].value, found["ixx"], found["izz"], value["tilted.nose_up"]
        )
    return found


def _warnings(
    swings: Swings,
    values: Mapping[str, MeasuredValue],
    quantities: Mapping[str, MeasuredValue],
    mass: float,
) -> tuple[str, ...]:
    found = [
        f"{name} comes out negative, which is physically impossible: check the distances from "
        "the pivot and the weights"
        for name in ("ixx", "iyy", "izz")
        if name in values and values[name].value <= 0.0
    ]
    if {"ixx", "iyy", "izz"} <= set(values):
        square = (values["ixx"].value + values["iyy"].value - values["izz"].value) / (2.0 * mass)
        if square < 0.0:
            found.append("izz exceeds ixx + iyy, which is physically impossible: repeat the swings")
        elif values["izz"].value > 0.0:
            height = math.sqrt(square)
            depth = swings.aircraft.depth
            room = (
                depth.value / 2.0
                if depth
                else GROUND_TESTS.max_mass_height_ratio * math.sqrt(values["izz"].value / mass)
            )
            if height > room:
                found.append(
                    f"(ixx + iyy - izz)/2m puts the mass {height:.2f} m (rms) above and below the "
                    f"CG, more than the {room:.2f} m that the aircraft holds: repeat the swings"
                )
    exact = [
        name
        for name, one in quantities.items()
        if one.std == 0.0 and one.value != 0.0 and not name.endswith("period")
    ]
    if exact:
        found.append(
            f"no uncertainty is stated for {', '.join(exact)}: it counts as exact; write "
            '["value", "standard deviation"]'
        )
    return tuple(found)
