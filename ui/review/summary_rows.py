"""Lines and words of the page Summary: derivatives, what to look at, linear models."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from gsapp.quantities import channel, typeset
from ui.display_limits import DISPLAY
from ui.number_format import DASH, MINUS, number_text, symbol_text
from ui.widgets.row_model import TableRow

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.identification.runs.outcome import RunOutcome
    from gsapp.identification.summary import DerivativeSummary
    from gsapp.identification.summary.linear_model_validation import LinearModelValidation

DERIVATIVE_TITLES: Final = (
    "", "Mean", "Std. error", "%", "Scatter", "/ bound", "n", "Out", "Before", "Remarks",
)  # fmt: skip
"""Std. error is that of the mean; scatter the standard deviation from maneuver to maneuver,
then in times the bounds of single maneuvers."""
REMARK_COLUMN: Final = len(DERIVATIVE_TITLES) - 1
"""The column of words."""
_SCATTER_RATIO_COLUMN: Final = 5


_CONFOUNDED_PATTERN: Final = re.compile("told apart from (.+?) in this maneuver")
"""How an estimate names what it cannot tell a derivative from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AttentionItem:
    """Something in a campaign that a crew should look at.

    Attributes
    ----------
    kind : {"wild", "outlier", "failed", "gusts", "excluded"}
    maneuver : str
    derivative : str
        Empty where it is about the maneuver as a whole.
    """

    kind: Literal["wild", "outlier", "failed", "gusts", "excluded"]
    maneuver: str
    derivative: str = ""


def build_derivative_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return a line for each derivative that was earned, then for each that was not."""
    from gsapp.report.estimate_text import derivative_rows, prior_values, unknown_rows

    known = prior_values(outcome.result)
    lines = []
    for row in derivative_rows(outcome.summary, known):
        name, mean, bound, percent, scatter, ratio, n, out, before = row
        one = outcome.summary.derivatives[name]
        scatters = (
            one.bound_consistency is not None
            and one.bound_consistency.ratio > DISPLAY.max_scatter_ratio
        )
        sign = "▲ " if scatters else ""
        lines.append(
            TableRow(
                key=name,
                cells=(
                    symbol_text(name), _format_number(mean), bound, percent, scatter or DASH,
                    f"{sign}{ratio} ×" if ratio else DASH, n, out, _format_number(before),
                    "; ".join(_trend_texts(one)),
                ),
                state="caution" if scatters else "plain",
                colored=frozenset({_SCATTER_RATIO_COLUMN}),
                detail=describe_derivative(outcome, name),
            )
        )  # fmt: skip
    for name, status, why in unknown_rows(outcome.result):
        # Never a number that was not earned.
        words = _short_reason(status, why)
        cells = (symbol_text(name), *(DASH,) * 5, "0", "", DASH, typeset(words))
        lines.append(
            TableRow(key=name, cells=cells, italic=True, detail=describe_derivative(outcome, name))
        )
    return tuple(lines)


def _short_reason(status: str, why: str) -> str:
    """Return a reason in a few words; the whole of it stands beside the table."""
    others = _CONFOUNDED_PATTERN.search(why)
    if status == "not-identifiable" and others is not None:
        names = re.split(", | and ", others[1])
        return f"not told apart from {', '.join(names)}"
    return f"{_status_text(status)}: {re.split('[:;]', why)[0]}"


def _format_number(text: str) -> str:
    return number_text(float(text), len(text.partition(".")[2])) if text else DASH


def _status_text(status: str) -> str:
    return "not identifiable" if status == "not-identifiable" else status


def _trend_texts(one: DerivativeSummary) -> list[str]:
    return [
        f"changes with {channel(trend.condition).title.lower()}"
        for trend in one.trends
        if trend.is_significant
    ]


def describe_derivative(outcome: RunOutcome, name: str) -> str:
    """Return all there is to say of one derivative, in sentences."""
    from gsapp.report.estimate_text import decimals_for_std, unknown_rows

    one = outcome.summary.derivatives.get(name)
    if one is None:
        for other, status, why in unknown_rows(outcome.result):
            if other == name:
                return typeset(f"{name} is {_status_text(status)}: {why}.")
        return ""
    digits = decimals_for_std(one.value.std)
    said = [
        f"{name} is {number_text(one.value.mean, digits)} ± "
        f"{one.value.std:.{digits}f} per radian, from {one.value.n} of {len(one.points)} maneuvers."
    ]
    said += [
        f"All maneuvers fitted together: {number_text(found.value, digits)} ± "
        f"{found.std:.{digits}f}."
        for found in (fit.derivatives.get(name) for fit in outcome.result.joint)
        if found is not None and found.value is not None and found.std
    ]
    if one.bound_consistency is None and one.value.n < DISPLAY.min_scatter_values:
        said.append(
            f"Fewer than {DISPLAY.min_scatter_values} values: scatter cannot check the bounds."
        )
    elif one.bound_consistency is None:
        said.append(
            "Its bound includes an instrument zero common to all maneuvers: scatter cannot "
            "check it."
        )
    else:
        said.append(
            f"Scatter is {one.bound_consistency.ratio:.1f} times the bounds (expected by "
            f"chance: up to {one.bound_consistency.p_value:.2g})."
        )
        if one.bound_consistency.ratio > DISPLAY.max_scatter_ratio:
            said.append("The bound of the mean includes the scatter between maneuvers.")
    said += [
        f"Trend with {channel(trend.condition).title.lower()}: "
        f"{'proven' if trend.is_significant else 'not proven'} (chance alone: "
        f"{max(trend.p_value, 1e-9):.2g})."
        for trend in one.trends
    ]
    said += [
        f"Maneuver {outlier.point.maneuver} is excluded, {_sigma_text(outlier.sigmas)} off: "
        f"{'; '.join(outlier.reasons)}."
        for outlier in one.outliers
    ]
    if one.excluded:
        names = ", ".join(point.maneuver for point in one.excluded)
        said.append(f"Excluded manually: {names}.")
    return typeset(" ".join(said))


def _sigma_text(value: float) -> str:
    return f"{number_text(value, 1)} standard deviations"


ATTENTION_TITLES: Final = ("Maneuver", "What", "Why")


def build_attention_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return what to look at: wild maneuvers first, then values left out, then failures."""
    summary = outcome.summary
    lines = [
        TableRow(
            key=AttentionItem(kind="wild", maneuver=one.maneuver),
            cells=(
                one.maneuver,
                f"wild: {len(one.derivatives)} of {one.derivative_count} derivatives"
                + (", though fitted well" if one.fits_well else ""),
                typeset(f"{', '.join(one.derivatives)}: {'; '.join(one.reasons)}"),
            ),
            state="caution",
            is_bold=True,
            colored=frozenset({1}),
        )
        for one in summary.outlying_maneuvers
    ]
    # The values of a wild maneuver stand in its own line.
    wild = {one.maneuver for one in summary.outlying_maneuvers}
    lines += [
        TableRow(
            key=AttentionItem(kind="outlier", maneuver=outlier.point.maneuver, derivative=name),
            cells=(
                outlier.point.maneuver,
                f"{symbol_text(name)} {number_text(outlier.sigmas, 1)} σ off",
                "; ".join(outlier.reasons),
            ),
        )
        for name, one in summary.derivatives.items()
        for outlier in one.outliers
        if outlier.point.maneuver not in wild
    ]
    for one in outcome.result.results:
        estimate = one.estimate
        if estimate is not None and estimate.converged:
            continue
        why = one.failure if estimate is None else estimate.message
        lines.append(
            TableRow(
                key=AttentionItem(kind="failed", maneuver=one.maneuver.id),
                cells=(
                    one.maneuver.id, "not fitted" if estimate is None else "not converged", why
                ),
                state="caution",
                colored=frozenset({1}),
            )
        )  # fmt: skip
    lines += _build_gust_rows(outcome)
    lines += [
        TableRow(
            key=AttentionItem(kind="excluded", maneuver=maneuver),
            cells=(maneuver, "excluded manually", "not in any mean"),
        )
        for maneuver in sorted(summary.excluded_maneuvers)
    ]
    return tuple(lines)


def _build_gust_rows(outcome: RunOutcome) -> list[TableRow]:
    """Return a line for each maneuver in gusts: where equation error lies apart."""
    from gsapp.identification.summary.method_comparison import compare_methods

    lines = []
    for one in outcome.result.results:
        values = compare_methods(one)
        if not values:
            continue
        apart = ", ".join(symbol_text(value.name) for value in values if value.differs)
        lines.append(
            TableRow(
                key=AttentionItem(kind="gusts", maneuver=one.maneuver.id),
                cells=(
                    one.maneuver.id,
                    "flown in gusts",
                    f"equation error disagrees in {apart}: use the smaller bound"
                    if apart
                    else "equation error agrees",
                ),
                state="caution" if apart else "plain",
                colored=frozenset({1}),
            )
        )
    return lines


MODE_TITLES: Final = ("Mode", "ω, rad/s", "Damping", "Time constant, s")


def build_mode_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return the modes of the linear models with the means, both axes."""
    from gsapp.report.linear_text import mode_rows

    return tuple(
        TableRow(
            key=(axis, place),
            cells=(name, *(text.replace("-", MINUS) for text in numbers)),
            detail=f"pole {pole} 1/s".replace("-", MINUS),
        )
        for axis, model in outcome.models.items()
        for place, (name, pole, *numbers) in enumerate(mode_rows(model))
    )


ERROR_TITLES: Final = ("RMS error over range, %", "Least squares", "Subspace", "Derivatives")


def build_error_rows(comparison: LinearModelValidation) -> tuple[TableRow, ...]:
    """Return the error tables of the linear models, both axes; the least of a row has a star."""
    from gsapp.report.linear_text import error_rows

    lines = []
    for axis, one in comparison.axes.items():
        for words, found in (("", one.errors), (", whole flight", one.whole_flight_errors)):
            for name, *errors in error_rows(one.outputs, found) if found else ():
                cells = (f"{symbol_text(channel(name).symbol)}{words}", *errors)
                lines.append(TableRow(key=(axis, name, words), cells=cells))
    return tuple(lines)


def describe_comparison(comparison: LinearModelValidation) -> str:
    """Return what was fitted on what and judged on what, or why nothing was."""
    from gsapp.report.linear_text import validation_text

    said = [validation_text(one) for one in comparison.axes.values()]
    said += [f"{text[:1].upper()}{text[1:]}." for text in comparison.remarks]
    return " ".join(said)


def format_derivative_table(outcome: RunOutcome) -> str:
    """Return the table of derivatives as text with tabs, for a spreadsheet: plain numbers."""
    from gsapp.report.estimate_text import (
        DERIVATIVE_COLUMNS,
        derivative_rows,
        prior_values,
        unknown_rows,
    )

    rows: list[tuple[str, ...]] = [(*DERIVATIVE_COLUMNS, "status")]
    rows += [
        (*row, "estimated")
        for row in derivative_rows(outcome.summary, prior_values(outcome.result))
    ]
    blank = ("",) * (len(DERIVATIVE_COLUMNS) - 1)
    rows += [
        (name, *blank, f"{status}: {why}") for name, status, why in unknown_rows(outcome.result)
    ]
    return "".join("\t".join(row) + "\n" for row in rows)
