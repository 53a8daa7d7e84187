"""What the figures are made from, and the words for what they show. No Qt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gsapp.identification.methods import short_method_title
from gsapp.quantities import channel, symbol_text, typeset
from ui.number_format import channel_value_text
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.campaign import ManeuverResult
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary import DerivativePoint, DerivativeSummary
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
    from gsapp.report.ftr_histories import FlightEstimateHistory

_EXCLUDED_TEXT = QT_TR_NOOP("Excluded from the means manually.")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureData:
    """A run and what was worked out from it.

    Attributes
    ----------
    outcome : RunOutcome
        The run that is looked at.
    others : tuple of RunOutcome
        Runs looked at before, the newest first.
    maneuver : str
        The one that is chosen.
    units : str
        ``US`` or ``SI``.
    ftr_histories : tuple of FlightEstimateHistory or None
        FTR over the flights; None until it has listened.
    comparison : LinearModelValidation or None
        Linear models against flight; None until they are compared.
    selected_options : mapping of str to str
        What was chosen in the lists above the figures.
    """

    outcome: RunOutcome
    others: tuple[RunOutcome, ...] = ()
    maneuver: str = ""
    units: str = "US"
    ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
    comparison: LinearModelValidation | None = None
    selected_options: Mapping[str, str] = field(default_factory=dict)

    @property
    def current_maneuver(self) -> ManeuverResult:
        """Return the chosen maneuver, or the first of the run."""
        results = self.outcome.result.results
        return find_result(self.outcome, self.maneuver) or results[0]

    @property
    def priors(self) -> Mapping[str, float]:
        """Return the derivatives known before: of the model, and those that the fit leaned on."""
        request = self.outcome.request
        model = {} if request.known_model is None else request.known_model.derivatives
        priors = {name: value for name, (value, _) in request.priors.items()}
        return {**model, **priors}


def find_result(outcome: RunOutcome, maneuver: str) -> ManeuverResult | None:
    """Return what became of a maneuver; None where the run did not use it."""
    return next((one for one in outcome.result.results if one.maneuver.id == maneuver), None)


def format_run_name(outcome: RunOutcome) -> str:
    """Return what a run is called: its label, its number, its method."""
    method = short_method_title(outcome.result.settings.method)
    if outcome.request.label:
        return outcome.request.label
    return (
        tr("run {number}, {method}").format(number=outcome.number, method=method)
        if outcome.number is not None
        else method
    )


def describe_maneuver(result: ManeuverResult) -> str:
    """Return ``2:M4  δr doublet  Flight E``."""
    maneuver = result.maneuver
    moved = "+".join(symbol_text(channel(name).symbol) for name in maneuver.inputs)
    what = " ".join((moved or tr("nothing"), maneuver.kind)).strip()
    return f"{maneuver.id}  {what}  {maneuver.flight}"


def describe_conditions(conditions: Mapping[str, float], units: str) -> str:
    """Return ``V 95 ft/s, α 4.1 °``."""
    return ", ".join(
        f"{symbol_text(channel(name).symbol)} "
        f"{channel_value_text(channel(name), conditions[name], units)}"
        for name in ("V", "alpha", "beta")
        if name in conditions
    )


def describe_point(data: FigureData, derivative: str, maneuver: str) -> str:
    """Return what is known of a point: maneuver, value, conditions, why it does not count."""
    summary = data.outcome.summary.derivatives.get(derivative)
    result = find_result(data.outcome, maneuver)
    lines = [
        tr("Maneuver {maneuver}").format(maneuver=describe_maneuver(result))
        if result is not None
        else maneuver
    ]
    point = None if summary is None else _find_point(summary, maneuver)
    if summary is not None and point is not None:
        percent = f" ({100.0 * point.std / abs(point.value):.2g} %)" if point.value else ""
        lines.append(
            tr("{derivative} {value:.4g}, bound {std:.2g}{percent}").format(
                derivative=symbol_text(derivative),
                value=point.value,
                std=point.std,
                percent=percent,
            )
        )
        lines.append(
            tr("mean {mean:.4g}, bound {std:.2g}").format(
                mean=summary.value.mean, std=summary.value.std
            )
        )
        lines.append(describe_conditions(point.conditions, data.units))
        lines += _describe_exclusion(summary, maneuver)
    elif result is not None:
        from gsapp.identification.summary.campaign_summary import mean_conditions

        lines.append(describe_conditions(mean_conditions(result.maneuver), data.units))
        if maneuver in data.outcome.summary.excluded_maneuvers:
            lines.append(tr(_EXCLUDED_TEXT))
    return typeset("\n".join(line for line in lines if line))


def _find_point(summary: DerivativeSummary, maneuver: str) -> DerivativePoint | None:
    return next(
        (
            one
            for one in (*summary.points, *summary.nonconverged_points)
            if one.maneuver == maneuver
        ),
        None,
    )


def _describe_exclusion(summary: DerivativeSummary, maneuver: str) -> list[str]:
    if any(one.maneuver == maneuver for one in summary.excluded):
        return [tr(_EXCLUDED_TEXT)]
    if any(one.maneuver == maneuver for one in summary.nonconverged_points):
        return [tr("Excluded from the mean: the fit did not converge.")]
    return [
        tr("Excluded from the mean, {sigmas:+.1f} sigma off: {reasons}.").format(
            sigmas=one.sigmas, reasons="; ".join(one.reasons)
        )
        for one in summary.outliers
        if one.point.maneuver == maneuver
    ]
