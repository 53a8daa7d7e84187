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


def _vector_norm(v: tuple[FloatArray, ...]) -> FloatArray:
    return np.sqrt(v[0] * v[0] + v[1] * v[1])


def _direction(v: tuple[FloatArray, ...]) -> FloatArray:
    return np.arctan2(v[1], v[0])


def _wind_north(v: tuple[FloatArray, ...]) -> FloatArray:
    return -v[1] * np.cos(np.radians(v[0]))


def _wind_east(v: tuple[FloatArray, ...]) -> FloatArray:
    return -v[1] * np.sin(np.radians(v[0]))


def _mean(v: tuple[FloatArray, ...]) -> FloatArray:
    return 0.5 * (v[0] + v[1])


def _half_difference(v: tuple[FloatArray, ...]) -> FloatArray:
    return 0.5 * (v[0] - v[1])


_QUATERNION = "w, x, y, z of the attitude, earth to body -> rad"

CONVERSIONS: dict[str, Conversion] = {
    conversion.name: conversion
    for conversion in (
        Conversion(name="quaternion.phi", inputs=4, compute=_quaternion_phi, meaning=_QUATERNION),
        Conversion(
            name="quaternion.theta", inputs=4, compute=_quaternion_theta, meaning=_QUATERNION
        ),
        Conversion(name="quaternion.psi", inputs=4, compute=_quaternion_psi, meaning=_QUATERNION),
        Conversion(
            name="horizontal.length",
            inputs=2,
            compute=_vector_norm,
            meaning="north, east -> length, in their unit",
        ),
        Conversion(
            name="horizontal.direction",
            inputs=2,
            compute=_direction,
            meaning="north, east -> direction from north, clockwise, rad",
        ),
        Conversion(
            name="wind_from.north",
            inputs=2,
            compute=_wind_north,
            meaning="direction that the wind comes from (deg), speed -> air moving north",
        ),
        Conversion(
            name="wind_from.east",
            inputs=2,
            compute=_wind_east,
            meaning="direction that the wind comes from (deg), speed -> air moving east",
        ),
        Conversion(
            name="mixed.mean",
            inputs=2,
            compute=_mean,
            meaning="two halves of a V-tail, or elevons -> symmetric part (mean)",
        ),
        Conversion(
            name="mixed.half_difference",
            inputs=2,
            compute=_half_difference,
            meaning="two halves of a V-tail, or elevons -> antisymmetric part, (first - second)/2",
        ),
    )
}
"""Every conversion by its name."""
