"""What the figures are made from, in words, and what can be chosen above each. No Qt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gsapp.identification.axes import AXIS_COEFFICIENTS, AXIS_TITLES
from gsapp.identification.methods import short_method_title
from gsapp.quantities import channel, name_in_text, symbol_text, typeset
from ui.number_format import channel_value_text
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.campaign import ManeuverResult
    from gsapp.identification.results import Estimate
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary import DerivativePoint, DerivativeSummary
    from gsapp.identification.summary.campaign_linear_models import (
        AxisValidation,
        LinearModelValidation,
    )
    from gsapp.report.ftr_histories import FlightEstimateHistory

_EXCLUDED_TEXT = QT_TR_NOOP("Excluded from the means manually.")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureData:
    """A run and what was worked out from it."""

    outcome: RunOutcome
    others: tuple[RunOutcome, ...] = ()
    maneuver: str = ""
    units: str = "US"
    ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
    """FTR over the flights; None until it has listened."""
    comparison: LinearModelValidation | None = None
    selected_options: Mapping[str, str] = field(default_factory=dict)

    @property
    def current_maneuver(self) -> ManeuverResult:
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
    """Return what a run is called: its label, its number, its methods (in gusts another one)."""
    result = outcome.result
    used = [one.estimate.method for one in result.results if one.estimate is not None]
    method = ", ".join(
        tr(short_method_title(one)) for one in dict.fromkeys(used or [result.settings.method])
    )
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
        bound = summary.bound(point)
        percent = f" ({100.0 * bound / abs(point.value):.2g} %)" if point.value else ""
        lines.append(
            tr("{derivative} {value:.4g}, bound {std:.2g}{percent}").format(
                derivative=symbol_text(derivative),
                value=point.value,
                std=bound,
                percent=percent,
            )
        )
        if bound > point.std:
            lines.append(
                tr("noise {noise:.2g}, disagreement {disagreement:.2g}").format(
                    noise=point.std, disagreement=summary.point_disagreement
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


OptionChoices = tuple[tuple[str, str], ...]
"""Keys and words of a list."""

JOINT_PREFIX = "joint "
"""Begins the key of a fit of several maneuvers together."""
_CONDITIONS = (
    ("number", QT_TR_NOOP("maneuver")),
    *((name, name_in_text(name)) for name in ("V", "alpha", "beta")),
)
_COEFFICIENTS = AXIS_COEFFICIENTS["both"]
_EFFECTS_GROUP = "effects"


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureOption:
    """A list above a figure."""

    id: str
    title: str
    choices: OptionChoices


def selected_choice(data: FigureData, option: FigureOption) -> str:
    """Return what is chosen in a list: the first where the last choice is not there."""
    wanted = data.selected_options.get(option.id, "")
    keys = [key for key, _ in option.choices]
    return wanted if wanted in keys else keys[0] if keys else ""


def derivative_group_option(data: FigureData) -> FigureOption:
    """Return which derivatives can be looked at together, and each alone."""
    names = _plotted_derivatives(data)
    groups = {
        **{axis: tr("all {axis}").format(axis=AXIS_TITLES[axis]) for axis in ("lon", "lat")},
        **{one: tr("of {control}").format(control=symbol_text(one)) for one in _COEFFICIENTS},
        _EFFECTS_GROUP: tr("parameters of effects"),
    }
    choices = tuple((key, text) for key, text in groups.items() if _filter_by_group(names, key))
    return FigureOption(
        id="group",
        title=tr("Derivatives"),
        choices=(*choices, *((name, symbol_text(name)) for name in names)),
    )


def derivatives_in_group(data: FigureData, group: str) -> tuple[str, ...]:
    """Return the derivatives of a group."""
    names = _plotted_derivatives(data)
    return (group,) if group in names else _filter_by_group(names, group)


def _plotted_derivatives(data: FigureData) -> tuple[str, ...]:
    """Return what has figures: all that was estimated but the values at zero."""
    found = data.outcome.summary.derivatives
    return tuple(name for name in found if not name.endswith("_0"))


def _filter_by_group(names: Sequence[str], group: str) -> tuple[str, ...]:
    wanted = AXIS_COEFFICIENTS.get(group, (group,))
    if group == _EFFECTS_GROUP:
        return tuple(name for name in names if name.partition("_")[0] not in _COEFFICIENTS)
    return tuple(name for name in names if name.partition("_")[0] in wanted)


def abscissa_option(data: FigureData) -> FigureOption:
    """Return what values can be drawn against: only what was measured."""
    flown = {
        name
        for one in data.outcome.summary.derivatives.values()
        for point in one.points
        for name in point.conditions
    }
    return FigureOption(
        id="over",
        title=tr("Against"),
        choices=tuple(one for one in _CONDITIONS if one[0] == "number" or one[0] in flown),
    )


def maneuver_option(data: FigureData) -> FigureOption:
    """Return the maneuvers of the run."""
    return FigureOption(
        id="maneuver",
        title=tr("Maneuver"),
        choices=tuple(
            (one.maneuver.id, describe_maneuver(one)) for one in data.outcome.result.results
        ),
    )


def comparison_run_option(data: FigureData) -> FigureOption:
    """Return the runs that a fit can be compared with: those that computed the same, too."""
    shown = _computed_channels(data.current_maneuver)
    comparable = [
        (str(index), format_run_name(one))
        for index, one in enumerate(data.others)
        if (found := find_result(one, data.current_maneuver.maneuver.id)) is not None
        and shown & _computed_channels(found)
    ]
    return FigureOption(
        id="beside", title=tr("Compare with"), choices=(("", tr("no other run")), *comparable)
    )


def _computed_channels(result: ManeuverResult) -> frozenset[str]:
    histories = () if result.estimate is None else result.estimate.histories
    return frozenset(name for one in histories for name in one.channels)


def fit_option(data: FigureData) -> FigureOption:
    """Return the fits of the run: of each maneuver, and of several together."""
    joint = tuple(
        (
            f"{JOINT_PREFIX}{index}",
            tr("{count} maneuvers jointly, {axis}").format(
                count=len(one.maneuvers), axis=axis_text(one)
            ),
        )
        for index, one in enumerate(data.outcome.result.joint)
    )
    single = maneuver_option(data)
    return FigureOption(id="maneuver", title=tr("Fit"), choices=(*single.choices, *joint))


def axis_text(estimate: Estimate) -> str:
    """Return the axis of a fit in words."""
    return AXIS_TITLES[estimate.axis]


def flight_option(data: FigureData) -> FigureOption:
    """Return the flights that FTR listened to."""
    return FigureOption(
        id="flight",
        title=tr("Flight"),
        choices=tuple((one.flight, one.flight) for one in data.ftr_histories or ()),
    )


def ftr_axis_option(_material: FigureData) -> FigureOption:
    """Return the axes whose derivatives formed in flight."""
    return _axis_option(("lon", "lat"))


def linear_model_axis_option(data: FigureData) -> FigureOption:
    """Return the axes that linear models were judged in."""
    axes = () if data.comparison is None else tuple(data.comparison.axes)
    return _axis_option(axes)


def selected_validation(data: FigureData) -> AxisValidation | None:
    """Return the validation of the linear models in the selected axis; None for none."""
    axis = selected_choice(data, linear_model_axis_option(data))
    axes = {} if data.comparison is None else data.comparison.axes
    return next((one for name, one in axes.items() if name == axis), None)


def _axis_option(axes: Sequence[str]) -> FigureOption:
    choices = tuple((one, AXIS_TITLES[one]) for one in axes)
    return FigureOption(id="axis", title=tr("Axis"), choices=choices)


def held_out_option(data: FigureData) -> FigureOption:
    """Return the maneuvers that the linear models were judged on."""
    validation = selected_validation(data)
    traces = () if validation is None else validation.traces
    return FigureOption(
        id="kept_out",
        title=tr("Maneuver"),
        choices=(
            ("", tr("some of them")),
            *(
                (
                    one.maneuver,
                    tr("{maneuver} of {flight}").format(maneuver=one.maneuver, flight=one.flight),
                )
                for one in traces
            ),
        ),
    )
