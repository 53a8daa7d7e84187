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
