"""The figures of the review: what each shows, what can be chosen in it, and how it is made.

Pictures are the report's own. They are made in the thread that draws them; matplotlib is loaded
there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from gsapp.identification.axes import AXIS_COEFFICIENTS, AXIS_TITLES
from gsapp.identification.methods import compares_coefficients, estimation_method
from ui.review.figure_data import (
    JOINT_PREFIX,
    FigureData,
    FigureOption,
    abscissa_option,
    axis_text,
    comparison_run_option,
    derivative_group_option,
    derivatives_in_group,
    find_result,
    fit_option,
    flight_option,
    format_run_name,
    ftr_axis_option,
    held_out_option,
    linear_model_axis_option,
    maneuver_option,
    selected_choice,
    selected_validation,
)
from ui.review.figure_renderer import FigureSize
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.results import Estimate
    from gsapp.identification.summary.mode_uncertainty import ModeUncertainty
    from gsapp.report.document import DocumentFigure, DocumentTable
    from gsapp.report.palette import Palette

_TARGET_ASPECT, _MIN_ROW_HEIGHT = 1.5, 1.45
"""Width over height that small charts are best read at; inches of height that each takes."""
_MIN_CHART_WIDTH = 2.3
"""Inches that a small chart of a value takes at least."""
_HISTORY_HEIGHT = 3.2
"""Inches of a history over a flight."""
_NO_ESTIMATE_TEXT = QT_TR_NOOP("{method} found no derivative in maneuver {maneuver}: {why}.")
_MAX_REASONS = 3
"""Reasons that a sentence holds."""
_NO_COEFFICIENTS_TEXT = QT_TR_NOOP(
    "Maneuver {maneuver} has no force and moment coefficients to compare: they require "
    "measured airspeed and rates."
)
_NO_RESIDUALS_TEXT = QT_TR_NOOP(
    "{method} compares smoothed coefficients, whose residuals are never white. The Fit figure "
    "shows their fit; for residuals use maximum likelihood."
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureKind:
    """One entry of the list of figures."""

    id: str
    title: str
    description: str
    options: Callable[[FigureData], tuple[FigureOption, ...]]
    build: Callable[[FigureData, Palette, FigureSize], DocumentFigure | str]
    """Returns the picture, or why there is none."""
    needs: Literal["", "ftr_histories", "comparison"] = ""
    table: Callable[[FigureData], DocumentTable | None] | None = None


def best_column_count(count: int, room: FigureSize, least: float) -> int:
    """Return how many of so many charts, each `least` inches wide, stand beside each other."""

    def misshapen(across: int) -> float:
        down = -(-count // across)
        shape = (room.width / across) / max(room.height / down, _MIN_ROW_HEIGHT)
        return abs(math.log(shape / _TARGET_ASPECT))

    most = max(1, min(count, int(room.width / least)))
    return min(range(1, most + 1), key=misshapen)


# Values


def _build_values(data: FigureData, palette: Palette, room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.value_figures import value_figure

    names = derivatives_in_group(data, selected_choice(data, derivative_group_option(data)))
    if not names:
        return tr("This run estimated no derivative; the Summary page gives the reasons.")
    return value_figure(
        data.outcome.summary, names, selected_choice(data, abscissa_option(data)),
        units=data.units,
        known=data.priors, palette=palette, across=best_column_count(len(names), room,
        _MIN_CHART_WIDTH),
    )  # fmt: skip


# One maneuver


def _missing_fit_text(data: FigureData) -> str:
    looked_at = data.current_maneuver
    if looked_at.estimate is None:
        return tr("Maneuver {id} could not be fitted: {failure}.").format(
            id=looked_at.maneuver.id, failure=looked_at.failure
        )
    estimate = looked_at.estimate
    if estimate.free:
        return tr(_NO_COEFFICIENTS_TEXT).format(maneuver=looked_at.maneuver.id)
    whys = dict.fromkeys(one.why for one in estimate.derivatives.values() if one.why)
    return tr(_NO_ESTIMATE_TEXT).format(
        method=tr(estimation_method(estimate.method).title),
        maneuver=looked_at.maneuver.id,
        why=", ".join([*whys][:_MAX_REASONS]) or estimate.message,
    )


def _build_fit(data: FigureData, palette: Palette, _room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.fit_figures import fit_figure

    place = selected_choice(data, comparison_run_option(data))
    other = data.others[int(place)] if place else None
    picture = fit_figure(
        data.current_maneuver, units=data.units, palette=palette,
        other=None if other is None else find_result(other, data.current_maneuver.maneuver.id),
        other_name="" if other is None else format_run_name(other),
    )  # fmt: skip
    return picture or _missing_fit_text(data)


def _methods_figure_data(data: FigureData) -> DocumentTable | None:
    from gsapp.report.fit_diagnostics import method_comparison_table

    return method_comparison_table(data.current_maneuver)


def _build_residuals(data: FigureData, palette: Palette, _room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.fit_figures import residual_figure

    picture = residual_figure(data.current_maneuver, units=data.units, palette=palette)
    estimate = data.current_maneuver.estimate
    if picture is None and estimate is not None and compares_coefficients(estimate.method):
        return tr(_NO_RESIDUALS_TEXT).format(method=tr(estimation_method(estimate.method).title))
    return picture or _missing_fit_text(data)


def _selected_fit(data: FigureData) -> tuple[Estimate | None, str]:
    key = selected_choice(data, fit_option(data))
    if key.startswith(JOINT_PREFIX):
        one = data.outcome.result.joint[int(key.removeprefix(JOINT_PREFIX))]
        return one, tr("{count} {axis} maneuvers jointly").format(
            count=len(one.maneuvers), axis=axis_text(one)
        )
    looked_at = data.current_maneuver
    return looked_at.estimate, tr("maneuver {id} of {flight}").format(
        id=looked_at.maneuver.id, flight=looked_at.maneuver.flight
    )


def _build_correlations(
    data: FigureData, palette: Palette, _room: FigureSize
) -> DocumentFigure | str:
    from gsapp.report.fit_diagnostic_figures import correlation_figure

    estimate, subject = _selected_fit(data)
    if estimate is None:
        return _missing_fit_text(data)
    picture = correlation_figure(estimate, subject, palette=palette)
    return picture or tr("The fit of {subject} has fewer than two free derivatives.").format(
        subject=subject
    )


def _build_bounds(data: FigureData, palette: Palette, _room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.fit_diagnostic_figures import bounds_figure

    estimate, subject = _selected_fit(data)
    if estimate is None:
        return _missing_fit_text(data)
    return bounds_figure(estimate, subject, palette=palette) or (
        tr("The fit of {subject} estimated no derivative.").format(subject=subject)
    )


# In flight


def _build_ftr_history(
    data: FigureData, palette: Palette, room: FigureSize
) -> DocumentFigure | str:
    from gsapp.report.online_figures import online_estimates_figure

    flights = list(data.ftr_histories or ())
    name = selected_choice(data, flight_option(data))
    one = next((one for one in flights if one.flight == name), None)
    if one is None or not one.histories:
        why = f" ({one.why})" if one is not None and one.why else ""
        return tr("FTR was not computed for this flight{why}.").format(why=why)
    lon = selected_choice(data, ftr_axis_option(data)) == "lon"
    histories = [
        history
        for derivative, history in one.histories.items()
        if not derivative.endswith("_0")
        and (derivative.partition("_")[0] in AXIS_COEFFICIENTS["lon"]) == lon
    ]
    # Those that formed come first: a page holds so many.
    histories.sort(key=lambda history: not bool((history.values == history.values).any()))
    return online_estimates_figure(
        histories, data.outcome.result, data.outcome.summary, one.flight,
        flights.index(one) + 1, palette=palette, across=best_column_count(len(histories), room,
        _HISTORY_HEIGHT),
    )  # fmt: skip


# Linear models


def _build_linear(data: FigureData, palette: Palette, room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.linear_report import linear_model_figure, select_traces

    validation = selected_validation(data)
    if validation is None:
        remarks = () if data.comparison is None else data.comparison.remarks
        return tr("No linear models to compare") + "".join(f": {one}" for one in remarks)
    name = selected_choice(data, held_out_option(data))
    traces = tuple(trace for trace in validation.traces if trace.maneuver == name)
    traces = traces or select_traces(validation)[: max(1, int(room.width / _MIN_CHART_WIDTH))]
    return linear_model_figure(validation, traces, units=data.units, palette=palette)


def _build_error_table(data: FigureData) -> DocumentTable | None:
    from gsapp.report.linear_report import error_table

    comparison, validation = data.comparison, selected_validation(data)
    if comparison is None or validation is None:
        return None
    return error_table(validation, comparison.method)


def _modes_with_spread(data: FigureData) -> dict[str, tuple[ModeUncertainty, ...]]:
    from gsapp.identification.summary.mode_uncertainty import propagate_mode_uncertainty

    outcome = data.outcome
    return {
        AXIS_TITLES[axis]: propagate_mode_uncertainty(outcome.result, outcome.summary, axis)
        for axis in outcome.models
    }


def _build_modes(data: FigureData, palette: Palette, _room: FigureSize) -> DocumentFigure | str:
    from gsapp.report.mode_figures import modes_figure

    if not data.outcome.models:
        from gsapp.identification.summary.campaign_linear_models import NO_LINEAR_MODEL_PREFIX

        why = [one for one in data.outcome.remarks if one.startswith(NO_LINEAR_MODEL_PREFIX)]
        return tr("No linear model") + "".join(f": {one}" for one in why) + "."
    return modes_figure(_modes_with_spread(data), palette=palette)


def _build_mode_table(data: FigureData) -> DocumentTable | None:
    from gsapp.report.mode_figures import modes_table

    if not data.outcome.models:
        return None
    return modes_table(_modes_with_spread(data), data.units)


FIGURE_KINDS = (
    FigureKind(
        id="values", title=QT_TR_NOOP("Values"),
        description=QT_TR_NOOP("Each derivative by maneuver, with bounds and mean."),
        options=lambda data: (derivative_group_option(data), abscissa_option(data)),
        build=_build_values,
    ),
    FigureKind(
        id="fit", title=QT_TR_NOOP("Fit"),
        description=QT_TR_NOOP("Inputs, and measured and computed responses or coefficients."),
        options=lambda data: (maneuver_option(data), comparison_run_option(data)),
        build=_build_fit,
        table=_methods_figure_data,
    ),
    FigureKind(
        id="residuals", title=QT_TR_NOOP("Residuals"),
        description=QT_TR_NOOP("Residuals of the fit and their whiteness."),
        options=lambda data: (maneuver_option(data),), build=_build_residuals,
    ),
    FigureKind(
        id="online", title=QT_TR_NOOP("In flight"),
        description=QT_TR_NOOP("FTR estimates over the flight, with the post-flight values."),
        options=lambda data: (flight_option(data), ftr_axis_option(data)),
        build=_build_ftr_history,
        needs="ftr_histories",
    ),
    FigureKind(
        id="linear", title=QT_TR_NOOP("Linear models"),
        description=QT_TR_NOOP("Linear models on held-out maneuvers."),
        options=lambda data: (linear_model_axis_option(data), held_out_option(data)),
        build=_build_linear,
        needs="comparison", table=_build_error_table,
    ),
    FigureKind(
        id="correlations", title=QT_TR_NOOP("Correlations"),
        description=QT_TR_NOOP("Correlation of the estimates."),
        options=lambda data: (fit_option(data),), build=_build_correlations,
    ),
    FigureKind(
        id="bounds", title=QT_TR_NOOP("Bounds"),
        description=QT_TR_NOOP("Bounds in percent: Cramer-Rao and corrected."),
        options=lambda data: (fit_option(data),), build=_build_bounds,
    ),
    FigureKind(
        id="modes", title=QT_TR_NOOP("Modes"),
        description=QT_TR_NOOP("Poles of the linear models with frequency and damping."),
        options=lambda _material: (), build=_build_modes, table=_build_mode_table,
    ),
)  # fmt: skip
"""In the order in which a review takes them."""
