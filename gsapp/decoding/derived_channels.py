"""Derived channels: computed from measured ones, and only where nobody measures them.

A derived channel is computed row by row on the grid. Its quick inputs must be there at the very
row. Its slow inputs (pressure and temperature of the air) may come in other, slower messages:
then the latest one before the row counts, for up to 30 s, so that a slow message never holds back
a quick one.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gsapp.decoding import air_data
from gsapp.decoding.air_data import Number
from gsapp.decoding.settings import DECODING
from gsapp.quantities import FloatArray

DeriveFunction = Callable[..., Any]


@dataclass(frozen=True, slots=True)
class Derivation:
    """How one channel is computed from others, in the order in which `compute` takes them."""

    output: str
    fast_inputs: tuple[str, ...]
    compute: DeriveFunction  # From arrays of shape (n,) to one, or from numbers to a number.
    source: str  # The formula, or where it stands.
    slow_inputs: tuple[str, ...] = ()
    density: DeriveFunction | None = None
    """From the slow inputs to the density of the air, which `compute` takes in their place."""
    assumed: str = ""  # What is assumed for want of a sensor; empty for nothing.

    @property
    def description(self) -> str:
        """Return formula, inputs and assumption in one line."""
        tail = f"; {self.assumed} assumed" if self.assumed else ""
        return f"{self.source} from {', '.join(self.inputs)}{tail}"

    @property
    def inputs(self) -> tuple[str, ...]:
        return self.fast_inputs + self.slow_inputs

    @property
    def is_alias(self) -> bool:
        """Return whether it is its input, under another name."""
        return self.compute is _identity


def _mean(left: Number, right: Number) -> Number:
    return 0.5 * (left + right)


def _half_difference(left: Number, right: Number) -> Number:
    return 0.5 * (left - right)


def _identity(value: Number) -> Number:
    return value


_STANDARD_DAY = "temperature of the standard day"

_AIR = ("static_pressure", "temperature")
_PRESSURE = ("static_pressure",)
_V, _QBAR = air_data.true_airspeed, air_data.dynamic_pressure
_V_TAIL = ("ruddervator_left", "ruddervator_right")
_ELEVONS = ("elevon_left", "elevon_right")
SURFACE_DERIVATIONS: tuple[Derivation, ...] = (
    Derivation("de", ("elevator_left", "elevator_right"), _mean, "(6.1.1)"),
    Derivation("de", _V_TAIL, _mean, "(left + right)/2"),
    Derivation("de", _ELEVONS, _mean, "(left + right)/2"),
    Derivation("da", ("aileron_left", "aileron_right"), _mean, "(6.1.2)"),
    Derivation("da", _ELEVONS, _half_difference, "(left - right)/2"),
    Derivation("dr", ("rudder",), _identity, "(6.1.3)"),
    Derivation("dr", _V_TAIL, _half_difference, "(left - right)/2"),
)
"""Combined surfaces: definitions, so that they apply to columns as well."""
DERIVATIONS: tuple[Derivation, ...] = (
    *SURFACE_DERIVATIONS,
    # What the vehicle corrected itself goes before the raw difference of pressures.
    Derivation("qbar", ("Vc",), air_data.sea_level_dynamic_pressure, "rho0 Vc^2 / 2"),
    Derivation("qbar", ("V",), _QBAR, "rho V^2 / 2", _AIR, air_data.density),
    Derivation(
        "qbar", ("V",), _QBAR, "rho V^2 / 2", _PRESSURE, air_data.standard_density, _STANDARD_DAY
    ),
    Derivation("qbar", ("dynamic_pressure",), _identity, "incompressible flow"),
    Derivation("Vc", ("qbar",), air_data.calibrated_airspeed, "sqrt(2 qbar / rho0)"),
    Derivation("V", ("qbar",), _V, "sqrt(2 qbar / rho)", _AIR, air_data.density),
    Derivation(
        "V", ("qbar",), _V, "sqrt(2 qbar / rho)", _PRESSURE, air_data.standard_density,
        _STANDARD_DAY,
    ),
    Derivation("density", _PRESSURE, air_data.density, "ideal gas", ("temperature",)),
    Derivation(
        "density", _PRESSURE, air_data.standard_density, "ideal gas", assumed=_STANDARD_DAY
    ),
    Derivation("altitude", _PRESSURE, air_data.altitude, "standard atmosphere"),
)  # fmt: skip
"""All that can be derived. Of several for one channel the first whose inputs exist is taken."""


def select_derivations(
    available: Collection[str], among: Sequence[Derivation] = DERIVATIONS
) -> tuple[Derivation, ...]:
    """Return what can be derived from channels, and is not among them, in order of computation."""
    have = set(available)
    chosen = []
    for derivation in among:
        if derivation.output not in have and have.issuperset(derivation.inputs):
            chosen.append(derivation)
            have.add(derivation.output)
    return tuple(chosen)


def underivable_channels(available: Collection[str], lacking: Collection[str]) -> tuple[str, ...]:
    """Return what could be derived only if some more channels were there.

    Available are derived channels, too; lacking those that calibrated instruments would add.
    """
    whole = {*available, *lacking}
    return tuple(each.output for each in select_derivations(whole) if each.output not in whole)


def source_instruments(measured: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Return the measured channels that each channel is computed from in the end."""
    behind: dict[str, tuple[str, ...]] = {name: (name,) for name in measured}
    for derivation in select_derivations(measured):
        inputs = (name for given in derivation.inputs for name in behind[given])
        behind[derivation.output] = tuple(dict.fromkeys(inputs))
    return behind


class SlowInput:
    """The latest sample of a slow channel before a row, of several sources, the better first.

    A sample counts from the later of its stamp and the flight time at which it came. So it never
    matters for rows that were complete before it came, however the record is cut.
    """

    def __init__(self, sources: int) -> None:
        self._since: list[list[int]] = [[] for _ in range(sources)]
        self._values: list[list[float]] = [[] for _ in range(sources)]

    def push(
        self, source: int, times: Sequence[int], nows: Sequence[int], values: Iterable[float]
    ) -> None:
        """Take samples: stamps and flight time at arrival (us), and values."""
        since, kept = self._since[source], self._values[source]
        for time, now, value in zip(times, nows, values, strict=True):
            # Flight time never goes back, so these are in order but for stamps far ahead.
            counts = max(time, now)
            if since and counts < since[-1]:
                counts = since[-1]
            since.append(counts)
            kept.append(value)

    def at(self, micros: FloatArray) -> FloatArray:
        """Return the value that counts at each of some times (us), NaN where there is none.

        The times increase.
        """
        result = np.full(micros.size, np.nan)
        for since, values in zip(self._since, self._values, strict=True):
            # Of all that is kept only a few are about these times.
            start = max(bisect_left(since, micros[0]) - 1, 0)
            stop = bisect_left(since, micros[-1])
            if start >= stop:
                continue
            counts = np.array(since[start:stop], dtype=np.float64)
            place = np.searchsorted(counts, micros, side="left") - 1
            known = place >= 0
            place = np.maximum(place, 0)
            known &= micros - counts[place] <= DECODING.max_hold
            value = np.where(known, np.array(values[start:stop])[place], np.nan)
            result = np.where(np.isnan(result), value, result)
        return result

    def at_scalars(self, micros: Sequence[float]) -> list[float]:
        """Return what `at` does, number by number."""
        return [self._at(time) for time in micros]

    def _at(self, time: float) -> float:
        for since, values in zip(self._since, self._values, strict=True):
            index = bisect_left(since, time) - 1
            if index >= 0 and time - since[index] <= DECODING.max_hold:
                value = values[index]
                if value == value:
                    return value
        return math.nan

    def drop_before(self, before: int) -> None:
        """Drop what no later row will ask for: all but the last sample before a time (us)."""
        for since, values in zip(self._since, self._values, strict=True):
            if len(since) > 256:
                index = bisect_left(since, before) - 1
                if index > 0:
                    del since[:index], values[:index]
