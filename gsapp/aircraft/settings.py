"""Uncertainties of weighing an aircraft and of swinging it as a pendulum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTestSettings:
    """Engineering choices."""

    scale_std: float = 0.1  # Of a scale's reading where none is given, N: ten grams.
    axle_std: float = 0.002  # Standard deviation of an axle's place where none is given, m.
    level_std: float = 0.5 * DEGREE  # Of the attitude on the scales where none is given, rad.
    min_axle_distance: float = 0.02  # m: closer axles tell nothing of the CG between them.
    stopwatch_std: float = 0.05  # Of a single time taken by hand, s.
    max_mass_height_ratio: float = 0.4
    """Rms height of the mass over the radius of gyration about z, never reached by an aircraft
    of usual shape: wing, tail and fuselage lie nearly in one plane."""


GROUND_TESTS: Final = GroundTestSettings()
