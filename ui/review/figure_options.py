"""What can be chosen above each figure: derivatives, conditions, maneuvers, runs. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gsapp.identification.axes import AXIS_COEFFICIENTS, AXIS_TITLES
from gsapp.quantities import name_in_text, symbol_text
from ui.review.figure_data import FigureData, describe_maneuver, find_result, format_run_name
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.campaign import ManeuverResult
    from gsapp.identification.results import Estimate
    from gsapp.identification.summary.campaign_linear_models import AxisValidation

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
    """A list above a figure.

    Attributes
    ----------
    id : str
        Key of what is chosen.
    title : str
    choices : tuple of (key, words)
    """

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
    choices = tuple((key, words) for key, words in groups.items() if _filter_by_group(names, key))
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
    """Return those of an axis, of a coefficient, or of effects."""
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
        (str(place), format_run_name(one))
        for place, one in enumerate(data.others)
        if (found := find_result(one, data.current_maneuver.maneuver.id)) is not None
        and shown & _computed_channels(found)
    ]
    return FigureOption(
        id="beside", title=tr("Compare with"), choices=(("", tr("no other run")), *comparable)
    )


def _computed_channels(result: ManeuverResult) -> frozenset[str]:
    """Return the responses or coefficients that a fit computed."""
    histories = () if result.estimate is None else result.estimate.histories
    return frozenset(name for one in histories for name in one.channels)


def fit_option(data: FigureData) -> FigureOption:
    """Return the fits of the run: of each maneuver, and of several together."""
    joint = tuple(
        (
            f"{JOINT_PREFIX}{place}",
            tr("{count} maneuvers jointly, {axis}").format(
                count=len(one.maneuvers), axis=axis_text(one)
            ),
        )
        for place, one in enumerate(data.outcome.result.joint)
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
