"""What the mouse does on strip charts."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QWheelEvent

from ui.strips.chart_canvas import ChartCanvas
from ui.strips.chart_editor import ChartEditor
from ui.strips.chart_model import ChartModel
from ui.strips.chart_state import scale_range
from ui.strips.view_navigator import ViewNavigator
from ui.widgets.wheel_scrolling import WheelStepCounter, scroll_steps

_VALUE_ZOOM = 1.25
"""Of the range of values, by a notch of the wheel."""


class ChartMouse:
    """Turns positions in the widget into times, values and charts, and acts on them."""

    def __init__(
        self, model: ChartModel, canvas: ChartCanvas, navigator: ViewNavigator, editor: ChartEditor
    ) -> None:
        self._model = model
        self._canvas = canvas
        self._navigator = navigator
        self._editor = editor
        self._wheel_steps = WheelStepCounter()
        self._dragged_value: float | None = None  # by which a value axis is held

    def turn_wheel(self, event: QWheelEvent) -> None:
        """Zoom about the pointer; with Shift, or sideways, scroll.

        Over a value axis, or with Ctrl, scale the values of that chart.
        """
        position, (along, up) = event.position(), scroll_steps(event)
        steps = self._wheel_steps.add(up)
        ctrl = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if steps and (ctrl or self.is_over_axis(position)):
            self._scale_values(position, steps)
        elif along:
            self._navigator.scroll(-along * 0.1 * self._model.view.seconds)
        elif steps:
            self._navigator.zoom(steps, self.time_at(position.x()))

    def press(self, position: QPointF) -> None:
        self.select_at(position)
        self._set_cursor_at(position)
        self._dragged_value = self.value_at(position.y()) if self.is_over_axis(position) else None

    def drag(self, position: QPointF) -> None:
        """Drag the cursor, or the values of a chart by their axis."""
        if self._dragged_value is None:
            self._set_cursor_at(position)
            return
        chart = self._model.selected_chart
        shift = self._dragged_value - self.value_at(position.y())
        if chart is not None and math.isfinite(shift):
            self._editor.set_range((chart.low + shift, chart.high + shift))

    def double_click(self, position: QPointF) -> None:
        """Enlarge a chart; on its value axis autoscale it."""
        self.select_at(position)
        self._set_cursor_at(position)
        if self.is_over_axis(position):
            self._editor.set_range(None)
        else:
            self._editor.toggle_enlarged()

    def select_at(self, position: QPointF) -> None:
        geometry = self._canvas.geometry
        index = None if geometry is None else geometry.chart_at(position.y() * self._canvas.density)
        if geometry is not None and index is not None:
            self._editor.select(geometry.numbers[index])

    def is_over_axis(self, position: QPointF) -> bool:
        geometry = self._canvas.geometry
        x = position.x() * self._canvas.density
        return geometry is not None and geometry.ticks.x <= x < geometry.plot.x

    def time_at(self, x: float) -> float | None:
        """Return the flight time (s) at a column of the widget."""
        geometry, view = self._canvas.geometry, self._model.view
        if geometry is None or view.now is None:
            return None
        column = math.floor(x * self._canvas.density) - geometry.plot.x
        return view.sample_time(min(max(column, 0), geometry.plot.width - 1))

    def value_at(self, y: float) -> float:
        """Return the value (displayed units) of the selected chart at a height of the widget."""
        geometry, raster = self._canvas.geometry, self._canvas.raster
        chart, selected = self._model.selected_chart, self._model.view.selected
        if geometry is None or raster is None or chart is None or selected not in geometry.numbers:
            return math.nan
        box = geometry.charts[geometry.numbers.index(selected)]
        row = y * self._canvas.density - box.y - raster.free_rows
        return chart.high - row / (box.height - 2.0 * raster.free_rows) * (chart.high - chart.low)

    def _set_cursor_at(self, position: QPointF) -> None:
        geometry, x = self._canvas.geometry, position.x() * self._canvas.density
        if geometry is not None and geometry.plot.x <= x < geometry.plot.right:
            self._navigator.set_cursor("cursor", self.time_at(position.x()))

    def _scale_values(self, position: QPointF, steps: int) -> None:
        """Show a smaller (positive) or larger range of values, about the one at a position."""
        self.select_at(position)
        chart, value = self._model.selected_chart, self.value_at(position.y())
        if chart is not None and math.isfinite(value):
            self._editor.set_range(scale_range(chart, _VALUE_ZOOM**-steps, value))
