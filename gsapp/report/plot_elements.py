"""What pictures of estimates have in common: plain axes, traces with their units, names of marks.

What can be pointed at carries its name, so that a window knows what lies under the mouse: axes
about one derivative are named ``derivative:Cm_alpha``, a line names the maneuver of each of its
points in order (`name_points`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.ticker import Formatter, Locator, MaxNLocator

from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.quantities import FloatArray, channel, clock_text, from_si, symbol_parts, unit_text
from gsapp.report.palette import Palette

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MANEUVER_PREFIX, DERIVATIVE_PREFIX = "maneuver:", "derivative:"
"""Begin the names of points, and of axes."""
NAME_SEPARATOR: Final = "|"
_TRACE, WIDE_LINE_WIDTH = 0.9, 2.0
"""Width of a trace, and of one under another, points."""
UNDERLAY_ALPHA: Final = 0.55
_POINTS: Final = 3000
"""Of a trace: more cannot be told apart."""
_TIME_STEPS: Final = (
    0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0,
    1800.0, 3600.0,
)  # fmt: skip
_FINE_TICK_SPACING: Final = 0.095
_MAX_TIME_STEPS: Final = 5
_ACCENTS: Final = {"\N{COMBINING DOT ABOVE}": "dot", "\N{COMBINING MACRON}": "bar"}


class ClockFormatter(Formatter):
    """Writes flight time as ``mm:ss.s``, with more digits where ticks are closer."""

    def __call__(self, time: float, _place: int | None = None) -> str:
        return clock_text(time, decimals=1)

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        close = len(values) > 1 and abs(values[1] - values[0]) < _FINE_TICK_SPACING
        return [clock_text(time, decimals=2 if close else 1) for time in values]


class ClockLocator(Locator):
    """Places ticks at round seconds and minutes."""

    def __call__(self) -> Sequence[float]:
        low, high = sorted(self.axis.get_view_interval())  # type: ignore[union-attr]
        return self.tick_values(low, high)

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        fitting = (step for step in _TIME_STEPS if vmax - vmin <= _MAX_TIME_STEPS * step)
        step = next(fitting, _TIME_STEPS[-1])
        first, last = math.ceil(vmin / step - 1e-6), math.floor(vmax / step + 1e-6)
        return [place * step for place in range(first, last + 1)]


def format_clock_axis(*charts: Axes) -> None:
    """Write flight time along the x axes."""
    for chart in charts:
        chart.xaxis.set_major_locator(ClockLocator())
        chart.xaxis.set_major_formatter(ClockFormatter())


def label_flight_time(chart: Axes, palette: Palette) -> None:
    """Name the time axis."""
    chart.set_xlabel("flight time [mm:ss.s]", color=palette.ink)


def name_points(line: Line2D, maneuvers: Sequence[str]) -> None:
    """Give each point of a line the name of its maneuver."""
    line.set_gid(NAME_SEPARATOR.join(MANEUVER_PREFIX + one for one in maneuvers))


def point_names(line: Line2D) -> tuple[str, ...]:
    """Return the maneuvers of a line's points; empty where it names none."""
    names = line.get_gid() or ""
    if not names.startswith(MANEUVER_PREFIX):
        return ()
    return tuple(one.removeprefix(MANEUVER_PREFIX) for one in names.split(NAME_SEPARATOR))


def format_axes(chart: Axes, palette: Palette) -> None:
    """Give a chart a grid, few numbers and no box, in a `figure_style`."""
    chart.grid(True)
    if chart.get_yscale() == "linear":
        chart.yaxis.set_major_locator(MaxNLocator(nbins=4, min_n_ticks=2))
    if chart.get_xscale() == "linear":
        chart.xaxis.set_major_locator(MaxNLocator(nbins=5))
    for side in ("top", "right"):
        chart.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        chart.spines[side].set_color(palette.faint)


def draw_trace(
    chart: Axes,
    name: str,
    times: FloatArray,
    values: FloatArray,
    units: str,
    color: str,
    palette: Palette,
    *,
    label: str = "",
    linestyle: str = "-",
    under: bool = False,
    behind: bool = False,
) -> None:
    """Draw a channel or a coefficient over time, SI values (n,) in the units asked for.

    What it is, and its unit, are said at the left.

    What is drawn later lies before what is there, unless it is to lie behind. A broad pale line
    under another is seen where both are the same.
    """
    step = max(1, -(-times.size // _POINTS))
    shown = display_values(name, np.asarray(values[::step]), units)
    chart.plot(
        times[::step], shown, color=color, linestyle=linestyle, label=label or None,
        zorder=1.5 if behind else 2.0, alpha=UNDERLAY_ALPHA if under else 1.0,
        linewidth=(WIDE_LINE_WIDTH if under else _TRACE) * palette.line_scale,
    )  # fmt: skip
    label_channel(chart, name, units, palette)
    format_axes(chart, palette)
    format_clock_axis(chart)


def label_channel(chart: Axes, name: str, units: str, palette: Palette) -> None:
    """Write symbol and unit of a channel or a coefficient left of its chart."""
    chart.set_ylabel(
        axis_label(name, units, "\n"), rotation=0, ha="right", va="center", color=palette.ink,
        labelpad=6, parse_math=True,
    )  # fmt: skip


def symbol_mathtext(symbol: str) -> str:
    """Return a symbol as matplotlib typesets it where ``parse_math`` is true."""
    base, below, rest = symbol_parts(symbol)
    for accent, command in _ACCENTS.items():
        base = re.sub(f"(.){accent}", rf"\\{command}{{\1}}", base)
        below = re.sub(f"(.){accent}", rf"\\{command}{{\1}}", below)
    if not below and base.isascii() and "\\" not in base:
        return base + rest
    return f"${base}_{{{below}}}${rest}" if below else f"${base}${rest}"


def mathtext_to_plain(label: str) -> str:
    """Return what `symbol_mathtext` typesets as plain Unicode on one line."""
    for accent, command in _ACCENTS.items():
        label = re.sub(rf"\\{command}{{(.)}}", rf"\1{accent}", label)
    return re.sub(r"[${}]|(?<=\w)_(?={)", "", label).replace("\n", " ")


def axis_label(name: str, units: str, between: str = " ") -> str:
    """Return a channel's symbol with its unit for an axis; ``parse_math`` typesets it."""
    if name in COEFFICIENTS:
        return symbol_mathtext(name)
    spec = channel(name)
    unit = spec.display_unit(units)
    symbol = symbol_mathtext(spec.symbol)
    return f"{symbol}{between}[{unit_text(unit)}]" if unit else symbol


def column_title(name: str, units: str) -> str:
    """Return a channel's id with its unit for a table or a file, ``alpha [deg]``."""
    unit = "" if name in COEFFICIENTS else channel(name).display_unit(units)
    return f"{name} [{unit}]" if unit else name


def display_values(name: str, values: FloatArray, units: str) -> FloatArray:
    """Return SI values of a channel, or of a coefficient, in the units asked for."""
    if name in COEFFICIENTS:
        return values
    spec = channel(name)
    return np.asarray(from_si(values, spec.display_unit(units), spec.quantity))


def create_axes_grid(
    container: FigureBase, count: int, across: int, *, sharex: bool = False
) -> tuple[tuple[Axes, ...], tuple[Axes, ...]]:
    """Return axes for so many charts, row by row, and those of them that are lowest in a column."""
    rows = -(-count // across)
    charts = container.subplots(rows, across, squeeze=False, sharex=sharex)
    for chart in charts.flat[count:]:
        chart.set_visible(False)
    used = tuple(charts.flat[:count])
    lowest = tuple(used[place] for place in range(max(0, count - across), count))
    return used, lowest


def exact_number_text(value: float | None) -> str:
    """Return a number in full for a table of numbers; nothing for none."""
    return "" if value is None or not np.isfinite(value) else repr(float(value))
