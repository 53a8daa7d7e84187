"""Settings of the calibration wizard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardSettings:
    """Engineering choices, checked by `tests/bench/wizard.py`."""

    start_time: float = 2.0
    """Seconds of samples that are looked at before the first instrument is asked for."""
    max_gap: float = 1.0
    """Seconds without samples, or back in time, after which a movement may have gone unseen."""
    slice_duration: float = 0.1  # Of a slice, s.
    clock_restart: float = 1.0
    """Seconds back in time that mean that the aircraft's clock began anew."""
    rest_timeout: float = 20.0
    """Seconds that it takes to lay an aircraft down before anything is said."""
    reason_interval: float = 5.0  # Seconds between two reasons.
    max_means: int = 3000  # Means that are kept: five minutes of tenths of a second.

    # Angles set by hand.
    min_volts_apart: float = 0.02
    """Volts from a rest that count as elsewhere: half a degree on most instruments."""
    same_setting_volts: float = 0.06  # Volts from a point within which no other setting lies.
    known_share: float = 0.05
    """Of the certificate's 95 % bound: a mean known as well as that adds nothing to it that
    shows."""
    min_stds_apart: float = 6.0  # The same in standard deviations of the mean.
    min_sign_movement: float = 0.15
    """Volts that a movement must have so that it proves a sign: about four degrees."""
    sign_hold: float = 1.0  # Seconds that it must be held.
    hold: float = 1.1
    """Seconds that a rest must last before it is taken by itself: longer than the mean that is
    taken, for a hand creeps up to its mark, and up and down that would look like slop."""
    unsure_hold: float = 1.5  # The same where nothing tells whether it is the setting asked for.
    min_averaging: float = 0.3  # Seconds of rest that are averaged at least ...
    confirmed_hold: float = 0.6
    """... and that it must last where the certificate in force says so: all that is left to find
    out is whether that holds."""
    near_share: float = 0.3
    """Share of the distance between settings within which a rest is meant to be one, by two points
    or more ..."""
    near_share_one: float = 0.45  # ... by one point and the reference ...
    passed_share: float = 0.1  # ... and beyond which a rest has passed it.
    sample_retention: float = 20.0  # Seconds of samples that are looked back at.
    check_interval: float = 0.5  # Seconds between looks.
    movement_timeout: float = 15.0
    """Seconds without any movement after which an instrument may be dead."""
    held_volts: float = 0.02  # Volts between which an instrument stays while it is held.
    recent_time: float = 2.0  # Seconds of samples that tell a fault at once.
    max_zero_drift: float = 0.05  # Drift that is asked about: of the zero, share of the range ...
    max_slope_drift: float = 0.1  # ... and of the slope, relative.
    max_slope_difference: float = 0.5
    """How much the slopes of left and right may differ before it is asked about."""
    min_coverage: float = 0.6  # Share of the travel: less than that covered is worth a word.

    # Rest, s.
    position_rest: float = 3.0  # Seconds of rest in each position.
    zero_rest: float = 5.0  # Seconds of rest for the zeros.
    min_turn_share: float = 0.6
    """Share of the angle asked for that makes a turn; laying the aircraft on the table makes
    none."""
    pressure_rest: float = 4.0
    """Seconds of steady pressure: without a cover no wind stood still for so long in 200 trials."""
    cover_timeout: float = 10.0
    """Seconds under a cover after which a pressure that still moves is called that of wind."""


WIZARD: Final = WizardSettings()
