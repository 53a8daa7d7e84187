"""The channels that the equations read: what each axis needs, and which of them speak."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import linear_variables
from gsapp.identification.axes import AXIS_COEFFICIENTS, AXIS_SURFACES, AXIS_TITLES
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FTRSettings
from gsapp.quantities import BoolArray, FloatArray

FTRAxis = Literal["lon", "lat"]

FTR_CHANNELS = (
    "V", "qbar", "dynamic_pressure", "alpha", "beta", "p", "q", "r", "ax", "ay", "an",
    "de", "da", "dr", "throttle", "throttle_left", "throttle_right", "thrust",
    "density", "static_pressure", "temperature", "mass",
)  # fmt: skip
"""Channels that the equations may use, in the order of the columns of a row."""
CHANNEL_INDEX: Mapping[str, int] = {name: place for place, name in enumerate(FTR_CHANNELS)}

REQUIRED_CHANNELS: Mapping[FTRAxis, tuple[str, ...]] = {
    "lon": ("alpha", "q", "de"),
    "lat": ("beta", "p", "r", "da", "dr"),
}
OPTIONAL_CHANNELS: Mapping[FTRAxis, tuple[str, ...]] = {
    "lon": ("p", "r", "beta"),
    "lat": ("q", "alpha"),
}
"""Taken as zero where they are not measured."""
FORCE_ACCELEROMETER: Mapping[str, str] = {"CN": "an", "CA": "ax", "CY": "ay"}
"""The instrument that one coefficient alone needs."""
AIRSPEED_CHANNELS = ("V", "qbar", "dynamic_pressure")
"""Any of them gives the airspeed."""


def axis_regressors(axis: FTRAxis) -> tuple[str, ...]:
    """Return the suffixes of the derivatives of one axis: ``alpha q de`` or ``beta p r da dr``."""
    return tuple(linear_variables(AXIS_COEFFICIENTS[axis][0]))


class ChannelAvailability:
    """What was heard of each channel up to now.

    Parameters
    ----------
    dt : float
        Sample time, s.
    measured : iterable of str, optional
        Channels that are known to be measured; by default that shows as the flight goes on.

    Attributes
    ----------
    ever_measured : ndarray of bool, shape (n, n_channels)
        Channels heard up to each row of the last samples taken in.
    """

    def __init__(self, settings: FTRSettings, dt: float, measured: Iterable[str] | None) -> None:
        self._settings, self._dt = settings, dt
        self._known: BoolArray | None = None
        if measured is not None:
            names = set(measured)
            self._known = np.array([name in names for name in FTR_CHANNELS])
        self.restart()

    def restart(self) -> None:
        count = len(FTR_CHANNELS)
        # Rows since the last sample of each channel; at first all get the benefit of the doubt.
        self._silence = np.zeros(count)
        self._heard = np.zeros(count, dtype=bool)
        self._held = np.full(count, np.nan)
        self.ever_measured: BoolArray = np.zeros((1, count), dtype=bool)

    def available(self, finite: BoolArray) -> BoolArray:
        """Return which channels spoke within the last moments, shape (n, n_channels)."""
        ever = np.logical_or.accumulate(
            np.concatenate((self._heard[np.newaxis], finite)), axis=0, dtype=bool
        )
        self.ever_measured, self._heard = ever[1:], ever[-1].copy()
        if self._known is not None:
            return np.broadcast_to(self._known, finite.shape)
        count = len(finite)
        rows = np.arange(1.0, count + 1.0)[:, np.newaxis]
        last = np.maximum.accumulate(np.where(finite, rows, -self._silence), axis=0)
        silence = rows - last
        self._silence = silence[-1].copy()
        return np.asarray(silence <= FTR_ALGORITHM.channel_timeout / self._dt)

    def hold(self, values: FloatArray, finite: BoolArray) -> FloatArray:
        """Return the values with missing ones replaced by the last measured."""
        full = np.concatenate((self._held[np.newaxis], values))
        rows = np.zeros(full.shape, dtype=np.intp)
        np.multiply(finite, np.arange(1, len(full))[:, np.newaxis], out=rows[1:])
        np.maximum.accumulate(rows, axis=0, out=rows)
        held = np.take_along_axis(full, rows, axis=0)
        self._held = held[-1].copy()
        return held[1:]

    def was_measured(self, name: str) -> bool:
        """Return whether a channel spoke at any time."""
        index = CHANNEL_INDEX[name]
        return bool(self._heard[index] if self._known is None else self._known[index])

    # --- words ----------------------------------------------------------------------------------

    def missing_reasons(self, axis: FTRAxis) -> dict[str, str]:
        """Return, for each coefficient that cannot be had now, why, in words."""
        spoken = (
            (self._heard & (self._silence <= FTR_ALGORITHM.channel_timeout / self._dt))
            if self._known is None
            else self._known
        )

        def there(name: str) -> bool:
            return bool(spoken[CHANNEL_INDEX[name]])

        missing = [
            name
            for name in REQUIRED_CHANNELS[axis]
            if not there(name)
            and not (name in self._settings.still and not self.was_measured(name))
        ]
        if not any(there(name) for name in AIRSPEED_CHANNELS) and self._settings.speed is None:
            missing.insert(0, "airspeed")
        found: dict[str, str] = {}
        for name in AXIS_COEFFICIENTS[axis]:
            own = FORCE_ACCELEROMETER.get(name)
            lacking = missing + ([own] if own is not None and not there(own) else [])
            if lacking:
                verb = "is" if len(lacking) == 1 else "are"
                found[name] = f"{' and '.join(lacking)} {verb} not measured"
        return found

    def remarks(self, aircraft: Aircraft, axes: Iterable[FTRAxis]) -> tuple[str, ...]:
        """Return what stands in for what, in words."""
        found: list[str] = []
        for axis in axes:
            silent = [name for name in OPTIONAL_CHANNELS[axis] if not self.was_measured(name)]
            if silent:
                found.append(
                    f"{', '.join(silent)} not measured: taken as zero in the "
                    f"{AXIS_TITLES[axis]} equations"
                )
        still = [
            name
            for axis in axes
            for name in AXIS_SURFACES[axis]
            if name in self._settings.still and not self.was_measured(name)
        ]
        if still:
            found.append(f"{', '.join(still)} not measured: assumed constant")
        if (
            not any(self.was_measured(name) for name in AIRSPEED_CHANNELS)
            and self._settings.speed is not None
        ):
            found.append(
                f"airspeed was not measured; the constant {self._settings.speed:.1f} m/s is used"
            )
        engine = ("throttle", "throttle_left", "thrust")
        if (
            "lon" in axes
            and aircraft.propulsion.max_thrust > 0.0
            and not any(self.was_measured(name) for name in engine)
        ):
            found.append("neither throttle nor thrust was measured: CA_0 then includes the thrust")
        return tuple(found)

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {"silence": self._silence, "heard": self._heard, "held": self._held}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._silence = np.array(state["silence"], dtype=np.float64)
        self._heard = np.array(state["heard"], dtype=bool)
        self._held = np.array(state["held"], dtype=np.float64)
