"""The channels that the equations read, and what each axis cannot do without."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from gsapp.dynamics.buildup import linear_variables
from gsapp.identification.axes import AXIS_COEFFICIENTS

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
