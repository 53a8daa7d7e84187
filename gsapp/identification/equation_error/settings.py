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
    drift_degree: int = 2
    """Of the polynomial in time that takes up what an integrated flow angle drifts."""
    min_angle_std: float = 0.1 * DEGREE
    """Standard deviations below which nothing has moved: rad ..."""
    min_rate_std: float = 0.3 * DEGREE  # ... and rad/s.
    min_signal_to_noise: float = 2.0
    """Standard deviation over that of the noise, below which nothing has moved."""
    min_duration: float = 1.0  # s of usable record below which nothing is estimated.
    significant_sigmas: float = 3.0  # Bounds from which a time shift is proven ...
    min_shift: float = 1e-3  # ... and the least shift that does harm, s.
    weak_instrument_inflation: float = 1.7
    """Growth of the bounds at which instruments cost more than the noise that they avoid."""

    # Regression.
    max_correlation_time: float = 2.0
    """Of the residuals, s: how far their autocovariance is followed."""
    min_regressor_to_noise: float = 3.0
    """What the other regressors leave of one, over the noise in it: below, it is noise."""
    max_inflation: float = 1e7
    """Of a variance by collinearity, where there is no noise to compare with."""
    start_value_cutoff: float = 5.0  # Hz; a start value needs no better choice.
    singular_value_cutoff: float = 1e-3
    """Share of the largest singular value below which a combination of parameters stays small."""

    # Stepwise regression.
    f_to_enter: float = 20.0  # Partial F at which a term enters ...
    f_to_remove: float = 12.0  # ... and below which it leaves.
    press_segment_duration: float = 0.6  # Length of the stretches that PRESS leaves out, s.
    max_cosine: float = 0.9
    """Cosine of what is new in two candidates, from which the data hardly tell them apart."""
    max_candidates: int = 3  # Candidates tried in a round before it gives up.


EQUATION_ERROR: Final = EquationErrorSettings()
