"""Settings of cues, trim, inputs and their verdicts, test points, forecasts, and alerts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class CueSettings:
    """Engineering choices."""

    # Rows of samples.
    tick: float = 0.05  # Rows come in whole ticks of so many seconds, counted from time zero.
    max_channel_wait: float = 0.3  # Seconds that a row waits for a quick channel.
    slow_channel_delay: float = 0.5  # Seconds by which slow channels are late.
    max_value: float = 1e7  # In any unit; a larger one is a damaged number.
    max_filled_pause: float = 5.0  # A pause longer than this, s, begins a new stretch of rows.
    rows_retention: float = 60.0  # s of rows kept: more than the longest input takes.

    # Cards.
    selection_interval: int = 10  # Ticks between two selections of a card.
    density_samples: int = 200  # Samples of the air density whose mean is that of the day.
    same_speed: float = 1.0  # m/s: inputs without a card share their targets within.
    reaction_time: float = 1.0  # Seconds from GO to the first move of the stick.

    # Cues.
    go_delay: float = 0.3  # Seconds after what is known of an input until GO may be given again.
    replay_ticks: int = 4  # Ticks in one step from which a record is being replayed.
    display_averaging: float = 0.5  # s, of the speed and angle of attack displayed.
    cue_retention: float = 60.0  # Seconds of cues kept.
    go_memory: float = 2.0  # s after GO was lost in which an input still answers to it.
    verdict_display_time: float = 6.0  # s: the pilot is busy with the recovery.

    # Announcements.
    deviation_interval: float = 1.5  # s between two deviations that are announced.
    deviation_growth: float = 1.5  # Factor from which a deviation is news again.
    min_repeat_interval: float = 3.0  # s until a deviation is repeated with its number.
    repeat_intervals: tuple[float, float, float, float] = (5.0, 10.0, 20.0, 40.0)
    """s until repetitions."""
    max_announced_ratio: float = 3.0  # Tolerances beyond which every pilot sees it.
    roll_out_time: float = 2.0  # Seconds after a turn in which a pilot still rolls out of it.
    recovery_time: float = 3.0  # Seconds after a verdict that belong to it, and to flying on.
    verdict_silence: float = 1.5  # Seconds after a hands-off interval that are left to its verdict.
    note_silence: float = 2.5  # Seconds without a word before a note is said.
    plot_rate: float = 25.0  # Samples/s of kept curves: ten in half a doublet.

    # Estimates in flight.
    maneuver_delay: float = 3.0  # s after a maneuver until late channels came.
    work_slice: float = 0.003  # s of forecast work in one step of a session.
    forecast_interval: int = 10  # Ticks between two forecasts.
    forecast_margin: float = 0.6  # s after which the forecast surely followed the work.


CUES: Final = CueSettings()


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


@dataclass(frozen=True, slots=True, kw_only=True)
class DoubletSettings:
    """Engineering choices, tuned and checked by `tests/bench/verdicts.py`."""

    # Recognizing an input.
    history_retention: float = 40.0  # s: an input may take ten, its response six.
    airborne_at_start: float = 1.5  # s: flying so soon means no take-off in the record.
    landing_height: float = 8.0  # m above the ground: lower, the sticks are landing.
    ground_altitude_frames: int = 8  # Frames on the ground whose median is its altitude.
    continuation_after_target: float = 1.0  # s that sticks may move after the expected input.
    recovery_time: float = 4.0  # s after a verdict: only unmistakable inputs count.
    max_start_bank: float = 32.0 * DEGREE  # rad: beyond it, sticks only roll out of a turn.
    step_gap: float = 0.05  # Seconds without a quick move between two steps.
    min_relative_size: float = 0.5  # Of the motion before: less is a part of a larger input.
    release_time: float = 0.15  # s without a quick move: an input is over.
    release_time_expected: float = 0.6  # The same until an expected surface moved.
    continuation_time: float = 0.7  # A quick move so soon after an input, s, goes on with it.
    max_duration: float = 10.0  # An input that goes on for longer, s, is steering.
    hands_off_other: float = 1.05  # s without sticks after an input of unusual shape.
    returned_share: float = 0.4  # Of the excursion: nearer to trim, the surface is back.
    displaced_share: float = 0.25
    """Of the amplitude: farther, the surface was not brought back, and the input looks like
    another shape about the line between its trims."""
    second_side_share: float = 0.35  # Of the larger side, to be a half of a doublet.
    rest_interval: tuple[float, float] = (0.4, 0.1)  # s before the end of an input: rest after it.
    rest_movement: float = 0.3 * DEGREE  # What a surface at rest moves at most, rad ...
    stick_movement: float = 0.6 * DEGREE  # ... and what it moves by when a hand is put on, rad.
    last_step_time: float = 0.8  # s after which an input that ends off trim is over.
    max_unrest_other: float = 0.15
    """Motion before an input of another shape than expected, as a share of its amplitude, for it
    to be taken as the expected one ..."""
    max_unrest_expected: float = 0.25  # ... and before one of the expected shape.
    certain_step_ratio_one_side: float = 2.0  # Its quickest move over the threshold, one side ...
    certain_step_ratio: float = 1.3  # ... and to both.

    # Measuring an input.
    edge_search: float = 0.3  # Seconds before and after an input in which its edges are looked for.
    pre_input_time: float = 2.5  # s before an input that are examined, trim included.
    bank_history: float = 12.0  # s of bank followed where no attitude is measured.
    initial_state_time: float = 0.15  # Seconds that tell in which state the input began.
    default_gusts: float = 0.3  # Gusts assumed where none were measured, m/s.

    # Parting an answer into what the sticks and what gusts did.
    gust_step: float = 0.05  # s: averaging of samples, and one step of the gust.
    gust_iterations: int = 6  # Of answer and strengths, each from the other.
    initial_gust: float = 0.1 * DEGREE  # Of a step, rad: gusts of half a meter a second.
    min_gust: float = 0.001 * DEGREE  # rad; below it the air is still.
    min_noise_share: float = 0.02  # Of the response: no model follows it more closely.
    gain_std: float = 0.4  # Of the gains about one: how far control derivatives are off.
    max_trim_offset: float = 1.0 * DEGREE
    """rad, of a surface from trim as an input begins: a stick that is held makes a steady roll,
    which is no gust."""
    effect_state_std: float = 1.0  # Of an effect's own state, in its unit: unknown.
    speed_step: float = 1.0  # Small motions are found once for each so many m/s ...
    density_step: float = 0.02  # ... and kg/m^3: 2 % change no response visibly.
    min_response_samples: int = 50  # Of an answer; fewer tell nothing about it.

    # The verdict.
    min_symmetry: float = 0.6  # Of a doublet's halves by area; reported, yet it counts.
    reduction: float = 0.75  # Advised after a response that was too large without a band.
    min_change: float = 1.1
    """Least factor by which a wrong size is to change: *the same* is no advice, even where the
    best size lies at the end of the band."""


DOUBLETS: Final = DoubletSettings()


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


@dataclass(frozen=True, slots=True, kw_only=True)
class InformationSettings:
    """Engineering choices, checked by `tests/bench/information.py`."""

    # Bounds.
    unobservable_bound: float = 1e3  # A larger bound: derivative not observable.
    max_iterations: int = 12  # Steps after which a fit is left as it is.
    prior_share: float = 0.5  # Of a derivative's value: its uncertainty without an input.
    min_prior: float = 0.05  # The least of it, for a derivative near zero.
    weight_iterations: int = 3  # Of weights and step, until what is left over hardly changes.
    min_variance: float = 1e-16  # Variance, SI: no response is known better.
    vane_noise: float = 0.1 * DEGREE  # Of instruments without stated noise: rad ...
    gyro_noise: float = 1.0 * DEGREE  # ... rad/s ...
    accelerometer_noise: float = 0.005 * GRAVITY  # ... and m/s^2.

    # What the flight taught.
    noise_time: float = 4.0  # Seconds before a maneuver in which the noise is heard.
    max_noise_stretches: int = 30  # Of an axis, the newest: the air changes over a long flight.
    min_noise_time: float = 2.5  # s; a shorter stretch says too little of the noise.
    pilot_prior_weight: float = 4.0  # What is usual counts as much as so many maneuvers seen.
    unknown_noise_ratio: tuple[float, float] = 1.0, 0.9
    """Mean and spread of the logarithm of what unknown air does to bounds. In calm air they are
    what the instruments allow; in gusts of 0.8 m/s ten times that."""
    climb_exclusion_time: float = 8.0  # s after take-off: flaps, throttle, steep climb.
    ground_retention: float = 60.0  # s of rows kept on the ground until take-off is found.
    forecast_delay: float = 4.0
    """s of flight after a verdict until the new forecast is shown, whatever the speed of the
    computer: work is done in slices before, or at that moment."""
    first_noise_time: float = 20.0  # s of first flight in which a quiet segment is found.

    # Forecasts.
    pre_input_trim_time: float = 1.0  # s of trim before an input, as detected.
    hand_time_constant: float = 0.1  # Time constant of a hand at the stick, s.
    sweep_band: tuple[float, float] = (0.3, 2.0)  # Frequencies of a sweep, Hz.
    max_relative_bound: float = 1.0  # A bound as large as its derivative says nothing yet.
    execution_count: int = 8  # Simulated executions of a card, with sensitivities.
    draw_count: int = 200  # Random draws for the quantiles of a bound.
    band_quantiles: tuple[float, float, float] = (0.1, 0.5, 0.9)  # Of a bound: band and median.
    speed_step: float = 0.5  # Speeds are rounded to so much, m/s: nearer ones fly alike.
    max_repeats: int = 6  # Nobody plans further ahead with one card.

    # Time left.
    default_flight_duration: float = 420.0  # s, where nothing else is said.
    landing_reserve: float = 60.0  # To come home and land, with one approach gone around, s.
    default_maneuver_interval: float = 35.0  # s, at first: nine to twelve in a flight.
    engine_running_speed: float = 100.0  # Above this speed, rad/s, an engine runs.
    closed_throttle: float = 0.02  # Below it, an engine without tachometer is stopped.
    fuel_flow_time: float = 30.0  # Seconds of flight from which on its own fuel flow counts.
    min_lap: float = 10.0  # Laps shorter than this, s, were none: two inputs on one leg ...
    max_lap: float = 120.0  # ... nor were longer ones: a pause.


INFORMATION: Final = InformationSettings()


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
