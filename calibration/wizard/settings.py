"""Settings of the calibration wizard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardSettings:
    """Engineering choices, checked by `tests/bench/wizard.py`."""

    start_time: float = 2.0  # s of samples before the first instrument is asked for.
    max_gap: float = 1.0  # s without samples after which a movement may be missed.
    slice_duration: float = 0.1  # Of a slice, s.
    clock_restart: float = 1.0  # s back in time: the clock of the aircraft restarted.
    rest_timeout: float = 20.0  # s to lay an aircraft down before anything is said.
    reason_interval: float = 5.0  # Seconds between two reasons.
    max_means: int = 3000  # Means that are kept: five minutes of tenths of a second.

    # Angles set by hand.
    min_volts_apart: float = 0.02  # V from a rest that count as moved: about 0.5 deg.
    same_setting_volts: float = 0.06  # Volts from a point within which no other setting lies.
    known_share: float = 0.05  # Of the certificate's bound: such a mean adds nothing.
    min_stds_apart: float = 6.0  # The same in standard deviations of the mean.
    min_sign_movement: float = 0.15  # V of a movement that proves a sign: about 4 deg.
    sign_hold: float = 1.0  # Seconds that it must be held.
    hold: float = 1.1
    """s at rest before a point is taken: longer than the averaging, since a hand creeps to its
    mark, and creeping up and down would look like slop."""
    unsure_hold: float = 1.5  # The same where nothing tells whether it is the setting asked for.
    min_averaging: float = 0.3  # Seconds of rest that are averaged at least ...
    confirmed_hold: float = 0.6  # ... and held where the certificate in force agrees.
    near_share: float = 0.3  # Of the spacing: a rest this near is the setting, by two points ...
    near_share_one: float = 0.45  # ... by one point and the reference ...
    passed_share: float = 0.1  # ... and beyond which a rest has passed it.
    sample_retention: float = 20.0  # Seconds of samples that are looked back at.
    check_interval: float = 0.5  # Seconds between looks.
    movement_timeout: float = 15.0  # s without movement: the instrument may be dead.
    held_volts: float = 0.02  # Volts between which an instrument stays while it is held.
    recent_time: float = 2.0  # Seconds of samples that tell a fault at once.
    max_zero_drift: float = 0.05  # Drift that is asked about: of the zero, share of the range ...
    max_slope_drift: float = 0.1  # ... and of the slope, relative.
    max_slope_difference: float = 0.5  # Between left and right, before it is asked about.
    min_coverage: float = 0.6  # Share of the travel: less than that covered is worth a word.

    # Rest, s.
    position_rest: float = 3.0  # Seconds of rest in each position.
    zero_rest: float = 5.0  # Seconds of rest for the zeros.
    min_turn_share: float = 0.6  # Of the angle asked for: less was laying it on the table.
    pressure_rest: float = 4.0  # s of steady pressure: longer than wind in 200 trials.
    cover_timeout: float = 10.0  # s under a cover after which pressure that moves is wind.


WIZARD: Final = WizardSettings()
