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
    min_travel_share: float = 0.03
    """Share of half of the travel below which no input is seen as one; as the grader has it."""
    max_edge_share: float = 1.0 / 3.0
    """Share of a step that the servo may take from one side to the other."""
    narrow_band_ratio: float = 1.25
    """Ratio of the ends of a band where noise leaves hardly any room below the limits."""
    max_range_share: float = 0.9
    """Share of a sensor's range that an answer may use: gusts and vibration need the rest."""
    target_amplitude_share: float = 0.6
    """Share of the largest amplitude that is aimed at: a pilot is off by a tenth and more, the gust
    that comes along adds to the answer, and either must not spoil it."""
    response_time_step: float = 0.01  # Time step of the answers, s.
    max_relative_bound: float = 0.3
    """Share of its own value that the bound of an estimate may have to take a derivative's
    place."""
    max_ratio: float = 3.0
    """Ratio to the model's value beyond which an estimate is not believed, either way."""

    # Timing of an input.
    max_damping_ratio: float = 0.9
    """Damping ratio beyond which an oscillation is none to the eye: it dies within one swing."""
    aperiodic_time_constants: float = 4.0
    """Time constants after which 2 % of a motion without oscillation are left."""
    roll_time_constants: float = 2.0
    """Time constants of the roll after which a doublet's roll rate swings 80 % of what it can."""
    min_response_share: float = 0.8  # Share of the best response that an input's width must reach.
    hands_off_periods: float = 2.0
    """Periods of the slowest oscillation excited for which the hands stay off."""
    max_hands_off_time: float = 6.0  # s; no straight leg has room for more.
    min_step: float = 0.15  # Shortest step that a hand can make, s ...
    max_step: float = 2.5  # ... and the longest that a straight leg has room for, s.
    default_hands_off_time: float = 4.0
    """Where no model tells, s: two periods of an aircraft of this size."""

    # Words for the stick.
    good_stick_range: tuple[float, float] = (1.0 / 3.0, 0.75)
    """Shares that a hand finds well: smaller ones are fiddly, larger ones leave no room."""
    stick_range: tuple[float, float] = (0.2, 1.0)
    """Shares for which the rate switch is left where it is."""
    max_stick: float = 1.1  # Share beyond which full stick is not enough.
    width_tolerance: float = 0.1
    """Share by which a width may miss what is wanted without a word: no hand keeps it better."""
    max_change: float = 5.0
    """Factor beyond which no number is told: such an input was a mistake ..."""
    min_change: float = 0.2  # ... and below which none is.

    # Level flight over speed.
    grid_points: int = 25  # Of the grid; alpha is met within a hundredth of a degree between them.
    bisections: int = 6  # Steps in which each end of the range is found.
    min_segments: int = 3
    """Stretches that tell where the vane stands: the median of three is safe from one that is
    off."""
    alpha_tolerance: float = 1e-9  # By which alpha at an end of the curve may miss it, rad.
    max_alpha_shift: float = 3.0 * DEGREE
    """The most by which alpha measured in steady flight moves the curve; beyond it the vane is
    off."""
    min_speed_ratio: float = 0.7
    """Ends of the search, in speeds at which the wing carries the weight just before the stall: the
    lowest ..."""
    max_speed_ratio: float = 4.0  # ... and the highest.

    # Holding a point.
    deadband: float = 0.5
    """Share of the tolerance within which nothing is said: advice must not chase noise."""
    far_tolerances: float = 2.0
    """Tolerances beyond which the throttle that holds the point is said with the advice."""
    capture_time: float = 2.0  # Seconds for which a point is held before it is captured.
    max_speed_change: float = 0.6
    """Share of the tolerance by which the speed may have changed over `capture_time`."""
    release_tolerances: float = 2.0  # Tolerances beyond which a captured point is left.


INPUTS: Final = InputTargetSettings()
