"""Maneuvers in gusts: equation error beside maximum likelihood, in a sentence and in tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.summary.beside import (
    FAR,
    BesideValue,
    Known,
    beside_means,
    beside_values,
)
from gsapp.report.document import Table
from gsapp.report.estimate_words import decimals

_COLUMNS: Final = (
    "derivative", "ML", "bound", "equation error", "bound", "apart, in joint bounds",
)  # fmt: skip


def gust_words(result: CampaignResult) -> tuple[str, ...]:
    """Return in a sentence which maneuvers flew in gusts; empty where none did."""
    ids = [one.maneuver.id for one in result.results if one.beside is not None]
    if not ids:
        return ()
    return (
        f"The residuals of {len(ids)} maneuver{'' if len(ids) == 1 else 's'} ({', '.join(ids)}) "
        "show gusts, which values and bounds of maximum likelihood suffer from. Equation error "
        "takes the air as the vanes felt it and stands beside: where the two lie more than "
        f"{FAR:.0f} joint bounds apart, believe the one with the smaller bound.",
    )


def gusty_table(result: CampaignResult) -> Table | None:
    """Return the means of both methods over the maneuvers in gusts; None where there are none."""
    means = beside_means(result.results)
    if not means:
        return None
    return _table("Means over the maneuvers in gusts, per radian, by both methods", means)


def beside_table(result: ManeuverResult) -> Table | None:
    """Return the derivatives of a maneuver by both methods; None where it flew in calm air."""
    values = beside_values(result)
    if not values:
        return None
    maneuver = result.maneuver
    notes = () if result.beside is None else result.beside.warnings
    said = f". Of equation error: {'; '.join(notes)}" if notes else ""
    caption = (
        f"Maneuver {maneuver.id} of {maneuver.flight} flew in gusts: equation error beside maximum "
        f"likelihood, per radian{said}"
    )
    return _table(caption, values)


def _table(caption: str, values: Sequence[BesideValue]) -> Table:
    return Table(
        caption=caption,
        columns=_COLUMNS,
        rows=tuple(
            (one.name, *_known(one.likelihood), *_known(one.equations), _apart(one))
            for one in values
        ),
        numeric=frozenset(range(1, len(_COLUMNS))),
    )


def _known(one: Known | None) -> tuple[str, str]:
    if one is None:
        return "", ""
    value, bound = one
    digits = decimals(bound)
    return f"{value:.{digits}f}", f"{bound:.{digits}f}"


def _apart(one: BesideValue) -> str:
    return "" if one.apart is None else f"{one.apart:+.1f}"
