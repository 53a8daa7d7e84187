"""Settings of the equation-error method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class EquationErrorSettings:
    """Engineering choices unless a source is named."""

    # Equations.
    rows_per_column: int = 8  # Rows that a stretch must have for each number of its model.
    max_growth: float = 10.0  # By which an unstable model may grow within a stretch.
    drift_degree: int = 2  # Of the polynomial for drift of integrated flow angles.
    min_angle_std: float = 0.1 * DEGREE  # Smaller deviations are no motion: rad ...
    min_rate_std: float = 0.3 * DEGREE  # ... and rad/s.
    min_signal_to_noise: float = 2.0  # Standard deviation over noise: moved beyond.
    min_duration: float = 1.0  # s of usable record below which nothing is estimated.
    significant_sigmas: float = 3.0  # Bounds from which a time shift is proven ...
    min_shift: float = 1e-3  # ... and the least shift that does harm, s.
    weak_instrument_inflation: float = 1.7  # Of bounds: worse than the noise.

    # Regression.
    max_correlation_time: float = 2.0  # s, of the autocovariance of residuals.
    min_regressor_to_noise: float = 3.0  # Of a regressor, given the others.
    max_inflation: float = 1e7  # Of a variance by collinearity, where no noise is known.
    start_value_cutoff: float = 5.0  # Hz; a start value needs no better choice.
    singular_value_cutoff: float = 1e-3  # Of the largest one: smaller stay near zero.

    # Stepwise regression.
    f_to_enter: float = 20.0  # Partial F at which a term enters ...
    f_to_remove: float = 12.0  # ... and below which it leaves.
    press_segment_duration: float = 0.6  # Length of the stretches that PRESS leaves out, s.
    max_cosine: float = 0.9  # Of what is new in two candidates: hardly told apart.
    max_candidates: int = 3  # Candidates tried in a round before it gives up.


EQUATION_ERROR: Final = EquationErrorSettings()
