"""Settings of test points and of the inputs that are asked for at them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class InputTargetSettings:
    """Engineering choices, checked by `tests/bench/wanted_inputs.py`."""

    # Size of an input.
    min_free_plays: float = 2.0  # Times the free play of the linkage that an input must have.
    min_travel_share: float = 0.03  # Of half the travel: smaller inputs are not found.
    max_edge_share: float = 1.0 / 3.0  # Of a step that the servo may take across.
    narrow_band_ratio: float = 1.25  # Of the ends of a band, between noise and limits.
    max_range_share: float = 0.9  # Of a sensor's range: gusts and vibration need the rest.
    target_amplitude_share: float = 0.6
    """Of the largest amplitude: a pilot is off by a tenth and more, a gust adds to the response,
    and either must not spoil it."""
    response_time_step: float = 0.01  # Time step of the answers, s.
    max_relative_bound: float = 0.3  # Of its value, for an estimate to update the model.
    max_ratio: float = 3.0  # To the model's value, either way, for the same.

    # Timing of an input.
    max_damping_ratio: float = 0.9  # Beyond it, an oscillation dies within one swing.
    aperiodic_time_constants: float = 4.0  # After them 2 % of a motion are left.
    roll_time_constants: float = 2.0  # After them a doublet has 80 % of its roll rate.
    min_response_share: float = 0.8  # Share of the best response that an input's width must reach.
    hands_off_periods: float = 2.0  # Of the slowest oscillation excited.
    max_hands_off_time: float = 6.0  # s; no straight leg has room for more.
    min_step: float = 0.15  # Shortest step that a hand can make, s ...
    max_step: float = 2.5  # ... and the longest that a straight leg has room for, s.
    default_hands_off_time: float = 4.0  # s: two periods of an aircraft of this size.

    # Words for the stick.
    good_stick_range: tuple[float, float] = (1.0 / 3.0, 0.75)
    """Shares of full stick that are easy to fly."""
    stick_range: tuple[float, float] = (0.2, 1.0)  # Shares at which the rate switch stays.
    max_stick: float = 1.1  # Share beyond which full stick is not enough.
    width_tolerance: float = 0.1  # Share: no hand keeps a width better.
    max_change: float = 5.0  # Factor beyond which no number is given: a mistake ...
    min_change: float = 0.2  # ... and below which none is.

    # Level flight over speed.
    grid_points: int = 25  # Of the grid; alpha is met within a hundredth of a degree between them.
    bisections: int = 6  # Steps in which each end of the range is found.
    min_segments: int = 3  # For the zero of the vane: a median of three.
    alpha_tolerance: float = 1e-9  # By which alpha at an end of the curve may miss it, rad.
    max_alpha_shift: float = 3.0 * DEGREE  # By steady flight; beyond, the vane is off.
    min_speed_ratio: float = 0.7  # Search range in speeds just before the stall: lowest ...
    max_speed_ratio: float = 4.0  # ... and the highest.

    # Holding a point.
    deadband: float = 0.5  # Share of the tolerance: advice must not chase noise.
    far_tolerances: float = 2.0  # Beyond them, the throttle setting is advised.
    capture_time: float = 2.0  # Seconds for which a point is held before it is captured.
    max_speed_change: float = 0.6  # Share of the tolerance, over `capture_time`.
    release_tolerances: float = 2.0  # Tolerances beyond which a captured point is left.


INPUTS: Final = InputTargetSettings()
