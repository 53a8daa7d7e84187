"""Values on the screen with as many digits as their bounds earn."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignValue

MEAN_HEADINGS = ("mean", "std. error", "scatter", "n")
"""Above `mean_cells`."""
MEAN_LEGEND = (
    "std. error: standard error of the mean; scatter: standard deviation from maneuver to maneuver"
)


def format_value_and_bound(value: float, std: float, least: int = 4) -> tuple[str, str]:
    """Return a value and its bound: never a bound of zero for one that is small.

    Parameters
    ----------
    value, std : float
    least : int
        Digits after the point, so that columns of usual values stand in line.
    """
    from gsapp.report.estimate_text import decimals_for_std

    digits = max(least, decimals_for_std(std))
    return f"{value:z.{digits}f}", f"{std:.{digits}f}"


def mean_cells(value: CampaignValue) -> list[str]:
    """Return the cells of a mean: value, standard error, scatter and number."""
    mean, std = format_value_and_bound(value.mean, value.std)
    scatter = "" if value.scatter is None else format_value_and_bound(value.scatter, value.std)[0]
    return [mean, std, scatter, str(value.n)]
