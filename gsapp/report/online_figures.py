"""Derivatives as they formed in the air, against what maximum likelihood found on the ground.

Figures 8.2.x of the source: FTR over the flight, the point of each maneuver, and the mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D

from gsapp.identification.campaign import CampaignResult
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.summary import CampaignSummary, DerivativeSummary
from gsapp.report.document import DocumentFigure, DocumentTable, set_margins
from gsapp.report.palette import PRINT_PALETTE, Palette
from gsapp.report.plot_elements import (
    DERIVATIVE_PREFIX,
    create_axes_grid,
    exact_number_text,
    format_axes,
    format_clock_axis,
    label_flight_time,
    name_points,
    symbol_mathtext,
)
from gsapp.report.settings import REPORT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ONLINE_FIGURE_COLUMNS: Final = 2
_MOST: Final = 12


def online_estimates_figure(
    histories: Sequence[EstimateHistory],
    result: CampaignResult,
    summary: CampaignSummary,
    flight: str,
    number: int,
    *,
    palette: Palette = PRINT_PALETTE,
    across: int = ONLINE_FIGURE_COLUMNS,
) -> DocumentFigure:
    """Return how FTR's values formed over a flight, with the points and means of the campaign.

    Parameters
    ----------
    result : CampaignResult
        Whose maneuvers of this flight are drawn as points, where they ended.
    summary : CampaignSummary
        Whose means are the lines to be reached.
    """
    drawn = tuple(histories)[:_MOST]
    rows = -(-len(drawn) // across)
    ends = {
        one.maneuver.id: one.maneuver.t_end
        for one in result.results
        if one.maneuver.flight == flight
    }

    def draw(container: FigureBase) -> None:
        charts, lowest = create_axes_grid(container, len(drawn), across, sharex=True)
        set_margins(container, left=0.6, top=0.44, bottom=0.42, hspace=0.32, wspace=0.22)
        for chart, one in zip(charts, drawn, strict=True):
            _draw_history(chart, one, summary.derivatives.get(one.name), ends, palette)
        for chart in lowest:
            chart.tick_params(labelbottom=True)
            label_flight_time(chart, palette)
        container.legend(
            handles=_handles(palette), loc="upper left", ncols=3, borderaxespad=0.1,
            columnspacing=1.2,
        )  # fmt: skip

    return DocumentFigure(
        name=f"online-{number}",
        caption=f"{flight}: in-flight FTR estimates (line, 95 % band), post-flight values of "
        "each maneuver (points, 95 %) and campaign mean (dashed, with band). Gaps: not "
        "excited.",
        height=0.8 + 1.45 * rows,
        draw=draw,
        numbers=lambda: _numbers(drawn),
    )


def _handles(palette: Palette) -> list[Line2D]:
    return [
        Line2D([], [], color=palette.ink, label="FTR in flight"),
        Line2D(
            [], [], color=palette.ink, linestyle="none", marker="s", markersize=3.5,
            label="post-flight, each maneuver",
        ),
        Line2D([], [], color=palette.ink, linestyle="--", label="mean of the campaign"),
    ]  # fmt: skip


def _draw_history(
    chart: Axes,
    one: EstimateHistory,
    known: DerivativeSummary | None,
    ends: dict[str, float],
    palette: Palette,
) -> None:
    chart.set_gid(DERIVATIVE_PREFIX + one.name)
    if known is not None:
        half = REPORT.error_bar_sigmas * known.value.std
        mean = known.value.mean
        chart.axhspan(mean - half, mean + half, color=palette.band, linewidth=0)
        chart.axhline(mean, color=palette.ink, linewidth=0.8 * palette.line_scale, linestyle="--")
    low, high = (
        one.values - REPORT.error_bar_sigmas * one.stds,
        one.values + REPORT.error_bar_sigmas * one.stds,
    )
    color = palette.channel(one.name)
    chart.fill_between(one.times, low, high, color=color, alpha=0.18, linewidth=0)
    chart.plot(one.times, one.values, color=color)
    points = [] if known is None else [one for one in known.included_points if one.maneuver in ends]
    if points:
        bars = chart.errorbar(
            [ends[point.maneuver] for point in points],
            [point.value for point in points],
            yerr=[REPORT.error_bar_sigmas * point.std for point in points],
            linestyle="none", marker="s", markersize=3.5, color=palette.ink,
            elinewidth=0.7 * palette.line_scale, zorder=3,
        )  # fmt: skip
        name_points(bars.lines[0], [point.maneuver for point in points])
    format_axes(chart, palette)
    format_clock_axis(chart)
    chart.set_title(
        symbol_mathtext(one.name), loc="left", color=palette.ink, y=1.0, parse_math=True
    )
    chart.set_xlim(float(one.times[0]), float(one.times[-1]))
    earned = np.isfinite(one.values)
    if not earned.any():
        chart.text(
            0.5, 0.9, "unknown: not excited", transform=chart.transAxes, ha="center",
            va="top", color=palette.secondary_ink,
        )  # fmt: skip
        return
    # The first moments, with a bound many times the last one, must not flatten the rest.
    last = float(one.values[earned][-1])
    room = REPORT.online_axis_margin * max(
        float(one.stds[earned][-1]), known.value.std if known else 0.0
    )
    shown = [last, *([known.value.mean] if known else ()), *(point.value for point in points)]
    reach = max(room, 1.2 * max(abs(value - last) for value in shown))
    chart.set_ylim(last - reach, last + reach)


def _numbers(histories: Sequence[EstimateHistory]) -> DocumentTable:
    return DocumentTable(
        columns=("derivative", "time [s]", "value", "bound"),
        rows=tuple(
            (one.name, exact_number_text(time), exact_number_text(value), exact_number_text(std))
            for one in histories
            for time, value, std in zip(one.times, one.values, one.stds, strict=True)
        ),
    )
