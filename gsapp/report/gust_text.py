"""Maneuvers in gusts: equation error beside maximum likelihood, in a sentence and in tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.summary.method_comparison import (
    MethodDifference,
    ValueWithBound,
    compare_method_means,
    compare_methods,
)
from gsapp.identification.summary.settings import SUMMARY
from gsapp.report.document import DocumentTable
from gsapp.report.estimate_text import decimals_for_std

_COLUMNS: Final = (
    "derivative", "ML", "bound", "equation error", "bound", "difference, in joint bounds",
)  # fmt: skip


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
                _difference_cell(one),
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


def _difference_cell(one: MethodDifference) -> str:
    return "" if one.normalized_difference is None else f"{one.normalized_difference:+.1f}"
