"""Settings of what watches a flight that is recorded or replayed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionMonitorSettings:
    """Engineering choices; times in s."""

    # Update intervals.
    events_interval: float = 0.25  # Interval at which the events file is read.
    memory_interval: float = 10.0  # Interval at which memory is given back.
    recorder_interval: float = 0.25  # Interval at which the recorder's state is read.
    disk_timeout: float = 2.0  # After which a disk that does not respond is told.
    info_interval: float = 1.0  # Seconds between looks at the flight card on the disk.
    file_interval: float = 0.002  # Seconds between two looks at the record: three sizes of files.
    file_reread: float = 0.1  # Interval at which small files are read again.
    file_wait: float = 0.2  # Seconds that who asks for something waits for the disk.
    file_retry: float = 1.0  # Interval at which reading a record that failed is tried again.
    consumer_retry: float = 1.0  # Seconds after which what failed in a live flight is tried again.

    # Samples to those who watch.
    delivery_interval: float = 0.04  # Between two steps of alarms, cues and estimates, live.
    max_rows: int = 512  # Rows of the grid given at a time where nothing holds anybody up.
    max_delay: float = 1.0  # s of flight behind that still count as up to date.
    max_filled_pause: float = 60.0  # s without a sample that belong to a flight.
    min_step: float = 0.25  # s of flight given at a time, as time allows: at least ...
    max_step: float = 1.0
    """... and at most. What is due some seconds after an event, such as a forecast, is never due
    in the very step of the event."""
    max_tick: float = 1.0  # s of replay between two calls at single speed, at most.
    max_progress: float = 0.99  # The most that is told to be watched while the rest is not.
    read_ahead: float = 5.0  # s read ahead of the playhead: slow messages are late.
    map_guess_us: int = 3_000_000  # Part of a record that tells its channel map ...
    map_guess_records: int = 20_000  # ... or so many records.

    # Stale channels.
    stale_periods: float = 3.0  # Sample periods after which a channel is stale, but ...
    min_stale_time: float = 0.5  # ... not before ...
    max_stale_time: float = 10.0  # ... and not after so many seconds.
    default_stale_time: float = 1.5  # Where the rate of a channel is not known.

    # Alarms and cues.
    same_alarm_time: float = 10.0  # Within it, two windows raise the same alarm.
    same_input_time: float = 0.5  # Within it, two windows judge the same input.
    min_limit_time: float = 0.1  # Time beyond a limit, by default: one spike is no alarm.
    near_ground_height: float = 6.0  # m above the place of take-off.
    ground_altitude_time: float = 5.0  # On the ground: its median is ground altitude ...
    min_ground_time: float = 1.0  # ... or what there is of them, but no less than this.
    near_ground_window: float = 0.5  # More than half of it near the ground: noise.

    # Link, recorder, disk.
    equipment_interval: float = 0.5  # Of reading the recorder's state.
    max_update_gap: float = 1.0  # s between updates; after a longer one files are read again first.
    no_data_time: float = 5.0  # Without the aircraft, until the reason is shown.
    clock_set_back_us: int = 1_000_000  # Of the computer's clock, until it is shown.
    recorder_timeout: float = 5.0  # Seconds without a word of the recorder after which it hangs.
    silence_time: float = 3.0  # Seconds without data after which a link is silent.
    loss_window: float = 10.0  # Seconds over which lost frames are counted ...
    max_loss: float = 0.1  # ... the share of them that is told ...
    min_loss_frames: int = 50  # ... among so many frames at least.
    low_disk_time: float = 1800.0  # Seconds of recording left on the disk from which it is told ...
    low_disk_bytes: float = 500e6  # ... and bytes left.
    full_disk_time: float = 600.0  # The same from which it is an alarm ...
    full_disk_bytes: float = 50e6  # ... and bytes left.

    # Landing.
    default_flying_speed: float = 12.0  # m/s, without an aircraft file.
    slow_ratio: float = 0.5  # To the flying speed: no stall or wind stays below it.
    max_ground_rate: float = 4.0 * DEGREE  # Mean pitch or roll rate on wheels, rad/s.
    max_altitude_change: float = 4.0  # Most that the altitude of a standing aircraft wanders, m.
    max_ground_height: float = 20.0  # m above take-off, without ground speed.
    reported_ground_frames: int = 2  # Slow frames with the autopilot's report.
    standing_frames_alone: int = 40  # Frames where only airspeed tells.
    min_flown_frames: int = 10  # Frames that must have flown before a landing.
    standing_frames: int = 6  # Slow frames with height or ground speed.

    # Checklist.
    stick_center: float = 0.1  # A stick within this of its middle is let go.
    surface_settling_time: float = 0.25  # Of a surface after its stick.
    min_mean_time: float = 0.1  # Seconds of a settled surface that make a mean.
    engine_settling_time: float = 2.0  # Seconds after which engines have followed the throttle.
    stopped_ratio: float = 0.3  # Engines slower than this share of the lower bound do not run.
    pulse_end_share: float = 1.0 / 3.0  # Of the least size: a pulse ends.
    rest_time_constant: float = 1.0  # Time constant with which the place of rest is followed, s.
    sample_delay: float = 0.5  # Newest samples left for later: channels differ in delay.
    max_samples_time: float = 5.0  # Samples taken in one update, at most.

    # Live estimates.
    maneuver_margin: float = 1.0  # Beside a maneuver, for time shifts.
    min_reported_change: float = 0.05  # Share of a bound by which it must change to be told.
    max_history_points: int = 1000  # Of an FTR history on screen, however long the flight.
    maneuver_delay: float = 3.0  # After a maneuver, until slow samples came.
    early_search: int = 9  # Maneuvers up to which what a search names must be confirmed.
    search_confirmation: int = 3  # Further maneuvers over which searches then name it.
    estimate_interval: float = 0.5  # s of flight that FTR takes in at a time, at least.
    max_attempts: int = 2  # Of a fit whose process died: the cause may be elsewhere.
    min_maneuver_duration: float = 0.5  # A shorter one shows no motion.


MONITORS: Final = SessionMonitorSettings()
