"""Which channels share a chart of the time line, and how their axes are chosen. No Qt."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray, channel, trace_color
from gsapp.session.review.traces import Traces
from ui.number_format import number_text, symbol_text, unit_text
from ui.strips.axis_ticks import round_range
from ui.strips.chart_annotations import DisplayFormat

CHANNEL_GROUPS = (
    ("de", "da", "dr"),
    ("q", "p", "r"),
    ("alpha", "beta"),
    ("V",),
    ("an", "ay"),
)
"""Channels of each chart, from top to bottom."""

TIMELINE_CHANNELS = tuple(name for group in CHANNEL_GROUPS for name in group)
"""All that the time line can show."""

_MARGIN = 0.06


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimelineCurve:
    """One channel in sight."""

    channel: str
    title: str
    """Symbol as it is shown."""
    color: str
    """Name of a trace color."""
    times: FloatArray
    values: FloatArray
    """s, and in the unit of the chart; NaN where missing."""
    is_min_max: bool
    """Whether each column has its lowest and highest value only."""
    display: DisplayFormat

    def value_text(self, value: float) -> str:
        """Return the symbol with a value (SI); a dash for a missing one."""
        shown = number_text(self.display.to_display(value), self.display.decimals)
        return f"{self.title} {shown}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimelineChart:
    """One chart of the time line: its lines, and the range of its axis in the unit shown."""

    lines: tuple[TimelineCurve, ...]
    unit: str
    low: float
    high: float


def build_timeline_charts(
    traces: Traces, wanted: Collection[str], start: float, stop: float, columns: int, units: str
) -> tuple[TimelineChart, ...]:
    """Return the charts in sight.

    Parameters
    ----------
    start, stop : float
        In sight, s.
    """
    found = []
    for group in CHANNEL_GROUPS:
        names = [name for name in group if name in wanted and name in traces.channels]
        if names:
            found.append(_build_chart(traces, names, start, stop, columns, units))
    return tuple(found)


def _build_chart(
    traces: Traces, names: list[str], start: float, stop: float, columns: int, units: str
) -> TimelineChart:
    lines, ends = [], []
    displays = {name: DisplayFormat.for_channel(channel(name), units) for name in names}
    for name in names:
        times, values = traces.line(name, start, stop, columns)
        shown = displays[name].to_display(values)
        finite = shown[np.isfinite(shown)]
        if finite.size:
            ends += [float(finite.min()), float(finite.max())]
        lines.append(
            TimelineCurve(
                channel=name,
                title=symbol_text(channel(name).symbol),
                color=trace_color(name),
                times=times,
                values=shown,
                is_min_max=times.size > 1 and bool(times[0] == times[1]),
                display=displays[name],
            )
        )
    least = max(display.min_span for display in displays.values())
    low, high = _axis_range(min(ends, default=math.nan), max(ends, default=math.nan), least)
    return TimelineChart(
        lines=tuple(lines), unit=unit_text(displays[names[0]].unit), low=low, high=high
    )


def _axis_range(low: float, high: float, least: float) -> tuple[float, float]:
    if not math.isfinite(low):
        return -least / 2.0, least / 2.0
    room = max(_MARGIN * (high - low), (least - (high - low)) / 2.0)
    return round_range(low - room, high + room)
