"""Linear models with the means of a campaign, for a control designer."""

from __future__ import annotations

from typing import Final

from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.axes import SURFACES
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.linear_models.comparison import mean_condition, model_of_derivatives
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary.campaign_summary import CampaignSummary

_NEEDED: Final[dict[LinearAxis, tuple[str, ...]]] = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r"),
}
"""Without these there is no model: zero in their place would be another aircraft."""


def linear_models(
    result: CampaignResult, summary: CampaignSummary
) -> tuple[dict[LinearAxis, LinearModel], tuple[str, ...]]:
    """Return the linear models about the mean condition of the maneuvers of each axis.

    Parameters
    ----------
    result : CampaignResult
    summary : CampaignSummary
        Whose means are taken; what is held or known from a model stands in for the others.

    Returns
    -------
    models : dict of str to LinearModel
        By axis, SI; those that cannot be made are left out.
    remarks : tuple of str
        Why not, in words.
    """
    model = result.settings.model
    values = {} if model is None else dict(model.derivatives)
    values |= dict(result.settings.held)
    values |= {name: one.value.mean for name, one in summary.derivatives.items()}
    found: dict[LinearAxis, LinearModel] = {}
    remarks = []
    for axis, needed in _NEEDED.items():
        flown = [
            one.maneuver
            for one in result.results
            if one.estimate is not None and not set(SURFACES[axis]).isdisjoint(one.maneuver.inputs)
        ]
        missing = [name for name in needed if name not in values]
        if not flown:
            continue
        words = "longitudinal" if axis == "lon" else "lateral"
        if missing:
            remarks.append(f"no linear {words} model: {', '.join(missing)} not known")
            continue
        try:
            found[axis] = model_of_derivatives(
                flown[0].aircraft, mean_condition(flown), axis, values
            )
        except FlightError as error:
            remarks.append(f"no linear {words} model: {error}")
    return found, tuple(remarks)
