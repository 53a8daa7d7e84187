"""The figures of the review: what each shows, what can be chosen in it, and how it is made.

Pictures are the report's own. They are made in the thread that draws them; matplotlib is loaded
there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ui.review.figure_drawing import Room
from ui.review.figures_material import Material, result_of, run_name
from ui.review.figures_options import (
    AXES,
    JOINT,
    LONGITUDINAL,
    Option,
    axis_formed,
    axis_judged,
    axis_words,
    beside_of,
    chosen,
    fit_of,
    flight_of,
    group_of,
    kept_out_of,
    maneuver_of,
    names_in,
    over_of,
)

if TYPE_CHECKING:
    from gsapp.identification.results import Estimate
    from gsapp.identification.summary.mode_spread import SpreadMode
    from gsapp.report.document import Picture, Table
    from gsapp.report.palette import Palette

_SHAPE, _LOW = 1.5, 1.45
"""Width over height that small charts are best read at; inches of height that each takes."""
_CHART = 2.3
"""Inches that a small chart of a value takes at least."""
_HISTORY = 3.2
"""Inches of a history over a flight."""
_NOTHING_EARNED = "{method} earned no derivative in maneuver {maneuver}: {why}."
_WHYS = 3
"""Reasons that a sentence holds."""
_NO_COEFFICIENTS = (
    "Maneuver {maneuver} has no force and moment coefficients to compare: they take airspeed and "
    "rates that were measured."
)
_NO_RESIDUALS = (
    "{method} compares smoothed coefficients, and what smoothing leaves over is never white. The "
    "figure Fit shows how well they are followed; maximum likelihood has residuals to look at."
)
_METHODS = {"ml": "Maximum likelihood", "ee": "Equation error", "ftr": "FTR"}


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


def columns(count: int, room: Room, least: float) -> int:
    """Return how many of so many charts stand beside each other.

    Parameters
    ----------
    count : int
    room : Room
    least : float
        Inches across that a chart takes.
    """

    def misshapen(across: int) -> float:
        down = -(-count // across)
        shape = (room.width / across) / max(room.height / down, _LOW)
        return abs(math.log(shape / _SHAPE))

    most = max(1, min(count, int(room.width / least)))
    return min(range(1, most + 1), key=misshapen)


# Values


def _values(material: Material, palette: Palette, room: Room) -> Picture | str:
    from gsapp.report.value_figures import values_picture

    names = names_in(material, chosen(material, group_of(material)))
    if not names:
        return "No maneuver of this run earned a derivative; the page Summary says why."
    return values_picture(
        material.outcome.summary, names, chosen(material, over_of(material)), units=material.units,
        known=material.known, palette=palette, across=columns(len(names), room, _CHART),
    )  # fmt: skip


# One maneuver


def _no_fit(material: Material) -> str:
    """Return why there is nothing to draw of the maneuver that is looked at."""
    looked_at = material.looked_at
    if looked_at.estimate is None:
        return f"Maneuver {looked_at.maneuver.id} could not be fitted: {looked_at.failure}."
    estimate = looked_at.estimate
    if estimate.free:
        return _NO_COEFFICIENTS.format(maneuver=looked_at.maneuver.id)
    whys = dict.fromkeys(one.why for one in estimate.derivatives.values() if one.why)
    return _NOTHING_EARNED.format(
        method=_METHODS[estimate.method],
        maneuver=looked_at.maneuver.id,
        why=", ".join([*whys][:_WHYS]) or estimate.message,
    )


def _fit(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.fit_figures import fit_picture

    place = chosen(material, beside_of(material))
    other = material.others[int(place)] if place else None
    picture = fit_picture(
        material.looked_at, units=material.units, palette=palette,
        other=None if other is None else result_of(other, material.looked_at.maneuver.id),
        other_name="" if other is None else run_name(other),
    )  # fmt: skip
    return picture or _no_fit(material)


def _both_methods(material: Material) -> Table | None:
    from gsapp.report.gust_words import beside_table

    return beside_table(material.looked_at)


def _residuals(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.fit_figures import residual_picture

    picture = residual_picture(material.looked_at, units=material.units, palette=palette)
    estimate = material.looked_at.estimate
    if picture is None and estimate is not None and estimate.method != "ml":
        return _NO_RESIDUALS.format(method=_METHODS[estimate.method])
    return picture or _no_fit(material)


def _estimate(material: Material) -> tuple[Estimate | None, str]:
    """Return the fit that is looked at, and what it is of, in words."""
    key = chosen(material, fit_of(material))
    if key.startswith(JOINT):
        one = material.outcome.result.joint[int(key.removeprefix(JOINT))]
        return one, f"{len(one.maneuvers)} {axis_words(one)} maneuvers together"
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


def _online(material: Material, palette: Palette, room: Room) -> Picture | str:
    from gsapp.report.online_figures import online_picture

    flights = list(material.heard or ())
    name = chosen(material, flight_of(material))
    one = next((one for one in flights if one.flight == name), None)
    if one is None or not one.histories:
        why = f" ({one.why})" if one is not None and one.why else ""
        return f"FTR did not listen to this flight{why}."
    lon = chosen(material, axis_formed(material)) == "lon"
    histories = [
        history
        for derivative, history in one.histories.items()
        if not derivative.endswith("_0") and (derivative.partition("_")[0] in LONGITUDINAL) == lon
    ]
    # Those that formed come first: a page holds so many.
    histories.sort(key=lambda history: not bool((history.values == history.values).any()))
    return online_picture(
        histories, material.outcome.result, material.outcome.summary, one.flight,
        flights.index(one) + 1, palette=palette, across=columns(len(histories), room, _HISTORY),
    )  # fmt: skip


# Linear models


def _linear(material: Material, palette: Palette, room: Room) -> Picture | str:
    from gsapp.report.linear_figures import linear_picture, shown_traces

    comparison = material.comparison
    axis = chosen(material, axis_judged(material))
    if comparison is None or not axis:
        remarks = () if comparison is None else comparison.remarks
        return "There are no linear models to compare" + "".join(f": {one}" for one in remarks)
    one, name = comparison.axes[axis], chosen(material, kept_out_of(material))
    traces = tuple(trace for trace in one.traces if trace.maneuver == name)
    traces = traces or shown_traces(one)[: max(1, int(room.width / _CHART))]
    return linear_picture(one, traces, units=material.units, palette=palette)


def _errors(material: Material) -> Table | None:
    from gsapp.report.linear_report import error_table

    comparison = material.comparison
    axis = chosen(material, axis_judged(material))
    if comparison is None or not axis:
        return None
    return error_table(comparison.axes[axis], comparison.method)


def _spread_modes(material: Material) -> dict[str, tuple[SpreadMode, ...]]:
    from gsapp.identification.summary.mode_spread import mode_spread

    outcome = material.outcome
    return {
        AXES[axis]: mode_spread(outcome.result, outcome.summary, axis) for axis in outcome.models
    }


def _modes(material: Material, palette: Palette, _room: Room) -> Picture | str:
    from gsapp.report.mode_figures import modes_picture

    if not material.outcome.models:
        from gsapp.identification.summary.linear import NO_MODEL

        why = [one for one in material.outcome.remarks if one.startswith(NO_MODEL)]
        return "There is no linear model" + "".join(f": {one}" for one in why) + "."
    return modes_picture(_spread_modes(material), palette=palette)


def _mode_table(material: Material) -> Table | None:
    from gsapp.report.mode_figures import modes_table

    if not material.outcome.models:
        return None
    return modes_table(_spread_modes(material), material.units)


KINDS = (
    FigureKind(
        id="values", title="Values",
        tells="Each derivative, maneuver by maneuver, with bounds and mean.",
        options=lambda material: (group_of(material), over_of(material)), make=_values,
    ),
    FigureKind(
        id="fit", title="Fit",
        tells="What was moved, and measured against computed responses or coefficients.",
        options=lambda material: (maneuver_of(material), beside_of(material)), make=_fit,
        table=_both_methods,
    ),
    FigureKind(
        id="residuals", title="Residuals",
        tells="What the fit leaves over, and whether it is white.",
        options=lambda material: (maneuver_of(material),), make=_residuals,
    ),
    FigureKind(
        id="online", title="In flight",
        tells="Derivatives as FTR formed them, against the points on the ground.",
        options=lambda material: (flight_of(material), axis_formed(material)), make=_online,
        needs="heard",
    ),
    FigureKind(
        id="linear", title="Linear models",
        tells="Linear models on maneuvers that they never saw.",
        options=lambda material: (axis_judged(material), kept_out_of(material)), make=_linear,
        needs="comparison", table=_errors,
    ),
    FigureKind(
        id="correlations", title="Correlations",
        tells="What a fit cannot tell apart.",
        options=lambda material: (fit_of(material),), make=_correlations,
    ),
    FigureKind(
        id="bounds", title="Bounds",
        tells="Bounds in percent, as white noise would have them and corrected.",
        options=lambda material: (fit_of(material),), make=_bounds,
    ),
    FigureKind(
        id="modes", title="Modes",
        tells="Poles of the linear models with frequency and damping.",
        options=lambda _material: (), make=_modes, table=_mode_table,
    ),
)  # fmt: skip
"""In the order in which a review takes them."""
