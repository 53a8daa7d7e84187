"""Which states, responses and derivatives belong to which part of the motion.

Tables 6.2.5 and 6.2.6 of the source: an elevator maneuver frees the twelve longitudinal
derivatives; of the eighteen lateral-directional ones, an aileron maneuver frees all but those of
the rudder, a rudder maneuver all but those of the ailerons, a combined one all.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final, Literal

from gsapp.dynamics.buildup import (
    LATERAL_COEFFICIENTS,
    LONGITUDINAL_COEFFICIENTS,
    linear_variables,
)

Axis = Literal["lon", "lat", "both"]

AXIS_TITLES: Final[Mapping[str, str]] = {
    "lon": "longitudinal",
    "lat": "lateral-directional",
    "both": "six degrees of freedom",
}

AXIS_COEFFICIENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "lon": LONGITUDINAL_COEFFICIENTS,
    "lat": LATERAL_COEFFICIENTS,
    "both": (*LONGITUDINAL_COEFFICIENTS, *LATERAL_COEFFICIENTS),
}
AXIS_STATES: dict[Axis, tuple[str, ...]] = {
    "lon": ("alpha", "q"),
    "lat": ("beta", "p", "r"),
    "both": ("V", "alpha", "beta", "p", "q", "r", "phi", "theta"),
}
"""Active states by default; attitude joins the first two where it was not measured."""
AXIS_RESPONSES: dict[Axis, tuple[str, ...]] = {
    "lon": ("alpha", "q", "an", "ax"),
    "lat": ("beta", "p", "r", "ay"),
    "both": ("V", "alpha", "beta", "p", "q", "r", "phi", "theta", "ax", "ay", "an"),
}
"""Responses compared by default, as far as they were measured."""
DEFAULT_BIASES: dict[Axis, tuple[str, ...]] = {
    "lon": ("an",),
    "lat": ("ay",),
    "both": ("ax", "ay", "an"),
}
"""Responses with a free sensor bias by default.

Where the force coefficients have a bias of their own (CN_0, CY_0), an accelerometer's bias is told
from it by the flow angle's equation. A second bias in the same balance (q, r) cannot be told from
the first, and those of alpha, beta, p and, without speed as a state, a_x not from the ``_0`` terms.
"""
AXIS_SURFACES: dict[Axis, tuple[str, ...]] = {
    "lon": ("de",),
    "lat": ("da", "dr"),
    "both": ("de", "da", "dr"),
}


def derivatives_of(coefficient: str) -> tuple[str, ...]:
    """Return the names of the linear derivatives of one coefficient, bias first."""
    return tuple(f"{coefficient}_{suffix}" for suffix in ("0", *linear_variables(coefficient)))


def axis_derivatives(axis: Axis) -> tuple[str, ...]:
    """Return all derivatives of an axis: 12, 18 or 30."""
    return tuple(name for one in AXIS_COEFFICIENTS[axis] for name in derivatives_of(one))


def axis_of(inputs: Collection[str]) -> Axis:
    """Return the axis that a maneuver with these controls excites; throttle and flap pitch."""
    lateral = not {"da", "dr"}.isdisjoint(inputs)
    longitudinal = "de" in inputs or (bool(inputs) and not lateral)
    return "both" if longitudinal and lateral else "lon" if longitudinal else "lat"


def free_derivatives(axis: Axis, inputs: Collection[str]) -> tuple[str, ...]:
    """Return what is free for a maneuver, tables 6.2.5 and 6.2.6.

    `inputs`: the surfaces that were moved. Derivatives of the others are held.
    """
    still = [f"_{surface}" for surface in AXIS_SURFACES[axis] if surface not in inputs]
    return tuple(name for name in axis_derivatives(axis) if not name.endswith(tuple(still)))
