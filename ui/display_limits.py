"""Limits of judgment of the window: what is stale, what is said, what counts as seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayLimits:
    """Engineering choices; times in s."""

    # Old data.
    data_timeout: float = 1.0  # Without a sample, until the charts move on.
    min_stale_age: float = 3.0  # Least age of a stale value, s.
    channel_wait: float = 3.0  # Of a live flight, until silent channels are absent.
    no_volts_time: float = 1.5  # Without volts, until none are shown or taken.
    max_channel_delay: float = 2.0  # Wait for a channel that does not come.
    stale_reading_age: float = 2.0  # Seconds after which a value is not one of now.
    residual_rounding: float = 1e-6  # In the unit of an instrument: no residual.

    # Pilot and voice.
    max_cue_age: float = 1.0  # Without a sample, until cues are withdrawn.
    min_text_time: float = 0.5  # Seconds for which words stand at least.
    deliberate_share: float = 0.5  # Of the least amplitude wanted: shown as an input.
    short_leg_time: float = 4.0  # Left of a leg, to be highlighted.
    max_speech_delay: float = 1.5  # Of flight, after which speech is dropped.
    repeat_interval: float = 10.0  # Until the same words may be repeated.
    warning_interval: float = 2.0  # Between sounds of an unacknowledged warning.

    # Estimates.
    bar_sigmas: float = 2.0  # Half the length of a bar, in bounds: 95 %.
    history_sigmas: float = 5.0  # Half the height of a history, in bounds as they stand now.
    max_scatter_ratio: float = 1.4  # Scatter over bounds from which it is said.
    min_scatter_values: int = 3  # Values from which their scatter says something.
    min_observable_sigmas: float = 3.0  # Below, an effect could not have shown.
    map_levels: tuple[float, float, float, float] = (1.5, 2.5, 5.0, 10.0)
    """Times the noise floor: next color."""


DISPLAY: Final = DisplayLimits()
