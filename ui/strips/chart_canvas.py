"""The picture of strip charts: their geometry, their raster, and how a repaint is painted."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import cast

from PySide6.QtCore import QPoint, QRect
from PySide6.QtGui import QColor, QImage, QPainter, QRegion

from ui.number_format import DASH
from ui.strips import chart_painter
from ui.strips.chart_geometry import ChartGeometry, PixelBox, compute_geometry
from ui.strips.chart_model import ChartModel
from ui.strips.chart_painter import PaintStyle
from ui.strips.chart_raster import ChartRaster
from ui.strips.chart_state import DisplayedValue
from ui.strips.raster import split_ring
from ui.translation import tr


class RepaintRegion:
    """The region of a repaint, asked part by part.

    `painter`: set up for whole pixels of the screen. `region`: in pixels of the design. `density`:
    pixels of the screen to one of the design.
    """

    def __init__(self, painter: QPainter, region: QRegion, density: float) -> None:
        self._painter = painter
        self._density = density
        # Numbers are far quicker than a question to the region for each of many small boxes.
        self._parts = [
            (part.left(), part.top(), part.right() + 1, part.bottom() + 1)
            for part in cast(Iterable[QRect], region)  # the stub has no __iter__
        ]

    def intersects(self, box: PixelBox) -> bool:
        """Return whether some of a box is to be painted."""
        # A pixel of the design that two parts share does not make both of them new.
        left, top = math.ceil(box.x / self._density), math.ceil(box.y / self._density)
        right = max(math.floor(box.right / self._density), left + 1)
        bottom = max(math.floor(box.bottom / self._density), top + 1)
        for part in self._parts:
            if left < part[2] and part[0] < right and top < part[3] and part[1] < bottom:
                return True
        return False

    def is_within(self, box: PixelBox) -> bool:
        """Return whether nothing outside of a box is to be painted."""
        left, top = box.x / self._density, box.y / self._density
        right, bottom = box.right / self._density, box.bottom / self._density
        return all(
            left <= part[0] and part[2] <= right and top <= part[1] and part[3] <= bottom
            for part in self._parts
        )

    def clip_to(self, box: PixelBox) -> bool:
        """Confine the painter to a box; return whether some of it is to be painted.

        Within a clip of several rectangles every stroke of the painter is many times as dear.
        Cut down to a part, the clip is a single one.
        """
        if not self.intersects(box):
            return False
        self._painter.setClipRect(QRect(box.x, box.y, box.width, box.height))
        return True

    def exposed_columns(self, box: PixelBox) -> tuple[int, int]:
        """Return first and one past the last column of a box to be painted, from its left edge.

        Unlike in `intersects`, the columns it shares with its neighbors count: one of them may be
        all that changed.
        """
        top, bottom = box.y / self._density, box.bottom / self._density
        spans = [
            (math.floor(part[0] * self._density), math.ceil(part[2] * self._density))
            for part in self._parts
            if part[1] < bottom and part[3] > top
        ]
        first = min((span[0] for span in spans), default=box.right) - box.x
        last = max((span[1] for span in spans), default=box.x) - box.x
        return max(first, 0), min(last, box.width)


class ChartCanvas:
    """Keeps the picture up with a model; what changed is returned as boxes to repaint."""

    def __init__(self, model: ChartModel) -> None:
        self._model = model
        self._pen = PaintStyle(model.theme, 1.0)
        self._image = QImage()
        self._tick = 10.0  # s between labels of the time axis
        self._header_state: tuple[float | bool, float | None] | None = None
        # Where everything stands, in pixels of the screen; None before it was built.
        self.geometry: ChartGeometry | None = None
        self.raster: ChartRaster | None = None  # Pixels of the plots; None before it was built.
        self.density = 1.0  # Pixels of the screen to one of the widget.
        self.is_valid = False  # Whether geometry and raster fit the model.
        # Current values by chart, as they are shown.
        self.displayed_values: dict[int, tuple[DisplayedValue, ...]] = {}

    def invalidate(self) -> None:
        """Build everything again before the next frame or repaint."""
        self.is_valid = False
        self.displayed_values.clear()

    def invalidate_header(self) -> None:
        """Paint the line at the top again at the next frame."""
        self._header_state = None

    def build(self, width: int, height: int, density: float) -> None:
        model, view = self._model, self._model.view
        self.density, self.is_valid = density, True
        ratio = model.scale * density
        if self._pen.theme is not model.theme or self._pen.ratio != ratio:
            self._pen = PaintStyle(model.theme, ratio)
        model.create_charts()
        groups = [
            (group.name, [strip.height for strip in group.strips])
            for group in model.layout.groups
            if group.strips
        ]
        columns = chart_painter.measure_column_widths(
            self._pen, list(model.charts.values()), [name for name, _ in groups], width
        )
        self.geometry = geometry = compute_geometry(
            width,
            height,
            ratio,
            columns,
            groups,
            model.cursor_value_count,
            view.selected,
            view.enlarged and bool(model.charts),
        )
        view.resize(geometry.plot.width)
        self._tick = chart_painter.time_axis_step(self._pen, view.seconds, geometry.plot.width)
        self.raster = ChartRaster(
            model.charts, geometry, model.theme, self._tick, model.spans, model.marks
        )
        pixels = self.raster.raster.pixels
        self._image = QImage(
            pixels.data,
            pixels.shape[1],
            pixels.shape[0],
            pixels.strides[0],
            QImage.Format.Format_RGB32,
        )
        if model.history is not None and view.now is not None:
            self.raster.advance(model.history, view)
            self.raster.update_auto_ranges(view, at_once=True)

    # Frames

    def advance(self) -> list[PixelBox]:
        history, geometry, view = self._model.history, self.geometry, self._model.view
        if history is None or geometry is None or self.raster is None:
            return []
        changes = self.raster.advance(history, view)
        plot = geometry.plot
        if changes.scrolled:
            return [plot, geometry.axis, geometry.lane]
        if changes.first >= changes.last:
            return []
        x = plot.x + changes.first - view.columns[0]
        return [PixelBox(x=x, y=plot.y, width=changes.last - changes.first, height=plot.height)]

    def update_auto_ranges(self) -> list[PixelBox]:
        """Let automatic y axes follow what is in sight."""
        geometry, view = self.geometry, self._model.view
        if geometry is None or self.raster is None:
            return []
        if not self.raster.update_auto_ranges(view, at_once=view.paused):
            return []
        left = PixelBox(x=0, y=0, width=geometry.plot.x, height=geometry.axis.bottom)
        return [geometry.plot, left]

    def update_values(self) -> list[PixelBox]:
        geometry = self.geometry
        if geometry is None or self._model.history is None:
            return []
        column = geometry.values
        top, bottom, right = column.bottom, column.y, geometry.units.x
        for number_of_chart, box in zip(geometry.numbers, geometry.charts, strict=True):
            values = self._model.find_displayed_values(self._model.charts[number_of_chart])
            before = self.displayed_values.get(number_of_chart)
            if values == before:
                continue
            self.displayed_values[number_of_chart] = values
            top, bottom = min(top, box.y), max(bottom, box.bottom)
            # Units stay, but for those of stale values, which have none.
            if before is None or any(
                one.stale != other.stale for one, other in zip(before, values, strict=True)
            ):
                right = column.right
        if top >= bottom:
            return []
        # One rectangle: many small ones cost the painter more than what lies between them.
        return [PixelBox(x=column.x, y=top, width=right - column.x, height=bottom - top)]

    def update_header(self) -> list[PixelBox]:
        """Compare the line at the top with what it showed."""
        view = self._model.view
        state = (
            view.paused and round(view.seconds_behind, 1),
            None if view.now is None else round(view.now, 1),
        )
        before, self._header_state = self._header_state, state
        if self.geometry is None or state == before:
            return []
        # Live, only the clock changes.
        only_clock = before is not None and state[0] == before[0]
        return [_clock_box(self.geometry) if only_clock else self.geometry.header]

    # Painting

    def paint(self, painter: QPainter, exposed: RepaintRegion, *, focused: bool) -> None:
        """Paint what a repaint exposes, with a painter set up for pixels of the screen."""
        geometry = self.geometry
        if geometry is None:
            return
        pen = self._pen
        pen.painter, pen.geometry, pen.view = painter, geometry, self._model.view
        if not exposed.is_within(geometry.plot):
            self._paint_above(painter, geometry, exposed)
            self._paint_beside(painter, geometry, exposed, focused=focused)
        first, last = exposed.exposed_columns(geometry.plot)
        if first < last:
            painter.setClipRect(_rect(geometry.plot))
            self._paint_plot(painter, geometry, first, last)

    def _paint_above(
        self, painter: QPainter, geometry: ChartGeometry, exposed: RepaintRegion
    ) -> None:
        model, pen = self._model, self._pen
        background, lane = QColor(model.theme.background), geometry.lane
        header = replace(geometry.header, width=geometry.values.x)
        if exposed.clip_to(header):
            painter.fillRect(_rect(header), background)
            chart_painter.draw_header(pen, tr(model.layout.name), recording=model.recording)
        clock = _clock_box(geometry)
        if exposed.clip_to(clock):
            painter.fillRect(_rect(clock), background)
            chart_painter.draw_clock(pen, tr(model.newest_text))
        if exposed.clip_to(lane):
            painter.fillRect(_rect(lane), background)
            chart_painter.draw_lane(pen, model.spans, model.marks)
            chart_painter.draw_lane_alarms(pen, model.alarms)
        for left, right in ((0, lane.x), (lane.right, geometry.values.right)):
            box = PixelBox(x=left, y=lane.y, width=right - left, height=lane.height)
            if exposed.clip_to(box):
                painter.fillRect(_rect(box), background)

    def _paint_beside(
        self, painter: QPainter, geometry: ChartGeometry, exposed: RepaintRegion, *, focused: bool
    ) -> None:
        model, pen, view = self._model, self._pen, self._model.view
        background, plot, axis = QColor(model.theme.background), geometry.plot, geometry.axis
        left = PixelBox(x=0, y=plot.y, width=plot.x, height=plot.height)
        if exposed.clip_to(left):
            painter.fillRect(_rect(left), background)
            chart_painter.draw_names(pen, model.charts, view.selected, focused)
        units = exposed.intersects(geometry.units)
        end = geometry.values.right if units else geometry.units.x
        right = PixelBox(x=plot.right, y=plot.y, width=end - plot.right, height=plot.height)
        if exposed.clip_to(right):
            painter.fillRect(_rect(right), background)
            self._paint_values(geometry, right, exposed, units=units)
        if exposed.clip_to(axis):
            painter.fillRect(_rect(axis), background)
            chart_painter.draw_time_axis(pen, self._tick, geometry.hidden)

    def _paint_values(
        self, geometry: ChartGeometry, right: PixelBox, exposed: RepaintRegion, *, units: bool
    ) -> None:
        pen, model = self._pen, self._model
        with_cursors = bool(geometry.cursors) and exposed.intersects(geometry.cursors[0])
        for number_of_chart, box in zip(geometry.numbers, geometry.charts, strict=True):
            row = PixelBox(x=right.x, y=box.y, width=right.width, height=box.height)
            if not exposed.intersects(row):
                continue
            chart = model.charts[number_of_chart]
            values = self.displayed_values.get(number_of_chart) or tuple(
                DisplayedValue(text=DASH, stale=True) for _ in chart.specs
            )
            chart_painter.draw_displayed_values(pen, chart, box, values, unit=units)
            if with_cursors:
                texts = model.cursor_texts(number_of_chart)
                chart_painter.draw_cursor_values(pen, box, geometry.cursors, texts, chart)

    def _paint_plot(
        self, painter: QPainter, geometry: ChartGeometry, first: int, last: int
    ) -> None:
        """Paint the columns ``first <= x < last`` of the plot."""
        model, image, plot, view = self._model, self._image, geometry.plot, self._model.view
        if view.now is None or not geometry.charts:
            painter.fillRect(_rect(plot), QColor(model.theme.background))
            for box in geometry.charts:
                painter.fillRect(_rect(box), QColor(model.theme.plot))
            text = model.empty_text if geometry.charts else tr("No chart chosen")
            chart_painter.draw_empty_message(self._pen, text)
            return
        seam = view.columns[0] % image.width()
        for ring, part in split_ring(seam + first, seam + last, image.width()):
            painter.drawImage(
                QPoint(plot.x + first + part.start, plot.y),
                image,
                QRect(ring.start, 0, ring.stop - ring.start, image.height()),
            )
        if model.alarms:
            chart_painter.draw_alarms(self._pen, model.charts, model.alarms, first, last)
        chart_painter.draw_cursor_lines(self._pen, first, last)


def _clock_box(geometry: ChartGeometry) -> PixelBox:
    return replace(geometry.values, y=0, height=geometry.header.height)


def _rect(box: PixelBox) -> QRect:
    return QRect(box.x, box.y, box.width, box.height)
