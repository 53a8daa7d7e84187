"""A whole campaign: every maneuver by itself, the means over all, and joint fits.

Each maneuver goes to the axis that its surfaces excite. What a maneuver does not free (tables
6.2.5 and 6.2.6) is held at the model's value; without a model, at the campaign's own: maneuvers
that move fewer surfaces come second and hold the means of those that moved more. Those that lack
airspeed or angle of attack come after the others of their kind and start from their means.
"""

from __future__ import annotations

from gsapp.identification.campaign.method_functions import (
    EstimationTask,
    secondary_input_derivatives,
)
from gsapp.identification.campaign.results import (
    CampaignResult,
    CampaignSettings,
    CampaignValue,
    ManeuverResult,
    campaign_values,
    weighted_mean,
)
from gsapp.identification.campaign.runner import (
    CampaignProgressCallback,
    CanceledError,
    run_campaign,
)

__all__ = [
    "CampaignProgressCallback",
    "CampaignResult",
    "CampaignSettings",
    "CampaignValue",
    "CanceledError",
    "EstimationTask",
    "ManeuverResult",
    "campaign_values",
    "run_campaign",
    "secondary_input_derivatives",
    "weighted_mean",
]
