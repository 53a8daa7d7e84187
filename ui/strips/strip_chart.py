"""The strip charts: one widget that paints all of them."""

from __future__ import annotations

import math
import time as wall_clock
from collections.abc import Iterable, Mapping, Sequence

from PySide6.QtCore import QEvent, QKeyCombination, QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QFocusEvent,
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

from gsapp.session.limits import LimitBands
from ui.strips.chart_annotations import AlarmSpan, ChannelOrigin, ChartMark, ChartSpan
from ui.strips.chart_canvas import ChartCanvas, RepaintRegion
from ui.strips.chart_geometry import ChartGeometry, PixelBox
from ui.strips.chart_interaction import ChartEditor, ChartMouse, ViewNavigator
from ui.strips.chart_keys import ACTION_BY_KEY
from ui.strips.chart_model import ChartModel
from ui.strips.chart_raster import ChartRaster
from ui.strips.chart_state import ChartState, DisplayedValue
from ui.strips.pixel_columns import SampleSource
from ui.strips.strip_layout import StripLayout
from ui.strips.strip_view import StripView
from ui.theme import Theme, compute_sizes
from ui.translation import tr

_FRAME_MS = 16  # Between looks at the history, ms.
_VALUE_INTERVAL = 0.15  # Between new values, s: faster, nobody can read them.


class StripChart(QWidget):
    """All strip charts in one widget.

    `timed`: whether the widget looks at the history by itself, 60 times a second while it is
    visible. Where the window has a timer that polls the feed, False and a call of `advance` after
    the poll save up to a frame of delay.
    """

    mark_requested = Signal(float)  # The user wants a mark at this flight time, s.
    cursor_moved = Signal(str, object)  # ``cursor``, ``a`` or ``b``, and its time in s or None.
    layout_changed = Signal(object)  # The user changed the charts: the new `StripLayout`.
    view_changed = Signal()  # Pause, time or window changed.
    # The user wants a menu of the selected chart: where on the screen (QPoint), and for which
    # flight time, s or None.
    menu_requested = Signal(object, object)

    def __init__(self, parent: QWidget | None = None, *, timed: bool = True) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMouseTracking(False)
        self.setAccessibleName(tr("Strip charts"))
        self.model = ChartModel()  # What is shown.
        self.navigator = ViewNavigator(self.model, self)
        self.editor = ChartEditor(self.model, self)  # Selects and changes charts.
        self._canvas = ChartCanvas(self.model)
        self._mouse = ChartMouse(self.model, self._canvas, self.navigator, self.editor)
        self._values_read_at = -math.inf
        self._actions = {
            **self.navigator.actions, **self.editor.actions, "clear": self.clear,
        }  # fmt: skip
        self.navigator.rebuild_requested.connect(self._rebuild)
        self.navigator.view_changed.connect(self._show_view)
        self.navigator.cursor_moved.connect(self._show_cursor)
        self.navigator.mark_requested.connect(self.mark_requested)
        self.editor.rebuild_requested.connect(self._rebuild)
        self.editor.selection_changed.connect(self._show_selection)
        self.editor.layout_edited.connect(self._edit_layout)
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(_FRAME_MS)
        self._timer.timeout.connect(self.advance)
        if timed:
            self._timer.start()

    # What to show

    def set_history(self, history: SampleSource | None) -> None:
        """Show another history; the display follows its newest sample."""
        self.model.show_history(history)
        self.refresh()
        self.view_changed.emit()

    def set_layout(self, layout: StripLayout) -> None:
        """Show other charts, in another window if that of the layout is another."""
        model = self.model
        former = model.layout
        if not model.change("layout", layout):
            return
        if layout.window != former.window:
            model.view.set_window(layout.window)
        model.view.selected = min(model.view.selected, max(len(layout.strips) - 1, 0))
        model.create_charts()
        self._rebuild()

    def set_theme(self, theme: Theme) -> None:
        self._change_charts("theme", theme)

    def set_units(self, system: str) -> None:
        self._change_charts("units", system)

    def set_limits(self, limits: Mapping[str, LimitBands]) -> None:
        """Draw these limits, and name the values beyond them; by channel id."""
        self._change_charts("limits", dict(limits))

    def _change_charts(self, name: str, value: object) -> None:
        if self.model.change(name, value):
            self.model.charts.clear()
            self._rebuild()

    def set_scale(self, scale: float) -> None:
        """Set the size of text and lines: 1.0 to 2.5."""
        self._change_geometry("scale", compute_sizes(scale).scale)

    def set_spans(self, spans: Sequence[ChartSpan]) -> None:
        self._change_geometry("spans", tuple(spans))

    def set_marks(self, marks: Sequence[ChartMark]) -> None:
        self._change_geometry("marks", tuple(marks))

    def set_cursor_values_shown(self, shown: bool) -> None:
        """Show values at the cursors beside the charts, or leave their room to the charts."""
        self._change_geometry("shows_cursor_values", shown)

    def _change_geometry(self, name: str, value: object) -> None:
        if self.model.change(name, value):
            self._rebuild()

    def set_alarms(self, alarms: Sequence[AlarmSpan]) -> None:
        self._change_text("alarms", tuple(alarms))

    def set_recording(self, recording: bool) -> None:
        """Say whether a recorder runs, which a paused display shows."""
        self._change_text("recording", recording)

    def set_newest_text(self, text: str) -> None:
        """Say what the newest flight time is: now, or as far as a record was read."""
        self._change_text("newest_text", text)

    def set_empty_text(self, text: str) -> None:
        """Say why there is no sample at all; shown while there is none."""
        self._change_text("empty_text", text)

    def _change_text(self, name: str, value: object) -> None:
        if self.model.change(name, value):
            self.update()

    def set_sources(self, sources: Mapping[str, ChannelOrigin]) -> None:
        """Say which channels are estimated or not calibrated; by channel id."""
        self.model.sources = dict(sources)
        self._values_read_at = -math.inf

    def set_stale_ages(self, ages: Mapping[str, float]) -> None:
        """Set the age (s) from which values that come seldom are stale; by channel id."""
        self.model.stale_ages = dict(ages)
        self._values_read_at = -math.inf

    def set_now(self, flight_time: float | None) -> None:
        """Set the flight time, s, so that values grow stale when nothing comes any more.

        None goes by the newest sample alone.
        """
        self.model.flight_time = flight_time

    def refresh(self) -> None:
        """Paint everything again, as after changing `view`."""
        self._rebuild()
        self.advance()

    # What is shown

    @property
    def view(self) -> StripView:
        return self.model.view

    @property
    def strip_layout(self) -> StripLayout:
        return self.model.layout

    @property
    def charts(self) -> Mapping[int, ChartState]:
        """Return the charts by number, with range and labels in force."""
        return self.model.charts

    @property
    def geometry_in_pixels(self) -> ChartGeometry | None:
        """Return where everything stands, in pixels of the screen; None before it was shown."""
        return self._canvas.geometry

    @property
    def raster(self) -> ChartRaster | None:
        """Return the pixels of the plots; None before it was shown."""
        return self._canvas.raster

    def displayed_values(self, number_of_chart: int) -> tuple[DisplayedValue, ...]:
        """Return the current values of a chart as they are shown."""
        return self._canvas.displayed_values.get(number_of_chart, ())

    # Frames

    def advance(self) -> None:
        """Paint what has arrived: one frame."""
        model, canvas = self.model, self._canvas
        if model.history is None or not self.isVisible():
            return
        model.advance_time()
        if model.view.now is None:
            return
        if not canvas.is_valid:
            self._build()
        self._repaint(canvas.advance())
        now = wall_clock.monotonic()
        if now - self._values_read_at >= _VALUE_INTERVAL:
            self._values_read_at = now
            self._repaint(canvas.update_auto_ranges())
            self._repaint(canvas.update_values())
        self._repaint(canvas.update_header())

    def _repaint(self, boxes: Iterable[PixelBox]) -> None:
        for box in boxes:
            self.update(_to_logical_rect(box, self._canvas.density))

    def _rebuild(self) -> None:
        """Build everything again at the next frame or repaint."""
        self._canvas.invalidate()
        self._values_read_at = -math.inf
        self.update()

    def _build(self) -> None:
        density = self.devicePixelRatioF()
        self._canvas.build(round(self.width() * density), round(self.height() * density), density)
        self._describe()
        self.update()

    def _describe(self) -> None:
        self.setAccessibleDescription(self.model.describe_selection())

    def _show_view(self) -> None:
        self._values_read_at = -math.inf
        self._canvas.invalidate_header()
        self.update()
        self.advance()
        self.view_changed.emit()

    def _show_cursor(self, name: str, time: float | None) -> None:
        self.update()
        self.cursor_moved.emit(name, time)

    def _show_selection(self) -> None:
        geometry, view = self._canvas.geometry, self.view
        if view.enlarged or geometry is None or view.selected not in geometry.numbers:
            self._rebuild()
        self._describe()
        self.update()

    def _edit_layout(self, layout: StripLayout) -> None:
        self.set_layout(layout)
        self.layout_changed.emit(layout)

    # Keys and mouse

    def perform(self, action: str) -> None:
        self._actions[action]()

    def clear(self) -> None:
        """Remove the cursors and show all charts."""
        self.navigator.clear_cursors()
        if self.view.enlarged:
            self.editor.toggle_enlarged()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        action = ACTION_BY_KEY.get(_key_text(event))
        if action is None:
            super().keyPressEvent(event)
            return
        if action.repeats or not event.isAutoRepeat():
            self.perform(action.id)
        event.accept()

    def wheelEvent(self, event: QWheelEvent) -> None:
        self._mouse.turn_wheel(event)
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._mouse.press(event.position())
        else:
            super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self._mouse.drag(event.position())

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._mouse.double_click(event.position())

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        time = self.view.cursors.get("cursor", self.view.now)
        if event.reason() == QContextMenuEvent.Reason.Mouse:
            self._mouse.select_at(event.pos().toPointF())
            time = self._mouse.time_at(event.pos().x())
        self.menu_requested.emit(event.globalPos(), time)
        event.accept()

    # Painting

    def paintEvent(self, event: QPaintEvent) -> None:
        if not self._canvas.is_valid:
            self.model.advance_time()
            self._build()
            if self.view.now is not None:
                self._canvas.update_values()
        painter = QPainter(self)
        density = self._canvas.density
        painter.setRenderHint(QPainter.RenderHint.TextAntialiasing, True)
        # From here on in whole pixels of the screen; what the window is shifted by in fractions
        # of a pixel, on screens of uneven density, is taken back.
        painter.scale(1.0 / density, 1.0 / density)
        shift = painter.deviceTransform()
        painter.translate(round(shift.dx()) - shift.dx(), round(shift.dy()) - shift.dy())
        exposed = RepaintRegion(painter, event.region(), density)
        self._canvas.paint(painter, exposed, focused=self.hasFocus())
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._rebuild()
        super().resizeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        self._rebuild()
        super().showEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.FontChange:
            self._rebuild()
        super().changeEvent(event)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._rebuild()
        return bool(super().event(event))

    def focusInEvent(self, event: QFocusEvent) -> None:
        self.update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self.update()
        super().focusOutEvent(event)

    def sizeHint(self) -> QSize:
        return QSize(1000, 700)

    def minimumSizeHint(self) -> QSize:
        return QSize(round(420 * self.model.scale), round(160 * self.model.scale))


def _to_logical_rect(box: PixelBox, density: float) -> QRect:
    """Return the smallest rectangle in pixels of the design that covers a box."""
    left, top = math.floor(box.x / density), math.floor(box.y / density)
    right, bottom = math.ceil(box.right / density), math.ceil(box.bottom / density)
    return QRect(left, top, right - left, bottom - top)


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
