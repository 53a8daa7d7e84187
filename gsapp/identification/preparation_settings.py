"""Settings of preparing measured motion for an estimate, whatever its method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparationSettings:
    """Engineering choices unless a source is named."""

    # Motion.
    cruise_speed_ratio: float = 1.64  # Of a missing speed to stall: Seanor's 100/61 ft/s.
    min_speed_ratio: float = 0.5  # Airspeed over stall speed below which nothing flies.
    attitude_time: float = 0.8  # Seconds at the start of a maneuver over which attitude is found.
    trim_duration: float = 1.0  # s at the start of a maneuver: its condition.
    speed_spread: float = 0.1  # Share: uncertainty of a speed from the stall speed.
    spread_prior_weight: float = 2.0  # Maneuvers: two may agree by chance.
    accelerometer_offset: float = 0.02 * GRAVITY  # Of the zero, m/s^2.
    cg_tolerance: float = 2e-3  # m between CGs of flights in one fit.

    # Samples.
    margin_samples: int = 32  # Samples beside a maneuver for time shifts.
    min_samples: int = 40  # That a maneuver must hold: fewer than the unknowns can be told from.
    min_deflection: float = 0.01  # Peak to peak, rad, of a surface that moved.
    max_missing_share: float = 1e-3  # Share that a missing sample may have in one that counts.
    limit_tolerance: float = 1e-9  # Share of a limit within which a sample was cut off by it.
    max_interpolated_share: float = 1e-6  # The same in an interpolated one.

    # Steps of surfaces in slow records.
    slow_sample_time: float = 0.04  # s: from here on the instant of a step matters.
    max_steps: int = 8  # Of a surface in a maneuver: a 3-2-1-1 has five.
    min_step_share: float = 0.2  # Of the largest one.

    # Interpolation and smoothing.
    max_interval: int = 5  # Grid samples between knots: more is a guess.
    collinearity_tolerance: float = 1e-4  # Bend over the channel's usual bend.
    min_linear_share: float = 0.98  # Samples on a line with their neighbors: interpolated ...
    max_linear_knot_share: float = 0.5  # ... and the largest share of its knots that may be so.
    min_knots: int = 4  # Ends of chords that it takes for a curve.
    min_held_share: float = 0.5  # Of the changes of a channel that follow a repeated value ...
    min_held_steps: float = 4.0  # ... and their usual size over its smallest: it holds values.
    min_cutoff: float = 2.0  # Hz: rigid-body motion lies below the lowest cutoff ...
    max_cutoff: float = 10.0  # ... noise and structure above the highest.
    max_air_data_gap: float = 0.5  # s without air data, bridged: they follow speed and height.
    max_filled_gap: float = 0.035  # s bridged for the filter; they still do not count.
    flow_angle_passes: int = 3  # Passes in which flow angles that were not measured are integrated.

    # Signs.
    sign_sigmas: float = 3.0  # Standard deviations from zero at which a sign is known.


PREPARATION: Final = PreparationSettings()
