"""Derivatives from maneuvers by maximum likelihood: output error on the nonlinear equations.

`estimate` gives what every method gives; `fit` also keeps residuals, sensitivities and
covariances (`MLSolution`); `simulate` computes responses with given parameters.
"""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.identification.axes import DEFAULT_BIASES
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.output_error_fit import fit, simulate
from gsapp.identification.maximum_likelihood.residuals import ManeuverResiduals
from gsapp.identification.maximum_likelihood.settings import (
    FitProgress,
    FitProgressCallback,
    MLSettings,
)
from gsapp.identification.maximum_likelihood.solution import MLSolution
from gsapp.identification.results import Estimate

__all__ = [
    "DEFAULT_BIASES",
    "FitProgress",
    "FitProgressCallback",
    "MLSettings",
    "MLSolution",
    "ManeuverResiduals",
    "estimate",
    "fit",
    "simulate",
]


def estimate(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    *,
    progress: FitProgressCallback | None = None,
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several in one joint fit.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one or several flights, each with its own aircraft, mass and weights.
    settings : MLSettings
    progress : callable, optional
        Called after every iteration; returning False stops the fit where it is.

    Raises
    ------
    FlightError
        If the maneuvers hold too little to fit anything, or the model diverges.
    """
    return fit(maneuvers, settings, progress=progress).estimate
