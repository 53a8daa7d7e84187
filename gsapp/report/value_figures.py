"""Each derivative, maneuver by maneuver, against what it may depend on.

Flights differ by color and marker, thick bars are 95 % of each value's own bound, thin ones of it
and what maneuvers and methods disagree together, the band is the mean with 95 % of its error. What
does not count stays in sight, gray.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import FigureBase
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, Locator

from gsapp.identification.summary import CampaignSummary, DerivativePoint, DerivativeSummary
from gsapp.quantities import channel
from gsapp.report.document import DocumentFigure, DocumentTable, set_margins
from gsapp.report.palette import PRINT_PALETTE, Palette, flight_marker
from gsapp.report.plot_elements import (
    DERIVATIVE_PREFIX,
    axis_label,
    column_title,
    create_axes_grid,
    display_values,
    exact_number_text,
    format_axes,
    name_points,
    symbol_mathtext,
)
from gsapp.report.settings import REPORT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

VALUE_FIGURE_COLUMNS: Final = 3
_FIGURE_ROWS: Final = 4
_OUTLIER, _BY_HAND, _UNFIT = "x", "+", "1"
_SMALL, _LARGE = 3.2, 5.5
"""Markers in points: of small charts, and of one alone."""
_FLIGHTS_A_ROW: Final = 6
_NAMED: Final = 5
"""Maneuvers that have room for their names below a chart, while they are called by numbers."""
_LONGEST: Final = 10
"""Letters of a name below a chart."""
_LETTER: Final = 0.6
"""Width of a letter in heights."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _ChartStyle:
    """What all charts of a picture share."""

    over: str
    units: str
    palette: Palette
    flights: Mapping[str, int]
    known: Mapping[str, float] = field(default_factory=dict)
    size: float = _SMALL


class _ManeuverLocator(Locator):
    """Marks some of the maneuvers, as many as have room for their names in sight."""

    def __init__(self, chart: Axes, names: Mapping[int, str]) -> None:
        self._chart = chart
        self._names = dict(sorted(names.items()))
        size = FontProperties(size=rcParams["xtick.labelsize"]).get_size_in_points()
        self._letter = _LETTER * size / 72.0

    def __call__(self) -> Sequence[float]:
        return [] if self.axis is None else self.tick_values(*sorted(self.axis.get_view_interval()))

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        seen = [place for place in self._names if vmin <= place <= vmax]
        marked = seen[:: max(1, -(-len(seen) // _NAMED))]
        inches = self._chart.get_window_extent().width / self._chart.figure.dpi
        letter = self._letter / inches * (vmax - vmin)
        kept: list[float] = []
        end = -math.inf
        for place in marked:
            half = 0.5 * letter * len(_short(self._names[place]))
            if place - half > end:
                kept.append(float(place))
                end = place + half + letter
        return kept


def _short(maneuver: str) -> str:
    """Return the id of a maneuver, or its beginning where it was given a long name."""
    return maneuver if len(maneuver) <= _LONGEST else f"{maneuver[: _LONGEST - 1]}…"


def value_figures(
    summary: CampaignSummary,
    over: str,
    *,
    units: str = "US",
    known: Mapping[str, float] | None = None,
    palette: Palette = PRINT_PALETTE,
) -> tuple[DocumentFigure, ...]:
    """Return each derivative against a condition or the number of the maneuver, page by page.

    Parameters
    ----------
    over : str
        ``V``, ``alpha``, ``beta`` or ``number``.
    known : mapping of str to float, optional
        Values known before, drawn as a dotted gray line.

    Returns
    -------
    tuple of Picture
        As many pages as it takes; derivatives of bias (``_0``) are left to the table.
    """
    names = [name for name in summary.derivatives if not name.endswith("_0")]
    page = VALUE_FIGURE_COLUMNS * _FIGURE_ROWS
    return tuple(
        value_figure(
            summary, names[first : first + page], over, units=units, known=known, palette=palette,
            number=first // page + 1,
        )
        for first in range(0, len(names), page)
    )  # fmt: skip


def value_figure(
    summary: CampaignSummary,
    names: Sequence[str],
    over: str,
    *,
    units: str = "US",
    known: Mapping[str, float] | None = None,
    palette: Palette = PRINT_PALETTE,
    across: int = VALUE_FIGURE_COLUMNS,
    number: int = 1,
) -> DocumentFigure:
    """Return some derivatives against a condition or the number of the maneuver."""
    chosen = [summary.derivatives[name] for name in names]
    across = min(across, len(chosen))
    drawn = _ChartStyle(
        over=over, units=units, palette=palette, flights=_flights(summary), known=known or {},
        size=_LARGE if len(chosen) == 1 else _SMALL,
    )  # fmt: skip
    label = "maneuver" if over == "number" else axis_label(over, units)

    def draw(container: FigureBase) -> None:
        charts, lowest = create_axes_grid(container, len(chosen), across)
        handles = _handles(chosen, drawn)
        rows_of_legend = -(-len(handles) // _FLIGHTS_A_ROW)
        set_margins(
            container, left=0.6, top=0.27 + 0.15 * rows_of_legend, bottom=0.45, hspace=0.42,
            wspace=0.3,
        )  # fmt: skip
        for chart, one in zip(charts, chosen, strict=True):
            _draw_values(chart, one, drawn)
        for chart in lowest:
            chart.set_xlabel(label, color=palette.ink, parse_math=True)
        container.legend(
            handles=handles, loc="upper left", ncols=_FLIGHTS_A_ROW, borderaxespad=0.1,
            columnspacing=1.2, handletextpad=0.4,
        )  # fmt: skip

    rows = -(-len(chosen) // across)
    text = "by maneuver" if over == "number" else f"over {column_title(over, units)}"
    subject = f"{names[0]}, per radian," if len(chosen) == 1 else "Each derivative, per radian,"
    there = any(name in drawn.known for name in names)
    dotted = ", dotted line: prior" if there else ""
    out = any(one.outliers or one.excluded or one.nonconverged_points for one in chosen)
    thick = ", thick: noise alone" if any(one.point_disagreement for one in chosen) else ""
    gray = " Gray marks are excluded from the mean." if out else ""
    return DocumentFigure(
        name=f"values-{over}-{number}",
        caption=f"{subject} {text}: bars: 95 % bounds{thick}; band: mean with 95 % "
        f"error{dotted}.{gray}{_not_drawn(chosen, over)}",
        height=0.9 + 1.65 * rows if len(chosen) > 1 else 3.6,
        draw=draw,
        numbers=lambda: _numbers(chosen, units),
    )


def _not_drawn(chosen: Sequence[DerivativeSummary], over: str) -> str:
    """Return in a sentence which maneuvers have no place on the axis; empty where all have."""
    if over == "number":
        return ""
    points = (point for one in chosen for point in one.points)
    count = len({point.maneuver for point in points if over not in point.conditions})
    what = f"{channel(over).title.lower()} was not measured"
    if count == 0:
        return ""
    return f" Not drawn: {count} {'maneuver' if count == 1 else 'maneuvers'} whose {what}."


def _flights(summary: CampaignSummary) -> dict[str, int]:
    """Return the flights in order of appearance, each with its number."""
    names = dict.fromkeys(
        point.flight for one in summary.derivatives.values() for point in one.points
    )
    return {name: index for index, name in enumerate(names)}


def _place(point: DerivativePoint, drawn: _ChartStyle) -> float:
    if drawn.over == "number":
        return float(point.number)
    value = point.conditions.get(drawn.over, np.nan)
    return float(display_values(drawn.over, np.asarray(value), drawn.units))


def _draw_values(chart: Axes, one: DerivativeSummary, drawn: _ChartStyle) -> None:
    palette = drawn.palette
    chart.set_gid(DERIVATIVE_PREFIX + one.name)
    half = REPORT.error_bar_sigmas * one.value.std
    chart.axhspan(one.value.mean - half, one.value.mean + half, color=palette.band, linewidth=0)
    chart.axhline(one.value.mean, color=palette.ink, linewidth=0.8 * palette.line_scale)
    bounds = [one.bound(point) for point in one.included_points]
    _draw_error_bars(chart, one.included_points, bounds, 0.7, drawn)
    if one.point_disagreement:
        noise = [point.std for point in one.included_points]
        _draw_error_bars(chart, one.included_points, noise, 1.8, drawn)
    for flight, place in drawn.flights.items():
        points = [point for point in one.included_points if point.flight == flight]
        if not points:
            continue
        (line,) = chart.plot(
            [_place(point, drawn) for point in points], [point.value for point in points],
            linestyle="none", marker=flight_marker(place), markersize=drawn.size,
            color=palette.flight(place), zorder=2.5,
        )  # fmt: skip
        name_points(line, [point.maneuver for point in points])
    format_axes(chart, palette)
    if drawn.over == "number":
        names = {point.number: point.maneuver for point in (*one.points, *one.nonconverged_points)}
        chart.xaxis.set_major_locator(_ManeuverLocator(chart, names))
        chart.xaxis.set_major_formatter(
            FuncFormatter(lambda place, _: _short(names.get(round(place), "")))
        )
    chart.margins(x=0.08)
    _draw_left_out(chart, [outlier.point for outlier in one.outliers], _OUTLIER, drawn)
    _draw_left_out(chart, one.excluded, _BY_HAND, drawn)
    _draw_left_out(chart, one.nonconverged_points, _UNFIT, drawn)
    if one.name in drawn.known:
        chart.axhline(
            drawn.known[one.name], color=palette.previous, linewidth=0.9 * palette.line_scale,
            linestyle=":",
        )  # fmt: skip
    chart.set_title(
        symbol_mathtext(one.name), loc="left", color=palette.ink, y=1.0, parse_math=True
    )


def _draw_error_bars(
    chart: Axes,
    points: Sequence[DerivativePoint],
    stds: Sequence[float],
    width: float,
    drawn: _ChartStyle,
) -> None:
    """Draw the bars of all flights at once: an error bar for each costs a second of CPU."""
    values = np.array([point.value for point in points])
    half = REPORT.error_bar_sigmas * np.asarray(stds)
    chart.vlines(
        [_place(point, drawn) for point in points], values - half, values + half,
        colors=[drawn.palette.flight(drawn.flights[point.flight]) for point in points],
        linewidth=width * drawn.palette.line_scale,
    )  # fmt: skip


def _draw_left_out(
    chart: Axes, points: Sequence[DerivativePoint], sign: str, drawn: _ChartStyle
) -> None:
    if not points:
        return
    low, high = chart.get_ylim()
    (line,) = chart.plot(
        [_place(point, drawn) for point in points],
        # A wild value stays in sight at the edge and does not flatten the others.
        [min(max(point.value, low), high) for point in points],
        linestyle="none", marker=sign, color=drawn.palette.excluded, markersize=drawn.size + 1.8,
        markeredgewidth=1.2 * drawn.palette.line_scale, clip_on=False,
    )  # fmt: skip
    name_points(line, [point.maneuver for point in points])
    chart.set_ylim(low, high)


def _handles(chosen: Sequence[DerivativeSummary], drawn: _ChartStyle) -> list[Line2D]:
    """Return what the legend explains: flights, gray marks, the dotted line."""
    palette = drawn.palette
    handles = [
        Line2D(
            [], [], linestyle="none", marker=flight_marker(place), markersize=4.0,
            color=palette.flight(place), label=name,
        )
        for name, place in drawn.flights.items()
    ]  # fmt: skip
    gray = {
        _OUTLIER: ("outlier", any(one.outliers for one in chosen)),
        _BY_HAND: ("excluded manually", any(one.excluded for one in chosen)),
        _UNFIT: ("fit did not converge", any(one.nonconverged_points for one in chosen)),
    }
    handles += [
        Line2D([], [], linestyle="none", marker=sign, color=palette.excluded, label=text)
        for sign, (text, there) in gray.items()
        if there
    ]
    if any(one.name in drawn.known for one in chosen):
        handles.append(Line2D([], [], color=palette.previous, linestyle=":", label="prior"))
    return handles


def _why(point: DerivativePoint, outliers: set[str], by_hand: set[str]) -> str:
    if point.maneuver in outliers:
        return "outlier"
    return "by hand" if point.maneuver in by_hand else "did not converge"


def _numbers(chosen: Sequence[DerivativeSummary], units: str) -> DocumentTable:
    conditions = ("V", "alpha", "beta")
    rows = []
    for one in chosen:
        out = {outlier.point.maneuver for outlier in one.outliers}
        by_hand = {point.maneuver for point in one.excluded}
        unfit = {point.maneuver for point in one.nonconverged_points}
        for point in (*one.points, *one.nonconverged_points):
            kept = point.maneuver not in out | by_hand | unfit
            rows.append(
                (
                    one.name,
                    point.maneuver,
                    point.flight,
                    str(point.number),
                    *(
                        exact_number_text(float(display_values(name, np.asarray(value), units)))
                        if (value := point.conditions.get(name)) is not None
                        else ""
                        for name in conditions
                    ),
                    exact_number_text(point.value),
                    exact_number_text(point.std),
                    exact_number_text(one.bound(point)),
                    "" if kept else _why(point, out, by_hand),
                )
            )
    return DocumentTable(
        columns=(
            "derivative", "maneuver", "flight", "number",
            *(column_title(name, units) for name in conditions), "value", "noise", "bound",
            "left out",
        ),
        rows=tuple(rows),
    )  # fmt: skip
