"""Linear models with the means of a campaign, for a control designer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES, AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, CampaignSettings
from gsapp.identification.linear_models.model_comparison import (
    DRAG_DERIVATIVES,
    mean_condition,
    model_from_derivatives,
)
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary.campaign_summary import CampaignSummary

_REQUIRED_DERIVATIVES: Final[dict[LinearAxis, tuple[str, ...]]] = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r"),
}
"""Without these there is no model: zero in their place would be another aircraft."""


NO_LINEAR_MODEL_PREFIX: Final = "no linear"
"""Begins each remark on a linear model that could not be made."""


def known_derivatives(settings: CampaignSettings, means: Mapping[str, float]) -> dict[str, float]:
    """Return what is known of the derivatives: means, then what was held, then a model's values."""
    model = settings.known_model
    return {**({} if model is None else model.derivatives), **settings.held, **means}


def check_required_derivatives(axis: LinearAxis, values: Mapping[str, float]) -> None:
    """See that the derivatives without which a linear model is none are known.

    Raises
    ------
    FlightError
        Names those that are not.
    """
    missing = [name for name in _REQUIRED_DERIVATIVES[axis] if name not in values]
    if missing:
        raise FlightError(f"{', '.join(missing)} not known")


def build_linear_models(
    result: CampaignResult, summary: CampaignSummary
) -> tuple[dict[LinearAxis, LinearModel], tuple[str, ...]]:
    """Return the linear models about the mean condition of the maneuvers of each axis.

    `summary`: whose means are taken; what is held or known from a model stands in for the others.

    Returns
    -------
    models : dict of str to LinearModel
        By axis, SI; those that cannot be made are left out.
    remarks : tuple of str
        Why not, in words.
    """
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    values = known_derivatives(result.settings, means)
    found: dict[LinearAxis, LinearModel] = {}
    remarks = []
    for axis in _REQUIRED_DERIVATIVES:
        flown = [
            one.maneuver
            for one in result.results
            if one.estimate is not None
            and not set(AXIS_SURFACES[axis]).isdisjoint(one.maneuver.inputs)
        ]
        if not flown:
            continue
        words = AXIS_TITLES[axis]
        try:
            check_required_derivatives(axis, values)
            found[axis] = model_from_derivatives(
                flown[0].aircraft, mean_condition(flown), axis, values
            )
        except FlightError as error:
            remarks.append(f"{NO_LINEAR_MODEL_PREFIX} {words} model: {error}")
            continue
        if axis == "lon" and "V" not in found[axis].states:
            missing = ", ".join(name for name in DRAG_DERIVATIVES if name not in values)
            remarks.append(
                f"{NO_LINEAR_MODEL_PREFIX} model of speed and pitch angle: {missing} not known"
            )
    return found, tuple(remarks)
