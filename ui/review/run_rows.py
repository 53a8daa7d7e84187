"""Kept runs, one run, and two beside each other, as lines of tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.methods import short_method_title
from ui.number_format import DASH, symbol_text, value_with_std_text
from ui.translation import tr
from ui.widgets.row_model import TableRow

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignValue
    from gsapp.identification.runs.run_comparison import RunComparison, ValueDifference
    from gsapp.identification.runs.run_store import StoredRun

NAME_COLUMN_INDEX = 1
"""Column of a run's name."""


def build_run_rows(
    runs: Sequence[StoredRun], marked: int | None, shown: int | None
) -> list[TableRow]:
    """Return the kept runs as lines.

    Parameters
    ----------
    marked : int or None
        Number of the run that others are compared with.
    """
    lines = []
    for one in runs:
        signs = [
            word
            for on, word in (
                (one.number == marked, tr("◆ marked")),
                (one.number == shown, tr("shown")),
            )
            if on
        ]
        lines.append(
            TableRow(
                key=one.number,
                cells=(
                    str(one.number),
                    one.label,
                    short_method_title(one.method)
                    + ", "
                    + (tr("by surfaces") if one.axis == "both" else AXIS_TITLES[one.axis]),
                    str(one.maneuver_count),
                    one.created_at.astimezone().strftime("%d %b %H:%M"),
                    ", ".join(signs),
                ),
                detail=tr("run {number} of {flights}").format(
                    number=one.number, flights=", ".join(one.flights)
                ),
            )
        )
    return lines


def build_setting_rows(run: StoredRun, comparison: RunComparison | None) -> list[TableRow]:
    """Return the settings of a run; beside another one, those that differ."""
    if comparison is None:
        return [TableRow(key=name, cells=(name, words, "")) for name, words in run.settings.items()]
    return [
        TableRow(key=one.name, cells=(one.name, one.one, one.other)) for one in comparison.settings
    ]


def build_run_value_rows(run: StoredRun, comparison: RunComparison | None) -> list[TableRow]:
    """Return the values of a run; beside another one, both and how far they are apart."""
    if comparison is None:
        return [
            TableRow(key=name, cells=(symbol_text(name), mean_text(value), "", ""))
            for name, value in run.values.items()
        ]
    return [_build_comparison_row(one) for one in comparison.values]


def _build_comparison_row(one: ValueDifference) -> TableRow:
    apart = (
        "" if one.in_bounds is None else tr("{bounds:.1f} bounds").format(bounds=abs(one.in_bounds))
    )
    words = tr("single value") if one.in_bounds is None else f"▲ {apart}" if one.differs else apart
    return TableRow(
        key=one.name,
        cells=(symbol_text(one.name), mean_text(one.one), mean_text(one.other), words),
        state="caution" if one.differs else "plain",
        colored=frozenset({3}),
    )


def mean_text(value: CampaignValue | None) -> str:
    """Return a mean with its bound; a dash where there is none."""
    return DASH if value is None else value_with_std_text(value.mean, value.std)


def count_derivatives(names: Iterable[str]) -> int:
    """Return how many names are derivatives: the constant terms are none."""
    return sum(not name.endswith("_0") for name in names)


def describe_run(run: StoredRun, comparison: RunComparison | None) -> str:
    """Return what there is to say of a run, or of two beside each other."""
    if comparison is None:
        said = [
            tr("{count} derivatives from {maneuvers} maneuvers.").format(
                count=count_derivatives(run.values), maneuvers=run.maneuver_count
            )
        ]
        if run.bounds_ratio is not None:
            said.append(
                tr("Scatter / bound: {ratio:.1f} (1 = consistent).").format(ratio=run.bounds_ratio)
            )
        if run.failures:
            said.append(tr("Not fitted: {failures}.").format(failures=", ".join(run.failures)))
        if run.outlying_maneuvers:
            said.append(tr("Wild: {names}.").format(names=", ".join(run.outlying_maneuvers)))
        return " ".join(said)
    far = [symbol_text(one.name) for one in comparison.values if one.differs]
    what = (
        tr("{count} of {total} values differ: {values}{more}.").format(
            count=len(far),
            total=len(comparison.values),
            values=", ".join(far[:6]),
            more=" …" if len(far) > 6 else "",
        )
        if far
        else tr("No value differs by more than the bounds allow.")
    )
    versions = (
        tr(" Versions differ: {versions}.").format(versions="; ".join(comparison.versions))
        if comparison.versions
        else ""
    )
    settings = "" if comparison.settings else tr(" The settings are the same.")
    return tr("{one} beside {other}: {what}{settings}{versions}").format(
        one=comparison.one, other=comparison.other, what=what, settings=settings, versions=versions
    )
