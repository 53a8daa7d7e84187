"""When an estimate is earned.

A derivative is *unknown* until all of this holds:

1. its equation runs (its instruments are there), and there are enough real equations;
2. what its variable did in the band, and no other variable explains, exceeds the variable's own
   noise there by `FTRSettings.signal_to_noise`; noise in a regressor shrinks the derivative by
   one over the square of that;
3. its bound, times the rms of its variable, stays below `FTRSettings.uncertain_share` of the
   rms of the coefficient (trim and drift taken out).

Where 2 or 3 fails because the variable moved together with others, it is *not identifiable*, and
the one it moved with most is named. The constant part needs 3 alone, with its bound itself in the
place of the product.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.settings import FTR_ALGORITHM, FTRSettings
from gsapp.identification.ftr.solution import FTRSolution
from gsapp.identification.results import DerivativeStatus
from gsapp.quantities import FloatArray


class EstimateVerdict(IntEnum):
    """Why an estimate is, or is not, shown."""

    ESTIMATED = 0
    NOT_MEASURED = 1
    TOO_SHORT = 2
    NOT_EXCITED = 3
    COLLINEAR = 4
    UNCERTAIN = 5

    @property
    def status(self) -> DerivativeStatus:
        if self is EstimateVerdict.ESTIMATED:
            return "estimated"
        return "not-identifiable" if self is EstimateVerdict.COLLINEAR else "unknown"


VerdictArray = npt.NDArray[np.int8]


def evaluate_estimates(
    solution: FTRSolution, settings: FTRSettings, running: npt.NDArray[np.bool_]
) -> tuple[VerdictArray, VerdictArray]:
    """Return a verdict for each derivative, and the place of the variable it moved with.

    `running`, shape (U, 3): equations whose instruments are there.

    Returns
    -------
    verdicts : ndarray of int8, shape (U, 3, p + 1)
        The constant part last.
    companions : ndarray of int8, shape (U, 3, p)
        -1 where there is none.
    """
    noisy = solution.signal_to_noise < settings.signal_to_noise
    uncertain = solution.uncertain > settings.uncertain_share
    # Not above is not enough: NaN must fail, too.
    uncertain |= ~np.isfinite(solution.uncertain)
    # Had it been alone in moving, would it have been enough?
    share = np.sqrt(np.maximum(solution.alone, 1e-30))
    companions = _most_correlated(solution)
    together = (solution.alone < FTR_ALGORITHM.collinearity_share) & (companions >= 0)
    noisy_together = (
        noisy & together & (solution.signal_to_noise > settings.signal_to_noise * share)
    )
    uncertain_together = (
        uncertain[..., :-1]
        & together
        & (solution.uncertain[..., :-1] * share < settings.uncertain_share)
    )
    verdicts = np.full(solution.uncertain.shape, EstimateVerdict.ESTIMATED, dtype=np.int8)
    verdicts[uncertain] = EstimateVerdict.UNCERTAIN
    own = verdicts[..., :-1]
    own[noisy] = EstimateVerdict.NOT_EXCITED
    own[noisy_together | (uncertain_together & ~noisy)] = EstimateVerdict.COLLINEAR
    verdicts[solution.freedom < settings.least_freedom] = EstimateVerdict.TOO_SHORT
    verdicts[~running] = EstimateVerdict.NOT_MEASURED
    return verdicts, companions


def _most_correlated(solution: FTRSolution) -> VerdictArray:
    correlation: FloatArray = np.abs(solution.correlation)
    p = correlation.shape[-1]
    if p < 2:
        return np.full(solution.theta.shape, -1, dtype=np.int8)
    others = correlation * (1.0 - np.eye(p))
    nearest = others.argmax(axis=-1)
    found = others.max(axis=-1) > 0.0
    return np.asarray(np.where(found, nearest, -1), dtype=np.int8)


def estimate_verdict_text(
    verdict: EstimateVerdict,
    *,
    name: str,
    companion: str | None,
    signal_to_noise: float,
    uncertain: float,
    listened: float,
    settings: FTRSettings,
    missing: str,
) -> str:
    """Return in words why an estimate is not shown; empty where it is."""
    variable = name.partition("_")[2]
    if verdict is EstimateVerdict.ESTIMATED:
        return ""
    if verdict is EstimateVerdict.NOT_MEASURED:
        return missing or "a required instrument was silent"
    if verdict is EstimateVerdict.TOO_SHORT:
        return f"only {listened:.1f} s of data" if listened > 0.0 else "no samples yet"
    if verdict is EstimateVerdict.NOT_EXCITED:
        return (
            f"{variable} was too weak alone: {signal_to_noise:.1f} times its noise, needed "
            f"{settings.signal_to_noise:g}"
        )
    if verdict is EstimateVerdict.COLLINEAR:
        return f"{variable} moved together with {companion}; move the surfaces apart"
    what = "its bound" if variable == "0" else f"the bound times what {variable} did"
    return (
        f"{what} is {100 * uncertain:.0f} % of what the coefficient did; "
        f"needed {100 * settings.uncertain_share:.0f} %"
    )
