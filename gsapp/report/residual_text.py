"""Whether the residuals of a campaign's fits are white, and what that means for its bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gsapp.identification.campaign import CampaignResult
from gsapp.identification.methods import compares_coefficients, estimation_method
from gsapp.identification.statistics import Whiteness, evaluate_whiteness


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualSummary:
    """The residuals of one response over a campaign."""

    name: str
    fits: int
    white: int
    """How many there are, and how many of them may be white noise."""
    low_share: float
    white_share: float
    """Median share of their power below 2 Hz, and what it would be of white noise."""


def residual_summaries(result: CampaignResult) -> tuple[ResidualSummary, ...]:
    """Return what the residuals of each response look like; empty where none are integrated."""
    found: dict[str, list[Whiteness]] = {}
    for one in result.results:
        estimate = one.estimate
        # Coefficients were smoothed: what is left of them is never white.
        if estimate is None or not estimate.converged or compares_coefficients(estimate.method):
            continue
        for history in estimate.histories:
            dt = float(np.median(np.diff(history.times)))
            tested = evaluate_whiteness(history.measured - history.computed, dt=dt)
            for name, told in zip(history.channels, tested, strict=True):
                found.setdefault(name, []).append(told)
    return tuple(
        ResidualSummary(
            name=name,
            fits=len(told),
            white=sum(one.white for one in told),
            low_share=_median(one.low_frequency_share for one in told),
            white_share=_median(one.white_share for one in told),
        )
        for name, told in found.items()
    )


def _median(values: Iterable[float]) -> float:
    return float(np.median(np.array(list(values))))


RESIDUAL_COLUMNS = ("response", "fits", "white", "power below 2 Hz", "if white")


def residual_rows(result: CampaignResult) -> tuple[tuple[str, ...], ...]:
    """Return a row for each response: how far its residuals are from white noise."""
    return tuple(
        (
            one.name,
            str(one.fits),
            str(one.white),
            f"{100.0 * one.low_share:.0f} %",
            f"{100.0 * one.white_share:.0f} %",
        )
        for one in residual_summaries(result)
    )


def residual_text(result: CampaignResult) -> tuple[str, ...]:
    """Return in a sentence by how much colored residuals widen the bounds; empty where unknown."""
    ratios = [
        math.sqrt(max(found.std**2 - found.offset**2, 0.0)) / found.cramer_rao
        for one in result.results
        if one.estimate is not None and one.estimate.converged
        for found in one.estimate.derivatives.values()
        if found.status == "estimated" and found.std and found.cramer_rao
    ]
    if not ratios:
        return ()
    factor = result.settings.bound_factor
    if factor is not None and "bound_factor" in estimation_method(result.settings.method).settings:
        return (f"The bounds are the plain Cramer-Rao bounds times {factor:g}, as requested.",)
    return (
        f"The bounds account for colored residuals: their noise is {np.median(ratios):.1f} times "
        "the plain Cramer-Rao bounds (median over all values).",
    )
