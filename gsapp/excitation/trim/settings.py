"""Settings of the trim cue, its legs and its air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimSettings:
    """Engineering choices, checked by `tests/bench/trim_cue.py`."""

    # Ticks.
    fast_channels: int = 11
    """The first of `TICK_CHANNELS`: quick ones, which never show the same value for long."""
    stuck_time: float = 2.0  # s without any change.
    min_flow_speed: float = 5.0
    """Airspeed, m/s, below which a pitot may well show one and the same: on the ground."""
    min_window_share: float = 0.6  # Share of the ticks of a window that must be there.
    min_zero_frames: int = 6  # Frames of standing still that tell a zero.
    ground_frames: int = 4
    """Frames after which an aircraft that does not seem to fly is said to be on the ground: a
    record may begin, or go on after a gap, in the air."""
    max_zero: float = 5.0 * DEGREE  # What is more, rad/s, is motion or a broken gyro.
    default_min_airspeed: float = 12.0
    """Airspeed below which no aircraft of this kind flies, m/s, where no aircraft file tells."""
    initial_std: tuple[float, float] = (10.0, 5.0)
    """Standard deviations of height (m) and rate of climb (m/s) before anything was seen."""
    height_std: float = 0.5
    """Standard deviation of the mean height of a tick, m: static pressure with its noise."""
    climb_rate_std: float = 0.5  # The same of a measured rate of climb, m/s.
    climb_process_noise: float = 0.1**2
    """What the integrated acceleration adds, (m/s)^2 a second: attitude is known to a degree or
    two."""
    max_height_error: float = 15.0
    """A height farther than this from where it should be, m, is a fault or a new beginning."""
    height_error_time: float = 0.5  # Seconds of such heights that are a new beginning.
    climb_timeout: float = 2.0
    """Seconds without height and without rate of climb after which nothing is told."""
    min_flow_angle_speed: float = 5.0  # Airspeed below which flow angles mean nothing, m/s.
    default_speed: float = 28.0
    """Airspeed, m/s, where neither a pitot nor an aircraft file tells one."""
    cruise_ratio: float = 1.5  # Usual airspeed over that below which it does not fly.
    turn_averaging: float = 0.7  # Seconds of which the mean turn rate tells a turn.
    rate_averaging: float = 0.3  # Seconds of which the mean rates tell that trim is lost.
    min_mean_share: float = 0.6  # Share of what a mean is taken of that must be there.

    # Bank without attitude.
    initial_bank_std: tuple[float, float] = (12.0 * DEGREE, 2.0)
    """Standard deviations of bank (rad) and sideways speed (m/s) before anything was seen."""
    roll_process_noise: float = (0.6 * DEGREE) ** 2
    """Of the integrated rate of roll, rad^2 a second: vibration, and what is left of its zero."""
    roll_process_noise_unmeasured: float = (15.0 * DEGREE) ** 2  # The same without that rate.
    side_process_noise: float = 0.35**2
    """Of the integrated lateral acceleration and V r, (m/s)^2 a second."""
    side_process_noise_unmeasured: float = 1.5**2  # The same without lateral acceleration.
    calm_air_std: float = 0.15  # Standard deviation of v about V beta in calm air, m/s.
    sideslip_std: float = 1.2  # The same about zero, where no vane tells beta.
    gust_time: float = 2.0  # How long a gust from the side lasts, s.
    attitude_time_constant: float = 2.0
    """Time constant of the mean of a_x that tells the attitude, s; what is faster is gusts."""
    default_pitch: float = 4.0 * DEGREE  # Pitch attitude where no a_x tells it.

    # The cue.
    min_dwell_time: float = 0.6
    """Seconds that a state stands at least; GO ends at once when trim is clearly lost."""
    steady_time: float = 0.4
    """Seconds for which the mean of a second has to be within its tolerances before GO."""
    change_delay: float = 0.2
    """Seconds for which another state has to be wanted before it is taken."""
    enter_ratio: float = 0.92  # Share of the tolerances within which GO is given.
    leave_ratio: float = 1.08
    """Share of the tolerances beyond which the aircraft is no longer trimmed, once it was."""
    time_tolerance: float = 1e-6  # s; sums of ticks are not exact.
    min_leg_time_left: float = 3.0  # No GO with less of the straight leg left, s.
    leg_growth: float = 1.0  # A leg found too short stays so unless it grows by this, s.
    lost_rate_ratio: float = 3.0  # Times its tolerance, over 0.3 s: a rate that ends GO at once.
    lost_ratio: float = 1.5  # Times its tolerance, over a second: anything that ends GO at once.
    gusty_share: float = 0.6
    """Share of the unrest allowed beyond which means of a second go to and fro with the gusts."""
    calm_share: float = 0.9
    """Share of the unrest allowed below which air is calm again that was too rough."""
    calm_time: float = 1.0  # Seconds of calm that end gusty air.
    well_known_bank: float = 1.25 * DEGREE
    """Standard deviation of a bank not seen, rad, for which the tolerance itself leaves room."""
    min_bank_share: float = 0.25
    """Share of the tolerance of a bank not seen that is left however little is known of it."""

    # Turbulence.
    window_count: int = 5
    """Windows of a second by which unrest is found to last, or gusts to be strong."""
    lasting_share: float = 0.5
    """Share of the tolerance that each of the last seconds exceeds in gusts that last: the answer
    to an input fills some of them only."""
    gust_ratio: float = 2.8
    """Standard deviation of a gust over that of V alpha within a second: the rest is slower, and
    the aircraft turns its nose into the wind."""
    lift_slope: float = 4.5
    """Lift per radian of an aircraft of usual shape, where only accelerations tell of gusts."""
    min_gust_speed: float = 5.0  # Airspeed below which flow angles mean nothing, m/s.

    # Legs.
    turn_rate: float = 8.0 * DEGREE
    """A mean turn rate beyond this, rad/s, is a turn; 45 deg of bank turn at 18 deg/s."""
    straight_rate: float = 5.0 * DEGREE  # Below this, rad/s, a turn is over.
    turn_bank: float = 12.0 * DEGREE
    """A turn is flown with more bank, rad; what yaws with less is the answer to a rudder."""
    roll_in_time: float = 0.7  # Seconds from the first bank to a mean turn rate of `turn_rate`.
    min_pattern_turn: float = 60.0 * DEGREE  # What turns less is a correction on the same leg, rad.
    same_track_tolerance: float = 45.0 * DEGREE
    """Legs whose directions differ less are the same leg of the pattern, rad."""
    max_legs: int = 12  # Legs remembered: three laps of four.
    laps: int = 3  # Laps by which the end of a leg is told.
    single_lap_margin: float = 1.0  # Seconds more while one lap alone tells.
    max_overrun: float = 3.0  # A leg longer than this beyond its end, s, is flown to another plan.
    position_memory: float = 1.5  # Seconds of positions kept.
    min_ground_speed: float = 5.0  # Ground speed below which a position tells no direction, m/s.


TRIM: Final = TrimSettings()
