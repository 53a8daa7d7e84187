"""How the time line looks: what is in sight, where everything stands, and the painting of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPen, QPixmap, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from gsapp.session.review.traces import Traces
from ui.display_style import DisplayStyle
from ui.number_format import clock_text
from ui.review import timeline_painter as drawing
from ui.review.timeline_painter import (
    TIMELINE_CHANNELS,
    TimelineChart,
    TimelineSpan,
    TimeScale,
    build_timeline_charts,
)
from ui.translation import tr
from ui.widgets.paint_primitives import paint_focus_frame

_MIN_SECONDS = 0.5
"""Seconds in sight at least: some tens of samples."""
_ZOOM_MARGIN = 0.35
"""Share of a maneuver's length left free on either side when it is zoomed to."""


class VisibleTimeRange:
    """The stretch from `start` to `stop` in sight of a flight from `first` to `last`, s."""

    def __init__(self, first: float = 0.0, last: float = 1.0) -> None:
        self.first, self.last = first, max(last, first + _MIN_SECONDS)
        self.start, self.stop = self.first, self.last

    @property
    def seconds(self) -> float:
        return self.stop - self.start

    @property
    def shows_all(self) -> bool:
        return self.start <= self.first and self.stop >= self.last

    def show(self, start: float, stop: float) -> None:
        """Show a stretch, held within the flight."""
        length = min(max(stop - start, _MIN_SECONDS), self.last - self.first)
        middle = (start + stop) / 2.0
        self.start = min(max(middle - length / 2.0, self.first), self.last - length)
        self.stop = self.start + length

    def show_all(self) -> None:
        self.show(self.first, self.last)

    def zoom(self, factor: float, anchor: float | None = None) -> None:
        at = (self.start + self.stop) / 2.0 if anchor is None else anchor
        length = min(max(self.seconds * factor, _MIN_SECONDS), self.last - self.first)
        share = (at - self.start) / self.seconds
        start = at - share * length
        self.show(start, start + length)

    def pan(self, seconds: float) -> None:
        """Move on, or back if negative."""
        self.show(self.start + seconds, self.stop + seconds)

    def zoom_to(self, start: float, stop: float) -> None:
        """Show a maneuver with some room on either side."""
        room = _ZOOM_MARGIN * (stop - start)
        self.show(start - room, stop + room)

    def scroll_to(self, start: float, stop: float) -> None:
        """Move as far as needed to see a stretch; zoom out where it is longer than the sight."""
        if self.start <= start and stop <= self.stop:
            return
        if stop - start > self.seconds:
            self.zoom_to(start, stop)
            return
        middle = (start + stop - self.seconds) / 2.0
        self.show(middle, middle + self.seconds)


_OVERVIEW_CHANNELS = ("altitude", "V", "q", "de")
"""What tells how a whole flight went, the first one that was measured."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimelineRegions:
    """Where the parts of the widget stand, in its own pixels."""

    overview: QRectF
    lane: QRectF
    plot: QRectF
    axis: QRectF


class TimelineWidget(QWidget):
    """One flight with its maneuvers, to be looked at."""

    segment_marked = Signal()

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._traces: Traces | None = None
        self._channels: tuple[str, ...] = TIMELINE_CHANNELS
        self._spans: tuple[TimelineSpan, ...] = ()
        self._name = ""
        self._held: TimelineSpan | None = None
        self._curves: QPixmap | None = None
        self._overview: QPixmap | None = None
        self._tick = 10.0
        self._boxes: tuple[QRectF, ...] = ()
        self.pointer: float | None = None
        """Where all values are read, s."""
        self.shown_charts: tuple[TimelineChart, ...] = ()
        self.marked_segment: tuple[float, float] | None = None
        self.view = VisibleTimeRange()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(tr("Time line of the flight"))
        style.changed.connect(self._restyle)

    # What it is given

    def show_flight(self, traces: Traces | None) -> None:
        self._traces = traces
        self._spans, self._name = (), ""
        self.marked_segment, self._held, self.pointer = None, None, None
        self.view = VisibleTimeRange()
        if traces is not None and traces.times.size > 1:
            self.view = VisibleTimeRange(float(traces.times[0]), float(traces.times[-1]))
        self._overview = None
        self._redraw()

    def show_spans(self, spans: Sequence[TimelineSpan], chosen: str) -> None:
        self._spans, self._name = tuple(spans), chosen
        self._describe()
        self.update()

    def show_channels(self, channels: Sequence[str]) -> None:
        self._channels = tuple(channels)
        self._redraw()

    def scroll_to(self, start: float, stop: float) -> None:
        """Move so that a stretch (s) is in sight."""
        self.view.scroll_to(start, stop)
        self._redraw()

    def zoom_to(self, start: float, stop: float) -> None:
        """Show a stretch (s) with some room around it."""
        self.view.zoom_to(start, stop)
        self._redraw()

    def show_all(self) -> None:
        self.view.show_all()
        self._redraw()

    def mark_segment(self, stretch: tuple[float, float] | None) -> None:
        if stretch != self.marked_segment:
            self.marked_segment = stretch
            self.update()
            self.segment_marked.emit()

    # Geometry

    @property
    def regions(self) -> TimelineRegions:
        px = self._style.px
        left, right = px(56), self.width() - px(10)
        wide = max(right - left, 1)
        overview = QRectF(left, px(4), wide, px(34))
        lane = QRectF(left, overview.bottom() + px(4), wide, px(20))
        high = max(self.height() - lane.bottom() - px(22), 1)
        plot = QRectF(left, lane.bottom(), wide, high)
        axis = QRectF(left, plot.bottom(), wide, px(20))
        return TimelineRegions(overview=overview, lane=lane, plot=plot, axis=axis)

    @property
    def scale(self) -> TimeScale:
        plot = self.regions.plot
        return TimeScale(
            start=self.view.start, stop=self.view.stop, left=plot.left(), right=plot.right()
        )

    @property
    def overview_scale(self) -> TimeScale:
        box = self.regions.overview
        return TimeScale(
            start=self.view.first, stop=self.view.last, left=box.left(), right=box.right()
        )

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(640), self._style.px(250))

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(320), self._style.px(250))

    def _restyle(self) -> None:
        self._overview = None
        self.updateGeometry()
        self._redraw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._overview = None
        self._redraw()

    def _redraw(self) -> None:
        self._curves = None
        self._describe()
        self.update()

    # Painting

    @property
    def spans(self) -> tuple[TimelineSpan, ...]:
        """Return the maneuvers as they are drawn, a dragged edge where the mouse holds it."""
        held = self._held
        return tuple(
            replace(span, start=held.start, stop=held.stop)
            if held is not None and span.id == held.id
            else span
            for span in self._spans
        )

    @property
    def chosen_span(self) -> TimelineSpan | None:
        return next((span for span in self._spans if span.id == self._name), None)

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, places = self._style, self.regions
        painter = QPainter(self)
        painter.fillRect(self.rect(), style.color("background"))
        for box in (places.overview, places.plot):
            painter.fillRect(box, style.color("panel"))
        if self._traces is not None:
            self._paint_overview(painter, places)
            self._paint_charts(painter, places)
        if self.hasFocus():
            paint_focus_frame(painter, self.rect(), style)
        painter.end()

    def _paint_overview(self, painter: QPainter, places: TimelineRegions) -> None:
        style, box, scale = self._style, places.overview, self.overview_scale
        painter.save()
        painter.setClipRect(box)
        for span in self.spans:
            drawing.draw_span(painter, style, span, scale, box, chosen=span.id == self._name)
        if self._overview is None:
            self._overview = self._pixmap(self._draw_overview)
        painter.drawPixmap(0, 0, self._overview)
        if self.marked_segment is not None:
            drawing.draw_segment(painter, style, self.marked_segment, scale, box)
        painter.restore()
        drawing.draw_frame(painter, style, box)
        if not self.view.shows_all:
            left, right = scale.x(self.view.start), scale.x(self.view.stop)
            painter.setPen(QPen(style.color("accent"), max(style.px(2), 2)))
            painter.drawRect(QRectF(left, box.top(), max(right - left, 3.0), box.height()))
        painter.setFont(style.font("label"))
        painter.setPen(style.color("muted"))
        side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(
            QRectF(0, box.top(), box.left() - style.px(6), box.height()), side, tr("Whole\nflight")
        )

    def _draw_overview(self, painter: QPainter) -> None:
        traces, box = self._traces, self.regions.overview
        if traces is None:
            return
        known = [name for name in _OVERVIEW_CHANNELS if name in traces.channels]
        if known:
            drawing.draw_overview_curve(
                painter, self._style, traces, known[0], self.overview_scale, box
            )

    def _paint_charts(self, painter: QPainter, places: TimelineRegions) -> None:
        style, scale, plot = self._style, self.scale, places.plot
        if self._curves is None:
            self._curves = self._pixmap(self._draw_charts)
        painter.save()
        painter.setClipRect(plot)
        for span in self.spans:
            drawing.draw_span(painter, style, span, scale, plot, chosen=span.id == self._name)
        painter.restore()
        painter.drawPixmap(0, 0, self._curves)
        for chart, box in zip(self.shown_charts, self._boxes, strict=True):
            drawing.draw_curve_names(painter, style, chart, box, self._names(chart))
        painter.save()
        painter.setClipRect(plot.adjusted(-style.px(4), 0, style.px(4), 0))
        for span in self.spans:
            if span.id == self._name:
                drawing.draw_inputs(painter, style, span, scale, plot)
                drawing.draw_edges(painter, style, span.start, span.stop, scale, plot)
        if self.marked_segment is not None:
            drawing.draw_segment(painter, style, self.marked_segment, scale, plot)
        painter.restore()
        drawing.draw_labels(painter, style, self.spans, scale, places.lane, self._name)
        drawing.draw_timeline_axis(painter, style, scale, places.axis, self._tick)
        if self.pointer is not None:
            drawing.draw_pointer(painter, style, self.pointer, scale, plot, places.axis)

    def _names(self, chart: TimelineChart) -> list[str]:
        """Return the symbols of a chart's lines, with their values where the mouse is."""
        traces, time = self._traces, self.pointer
        if traces is None or time is None:
            return [line.title for line in chart.lines]
        return [line.value_text(traces.value(line.channel, time)) for line in chart.lines]

    def set_pointer(self, time: float | None) -> None:
        """Read all values at a time (s), or at none."""
        inside = time is not None and self.view.start <= time <= self.view.stop
        pointer = time if inside else None
        if pointer != self.pointer:
            self.pointer = pointer
            self._describe()
            self.update()

    def _pixmap(self, draw: Callable[[QPainter], None]) -> QPixmap:
        density = self.devicePixelRatioF()
        made = QPixmap(math.ceil(self.width() * density), math.ceil(self.height() * density))
        made.setDevicePixelRatio(density)
        made.fill(Qt.GlobalColor.transparent)
        painter = QPainter(made)
        draw(painter)
        painter.end()
        return made

    def _draw_charts(self, painter: QPainter) -> None:
        traces, style, scale, plot = self._traces, self._style, self.scale, self.regions.plot
        if traces is None:
            return
        self._tick = drawing.time_tick_step(style, scale)
        self.shown_charts = build_timeline_charts(
            traces, self._channels, scale.start, scale.stop, round(plot.width()), style.units
        )
        self._boxes = ()
        if not self.shown_charts:
            painter.setPen(style.color("muted"))
            painter.setFont(style.font("body"))
            painter.drawText(plot, Qt.AlignmentFlag.AlignCenter, tr("No channel is shown"))
            return
        gap = style.px(4)
        high = (plot.height() - gap * (len(self.shown_charts) - 1)) / len(self.shown_charts)
        for index, chart in enumerate(self.shown_charts):
            top = plot.top() + index * (high + gap)
            if index:
                painter.fillRect(
                    QRectF(plot.left(), top - gap + 1, plot.width(), gap - 1),
                    style.color("background"),
                )
            box = QRectF(plot.left(), top, plot.width(), high)
            drawing.draw_chart(painter, style, chart, scale, box, self._tick)
            drawing.draw_frame(painter, style, box)
            self._boxes = (*self._boxes, box)

    def _describe(self) -> None:
        view = self.view
        words = [
            tr("{start} to {stop} shown").format(
                start=_clock_text(view.start), stop=_clock_text(view.stop)
            )
        ]
        for span in self._spans:
            if span.id == self._name:
                words.insert(
                    0,
                    tr("maneuver {label}, {start} to {stop}").format(
                        label=span.label, start=_clock_text(span.start), stop=_clock_text(span.stop)
                    ),
                )
        if self.marked_segment is not None:
            words.append(
                tr("{start} to {stop} marked").format(
                    start=_clock_text(self.marked_segment[0]),
                    stop=_clock_text(self.marked_segment[1]),
                )
            )
        if self.pointer is not None:
            values = [name for chart in self.shown_charts for name in self._names(chart)]
            words.append(
                tr("at {pointer} {values}").format(
                    pointer=_clock_text(self.pointer), values=", ".join(values)
                )
            )
        self.setAccessibleDescription("; ".join(words))


def _clock_text(time: float) -> str:
    return clock_text(time, decimals=2)
