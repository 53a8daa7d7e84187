"""Settings of the cues: how samples become rows, and when a crew is told what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class CueSettings:
    """Engineering choices."""

    # Rows of samples.
    tick: float = 0.05  # Rows come in whole ticks of so many seconds, counted from time zero.
    max_channel_wait: float = 0.3  # Seconds that a row waits for a quick channel.
    slow_channel_delay: float = 0.5  # Seconds by which slow channels are late.
    max_value: float = 1e7
    """No channel reads more, whatever its unit; what does is a damaged number."""
    max_filled_pause: float = 5.0  # A pause longer than this, s, begins a new stretch of rows.
    rows_retention: float = 60.0
    """Seconds of rows kept: the longest input with its second of trim and its answer is shorter."""

    # Cards.
    selection_interval: int = 10
    """Ticks from one look at the rows to the next: a point is held for seconds."""
    density_samples: int = 200  # Samples of the air density whose mean is that of the day.
    same_speed: float = 1.0
    """Inputs without a card are judged by the same wants within so many m/s."""
    reaction_time: float = 1.0  # Seconds from GO to the first move of the stick.

    # Cues.
    go_delay: float = 0.3  # Seconds after what is known of an input until GO may be given again.
    replay_ticks: int = 4
    """More ticks in one step than a live flight brings: a record is being read."""
    display_averaging: float = 0.5
    """Seconds over which the speed and the angle of attack shown are the mean."""
    cue_retention: float = 60.0  # Seconds of cues kept.
    go_memory: float = 2.0
    """Seconds after GO was lost in which an input still answers to it: a hand takes its time."""
    verdict_display_time: float = 6.0
    """Seconds for which a verdict is the news: until then the pilot is busy with the recovery."""

    # Announcements.
    deviation_interval: float = 1.5
    """Seconds between two things that are off: a pilot mends one after the other."""
    deviation_growth: float = 1.5
    """What is off is news again once it is so many times what was said."""
    min_repeat_interval: float = 3.0
    """Seconds after which the same thing may be said with another number."""
    repeat_intervals: tuple[float, float, float, float] = (5.0, 10.0, 20.0, 40.0)
    """Seconds until the same words are said again, the first time, the second time ..."""
    max_announced_ratio: float = 3.0
    """What is off by more than so many tolerances is seen by every pilot: he is on his way."""
    roll_out_time: float = 2.0  # Seconds after a turn in which a pilot still rolls out of it.
    recovery_time: float = 3.0  # Seconds after a verdict that belong to it, and to flying on.
    verdict_silence: float = 1.5  # Seconds after a hands-off interval that are left to its verdict.
    note_silence: float = 2.5  # Seconds without a word before a note is said.
    plot_rate: float = 25.0
    """Samples a second of the curves kept: a half of a doublet lasts ten of them."""

    # Estimates in flight.
    maneuver_delay: float = 3.0
    """Seconds after a maneuver when all of it was surely heard, late channels too."""
    work_slice: float = 0.003
    """Seconds of work on what comes next that a step of a session may take."""
    forecast_interval: int = 10
    """Ticks from one look ahead to the next; the time left is told in seconds."""
    forecast_margin: float = 0.6
    """Seconds after which the look that follows the work was surely taken."""


CUES: Final = CueSettings()
