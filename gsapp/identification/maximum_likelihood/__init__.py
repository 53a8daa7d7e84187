"""Derivatives from maneuvers by maximum likelihood: output error on the nonlinear equations.

`estimate` gives what every method gives; `fit` also keeps residuals, sensitivities and
covariances (`MLSolution`); `simulate` computes responses with given parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from gsapp.identification.axes import DEFAULT_BIASES
from gsapp.identification.estimate_corrections import AssumedConstant, estimate_with_constants
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.output_error_fit import fit, simulate
from gsapp.identification.maximum_likelihood.settings import (
    FitProgressCallback,
    MLSettings,
)
from gsapp.identification.maximum_likelihood.solution import MLSolution
from gsapp.identification.results import Estimate

__all__ = [
    "DEFAULT_BIASES",
    "FitProgressCallback",
    "MLSettings",
    "MLSolution",
    "estimate",
    "fit",
    "simulate",
]


def estimate(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    *,
    assumed: Mapping[str, AssumedConstant] = MappingProxyType({}),
    progress: FitProgressCallback | None = None,
    values_only: bool = False,
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several in one joint fit.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one or several flights, each with its own aircraft, mass and weights.
    assumed : mapping of str to AssumedConstant
        Constants for channels that were not measured; their error goes into the bounds, by a fit
        with each of them moved.
    progress : callable, optional
        Called after every iteration; returning False stops the fit where it is.
    values_only : bool
        Leave out what takes time beside the values: bounds corrected for colored residuals, tests
        of single responses, signs.

    Raises
    ------
    FlightError
        If the maneuvers hold too little to fit anything, or the model diverges.
    """
    return estimate_with_constants(
        lambda values: (
            fit(
                maneuvers,
                settings.with_stand_ins(values),
                progress=progress,
                values_only=values_only,
            ).estimate
        ),
        assumed,
    )
