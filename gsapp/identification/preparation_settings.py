"""Settings of preparing measured motion for an estimate, whatever its method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparationSettings:
    """Engineering choices unless a source is named."""

    # Motion.
    cruise_speed_ratio: float = 1.64
    """Speed that replaces a missing one, over the stall speed: 100 over the 61 ft/s of Seanor's."""
    min_speed_ratio: float = 0.5  # Airspeed over stall speed below which nothing flies.
    attitude_time: float = 0.8  # Seconds at the start of a maneuver over which attitude is found.
    trim_duration: float = 1.0
    """Seconds at the start of a maneuver that tell the conditions it was flown at."""
    speed_spread: float = 0.1
    """Share of the speed by which a guess from the stall speed is uncertain."""
    spread_prior_weight: float = 2.0
    """How many maneuvers such a guess of the spread is worth: two that happen to agree prove
    little."""
    accelerometer_offset: float = 0.02 * GRAVITY
    """How uncertain the zero of an accelerometer is, m/s^2."""
    cg_tolerance: float = 2e-3
    """Flights whose CGs lie closer together than this, m, can share one fit."""

    # Samples.
    margin_samples: int = 32
    """Samples beside a maneuver that bringing late channels to their time may reach into."""
    min_samples: int = 40  # That a maneuver must hold: fewer than the unknowns can be told from.
    min_deflection: float = 0.01
    """Peak-to-peak deflection (rad) from which a surface counts as moved."""
    max_missing_share: float = 1e-3  # Share that a missing sample may have in one that counts.
    limit_tolerance: float = 1e-9  # Share of a limit within which a sample was cut off by it.
    max_interpolated_share: float = 1e-6
    """Share that a missing sample may have in an interpolated one."""

    # Interpolation and smoothing.
    max_interval: int = 5
    """Samples of the grid to a chord at most: beyond, a curve through its ends is a guess."""
    collinearity_tolerance: float = 1e-4
    """Bend over the usual bend of the channel below which three samples are in line."""
    min_linear_share: float = 0.98
    """Share of samples in line with their neighbors from which a channel was interpolated ..."""
    max_linear_knot_share: float = 0.5  # ... and the largest share of its knots that may be so.
    min_knots: int = 4  # Ends of chords that it takes for a curve.
    min_cutoff: float = 2.0
    """Cutoff frequencies, Hz: rigid-body motion of such aircraft lies below the lowest ..."""
    max_cutoff: float = 10.0  # ... noise and structure above the highest.
    max_filled_gap: float = 0.035
    """Missing stretches up to this long (s) are bridged for the filter; they still do not count."""
    flow_angle_passes: int = 3  # Passes in which flow angles that were not measured are integrated.

    # Signs.
    sign_sigmas: float = 3.0  # Standard deviations from zero at which a sign is known.


PREPARATION: Final = PreparationSettings()
