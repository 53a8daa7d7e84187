"""Kept runs, one run, and two beside each other, as lines of tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ui.flight.tables import Line
from ui.words import DASH, symbol_text, with_std

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignValue
    from gsapp.identification.runs.comparing import ComparedValue, Comparison
    from gsapp.identification.runs.keeping import KeptRun

METHOD_SIGNS = {"ml": "ML", "ee": "equation error", "ftr": "FTR"}
AXIS_SIGNS = {"lon": "longitudinal", "lat": "lateral", "both": "by surfaces"}
NAMED = 1
"""Column of a run's name."""


def run_lines(runs: Sequence[KeptRun], marked: int | None, shown: int | None) -> list[Line]:
    """Return the kept runs as lines.

    Parameters
    ----------
    runs : sequence of KeptRun
    marked : int or None
        Number of the run that others are compared with.
    shown : int or None
        Of the run that figures and summary show.
    """
    lines = []
    for one in runs:
        signs = [
            word
            for on, word in ((one.number == marked, "◆ marked"), (one.number == shown, "shown"))
            if on
        ]
        lines.append(
            Line(
                key=one.number,
                cells=(
                    str(one.number),
                    one.label,
                    f"{METHOD_SIGNS.get(one.method, one.method)}, "
                    f"{AXIS_SIGNS.get(one.axis, one.axis)}",
                    str(one.maneuver_count),
                    one.when.astimezone().strftime("%d %b %H:%M"),
                    ", ".join(signs),
                ),
                detail=f"run {one.number} of {', '.join(one.flights)}",
            )
        )
    return lines


def setting_lines(run: KeptRun, comparison: Comparison | None) -> list[Line]:
    """Return the settings of a run; beside another one, those that differ."""
    if comparison is None:
        return [Line(key=name, cells=(name, words, "")) for name, words in run.settings.items()]
    return [Line(key=one.name, cells=(one.name, one.one, one.other)) for one in comparison.settings]


def value_lines(run: KeptRun, comparison: Comparison | None) -> list[Line]:
    """Return the values of a run; beside another one, both and how far they are apart."""
    if comparison is None:
        return [
            Line(key=name, cells=(symbol_text(name), value_text(value), "", ""))
            for name, value in run.values.items()
        ]
    return [_compared(one) for one in comparison.values]


def _compared(one: ComparedValue) -> Line:
    apart = "" if one.in_bounds is None else f"{abs(one.in_bounds):.1f} bounds"
    words = "only one" if one.in_bounds is None else f"▲ {apart}" if one.differs else apart
    return Line(
        key=one.name,
        cells=(symbol_text(one.name), value_text(one.one), value_text(one.other), words),
        state="caution" if one.differs else "plain",
        colored=frozenset({3}),
    )


def value_text(value: CampaignValue | None) -> str:
    """Return a mean with its bound; a dash where there is none."""
    return DASH if value is None else with_std(value.mean, value.std)


def derivative_count(names: Iterable[str]) -> int:
    """Return how many names are derivatives: the constant terms are none."""
    return sum(not name.endswith("_0") for name in names)


def run_words(run: KeptRun, comparison: Comparison | None) -> str:
    """Return what there is to say of a run, or of two beside each other."""
    if comparison is None:
        said = [f"{derivative_count(run.values)} derivatives from {run.maneuver_count} maneuvers."]
        if run.bounds_ratio is not None:
            said.append(f"Scatter over bounds {run.bounds_ratio:.1f} (1: honest).")
        if run.failures:
            said.append(f"Not fitted: {', '.join(run.failures)}.")
        if run.wild:
            said.append(f"Wild: {', '.join(run.wild)}.")
        return " ".join(said)
    far = [symbol_text(one.name) for one in comparison.values if one.differs]
    what = (
        f"{len(far)} of {len(comparison.values)} values differ: {', '.join(far[:6])}"
        f"{' …' if len(far) > 6 else ''}."
        if far
        else "No value differs by more than the bounds allow."
    )
    versions = f" Versions differ: {'; '.join(comparison.versions)}." if comparison.versions else ""
    settings = "" if comparison.settings else " The settings are the same."
    return f"{comparison.one} beside {comparison.other}: {what}{settings}{versions}"
