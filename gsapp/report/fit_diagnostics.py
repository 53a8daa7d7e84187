"""How far single fits carry: white residuals, gusts, bounds, what cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.methods import short_method_title
from gsapp.identification.results import Estimate
from gsapp.identification.summary.method_comparison import (
    MethodComparison,
    ValueWithBound,
    compare_method_means,
    compare_methods,
)
from gsapp.report.document import DocumentPart, DocumentSection, DocumentTable
from gsapp.report.estimate_text import decimals_for_std
from gsapp.report.fit_diagnostic_figures import bounds_figure, correlated_pairs, correlation_figure
from gsapp.report.residual_text import RESIDUAL_COLUMNS, residual_rows
from gsapp.report.settings import REPORT


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
    ids = [
        one.maneuver.id
        for one in result.results
        if one.estimate is not None and one.estimate.gusty_maneuvers
    ]
    if not ids:
        return ()
    return (
        f"The residuals of {len(ids)} maneuver{'' if len(ids) == 1 else 's'} ({', '.join(ids)}) "
        "show gusts, which values and bounds of maximum likelihood suffer from. They were "
        "estimated by filter error, which estimates the gusts, too.",
    )


def mean_comparison_table(result: CampaignResult) -> DocumentTable | None:
    """Return the means by each method; None where only one was used."""
    means = compare_method_means(result.results)
    if not means:
        return None
    caption = "Means by each method, per radian; bounds of the first allow for systematic errors"
    return _table(caption, means)


def method_comparison_table(result: ManeuverResult) -> DocumentTable | None:
    """Return the derivatives of a maneuver by each method; None where only one was used."""
    values = compare_methods(result)
    if not values:
        return None
    maneuver = result.maneuver
    notes = dict.fromkeys(
        f"{short_method_title(method)}: {text}"
        for method, one in result.comparisons.items()
        for text in one.warnings
        if result.estimate is None or text not in result.estimate.warnings
    )
    said = f". {'; '.join(notes)}" if notes else ""
    caption = f"Maneuver {maneuver.id} of {maneuver.flight} by each method, per radian{said}"
    return _table(caption, values)


def _table(caption: str, values: Sequence[MethodComparison]) -> DocumentTable:
    own = values[0].method
    others = tuple(dict.fromkeys(key for one in values for key in one.values if key != own))
    columns = ["derivative", short_method_title(own), "bound"]
    for other in others:
        columns += [short_method_title(other), "bound", "difference, in joint bounds"]
    return DocumentTable(
        caption=caption,
        columns=tuple(columns),
        rows=tuple(
            (
                one.name,
                *_value_cells(one.values.get(own)),
                *(
                    cell
                    for other in others
                    for cell in (
                        *_value_cells(one.values.get(other)),
                        _difference_cell(one.difference(other)),
                    )
                ),
            )
            for one in values
        ),
        numeric=frozenset(range(1, len(columns))),
    )


def _difference_cell(difference: float | None) -> str:
    return "" if difference is None else f"{difference:+.1f}"


def _value_cells(one: ValueWithBound | None) -> tuple[str, str]:
    if one is None:
        return "", ""
    value, bound = one
    digits = decimals_for_std(bound)
    return f"{value:.{digits}f}", f"{bound:.{digits}f}"
