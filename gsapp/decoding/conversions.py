"""Named conversions for channels that are not a linear function of one field."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray

ConvertFunction = Callable[[tuple[FloatArray, ...]], FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """A function of several numbers of one message."""

    name: str  # As written in a channel map.
    inputs: int  # How many numbers it takes: fields, or elements of one array field.
    compute: ConvertFunction  # From arrays of shape (n,) to one of shape (n,).
    meaning: str  # What goes in and what comes out.


def _quaternion_phi(q: tuple[FloatArray, ...]) -> FloatArray:
    w, x, y, z = q
    return np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))


def _quaternion_theta(q: tuple[FloatArray, ...]) -> FloatArray:
    w, x, y, z = q
    return np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))


def _quaternion_psi(q: tuple[FloatArray, ...]) -> FloatArray:
    w, x, y, z = q
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


_QUATERNION = "w, x, y, z of the attitude, earth to body -> rad"

CONVERSIONS: dict[str, Conversion] = {
    name: Conversion(name=name, inputs=inputs, compute=compute, meaning=meaning)
    for name, inputs, compute, meaning in (
        ("quaternion.phi", 4, _quaternion_phi, _QUATERNION),
        ("quaternion.theta", 4, _quaternion_theta, _QUATERNION),
        ("quaternion.psi", 4, _quaternion_psi, _QUATERNION),
        (
            "horizontal.length", 2, lambda v: np.sqrt(v[0] * v[0] + v[1] * v[1]),
            "north, east -> length, in their unit",
        ),
        (
            "horizontal.direction", 2, lambda v: np.arctan2(v[1], v[0]),
            "north, east -> direction from north, clockwise, rad",
        ),
        (
            "wind_from.north", 2, lambda v: -v[1] * np.cos(np.radians(v[0])),
            "direction that the wind comes from (deg), speed -> air moving north",
        ),
        (
            "wind_from.east", 2, lambda v: -v[1] * np.sin(np.radians(v[0])),
            "direction that the wind comes from (deg), speed -> air moving east",
        ),
        (
            "mixed.mean", 2, lambda v: 0.5 * (v[0] + v[1]),
            "two halves of a V-tail, or elevons -> symmetric part (mean)",
        ),
        (
            "mixed.half_difference", 2, lambda v: 0.5 * (v[0] - v[1]),
            "two halves of a V-tail, or elevons -> antisymmetric part, (first - second)/2",
        ),
    )
}  # fmt: skip
"""Every conversion by its name."""
