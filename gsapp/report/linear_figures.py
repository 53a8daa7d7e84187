"""Linear models against flight: figures 7.4.3 to 7.4.6 of the source.

What was moved, and each variable as measured (solid) and as three models compute it (dashed).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.methods import LINEAR_MODEL_TITLES
from gsapp.identification.summary.campaign_linear_models import AxisValidation, ValidationTrace
from gsapp.quantities import FloatArray
from gsapp.report.document import MAX_FIGURE_HEIGHT, DocumentFigure, DocumentTable, set_margins
from gsapp.report.palette import PRINT_PALETTE, Palette
from gsapp.report.plot_elements import (
    MANEUVER_PREFIX,
    column_title,
    display_values,
    exact_number_text,
    format_axes,
    format_clock_axis,
    label_channel,
    label_flight_time,
)
from gsapp.report.settings import REPORT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHES: Final[Mapping[str, tuple[float, ...]]] = {
    "bls": (4.0, 1.5),
    "subspace": (1.2, 1.2),
    "ml": (5.0, 1.2, 1.0, 1.2),
}
"""Of each model: told apart without color, too."""
_MOST: Final = 3
"""Maneuvers beside each other."""


def select_traces(one: AxisValidation) -> tuple[ValidationTrace, ...]:
    """Return the traces that are drawn: as many as fit beside each other, evenly chosen."""
    places = np.linspace(0, len(one.traces) - 1, min(_MOST, len(one.traces))).round()
    return tuple(one.traces[int(place)] for place in places)


def linear_model_figure(
    one: AxisValidation,
    traces: Sequence[ValidationTrace] = (),
    *,
    units: str = "US",
    palette: Palette = PRINT_PALETTE,
) -> DocumentFigure:
    """Return inputs and outputs of maneuvers that were kept out, beside each other.

    Parameters
    ----------
    one : AxisValidation
    traces : sequence of ValidationTrace
        Of `one`; `select_traces` where empty.
    units : {"US", "SI"}
    palette : Palette
    """
    drawn = tuple(traces) or select_traces(one)
    names = (*one.inputs, *one.outputs)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(len(names), len(drawn), squeeze=False, sharex="col")
        set_margins(container, left=0.8, top=0.58, bottom=0.42, hspace=0.16, wspace=0.3)
        for column, trace in enumerate(drawn):
            for row, name in enumerate(names):
                _draw(charts[row, column], one, trace, name, units, palette)
            charts[0, column].set_title(
                f"{trace.maneuver} of {trace.flight}", loc="left", color=palette.ink
            )
            label_flight_time(charts[-1, column], palette)
            charts[-1, column].set_xlim(float(trace.times[0]), float(trace.times[-1]))
        for row, name in enumerate(names):
            label_channel(charts[row, 0], name, units, palette)
        container.legend(
            handles=_handles(one, palette), loc="upper left", ncols=1 + len(one.models),
            borderaxespad=0.1, labelcolor=palette.ink,
        )  # fmt: skip

    return DocumentFigure(
        name=f"linear-{one.axis}",
        caption=f"{AXIS_TITLES[one.axis].capitalize()} models on held-out maneuvers: inputs, "
        "and each variable measured (solid) and computed from the inputs (dashed).",
        height=min(MAX_FIGURE_HEIGHT, 1.1 + 0.86 * len(names)),
        draw=draw,
        numbers=lambda: _numbers(one, drawn, units),
    )


def _numbers(one: AxisValidation, traces: Sequence[ValidationTrace], units: str) -> DocumentTable:
    heads = ["maneuver", "time [s]", *(column_title(name, units) for name in one.inputs)]
    for name in one.outputs:
        heads += [f"{column_title(name, units)} {which}" for which in ("measured", *one.models)]
    rows: list[tuple[str, ...]] = []
    for trace in traces:
        columns = [trace.times]
        columns += [
            display_values(name, trace.inputs[:, place], units)
            for place, name in enumerate(one.inputs)
        ]
        for place, name in enumerate(one.outputs):
            every = (trace.measured, *(trace.computed[model] for model in one.models))
            columns += [display_values(name, values[:, place], units) for values in every]
        rows += [
            (trace.maneuver, *map(exact_number_text, row))
            for row in np.column_stack(columns).tolist()
        ]
    return DocumentTable(columns=tuple(heads), rows=tuple(rows))


def _draw(
    chart: Axes,
    one: AxisValidation,
    trace: ValidationTrace,
    name: str,
    units: str,
    palette: Palette,
) -> None:
    """Draw one input, or one output as measured and computed; the axes name the maneuver."""
    chart.set_gid(MANEUVER_PREFIX + trace.maneuver)
    if name in one.inputs:
        moved = display_values(name, trace.inputs[:, one.inputs.index(name)], units)
        chart.plot(trace.times, moved, color=palette.channel(name))
        format_axes(chart, palette)
        format_clock_axis(chart)
        return
    column = one.outputs.index(name)
    measured = display_values(name, trace.measured[:, column], units)
    chart.plot(trace.times, measured, color=palette.channel(name), label="measured")
    for model, computed in trace.computed.items():
        shown = display_values(name, computed[:, column], units)
        chart.plot(trace.times, shown, color=_color(model, palette), dashes=_DASHES[model],
                   label=LINEAR_MODEL_TITLES[model])  # fmt: skip
    chart.set_ylim(*_limits(measured))
    format_axes(chart, palette)
    format_clock_axis(chart)


def _limits(measured: FloatArray) -> tuple[float, float]:
    low, high = float(measured.min()), float(measured.max())
    room = REPORT.linear_axis_margin * (high - low) if high > low else 1.0
    return low - room, high + room


def _color(model: str, palette: Palette) -> str:
    """Return a color that no response has."""
    return {"bls": palette.traces["olive"], "subspace": palette.secondary_ink}.get(
        model, palette.ink
    )


def _handles(one: AxisValidation, palette: Palette) -> list[Line2D]:
    return [
        Line2D([], [], color=palette.secondary_ink, label="measured"),
        *(
            Line2D(
                [], [], color=_color(model, palette), dashes=_DASHES[model],
                label=LINEAR_MODEL_TITLES[model],
            )
            for model in one.models
        ),
    ]  # fmt: skip
