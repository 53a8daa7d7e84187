"""How far single fits carry: white residuals, gusts, bounds, what cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.results import Estimate
from gsapp.identification.summary.method_comparison import (
    MethodDifference,
    ValueWithBound,
    compare_method_means,
    compare_methods,
)
from gsapp.identification.summary.settings import SUMMARY
from gsapp.report.document import DocumentPart, DocumentSection, DocumentTable
from gsapp.report.estimate_text import decimals_for_std
from gsapp.report.fit_diagnostic_figures import bounds_figure, correlated_pairs, correlation_figure
from gsapp.report.residual_text import RESIDUAL_COLUMNS, residual_rows
from gsapp.report.settings import REPORT

_COLUMNS: Final = (
    "derivative", "ML", "bound", "equation error", "bound", "difference, in joint bounds",
)  # fmt: skip


def fit_diagnostics_section(result: CampaignResult) -> DocumentSection:
    """Return the section on how far single fits carry: residuals, bounds, correlations."""
    parts: list[DocumentPart] = []
    residuals = residual_rows(result)
    if residuals:
        parts.append(
            DocumentTable(
                caption="Residuals: number of fits with white residuals, and power share in "
                "the band of the aircraft motion (median)",
                columns=RESIDUAL_COLUMNS,
                rows=residuals,
                numeric=frozenset(range(1, len(RESIDUAL_COLUMNS))),
            )
        )
    rows = _correlated(result)
    if rows:
        parts.append(
            DocumentTable(
                caption=f"Highly correlated derivatives: correlations beyond "
                f"{REPORT.high_correlation} in size"
                + (
                    f", the {REPORT.max_pairs} found most often"
                    if len(rows) > REPORT.max_pairs
                    else ""
                ),
                columns=("one", "other", "in how many fits", "correlation there"),
                rows=rows[: REPORT.max_pairs],
                numeric=frozenset({2, 3}),
            )
        )
    for estimate, subject in _typical_fits(result):
        pictures = (bounds_figure(estimate, subject), correlation_figure(estimate, subject))
        parts += [
            replace(one, name=f"{one.name}-{estimate.axis}") for one in pictures if one is not None
        ]
    return DocumentSection(title="Residuals, bounds and correlations", parts=tuple(parts))


def _typical_fits(result: CampaignResult) -> list[tuple[Estimate, str]]:
    """Return the fit of all maneuvers together, or the best single one, of each axis."""
    if result.joint:
        return [
            (one, f"{len(one.maneuvers)} maneuvers jointly ({AXIS_TITLES[one.axis]})")
            for one in result.joint
        ]
    best: dict[str, tuple[float, Estimate, str]] = {}
    for one in result.results:
        estimate = one.estimate
        if estimate is None or not estimate.converged or len(estimate.free) < 2:
            continue
        subject = f"maneuver {one.maneuver.id} of {one.maneuver.flight}"
        found = (_median_bound(estimate), estimate, subject)
        best[estimate.axis] = min(best.get(estimate.axis, found), found, key=lambda fit: fit[0])
    return [(estimate, subject) for _, estimate, subject in best.values()]


def _median_bound(estimate: Estimate) -> float:
    """Return the median bound over value of a fit; the fewer it earned, the less it is worth."""
    shares = [
        abs(one.std / one.value)
        for one in estimate.derivatives.values()
        if one.status == "estimated" and one.value and one.std
    ]
    return float(np.median(shares)) / len(shares) if shares else np.inf


def _correlated(result: CampaignResult) -> tuple[tuple[str, str, str, str], ...]:
    """Return the pairs that are close in some fit, those close most often first."""
    every = [one.estimate for one in result.results if one.estimate is not None]
    close: dict[tuple[str, str], list[float]] = {}
    for estimate in (*result.joint, *every):
        for one, other, value in correlated_pairs(estimate):
            close.setdefault((one, other), []).append(value)
    ordered = sorted(close.items(), key=lambda pair: (-len(pair[1]), pair[0]))
    return tuple(
        (one, other, str(len(values)), f"{float(np.median(values)):+.3f}")
        for (one, other), values in ordered
    )


def gusty_maneuvers_text(result: CampaignResult) -> tuple[str, ...]:
    """Return in a sentence which maneuvers flew in gusts; empty where none did."""
    ids = [one.maneuver.id for one in result.results if one.equation_error_estimate is not None]
    if not ids:
        return ()
    return (
        f"The residuals of {len(ids)} maneuver{'' if len(ids) == 1 else 's'} ({', '.join(ids)}) "
        "show gusts, which values and bounds of maximum likelihood suffer from. Equation error "
        "takes the air as the vanes felt it and stands beside: where the two differ by more "
        f"than {SUMMARY.significant_sigmas:.0f} joint bounds apart, believe the one with the "
        "smaller bound.",
    )


def gust_comparison_table(result: CampaignResult) -> DocumentTable | None:
    """Return the means of both methods over the maneuvers in gusts; None where there are none."""
    means = compare_method_means(result.results)
    if not means:
        return None
    return _table("Means over the maneuvers in gusts, per radian, by both methods", means)


def method_comparison_table(result: ManeuverResult) -> DocumentTable | None:
    """Return the derivatives of a maneuver by both methods; None where it flew in calm air."""
    values = compare_methods(result)
    if not values:
        return None
    maneuver = result.maneuver
    notes = (
        () if result.equation_error_estimate is None else result.equation_error_estimate.warnings
    )
    said = f". Of equation error: {'; '.join(notes)}" if notes else ""
    caption = (
        f"Maneuver {maneuver.id} of {maneuver.flight} flew in gusts: equation error beside maximum "
        f"likelihood, per radian{said}"
    )
    return _table(caption, values)


def _table(caption: str, values: Sequence[MethodDifference]) -> DocumentTable:
    return DocumentTable(
        caption=caption,
        columns=_COLUMNS,
        rows=tuple(
            (
                one.name,
                *_value_cells(one.maximum_likelihood),
                *_value_cells(one.equation_error),
                "" if one.normalized_difference is None else f"{one.normalized_difference:+.1f}",
            )
            for one in values
        ),
        numeric=frozenset(range(1, len(_COLUMNS))),
    )


def _value_cells(one: ValueWithBound | None) -> tuple[str, str]:
    if one is None:
        return "", ""
    value, bound = one
    digits = decimals_for_std(bound)
    return f"{value:.{digits}f}", f"{bound:.{digits}f}"
