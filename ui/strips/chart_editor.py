"""Selecting a strip chart, its y range, and its place in the layout."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QObject, Signal

from ui.strips.chart_model import ChartModel


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
