"""Settings of decoding: the clock of the vehicle, the grid, and the health of a link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodingSettings:
    """Engineering choices unless a source is named; times in microseconds unless in seconds."""

    # Clock of the vehicle.
    max_stamp_delay: int = 2_000_000
    """A stamp may be so much older than the newest one before it: reordered, not restarted."""
    max_stamp_lead: int = 1_500_000
    """A stamp may be so much newer than the time that has passed on the host."""
    confirm_count: int = 5
    """So many stamps must agree before a clock is believed to have been set ..."""
    confirm_span: int = 500_000  # ... over so much of its own time ...
    confirm_host: int = 5_000_000  # ... or of the host's if it stands still.
    max_set_back: int = 60_000_000
    """A clock that shows at most so much less than before was set; by more, it began anew at
    zero."""
    same_clock_tolerance: int = 5_000_000
    """Two clocks that agree within this much are the same clock."""
    max_pause: int = 3_600_000_000
    """A clock that jumps ahead by less is a pause of the link; by more, it was set."""
    frozen_clock_time: int = 3_000_000
    """A clock that shows the same after so much time on the host stands still."""
    max_clock_drift: float = 2e-4
    """How fast the two clocks may drift apart; crystals do 1e-4 at worst."""
    max_held_stamps: int = 16  # Stamps held of a clock that is not confirmed yet.
    first_stamp_timeout: int = 30_000_000
    """How long messages without a stamp wait for the first one with a stamp, host time."""
    min_host_clock_step: int = 30_000_000
    """A delay that grows by so much, and stays, is a host clock that was set."""
    give_up_interval: int = 30_000_000  # Interval at which rows that still wait are given up.
    autopilot_timeout: int = 3_000_000
    """How long measurements of other components wait for an autopilot: it sends a heartbeat every
    second."""
    chunk_timeout: int = 5_000_000  # How long the next piece of a text is waited for.

    # Grid.
    max_hold: int = 30_000_000  # How long a slow input stands for itself.
    max_filled_pause: float = 60.0
    """Seconds of a pause that are filled with NaN rows; after a longer one rows just go on."""
    period_window: int = 9  # Intervals between samples whose median is the period of a channel.
    unknown_period: int = 1_000_000  # Period of a channel of one sample.
    range_margin: float = 1e-3
    """Share of its range from the end that counts as the end: a converter rounds the rail to a
    count."""

    # Health of a link.
    sequence_window: int = 128
    """Frames behind the newest by up to this many sequence numbers are late or doubled, not new."""
    max_sequence_step: int = 16
    """Frames that leap or lag by more than this do not belong to one undisturbed sequence."""
    rate_span: int = 2_000_000  # Time over which a rate is counted.
    offset_span: int = 60_000_000  # Time over which the least delay is taken.
    mixed_frames: int = 200
    """Frames of a sender after which it is judged whether two share its id ..."""
    mixed_share: float = 0.25  # ... by the share of frames out of sequence, or ...
    uncounted_share: float = 0.8
    """... it does not count its frames, by the share of repeated numbers."""
    foreign_headers: int = 20
    """So many headers of one message without one whose checksum fits are no accident."""
    unreadable_bytes: int = 1000  # What cannot be read is told after so many bytes ...
    unreadable_time: int = 3_000_000  # ... and so long since something could.
    chance_factor: int = 4
    """A frame of unknown id or a line of text may be chance, as it happens where the baud rate is
    wrong: it stands against this many times its own bytes only."""


DECODING: Final = DecodingSettings()
