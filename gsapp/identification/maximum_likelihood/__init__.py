"""Derivatives from maneuvers by maximum likelihood: output error on the nonlinear equations."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.settings import (
    DEFAULT_BIASES,
    Callback,
    MLSettings,
    Progress,
)
from gsapp.identification.results import Estimate

__all__ = ["DEFAULT_BIASES", "Callback", "MLSettings", "Progress", "estimate"]


def estimate(
    maneuvers: Sequence[Maneuver], settings: MLSettings, *, progress: Callback | None = None
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several in one joint fit.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
    settings : MLSettings
    progress : callable, optional
        Called after every iteration; returning False stops the fit.

    Raises
    ------
    FlightError
        If the maneuvers hold too little to fit anything, or the model diverges.
    """
    del settings, progress
    raise FlightError(f"no engine yet for {len(maneuvers)} maneuvers")
