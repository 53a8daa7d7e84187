"""Settings of maneuver detection and grading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverDetectionSettings:
    """Engineering choices, checked by `tests/bench/detection.py` and `tests/bench/verdicts.py`."""

    # Airborne or not, frame by frame.
    frame_duration: float = 0.5  # Length of one frame, s; decisions are made at its end.
    max_lift_coefficient: float = 1.2
    """Greatest lift coefficient assumed where the aircraft file gives no stall speed."""
    takeoff_speed_ratio: float = 1.05  # Speed over the stall speed above which the aircraft flies.
    landing_speed_ratio: float = 0.9  # Speed over the stall speed below which it has landed.
    standing_speed_ratio: float = 0.3
    """Speed over the stall speed below which it stands, in any wind."""
    frames_to_change: int = 2  # Frames that must contradict the present state.
    frames_to_reject_airspeed: int = 12
    """Frames of turning at a low airspeed after which the airspeed is not believed."""
    airborne_rate: float = 4.0 * DEGREE
    """Mean pitch or roll rate over a frame that wheels do not allow, rad/s."""
    still_rate: float = 2.5 * DEGREE  # Mean pitch or roll rate of an aircraft that stands, rad/s.
    min_airborne_rate_frames: int = 4  # Frames beyond `airborne_rate` that show flight ...
    airborne_rate_window: int = 16  # ... among so many.
    still_frames_to_land: int = 40  # Still frames near the ground after which it has landed.
    still_frames_at_end: int = 6  # The same at the end of a record.
    min_climb: float = 12.0  # Above the ground it stood on, m: more than static pressure wanders.
    ground_altitude_frames: int = 8  # Still frames whose altitude is that of the ground.
    max_ground_height: float = 6.0  # Height above the ground, m, below which it may stand on it.

    # Clipped and dead instruments.
    range_margin: float = 0.01
    """Share of its range from the end within which an instrument is clipped."""
    dead_share: float = 0.95
    """Share of a maneuver's samples at the end of the range from which an instrument is dead."""
    beyond_travel_share: float = 0.5
    """Share of its travel that no surface ever goes beyond it: what reads more is a broken wire."""
    min_speed_ratio: float = 0.3
    """An aircraft that answers to its surfaces flies faster than this share of its stall speed."""
    min_clipped_samples: int = 20  # Samples that it takes to call an instrument dead at its limit.
    min_stuck_samples: int = 40
    """Among so many samples noise reaches over four of its standard deviations."""
    partner_movement: float = 1.0 * DEGREE
    """A half of a surface that stays where it is while the other moves so far, rad, is stuck."""
    same_value_tolerance: float = 1e-9
    """Share of its size that a value may change by, brought to another time, and still be the
    same."""

    # Noise floor.
    noise_window: float = 2.0  # Length of one window of the noise floor, s.
    takeoff_windows: int = 8
    """Windows dropped before being recognized as airborne: the take-off run is no quiet stretch."""
    min_ground_windows: int = 2  # Windows with engines running that give the noise on the ground.
    quiet_share: float = 0.15  # Share of the windows in the air that count as quiet.
    max_windows: int = 400  # Windows kept; beyond, every second one is dropped.
    engine_running_speed: float = 100.0  # Above this speed, rad/s, an engine runs.

    # Rapid moves of surfaces.
    input_end_pause: float = 1.3
    """Seconds without a quick move after which an input is over, if the surfaces are back."""
    input_end_pause_displaced: float = 2.6
    """The same if they are not: the longest step of an input."""
    secondary_input_ratio: float = 0.25
    """An input this quick beside the quickest, both as shares of travel, belongs to the
    maneuver."""
    min_rapid_move: float = 0.02  # Share of half the travel that a quick move takes at least.
    rapid_move_over_noise: float = 7.0  # Times the noise that a rapid move takes at least ...
    rapid_move_over_steering: float = 3.0  # ... and times the usual steering of the flight.
    steering_quantile: float = 0.8  # Quantile of the moves per frame that is the usual steering.
    steering_frames: int = 240  # Frames of steering remembered for each surface: two minutes.
    min_steering_frames: int = 12  # Frames that it takes to know the steering.
    abrupt_share: float = 0.35
    """Share of its excursion that a doublet or 3-2-1-1 covers within `look_back` ..."""
    abrupt_share_other: float = 0.5  # ... and any other shape.
    step_share: float = 0.35
    """Share of the quickest move of a surface that the steps of one input reach."""
    first_step_search: float = 1.5
    """Seconds before the first quick move in which the first step is looked for."""
    certain_step_ratio: float = 1.3
    """A step from side to side is no accident this far over the threshold of a quick move."""
    hands_off: float = 0.4  # Seconds without a stick after a doublet or 3-2-1-1 ...
    hands_off_other: float = 1.0  # ... and after any other shape.

    # Shape of an input.
    look_back: float = 0.15
    """A surface that goes a good way within this time, s, is moved on purpose."""
    trim_before_input: float = 0.8
    """Length of the stretch before an input in which the surface is trimmed, s."""
    displaced_share: float = 0.35
    """Share of the largest excursion beyond which the surface is held to one side."""
    begin_share: float = 0.1  # Share of the largest excursion at which an input begins.
    smoothing: float = 0.05  # Width of the moving mean over a deflection, s.
    min_displacement_time: float = 0.06  # A surface displaced for less, s, made no step.
    max_edge_time: float = 0.4
    """The most that a surface takes from one side to the other in one go, s."""
    max_hold_time: float = 3.0
    """A surface held to one side for longer, s, was retrimmed and not displaced."""

    # Maneuvers of a flight.
    min_sample_rate: float = 8.0  # Fewer samples a second do not show the steps of an input.
    takeoff_settling_time: float = 6.0
    """Seconds after take-off in which the pilot is busy with flying."""
    landing_margin: float = 4.0  # Seconds before a landing that belong to flare and touch-down.
    max_input_duration: float = 10.0
    """An input that goes on for longer, s, is steering, from which to learn."""
    max_free_response: float = 5.0
    """Length of the answer after the input that belongs to the maneuver at most, s."""
    history_duration: float = 40.0  # Seconds of frames kept for judging an input.
    min_response: float = 8.0
    """Peak-to-peak answer over the noise floor that a standing aircraft does not give."""
    short_flight_duration: float = 60.0
    """A flight shorter than this, s, with one maneuver at most is that maneuver, whole."""
    moved_over_noise: float = 6.0
    """Peak-to-peak deflection over its noise from which a surface moved ..."""
    moved_share: float = 0.015  # ... and the least share of half the travel.
    same_edge_tolerance: float = 1e-6  # Seconds between edges that are the same.
    same_maneuver_share: float = 0.5
    """Share of the shorter of two stretches that both hold if they are the same maneuver."""

    # Grade of a maneuver.
    response_time: float = 1.0  # How long after an input its answer is looked for, s.
    trim_time: float = 1.0  # Length of the stretch before an input that belongs to the maneuver, s.
    min_free_response_time: float = 2.0  # Length of the free answer that an estimate lives from, s.
    faint_response: float = 12.0
    """Peak-to-peak answer over the noise floor below which nothing can be learned ..."""
    weak_response: float = 25.0  # ... and below which little can be.
    max_trim_rate: float = 6.0 * DEGREE
    """Mean rate before the input, rad/s, from which it was not trimmed."""
    max_rate_before_input: float = 15.0 * DEGREE  # The same from which it was maneuvering.
    min_graded_samples: int = 50  # Samples that a grade takes.


DETECTION: Final = ManeuverDetectionSettings()
