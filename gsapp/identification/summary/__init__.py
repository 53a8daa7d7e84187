"""A campaign at a glance: means, whether the bounds are honest, outliers, what values depend on."""

from __future__ import annotations

from gsapp.identification.summary.campaign_summary import (
    CampaignSummary,
    DerivativeSummary,
    WildManeuver,
    summarize_campaign,
)
from gsapp.identification.summary.dependence import Dependence
from gsapp.identification.summary.outliers import Outlier
from gsapp.identification.summary.points import CONDITIONS, Point

__all__ = [
    "CONDITIONS",
    "CampaignSummary",
    "Dependence",
    "DerivativeSummary",
    "Outlier",
    "Point",
    "WildManeuver",
    "summarize_campaign",
]
