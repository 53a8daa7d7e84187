"""Settings of the calibration of pressure transducers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class PressureSettings:
    """Engineering choices, checked by `tests/bench/calibrations.py`, unless a source is named."""

    # Known pressures.
    rest_pressure: float = 2.5  # Range of half-second means of dynamic pressure, Pa ...
    rest_pressure_std: float = 6.0  # ... and its samples scatter, Pa.
    static_rest_pressure: float = 60.0  # The same for the static pressure, Pa ...
    static_rest_pressure_std: float = 150.0  # ... and Pa.
    noise_ratio: float = 6.0
    """Range of half-second means under the cover, in standard deviations by their noise: six
    means seldom lie more than four apart, and wind hidden within six is worth less than 1 Pa."""
    wind_uncertainty: float = 5.0  # Pa, of a zero taken in a lull: more than in 200 trials.
    dynamic_zero_tolerance: float = 50.0  # Pa: a covered pitot that reads more than that is named.
    static_tolerance: float = 600.0  # Pa: half a percent of an atmosphere; about 50 m of altitude.
    linearity: float = 0.01  # Of the transducers, relative (Seanor 3.5: 1 %).
    line_points: int = 9  # Points of a straight line in its certificate.

    # A breath into the pitot.
    blow_pressure: float = 150.0  # Pa of a breath; lungs give several thousand.
    suction_pressure: float = 60.0  # Pa below zero under a breath: the hoses are swapped.
    end_pressure: float = 40.0  # Pa above what the wind made before at which a breath is over.
    max_static_change: float = 500.0  # Pa that a breath into the pitot must not exceed.
    averaging: float = 0.05  # s: means over that are judged.
    min_duration: float = 0.3  # Seconds that a breath must last ...
    blocked_time: float = 10.0  # ... and after which pressure that stays is shut in.


PRESSURES: Final = PressureSettings()
