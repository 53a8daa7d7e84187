"""The figures of the review: what each shows, what can be chosen in it, and how it is made.

Pictures are the report's own. They are made in the thread that draws them; matplotlib is loaded
there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ui.review.figure_drawing import Room
from ui.review.figures_material import Material, maneuver_words, run_name

if TYPE_CHECKING:
    from gsapp.identification.results import Estimate
    from gsapp.identification.summary.mode_spread import SpreadMode
    from gsapp.report.document import Picture, Table
    from gsapp.report.palette import Palette

Choices = tuple[tuple[str, str], ...]
"""Keys and words of a list."""

_CHART = 2.3
"""Inches that a small chart of a value takes at least."""
_HISTORY = 3.2
"""Inches of a history over a flight."""
_CONDITIONS = (("number", "maneuver"), ("V", "speed"), ("alpha", "angle of attack"),
               ("beta", "sideslip"))  # fmt: skip
_LONGITUDINAL = ("CN", "CA", "Cm")
_COEFFICIENTS = (*_LONGITUDINAL, "CY", "Cl", "Cn")
_AXES = {"lon": "longitudinal", "lat": "lateral"}
_NO_RESPONSES = (
    "{method} computes no responses to hold against the measured ones. Estimate with maximum "
    "likelihood to see how well this maneuver is followed."
)


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureKind:
    """One entry of the list of figures.

    Attributes
    ----------
    id, title : str
    tells : str
        What it shows, in a sentence.
    options : callable
        Returns the lists above it.
    make : callable
        Returns the picture, or why there is none.
    needs : {"", "heard", "comparison"}
        What has to be worked out first.
    table : callable or None
        Returns a table to be read below it.
    """

    id: str
    title: str
    tells: str
    options: Callable[[Material], tuple[Option, ...]]
    make: Callable[[Material, Palette, Room], Picture | str]
    needs: Literal["", "heard", "comparison"] = ""
    table: Callable[[Material], Table | None] | None = None


def chosen(material: Material, option: Option) -> str:
    """Return what is chosen in a list: the first where the last choice is not there."""
    wanted = material.chosen.get(option.id, "")
    keys = [key for key, _ in option.choices]
    return wanted if wanted in keys else keys[0] if keys else ""


# Values


def group_of(material: Material) -> Option:
    """Return which derivatives can be looked at together, and each alone."""
    names = [name for name in material.outcome.summary.derivatives if not name.endswith("_0")]
    families = [one for one in _COEFFICIENTS if any(_of(name, one) for name in names)]
    axes = [
        (axis, f"all {words}")
        for axis, words in _AXES.items()
        if any((one in _LONGITUDINAL) == (axis == "lon") for one in families)
    ]
    return Option(
        id="group",
        title="Derivatives",
        choices=(
            *axes,
            *((one, f"of {one}") for one in families),
            *((name, name) for name in names),
        ),
    )


def names_in(material: Material, group: str) -> tuple[str, ...]:
    """Return the derivatives of a group."""
    names = [name for name in material.outcome.summary.derivatives if not name.endswith("_0")]
    if group in _AXES:
        return tuple(
            name for name in names if (name.partition("_")[0] in _LONGITUDINAL) == (group == "lon")
        )
    if group in _COEFFICIENTS:
        return tuple(name for name in names if _of(name, group))
    return (group,) if group in names else tuple(names)


def _of(name: str, coefficient: str) -> bool:
    return name.partition("_")[0] == coefficient


def _over(material: Material) -> Option:
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


def _values(material: Material, palette: Palette, room: Room) -> Picture | str:
    from gsapp.report.value_figures import values_picture

    names = names_in(material, chosen(material, group_of(material)))
    if not names:
        return "No maneuver of this run earned a derivative; the page Summary says why."
    return values_picture(
        material.outcome.summary, names, chosen(material, _over(material)), units=material.units,
        known=material.known, palette=palette, across=max(1, int(room.width / _CHART)),
    )  # fmt: skip


# One maneuver


def _maneuver(material: Material) -> Option:
    return Option(
        id="maneuver",
        title="Maneuver",
        choices=tuple(
            (one.maneuver.id, maneuver_words(one)) for one in material.outcome.result.results
        ),
    )


def _beside(material: Material) -> Option:
    return Option(
        id="beside",
        title="Compare with",
        choices=(
            ("", "no other run"),
            *((str(place), run_name(one)) for place, one in enumerate(material.others)),
        ),
    )


def _no_fit(material: Material) -> str:
    """Return why there is nothing to draw of the maneuver that is looked at."""
    looked_at = material.looked_at
    if looked_at.estimate is None:
        return f"Maneuver {looked_at.maneuver.id} could not be fitted: {looked_at.failure}."
    methods = {"ml": "Maximum likelihood", "ee": "Equation error", "ftr": "FTR"}
    return _NO_RESPONSES.format(method=methods[looked_at.estimate.method])


def _fit(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.fit_figures import fit_picture
    from ui.review.figures_material import result_of

    place = chosen(material, _beside(material))
    other = material.others[int(place)] if place else None
    picture = fit_picture(
        material.looked_at, units=material.units, palette=palette,
        other=None if other is None else result_of(other, material.looked_at.maneuver.id),
        other_name="" if other is None else run_name(other),
    )  # fmt: skip
    return picture or _no_fit(material)


def _residuals(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.fit_figures import residual_picture

    picture = residual_picture(material.looked_at, units=material.units, palette=palette)
    return picture or _no_fit(material)


def _fits(material: Material) -> Option:
    joint = tuple(
        (f"joint {place}", f"{len(one.maneuvers)} maneuvers together, {_axis_words(one)}")
        for place, one in enumerate(material.outcome.result.joint)
    )
    single = _maneuver(material)
    return Option(id="maneuver", title="Fit", choices=(*single.choices, *joint))


def _axis_words(estimate: Estimate) -> str:
    return _AXES.get(estimate.axis, "six degrees of freedom")


def _estimate(material: Material) -> tuple[Estimate | None, str]:
    """Return the fit that is looked at, and what it is of, in words."""
    place = material.chosen.get("maneuver", "")
    joint = material.outcome.result.joint
    if place.startswith("joint ") and int(place.split()[1]) < len(joint):
        one = joint[int(place.split()[1])]
        return one, f"{len(one.maneuvers)} {_axis_words(one)} maneuvers together"
    looked_at = material.looked_at
    return looked_at.estimate, f"maneuver {looked_at.maneuver.id} of {looked_at.maneuver.flight}"


def _correlations(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.trust_figures import correlation_picture

    estimate, subject = _estimate(material)
    if estimate is None:
        return _no_fit(material)
    picture = correlation_picture(estimate, subject, palette=palette)
    return picture or f"The fit of {subject} freed fewer than two derivatives."


def _bounds(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.trust_figures import bounds_picture

    estimate, subject = _estimate(material)
    if estimate is None:
        return _no_fit(material)
    return bounds_picture(estimate, subject, palette=palette) or (
        f"The fit of {subject} earned no derivative."
    )


# In flight


def _flight(material: Material) -> Option:
    return Option(
        id="flight",
        title="Flight",
        choices=tuple((one.flight, one.flight) for one in material.heard or ()),
    )


def _formed(_material: Material) -> Option:
    return Option(id="axis", title="Axis", choices=tuple(_AXES.items()))


def _online(material: Material, palette: Palette, room: Room) -> Picture | str:
    from gsapp.report.online_figures import online_picture

    flights = list(material.heard or ())
    name = chosen(material, _flight(material))
    one = next((one for one in flights if one.flight == name), None)
    if one is None or not one.histories:
        why = f" ({one.why})" if one is not None and one.why else ""
        return f"FTR did not listen to this flight{why}."
    lon = chosen(material, _formed(material)) == "lon"
    histories = [
        history
        for derivative, history in one.histories.items()
        if not derivative.endswith("_0") and (derivative.partition("_")[0] in _LONGITUDINAL) == lon
    ]
    # Those that formed come first: a page holds so many.
    histories.sort(key=lambda history: not bool((history.values == history.values).any()))
    return online_picture(
        histories, material.outcome.result, material.outcome.summary, one.flight,
        flights.index(one) + 1, palette=palette, across=max(1, int(room.width / _HISTORY)),
    )  # fmt: skip


# Linear models


def _judged(material: Material) -> Option:
    axes = () if material.comparison is None else tuple(material.comparison.axes)
    return Option(id="axis", title="Axis", choices=tuple((one, _AXES[one]) for one in axes))


def _kept_out(material: Material) -> Option:
    """Return the maneuvers that the linear models were judged on."""
    axis = chosen(material, _judged(material))
    traces = material.comparison.axes[axis].traces if material.comparison and axis else ()
    return Option(
        id="kept_out",
        title="Maneuver",
        choices=(
            ("", "some of them"),
            *((one.maneuver, f"{one.maneuver} of {one.flight}") for one in traces),
        ),
    )


def _linear(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.linear_figures import linear_picture

    comparison = material.comparison
    axis = chosen(material, _judged(material))
    if comparison is None or not axis:
        remarks = () if comparison is None else comparison.remarks
        return "There are no linear models to compare" + "".join(f": {one}" for one in remarks)
    one, name = comparison.axes[axis], chosen(material, _kept_out(material))
    traces = tuple(trace for trace in one.traces if trace.maneuver == name)
    return linear_picture(one, traces, units=material.units, palette=palette)


def _errors(material: Material) -> Table | None:
    from gsapp.report.linear_report import error_table

    comparison = material.comparison
    axis = chosen(material, _judged(material))
    if comparison is None or not axis:
        return None
    return error_table(comparison.axes[axis], comparison.method)


def _spread_modes(material: Material) -> dict[str, tuple[SpreadMode, ...]]:
    from gsapp.identification.summary.mode_spread import mode_spread

    outcome = material.outcome
    return {
        _AXES[axis]: mode_spread(outcome.result, outcome.summary, axis) for axis in outcome.models
    }


def _modes(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.mode_figures import modes_picture

    if not material.outcome.models:
        why = [one for one in material.outcome.remarks if "linear" in one]
        return "There is no linear model" + "".join(f": {one}" for one in why) + "."
    return modes_picture(_spread_modes(material), palette=palette)


def _mode_table(material: Material) -> Table | None:
    from gsapp.report.mode_figures import modes_table

    return modes_table(_spread_modes(material)) if material.outcome.models else None


KINDS = (
    FigureKind(
        id="values", title="Values",
        tells="Each derivative, maneuver by maneuver, with bounds and mean.",
        options=lambda material: (group_of(material), _over(material)), make=_values,
    ),
    FigureKind(
        id="fit", title="Fit",
        tells="What was moved, and measured against computed responses.",
        options=lambda material: (_maneuver(material), _beside(material)), make=_fit,
    ),
    FigureKind(
        id="residuals", title="Residuals",
        tells="What the fit leaves over, and whether it is white.",
        options=lambda material: (_maneuver(material),), make=_residuals,
    ),
    FigureKind(
        id="online", title="In flight",
        tells="Derivatives as FTR formed them, against the points on the ground.",
        options=lambda material: (_flight(material), _formed(material)), make=_online,
        needs="heard",
    ),
    FigureKind(
        id="linear", title="Linear models",
        tells="Linear models on maneuvers that they never saw.",
        options=lambda material: (_judged(material), _kept_out(material)), make=_linear,
        needs="comparison", table=_errors,
    ),
    FigureKind(
        id="correlations", title="Correlations",
        tells="What a fit cannot tell apart.",
        options=lambda material: (_fits(material),), make=_correlations,
    ),
    FigureKind(
        id="bounds", title="Bounds",
        tells="Bounds in percent, as white noise would have them and corrected.",
        options=lambda material: (_fits(material),), make=_bounds,
    ),
    FigureKind(
        id="modes", title="Modes",
        tells="Poles of the linear models with frequency and damping.",
        options=lambda _material: (), make=_modes, table=_mode_table,
    ),
)  # fmt: skip
"""In the order in which a review takes them."""
