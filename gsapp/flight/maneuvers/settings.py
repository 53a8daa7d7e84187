"""Settings of maneuver detection and grading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverDetectionSettings:
    """Engineering choices, checked by `tests/bench/detection.py` and `tests/bench/verdicts.py`."""

    # Size of the aircraft.
    reference_chord: float = 0.43  # m, of the aircraft that all durations below were tuned on.

    # Airborne or not, frame by frame.
    frame_duration: float = 0.5  # Length of one frame, s; decisions are made at its end.
    max_lift_coefficient: float = 1.2  # Assumed where no stall speed is given.
    takeoff_speed_ratio: float = 1.05  # Speed over the stall speed above which the aircraft flies.
    landing_speed_ratio: float = 0.9  # Speed over the stall speed below which it has landed.
    standing_speed_ratio: float = 0.3  # Below it the aircraft stands, in any wind.
    frames_to_change: int = 2  # Frames that must contradict the present state.
    frames_to_reject_airspeed: int = 12  # Frames of turning at low airspeed.
    airborne_rate: float = 4.0 * DEGREE  # Mean pitch or roll rate never seen on wheels, rad/s.
    still_rate: float = 2.5 * DEGREE  # Mean pitch or roll rate of an aircraft that stands, rad/s.
    min_airborne_rate_frames: int = 4  # Frames beyond `airborne_rate` that show flight ...
    airborne_rate_window: int = 16  # ... among so many.
    still_frames_to_land: int = 40  # Still frames near the ground after which it has landed.
    still_frames_at_end: int = 6  # The same at the end of a record.
    min_climb: float = 12.0  # Above the ground it stood on, m: more than static pressure wanders.
    ground_altitude_frames: int = 8  # Still frames whose altitude is that of the ground.
    max_ground_height: float = 6.0  # Height above the ground, m, below which it may stand on it.

    # Clipped and dead instruments.
    range_margin: float = 0.01  # Share of the range that counts as its end.
    dead_share: float = 0.95  # Share of the samples at the end of the range.
    beyond_travel_share: float = 0.5  # Of the travel: more is a broken wire.
    min_speed_ratio: float = 0.3  # Of the stall speed: less is a dead airspeed.
    min_clipped_samples: int = 20  # Samples that it takes to call an instrument dead at its limit.
    min_stuck_samples: int = 40  # Noise reaches over four deviations among them.
    partner_movement: float = 1.0 * DEGREE  # rad, of one half while a stuck one stays.
    same_value_tolerance: float = 1e-9  # Relative, of values brought to another time.

    # Noise floor.
    noise_window: float = 2.0  # Length of one window of the noise floor, s.
    takeoff_windows: int = 8  # Windows dropped before airborne: take-off run.
    min_ground_windows: int = 2  # Windows with engines running that give the noise on the ground.
    quiet_share: float = 0.25  # Share of the windows in the air below whose noise it is taken.
    noise_lag: float = 0.04  # s between the samples of a difference: 6 to 12 Hz, no motion.
    repeated_share: float = 0.3  # Of the samples: a channel slower than the grid.
    min_converter_steps: float = 8.0  # Steps that a channel goes: fewer are moves, no rounding.
    max_windows: int = 400  # Windows kept; beyond, every second one is dropped.
    engine_running_speed: float = 100.0  # Above this speed, rad/s, an engine runs.

    # Rapid moves of surfaces.
    input_end_pause: float = 1.3  # s without a quick move that end an input in trim ...
    input_end_pause_displaced: float = 2.6  # ... or off trim: longest step.
    secondary_input_ratio: float = 0.25  # To the quickest input, as shares of travel.
    min_rapid_move: float = 0.02  # Share of half the travel that a quick move takes at least.
    min_rapid_move_assumed_travel: float = 0.005  # The same of a travel that no file states.
    rapid_move_over_noise: float = 7.0  # Times the noise that a rapid move takes at least ...
    move_over_converter_step: float = 1.5  # Steps of a coarse converter: one is no move.
    rapid_move_over_steering: float = 3.0  # ... and times the usual steering of the flight.
    steering_quantile: float = 0.8  # Quantile of the moves per frame that is the usual steering.
    steering_frames: int = 240  # Frames of steering remembered for each surface: two minutes.
    min_steering_frames: int = 12  # Frames that it takes to know the steering.
    abrupt_share: float = 0.35  # Of the excursion of a doublet or 3-2-1-1 in `look_back` ...
    abrupt_share_other: float = 0.5  # ... and any other shape.
    sudden_share: float = 0.9  # No steering takes so much of its excursion in `look_back`.
    step_share: float = 0.35  # Of its quickest move: a step of the same input.
    first_step_search: float = 1.5  # s searched before the first quick move.
    certain_step_ratio: float = 1.3  # Over the threshold: a certain step, if sudden ...
    certain_step_ratio_other: float = 4.0  # ... or else, out of calm or of another shape.
    calm_before: float = 0.1  # Motion before an input over its amplitude: out of perfect calm ...
    calm_abrupt_ratio: float = 0.6  # ... its steps may be less abrupt, by this factor ...
    calm_hand: float = 0.15  # ... and a stick that moves less, of its amplitude, is no hand.
    hands_off: float = 0.4  # Seconds without a stick after a doublet or 3-2-1-1 ...
    hands_off_other: float = 1.0  # ... and after any other shape.

    # Moves of throttle and flap.
    min_lever_move: float = 0.2  # Share of half the travel that an input moves a lever at least.
    lever_rest: float = 0.04  # Share of half the travel within which a lever rests.
    lever_stick_share: float = 0.1  # Share of half its travel that a surface moves meanwhile.
    lever_rest_frames: int = 4  # Frames of rest before and after an input.

    # Shape of an input.
    look_back: float = 0.15  # s: a deliberate move goes far within.
    trim_at_edge: float = 0.1  # s at either end of a stretch that may begin and end with an input.
    trim_before_input: float = 0.8  # s before an input in which the surface is trimmed.
    displaced_share: float = 0.35  # Of the largest excursion: displaced beyond.
    begin_share: float = 0.1  # Share of the largest excursion at which an input begins.
    smoothing: float = 0.05  # Width of the moving mean over a deflection, s.
    min_displacement_time: float = 0.06  # A surface displaced for less, s, made no step.
    max_edge_time: float = 0.4  # s, from one side to the other.
    max_hold_time: float = 3.0  # s to one side: longer is a new trim.

    # Maneuvers of a flight.
    min_sample_rate: float = 8.0  # Fewer samples a second do not show the steps of an input.
    takeoff_settling_time: float = 6.0  # s after take-off that do not count.
    landing_margin: float = 4.0  # Seconds before a landing that belong to flare and touch-down.
    max_input_duration: float = 10.0  # s: longer is steering.
    max_free_response: float = 5.0  # s of response after an input, at most.
    history_duration: float = 40.0  # Seconds of frames kept for judging an input.
    min_response: float = 8.0  # Peak to peak over the noise: more than on the ground.
    short_flight_duration: float = 60.0  # s: a shorter flight is one maneuver.
    max_cut_duration: float = 120.0  # s: a stretch of flight around one input, cut by somebody.
    max_gap: float = 1.0  # s without any sample: the record was joined, or lost.
    moved_over_noise: float = 6.0  # Peak-to-peak deflection over noise: moved ...
    moved_share: float = 0.015  # ... and the least share of half the travel.
    same_edge_tolerance: float = 1e-6  # Seconds between edges that are the same.
    same_maneuver_share: float = 0.5  # Overlap of the shorter one: same maneuver.

    # Grade of a maneuver.
    response_time: float = 1.0  # How long after an input its answer is looked for, s.
    trim_time: float = 1.0  # Length of the stretch before an input that belongs to the maneuver, s.
    min_free_response_time: float = 2.0  # Length of the free answer that an estimate lives from, s.
    rest_after_input: tuple[float, float] = (0.1, 0.6)  # s after it: the surface is at rest.
    min_graded_samples: int = 40  # As many as an estimate takes.


DETECTION: Final = ManeuverDetectionSettings()
