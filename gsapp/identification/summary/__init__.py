"""A campaign at a glance: means, whether the bounds are honest, outliers, what values depend on."""

from __future__ import annotations

from gsapp.identification.summary.campaign_summary import (
    CampaignSummary,
    DerivativeSummary,
    OutlyingManeuver,
    summarize_campaign,
)
from gsapp.identification.summary.condition_trends import ConditionTrend
from gsapp.identification.summary.derivative_points import CONDITIONS, DerivativePoint
from gsapp.identification.summary.outliers import Outlier

__all__ = [
    "CONDITIONS",
    "CampaignSummary",
    "ConditionTrend",
    "DerivativePoint",
    "DerivativeSummary",
    "Outlier",
    "OutlyingManeuver",
    "summarize_campaign",
]
