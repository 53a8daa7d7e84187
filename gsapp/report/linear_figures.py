"""Linear models against flight: figures 7.4.3 to 7.4.6 of the source.

What was moved, and each variable as measured (solid) and as three models compute it (dashed).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D

from gsapp.identification.summary.linear_comparison import AxisComparison, LinearTrace
from gsapp.quantities import FloatArray
from gsapp.report.document import TALLEST, Picture, Table, margins
from gsapp.report.figure_parts import (
    MANEUVER,
    clock_axis,
    column_title,
    label_channel,
    label_flight_time,
    number_text,
    plain,
    shown_values,
)
from gsapp.report.linear_words import MODEL_NAMES
from gsapp.report.palette import PAPER, Palette

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
_ROOM: Final = 0.25
"""Of the measured range, left above and below it: a model that runs away leaves the chart."""


def shown_traces(one: AxisComparison) -> tuple[LinearTrace, ...]:
    """Return the traces that are drawn: as many as fit beside each other, evenly chosen."""
    places = np.linspace(0, len(one.traces) - 1, min(_MOST, len(one.traces))).round()
    return tuple(one.traces[int(place)] for place in places)


def linear_picture(
    one: AxisComparison,
    traces: Sequence[LinearTrace] = (),
    *,
    units: str = "US",
    palette: Palette = PAPER,
) -> Picture:
    """Return inputs and outputs of maneuvers that were kept out, beside each other.

    Parameters
    ----------
    one : AxisComparison
    traces : sequence of LinearTrace
        Of `one`; `shown_traces` where empty.
    units : {"US", "SI"}
    palette : Palette
    """
    drawn = tuple(traces) or shown_traces(one)
    names = (*one.inputs, *one.outputs)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(len(names), len(drawn), squeeze=False, sharex="col")
        margins(container, left=0.8, top=0.58, bottom=0.42, hspace=0.16, wspace=0.3)
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

    words = "Longitudinal" if one.axis == "lon" else "Lateral-directional"
    return Picture(
        name=f"linear-{one.axis}",
        caption=f"{words} models on maneuvers that none of them was fitted on: what was moved, "
        "and each variable as measured (solid) and as computed from the inputs alone (dashed).",
        height=min(TALLEST, 1.1 + 0.86 * len(names)),
        draw=draw,
        numbers=lambda: _numbers(one, drawn, units),
    )


def _numbers(one: AxisComparison, traces: Sequence[LinearTrace], units: str) -> Table:
    heads = ["maneuver", "time [s]", *(column_title(name, units) for name in one.inputs)]
    for name in one.outputs:
        heads += [f"{column_title(name, units)} {which}" for which in ("measured", *one.models)]
    rows: list[tuple[str, ...]] = []
    for trace in traces:
        columns = [trace.times]
        columns += [
            shown_values(name, trace.inputs[:, place], units)
            for place, name in enumerate(one.inputs)
        ]
        for place, name in enumerate(one.outputs):
            every = (trace.measured, *(trace.computed[model] for model in one.models))
            columns += [shown_values(name, values[:, place], units) for values in every]
        rows += [
            (trace.maneuver, *map(number_text, row)) for row in np.column_stack(columns).tolist()
        ]
    return Table(columns=tuple(heads), rows=tuple(rows))


def _draw(
    chart: Axes,
    one: AxisComparison,
    trace: LinearTrace,
    name: str,
    units: str,
    palette: Palette,
) -> None:
    """Draw one input, or one output as measured and computed; the axes name the maneuver."""
    chart.set_gid(MANEUVER + trace.maneuver)
    if name in one.inputs:
        moved = shown_values(name, trace.inputs[:, one.inputs.index(name)], units)
        chart.plot(trace.times, moved, color=palette.channel(name))
        plain(chart, palette)
        clock_axis(chart)
        return
    column = one.outputs.index(name)
    measured = shown_values(name, trace.measured[:, column], units)
    chart.plot(trace.times, measured, color=palette.channel(name), label="measured")
    for model, computed in trace.computed.items():
        shown = shown_values(name, computed[:, column], units)
        chart.plot(trace.times, shown, color=_color(model, palette), dashes=_DASHES[model],
                   label=MODEL_NAMES[model])  # fmt: skip
    chart.set_ylim(*_limits(measured))
    plain(chart, palette)
    clock_axis(chart)


def _limits(measured: FloatArray) -> tuple[float, float]:
    low, high = float(measured.min()), float(measured.max())
    room = _ROOM * (high - low) if high > low else 1.0
    return low - room, high + room


def _color(model: str, palette: Palette) -> str:
    """Return a color that no response has."""
    return {"bls": palette.traces["olive"], "subspace": palette.quiet}.get(model, palette.ink)


def _handles(one: AxisComparison, palette: Palette) -> list[Line2D]:
    return [
        Line2D([], [], color=palette.quiet, label="measured"),
        *(
            Line2D(
                [], [], color=_color(model, palette), dashes=_DASHES[model],
                label=MODEL_NAMES[model],
            )
            for model in one.models
        ),
    ]  # fmt: skip
