"""What a campaign says, in sentences and rows of tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.methods import short_method_title
from gsapp.identification.results import Estimate
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.statistics.influence import influence_warnings
from gsapp.identification.summary import CampaignSummary, ConditionTrend, DerivativeSummary
from gsapp.identification.summary.method_comparison import contradiction_warnings
from gsapp.quantities import channel, clock_text, from_si
from gsapp.report.settings import REPORT


def estimate_headline(summary: CampaignSummary, result: CampaignResult) -> str:
    """Return what to read if nothing else."""
    known = [one for name, one in summary.derivatives.items() if not name.endswith("_0")]
    well = sum(_percent(one) <= REPORT.well_known_percent for one in known)
    maneuvers = sum(one.estimate is not None for one in result.results)
    flights = len({one.maneuver.flight for one in result.results})
    text = (
        f"{_count(maneuvers, 'maneuver')} of {_count(flights, 'flight')} "
        f"{'gives' if maneuvers == 1 else 'give'} "
        + (
            f"{_count(len(known), 'derivative')}, {well} of them to "
            f"{REPORT.well_known_percent:.0f} % or better."
            if known
            else "no derivative."
        )
    )
    if summary.outlying_maneuvers:
        text += (
            f" {_count(len(summary.outlying_maneuvers), 'maneuver')} "
            f"{'is' if len(summary.outlying_maneuvers) == 1 else 'are'} outlying."
        )
    return text


def prior_values(result: CampaignResult) -> dict[str, float]:
    """Return the derivatives that were known before: those of the model, where one was given."""
    model = result.settings.known_model
    return {} if model is None else dict(model.derivatives)


def exclusion_text(summary: CampaignSummary) -> tuple[str, ...]:
    """Return in a sentence what was left out by hand; empty for nothing."""
    if not summary.excluded_maneuvers:
        return ()
    return (
        "Excluded from all means manually: "
        f"{_count(len(summary.excluded_maneuvers), 'maneuver')} "
        f"({', '.join(sorted(summary.excluded_maneuvers))}).",
    )


def _count(number: int, word: str) -> str:
    return f"{number} {word}" if number == 1 else f"{number} {word}s"


def _shown(percent: float) -> str:
    """Return a percentage with two digits; more than the value itself says nothing more."""
    if percent > 100.0:
        return "> 100"
    return f"{percent:.0f}" if percent >= 9.5 else f"{percent:.1f}"


def _percent(one: DerivativeSummary) -> float:
    return 100.0 * one.value.std / abs(one.value.mean) if one.value.mean else float("inf")


def bound_consistency_text(summary: CampaignSummary) -> str:
    """Return whether the bounds can be believed."""
    ratio = summary.bounds_ratio
    if ratio is None:
        return "Nothing was flown three times: scatter cannot check the bounds."
    low, high = REPORT.consistent_ratio
    if ratio > high:
        return (
            f"The scatter between maneuvers is {ratio:.1f} times their bounds: differences "
            "between maneuvers (air, speed, play, clipped sensors) are not in the bounds of "
            "single values; the bounds of the means include them."
        )
    if ratio < low:
        return f"The scatter is {ratio:.1f} times their bounds: the bounds are conservative."
    return (
        f"The scatter between maneuvers is {ratio:.1f} times their bounds: the bounds are "
        "consistent."
    )


def derivative_rows(
    summary: CampaignSummary, known: Mapping[str, float]
) -> Iterator[tuple[str, ...]]:
    """Return the table of results: one row for each derivative."""
    for name, one in summary.derivatives.items():
        digits = decimals_for_std(one.value.std)
        scatter = "" if one.value.scatter is None else f"{one.value.scatter:.{digits}f}"
        ratio = "" if one.bound_consistency is None else f"{one.bound_consistency.ratio:.1f}"
        before = f"{known[name]:.{digits}f}" if name in known else ""
        parts = (one.value.noise, one.value.systematic, one.value.disagreement)
        yield (
            name,
            f"{one.value.mean:.{digits}f}",
            f"{one.value.std:.{digits}f}",
            *(f"{part:.{decimals_for_std(part)}f}" if part else "" for part in parts),
            "" if name.endswith("_0") else _shown(_percent(one)),
            scatter,
            ratio,
            str(one.value.n),
            str(len(one.outliers)) if one.outliers else "",
            before,
        )


DERIVATIVE_COLUMNS: Final = (
    "derivative", "mean", "bound", "noise", "systematic", "disagree", "%",
    "scatter", "scatter / bound", "n", "left out", "before",
)  # fmt: skip
"""Bound is that of the mean, then its parts: noise, what all maneuvers share, and what maneuvers
and methods disagree; scatter the standard deviation from maneuver to maneuver."""


def decimals_for_std(std: float) -> int:
    """Return the digits after the point that a bound earns: two of its own."""
    digits = 1
    while digits < 8 and std < 9.5 * 10.0**-digits:
        digits += 1
    return digits


def unknown_rows(result: CampaignResult) -> tuple[tuple[str, str, str], ...]:
    """Return derivatives that no maneuver gave, with status and reason."""
    given = {
        name
        for one in result.results
        if one.estimate is not None
        for name, found in one.estimate.derivatives.items()
        if found.status == "estimated"
    }
    why: dict[str, tuple[str, str]] = {}
    for one in result.results:
        if one.estimate is None:
            continue
        for name, found in one.estimate.derivatives.items():
            if name not in given and found.status in ("unknown", "not-identifiable"):
                why.setdefault(name, (found.status, found.why))
    order = {name: index for index, name in enumerate(derivative_names())}
    names = sorted(why, key=lambda name: order.get(name, len(order)))
    return tuple((name, *why[name]) for name in names)


JOINT_COLUMNS: Final = ("derivative", "together", "bound", "mean", "difference, in joint bounds")


def joint_rows(result: CampaignResult, summary: CampaignSummary) -> tuple[tuple[str, ...], ...]:
    """Return what a fit of all maneuvers together gives, beside the means of the single fits."""
    rows = []
    for estimate in result.joint:
        for name, found in estimate.derivatives.items():
            if found.status != "estimated" or found.value is None or not found.std:
                continue
            digits = decimals_for_std(found.std)
            mean = summary.derivatives.get(name)
            beside = ("", "")
            if mean is not None:
                apart = (found.value - mean.value.mean) / math.hypot(found.std, mean.value.std)
                beside = (f"{mean.value.mean:.{digits}f}", f"{apart:+.1f}")
            rows.append((name, f"{found.value:.{digits}f}", f"{found.std:.{digits}f}", *beside))
    return tuple(rows)


def outlier_rows(summary: CampaignSummary) -> tuple[tuple[str, ...], ...]:
    """Return the values that were left out: derivative, maneuver, how far off, why."""
    return tuple(
        (
            name,
            f"{outlier.point.maneuver} {outlier.point.flight}",
            f"{outlier.point.value:.{decimals_for_std(outlier.point.std)}f}",
            f"{outlier.sigmas:+.1f}",
            "; ".join(outlier.reasons),
        )
        for name, one in summary.derivatives.items()
        for outlier in one.outliers
    )


def outlier_maneuver_text(summary: CampaignSummary) -> tuple[str, ...]:
    """Return a sentence for each maneuver whose values are wild."""
    return tuple(
        f"Maneuver {one.maneuver} is an outlier: {len(one.derivatives)} of its "
        f"{one.derivative_count} derivatives ({', '.join(one.derivatives)}) are outliers"
        + (", though its responses are fitted well" if one.fits_well else "")
        + f". {_capital('; '.join(one.reasons))}."
        for one in summary.outlying_maneuvers
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def trend_text(summary: CampaignSummary, units: str) -> tuple[str, ...]:
    """Return a sentence for each trend that is proven."""
    return tuple(
        _trend(one, trend, units)
        for one in summary.derivatives.values()
        for trend in one.trends
        if trend.is_significant
    )


def _trend(one: DerivativeSummary, trend: ConditionTrend, units: str) -> str:
    spec = channel(trend.condition)
    unit = spec.display_unit(units)
    step = float(
        from_si(1.0, unit, spec.quantity) - from_si(0.0, unit, spec.quantity)
    )  # display units per SI unit
    slope, std = trend.slope / step, trend.std / step
    digits = decimals_for_std(std)
    return (
        f"{one.name} changes with {spec.title.lower()}: {slope:+.{digits}f} +- {std:.{digits}f} "
        f"for each {unit} (chance alone: {max(trend.p_value, 1e-9):.1g})."
    )


def maneuver_rows(results: Sequence[ManeuverResult], units: str) -> tuple[tuple[str, ...], ...]:
    """Return a row for each maneuver: what was flown, and how well it was fitted."""
    from gsapp.identification.summary.campaign_summary import mean_conditions

    rows = []
    for one in results:
        maneuver, estimate = one.maneuver, one.estimate
        conditions = mean_conditions(maneuver)
        fits = {} if estimate is None else estimate.fit
        worst = min(fits.items(), key=lambda pair: pair[1].r2, default=None)
        if estimate is None:
            state = one.failure
        elif not estimate.converged:
            state = f"not converged: {estimate.message}"
        else:
            state = "" if worst is None else f"{worst[0]} {worst[1].r2:.3f}"
        rows.append(
            (
                maneuver.id,
                maneuver.flight,
                f"{clock_text(maneuver.t_start, decimals=1)} to "
                f"{clock_text(maneuver.t_end, decimals=1)}",
                f"{'+'.join(maneuver.inputs) or 'none'} {maneuver.kind}".strip(),
                *(_condition(conditions, name, units) for name in ("V", "alpha")),
                state,
            )
        )
    return tuple(rows)


def maneuver_columns(units: str) -> tuple[str, ...]:
    """Return the headings of `maneuver_rows`."""
    return (
        "maneuver", "flight", "time", "input", f"V [{channel('V').display_unit(units)}]",
        "alpha [deg]", "worst R2",
    )  # fmt: skip


def _condition(conditions: Mapping[str, float], name: str, units: str) -> str:
    if name not in conditions:
        return ""
    spec = channel(name)
    unit = spec.display_unit(units)
    return f"{from_si(conditions[name], unit, spec.quantity):.{spec.decimals(unit)}f}"


def outcome_remarks(outcome: RunOutcome) -> list[str]:
    """Return what is to be said, each sentence once, with the maneuvers it is about."""
    said: dict[str, list[str]] = {}
    for one in outcome.result.results:
        told = (one.failure,) if one.estimate is None else one.estimate.warnings
        told = (*told, *_comparison_warnings(one))
        why = () if one.estimate is None else _unknown_reasons(one.estimate)
        # The maneuvers are named once, in front.
        own = f"maneuver {one.maneuver.id}: "
        for sentence in (*told, *why):
            said.setdefault(sentence.removeprefix(own), []).append(one.maneuver.id)
    remarks = dict.fromkeys(
        (
            *outcome.remarks,
            *outcome.result.remarks,
            *contradiction_warnings(outcome.result),
            *(
                f"joint fit, axis {fit.axis}: {text}"
                for fit in outcome.result.joint
                for text in influence_warnings(fit.influences)
            ),
        )
    )
    return [
        *remarks,
        *(
            f"maneuver{'s' if len(ids) > 1 else ''} {', '.join(ids)}: {sentence}"
            for sentence, ids in said.items()
        ),
    ]


def _unknown_reasons(estimate: Estimate) -> tuple[str, ...]:
    """Return each reason for which derivatives were not earned, once, with their names."""
    reasons: dict[str, list[str]] = {}
    for name, found in estimate.derivatives.items():
        if found.status in ("unknown", "not-identifiable") and found.why:
            reasons.setdefault(found.why, []).append(name)
    every = sum(len(names) for names in reasons.values())
    return tuple(
        f"{'no derivative' if len(names) == every > 1 and not estimate.free else ', '.join(names)}"
        f": {why}"
        for why, names in reasons.items()
        # Said already.
        if why not in estimate.warnings
    )


def _comparison_warnings(one: ManeuverResult) -> tuple[str, ...]:
    """Return what other methods warn of and the own does not."""
    own = () if one.estimate is None else one.estimate.warnings
    return tuple(
        f"{short_method_title(method)}: {text}"
        for method, estimate in one.comparisons.items()
        for text in estimate.warnings
        if text not in own
    )
