"""Which channels share a chart of the time line, and how their axes are chosen. No Qt."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray, channel, trace_color
from gsapp.session.review.traces import Traces
from ui.strips.furniture import Display
from ui.strips.ticks import round_range
from ui.words import number_text, symbol_text, unit_text

GROUPS = (
    ("de", "da", "dr"),
    ("q", "p", "r"),
    ("alpha", "beta"),
    ("V",),
    ("an", "ay"),
)
"""Channels of each chart, from top to bottom."""

CHANNELS = tuple(name for group in GROUPS for name in group)
"""All that the time line can show."""

_MARGIN = 0.06


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """One channel in sight.

    Attributes
    ----------
    channel : str
    title : str
        Symbol as it is shown.
    color : str
        Name of a trace color.
    times, values : ndarray, shape (n,)
        s, and in the unit of the chart; NaN where missing.
    dense : bool
        Whether each column has its lowest and highest value only.
    display : Display
        How its values are shown.
    """

    channel: str
    title: str
    color: str
    times: FloatArray
    values: FloatArray
    dense: bool
    display: Display

    def reading(self, value: float) -> str:
        """Return the symbol with a value (SI); a dash for a missing one."""
        shown = number_text(self.display.shown(value), self.display.decimals)
        return f"{self.title} {shown}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineChart:
    """One chart of the time line: its lines, and the range of its axis in the unit shown."""

    lines: tuple[Line, ...]
    unit: str
    low: float
    high: float


def charts(
    traces: Traces, wanted: Collection[str], start: float, stop: float, columns: int, units: str
) -> tuple[LineChart, ...]:
    """Return the charts in sight.

    Parameters
    ----------
    traces : Traces
    wanted : collection of str
        Channels to be shown, those measured of them.
    start, stop : float
        In sight, s.
    columns : int
        Of the picture.
    units : str
        ``US`` or ``SI``.
    """
    found = []
    for group in GROUPS:
        names = [name for name in group if name in wanted and name in traces.channels]
        if names:
            found.append(_chart(traces, names, start, stop, columns, units))
    return tuple(found)


def _chart(
    traces: Traces, names: list[str], start: float, stop: float, columns: int, units: str
) -> LineChart:
    lines, ends = [], []
    displays = {name: Display.of(channel(name), units) for name in names}
    for name in names:
        times, values = traces.line(name, start, stop, columns)
        shown = displays[name].shown(values)
        finite = shown[np.isfinite(shown)]
        if finite.size:
            ends += [float(finite.min()), float(finite.max())]
        lines.append(
            Line(
                channel=name,
                title=symbol_text(channel(name).symbol),
                color=trace_color(name),
                times=times,
                values=shown,
                dense=times.size > 1 and bool(times[0] == times[1]),
                display=displays[name],
            )
        )
    least = max(display.least_span for display in displays.values())
    low, high = _range(min(ends, default=math.nan), max(ends, default=math.nan), least)
    return LineChart(
        lines=tuple(lines), unit=unit_text(displays[names[0]].unit), low=low, high=high
    )


def _range(low: float, high: float, least: float) -> tuple[float, float]:
    if not math.isfinite(low):
        return -least / 2.0, least / 2.0
    room = max(_MARGIN * (high - low), (least - (high - low)) / 2.0)
    return round_range(low - room, high + room)
