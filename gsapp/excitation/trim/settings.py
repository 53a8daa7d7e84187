"""Settings of the trim cue, its legs and its air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimSettings:
    """Engineering choices, checked by `tests/bench/trim_cue.py`."""

    # Ticks.
    fast_channels: int = 11  # Of `TICK_CHANNELS`, the first: they never stay the same.
    stuck_time: float = 2.0  # s without any change.
    min_flow_speed: float = 5.0  # m/s: slower, a pitot may stay the same, on the ground.
    min_window_share: float = 0.6  # Share of the ticks of a window that must be there.
    min_zero_frames: int = 6  # Frames of standing still that tell a zero.
    ground_frames: int = 4
    """Frames without flight until the ground is certain: a record may begin, or go on after a
    gap, in the air."""
    max_zero: float = 5.0 * DEGREE  # What is more, rad/s, is motion or a broken gyro.
    default_min_airspeed: float = 12.0  # m/s, of flight, without an aircraft file.
    initial_std: tuple[float, float] = (10.0, 5.0)  # Of height, m, and climb rate, m/s.
    height_std: float = 0.5  # m, of a tick's mean: static pressure with its noise.
    climb_rate_std: float = 0.5  # The same of a measured rate of climb, m/s.
    climb_process_noise: float = 0.1**2  # (m/s)^2/s: attitude within a degree or two.
    max_height_error: float = 15.0  # m; beyond, a fault or a new start.
    height_error_time: float = 0.5  # Seconds of such heights that are a new beginning.
    climb_timeout: float = 2.0  # s without height and climb rate: unknown.
    min_flow_angle_speed: float = 5.0  # Airspeed below which flow angles mean nothing, m/s.
    default_speed: float = 28.0  # m/s, without pitot and aircraft file.
    cruise_ratio: float = 1.5  # Usual airspeed over that below which it does not fly.
    turn_averaging: float = 0.7  # Seconds of which the mean turn rate tells a turn.
    rate_averaging: float = 0.3  # Seconds of which the mean rates tell that trim is lost.
    min_mean_share: float = 0.6  # Share of what a mean is taken of that must be there.

    # Bank without attitude.
    initial_bank_std: tuple[float, float] = (12.0 * DEGREE, 2.0)  # Bank, rad, and v, m/s.
    roll_process_noise: float = (0.6 * DEGREE) ** 2  # rad^2/s: vibration, zero offset.
    roll_process_noise_unmeasured: float = (15.0 * DEGREE) ** 2  # The same without that rate.
    side_process_noise: float = 0.35**2  # (m/s)^2/s, of lateral acceleration and V r.
    side_process_noise_unmeasured: float = 1.5**2  # The same without lateral acceleration.
    calm_air_std: float = 0.15  # Standard deviation of v about V beta in calm air, m/s.
    sideslip_std: float = 1.2  # The same about zero, where no vane tells beta.
    gust_time: float = 2.0  # How long a gust from the side lasts, s.
    attitude_time_constant: float = 2.0  # s, of the mean of a_x; gusts are faster.
    default_pitch: float = 4.0 * DEGREE  # Pitch attitude where no a_x tells it.

    # The cue.
    min_dwell_time: float = 0.6  # s in a state; GO ends at once when trim is lost.
    steady_time: float = 0.4  # s within tolerances before GO, of one-second means.
    change_delay: float = 0.2  # s that another state must be wanted.
    enter_ratio: float = 0.92  # Share of the tolerances within which GO is given.
    leave_ratio: float = 1.08  # Share of the tolerances that ends trim.
    time_tolerance: float = 1e-6  # s; sums of ticks are not exact.
    min_leg_time_left: float = 3.0  # No GO with less of the straight leg left, s.
    leg_growth: float = 1.0  # A leg found too short stays so unless it grows by this, s.
    lost_rate_ratio: float = 3.0  # Times its tolerance, over 0.3 s: a rate that ends GO at once.
    lost_ratio: float = 1.5  # Times its tolerance, over a second: anything that ends GO at once.
    gusty_share: float = 0.6  # Of the limit of unrest: one-second means follow gusts.
    calm_share: float = 0.9  # Of the limit of unrest: rough air is calm again.
    calm_time: float = 1.0  # Seconds of calm that end gusty air.
    well_known_bank: float = 1.25 * DEGREE  # rad, of an estimated bank: within tolerances.
    min_bank_share: float = 0.25  # Of the tolerance of an estimated bank, at least.

    # Turbulence.
    window_count: int = 5  # One-second windows that show lasting unrest.
    lasting_share: float = 0.5
    """Share of the tolerance that each of the last seconds exceeds in lasting gusts: the
    response to an input fills only some of them."""
    gust_ratio: float = 2.8
    """Standard deviation of a gust over that of V alpha in a second: the rest is slower, and the
    aircraft turns into the wind."""
    lift_slope: float = 4.5  # 1/rad, of a usual shape, where only accelerations show gusts.
    min_gust_speed: float = 5.0  # Airspeed below which flow angles mean nothing, m/s.

    # Legs.
    turn_rate: float = 8.0 * DEGREE  # Mean rate of a turn, rad/s; 18 deg/s at 45 deg bank.
    straight_rate: float = 5.0 * DEGREE  # Below this, rad/s, a turn is over.
    turn_bank: float = 12.0 * DEGREE  # Least bank of a turn, rad; less is a rudder response.
    roll_in_time: float = 0.7  # Seconds from the first bank to a mean turn rate of `turn_rate`.
    min_pattern_turn: float = 60.0 * DEGREE  # What turns less is a correction on the same leg, rad.
    same_track_tolerance: float = 45.0 * DEGREE  # rad, between legs of one direction.
    max_legs: int = 12  # Legs remembered: three laps of four.
    laps: int = 3  # Laps by which the end of a leg is told.
    single_lap_margin: float = 1.0  # Seconds more while one lap alone tells.
    max_overrun: float = 3.0  # A leg longer than this beyond its end, s, is flown to another plan.
    position_memory: float = 1.5  # Seconds of positions kept.
    min_ground_speed: float = 5.0  # Ground speed below which a position tells no direction, m/s.


TRIM: Final = TrimSettings()
