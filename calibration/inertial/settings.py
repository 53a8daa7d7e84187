"""Settings of the calibration of rate gyros and accelerometers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class InertialSettings:
    """Engineering choices, checked by `tests/bench/inertial.py`."""

    # Accelerometers.
    max_iterations: int = 20  # Iterations of the solution.
    leveling_error: float = 2.0  # Of the aircraft about either axis: half width at 95 %, deg.
    accelerometer_zero_tolerance: float = 0.05  # What the factory's figures may be off: zero, g ...
    accelerometer_scale_tolerance: float = 0.03  # ... scale, relative ...
    alignment_tolerance: float = 3.0  # ... and alignment, deg.
    dead_accelerometer_share: float = 0.2  # Share of 1 g below which a sensor does not respond.
    min_mean_std: float = 2e-4  # V: the converter's steps are not all alike.
    max_misfit: float = 22.5  # Sum of squares: chance 0.001 with six degrees of freedom.

    # Zeros of gyros.
    rest_rate: float = 0.25  # How far half-second means may wander at rest, deg/s ...
    rest_rate_std: float = 0.6  # ... and samples scatter, deg/s.
    rest_tilt: float = 0.006  # The same for accelerometers, g, a third of a degree of tilt ...
    rest_acceleration_std: float = 0.03  # ... and g.
    gyro_zero_tolerance: float = 3.0  # By how much the factory's zero may be off, deg/s.

    # Scales of gyros.
    gyro_scale_tolerance: float = 0.03  # By how much the factory's scale may be off, relative.
    turn_angle_error: float = 0.5  # Of a mark set by hand: half width at 95 %, deg.
    dead_gyro_share: float = 0.2  # Share of its sensitivity below which a gyro does not respond.
    rest_around_turn: float = 0.2  # s at rest integrated with a turn, to cut off nothing.
    max_gap: float = 0.25  # s between samples during a turn.

    # Turns.
    averaging: float = 0.1  # s: means over that are judged.
    max_rest_segments: int = 30  # Stretches of rest before the turn that count for its zero.
    min_turn: float = 135.0  # deg: less is a knock, or laying the aircraft down.
    turning_rate: float = 2.5  # Mean rate of a turn, deg/s by the factory's scale, which goes ...
    turn_edge_rate: float = 0.5  # ... from this rate to where it stays below it, deg/s.
    ready_segments: int = 10  # Segments of rest before a turn may begin ...
    stopped_segments: int = 15  # ... and after which it is over.


INERTIAL: Final = InertialSettings()
