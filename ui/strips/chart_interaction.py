"""What keys, menus and the mouse do on strip charts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QWheelEvent

from ui.strips.chart_canvas import ChartCanvas
from ui.strips.chart_model import ChartModel
from ui.strips.chart_state import scale_range
from ui.strips.strip_layout import Trace
from ui.widgets.wheel_scrolling import WheelStepCounter, scroll_steps


class ViewNavigator(QObject):
    """Changes which part of the flight is in sight, and the cursors."""

    rebuild_requested = Signal()  # Columns mean other times, or need other room.
    view_changed = Signal()  # Pause, time or window changed.
    cursor_moved = Signal(str, object)  # ``cursor``, ``a`` or ``b``, and its time in s or None.
    mark_requested = Signal(float)  # The user wants a mark at this flight time, s.

    def __init__(self, model: ChartModel, parent: QObject) -> None:
        super().__init__(parent)
        self._model = model

    @property
    def actions(self) -> Mapping[str, Callable[[], object]]:
        return {
            "pause": self.toggle_pause,
            "live": self.go_live,
            "earlier": partial(self._scroll_windows, -0.1),
            "later": partial(self._scroll_windows, 0.1),
            "window_earlier": partial(self._scroll_windows, -1.0),
            "window_later": partial(self._scroll_windows, 1.0),
            "start": self.go_to_start,
            "zoom_in": partial(self.zoom, 1),
            "zoom_out": partial(self.zoom, -1),
            "cursor": self.toggle_cursor,
            "cursor_earlier": partial(self.step_cursor, -1),
            "cursor_later": partial(self.step_cursor, 1),
            "cursor_far_earlier": partial(self.step_cursor, -20),
            "cursor_far_later": partial(self.step_cursor, 20),
            "set_a": partial(self._set_at_cursor, "a"),
            "set_b": partial(self._set_at_cursor, "b"),
            "mark": self.request_mark,
        }

    # View

    def toggle_pause(self) -> None:
        self._model.view.toggle_pause()
        self.view_changed.emit()

    def go_live(self) -> None:
        self._model.view.go_live()
        self.view_changed.emit()

    def go_to_start(self) -> None:
        self._model.view.go_to_start()
        self.view_changed.emit()

    def go_to(self, time: float) -> None:
        """Bring a flight time (s) to the middle."""
        self._model.view.go_to(time)
        self.view_changed.emit()

    def scroll(self, seconds: float) -> None:
        """Move by some seconds, back if negative."""
        self._model.view.scroll(seconds)
        self.view_changed.emit()

    def _scroll_windows(self, windows: float) -> None:
        self.scroll(windows * self._model.view.seconds)

    def zoom(self, steps: int, anchor: float | None = None) -> None:
        """Show less (positive) or more time, about the cursor or another time (s)."""
        view = self._model.view
        if anchor is None:
            anchor = view.cursors.get("cursor")
            if anchor is not None and not 0 <= view.x(anchor) < view.width:
                anchor = None
        view.zoom(steps, anchor)
        self.rebuild_requested.emit()
        self.view_changed.emit()

    def set_window(self, seconds: float) -> None:
        """Show at least so many seconds."""
        self._model.view.set_window(seconds)
        self.rebuild_requested.emit()
        self.view_changed.emit()

    # Cursors

    def set_cursor(self, name: str, time: float | None) -> None:
        """Set ``cursor``, ``a`` or ``b`` to a flight time (s), or remove it with None."""
        view = self._model.view
        if view.cursors.get(name) == time:
            return
        before = self._model.cursor_value_count
        view.set_cursor(name, time)
        if self._model.cursor_value_count != before:
            self.rebuild_requested.emit()
        self.cursor_moved.emit(name, view.cursors.get(name))

    def toggle_cursor(self) -> None:
        """Set the cursor to the middle of the samples in sight, or remove it."""
        if "cursor" in self._model.view.cursors:
            self.set_cursor("cursor", None)
        elif self._model.view.now is not None:
            self.set_cursor("cursor", self._model.sampled_time(0.5))

    def step_cursor(self, columns: int) -> None:
        """Move the cursor by columns, at least by one sample; it comes into sight if need be."""
        view = self._model.view
        if view.now is None:
            return
        at = view.cursors.get("cursor")
        if at is None or not 0 <= view.x(at) < view.width:
            self.set_cursor("cursor", self._model.sampled_time(0.5))
            return
        self.set_cursor("cursor", at + columns * max(view.scale.seconds, 1.0 / view.scale.rate))

    def _set_at_cursor(self, name: str) -> None:
        view = self._model.view
        if view.now is not None:
            at = view.cursors.get("cursor")
            at = min(self._model.sampled_time(1.0), view.now) if at is None else at
            self.set_cursor(name, at)

    def clear_cursors(self) -> None:
        for name in tuple(self._model.view.cursors):
            self.set_cursor(name, None)

    def request_mark(self) -> None:
        """Ask for a mark at the cursor while paused, else at the newest sample."""
        view = self._model.view
        at = view.cursors.get("cursor") if view.paused else None
        at = view.now if at is None else at
        if at is not None:
            self.mark_requested.emit(at)


class ChartEditor(QObject):
    """Changes the selection and the selected chart."""

    rebuild_requested = Signal()  # Other charts are in sight.
    selection_changed = Signal()  # Another chart is selected.
    layout_edited = Signal(object)  # The `StripLayout` that the user wants.

    def __init__(self, model: ChartModel, parent: QObject) -> None:
        super().__init__(parent)
        self._model = model

    @property
    def actions(self) -> Mapping[str, Callable[[], object]]:
        return {
            "chart_up": partial(self._select_next, -1),
            "chart_down": partial(self._select_next, 1),
            "enlarge": self.toggle_enlarged,
            "range": self.select_next_range,
            "move_up": partial(self.move, -1),
            "move_down": partial(self.move, 1),
        }

    def select(self, number_of_chart: int) -> None:
        last, view = len(self._model.layout.strips) - 1, self._model.view
        selected = min(max(number_of_chart, 0), last)
        if last >= 0 and selected != view.selected:
            view.selected = selected
            self.selection_changed.emit()

    def _select_next(self, steps: int) -> None:
        self.select(self._model.view.selected + steps)

    def toggle_enlarged(self) -> None:
        """Let the selected chart fill the display, or show all again."""
        self._model.view.enlarged = not self._model.view.enlarged
        self.rebuild_requested.emit()

    def set_range(self, ends: tuple[float, float] | None) -> None:
        """Hold the y range of the selected chart (displayed units), or autoscale it with None."""
        chart = self._model.selected_chart
        if chart is None:
            return
        if ends is None:
            self._replace_selected({"range": "auto", "low": None, "high": None})
        else:
            low, high = sorted(chart.displays[0].to_si(end) for end in ends)
            self._replace_selected({"range": "fixed", "low": low, "high": high})

    def select_next_range(self) -> None:
        strips = self._model.layout.strips
        if strips:
            strip = strips[self._model.view.selected]
            order = ["auto", "limits"] if strip.low is None else ["auto", "fixed", "limits"]
            following = order[(order.index(strip.range) + 1) % len(order)]
            self._replace_selected({"range": following})

    def _replace_selected(self, values: Mapping[str, object]) -> None:
        layout, selected = self._model.layout, self._model.view.selected
        strip = layout.strips[selected].model_copy(update=values)
        self.layout_edited.emit(layout.with_strip(selected, strip))

    def hide(self) -> None:
        if self._model.layout.strips:
            self.layout_edited.emit(self._model.layout.with_strip(self._model.view.selected, None))

    def set_channels(self, names: Sequence[str]) -> None:
        """Show other channels of one quantity in the selected chart; lines that stay keep style."""
        former = {
            one.channel: one for one in self._model.layout.strips[self._model.view.selected].traces
        }
        traces = tuple(former.get(name, Trace(channel=name)) for name in names)
        self._replace_selected({"traces": traces})

    def move(self, by: int) -> None:
        """Move the selected chart up (-1) or down (+1)."""
        layout, view = self._model.layout, self._model.view
        if not layout.strips:
            return
        strip = layout.strips[view.selected]
        changed = layout.with_strip_moved(view.selected, by)
        if changed != layout:
            indices = [index for index, other in enumerate(changed.strips) if other is strip]
            view.selected = indices[0] if indices else view.selected
            self.layout_edited.emit(changed)


_VALUE_ZOOM = 1.25  # Of the range of values, by a notch of the wheel.


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
