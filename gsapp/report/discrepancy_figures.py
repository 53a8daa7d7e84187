"""Pictures of a search for a missing effect: where, what, and how far the gap has shrunk.

Each function returns a `DocumentFigure`, drawn when the report is written. Measured is solid in
the color of its channel, computed dashed, the model before gray (ui and paper alike).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import FigureBase
from matplotlib.ticker import FuncFormatter, MaxNLocator

from gsapp.discrepancy.results import (
    DiscrepancyResult,
    ManeuverHistories,
    ModelStep,
    UnexplainedStructure,
)
from gsapp.quantities import FloatArray, channel
from gsapp.quantities.notation import symbol_text
from gsapp.report.discrepancy_pictures import (
    CONDITIONS,
    channel_gaps,
    channel_overlay,
    missing_by_condition,
    missing_history,
    structure_curves,
    variable_unit,
    waterfall_steps,
)
from gsapp.report.discrepancy_text import (
    coefficient_label,
    gain_text,
    probability_text,
    residual_map,
)
from gsapp.report.document import FIGURE_WIDTH, MAX_FIGURE_HEIGHT, DocumentFigure, set_margins
from gsapp.report.palette import PRINT_PALETTE
from gsapp.report.plot_elements import (
    axis_label,
    format_clock_axis,
    label_channel,
    label_flight_time,
    symbol_mathtext,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

INK, FAINT, _BEFORE = PRINT_PALETTE.ink, PRINT_PALETTE.faint, PRINT_PALETTE.previous
_STEP, _BAND = PRINT_PALETTE.traces["blue"], "#dfe3e8"
_FEW_ROWS, _FEW_COLUMNS = 12, 8
"""Maneuvers and columns from which those of a map stand closer."""
_POINTS = 1200
"""Of a trace on paper: more cannot be told apart."""
_LONGEST_TITLE = 50
_SCALE = (1.0, 2.0, 4.0, 10.0, 20.0, 40.0, 100.0, 200.0, 400.0, 1000.0)
_BINS, _LEAST, _LEAST_SHARE = 12, 10, 0.01
"""Bins of a condition, and the fewest samples that make a median worth drawing."""


def coefficient_map_figure(found: DiscrepancyResult) -> DocumentFigure:
    """Return the map maneuver x coefficient in units of the noise floor, before and after."""
    return _maps(
        found,
        "map",
        tuple(map(symbol_mathtext, found.coefficients)),
        (found.steps[0].coefficient_map, found.steps[-1].coefficient_map),
        "Residual of each coefficient in each maneuver, in units of the noise floor (1 = "
        "noise). Maneuvers marked * are held out.",
    )


def residual_map_figure(found: DiscrepancyResult) -> DocumentFigure:
    """Return the map maneuver x channel in units of the noise floor, before and after."""
    return _maps(
        found,
        "map-channels",
        tuple(symbol_mathtext(channel(name).symbol) for name in found.channels),
        (residual_map(found, 0), residual_map(found, -1)),
        "Residual of each channel in the simulation of each maneuver, in units of its noise.",
    )


def _maps(
    found: DiscrepancyResult,
    name: str,
    columns: tuple[str, ...],
    maps: tuple[FloatArray, FloatArray],
    caption: str,
) -> DocumentFigure:
    """Return two maps beside each other, or one where nothing was added."""
    shown = maps[:1] if len(found.steps) == 1 else maps
    rows = len(found.maneuvers)
    height = min(MAX_FIGURE_HEIGHT, 0.75 + (0.26 if rows <= _FEW_ROWS else 0.2) * max(rows, 4))
    most = max(4.0, *(float(_finite(values).max(initial=1.0)) for values in shown))

    def draw(container: FigureBase) -> None:
        charts = container.subplots(1, 2, sharey=True)
        set_margins(container, left=1.15, right=0.75, top=0.62, bottom=0.08, wspace=0.08)
        for chart in charts[len(shown) :]:
            chart.set_visible(False)
        for chart, values, title in zip(charts, shown, ("before", "after"), strict=False):
            image = _draw_map(chart, columns, values, most)
            chart.set_title(title, loc="left", color=INK, pad=16)
        charts[0].set_yticks(range(rows), [_row_label(one) for one in found.maneuvers])
        last = charts[len(shown) - 1]
        bar = container.colorbar(
            image, ax=list(charts[: len(shown)]), cax=last.inset_axes((1.04, 0.0, 0.05, 1.0))
        )
        bar.set_label("times the noise", color=INK)
        bar.set_ticks([value for value in _SCALE if value <= most], minor=False)
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        bar.minorticks_off()

    return DocumentFigure(name=name, caption=caption, height=height, draw=draw)


def _finite(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def _row_label(view: ManeuverHistories) -> str:
    return f"{view.id} {view.kind}{' *' if view.held_out else ''}"


def _draw_map(chart: Axes, columns: tuple[str, ...], values: FloatArray, most: float) -> AxesImage:
    image = chart.imshow(
        np.maximum(values, 1.0), norm=LogNorm(1.0, most), cmap="YlOrBr", aspect="auto"
    )
    crowded = len(columns) > _FEW_COLUMNS
    chart.set_xticks(range(len(columns)), columns, fontsize=5.5 if crowded else 7.0,
                     parse_math=True)  # fmt: skip
    chart.xaxis.tick_top()
    chart.tick_params(length=0)
    for row, line in enumerate(values):
        for column, value in enumerate(line):
            dark = np.isfinite(value) and value > most**0.6
            chart.text(
                column, row, _times(value), ha="center", va="center",
                fontsize=5.2 if crowded else 6.2, color="white" if dark else INK,
            )  # fmt: skip
    for side in chart.spines.values():
        side.set_visible(False)
    return image


def missing_history_figure(
    found: DiscrepancyResult, coefficient: str, maneuvers: Sequence[str]
) -> DocumentFigure:
    """Return the missing part of a coefficient over time in some maneuvers, before and after."""
    views = [one for one in found.maneuvers if one.id in maneuvers]
    index = found.coefficients.index(coefficient)

    def draw(container: FigureBase) -> None:
        charts = container.subplots(len(views), 1, sharey=True, squeeze=False)[:, 0]
        set_margins(container, left=0.72, top=0.42, hspace=0.6)
        for chart, view in zip(charts, views, strict=True):
            shown = missing_history(found, view, coefficient)
            _draw_noise_band(chart, shown.floor)
            few = _thinned(view.times)
            chart.plot(view.times[few], shown.before[few], color=_BEFORE, label="before")
            if shown.after is not None:
                color = PRINT_PALETTE.channel(coefficient)
                chart.plot(view.times[few], shown.after[few], label="after", color=color)
            _plain_axes(chart)
            format_clock_axis(chart)
            chart.set_title(f"maneuver {_row_label(view)}", loc="left", color=INK, fontsize=7.5)
            chart.set_ylabel(f"missing {symbol_mathtext(coefficient)}", color=INK, parse_math=True)
            chart.set_xlim(float(view.times[0]), float(view.times[-1]))
        # One maneuver far beyond the others must not flatten them.
        sizes = [_finite(np.abs(view.missing[0][:, index])).max(initial=0.0) for view in views]
        usual = 2.5 * float(np.median(sizes)) if sizes else 0.0
        _clip_axis(charts[0], -usual, usual)
        label_flight_time(charts[-1], PRINT_PALETTE)
        _legend_above(container, charts[0])

    return DocumentFigure(
        name=f"missing-{coefficient}-time",
        caption=f"The residual of the {coefficient_label(coefficient)} over time, low-pass "
        "filtered.",
        height=min(MAX_FIGURE_HEIGHT, 0.8 + 1.3 * len(views)),
        draw=draw,
    )


def missing_by_condition_figure(
    found: DiscrepancyResult, coefficient: str, marked: str = "", units: str = "US"
) -> DocumentFigure:
    """Return the missing part of a coefficient over everything that it might depend on.

    Parameters
    ----------
    marked : str
        The variable in which the disagreement grows.
    """
    known = [name for name in CONDITIONS if _varies(found, name)]
    rows = max(1, -(-len(known) // 4))

    def draw(container: FigureBase) -> None:
        charts = container.subplots(rows, 4, sharey=True, squeeze=False)
        set_margins(container, left=0.72, top=0.5, hspace=0.55, wspace=0.12)
        for chart in charts.flat[len(known) :]:
            chart.set_visible(False)
        ranges = []
        for chart, name in zip(charts.flat, known, strict=False):
            kinds = ((0, _BEFORE, "before", "o"),
                     (-1, PRINT_PALETTE.channel(coefficient), "after", "s"))  # fmt: skip
            for step, color, label, marker in kinds[: len(found.steps)]:
                pairs = [
                    pair
                    for view in found.maneuvers
                    if (pair := missing_by_condition(view, coefficient, name, step, units))
                ]
                x, y = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
                ranges += _draw_bins(chart, x, y, color, label, marker)
            chart.axhline(0.0, color=INK, linewidth=0.5)
            _plain_axes(chart)
            chart.xaxis.set_major_locator(MaxNLocator(nbins=4))
            chart.set_xlabel(
                axis_label(name, units),
                color=INK,
                fontweight="bold" if name == marked else "normal",
                parse_math=True,
            )
        for row in charts:
            row[0].set_ylabel(f"missing {symbol_mathtext(coefficient)}", color=INK, parse_math=True)
        # The medians tell the story; bars of a few wild samples may be cut off.
        low = min((one for one, _ in ranges), default=0.0)
        high = max((one for _, one in ranges), default=0.0)
        _clip_axis(charts[0, 0], 2.0 * low - high, 2.0 * high - low)
        _legend_above(container, charts[0, 0])

    bold = f" It grows most with {channel(marked).title.lower()}." if marked in known else ""
    return DocumentFigure(
        name=f"missing-{coefficient}-region",
        caption=f"The residual of the {coefficient_label(coefficient)} over the flight "
        f"condition: median and quartiles in bins.{bold}",
        height=0.95 + 1.75 * rows,
        draw=draw,
    )


def structure_figure(structure: UnexplainedStructure, units: str = "US") -> DocumentFigure:
    """Return a structure without a name over the variables that change it most."""
    curves = structure_curves(structure, units)
    name = structure.variables[0]
    unit = variable_unit(name, units)

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=0.9, top=0.4)
        shades = np.linspace(0.35, 1.0, len(curves))
        color = PRINT_PALETTE.channel(structure.coefficient)
        for one, shade in zip(curves, shades, strict=True):
            chart.plot(one.x, one.y, color=color, alpha=float(shade), marker="o", markersize=2.5,
                       label=one.name)  # fmt: skip
        chart.axhline(0.0, color=INK, linewidth=0.5)
        _plain_axes(chart)
        chart.set_xlabel(
            f"{symbol_mathtext(symbol_text(name))}{f' [{unit}]' if unit else ''}",
            color=INK, parse_math=True,
        )  # fmt: skip
        chart.set_ylabel(symbol_mathtext(structure.coefficient), color=INK, parse_math=True)
        if len(curves) > 1:
            _legend_above(container, chart)

    return DocumentFigure(
        name=f"structure-{structure.coefficient}",
        caption=f"Found, not understood: {structure.equation}. Drawn where it was flown.",
        height=2.4,
        draw=draw,
    )


def _varies(found: DiscrepancyResult, name: str) -> bool:
    known = [one.conditions[name] for one in found.maneuvers if name in one.conditions]
    if not known:
        return False
    values = _finite(np.concatenate(known))
    if values.size == 0:
        return False
    low, high = np.quantile(values, (0.01, 0.99))
    return bool(high - low > 2.0 * channel(name).precision)


def _draw_noise_band(chart: Axes, floor: float) -> None:
    chart.axhspan(-2.0 * floor, 2.0 * floor, color=_BAND, linewidth=0, label="noise, ± 2")


def _draw_bins(
    chart: Axes, x: FloatArray, y: FloatArray, color: str, label: str, marker: str
) -> list[tuple[float, float]]:
    """Draw the medians of `y` in bins of `x`; return their range, where there are any."""
    good = np.isfinite(x) & np.isfinite(y)
    if good.sum() < 2 * _BINS:
        return []
    edges = np.linspace(float(x[good].min()), float(x[good].max()), _BINS + 1)
    places = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, _BINS - 1)
    middles, medians, lows, highs = [], [], [], []
    for number in range(_BINS):
        inside = good & (places == number)
        if inside.sum() < max(_LEAST, _LEAST_SHARE * good.sum()):
            continue
        low, median, high = np.quantile(y[inside], (0.25, 0.5, 0.75))
        middles.append(float(np.median(x[inside])))
        medians.append(median)
        lows.append(median - low)
        highs.append(high - median)
    chart.errorbar(
        middles, medians, yerr=[lows, highs], color=color, marker=marker, markersize=3.0,
        linewidth=0.7, elinewidth=0.6, label=label,
    )  # fmt: skip
    return [(min(medians), max(medians))] if medians else []


def ranking_figure(step: ModelStep, number: int, *, last: bool = False) -> DocumentFigure:
    """Return the competition that one step's model faced, as bars.

    Parameters
    ----------
    last : bool
        Whether nothing was added after it.
    """
    best = step.ranking[:8]

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=2.95, right=1.75, top=0.3)
        places = np.arange(len(best))
        chart.barh(places, [one.score for one in best], color=_STEP, height=0.62)
        chart.set_yticks(places, [f"{one.effect}\n{_short(one.title)}" for one in best])
        chart.invert_yaxis()
        _plain_axes(chart)
        chart.set_xlabel("log-likelihood gain, penalized", color=INK)
        chart.axvline(0.0, color=INK, linewidth=0.6)
        for place, one in zip(places, best, strict=True):
            chart.annotate(
                f"{probability_text(one.evidence)}, held out {gain_text(one.held_out)}",
                (1.02, place),
                xycoords=("axes fraction", "data"), va="center", fontsize=7.0, color=INK,
                annotation_clip=False,
            )  # fmt: skip
        chart.set_title("probability, held-out gain", loc="right", x=1.36, fontsize=7.0)

    return DocumentFigure(
        name=f"ranking-{number}",
        caption=f"Round {number}: candidate effects, best first"
        + (", none added" if last else "")
        + ". Right: probability among all candidates, and gain on held-out maneuvers.",
        height=0.9 + 0.42 * len(best),
        draw=draw,
    )


def _short(title: str) -> str:
    return title if len(title) <= _LONGEST_TITLE else f"{title[: _LONGEST_TITLE - 1].rstrip()}…"


def response_overlay_figure(view: ManeuverHistories, units: str = "US") -> DocumentFigure:
    """Return one maneuver, measured and computed before and after, with what is left beside it."""
    names = [
        name
        for index, name in enumerate(view.channels)
        if np.isfinite(view.measured[:, index]).any()
    ]

    def draw(container: FigureBase) -> None:
        charts = container.subplots(max(len(names), 1), 2, sharex=True, squeeze=False)
        set_margins(container, left=0.85, top=0.55, hspace=0.18, wspace=0.28)
        few = _thinned(view.times)
        times = view.times[few]
        for (left, right), name in zip(charts, names, strict=False):
            shown = channel_overlay(view, name, units)
            measured, before = shown.measured[few], shown.before[few]
            color = PRINT_PALETTE.channel(name)
            left.plot(times, measured, color=color, label="measured")
            left.plot(times, before, color=_BEFORE, linestyle="--", label="computed before")
            _draw_noise_band(right, shown.floor)
            right.plot(times, measured - before, color=_BEFORE)
            if shown.after is not None:
                after = shown.after[few]
                left.plot(times, after, color=INK, linestyle="--", label="computed after")
                right.plot(times, measured - after, color=color, linewidth=0.7)
            for chart in (left, right):
                _plain_axes(chart)
                chart.yaxis.set_major_locator(MaxNLocator(nbins=3, min_n_ticks=2))
            low, high = float(np.nanmin(measured)), float(np.nanmax(measured))
            _clip_axis(left, 2.0 * low - high, 2.0 * high - low)
            _clip_axis(right, low - high, high - low)
            label_channel(left, name, units, PRINT_PALETTE)
            format_clock_axis(left, right)
        charts[0, 1].set_title("residual", loc="left", color=INK, fontsize=7.5)
        for chart in charts[-1]:
            label_flight_time(chart, PRINT_PALETTE)
            chart.set_xlim(float(view.times[0]), float(view.times[-1]))
        _legend_above(container, charts[0, 0], charts[0, 1])

    kept = (
        " It is held out." if view.held_out
        else " It was used in the fit."
    )  # fmt: skip
    return DocumentFigure(
        name=f"overlay-{view.id.replace(':', '-')}",
        caption=f"Maneuver {view.id} ({view.kind or 'no name'}) of {view.flight}, every "
        f"channel.{kept}",
        height=min(MAX_FIGURE_HEIGHT, 1.1 + 0.72 * max(len(names), 1)),
        draw=draw,
    )


def _clip_axis(chart: Axes, low: float, high: float) -> None:
    """Cut the axis off where a model that runs away would flatten everything else."""
    if high > low:
        bottom, top = chart.get_ylim()
        chart.set_ylim(max(bottom, low), min(top, high))


def gap_figure(found: DiscrepancyResult) -> DocumentFigure:
    """Return the residual of each channel over its noise floor, before and after, as bars."""
    pairs = channel_gaps(found)
    before = np.array([one.before for one in pairs])
    after = np.array([one.after for one in pairs])

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=0.6, top=0.42, bottom=0.35)
        places = np.arange(len(pairs))
        kinds = ((-0.2, before, _BEFORE, "before"), (0.2, after, _STEP, "after"))
        for offset, values, color, label in kinds[: len(found.steps)]:
            bars = chart.bar(places + offset, values, width=0.36, color=color, label=label)
            chart.bar_label(bars, fmt=_times, fontsize=6.5, color=INK, padding=1.5)
        chart.axhline(1.0, color=INK, linewidth=0.8, linestyle=":", label="noise floor")
        if pairs and max(before.max(), after.max()) > 15.0:
            chart.set_yscale("log")
            chart.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            chart.set_ylim(min(0.7, 0.8 * float(min(before.min(), after.min()))), None)
        chart.margins(y=0.12)
        symbols = [symbol_mathtext(channel(one.channel).symbol) for one in pairs]
        chart.set_xticks(places, symbols, parse_math=True)
        chart.set_ylabel("RMS over the noise floor", color=INK)
        _plain_axes(chart)
        _legend_above(container, chart)

    return DocumentFigure(
        name="channels",
        caption="RMS of the residuals on the held-out maneuvers, in units of each channel's "
        "noise floor.",
        height=2.6,
        draw=draw,
    )


def _times(value: float) -> str:
    if not np.isfinite(value):
        return "–"
    return f"{value:.1f}" if value < 10.0 else f"{value:.0f}" if value < 1000.0 else "> 999"


def misfit_waterfall_figure(found: DiscrepancyResult) -> DocumentFigure:
    """Return the misfit of all channels together falling from step to step."""
    steps = waterfall_steps(found)
    names = ["model before", *(one.added or "values refitted" for one in steps[1:])]
    misfits = [one.after for one in steps]

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        set_margins(container, left=0.6, right=0.45, top=0.15, bottom=0.42)
        places = list(range(len(misfits) + 1))
        tops = [*(one.before for one in steps), misfits[-1]]
        bottoms = [0.0, *misfits[1:], 0.0]
        colors = [_BEFORE, *[_STEP] * len(misfits)]
        for place, top, bottom, color in zip(places, tops, bottoms, colors, strict=True):
            chart.bar(place, top - bottom, bottom=bottom, color=color, width=0.62)
            ends = place in (0, places[-1])
            chart.annotate(
                f"{top:.2f}" if ends else f"{bottom - top:+.2f}", (place, max(top, bottom)),
                ha="center", va="bottom", fontsize=7.5, color=INK, xytext=(0, 1.5),
                textcoords="offset points",
            )  # fmt: skip
        for place, level in enumerate(misfits):
            chart.plot([place + 0.31, place + 0.69], [level, level], color=INK, linewidth=0.5)
        chart.axhline(1.0, color=INK, linewidth=0.8, linestyle=":")
        chart.annotate(
            "noise\nfloor", (1.005, 1.0), xycoords=("axes fraction", "data"), ha="left",
            va="center", fontsize=7.0, color=INK, annotation_clip=False,
        )  # fmt: skip
        labels = [*names, "model after"]
        chart.set_xticks(places, [_broken(label) for label in labels])
        chart.set_ylabel("residual, noise = 1", color=INK)
        chart.margins(y=0.12)
        _plain_axes(chart)

    return DocumentFigure(
        name="waterfall",
        caption="All channels on the held-out maneuvers, by step. 1 is the noise floor.",
        height=2.5,
        draw=draw,
    )


def _broken(label: str) -> str:
    """Break an effect's id at its last point, where it would run into its neighbor."""
    head, point, tail = label.rpartition(".")
    return f"{head}.\n{tail}" if point and len(label) > 14 else label


def _thinned(times: FloatArray) -> slice:
    return slice(None, None, max(1, times.size // _POINTS))


def _plain_axes(chart: Axes) -> None:
    for side in ("top", "right"):
        chart.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        chart.spines[side].set_color(FAINT)
    chart.tick_params(colors=INK, length=2.5, width=0.5)
    chart.grid(True, axis="y", color=FAINT, linewidth=0.35)


def _legend_above(container: FigureBase, *charts: Axes) -> None:
    entries: dict[str, Artist] = {}
    for chart in charts:
        handles, labels = chart.get_legend_handles_labels()
        entries.update(zip(labels, handles, strict=True))
    height = container.bbox.height / container.dpi  # type: ignore[attr-defined]
    container.legend(
        list(entries.values()), list(entries), loc="upper right",
        bbox_to_anchor=(1.0 - 0.1 / FIGURE_WIDTH, 1.0 - 0.02 / height), ncols=len(entries),
        borderaxespad=0.0,
    )  # fmt: skip
