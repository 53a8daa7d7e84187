"""A campaign at a glance: means, whether the bounds are honest, outliers, what values depend on."""

from __future__ import annotations

from gsapp.identification.summary.campaign_summary import (
    CONDITIONS,
    CampaignSummary,
    ConditionTrend,
    DerivativePoint,
    DerivativeSummary,
    summarize_campaign,
)

__all__ = [
    "CONDITIONS",
    "CampaignSummary",
    "ConditionTrend",
    "DerivativePoint",
    "DerivativeSummary",
    "summarize_campaign",
]
