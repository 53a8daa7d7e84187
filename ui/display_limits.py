"""Limits of judgment of the window: what is stale, what is said, what counts as seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayLimits:
    """Engineering choices; times in s."""

    # Old data.
    data_timeout: float = 1.0
    """Seconds without a sample after which the charts move on without one."""
    min_stale_age: float = 3.0  # Least age of a stale value, s.
    channel_wait: float = 3.0
    """Seconds of a live flight after which channels without a sample are taken for absent."""
    no_volts_time: float = 1.5
    """Seconds without volts after which none are shown, and none can be taken."""
    max_channel_delay: float = 2.0
    """Seconds after which a channel that does not come is not waited for."""
    stale_reading_age: float = 2.0  # Seconds after which a value is not one of now.
    residual_rounding: float = 1e-6
    """In the unit of an instrument: a residual below that is the computer's, of a line through
    two."""

    # Pilot and voice.
    max_cue_age: float = 1.0
    """Seconds without a sample after which what was said last does not stand any more."""
    min_text_time: float = 0.5  # Seconds for which words stand at least.
    deliberate_share: float = 0.5
    """Share of the least amplitude wanted, from which a move shows as an input while it is made."""
    short_leg_time: float = 4.0
    """Seconds of leg below which its number is marked; what an input needs, the state knows."""
    max_speech_delay: float = 1.5
    """Seconds of flight after which something is not said any more: it was true a while ago."""
    repeat_interval: float = 10.0
    """Seconds after which the very same words may follow upon themselves."""
    warning_interval: float = 2.0
    """Seconds between the sounds of a warning that nobody has acknowledged."""

    # Estimates.
    bar_sigmas: float = 2.0  # Half the length of a bar, in bounds: 95 %.
    history_sigmas: float = 5.0  # Half the height of a history, in bounds as they stand now.
    max_scatter_ratio: float = 1.4  # Scatter over bounds from which it is said.
    min_scatter_values: int = 3  # Values from which their scatter says something.
    min_observable_sigmas: float = 3.0
    """Standard deviations below which these flights could not have shown an effect."""
    map_levels: tuple[float, float, float, float] = (1.5, 2.5, 5.0, 10.0)
    """Times the noise floor at which a cell of the map takes the next color."""


DISPLAY: Final = DisplayLimits()
