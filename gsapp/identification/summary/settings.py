"""Settings of the summary of a campaign and of comparisons of its values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class SummarySettings:
    """Engineering choices."""

    significant_sigmas: float = 2.0  # Joint bounds from which two values count as apart.
    contradiction_sigmas: float = 3.0
    """Joint bounds from which two methods contradict each other: 1 % of the values of virtual
    flights in calm air with perfect aircraft files."""
    max_named: int = 4  # Derivatives that a sentence names.

    # Campaign.
    min_outliers: int = 2  # Derivatives of one maneuver that must lie far off ...
    min_outlier_share: float = 0.3  # ... and their share, for a maneuver to be an outlier.
    good_fit: float = 0.95  # R2 of every response from which a fit is good.

    # Outliers.
    min_points: int = 4  # Values that it takes to call one of them an outlier.
    outlier_significance: float = 0.01  # For any false outlier in a campaign.
    min_outlier_sigmas: float = 3.5  # Standard deviations of an outlier at least.
    poor_fit: float = 0.8  # R2 of a response below which the fit itself is poor.
    wide_bound_ratio: float = 3.0  # A bound so many times the usual one says little by itself.

    # Trends.
    min_trend_points: int = 6  # Values that it takes to see a trend.
    trend_significance: float = 0.01  # For any false trend in a campaign.
    trim_duration: float = 1.0  # s at the start of a maneuver: trim before its input.
    min_range_share: float = 0.02  # Of a response's usual range: instrument broken.


SUMMARY: Final = SummarySettings()
