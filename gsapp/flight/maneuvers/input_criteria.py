"""What speaks against an input: one table for the verdict in flight and the grade of a maneuver.

The verdict tells the crew whether to repeat an input; the grade tells how much an estimate can
take from it. Both hold the same measures of `gsapp.flight.maneuvers.input_measures` against the
same criteria. What is beyond `invalid` makes a verdict other than good and is at least a small
defect, so that no such input is graded A; a large defect is always beyond `invalid`, so that an
input with one is never good.

The verdict knows more: the amplitude, width and airspeed that were asked for, and what a model
says of gusts. These criteria are its own (`gsapp.excitation.doublets.verdict_criteria`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.quantities.constants import DEGREE

DefectSeverity = Literal["small", "large", "fatal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Criterion:
    """Bounds of one measure, which is worse the larger it is.

    Attributes
    ----------
    small, large : float
        Beyond them it is a small or a large defect of the maneuver; infinite for never.
    invalid : float or None
        Beyond it the verdict is not good; None where the verdict goes by another measure.
    """

    small: float
    large: float = math.inf
    invalid: float | None = None

    def __post_init__(self) -> None:
        if not self.small <= (self.small if self.invalid is None else self.invalid) <= self.large:
            raise ValueError(f"a criterion needs small <= invalid <= large: {self}")

    def severity(self, value: float) -> DefectSeverity | None:
        """Return how severe a defect is; None for none."""
        if value > self.large:
            return "large"
        return "small" if value > self.small else None

    def is_invalid(self, value: float) -> bool:
        """Return whether the verdict is not good."""
        return self.invalid is not None and value > self.invalid


@dataclass(frozen=True, slots=True, kw_only=True)
class InputCriteria:
    """The criteria, with their measures."""

    trim_rate: Criterion = Criterion(small=6.0 * DEGREE, large=15.0 * DEGREE)
    """Mean rate about an axis over the second before, rad/s. The verdict goes by
    `trim_tolerance_factor`: 8 deg/s of roll, 6 of pitch and yaw."""
    trim_tolerance_factor: float = 2.0
    """Times the tolerances of the trim cue within which a start still counts: GO asks for more
    than an estimate needs."""
    trim_load_factor: float = 0.25
    """Mean deviation from 1 g over the second before, g: a small defect."""
    throttle_change: float = 0.15
    """Throttle moved: a small defect."""
    min_amplitude: float = 0.03
    """Share of half of the travel below which an input is a large defect."""
    faint_response: float = 12.0
    weak_response: float = 25.0
    """Peak-to-peak response over the noise floor below which it is a large or a small defect. The
    amplitudes that the verdict calls too small follow from them."""
    cross_input: Criterion = Criterion(small=0.35, invalid=0.35, large=0.7)
    """Largest excursion of another surface over the amplitude of the main one, both as shares of
    their travel."""
    least_cross_input: float = 0.5 * DEGREE
    """rad; another surface that moves less counts for nothing, however small the input was."""
    residual_deflection: Criterion = Criterion(small=0.4, invalid=0.4)
    """How far a surface stayed from where it began, share of its amplitude."""
    hands_off_lack: Criterion = Criterion(small=0.0, invalid=0.5, large=0.5)
    """Missing share of the hands-off interval that is wanted: of the target input, or
    `DETECTION.min_free_response_time`. Half of it is one period of the oscillation."""
    time_out_of_range: float = 0.1
    """Time out of the linear range of alpha, beta or a_n, s: a small defect, and invalid."""
    clipped_share: Criterion = Criterion(small=0.0, large=0.05)
    """Share of the samples at an end of the instrument's range."""
    clipped_time: float = 0.03
    """Time at an end of the range, from the input on, from which the verdict is not good, s."""
    missing_samples: Criterion = Criterion(small=0.1, invalid=0.2)
    """Missing share of the samples of a channel."""
    pre_input_motion: Criterion = Criterion(small=0.25, invalid=0.6, large=0.6)
    """Motion before the input over the response, both as standard deviations."""
    gust_fraction: float = 0.5
    """Share of the response that gusts may make, by the model; then up to `gust_factor` times
    the motion before the input."""
    gust_factor: float = 3.0
    """A model that is wrong finds gusts in calm air. Gusts are slow, and within two seconds most
    of them are hidden in a straight line."""


INPUT_CRITERIA: Final = InputCriteria()
"""Tuned by `bench verdicts` on seeds below 17,000."""
