"""Settings of the alerts in flight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class AlertSettings:
    """Engineering choices, checked by `tests/bench/dangers.py`."""

    frame_duration: float = 0.25  # Length of one frame, s: what is wrong is told at its end.
    max_value: float = 1e9  # SI: no quantity is so large; such samples are missing.
    hold_time: float = 2.0  # s that an alert stays after its last finding: no flicker.

    # Gyros and phase of flight.
    settling_time: float = 1.0  # Seconds in the air from which on instruments are spoken of.
    confirm_frames: int = 2  # Frames that a doubt must last before it is told.
    gyro_memory: float = 3.0  # Seconds over which angles are compared: a leaky sum.
    max_gyro_difference: float = 10.0 * DEGREE
    """rad: three times what zeros, scales and delays of usual gyros make of a turn."""
    min_turn_rate: float = 10.0 * DEGREE  # rad/s, at which a rejected gyro is accepted again ...
    gyro_tolerance: tuple[float, float] = (3.0 * DEGREE, 0.15)
    """... within so much, rad/s, and such a share ..."""
    gyro_agreement_frames: int = 4  # ... in so many frames one after the other in which it turns.
    max_pitch: float = 75.0 * DEGREE  # Beyond this pitch attitude Euler angles tell no rates.
    field_altitude_frames: int = 40  # Frames on the ground whose median is field altitude.
    landing_height: float = 8.0  # m above the field: lower, the aircraft is slow to land.
    altitude_frames: int = 4  # Barometers are noisy: the median of so many frames counts.

    # Battery and fuel.
    reserve_time: float = 60.0  # s; as long before the end the crew is told to land.
    fuel_reserve: float = 0.2  # Share of what there was at take-off.
    battery_slope_frames: int = 240  # Frames, a minute, over which the battery's sinking is taken.
    min_battery_slope: float = 1e-4  # V/s; less is noise and no forecast.

    # Clipping.
    min_clipped_samples: int = 3  # Successive samples at the end: one alone is a spike.
    flat_time: float = 0.12  # Seconds at one value.
    flat_share: float = 0.12  # Of the usual change from row to row; less is none.
    clipping_memory: int = 40  # Frames of which the usual change and the swing are remembered.
    min_bend: float = 1e-3
    """Of the usual change: where the change itself changes by more there is a sample; rows
    between two samples of a slow link lie on the line that joins them."""
    min_flat_distance: float = 6.0  # Usual changes from the middle of the last seconds.

    # Geofence.
    floor_margin: float = 5.0  # The floor counts once the aircraft was so far above it, m.
    landing_flap: float = 5.0 * DEGREE  # With flaps out it lands, and the floor counts no more.
    climb_frames: int = 6  # Frames that a climb must last to be carried on.
    climb_time: float = 3.0  # Seconds over which the climb is taken where nothing measures it.

    # Airspeed and gyros against kinematics.
    compared_frames: int = 24  # Long enough for a turn, short enough to tell in time.
    comparison_interval: int = 2  # Frames from one comparison to the next.
    frame_samples: int = 5  # Means per frame, which engine vibration does not pass.
    min_airborne_time: float = 1.0  # Seconds in the air before a stretch begins.
    stuck_share: float = 0.15  # Of the expected motion; gusts hid two thirds of it at most.
    stuck_noise_ratio: float = 2.0  # ... and of the noise of the means, where it is stated.
    mean_rows: float = 5.0  # Rows of 100 Hz in each mean.
    reference_speed: float = 25.0  # m/s; at less, noise of the pressure is more noise of the speed.
    free_share: float = 0.4  # Of the expected motion: a stuck sensor is free again.
    min_predicted_rate: float = 3.5 * DEGREE  # Standard deviation, rad/s, by all other sensors ...
    stuck_rate_share: float = 0.08  # ... and the share of it below which it has not.
    max_dead_rate: float = 1.0 * DEGREE  # rad/s; a gyro that moves more than this is not dead.
    min_live_rate: float = 0.6 * DEGREE  # rad/s; a gyro that moves less than this may be dead.
    max_unexplained_share: float = 0.3  # Of the squared residuals, without the faulty gyro.
    gust_ratios: tuple[float, float] = (0.5, 0.4)
    """Gusts along the path over those across: v, w, detrended."""
    calm_airspeed_std: float = 0.1  # Misses of the airspeed in calm air, m/s.
    wrong_gust_ratio: float = 5.0  # Airspeed residual over gusts; 3.4 was seen in gusts.
    min_wrong_residual: float = 0.8  # m/s.
    reversed_correlation: float = -0.85  # Of height and airspeed: the tube holds its pressure.
    reversed_gust_ratio: float = 2.0  # Times what gusts explain, for that.
    min_valid_correlation: float = 0.5  # Correlation from which on the airspeed tells the truth.
    confirm_comparisons: int = 2  # Successive comparisons that must agree.
    basis_functions: int = 9  # Triangles that rebuild the rate of a rejected gyro.
    gyro_error_std: float = 20.0 * DEGREE  # rad/s, of a rejected gyro: keeps the sums small ...
    residual_std: float = 0.5  # ... beside misses, m/s, such as gusts make.

    # Dead and disconnected sensors.
    silent_frames: int = 6  # Frames without a sample, while others come.
    still_frames: int = 6  # Frames without life.
    learning_frames: int = 40  # Frames until a sensor's own unrest is known.
    min_activity: float = 0.25  # Of the usual scatter, or of the noise where it is stated.
    min_activity_unknown_noise: float = 0.08  # Engine vibration is ten times the noise.
    range_excess: float = 0.03  # Of the range: only an open wire reads so far outside.
    open_frames: int = 2  # Frames of nothing but that.
    episode_memory: float = 60.0  # Two excursions within so many seconds are a loose wire ...
    episode_hold: float = 30.0  # ... for so long after the last, s.
    max_speed_drop: float = 6.0  # m/s in a frame: a tube came off.
    speed_drop_frames: int = 8  # Frames for which such a drop counts.

    # Stall.
    prediction_time: float = 0.5  # s ahead: what the pilot needs to hear and to push.
    min_load_factor: float = 0.5  # Lower ones do not lower the stall speed: a pull follows.
    caution_ratio: float = 1.08  # Of the stall speed at the present load factor.
    warning_ratio: float = 1.0  # The same: here it stalls.
    alpha_valid_factor: float = 0.93
    """On both ratios, where a valid vane shows alpha within its linear range: a gust that loads
    the wing for a moment is not yet a stall."""
    far_from_stall_ratio: float = 1.35  # Of the stall speed: half of the lift is used.
    caution_alpha_share: float = 0.55  # Of the way from the linear range to the stall.
    flap_gain: float = 0.12  # Share of the stall speed at full flap: half of a slotted flap.
    takeoff_time: float = 3.0  # s after lift-off in which low speed is normal.
    stall_frames: int = 2  # Successive frames: a gust is no stall.


ALERTS: Final = AlertSettings()
