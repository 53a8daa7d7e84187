"""The strip charts: one widget that paints all of them."""

from __future__ import annotations

import math
import time as wall_clock
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import (
    QEvent,
    QKeyCombination,
    QPoint,
    QPointF,
    QRect,
    QSize,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import (
    QColor,
    QContextMenuEvent,
    QFocusEvent,
    QImage,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QShowEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from gsapp.quantities import channel
from ui.number_format import DASH, number_text
from ui.strips import chart_painter
from ui.strips.chart_annotations import AlarmSpan, ChannelLimits, ChartMark, ChartSpan, OriginInfo
from ui.strips.chart_geometry import ChartGeometry, PixelBox, compute_geometry
from ui.strips.chart_keys import ACTION_BY_KEY
from ui.strips.chart_painter import PaintStyle
from ui.strips.chart_raster import ChartRaster
from ui.strips.chart_state import (
    BEYOND_CALIBRATION_MARK,
    ChartState,
    DisplayedValue,
    channel_difference,
    create_chart,
    find_displayed_value,
    is_beyond_calibration,
    scale_range,
)
from ui.strips.pixel_columns import SampleSource, column_extremes
from ui.strips.raster import split_ring
from ui.strips.repaint_region import RepaintRegion
from ui.strips.strip_layout import StripLayout, default_layout
from ui.strips.strip_view import StripView
from ui.theme import DAYLIGHT, Theme, compute_sizes
from ui.widgets.wheel_scrolling import WheelStepCounter, scroll_steps

_VALUE_ZOOM = 1.25  # of the range of values, by a notch of the wheel
_FRAME_MS = 16  # ms between looks at the history
_VALUE_INTERVAL = 0.15  # s between new values: faster, nobody can read them
_STALE_SECONDS = 3.0  # s, the least age of a value that is stale


class StripChart(QWidget):
    """All strip charts in one widget.

    Parameters
    ----------
    parent : QWidget or None
        As for every widget.
    timed : bool
        Whether the widget looks at the history by itself, 60 times a second while it is
        visible. Where the window has a timer that polls the feed, False and a call of
        `advance` after the poll save up to a frame of delay.

    Attributes
    ----------
    view : StripView
        What is in sight; call `refresh` after changing it from outside.
    mark_requested : Signal(float)
        The user wants a mark at this flight time, s.
    cursor_moved : Signal(str, object)
        ``cursor``, ``a`` or ``b``, and its time in s or None.
    layout_changed : Signal(object)
        The user changed the charts: the new `StripLayout`.
    view_changed : Signal()
        Pause, place or window changed.
    menu_requested : Signal(object, object)
        The user wants a menu of the chosen chart: where on the screen (QPoint), and for which
        flight time, s or None.
    """

    mark_requested = Signal(float)
    cursor_moved = Signal(str, object)
    layout_changed = Signal(object)
    view_changed = Signal()
    menu_requested = Signal(object, object)

    def __init__(self, parent: QWidget | None = None, *, timed: bool = True) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMouseTracking(False)
        self.setAccessibleName("Strip charts")
        self._history: SampleSource | None = None
        self._layout = default_layout()
        self._theme = DAYLIGHT
        self._units = "US"
        self._zoom = 1.0
        self._spans: tuple[ChartSpan, ...] = ()
        self._marks: tuple[ChartMark, ...] = ()
        self._alarms: tuple[AlarmSpan, ...] = ()
        self._limits: Mapping[str, ChannelLimits] = {}
        self._sources: Mapping[str, OriginInfo] = {}
        self._patience: Mapping[str, float] = {}
        self._given_now: float | None = None
        self._recording = False
        self._newest = "now"
        self._shows_cursor_values = True
        self._empty = ""
        self.view = StripView(window=self._layout.window)
        self._charts: dict[int, ChartState] = {}
        self._pen = PaintStyle(self._theme, 1.0)
        self._geometry: ChartGeometry | None = None
        self._picture: ChartRaster | None = None
        self._image = QImage()
        self._readings: dict[int, tuple[DisplayedValue, ...]] = {}
        self._read_at = -math.inf
        self._header_key: tuple[float | bool, float | None] | None = None
        self._tick = 10.0
        self._stale_build = True
        self._notches = WheelStepCounter()
        self._dragged: float | None = None  # the value by which an axis is held
        self._actions = self._make_actions()
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(_FRAME_MS)
        self._timer.timeout.connect(self.advance)
        if timed:
            self._timer.start()

    # What it is given

    def set_history(self, history: SampleSource | None) -> None:
        """Show another history; the display follows its newest sample."""
        self._history = history
        self._given_now = None
        window = self.view.window
        self.view = StripView(
            width=self.view.width,
            rate=history.rate if history is not None else 100.0,
            window=window,
        )
        self._charts.clear()
        self._rebuild()
        self.advance()
        self.view_changed.emit()

    def set_layout(self, layout: StripLayout) -> None:
        """Show other charts; a window other than the former layout's is taken over, too."""
        if layout == self._layout:
            return
        if layout.window != self._layout.window:
            self.view.set_window(layout.window)
        self._layout = layout
        self.view.selected = min(self.view.selected, max(len(layout.strips) - 1, 0))
        self._make_charts()
        self._rebuild()

    @property
    def strip_layout(self) -> StripLayout:
        """Return the charts shown."""
        return self._layout

    def set_theme(self, theme: Theme) -> None:
        """Take the colors and line weight of a theme."""
        if theme is self._theme:
            return
        self._theme = theme
        self._charts.clear()
        self._rebuild()

    def set_units(self, system: str) -> None:
        """Show ``US`` or ``SI`` units."""
        if system == self._units:
            return
        self._units = system
        self._charts.clear()
        self._rebuild()

    def set_scale(self, scale: float) -> None:
        """Take another size of type and lines: 1.0 to 2.5."""
        held = compute_sizes(scale).scale
        if held != self._zoom:
            self._zoom = held
            self._rebuild()

    def set_spans(self, spans: Sequence[ChartSpan]) -> None:
        """Show these labeled stretches across all charts."""
        if tuple(spans) != self._spans:
            self._spans = tuple(spans)
            self._rebuild()

    def set_marks(self, marks: Sequence[ChartMark]) -> None:
        """Show these marks across all charts."""
        if tuple(marks) != self._marks:
            self._marks = tuple(marks)
            self._rebuild()

    def set_alarms(self, alarms: Sequence[AlarmSpan]) -> None:
        """Show these alarms above the charts, and at the top of their own chart."""
        if tuple(alarms) != self._alarms:
            self._alarms = tuple(alarms)
            self.update()

    def set_limits(self, limits: Mapping[str, ChannelLimits]) -> None:
        """Draw these limits, and name the values beyond them; by channel id."""
        if dict(limits) == self._limits:
            return
        self._limits = dict(limits)
        self._charts.clear()
        self._rebuild()

    def set_sources(self, sources: Mapping[str, OriginInfo]) -> None:
        """Say which channels are estimated or not calibrated; by channel id."""
        self._sources = dict(sources)
        self._read_at = -math.inf

    def set_stale_ages(self, patience: Mapping[str, float]) -> None:
        """Say at which age (s) values are stale that come seldom; by channel id."""
        self._patience = dict(patience)
        self._read_at = -math.inf

    def set_now(self, flight_time: float | None) -> None:
        """Tell the flight time, s, so that values grow stale when nothing comes any more.

        None goes by the newest sample alone.
        """
        self._given_now = flight_time

    def set_recording(self, recording: bool) -> None:
        """Say whether a recorder runs; a paused display then tells that it goes on."""
        if recording != self._recording:
            self._recording = recording
            self.update()

    def set_cursor_values_shown(self, shown: bool) -> None:
        """Show values at the cursors, or leave their room to the charts: they stand elsewhere."""
        if shown != self._shows_cursor_values:
            self._shows_cursor_values = shown
            self._rebuild()

    def set_newest_text(self, words: str) -> None:
        """Say what the newest flight time is: that of now, or as far as a record was read."""
        if words != self._newest:
            self._newest = words
            self.update()

    def set_empty_text(self, words: str) -> None:
        """Say why there is no sample at all; shown while there is none."""
        if words != self._empty:
            self._empty = words
            self.update()

    def refresh(self) -> None:
        """Paint everything anew, as after changing `view`."""
        self._rebuild()
        self.advance()

    # What it shows

    @property
    def charts(self) -> Mapping[int, ChartState]:
        """Return the charts by number, with range and labels in force."""
        return self._charts

    @property
    def geometry_in_pixels(self) -> ChartGeometry | None:
        """Return where everything stands, in pixels of the screen; None before it was shown."""
        return self._geometry

    @property
    def raster(self) -> ChartRaster | None:
        """Return what is painted of the charts; None before it was shown."""
        return self._picture

    def displayed_values(self, number_of_chart: int) -> tuple[DisplayedValue, ...]:
        """Return the current values of a chart as they are shown."""
        return self._readings.get(number_of_chart, ())

    # A frame

    def advance(self) -> None:
        """Take in what has arrived and have it painted: one frame."""
        history = self._history
        if history is None or not self.isVisible():
            return
        view = self.view
        self._take_time(history)
        if view.now is None:
            return
        if self._stale_build or self._picture is None:
            self._build()
        self._follow(history)
        now = wall_clock.monotonic()
        if now - self._read_at >= _VALUE_INTERVAL:
            self._read_at = now
            self._follow_ranges(at_once=view.paused)
            self._read_values(history)
        self._show_header()

    def _take_time(self, history: SampleSource) -> None:
        end = history.end
        if end is not None and self._given_now is not None:
            end = max(end, self._given_now)
        if end is None:
            return
        self.view.set_now(end)
        self.view.start = history.start

    def _follow(self, history: SampleSource) -> None:
        picture, geometry = self._picture, self._geometry
        if picture is None or geometry is None:
            return
        changes = picture.advance(history, self.view)
        plot = geometry.plot
        if changes.scrolled:
            self._expose(plot)
            self._expose(geometry.axis)
            self._expose(geometry.lane)
        elif changes.first < changes.last:
            x = plot.x + changes.first - self.view.columns[0]
            self._expose(
                PixelBox(x=x, y=plot.y, width=changes.last - changes.first, height=plot.height)
            )

    def _follow_ranges(self, *, at_once: bool) -> None:
        picture, geometry = self._picture, self._geometry
        if picture is None or geometry is None:
            return
        if picture.update_auto_ranges(self.view, at_once=at_once):
            self._expose(geometry.plot)
            self._expose(PixelBox(x=0, y=0, width=geometry.plot.x, height=geometry.axis.bottom))

    # Values

    def _read_values(self, history: SampleSource) -> None:
        geometry = self._geometry
        if geometry is None:
            return
        place = geometry.values
        top, bottom, right = place.bottom, place.y, geometry.units.x
        for number_of_chart, box in zip(geometry.numbers, geometry.charts, strict=True):
            chart = self._charts[number_of_chart]
            readings = tuple(
                find_displayed_value(
                    history,
                    spec,
                    display,
                    self.view.now,
                    max(self._patience.get(spec.id, 0.0), _STALE_SECONDS),
                    self._limits.get(spec.id),
                    self._sources.get(spec.id),
                )
                for spec, display in zip(chart.specs, chart.displays, strict=True)
            )
            before = self._readings.get(number_of_chart)
            if readings == before:
                continue
            self._readings[number_of_chart] = readings
            top, bottom = min(top, box.y), max(bottom, box.bottom)
            # Units stand still, but for those of stale values, which have none.
            if before is None or any(
                one.stale != other.stale for one, other in zip(before, readings, strict=True)
            ):
                right = place.right
        if top < bottom:
            # One rectangle: many small ones cost the painter more than what lies between them.
            self._expose(PixelBox(x=place.x, y=top, width=right - place.x, height=bottom - top))

    def value_at(self, channel_id: str, time: float) -> float:
        """Return the sample (SI) of a channel nearest to a time (s); NaN where there is none."""
        history = self._history
        if history is None or channel_id not in history.channels:
            return math.nan
        index = round(time * history.rate)
        return float(history.samples(channel_id, index, index + 1)[0])

    def cursor_texts(self, number_of_chart: int) -> dict[str, list[str]]:
        """Return the values of a chart at the cursors as they are shown, by cursor.

        ``delta`` is B less A; a chart of several lines has a text for each. What lies beyond the
        range that was calibrated begins with `BEYOND_CALIBRATION_MARK`.
        """
        chart = self._charts[number_of_chart]
        texts: dict[str, list[str]] = {}
        values: dict[str, list[float]] = {}
        marks: dict[str, list[str]] = {}
        shown: dict[str, list[float]] = {}
        for name, time in self._cursors_read().items():
            values[name] = [self.value_at(spec.id, time) for spec in chart.specs]
            marks[name] = [
                BEYOND_CALIBRATION_MARK if self._beyond_at(spec.id, time) else ""
                for spec in chart.specs
            ]
            shown[name] = [
                display.to_display(value)
                for value, display in zip(values[name], chart.displays, strict=True)
            ]
        if "a" in values and "b" in values:
            shown["delta"] = [
                display.factor * channel_difference(spec, one, other)
                for spec, display, one, other in zip(
                    chart.specs, chart.displays, values["a"], values["b"], strict=True
                )
            ]
            marks["delta"] = [
                one or other for one, other in zip(marks["a"], marks["b"], strict=True)
            ]
        for name, row in shown.items():
            texts[name] = [
                DASH if math.isnan(value) else mark + number_text(value, display.decimals)
                for value, mark, display in zip(row, marks[name], chart.displays, strict=True)
            ]
        return texts

    def _beyond_at(self, channel_id: str, time: float) -> bool:
        """Return whether a sample stands on an instrument beyond what it was calibrated for."""
        source = self._sources.get(channel_id)
        return is_beyond_calibration(source, lambda name: self.value_at(name, time))

    # Building

    def _rebuild(self) -> None:
        """Have everything made anew at the next frame or paint."""
        self._stale_build = True
        self._readings.clear()
        self._read_at = -math.inf
        self.update()

    def _density(self) -> float:
        return self.devicePixelRatioF()

    def _build(self) -> None:
        self._stale_build = False
        density = self._density()
        ratio = self._zoom * density
        width, height = round(self.width() * density), round(self.height() * density)
        if self._pen.theme is not self._theme or self._pen.ratio != ratio:
            self._pen = PaintStyle(self._theme, ratio)
        pen = self._pen
        self._make_charts()
        strips = self._layout.strips
        groups = [
            (group.name, [strip.height for strip in group.strips])
            for group in self._layout.groups
            if group.strips
        ]
        alone = self.view.enlarged and bool(strips)
        columns = chart_painter.measure_column_widths(
            pen, list(self._charts.values()), [name for name, _ in groups], width
        )
        self._geometry = geometry = compute_geometry(
            width,
            height,
            ratio,
            columns,
            groups,
            self._count_cursor_values(),
            self.view.selected,
            alone,
        )
        self.view.resize(geometry.plot.width)
        self._tick = chart_painter.time_axis_step(pen, self.view.seconds, geometry.plot.width)
        self._picture = picture = ChartRaster(
            self._charts, geometry, self._theme, self._tick, self._spans, self._marks
        )
        pixels = picture.raster.pixels
        self._image = QImage(
            pixels.data,
            pixels.shape[1],
            pixels.shape[0],
            pixels.strides[0],
            QImage.Format.Format_RGB32,
        )
        history = self._history
        if history is not None and self.view.now is not None:
            picture.advance(history, self.view)
            picture.update_auto_ranges(self.view, at_once=True)
        self._describe()
        self.update()

    def _cursors_read(self) -> Mapping[str, float]:
        """Return the cursors whose values are shown: the cursor is not said again at A or B."""
        cursors = dict(self.view.cursors)
        if cursors.get("cursor") in (cursors.get("a"), cursors.get("b")):
            cursors.pop("cursor", None)
        return cursors

    def _count_cursor_values(self) -> int:
        """Return how many values at cursors the fullest chart has."""
        names = len(self._cursors_read()) + ({"a", "b"} <= {*self.view.cursors})
        lines = max((len(chart.specs) for chart in self._charts.values()), default=1)
        return names * lines if self._shows_cursor_values else 0

    def _make_charts(self) -> None:
        """Make the charts of the layout; those that were there keep their range."""
        known = self._charts
        self._charts = {
            index: known[index]
            if index in known and known[index].strip == strip
            else create_chart(strip, self._theme, self._units, self._limits.get(strip.channel))
            for index, strip in enumerate(self._layout.strips)
        }

    # Painting

    def _expose(self, box: PixelBox | None) -> None:
        if box is None:
            return
        self.update(_to_logical_rect(box, self._density()))

    def _show_header(self) -> None:
        view, geometry = self.view, self._geometry
        shown = (
            view.paused and round(view.seconds_behind, 1),
            None if view.now is None else round(view.now, 1),
        )
        before, self._header_key = self._header_key, shown
        if geometry is None or shown == before:
            return
        # Live, only the clock goes on.
        only_clock = before is not None and shown[0] == before[0]
        self._expose(_newest_time_box(geometry) if only_clock else geometry.header)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the parts that changed."""
        if self._stale_build or self._geometry is None:
            if self._history is not None:
                self._take_time(self._history)
            self._build()
            if self._history is not None and self.view.now is not None:
                self._read_values(self._history)
        geometry = self._geometry
        if geometry is None:
            return
        painter = QPainter(self)
        density = self._density()
        painter.setRenderHint(QPainter.RenderHint.TextAntialiasing, True)
        # From here on in whole pixels of the screen; what the window is shifted by in fractions
        # of a pixel, on screens of uneven density, is taken back.
        painter.scale(1.0 / density, 1.0 / density)
        placed = painter.deviceTransform()
        painter.translate(round(placed.dx()) - placed.dx(), round(placed.dy()) - placed.dy())
        exposed = RepaintRegion(painter, event.region(), density)
        if not exposed.is_within(geometry.plot):
            self._paint_above(painter, geometry, exposed)
            self._paint_beside(painter, geometry, exposed)
        first, last = exposed.exposed_columns(geometry.plot)
        if first < last:
            painter.setClipRect(_rect(geometry.plot))
            self._paint_plot(painter, geometry, first, last)
        painter.end()

    def _paint_above(
        self, painter: QPainter, geometry: ChartGeometry, exposed: RepaintRegion
    ) -> None:
        """Paint what stands above the charts."""
        pen, view, background = self._pen, self.view, QColor(self._theme.background)
        lane = geometry.lane
        header = replace(geometry.header, width=geometry.values.x)
        if exposed.clip_to(header):
            painter.fillRect(_rect(header), background)
            chart_painter.draw_header(
                painter, pen, geometry, view, self._layout.name, recording=self._recording
            )
        clock = _newest_time_box(geometry)
        if exposed.clip_to(clock):
            painter.fillRect(_rect(clock), background)
            chart_painter.draw_clock(painter, pen, geometry, view, self._newest)
        if exposed.clip_to(lane):
            painter.fillRect(_rect(lane), background)
            chart_painter.draw_lane(painter, pen, geometry, view, self._spans, self._marks)
            chart_painter.draw_lane_alarms(painter, pen, geometry, view, self._alarms)
        for left, right in ((0, lane.x), (lane.right, geometry.values.right)):
            box = PixelBox(x=left, y=lane.y, width=right - left, height=lane.height)
            if exposed.clip_to(box):
                painter.fillRect(_rect(box), background)

    def _paint_beside(
        self, painter: QPainter, geometry: ChartGeometry, exposed: RepaintRegion
    ) -> None:
        """Paint what stands to the left and right of the charts, and below."""
        pen, view, background = self._pen, self.view, QColor(self._theme.background)
        plot, axis = geometry.plot, geometry.axis
        left = PixelBox(x=0, y=plot.y, width=plot.x, height=plot.height)
        if exposed.clip_to(left):
            painter.fillRect(_rect(left), background)
            chart_painter.draw_names(
                painter, pen, geometry, self._charts, view.selected, self.hasFocus()
            )
        units = exposed.intersects(geometry.units)
        end = geometry.values.right if units else geometry.units.x
        right = PixelBox(x=plot.right, y=plot.y, width=end - plot.right, height=plot.height)
        if exposed.clip_to(right):
            painter.fillRect(_rect(right), background)
            self._paint_values(painter, geometry, right, exposed, units=units)
        if exposed.clip_to(axis):
            painter.fillRect(_rect(axis), background)
            chart_painter.draw_time_axis(painter, pen, geometry, view, self._tick, geometry.hidden)

    def _paint_values(
        self,
        painter: QPainter,
        geometry: ChartGeometry,
        right: PixelBox,
        exposed: RepaintRegion,
        *,
        units: bool,
    ) -> None:
        beside = bool(geometry.cursors) and exposed.intersects(geometry.cursors[0])
        for number_of_chart, box in zip(geometry.numbers, geometry.charts, strict=True):
            row = PixelBox(x=right.x, y=box.y, width=right.width, height=box.height)
            if not exposed.intersects(row):
                continue
            chart = self._charts[number_of_chart]
            readings = self._readings.get(number_of_chart) or tuple(
                DisplayedValue(text=DASH, stale=True) for _ in chart.specs
            )
            chart_painter.draw_displayed_values(
                painter, self._pen, geometry, chart, box, readings, unit=units
            )
            if beside:
                chart_painter.draw_cursor_values(
                    painter,
                    self._pen,
                    box,
                    geometry.cursors,
                    self.cursor_texts(number_of_chart),
                    chart,
                )

    def _paint_plot(
        self, painter: QPainter, geometry: ChartGeometry, first: int, last: int
    ) -> None:
        """Paint the columns ``first <= x < last`` of the plot."""
        image, plot = self._image, geometry.plot
        if self.view.now is None or not geometry.charts:
            painter.fillRect(_rect(plot), QColor(self._theme.background))
            for box in geometry.charts:
                painter.fillRect(_rect(box), QColor(self._theme.plot))
            words = self._empty if geometry.charts else "No chart chosen"
            chart_painter.draw_empty_message(painter, self._pen, geometry, words)
            return
        seam = self.view.columns[0] % image.width()
        for ring, part in split_ring(seam + first, seam + last, image.width()):
            painter.drawImage(
                QPoint(plot.x + first + part.start, plot.y),
                image,
                QRect(ring.start, 0, ring.stop - ring.start, image.height()),
            )
        if self._alarms:
            chart_painter.draw_alarms(
                painter, self._pen, geometry, self.view, self._charts, self._alarms, first, last
            )
        chart_painter.draw_cursor_lines(painter, self._pen, geometry, self.view, first, last)

    # Events

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange everything anew."""
        self._rebuild()
        super().resizeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Catch up with what came while hidden."""
        self._rebuild()
        super().showEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Take another font."""
        if event.type() == QEvent.Type.FontChange:
            self._rebuild()
        super().changeEvent(event)

    def event(self, event: QEvent) -> bool:
        """Take note of a move to a screen of another density."""
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._rebuild()
        return bool(super().event(event))

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show which chart is chosen."""
        self.update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Show that keys go elsewhere."""
        self.update()
        super().focusOutEvent(event)

    def sizeHint(self) -> QSize:
        """Return a size at which 16 charts are at ease."""
        return QSize(1000, 700)

    def minimumSizeHint(self) -> QSize:
        """Return the size below which nothing can be read."""
        return QSize(round(420 * self._zoom), round(160 * self._zoom))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Obey `KEY_ACTIONS`."""
        action = ACTION_BY_KEY.get(_key_text(event))
        if action is None:
            super().keyPressEvent(event)
            return
        if action.repeats or not event.isAutoRepeat():
            self.perform(action.id)
        event.accept()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom about the pointer; with Shift, or sideways, scroll.

        Over a value axis, or with Ctrl, the values of that chart are scaled.
        """
        along, up = scroll_steps(event)
        steps = self._notches.add(up)
        ctrl = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if steps and (ctrl or self._is_over_axis(event.position())):
            self._scale_values(event.position(), steps)
            event.accept()
            return
        if along:
            self.scroll(-along * 0.1 * self.view.seconds)
        elif steps:
            self.zoom(steps, self._time_at(event.position().x()))
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose a chart and set the cursor."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._pick(event)
            over = self._is_over_axis(event.position())
            self._dragged = self._value_at(event.position().y()) if over else None
        else:
            super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Drag the cursor, or the values of a chart by their axis."""
        if not event.buttons() & Qt.MouseButton.LeftButton:
            return
        if self._dragged is None:
            self._pick(event, choose=False)
            return
        chart = self.selected_chart
        shift = self._dragged - self._value_at(event.position().y())
        if chart is not None and math.isfinite(shift):
            self.set_range((chart.low + shift, chart.high + shift))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Enlarge a chart; on its value axis autoscale it."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._pick(event)
            if self._is_over_axis(event.position()):
                self.set_range(None)
            else:
                self.perform("enlarge")

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Ask for a menu of the chart under the pointer, or by key of the one chosen."""
        where = QPointF(event.pos())
        at = self.view.cursors.get("cursor", self.view.now)
        if event.reason() == QContextMenuEvent.Reason.Mouse:
            self._select_at(where)
            at = self._time_at(where.x())
        self.menu_requested.emit(event.globalPos(), at)
        event.accept()

    # The value axes

    def _is_over_axis(self, where: QPointF) -> bool:
        geometry = self._geometry
        x = where.x() * self._density()
        return geometry is not None and geometry.ticks.x <= x < geometry.plot.x

    def _value_at(self, y: float) -> float:
        """Return the value (displayed units) of the chosen chart at a height of the widget."""
        geometry, picture, chart = self._geometry, self._picture, self.selected_chart
        if (
            geometry is None
            or picture is None
            or chart is None
            or self.view.selected not in geometry.numbers
        ):
            return math.nan
        box = geometry.charts[geometry.numbers.index(self.view.selected)]
        row = y * self._density() - box.y - picture.free_rows
        return chart.high - row / (box.height - 2.0 * picture.free_rows) * (chart.high - chart.low)

    def _scale_values(self, where: QPointF, steps: int) -> None:
        """Show a smaller (positive) or larger range of values, about the one at a point."""
        self._select_at(where)
        chart, value = self.selected_chart, self._value_at(where.y())
        if chart is not None and math.isfinite(value):
            self.set_range(scale_range(chart, _VALUE_ZOOM**-steps, value))

    def _pick(self, event: QMouseEvent, *, choose: bool = True) -> None:
        geometry = self._geometry
        if geometry is None:
            return
        density = self._density()
        x = event.position().x() * density
        if choose:
            self._select_at(event.position())
        if geometry.plot.x <= x < geometry.plot.right:
            self.set_cursor("cursor", self._time_at(event.position().x()))

    def _select_at(self, where: QPointF) -> None:
        geometry = self._geometry
        place = None if geometry is None else geometry.chart_at(where.y() * self._density())
        if geometry is not None and place is not None:
            self._select(geometry.numbers[place])

    def _time_at(self, x: float) -> float | None:
        geometry = self._geometry
        if geometry is None or self.view.now is None:
            return None
        column = math.floor(x * self._density()) - geometry.plot.x
        return self.view.sample_time(min(max(column, 0), geometry.plot.width - 1))

    # Actions

    def _make_actions(self) -> dict[str, object]:
        view_actions = {
            "pause": self.toggle_pause,
            "live": self.go_live,
            "earlier": lambda: self.scroll(-0.1 * self.view.seconds),
            "later": lambda: self.scroll(0.1 * self.view.seconds),
            "window_earlier": lambda: self.scroll(-self.view.seconds),
            "window_later": lambda: self.scroll(self.view.seconds),
            "start": self.go_to_start,
            "zoom_in": lambda: self.zoom(1),
            "zoom_out": lambda: self.zoom(-1),
        }
        chart_actions = {
            "chart_up": lambda: self._select(self.view.selected - 1),
            "chart_down": lambda: self._select(self.view.selected + 1),
            "enlarge": self.toggle_enlarged,
            "range": self._next_range,
            "move_up": lambda: self._move(-1),
            "move_down": lambda: self._move(1),
        }
        cursor_actions = {
            "cursor": self.toggle_cursor,
            "cursor_earlier": lambda: self.step_cursor(-1),
            "cursor_later": lambda: self.step_cursor(1),
            "cursor_far_earlier": lambda: self.step_cursor(-20),
            "cursor_far_later": lambda: self.step_cursor(20),
            "set_a": lambda: self._set_here("a"),
            "set_b": lambda: self._set_here("b"),
            "clear": self.clear,
            "mark": self.request_mark,
        }
        return {**view_actions, **chart_actions, **cursor_actions}

    def perform(self, action: str) -> None:
        """Do one of `KEY_ACTIONS` by its id."""
        known = self._actions[action]
        if callable(known):
            known()

    def toggle_pause(self) -> None:
        """Stand still, or follow the newest sample again."""
        self.view.toggle_pause()
        self._viewed()

    def go_live(self) -> None:
        """Follow the newest sample again."""
        self.view.go_live()
        self._viewed()

    def go_to_start(self) -> None:
        """Show the beginning of the flight."""
        self.view.go_to_start()
        self._viewed()

    def go_to(self, time: float) -> None:
        """Bring a flight time (s) to the middle."""
        self.view.go_to(time)
        self._viewed()

    def scroll(self, seconds: float) -> None:
        """Move by some seconds, back if negative."""
        self.view.scroll(seconds)
        self._viewed()

    def zoom(self, steps: int, anchor: float | None = None) -> None:
        """Show less (positive) or more time, about the cursor or another time (s)."""
        if anchor is None:
            anchor = self.view.cursors.get("cursor")
            if anchor is not None and not 0 <= self.view.x(anchor) < self.view.width:
                anchor = None
        self.view.zoom(steps, anchor)
        self._rebuild()
        self._viewed()

    def set_window(self, seconds: float) -> None:
        """Show at least so many seconds."""
        self.view.set_window(seconds)
        self._rebuild()
        self._viewed()

    def _viewed(self) -> None:
        self._read_at = -math.inf
        self._header_key = None
        self.update()
        self.advance()
        self.view_changed.emit()

    def toggle_cursor(self) -> None:
        """Set the cursor to the middle of the samples in sight, or take it away."""
        if "cursor" in self.view.cursors:
            self.set_cursor("cursor", None)
        elif self.view.now is not None:
            self.set_cursor("cursor", self._sampled_time(0.5))

    def step_cursor(self, columns: int) -> None:
        """Move the cursor by columns, at least by one sample; it comes into sight if need be."""
        if self.view.now is None:
            return
        at = self.view.cursors.get("cursor")
        if at is None or not 0 <= self.view.x(at) < self.view.width:
            self.set_cursor("cursor", self._sampled_time(0.5))
            return
        scale = self.view.scale
        self.set_cursor("cursor", at + columns * max(scale.seconds, 1.0 / scale.rate))

    def set_cursor(self, name: str, time: float | None) -> None:
        """Set ``cursor``, ``a`` or ``b`` to a flight time (s), or take it away with None."""
        if self.view.cursors.get(name) == time:
            return
        before = self._count_cursor_values()
        self.view.set_cursor(name, time)
        if self._count_cursor_values() != before:
            self._rebuild()
        self.update()
        self.cursor_moved.emit(name, self.view.cursors.get(name))

    def _set_here(self, name: str) -> None:
        if self.view.now is None:
            return
        here = self.view.cursors.get("cursor")
        if here is None:
            here = min(self._sampled_time(1.0), self.view.now)
        self.set_cursor(name, here)

    def _sampled_time(self, share: float) -> float:
        """Return the time (s) of a column in sight that holds samples, 0 the first and 1 the last.

        Where none does, any column counts.
        """
        view, history = self.view, self._history
        first, last = view.columns
        held = np.zeros(view.width, dtype=bool)
        known = () if history is None else history.channels
        for name in {*self._layout.channels} & {*known}:
            low, _ = column_extremes(history, name, view.scale, first, last)
            held |= np.isfinite(low)
        places = np.flatnonzero(held) if held.any() else np.arange(view.width)
        return view.sample_time(int(places[round(share * (places.size - 1))]))

    def clear(self) -> None:
        """Take the cursors away and show all charts."""
        for name in tuple(self.view.cursors):
            self.set_cursor(name, None)
        if self.view.enlarged:
            self.toggle_enlarged()

    def request_mark(self) -> None:
        """Ask for a mark at the cursor while paused, else at the newest sample."""
        here = self.view.cursors.get("cursor") if self.view.paused else None
        if here is None:
            here = self.view.now
        if here is not None:
            self.mark_requested.emit(here)

    def toggle_enlarged(self) -> None:
        """Let the chosen chart fill the display, or show all again."""
        self.view.enlarged = not self.view.enlarged
        self._rebuild()

    def _select(self, number_of_chart: int) -> None:
        strips = self._layout.strips
        if not strips:
            return
        chosen = min(max(number_of_chart, 0), len(strips) - 1)
        if chosen == self.view.selected:
            return
        self.view.selected = chosen
        shown = self._geometry.numbers if self._geometry is not None else ()
        if self.view.enlarged or chosen not in shown:
            self._rebuild()
        self._describe()
        self.update()

    @property
    def selected_chart(self) -> ChartState | None:
        """Return the chosen chart; None if there is none."""
        return self._charts.get(self.view.selected)

    def set_range(self, ends: tuple[float, float] | None) -> None:
        """Hold the y range of the chosen chart (displayed units), or let it follow with None."""
        chart = self.selected_chart
        if chart is None:
            return
        values: dict[str, object] = {"range": "auto", "low": None, "high": None}
        if ends is not None:
            low, high = sorted(chart.displays[0].to_si(end) for end in ends)
            values = {"range": "fixed", "low": low, "high": high}
        self._change(
            self._layout.with_strip(self.view.selected, chart.strip.model_copy(update=values))
        )

    def hide_chart(self) -> None:
        """Take the chosen chart away."""
        if self._layout.strips:
            self._change(self._layout.with_strip(self.view.selected, None))

    def _next_range(self) -> None:
        strips = self._layout.strips
        if not strips:
            return
        strip = strips[self.view.selected]
        order = ["auto", "limits"] if strip.low is None else ["auto", "fixed", "limits"]
        following = order[(order.index(strip.range) + 1) % len(order)]
        self._change(
            self._layout.with_strip(
                self.view.selected, strip.model_copy(update={"range": following})
            )
        )

    def _move(self, by: int) -> None:
        strips = self._layout.strips
        if not strips:
            return
        strip = strips[self.view.selected]
        changed = self._layout.with_strip_moved(self.view.selected, by)
        if changed != self._layout:
            places = [index for index, other in enumerate(changed.strips) if other is strip]
            self.view.selected = places[0] if places else self.view.selected
            self._change(changed)

    def _change(self, layout: StripLayout) -> None:
        self.set_layout(layout)
        self.layout_changed.emit(layout)

    def _describe(self) -> None:
        """Say which chart is chosen, for those who hear the window."""
        strips = self._layout.strips
        if not strips:
            self.setAccessibleDescription("No chart chosen")
            return
        chart = self._charts.get(self.view.selected)
        title = channel(strips[self.view.selected].channel).title
        unit = chart.displays[0].unit if chart is not None else ""
        self.setAccessibleDescription(
            f"Chart {self.view.selected + 1} of {len(strips)}: {title} {unit}".rstrip()
        )


def _to_logical_rect(box: PixelBox, density: float) -> QRect:
    """Return the smallest rectangle in pixels of the design that covers a box."""
    left, top = math.floor(box.x / density), math.floor(box.y / density)
    right, bottom = math.ceil(box.right / density), math.ceil(box.bottom / density)
    return QRect(left, top, right - left, bottom - top)


def _newest_time_box(geometry: ChartGeometry) -> PixelBox:
    """Return where the newest time stands."""
    return replace(geometry.values, y=0, height=geometry.header.height)


def _rect(box: PixelBox) -> QRect:
    return QRect(box.x, box.y, box.width, box.height)


def _key_text(event: QKeyEvent) -> str:
    modifiers = event.modifiers()
    modifiers &= ~Qt.KeyboardModifier.KeypadModifier
    key = Qt.Key(event.key())
    if key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal, Qt.Key.Key_Minus):
        # Whether Shift is needed depends on the keyboard.
        modifiers &= ~Qt.KeyboardModifier.ShiftModifier
    text = QKeySequence(QKeyCombination(modifiers, key)).toString(
        QKeySequence.SequenceFormat.PortableText
    )
    return str(text)
