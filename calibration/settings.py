"""Settings of calibrations: curves and volts at rest, inertial sensors, pressures, the wizard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.foundation.translation import QT_TR_NOOP

FIT_ORDER_TITLES: Final = {
    1: QT_TR_NOOP("straight line"),
    2: QT_TR_NOOP("quadratic"),
    3: QT_TR_NOOP("cubic"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationSettings:
    """Engineering choices, checked by `tests/bench/calibrations.py`."""

    # Curve.
    max_loss_ratio: float = 0.9  # A higher degree must bring the loss down to this share of it.
    outlier_significance: float = 0.02  # How often points without any outlier have one pointed out.
    drift_significance: float = 0.01  # How often a shift is found where there is none.
    same_setting_share: float = 0.1  # Of the mean spacing: closer settings are the same one.
    turn_point_significance: float = 0.2  # Below it, turn points do not count as noted.
    prior_degrees_of_freedom: float = 4.0  # Points that a setting error known beforehand is worth.
    max_degree: int = max(FIT_ORDER_TITLES)  # Degree of a curve at most.
    uncertainty_points: int = 9  # Where along the curve its uncertainty is written down.
    confidence: float = 0.95  # Confidence level of bounds.
    line_points: int = 9  # Points of a straight line in its certificate.
    min_coverage: float = 0.6  # Share of the travel below which a calibration is remarked upon.
    range_tolerance: float = 1e-6  # Share of the calibrated range that counts as its end.

    # Settings of a plan.
    min_settings: int = 3  # Settings that a calibration takes.
    check_settings: int = 3  # Settings of a check.
    pulse_range: tuple[float, float] = (0.0, 20_000.0)  # Microseconds that a pulse may last.
    counts_range: tuple[float, float] = (-(2.0**32), 2.0**32)  # Counts of any converter.
    volts_range: tuple[float, float] = (-15.0, 15.0)  # Volts that a converter may read ...
    supply_range: tuple[float, float] = (0.5, 30.0)  # ... and that may supply a potentiometer.

    # Faults.
    min_response_counts: float = 40.0  # Movement of a potentiometer, ADC counts: about 1 deg.
    fault_noise_counts: float = 10.0  # Sample-to-sample noise of a bad contact, ADC counts.
    fault_clipped_share: float = 0.05  # Share of samples at the end of the ADC range: clipped.
    min_fault_samples: int = 8  # Fewer samples show no movement.

    # Rest.
    rest_block: float = 0.5  # Length of a block, s.
    min_block_samples: int = 5  # Samples that a block must have of each instrument.
    max_blocks: int = 240  # Blocks kept: two minutes of rest.

    # Volts.
    evaluation_period: float = 0.1  # How often the state is judged, s.
    averaging: float = 0.7  # Seconds at rest that a reading is averaged over.
    window_segments: int = 5  # Parts of the window whose means are compared.
    still_counts: float = 4.0  # Largest difference of the means at rest, ADC counts.
    noisy_counts: float = 10.0  # Standard deviation of a noisy instrument, ADC counts.
    clipped_share: float = 0.2  # Share of samples at the end of the ADC range: clipped.
    min_window_samples: int = 5  # Samples needed; a slow link lets the window grow ...
    max_window_factor: float = 3.0  # ... by up to this factor.
    max_gap: float = 0.5  # Seconds without a sample after which everything before is forgotten.


CALIBRATION: Final = CalibrationSettings()


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


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardSettings:
    """Engineering choices, checked by `tests/bench/wizard.py`."""

    start_time: float = 2.0  # s of samples before the first instrument is asked for.
    max_gap: float = 1.0  # s without samples after which a movement may be missed.
    slice_duration: float = 0.1  # Of a slice, s.
    clock_restart: float = 1.0  # s back in time: the clock of the aircraft restarted.
    rest_timeout: float = 20.0  # s to lay an aircraft down before anything is said.
    reason_interval: float = 5.0  # Seconds between two reasons.
    max_means: int = 3000  # Means that are kept: five minutes of tenths of a second.

    # Angles set by hand.
    min_volts_apart: float = 0.02  # V from a rest that count as moved: about 0.5 deg.
    same_setting_volts: float = 0.06  # Volts from a point within which no other setting lies.
    known_share: float = 0.05  # Of the certificate's bound: such a mean adds nothing.
    min_stds_apart: float = 6.0  # The same in standard deviations of the mean.
    min_sign_movement: float = 0.15  # V of a movement that proves a sign: about 4 deg.
    sign_hold: float = 1.0  # Seconds that it must be held.
    hold: float = 1.1
    """s at rest before a point is taken: longer than the averaging, since a hand creeps to its
    mark, and creeping up and down would look like slop."""
    unsure_hold: float = 1.5  # The same where nothing tells whether it is the setting asked for.
    min_averaging: float = 0.3  # Seconds of rest that are averaged at least ...
    confirmed_hold: float = 0.6  # ... and held where the certificate in force agrees.
    near_share: float = 0.3  # Of the spacing: a rest this near is the setting, by two points ...
    near_share_one: float = 0.45  # ... by one point and the reference ...
    passed_share: float = 0.1  # ... and beyond which a rest has passed it.
    sample_retention: float = 20.0  # Seconds of samples that are looked back at.
    check_interval: float = 0.5  # Seconds between looks.
    movement_timeout: float = 15.0  # s without movement: the instrument may be dead.
    held_volts: float = 0.02  # Volts between which an instrument stays while it is held.
    recent_time: float = 2.0  # Seconds of samples that tell a fault at once.
    max_zero_drift: float = 0.05  # Drift that is asked about: of the zero, share of the range ...
    max_slope_drift: float = 0.1  # ... and of the slope, relative.
    max_slope_difference: float = 0.5  # Between left and right, before it is asked about.
    min_coverage: float = 0.6  # Share of the travel: less than that covered is worth a word.

    # Rest, s.
    position_rest: float = 3.0  # Seconds of rest in each position.
    zero_rest: float = 5.0  # Seconds of rest for the zeros.
    min_turn_share: float = 0.6  # Of the angle asked for: less was laying it on the table.
    pressure_rest: float = 4.0  # s of steady pressure: longer than wind in 200 trials.
    cover_timeout: float = 10.0  # s under a cover after which pressure that moves is wind.


WIZARD: Final = WizardSettings()
