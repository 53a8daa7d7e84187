"""What can be chosen above each figure: derivatives, conditions, maneuvers, runs. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gsapp.quantities import symbol_text
from ui.review.figures_material import Material, maneuver_words, result_of, run_name

if TYPE_CHECKING:
    from gsapp.identification.campaign import ManeuverResult
    from gsapp.identification.results import Estimate

Choices = tuple[tuple[str, str], ...]
"""Keys and words of a list."""

JOINT = "joint "
"""Begins the key of a fit of several maneuvers together."""
_CONDITIONS = (("number", "maneuver"), ("V", "speed"), ("alpha", "angle of attack"),
               ("beta", "sideslip"))  # fmt: skip
LONGITUDINAL = ("CN", "CA", "Cm")
"""Coefficients of the longitudinal axis."""
_COEFFICIENTS = (*LONGITUDINAL, "CY", "Cl", "Cn")
_EFFECTS = "effects"
AXES = {"lon": "longitudinal", "lat": "lateral"}
"""Words for the axes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
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
    choices: Choices


def chosen(material: Material, option: Option) -> str:
    """Return what is chosen in a list: the first where the last choice is not there."""
    wanted = material.chosen.get(option.id, "")
    keys = [key for key, _ in option.choices]
    return wanted if wanted in keys else keys[0] if keys else ""


def group_of(material: Material) -> Option:
    """Return which derivatives can be looked at together, and each alone."""
    names = _names(material)
    groups = {
        **{axis: f"all {words}" for axis, words in AXES.items()},
        **{one: f"of {symbol_text(one)}" for one in _COEFFICIENTS},
        _EFFECTS: "parameters of effects",
    }
    choices = tuple((key, words) for key, words in groups.items() if _within(names, key))
    return Option(
        id="group",
        title="Derivatives",
        choices=(*choices, *((name, symbol_text(name)) for name in names)),
    )


def names_in(material: Material, group: str) -> tuple[str, ...]:
    """Return the derivatives of a group."""
    names = _names(material)
    return (group,) if group in names else _within(names, group)


def _names(material: Material) -> tuple[str, ...]:
    """Return what has figures: all that was estimated but the values at zero."""
    found = material.outcome.summary.derivatives
    return tuple(name for name in found if not name.endswith("_0"))


def _within(names: Sequence[str], group: str) -> tuple[str, ...]:
    """Return those of an axis, of a coefficient, or of effects."""
    lateral = tuple(one for one in _COEFFICIENTS if one not in LONGITUDINAL)
    wanted = {"lon": LONGITUDINAL, "lat": lateral}.get(group, (group,))
    if group == _EFFECTS:
        return tuple(name for name in names if name.partition("_")[0] not in _COEFFICIENTS)
    return tuple(name for name in names if name.partition("_")[0] in wanted)


def over_of(material: Material) -> Option:
    """Return what values can be drawn against: only what was measured."""
    flown = {
        name
        for one in material.outcome.summary.derivatives.values()
        for point in one.points
        for name in point.conditions
    }
    return Option(
        id="over",
        title="Against",
        choices=tuple(one for one in _CONDITIONS if one[0] == "number" or one[0] in flown),
    )


def maneuver_of(material: Material) -> Option:
    """Return the maneuvers of the run."""
    return Option(
        id="maneuver",
        title="Maneuver",
        choices=tuple(
            (one.maneuver.id, maneuver_words(one)) for one in material.outcome.result.results
        ),
    )


def beside_of(material: Material) -> Option:
    """Return the runs that a fit can be compared with: those that computed the same, too."""
    shown = _computed(material.looked_at)
    comparable = [
        (str(place), run_name(one))
        for place, one in enumerate(material.others)
        if (found := result_of(one, material.looked_at.maneuver.id)) is not None
        and shown & _computed(found)
    ]
    return Option(id="beside", title="Compare with", choices=(("", "no other run"), *comparable))


def _computed(result: ManeuverResult) -> frozenset[str]:
    """Return the responses or coefficients that a fit computed."""
    histories = () if result.estimate is None else result.estimate.histories
    return frozenset(name for one in histories for name in one.channels)


def fit_of(material: Material) -> Option:
    """Return the fits of the run: of each maneuver, and of several together."""
    joint = tuple(
        (f"{JOINT}{place}", f"{len(one.maneuvers)} maneuvers together, {axis_words(one)}")
        for place, one in enumerate(material.outcome.result.joint)
    )
    single = maneuver_of(material)
    return Option(id="maneuver", title="Fit", choices=(*single.choices, *joint))


def axis_words(estimate: Estimate) -> str:
    """Return the axis of a fit in words."""
    return AXES.get(estimate.axis, "six degrees of freedom")


def flight_of(material: Material) -> Option:
    """Return the flights that FTR listened to."""
    return Option(
        id="flight",
        title="Flight",
        choices=tuple((one.flight, one.flight) for one in material.heard or ()),
    )


def axis_formed(_material: Material) -> Option:
    """Return the axes whose derivatives formed in flight."""
    return Option(id="axis", title="Axis", choices=tuple(AXES.items()))


def axis_judged(material: Material) -> Option:
    """Return the axes that linear models were judged in."""
    axes = () if material.comparison is None else tuple(material.comparison.axes)
    return Option(id="axis", title="Axis", choices=tuple((one, AXES[one]) for one in axes))


def kept_out_of(material: Material) -> Option:
    """Return the maneuvers that the linear models were judged on."""
    axis = chosen(material, axis_judged(material))
    traces = material.comparison.axes[axis].traces if material.comparison and axis else ()
    return Option(
        id="kept_out",
        title="Maneuver",
        choices=(
            ("", "some of them"),
            *((one.maneuver, f"{one.maneuver} of {one.flight}") for one in traces),
        ),
    )
