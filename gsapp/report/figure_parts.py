"""What pictures of estimates have in common: plain axes, traces with their units, names of marks.

What can be pointed at carries its name, so that a window knows what lies under the mouse: axes
about one derivative are named ``derivative:Cm_alpha``, a line names the maneuver of each of its
points in order (`name_points`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.quantities import FloatArray, channel, from_si
from gsapp.report.palette import Palette

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGMAS: Final = 2.0
"""Half the length of a bar, in bounds: 95 %."""
MANEUVER, DERIVATIVE = "maneuver:", "derivative:"
"""Begin the names of points, and of axes."""
BETWEEN_NAMES: Final = "|"
_TRACE, _BROAD = 0.9, 2.0
"""Width of a trace, and of one under another, points."""
_PALE: Final = 0.55
"""Opacity of a trace under another."""
_POINTS: Final = 3000
"""Of a trace: more cannot be told apart."""


def name_points(line: Line2D, maneuvers: Sequence[str]) -> None:
    """Give each point of a line the name of its maneuver."""
    line.set_gid(BETWEEN_NAMES.join(MANEUVER + one for one in maneuvers))


def point_names(line: Line2D) -> tuple[str, ...]:
    """Return the maneuvers of a line's points; empty where it names none."""
    names = line.get_gid() or ""
    if not names.startswith(MANEUVER):
        return ()
    return tuple(one.removeprefix(MANEUVER) for one in names.split(BETWEEN_NAMES))


def plain(chart: Axes, palette: Palette) -> None:
    """Give a chart a faint grid, few numbers and no box."""
    chart.set_axisbelow(True)
    chart.grid(True, color=palette.faint, linewidth=0.4 * palette.weight)
    if chart.get_yscale() == "linear":
        chart.yaxis.set_major_locator(MaxNLocator(nbins=4, min_n_ticks=2))
    if chart.get_xscale() == "linear":
        chart.xaxis.set_major_locator(MaxNLocator(nbins=5))
    chart.tick_params(colors=palette.ink, length=2)
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
    shown = shown_values(name, np.asarray(values[::step]), units)
    chart.plot(
        times[::step], shown, color=color, linestyle=linestyle, label=label or None,
        zorder=1.5 if behind else 2.0, alpha=_PALE if under else 1.0,
        linewidth=(_BROAD if under else _TRACE) * palette.weight,
    )  # fmt: skip
    chart.set_ylabel(
        labeled(name, units, "\n"), rotation=0, ha="right", va="center", color=palette.ink,
        labelpad=6,
    )  # fmt: skip
    plain(chart, palette)


def labeled(name: str, units: str, between: str = " ") -> str:
    """Return a channel's symbol with its unit, ``alpha [deg]``; a coefficient has none."""
    if name in COEFFICIENTS:
        return name
    spec = channel(name)
    unit = spec.display_unit(units)
    return f"{spec.symbol}{between}[{unit}]" if unit else spec.symbol


def shown_values(name: str, values: FloatArray, units: str) -> FloatArray:
    """Return SI values of a channel, or of a coefficient, in the units asked for."""
    if name in COEFFICIENTS:
        return values
    spec = channel(name)
    return np.asarray(from_si(values, spec.display_unit(units), spec.quantity))


def grid_of(
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


def number_text(value: float | None) -> str:
    """Return a number in full for a table of numbers; nothing for none."""
    return "" if value is None or not np.isfinite(value) else repr(float(value))
