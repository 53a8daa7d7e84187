"""Figures of a fleet: a derivative against a condition, and values over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from scipy.stats import t as student_t

from gsapp.identification.fleet.fleet_analysis import FleetTrend, SeriesChange, date_text
from gsapp.identification.fleet.fleet_values import DATE
from gsapp.identification.fleet.settings import FLEET
from gsapp.quantities import FloatArray
from gsapp.report.document import DocumentFigure, DocumentTable, set_margins
from gsapp.report.fleet_text import (
    KIND_TEXTS,
    display_condition,
    display_condition_unit,
    trend_title,
    value_and_bound,
)
from gsapp.report.palette import PRINT_PALETTE, Palette, flight_marker
from gsapp.report.plot_elements import (
    create_axes_grid,
    exact_number_text,
    format_axes,
    symbol_mathtext,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FIRST_YEAR: Final = 1970
_MOST_BARS: Final = 150
"""Values beyond which bars would hide the points."""
_MOST_SERIES: Final = 12
_COLUMNS: Final = 2


def trend_figure(
    trend: FleetTrend, *, units: str = "US", palette: Palette = PRINT_PALETTE
) -> DocumentFigure:
    """Return the values against the first condition, the line of the fleet and of each group."""
    name = trend.values.name

    def draw(container: FigureBase) -> None:
        chart = container.subplots()
        values, stds = trend.values.arrays()
        shown, bars, unit = value_and_bound_arrays(name, values, stds, units)
        x = _shown_condition(trend.conditions[0], trend.columns[:, 0], units)
        keys = np.array([one.key(trend.by) for one in trend.values.values])
        for place, group in enumerate(trend.fit.groups):
            own = keys == group
            color = palette.flight(place)
            chart.plot(
                x[own], shown[own], flight_marker(place), color=color, markersize=2.5,
                alpha=0.6, linestyle="none", label=f"{trend.by} {group}",
            )  # fmt: skip
            if len(values) <= _MOST_BARS:
                chart.errorbar(
                    x[own], shown[own], 1.96 * bars[own], fmt="none", ecolor=color,
                    elinewidth=0.6, alpha=0.6,
                )  # fmt: skip
            _draw_group(chart, trend, group, trend.columns[own, 0], units, color)
        _draw_fleet(chart, trend, units, palette)
        format_axes(chart, palette)
        condition = trend.conditions[0]
        per = display_condition_unit(condition, units)
        chart.set_xlabel(f"{condition} [{per}]" if per else condition, color=palette.ink)
        label = symbol_mathtext(name)
        chart.set_ylabel(f"{label} [{unit}]" if unit else label, parse_math=True)
        if len(trend.fit.groups) <= len(palette.traces):
            chart.legend(loc="best")
        set_margins(container, left=0.75, top=0.12)

    return DocumentFigure(
        name=f"trend-{name}-{trend.conditions[0]}",
        caption=f"{trend_title(trend)}. Thick line and band: fleet, 95 % of its mean; thin lines: "
        f"each {trend.by}. Bars: 95 % of each value's bound.",
        height=3.6,
        draw=draw,
        numbers=lambda: _trend_numbers(trend),
    )


def value_and_bound_arrays(
    name: str, values: FloatArray, stds: FloatArray, units: str
) -> tuple[FloatArray, FloatArray, str]:
    """Return values of a fleet and their bounds as shown, shape (n,), and the unit."""
    # Units of a value have no offset.
    factor, _, unit = value_and_bound(name, 1.0, 0.0, units)
    return factor * values, factor * stds, unit


def _shown_condition(name: str, values: FloatArray, units: str) -> FloatArray:
    shown = display_condition(name, values, units)
    return shown + _FIRST_YEAR if name == DATE else shown


def _draw_group(
    chart: Axes, trend: FleetTrend, group: str, x: FloatArray, units: str, color: str
) -> None:
    line = trend.fit.groups[group]
    condition = trend.conditions[0]
    ends = np.array([x.min(), x.max()])
    values = line.intercept + (line.slope or 0.0) * (ends - trend.fit.reference[condition])
    shown, _, _ = value_and_bound_arrays(trend.values.name, values, values, units)
    chart.plot(_shown_condition(condition, ends, units), shown, color=color, linewidth=0.8)


def _draw_fleet(chart: Axes, trend: FleetTrend, units: str, palette: Palette) -> None:
    fit, condition = trend.fit, trend.conditions[0]
    column = trend.columns[:, 0]
    x = np.linspace(column.min(), column.max(), 60)
    slope = fit.slopes[condition]
    distance = x - fit.reference[condition]
    # At its mean the condition says nothing about the intercept: their errors add up.
    stds = np.hypot(fit.intercept.std, slope.std * distance)
    half = student_t.ppf(0.5 + 0.5 * FLEET.confidence, min(fit.intercept.freedom, slope.freedom))
    shown, bound, _ = value_and_bound_arrays(
        trend.values.name, fit.intercept.value + slope.value * distance, half * stds, units
    )
    across = _shown_condition(condition, x, units)
    chart.fill_between(across, shown - bound, shown + bound, color=palette.band, zorder=0)
    chart.plot(across, shown, color=palette.ink, linewidth=1.6, label="fleet")


def _trend_numbers(trend: FleetTrend) -> DocumentTable:
    """Return the values that are drawn, SI."""
    return DocumentTable(
        columns=("flight", "maneuver", trend.by, *trend.conditions, trend.values.name, "std"),
        rows=tuple(
            (
                one.flight,
                one.maneuver,
                one.key(trend.by),
                *(exact_number_text(float(number)) for number in row),
                exact_number_text(one.value),
                exact_number_text(one.std),
            )
            for one, row in zip(trend.values.values, trend.columns, strict=True)
        ),
    )


def change_figure(
    found: Sequence[SeriesChange], *, units: str = "US", palette: Palette = PRINT_PALETTE
) -> DocumentFigure:
    """Return values over time of the series that changed, or of all where none did."""
    changed = [one for one in found if one.change.time is not None]
    drawn = (changed or list(found))[:_MOST_SERIES]

    def draw(container: FigureBase) -> None:
        charts, lowest = create_axes_grid(container, len(drawn), min(_COLUMNS, len(drawn)))
        for chart, one in zip(charts, drawn, strict=True):
            _draw_series(chart, one, units, palette)
        for chart in lowest:
            chart.set_xlabel("year", color=palette.ink)
        set_margins(container, left=0.75, hspace=0.45, wspace=0.35)

    rows = -(-len(drawn) // _COLUMNS)
    return DocumentFigure(
        name="changes",
        caption="Mean of each flight with 95 % of its bound. Band: the dates between which the "
        f"change lies with {FLEET.date_probability:.0%}; line: its most likely course.",
        height=min(0.6 + 1.7 * rows, 9.6),
        draw=draw,
        numbers=lambda: DocumentTable(
            columns=("series", "group", "flight", "date", "mean", "std"),
            rows=tuple(
                (one.name, one.group, flight, date_text(time), repr(float(mean)), repr(float(std)))
                for one in drawn
                for flight, time, mean, std in zip(
                    one.flights, one.times, one.means, one.stds, strict=True
                )
            ),
        ),
    )


def _draw_series(chart: Axes, one: SeriesChange, units: str, palette: Palette) -> None:
    means, stds, unit = value_and_bound_arrays(one.name, one.means, one.stds, units)
    chart.errorbar(
        one.times + _FIRST_YEAR, means, 1.96 * stds, fmt="o", markersize=2.0, elinewidth=0.5,
        color=palette.flight(0),
    )  # fmt: skip
    change = one.change
    if change.time is not None and change.earliest is not None and change.latest is not None:
        chart.axvspan(
            change.earliest + _FIRST_YEAR, change.latest + _FIRST_YEAR, color=palette.band, zorder=0
        )
        ends = np.array([change.before or 0.0, change.now or 0.0])
        before, now = value_and_bound_arrays(one.name, ends, ends, units)[0]
        start, stop = one.times[0] + _FIRST_YEAR, one.times[-1] + _FIRST_YEAR
        at = change.time + _FIRST_YEAR
        course = (
            ([start, at, stop], [before, before, now])
            if change.kind == "drift"
            else ([start, at, at, stop], [before, before, now, now])
        )
        chart.plot(*course, color=palette.ink, linewidth=1.2)
    chart.set_title(f"{one.group}: {KIND_TEXTS[change.kind]}", loc="left")
    label = symbol_mathtext(one.name)
    chart.set_ylabel(f"{label} [{unit}]" if unit else label, parse_math=True)
    format_axes(chart, palette)
