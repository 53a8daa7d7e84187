"""Lines and words of the page Summary: derivatives, what to look at, linear models."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from gsapp.quantities import channel, typeset
from ui.display_limits import DISPLAY
from ui.icons import IndicatorState
from ui.number_format import DASH, MINUS, number_text, symbol_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import TableRow

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary import DerivativeSummary
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation

DERIVATIVE_TITLES: Final = (
    "", QT_TR_NOOP("Mean"), QT_TR_NOOP("Bound"), QT_TR_NOOP("Noise"), QT_TR_NOOP("Systematic"),
    QT_TR_NOOP("Disagree"), "%", QT_TR_NOOP("Scatter"), QT_TR_NOOP("/ bound"), "n",
    QT_TR_NOOP("Out"), QT_TR_NOOP("Before"), QT_TR_NOOP("Remarks"),
)  # fmt: skip
"""Bound is that of the mean, then its parts: noise, errors of instruments and aircraft file that
all maneuvers share, and what maneuvers and methods disagree; scatter the standard deviation from
maneuver to maneuver, then in times the bounds of single maneuvers."""
REMARK_COLUMN: Final = len(DERIVATIVE_TITLES) - 1
"""The column of words."""
_SCATTER_RATIO_COLUMN: Final = 8


_CONFOUNDED_PATTERN: Final = re.compile("distinguished from (.+?) in this maneuver")
"""How an estimate names what it cannot tell a derivative from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AttentionItem:
    """Something in a campaign that a crew should look at."""

    kind: Literal["wild", "outlier", "failed", "methods", "excluded"]
    maneuver: str
    derivative: str = ""
    """Empty where it is about the maneuver as a whole."""


def build_derivative_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return a line for each derivative that was earned, then for each that was not."""
    from gsapp.report.estimate_text import derivative_rows, prior_values, unknown_rows

    known = prior_values(outcome.result)
    lines = []
    for row in derivative_rows(outcome.summary, known):
        name, mean, bound, *parts, percent, scatter, ratio, n, out, before = row
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
                    symbol_text(name), _format_number(mean), bound, *(one or DASH for one in parts),
                    percent, scatter or DASH,
                    f"{sign}{ratio} ×" if ratio else DASH, n, out, _format_number(before),
                    "; ".join((*_contradiction_texts(one), *_trend_texts(one))),
                ),
                state="caution" if scatters else "plain",
                colored=frozenset({_SCATTER_RATIO_COLUMN}),
                detail=describe_derivative(outcome, name),
            )
        )  # fmt: skip
    for name, status, why in unknown_rows(outcome.result):
        # Never a number that was not earned.
        text = _short_reason(status, why)
        cells = (symbol_text(name), *(DASH,) * 8, "0", "", DASH, typeset(text))
        lines.append(
            TableRow(key=name, cells=cells, italic=True, detail=describe_derivative(outcome, name))
        )
    return tuple(lines)


def _short_reason(status: str, why: str) -> str:
    others = _CONFOUNDED_PATTERN.search(why)
    if status == "not-identifiable" and others is not None:
        names = re.split(", | and ", others[1])
        return tr("not distinguished from {names}").format(names=", ".join(names))
    return f"{_status_text(status)}: {re.split('[:;]', why)[0]}"


def _format_number(text: str) -> str:
    return number_text(float(text), len(text.partition(".")[2])) if text else DASH


def _status_text(status: str) -> str:
    return tr("not identifiable") if status == "not-identifiable" else status


def _trend_texts(one: DerivativeSummary) -> list[str]:
    return [
        tr("changes with {condition}").format(condition=channel(trend.condition).title.lower())
        for trend in one.trends
        if trend.is_significant
    ]


def _contradiction_texts(one: DerivativeSummary) -> list[str]:
    contradicts = one.comparison is not None and bool(one.comparison.contradictions)
    return [tr("methods contradict")] if contradicts else []


def describe_derivative(outcome: RunOutcome, name: str) -> str:
    """Return all there is to say of one derivative, in sentences."""
    from gsapp.report.estimate_text import decimals_for_std, unknown_rows

    one = outcome.summary.derivatives.get(name)
    if one is None:
        for other, status, why in unknown_rows(outcome.result):
            if other == name:
                return typeset(
                    tr("{name} is {status}: {why}.").format(
                        name=name, status=_status_text(status), why=why
                    )
                )
        return ""
    digits = decimals_for_std(one.value.noise or one.value.std)
    parts = [
        tr("{name} is {mean} ± {std:.{digits}f} per radian, from {n} of {count} maneuvers.").format(
            name=name,
            mean=number_text(one.value.mean, digits),
            std=one.value.std,
            digits=digits,
            n=one.value.n,
            count=len(one.points),
        )
    ]
    parts += [
        tr("All maneuvers fitted together: {value} ± {std:.{digits}f}.").format(
            value=number_text(found.value, digits), std=found.std, digits=digits
        )
        for found in (fit.derivatives.get(name) for fit in outcome.result.joint)
        if found is not None and found.value is not None and found.std
    ]
    if one.bound_consistency is None and one.value.n < DISPLAY.min_scatter_values:
        parts.append(
            tr("Fewer than {count} values: scatter cannot check the bounds.").format(
                count=DISPLAY.min_scatter_values
            )
        )
    elif one.bound_consistency is None:
        parts.append(
            tr(
                "Its bound includes an instrument zero common to all maneuvers: scatter cannot "
                "check it."
            )
        )
    else:
        parts.append(
            tr(
                "Scatter is {ratio:.1f} times the bounds (expected by chance: up to {p_value:.2g})."
            ).format(ratio=one.bound_consistency.ratio, p_value=one.bound_consistency.p_value)
        )
        if one.bound_consistency.ratio > DISPLAY.max_scatter_ratio:
            parts.append(tr("The bound of the mean includes the scatter between maneuvers."))
    if one.value.disagreement > one.value.noise:
        parts.append(
            tr(
                "Of its bound, noise is {noise:.{digits}f}; maneuvers or methods that disagree are "
                "{disagreement:.{digits}f}."
            ).format(noise=one.value.noise, disagreement=one.value.disagreement, digits=digits)
        )
    parts += _describe_methods(one, digits)
    parts += [
        tr("Trend with {condition}: {verdict} (chance alone: {p_value:.2g}).").format(
            condition=channel(trend.condition).title.lower(),
            verdict=tr("proven") if trend.is_significant else tr("not proven"),
            p_value=max(trend.p_value, 1e-9),
        )
        for trend in one.trends
    ]
    parts += [
        tr("Maneuver {maneuver} is excluded, {sigma} off: {reasons}.").format(
            maneuver=outlier.point.maneuver,
            sigma=_sigma_text(outlier.sigmas),
            reasons="; ".join(outlier.reasons),
        )
        for outlier in one.outliers
    ]
    if one.excluded:
        names = ", ".join(point.maneuver for point in one.excluded)
        parts.append(tr("Excluded manually: {names}.").format(names=names))
    return typeset(" ".join(parts))


def _sigma_text(value: float) -> str:
    return tr("{value} standard deviations").format(value=number_text(value, 1))


ATTENTION_TITLES: Final = (QT_TR_NOOP("Maneuver"), QT_TR_NOOP("What"), QT_TR_NOOP("Why"))


def _attention_row(item: AttentionItem, what: str, why: str, state: IndicatorState) -> TableRow:
    return TableRow(
        key=item,
        cells=(item.maneuver, what, why),
        state=state,
        is_bold=item.kind == "wild",
        colored=frozenset() if item.kind in ("outlier", "excluded") else frozenset({1}),
    )


def build_attention_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return what to look at: wild maneuvers first, then values left out, then failures."""
    summary = outcome.summary
    lines = [
        _attention_row(
            AttentionItem(kind="wild", maneuver=one.maneuver),
            tr("wild: {count} of {total} derivatives").format(
                count=len(one.derivatives), total=one.derivative_count
            )
            + (tr(", though fitted well") if one.fits_well else ""),
            typeset(f"{', '.join(one.derivatives)}: {'; '.join(one.reasons)}"),
            "caution",
        )
        for one in summary.outlying_maneuvers
    ]
    # The values of a wild maneuver stand in its own line.
    wild = {one.maneuver for one in summary.outlying_maneuvers}
    lines += [
        _attention_row(
            AttentionItem(kind="outlier", maneuver=outlier.point.maneuver, derivative=name),
            tr("{name} {sigmas} σ off").format(
                name=symbol_text(name), sigmas=number_text(outlier.sigmas, 1)
            ),
            "; ".join(outlier.reasons),
            "plain",
        )
        for name, one in summary.derivatives.items()
        for outlier in one.outliers
        if outlier.point.maneuver not in wild
    ]
    for one in outcome.result.results:
        estimate = one.estimate
        if estimate is not None and estimate.converged:
            continue
        item = AttentionItem(kind="failed", maneuver=one.maneuver.id)
        if estimate is None:
            lines.append(_attention_row(item, tr("not fitted"), one.failure, "caution"))
        else:
            lines.append(_attention_row(item, tr("not converged"), estimate.message, "caution"))
    lines += _build_contradiction_rows(outcome)
    lines += [
        _attention_row(
            AttentionItem(kind="excluded", maneuver=maneuver),
            tr("excluded manually"),
            tr("not in any mean"),
            "plain",
        )
        for maneuver in sorted(summary.excluded_maneuvers)
    ]
    return tuple(lines)


def _build_contradiction_rows(outcome: RunOutcome) -> list[TableRow]:
    from gsapp.identification.methods import short_method_title
    from gsapp.identification.summary.method_comparison import compare_methods

    lines = []
    for one in outcome.result.results:
        values = compare_methods(one)
        gusty = one.estimate is not None and bool(one.estimate.gusty_maneuvers)
        apart: dict[str, list[str]] = {}
        for value in values:
            for method in value.contradictions:
                apart.setdefault(method, []).append(symbol_text(value.name))
        disagrees = tr("{method} disagrees in {apart}")
        parts = [
            disagrees.format(method=short_method_title(method), apart=", ".join(names))
            for method, names in apart.items()
        ]
        if gusty or parts:
            lines.append(
                _attention_row(
                    AttentionItem(kind="methods", maneuver=one.maneuver.id),
                    tr("flown in gusts") if gusty else tr("methods contradict each other"),
                    "; ".join(parts) or tr("all methods agree"),
                    "caution" if parts else "plain",
                )
            )
    return lines


def _describe_methods(one: DerivativeSummary, digits: int) -> list[str]:
    """Return the mean by each other method, and whether it contradicts."""
    from gsapp.identification.methods import short_method_title

    if one.comparison is None:
        return []
    contradicts = tr("By {method}: {value} ± {bound:.{digits}f}, a contradiction.")
    agrees = tr("By {method}: {value} ± {bound:.{digits}f}.")
    return [
        (contradicts if method in one.comparison.contradictions else agrees).format(
            method=short_method_title(method),
            value=number_text(value, digits),
            bound=bound,
            digits=digits,
        )
        for method, (value, bound) in one.comparison.values.items()
        if method != one.comparison.method
    ]


MODE_TITLES: Final = (
    QT_TR_NOOP("Mode"), QT_TR_NOOP("ω, rad/s"), QT_TR_NOOP("Damping"),
    QT_TR_NOOP("Time constant, s"),
)  # fmt: skip


def build_mode_rows(outcome: RunOutcome) -> tuple[TableRow, ...]:
    """Return the modes of the linear models with the means, both axes."""
    from gsapp.report.linear_text import mode_rows

    return tuple(
        TableRow(
            key=(axis, index),
            cells=(name, *(text.replace("-", MINUS) for text in numbers)),
            detail=tr("pole {pole} 1/s").format(pole=pole).replace("-", MINUS),
        )
        for axis, model in outcome.models.items()
        for index, (name, pole, *numbers) in enumerate(mode_rows(model))
    )


ERROR_TITLES: Final = (
    QT_TR_NOOP("RMS error over range, %"), QT_TR_NOOP("Least squares"), QT_TR_NOOP("Subspace"),
    QT_TR_NOOP("Derivatives"),
)  # fmt: skip


def build_error_rows(comparison: LinearModelValidation) -> tuple[TableRow, ...]:
    """Return the error tables of the linear models, both axes; the least of a row has a star."""
    from gsapp.report.linear_text import error_rows

    lines = []
    for axis, one in comparison.axes.items():
        for text, found in (("", one.errors), (tr(", whole flight"), one.whole_flight_errors)):
            for name, *errors in error_rows(one.outputs, found) if found else ():
                cells = (f"{symbol_text(channel(name).symbol)}{text}", *errors)
                lines.append(TableRow(key=(axis, name, text), cells=cells))
    return tuple(lines)


def describe_comparison(comparison: LinearModelValidation) -> str:
    """Return what was fitted on what and judged on what, or why nothing was."""
    from gsapp.report.linear_text import validation_text

    parts = [validation_text(one) for one in comparison.axes.values()]
    parts += [f"{text[:1].upper()}{text[1:]}." for text in comparison.remarks]
    return " ".join(parts)


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
