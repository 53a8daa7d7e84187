"""Whether residuals are white, as plain Cramer-Rao bounds take them to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from gsapp.identification.statistics.correlation import (
    Layout,
    autocovariance,
    bartlett,
    usual_lags,
)
from gsapp.quantities import FloatArray

PORTMANTEAU_LAGS = 20
LOW_FREQUENCY_HZ = 2.0
SIGNIFICANT = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class Whiteness:
    """What the residuals of one response look like.

    Attributes
    ----------
    p_value : float
        Of the portmanteau test (Ljung-Box; missing samples allowed for): the chance of such
        correlation in white residuals.
    low_frequency_share : float
        Share of the power below 2 Hz, where the aircraft moves and derivatives are felt.
    white_share : float
        What that share would be for white residuals.
    inflation : float
        Density at low frequency over that of white residuals of the same size: the number of
        samples divided by it is the effective number.
    white : bool
        Whether the test lets it pass at 0.1 %.
    """

    p_value: float
    low_frequency_share: float
    white_share: float
    inflation: float
    white: bool


def whiteness(
    v: FloatArray, segments: Sequence[slice] | None = None, *, dt: float = 0.01
) -> tuple[Whiteness, ...]:
    """Test the residuals of each response.

    Parameters
    ----------
    v : ndarray, shape (n, n_responses)
        NaN where a sample does not count.
    segments : sequence of slice, optional
    dt : float
        Sample time, s.

    Returns
    -------
    tuple of Whiteness
        One for each response. Residuals of zero or fewer than 20 samples say nothing: p = 1.
    """
    lags = usual_lags(len(v))
    centered = v - _means(v)
    layout = Layout(len(v), segments, lags)
    C = autocovariance(centered, layout)
    counted = np.isfinite(v)
    pairs = np.rint(layout.lagged_sums(counted.astype(np.float64)))
    taper = bartlett(lags)
    j = np.arange(-lags, lags + 1)
    # Density of the tapered covariance, integrated to the edge of the low band.
    edge = min(2.0 * LOW_FREQUENCY_HZ * dt, 1.0)
    band = edge * np.sinc(edge * j)
    tested = min(PORTMANTEAU_LAGS, lags)
    found = []
    for index in range(v.shape[1]):
        own = C[:, index, index]
        size, samples = own[lags], int(counted[:, index].sum())
        if samples < 20 or not size > 0.0:
            found.append(
                Whiteness(
                    p_value=1.0,
                    low_frequency_share=np.nan,
                    white_share=edge,
                    inflation=np.nan,
                    white=True,
                )
            )
            continue
        rho = own / size
        shrink = 1.0 - np.abs(j) / len(v)
        straight = rho / shrink
        after = slice(lags + 1, lags + 1 + tested)
        available = pairs[after, index, index]
        statistic = (samples + 2.0) / samples * float((straight[after] ** 2 * available).sum())
        p_value = float(chi2.sf(statistic, tested))
        found.append(
            Whiteness(
                p_value=p_value,
                low_frequency_share=float(np.clip((rho * taper * band).sum(), 0.0, 1.0)),
                white_share=edge,
                inflation=float(max((rho * taper).sum(), 0.0)),
                white=p_value >= SIGNIFICANT,
            )
        )
    return tuple(found)


def _means(v: FloatArray) -> FloatArray:
    counted = np.isfinite(v)
    means: FloatArray = np.where(counted, v, 0.0).sum(axis=0) / np.maximum(counted.sum(axis=0), 1)
    return means
