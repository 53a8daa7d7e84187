"""Linear models against flight (figures 7.4.3 to 7.4.6 of the source), and their modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.methods import LINEAR_MODEL_TITLES, linear_model_title
from gsapp.identification.summary.campaign_linear_models import (
    AxisValidation,
    LinearModelValidation,
    ValidationTrace,
)
from gsapp.quantities import FloatArray, channel
from gsapp.quantities.units import from_si
from gsapp.report.document import (
    MAX_FIGURE_HEIGHT,
    DocumentFigure,
    DocumentPart,
    DocumentSection,
    DocumentTable,
    Paragraph,
    set_margins,
)
from gsapp.report.linear_text import (
    MODE_COLUMNS,
    error_rows,
    mode_rows,
    validation_text,
)
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
    traces : sequence of ValidationTrace
        Of `one`; `select_traces` where empty.
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
            display_values(name, trace.inputs[:, index], units)
            for index, name in enumerate(one.inputs)
        ]
        for index, name in enumerate(one.outputs):
            every = (trace.measured, *(trace.computed[model] for model in one.models))
            columns += [display_values(name, values[:, index], units) for values in every]
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


def error_table(one: AxisValidation, method: str) -> DocumentTable:
    """Return RMS error over range in percent by variable and model: tables 7.4.1 and 7.4.2.

    Over the maneuvers kept out, then over the whole of the flights where flights were.
    """
    rows = error_rows(one.outputs, one.errors)
    over = "each held-out maneuver, with its own initial state"
    if one.whole_flight_errors:
        whole = error_rows(one.outputs, one.whole_flight_errors)
        rows += tuple((f"{name}, whole flight", *errors) for name, *errors in whole)
        over += f", and the whole of {' and '.join(one.flights)} from first to last maneuver"
    return DocumentTable(
        caption=f"RMS error over range, percent, of the {AXIS_TITLES[one.axis]} models over "
        f"{over}; * the least of each row",
        columns=("variable", *(linear_model_title(name, method) for name in one.models)),
        rows=rows,
        numeric=frozenset(range(1, 1 + len(one.models))),
    )


def _mode_table(one: AxisValidation, method: str, units: str) -> DocumentTable:
    return DocumentTable(
        caption=f"Modes of the {AXIS_TITLES[one.axis]} models that were compared"
        f"{_about(one, units)}",
        columns=("model", *MODE_COLUMNS),
        rows=tuple(
            (linear_model_title(name, method), *row)
            for name, fitted in one.models.items()
            for row in mode_rows(fitted.model)
        ),
        numeric=frozenset(range(2, 1 + len(MODE_COLUMNS))),
    )


def _speed(value: float, units: str) -> str:
    spec = channel("V")
    unit = spec.display_unit(units)
    return f"{from_si(value, unit, spec.quantity):.{spec.decimals(unit)}f} {unit}"


def _about(one: AxisValidation, units: str) -> str:
    about = next((fitted.model.operating_point for fitted in one.models.values()), None)
    return "" if about is None else f", about steady flight at {_speed(about.speed, units)}"


def linear_section(comparison: LinearModelValidation, *, units: str) -> DocumentSection:
    """Return the section on linear models: how well they follow new flights, their modes."""
    parts: list[DocumentPart] = []
    for one in comparison.axes.values():
        parts.append(Paragraph(text=validation_text(one)))
        parts.append(error_table(one, comparison.method))
        parts.append(linear_model_figure(one, units=units))
        parts.append(_mode_table(one, comparison.method, units))
    parts += [
        Paragraph(text=f"{text[:1].upper()}{text[1:]}.", kind="note") for text in comparison.remarks
    ]
    return DocumentSection(title="Linear models against flight", parts=tuple(parts))
