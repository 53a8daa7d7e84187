"""Settings of decoding: the clock of the vehicle, the grid, and the health of a link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodingSettings:
    """Engineering choices unless a source is named; times in microseconds unless in seconds."""

    # Clock of the vehicle.
    max_stamp_delay: int = 2_000_000  # Behind the newest stamp: reordered, not restarted.
    max_stamp_lead: int = 1_500_000  # Ahead of the time that passed on the host.
    confirm_count: int = 5  # Stamps that must agree before a clock counts as set ...
    confirm_span: int = 500_000  # ... over so much of its own time ...
    confirm_host: int = 5_000_000  # ... or of the host's if it stands still.
    max_set_back: int = 60_000_000  # A clock set back by more restarted at zero.
    same_clock_tolerance: int = 5_000_000  # Clocks this close are the same clock.
    max_pause: int = 3_600_000_000  # A longer jump ahead is no pause: the clock was set.
    frozen_clock_time: int = 3_000_000  # Time on the host after which a clock is frozen.
    max_clock_drift: float = 2e-4  # Between the two clocks; crystals do 1e-4 at worst.
    max_held_stamps: int = 16  # Stamps held of a clock that is not confirmed yet.
    first_stamp_timeout: int = 30_000_000  # Messages without a stamp wait so long for one.
    min_backlog: int = 1_000_000  # Delay from which a link delivers what it kept back.
    min_host_clock_step: int = 30_000_000  # A lasting step of the delay: host clock set.
    give_up_interval: int = 30_000_000  # Interval at which rows that still wait are given up.
    autopilot_timeout: int = 3_000_000  # Wait for an autopilot: it sends a heartbeat a second.
    sender_timeout: int = 3_000_000  # Silence after which another port of a host takes over.
    rejection_time: int = 10_000_000  # For which a rejected sender counts as present.
    max_rejected_senders: int = 64  # Told apart; a flood of forged addresses fills no memory.
    chunk_timeout: int = 5_000_000  # How long the next piece of a text is waited for.

    # Messages without a stamp that come in bursts.
    burst_window: int = 24  # Intervals between arrivals that tell, ...
    min_burst_intervals: int = 8  # ... at least.
    burst_ratio: int = 5  # The usual interval is so much shorter than the mean one.
    min_bursts: int = 2  # So many long intervals among them.

    # Grid.
    max_hold: int = 30_000_000  # How long a slow input stands for itself.
    max_filled_pause: float = 60.0  # Seconds of a pause that are filled with NaN rows.
    period_window: int = 9  # Intervals between samples whose median is the period of a channel.
    unknown_period: int = 1_000_000  # Period of a channel of one sample.
    max_native_numbers: int = 250_000_000  # Rows times channels at their own times: 2 GB.
    range_margin: float = 1e-3  # Share of the range that counts as its end: ADC rounding.

    # Health of a link.
    sequence_window: int = 128  # Frames this far behind the newest are late or doubled.
    max_sequence_step: int = 16  # Larger steps do not belong to one sequence.
    rate_span: int = 2_000_000  # Time over which a rate is counted.
    usual_spans: int = 15  # So many of the last rates tell the usual one.
    offset_span: int = 60_000_000  # Time over which the least delay is taken.
    mixed_frames: int = 200  # Frames after which it is judged whether two share an id ...
    mixed_share: float = 0.25  # ... by the share of frames out of sequence, or ...
    uncounted_share: float = 0.8  # ... it does not count its frames, by repeated numbers.
    foreign_headers: int = 20  # Headers of one message with wrong checksums: foreign.
    unreadable_bytes: int = 1000  # What cannot be read is told after so many bytes ...
    unreadable_time: int = 3_000_000  # ... and so long since something could.
    chance_factor: int = 4
    """A frame of unknown id or a line of text may be chance, as with a wrong baud rate: it
    outweighs this many times its own bytes only."""


DECODING: Final = DecodingSettings()
