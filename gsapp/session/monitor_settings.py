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
    file_wait: float = 0.2  # Seconds that who asks for something waits for the disk.
    file_retry: float = 1.0  # Interval at which reading a record that failed is tried again.
    consumer_retry: float = 1.0  # Seconds after which what failed in a live flight is tried again.

    # Samples to those who watch.
    max_rows: int = 512  # Rows of the grid given at a time where nothing holds anybody up.
    max_delay: float = 1.0
    """Seconds of flight by which one may be behind and still count as being there."""
    max_filled_pause: float = 60.0
    """Seconds without a sample that belong to a flight; longer pauses are passed over."""
    min_step: float = 0.25
    """Seconds of flight given at a time, as the time of those who watch allows: at least ..."""
    max_step: float = 1.0
    """... and at most. What is due some seconds after something happened, such as a look ahead, is
    never due in the very step in which it happened."""
    max_tick: float = 1.0
    """Seconds that a replay moves on at most between two calls, at single speed."""
    max_progress: float = 0.99  # The most that is told to be watched while the rest is not.
    read_ahead: float = 5.0
    """Seconds that reading must be ahead of the playhead: slow messages arrive late."""
    map_guess_us: int = 3_000_000
    """Microseconds of a record from which its channel map is guessed ..."""
    map_guess_records: int = 20_000  # ... or so many records.

    # Stale channels.
    stale_periods: float = 3.0  # Sample periods after which a channel is stale, but ...
    min_stale_time: float = 0.5  # ... not before ...
    max_stale_time: float = 10.0  # ... and not after so many seconds.
    default_stale_time: float = 1.5
    """Seconds after which a channel is stale whose usual rate is not known."""

    # Alarms and cues.
    same_alarm_time: float = 10.0
    """What two windows say of the equipment within this time is the same alarm."""
    same_input_time: float = 0.5
    """Verdicts on inputs begun within so many seconds are the same, whichever window gave them."""
    min_limit_time: float = 0.1
    """Seconds that a value must stay beyond a limit by default: one spike is no alarm."""
    near_ground_height: float = 6.0
    """Height above the place of take-off that counts as near the ground, m."""
    ground_altitude_time: float = 5.0
    """Seconds of standing and rolling whose median altitude is that of the ground ..."""
    min_ground_time: float = 1.0  # ... or what there is of them, but no less than this.
    near_ground_window: float = 0.5
    """Seconds of which more than half must be near the ground: barometers are noisy."""

    # Link, recorder, disk.
    equipment_interval: float = 0.5
    """Seconds between looks at the recorder's state, which it writes as often."""
    no_data_time: float = 5.0
    """Seconds without a sign of the aircraft after which the crew is told what is wrong."""
    clock_set_back_us: int = 1_000_000
    """By how much the computer's clock must be set back for the crew to be told."""
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
    default_flying_speed: float = 12.0
    """Airspeed below which no aircraft of this kind flies, m/s, where no aircraft file tells."""
    slow_ratio: float = 0.5
    """Of the flying speed: a stall or a strong wind does not bring it below that for long."""
    max_ground_rate: float = 4.0 * DEGREE
    """Greatest mean pitch or roll rate of an aircraft on its wheels, rad/s."""
    max_altitude_change: float = 4.0  # Most that the altitude of a standing aircraft wanders, m.
    max_ground_height: float = 20.0
    """Greatest height above the place of take-off, m, where no ground speed tells."""
    reported_ground_frames: int = 2
    """Slow frames for which the autopilot must report ground, or have disarmed."""
    standing_frames_alone: int = 40
    """Frames where neither height nor ground speed confirms an airspeed that a fault can zero."""
    min_flown_frames: int = 10  # Frames that must have flown before a landing.
    standing_frames: int = 6
    """Slow frames after which it has landed, height or ground speed confirming."""

    # Checklist.
    stick_center: float = 0.1  # A stick within this of its middle is let go.
    surface_settling_time: float = 0.25
    """Seconds after which a surface has arrived where its stick wants it."""
    min_mean_time: float = 0.1  # Seconds of a settled surface that make a mean.
    engine_settling_time: float = 2.0  # Seconds after which engines have followed the throttle.
    stopped_ratio: float = 0.3  # Engines slower than this share of the lower bound do not run.
    pulse_end_share: float = 1.0 / 3.0
    """A pulse ends where the surface is back within this share of its least size."""
    rest_time_constant: float = 1.0  # Time constant with which the place of rest is followed, s.
    sample_delay: float = 0.5
    """Seconds of the newest samples left for the next look: channels do not arrive side by side."""
    max_samples_time: float = 5.0
    """Seconds of samples taken in by one look at most, so that none holds up the window."""

    # Live estimates.
    maneuver_margin: float = 1.0
    """Seconds beside a maneuver that bringing late channels to their time may reach into."""
    min_reported_change: float = 0.05  # Share of a bound by which it must change to be told.
    maneuver_delay: float = 3.0
    """Seconds of flight after a maneuver when all its samples have surely come, slow ones too."""
    max_attempts: int = 2
    """A fit whose process died is begun anew: another fit may have been to blame, or the system."""
    min_maneuver_duration: float = 0.5
    """A maneuver shorter than this, s, shows no motion of the aircraft."""


MONITORS: Final = SessionMonitorSettings()
