"""The charts of the time line, how their axes are chosen, and how everything on it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pyqtgraph
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFontMetricsF, QPainter, QPainterPath, QPen

from gsapp.quantities import FloatArray, channel, is_raw_channel, trace_color
from gsapp.session.review.traces import Traces
from ui.display_style import DisplayStyle, mix_colors
from ui.number_format import clock_text, number_text, symbol_text, unit_text
from ui.review.maneuver_text import GRADE_STATES
from ui.strips.axis_ticks import multiples, round_range, step_decimals, time_step, value_ticks
from ui.strips.chart_annotations import DisplayFormat
from ui.translation import tr

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
    color: str
    times: FloatArray
    values: FloatArray
    """s, and in the unit of the chart; NaN where missing."""
    is_min_max: bool
    """Whether each column has its lowest and highest value only."""
    display: DisplayFormat

    def value_text(self, value: float) -> str:
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
    """Return the charts of the wanted channels from `start` to `stop`, s."""
    found = []
    for group in CHANNEL_GROUPS:
        names = [name for name in group if name in wanted and name in traces.channels]
        if names:
            found.append(_build_chart(traces, names, start, stop, columns, units))
    found += [
        _build_chart(traces, [name], start, stop, columns, units)
        for name in traces.channels
        if name in wanted and is_raw_channel(name)
    ]
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


_TICK_SPACING = 15.0
_OUTLINE_WIDTH = 3.0
"""Points of the rim around the letters of names; half of it lies outside."""
_HANDLE_SIZE = (8.0, 28.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TimelineSpan:
    """A maneuver on the time line."""

    id: str
    start: float
    stop: float
    """Edges, s."""
    label: str
    grade: str
    used: bool = True
    """Whether it takes part in estimates; hatched otherwise."""
    t_input: float = float("nan")
    t_input_end: float = float("nan")
    """When the surfaces moved, s; NaN where none did."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeScale:
    """Where times lie: ``left`` is the place of ``start``, ``right`` that of ``stop``."""

    start: float
    stop: float
    left: float
    right: float

    def x(self, time: float) -> float:
        share = (time - self.start) / (self.stop - self.start)
        return self.left + share * (self.right - self.left)

    def time(self, x: float) -> float:
        share = (x - self.left) / max(self.right - self.left, 1.0)
        return self.start + share * (self.stop - self.start)

    def positions(self, times: FloatArray) -> FloatArray:
        """Return the places of times, shape (n,)."""
        gain = (self.right - self.left) / (self.stop - self.start)
        return np.asarray(self.left + gain * (times - self.start))


def draw_span(
    painter: QPainter,
    style: DisplayStyle,
    span: TimelineSpan,
    scale: TimeScale,
    box: QRectF,
    *,
    chosen: bool,
) -> None:
    """Draw a span in a box: the chosen one is stronger, one not in use is hatched."""
    left, right = scale.x(span.start), scale.x(span.stop)
    if right < box.left() or left > box.right():
        return
    place = QRectF(left, box.top(), max(right - left, 2.0), box.height())
    theme = style.theme
    strong = mix_colors(theme.plot, theme.traces["blue"], 0.24)
    painter.fillRect(place, strong if chosen else style.color("span"))
    if not span.used:
        hatch = QColor(style.color("span_edge"))
        hatch.setAlphaF(0.45)
        painter.fillRect(place, QBrush(hatch, Qt.BrushStyle.BDiagPattern))
    painter.setPen(QPen(style.color("span_edge"), 1))
    for x in (left, right):
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))


def draw_edges(
    painter: QPainter, style: DisplayStyle, start: float, stop: float, scale: TimeScale, box: QRectF
) -> None:
    """Draw the edges of the chosen maneuver with the grips by which they are dragged."""
    ink = style.color("accent")
    wide, high = style.px(_HANDLE_SIZE[0]), style.px(_HANDLE_SIZE[1])
    for time in (start, stop):
        x = scale.x(time)
        if not box.left() - wide <= x <= box.right() + wide:
            continue
        painter.setPen(QPen(ink, max(style.px(2), 2)))
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        grip = QRectF(x - wide / 2, box.center().y() - high / 2, wide, high)
        painter.setPen(QPen(style.color("panel"), 1))
        painter.setBrush(ink)
        painter.drawRoundedRect(grip, wide / 2, wide / 2)
        painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_inputs(
    painter: QPainter, style: DisplayStyle, span: TimelineSpan, scale: TimeScale, box: QRectF
) -> None:
    """Draw when the surfaces of a maneuver began to move and when the last one was back."""
    pen = QPen(style.color("span_edge"), 1, Qt.PenStyle.DotLine)
    painter.setPen(pen)
    for time in (span.t_input, span.t_input_end):
        if np.isfinite(time) and span.start < time < span.stop:
            x = scale.x(time)
            painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))


def draw_segment(
    painter: QPainter,
    style: DisplayStyle,
    stretch: tuple[float, float],
    scale: TimeScale,
    box: QRectF,
) -> None:
    """Draw the stretch that was marked to become a maneuver."""
    left, right = (scale.x(time) for time in stretch)
    color = style.color("target")
    fill = QColor(color)
    fill.setAlphaF(0.18)
    painter.fillRect(QRectF(left, box.top(), right - left, box.height()), fill)
    painter.setPen(QPen(color, max(style.px(2), 2), Qt.PenStyle.DashLine))
    for x in (left, right):
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))


def draw_pointer(
    painter: QPainter,
    style: DisplayStyle,
    time: float,
    scale: TimeScale,
    plot: QRectF,
    axis: QRectF,
) -> None:
    """Draw where the mouse is, with the time below."""
    x = scale.x(time)
    painter.setPen(QPen(style.color("muted"), 1))
    painter.drawLine(QPointF(x, plot.top()), QPointF(x, plot.bottom()))
    font = style.font("label", strong=True)
    text = clock_text(time, decimals=2)
    wide = QFontMetricsF(font).horizontalAdvance(text) + style.px(8)
    left = min(max(x - wide / 2.0, axis.left()), axis.right() - wide)
    place = QRectF(left, axis.top() + 1, wide, axis.height() - 1)
    painter.fillRect(place, style.color("background"))
    painter.setFont(font)
    painter.setPen(style.color("text"))
    painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)


def draw_labels(
    painter: QPainter,
    style: DisplayStyle,
    spans: Sequence[TimelineSpan],
    scale: TimeScale,
    lane: QRectF,
    chosen: str,
) -> None:
    """Write id and grade above the charts: of the chosen span, of others where there is room."""
    strong, plain = style.font("label", strong=True), style.font("label")
    taken: list[QRectF] = []
    for span in sorted(spans, key=lambda one: (one.id != chosen, one.start)):
        if span.stop <= scale.start or span.start >= scale.stop:
            continue
        metrics = QFontMetricsF(strong if span.id == chosen else plain)
        wide = metrics.horizontalAdvance(span.label) + style.px(8)
        left = max(scale.x(span.start), lane.left())
        if span.id == chosen:
            wide = min(wide, lane.width())
            left = min(left, lane.right() - wide)
        else:
            left = max([left, *(one.right() for one in taken if one.left() <= left)])
            starts = [scale.x(one.start) for one in spans if one.start > span.start]
            own = min(scale.x(span.stop), lane.right())
            room = max(own, min([lane.right(), *starts]))
            if left + wide > min([room, *(one.left() for one in taken if one.left() > left)]):
                continue
        place = QRectF(left, lane.top(), wide, lane.height())
        text = metrics.elidedText(span.label, Qt.TextElideMode.ElideMiddle, wide)
        painter.setFont(strong if span.id == chosen else plain)
        painter.setPen(style.state_color(GRADE_STATES[span.grade]))
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)
        taken.append(place)


def draw_frame(painter: QPainter, style: DisplayStyle, box: QRectF) -> None:
    """Draw the frame of a chart."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(style.color("axis"), 1))
    painter.drawRect(box)


def draw_overview_curve(
    painter: QPainter, style: DisplayStyle, traces: Traces, name: str, scale: TimeScale, box: QRectF
) -> None:
    """Draw one channel of the whole flight in gray, as high as the box."""
    times, values = traces.line(name, scale.start, scale.stop, round(box.width()))
    finite = values[np.isfinite(values)]
    if not finite.size or not float(np.ptp(finite)) > 0.0:
        return
    low, span = float(finite.min()), float(np.ptp(finite))
    heights = box.bottom() - 3.0 - (box.height() - 6.0) * (values - low) / span
    painter.setPen(QPen(style.color("previous"), max(style.px(1.5), 1)))
    painter.drawPath(pyqtgraph.arrayToQPath(scale.positions(times), heights, connect="finite"))


def draw_chart(
    painter: QPainter,
    style: DisplayStyle,
    chart: TimelineChart,
    scale: TimeScale,
    box: QRectF,
    tick: float,
) -> None:
    """Draw grid, lines and ticks of a chart; what lies behind the lines is there already."""
    gain = box.height() / (chart.high - chart.low)

    def y_of(value: float) -> float:
        return box.bottom() - gain * (value - chart.low)

    grid = QColor(style.color("axis"))
    grid.setAlphaF(0.35)
    painter.setPen(QPen(grid, 1))
    for time in multiples(scale.start, scale.stop, tick):
        x = scale.x(time)
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
    ticks = value_ticks(
        chart.low, chart.high, box.height(), 1.0, _TICK_SPACING * style.sizes.scale, most=5
    )
    for value in ticks:
        painter.drawLine(QPointF(box.left(), y_of(value)), QPointF(box.right(), y_of(value)))
    painter.save()
    painter.setClipRect(box)
    for line in chart.lines:
        pen = QPen(QColor(style.theme.trace(line.color)))
        wide = style.theme.line_width * style.sizes.scale * 0.75
        pen.setWidthF(max(wide, 1.0) if not line.is_min_max else max(round(style.sizes.scale), 1))
        pen.setCosmetic(True)
        painter.setPen(pen)
        # Many columns of extremes look alike with hard edges, and are drawn ten times as fast.
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, not line.is_min_max)
        path = pyqtgraph.arrayToQPath(
            scale.positions(line.times), box.bottom() - gain * (line.values - chart.low),
            connect="finite",
        )  # fmt: skip
        painter.drawPath(path)
    painter.restore()
    _draw_ticks(painter, style, ticks, y_of, box)


def _draw_ticks(
    painter: QPainter,
    style: DisplayStyle,
    ticks: Sequence[float],
    y_of: Callable[[float], float],
    box: QRectF,
) -> None:
    painter.setFont(style.font("label"))
    painter.setPen(style.color("muted"))
    high = QFontMetricsF(painter.font()).height()
    step = min((abs(b - a) for a, b in pairwise(ticks)), default=1.0)
    for value in ticks:
        middle = min(max(y_of(value), box.top() + high / 2), box.bottom() - high / 2)
        place = QRectF(0.0, middle - high / 2, box.left() - style.px(6), high)
        side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(place, side, number_text(value, step_decimals(step)))


def draw_curve_names(
    painter: QPainter, style: DisplayStyle, chart: TimelineChart, box: QRectF, names: Sequence[str]
) -> None:
    """Write a name for each line in its color, and the unit, each letter with a rim of the ground.

    A whole ground would hide the lines behind it, at large sizes of text half a minute of them.
    """
    font = style.font("label", strong=True)
    painter.setFont(font)
    metrics = QFontMetricsF(font)
    gap = style.px(6)
    texts = [
        (name, QColor(style.theme.trace(line.color)))
        for name, line in zip(names, chart.lines, strict=True)
    ]
    if chart.unit:
        texts.append((f"[{chart.unit}]", style.color("muted")))
    rim = QPen(style.color("panel"), style.px(_OUTLINE_WIDTH), j=Qt.PenJoinStyle.RoundJoin)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    x, foot = box.left() + 1 + gap, box.top() + 1 + metrics.ascent() + style.px(1)
    for text, color in texts:
        letters = QPainterPath()
        letters.addText(QPointF(x, foot), font, text)
        painter.strokePath(letters, rim)
        painter.setPen(color)
        painter.drawText(QPointF(x, foot), text)
        x += metrics.horizontalAdvance(text) + gap
    painter.restore()


def draw_timeline_axis(
    painter: QPainter, style: DisplayStyle, scale: TimeScale, box: QRectF, tick: float
) -> None:
    """Write the flight times below the charts."""
    font = style.font("label")
    painter.setFont(font)
    metrics = QFontMetricsF(font)
    unit = tr("flight time")
    end = box.right() - metrics.horizontalAdvance(unit) - style.px(10)
    painter.setPen(style.color("muted"))
    right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
    painter.drawText(box, right, unit)
    for time in multiples(scale.start, scale.stop, tick):
        text = clock_text(time, decimals=max(step_decimals(tick), 1))
        half = metrics.horizontalAdvance(text) / 2
        x = scale.x(time)
        if x + half < end and x - half >= 0:
            place = QRectF(x - half - 1, box.top(), 2 * half + 2, box.height())
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)


def time_tick_step(style: DisplayStyle, scale: TimeScale) -> float:
    """Return the seconds between ticks of the axis."""
    apart = 1.8 * QFontMetricsF(style.font("label")).horizontalAdvance("00:00.0")
    most = max(int((scale.right - scale.left) / apart), 2)
    return time_step(scale.stop - scale.start, most)
