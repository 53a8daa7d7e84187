"""Whether residuals are white, as plain Cramer-Rao bounds take them to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from gsapp.identification.statistics.correlation import (
    BoolArray,
    LagLayout,
    bartlett,
    default_lags,
)
from gsapp.identification.statistics.settings import STATISTICS
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Whiteness:
    """What the residuals of one response look like."""

    p_value: float
    """Of the portmanteau test (Ljung-Box; missing samples allowed for): the chance of such
    correlation in white residuals."""
    low_frequency_share: float
    """Share of the power below 2 Hz, where the aircraft moves and derivatives are felt."""
    white_share: float  # What that share would be for white residuals.
    inflation: float
    """Density at low frequency over that of white residuals of the same size: the number of samples
    divided by it is the effective number."""
    white: bool  # Whether the test lets it pass at 0.1 %.


def evaluate_whiteness(
    v: FloatArray, segments: Sequence[slice] | None = None, *, dt: float = 0.01
) -> tuple[Whiteness, ...]:
    """Test the residuals of each response.

    `v`, shape (n, n_responses): NaN where a sample does not count.
    `dt`: sample time, s.

    Returns
    -------
    tuple of Whiteness
        One for each response. Residuals of zero or fewer than 20 samples say nothing: p = 1.
    """
    lags = default_lags(len(v))
    layout = LagLayout(len(v), segments, lags)
    counted = np.isfinite(v)
    sums = layout.autocovariance_sums(np.where(counted, v, 0.0))
    return tuple(
        _evaluate_response(sums[:, index], counted[:, [index]], layout, dt)
        for index in range(v.shape[1])
    )


def _evaluate_response(
    sums: FloatArray, counted: BoolArray, layout: LagLayout, dt: float
) -> Whiteness:
    """Test one response by its lagged sums; which samples count has the shape (n, 1)."""
    count, lags = len(counted), layout.lags
    samples = int(counted.sum())
    edge = min(2.0 * STATISTICS.low_frequency * dt, 1.0)
    own = sums * layout.pair_normalization(counted)[:, 0, 0]
    if samples < STATISTICS.min_samples or not own[lags] > 0.0:
        return Whiteness(
            p_value=1.0, low_frequency_share=np.nan, white_share=edge, inflation=np.nan, white=True
        )
    rho = own / own[lags]
    j = np.arange(-lags, lags + 1)
    tapered = rho * bartlett(lags)
    # Ljung-Box by the means over the pairs that there are.
    after = slice(lags + 1, lags + 1 + min(STATISTICS.portmanteau_lags, lags))
    pairs = layout.pair_counts(counted)[after, 0, 0]
    mean = rho[after] / (1.0 - j[after] / count)
    statistic = (samples + 2.0) / samples * float((mean * mean * pairs).sum())
    p_value = float(chdtrc(pairs.size, statistic))
    # The density of the tapered covariance, integrated to the edge of the low band.
    share = float((tapered * edge * np.sinc(edge * j)).sum())
    return Whiteness(
        p_value=p_value,
        low_frequency_share=min(max(share, 0.0), 1.0),
        white_share=edge,
        inflation=max(float(tapered.sum()), 0.0),
        white=p_value >= STATISTICS.significance_level,
    )
