"""One maneuver: what was moved, measured against computed responses, and what is left over.

Measured is solid in the color of its channel, computed dashed, another run gray.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D

from gsapp.identification.campaign import ManeuverResult
from gsapp.identification.methods import compares_coefficients, estimation_method
from gsapp.identification.results import ResponseHistory
from gsapp.quantities import FloatArray
from gsapp.report.document import MAX_FIGURE_HEIGHT, DocumentFigure, DocumentTable, set_margins
from gsapp.report.palette import PRINT_PALETTE, Palette
from gsapp.report.plot_elements import (
    UNDERLAY_ALPHA,
    WIDE_LINE_WIDTH,
    column_title,
    display_values,
    draw_trace,
    exact_number_text,
    format_axes,
    label_flight_time,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

_ROW_HEIGHT = 0.82


def fit_figure(
    result: ManeuverResult,
    *,
    units: str = "US",
    palette: Palette = PRINT_PALETTE,
    other: ManeuverResult | None = None,
    other_name: str = "other run",
) -> DocumentFigure | None:
    """Return inputs, and measured against computed responses, of one maneuver.

    Parameters
    ----------
    other : ManeuverResult, optional
        The same maneuver in another run, whose computed responses are drawn in gray.

    Returns
    -------
    Picture or None
        None where nothing was computed: the fit failed, or earned no derivative.
    """
    history, maneuver, estimate = response_history(result), result.maneuver, result.estimate
    if history is None or estimate is None:
        return None
    inputs = [name for name in ("de", "da", "dr") if name in maneuver.inputs]
    rows = len(inputs) + len(history.channels)
    beside = None if other is None else response_history(other)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        set_margins(container, left=0.95, top=0.32, bottom=0.42, hspace=0.16)
        for chart, name in zip(charts, inputs, strict=False):
            times, values = maneuver.block.times, maneuver.samples(name)
            draw_trace(chart, name, times, values, units, palette.channel(name), palette)
        for chart, response in zip(charts[len(inputs) :], history.channels, strict=True):
            _draw_response(chart, response, history, beside, other_name, units, palette)
        label_flight_time(charts[-1], palette)
        charts[-1].set_xlim(float(history.times[0]), float(history.times[-1]))
        names = {line.get_label() for chart in charts for line in chart.lines}
        container.legend(
            handles=[one for one in _handles(palette, other_name) if one.get_label() in names],
            loc="upper right", ncols=3, borderaxespad=0.1,
        )  # fmt: skip

    return DocumentFigure(
        name=_named("fit", result),
        caption=f"Maneuver {maneuver.id} of {maneuver.flight}: inputs, and "
        f"{estimation_method(estimate.method).comparison_text}",
        height=min(MAX_FIGURE_HEIGHT, 0.8 + _ROW_HEIGHT * rows),
        draw=draw,
        numbers=lambda: _numbers(result, inputs, history, units),
    )


def _handles(palette: Palette, other_name: str) -> list[Line2D]:
    """Return the legend: measured traces have the colors of their channels."""
    return [
        Line2D(
            [], [], color=palette.secondary_ink, label="measured",
            linewidth=WIDE_LINE_WIDTH * palette.line_scale,
            alpha=UNDERLAY_ALPHA,
        ),
        Line2D([], [], color=palette.ink, linestyle="--", label="computed"),
        Line2D([], [], color=palette.previous, label=other_name),
    ]  # fmt: skip


def response_history(result: ManeuverResult) -> ResponseHistory | None:
    """Return what was measured and computed in one maneuver; None where nothing was computed."""
    if result.estimate is None or not result.estimate.histories:
        return None
    return result.estimate.histories[0]


def _named(what: str, result: ManeuverResult) -> str:
    maneuver = result.maneuver
    return f"{what}-{maneuver.flight}-{maneuver.id}".replace(":", "-").replace("/", "-")


def _draw_response(
    chart: Axes,
    name: str,
    history: ResponseHistory,
    beside: ResponseHistory | None,
    other_name: str,
    units: str,
    palette: Palette,
) -> None:
    column = history.channels.index(name)
    draw_trace(
        chart, name, history.times, history.measured[:, column], units,
        palette.channel(name), palette,
        label="measured", under=True,
    )  # fmt: skip
    draw_trace(
        chart, name, history.times, history.computed[:, column], units, palette.ink, palette,
        label="computed", linestyle="--",
    )  # fmt: skip
    if beside is not None and name in beside.channels:
        draw_trace(
            chart, name, beside.times, beside.computed[:, beside.channels.index(name)], units,
            palette.previous, palette, label=other_name, behind=True,
        )  # fmt: skip


def residual_figure(
    result: ManeuverResult, *, units: str = "US", palette: Palette = PRINT_PALETTE
) -> DocumentFigure | None:
    """Return the residuals of one maneuver and how they repeat themselves.

    None without any, and where smoothing made them: what it leaves is never white.

    Right of each residual stands its autocorrelation over a second, with the band that white noise
    would keep within in 95 %.
    """
    history, maneuver = response_history(result), result.maneuver
    if history is None or result.estimate is None or compares_coefficients(result.estimate.method):
        return None
    rows = len(history.channels)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 2, squeeze=False, width_ratios=(2.2, 1.0), sharex="col")
        set_margins(container, left=0.95, top=0.25, bottom=0.42, hspace=0.25, wspace=0.18)
        residuals = history.measured - history.computed
        dt = float(np.median(np.diff(history.times)))
        for row, name in enumerate(history.channels):
            left, right = charts[row]
            times, values = history.times, residuals[:, row]
            draw_trace(left, name, times, values, units, palette.channel(name), palette)
            lags, repeated, band = autocorrelation(residuals[:, row], dt)
            right.axhspan(-band, band, color=palette.band, linewidth=0)
            right.plot(lags, repeated, color=palette.channel(name))
            right.set_ylim(-1.05, 1.05)
            format_axes(right, palette)
        charts[0, 1].set_title("autocorrelation", loc="left", color=palette.ink, y=1.0, pad=3.0)
        label_flight_time(charts[-1, 0], palette)
        charts[-1, 1].set_xlabel("lag [s]", color=palette.ink)
        charts[-1, 0].set_xlim(float(history.times[0]), float(history.times[-1]))

    return DocumentFigure(
        name=_named("residuals", result),
        caption=f"Maneuver {maneuver.id} of {maneuver.flight}: residuals and autocorrelation; "
        "white noise stays within the band.",
        height=min(MAX_FIGURE_HEIGHT, 0.8 + _ROW_HEIGHT * rows),
        draw=draw,
        numbers=lambda: _numbers(result, [], history, units),
    )


def autocorrelation(values: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, float]:
    """Return how a residual, sampled every `dt` (s), repeats itself over a second.

    Parameters
    ----------
    values : ndarray, shape (n,)
        NaN where a sample did not count.

    Returns
    -------
    lags : ndarray, shape (m,)
        s.
    autocorrelation : ndarray, shape (m,)
        1 at lag zero.
    band : float
        Half the width of the band that white noise keeps within in 95 %.
    """
    good = np.isfinite(values)
    centered = np.where(good, values - (values[good].mean() if good.any() else 0.0), 0.0)
    most = min(max(2, round(1.0 / dt)), values.size - 1)
    size = 2 ** int(np.ceil(np.log2(2 * values.size)))
    power = np.abs(np.fft.rfft(centered, size)) ** 2
    sums = np.fft.irfft(power, size)[: most + 1]
    scale = sums[0] if sums[0] > 0.0 else 1.0
    band = 1.96 / math.sqrt(max(int(good.sum()), 1))
    lags = np.arange(most + 1, dtype=np.float64) * dt
    return lags, np.asarray(sums / scale, dtype=np.float64), band


def _numbers(
    result: ManeuverResult, inputs: Sequence[str], history: ResponseHistory, units: str
) -> DocumentTable:
    maneuver = result.maneuver
    at = [int(np.abs(maneuver.block.times - time).argmin()) for time in history.times]
    columns = [history.times]
    columns += [display_values(name, maneuver.samples(name)[at], units) for name in inputs]
    for column, name in enumerate(history.channels):
        columns.append(display_values(name, history.measured[:, column], units))
        columns.append(display_values(name, history.computed[:, column], units))
    heads = [column_title(name, units) for name in inputs]
    for name in history.channels:
        heads += [f"{column_title(name, units)} measured", f"{column_title(name, units)} computed"]
    return DocumentTable(
        columns=("time [s]", *heads),
        rows=tuple(tuple(map(exact_number_text, row)) for row in np.column_stack(columns)),
    )
