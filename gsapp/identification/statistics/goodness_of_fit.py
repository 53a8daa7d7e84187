"""How well computed responses follow measured ones."""

from __future__ import annotations

import numpy as np

from gsapp.identification.results import ResponseFit
from gsapp.quantities import FloatArray


def response_fit(measured: FloatArray, computed: FloatArray) -> ResponseFit:
    """Compare one response with its measurement.

    `measured` and `computed`, shape (n,): samples that are not finite in either do not count. With
    none left all is NaN; over a range of zero the percentage and r2 are NaN.
    """
    counted = np.isfinite(measured) & np.isfinite(computed)
    z, y = measured[counted], computed[counted]
    if not z.size:
        return ResponseFit(
            rms=np.nan, rms_over_range_pct=np.nan, r2=np.nan, theil=np.nan, samples=0
        )
    v = z - y
    rms = _rms(v)
    spread = float(np.ptp(z))
    about_mean = float(((z - z.mean()) ** 2).sum())
    sizes = _rms(z) + _rms(y)
    return ResponseFit(
        rms=rms,
        rms_over_range_pct=100.0 * rms / spread if spread > 0.0 else np.nan,
        r2=1.0 - float(v @ v) / about_mean if about_mean > 0.0 else np.nan,
        theil=rms / sizes if sizes > 0.0 else 0.0,
        samples=int(z.size),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values)))
