"""Below the charts: pause, marks, time in sight; and the bar that runs a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QWidget,
)

from ui.commands import action_hint, shortcut_text
from ui.display_style import DisplayStyle
from ui.flow_layout import FlowLayout
from ui.icons import create_icon, paint_indicator
from ui.number_format import clock_text, time_span_text
from ui.strips.chart_annotations import AlarmSpan

TIME_SPANS = (10.0, 30.0, 60.0, 120.0, 600.0)
"""Seconds in sight that have a button."""

REPLAY_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, float("inf"))
"""Speeds of a replay; the last is as fast as it can."""


_SPANS_MIN_WIDTH = 640
"""Points of width below which the buttons for the time in sight give way."""


_NOTE_MIN_WIDTH = 520
"""Points of width below which only the key N notes."""


def speed_text(speed: float) -> str:
    """Return ``0.1x``, ``1x``, ``max``."""
    return "max" if speed == float("inf") else f"{speed:g}x"


def _icon_spaced_text(words: str, glyph: str) -> str:
    # Qt sets sign and word closer than the grid.
    return f" {words}" if glyph else words


class ActionButton(QPushButton):
    """A button that runs a command: same words, same key, grayed with it."""

    def __init__(self, action: QAction, words: str, look: DisplayStyle, glyph: str = "") -> None:
        super().__init__(_icon_spaced_text(words, glyph))
        self._look = look
        self._glyph = glyph
        self._action = action
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.clicked.connect(action.trigger)
        action.changed.connect(self._follow)
        look.changed.connect(self._redraw)
        self._follow()
        self._redraw()

    def _follow(self) -> None:
        keys = shortcut_text(self._action.shortcut().toString())
        text = self._action.text().rstrip("…")
        self.setToolTip(action_hint(self._action))
        self.setAccessibleName(f"{text}, {keys}" if keys else text)
        self.setEnabled(self._action.isEnabled())

    def set_icon_text(self, glyph: str, words: str) -> None:
        """Show another sign and word."""
        if (glyph, _icon_spaced_text(words, glyph)) != (self._glyph, self.text()):
            self._glyph = glyph
            self.setText(_icon_spaced_text(words, glyph))
            self._redraw()

    def _redraw(self) -> None:
        if self._glyph:
            side = self._look.px(16)
            self.setIcon(create_icon(self._glyph, self._look.color("text"), side))
            self.setIconSize(QSize(side, side))


class TimeSlider(QWidget):
    """The whole flight as a line, marks above it and alarms below; pressed it goes there.

    Attributes
    ----------
    moved : Signal(float)
        Flight time to go to, s.
    """

    moved = Signal(float)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._range = (0.0, 0.0)
        self._time = 0.0
        self._marks: tuple[float, ...] = ()
        self._alarms: tuple[AlarmSpan, ...] = ()
        self._dragged = False
        self.setAccessibleName("Time in the flight")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setToolTip("Press to go there; with the keyboard Left and Right by 1 s")

    def sizeHint(self) -> QSize:
        """Return the least size."""
        return QSize(self._look.px(160), self._look.px(24))

    def show_time(
        self,
        time: float,
        first: float,
        last: float,
        marks: Sequence[float],
        alarms: Sequence[AlarmSpan] = (),
    ) -> None:
        """Show where the replay is, and what stands where in the flight."""
        new = (time, (first, last), tuple(marks), tuple(alarms))
        if new != (self._time, self._range, self._marks, self._alarms):
            self._time, self._range, self._marks, self._alarms = new
            self.setAccessibleDescription(
                f"{clock_text(time, decimals=1)} of {clock_text(last, decimals=1)}"
            )
            self.update()

    def _line(self) -> QRectF:
        pad = self._look.px(8)
        return QRectF(self.rect()).adjusted(pad, 0, -pad, 0)

    def x(self, time: float) -> float:
        """Return where a time is drawn."""
        line, (first, last) = self._line(), self._range
        share = (time - first) / (last - first) if last > first else 0.0
        return line.left() + min(max(share, 0.0), 1.0) * line.width()

    def _time_at(self, x: float) -> float:
        line, (first, last) = self._line(), self._range
        share = (x - line.left()) / line.width() if line.width() > 0 else 0.0
        return first + min(max(share, 0.0), 1.0) * (last - first)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw line, marks, place."""
        look, line = self._look, self._line()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, thick = line.center().y(), look.px(4)
        track = QRectF(line.left(), middle - thick / 2, line.width(), thick)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(look.color("line"))
        painter.drawRoundedRect(track, thick / 2, thick / 2)
        here = self.x(self._time)
        painter.setBrush(look.color("muted"))
        painter.drawRoundedRect(
            QRectF(track.left(), track.top(), here - track.left(), thick), thick / 2, thick / 2
        )
        painter.setBrush(look.color("span_edge"))
        side = look.px(4)
        for mark in self._marks:
            x, top = self.x(mark), middle - look.px(11)
            painter.drawPolygon(
                QPolygonF([QPointF(x - side, top), QPointF(x + side, top), QPointF(x, top + side)])
            )
            painter.drawRect(QRectF(x - 0.5, top, 1, look.px(12)))
        for alarm in self._alarms:
            # Triangle or square, as everywhere: the shape tells the state without its color.
            box = QRectF(self.x(alarm.start) - side, middle + look.px(3), 2 * side, 2 * side)
            state = "warning" if alarm.state == "warning" else "caution"
            paint_indicator(painter, state, box, look.state_color(state))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(look.color("text"))
        radius = look.px(7 if self.hasFocus() else 6)
        painter.drawEllipse(QPointF(here, middle), radius, radius)
        if self.hasFocus():
            painter.setBrush(look.color("background"))
            painter.drawEllipse(QPointF(here, middle), radius / 2, radius / 2)
        painter.end()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Go where it was pressed."""
        if event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        self._dragged = True
        self.moved.emit(self._time_at(event.position().x()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Follow the mouse."""
        if self._dragged:
            self.moved.emit(self._time_at(event.position().x()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._dragged = False

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move by 1 s, by 10 s with PgUp and PgDown, to the ends with Home and End."""
        first, last = self._range
        steps = {
            int(Qt.Key.Key_Left): self._time - 1.0,
            int(Qt.Key.Key_Right): self._time + 1.0,
            int(Qt.Key.Key_PageUp): self._time - 10.0,
            int(Qt.Key.Key_PageDown): self._time + 10.0,
            int(Qt.Key.Key_Home): first,
            int(Qt.Key.Key_End): last,
        }
        if event.key() in steps:
            self.moved.emit(min(max(steps[event.key()], first), last))
        else:
            super().keyPressEvent(event)


class ReplayBar(QWidget):
    """Runs a replay: play, speed, step, go to time.

    Attributes
    ----------
    speed_chosen : Signal(float)
        Times as fast as the flight was; infinite is as fast as it can.
    moved : Signal(float)
        Flight time to go to, s.
    slider : TimeSlider
        The whole flight with its marks; stands above this bar.
    """

    speed_chosen = Signal(float)
    moved = Signal(float)

    def __init__(self, actions: Mapping[str, QAction], look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        self.play = ActionButton(actions["chart_pause"], "Play", look, "play")
        self.back = ActionButton(actions["step_back"], "−1", look)
        self.step = ActionButton(actions["step"], "+1", look)
        self.go_to = ActionButton(actions["go_to"], "Go to…", look)
        self.speed = QComboBox()
        self.speed.setAccessibleName("Speed of the replay")
        self.speed.setToolTip("Speed of the replay ([ slower, ] faster)")
        self.speed.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        for speed in REPLAY_SPEEDS:
            self.speed.addItem(speed_text(speed), speed)
        self.speed.activated.connect(
            lambda index: self.speed_chosen.emit(float(self.speed.itemData(index)))
        )
        self.clock = QLabel()
        self.clock.setProperty("role", "number")
        self.clock.setMinimumWidth(look.px(112))
        for widget in (self.play, self.back, self.step, self.speed, self.go_to, self.clock):
            row.addWidget(widget)
        self._row = row
        self.slider = TimeSlider(look)
        self.slider.moved.connect(self.moved)
        look.changed.connect(self._rescale)
        self._rescale()

    def _rescale(self) -> None:
        self._row.setSpacing(self._look.px(8))
        self.clock.setMinimumWidth(self._look.px(112))
        self.slider.updateGeometry()

    def show_bar(self, shown: bool) -> None:
        """Show bar and slider, or hide both."""
        self.setVisible(shown)
        self.slider.setVisible(shown)

    def show_steps(self, shown: bool) -> None:
        """Show the buttons for single steps and times, or leave these to the keys."""
        for button in (self.back, self.step, self.go_to):
            button.setVisible(shown)

    def show_replay(
        self,
        time: float,
        first: float,
        last: float,
        *,
        playing: bool,
        speed: float,
        marks: Sequence[float],
        alarms: Sequence[AlarmSpan] = (),
    ) -> None:
        """Show where the replay is and how it runs."""
        self.slider.show_time(time, first, last, marks, alarms)
        self.clock.setText(f"{clock_text(time, decimals=1)} / {clock_text(last, decimals=1)}")
        self.play.set_icon_text("pause" if playing else "play", "Pause" if playing else "Play")
        index = min(range(len(REPLAY_SPEEDS)), key=lambda place: abs(REPLAY_SPEEDS[place] - speed))
        if speed == REPLAY_SPEEDS[-1]:
            index = len(REPLAY_SPEEDS) - 1
        if not self.speed.view().isVisible() and self.speed.currentIndex() != index:
            self.speed.setCurrentIndex(index)


class ControlRow(QWidget):
    """Pause or the replay's tools, mark, note, time in sight, side panel.

    Attributes
    ----------
    span_chosen : Signal(float)
        Seconds to show.
    """

    span_chosen = Signal(float)

    def __init__(
        self, actions: Mapping[str, QAction], look: DisplayStyle, replay: ReplayBar
    ) -> None:
        super().__init__()
        self._look = look
        self._replay = replay
        outer = QHBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.setSpacing(0)
        left, right = QWidget(), QWidget()
        outer.addWidget(left, 1)
        outer.addWidget(right, 0, Qt.AlignmentFlag.AlignTop)
        flow = FlowLayout(left, spacing=look.px(8))
        side = FlowLayout(right, spacing=look.px(8))
        self._flows = (flow, side)
        self.pause = ActionButton(actions["chart_pause"], "Pause", look, "pause")
        self.mark = ActionButton(actions["mark"], "Mark", look, "flag")
        self.note = ActionButton(actions["note"], "Note", look)
        self.panel = ActionButton(actions["side_panel"], "Panel", look, "panel")
        for widget in (replay, self.pause, self.mark, self.note):
            flow.addWidget(widget)
        self.spans: dict[float, QPushButton] = {}
        holder = QWidget()
        row = QHBoxLayout(holder)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(look.px(4))
        for seconds in TIME_SPANS:
            button = QPushButton(time_span_text(seconds))
            button.setProperty("role", "segment")
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAccessibleName(f"Show {time_span_text(seconds)}")
            button.setToolTip(f"Show {time_span_text(seconds)} (+ zooms in, - out)")
            button.clicked.connect(lambda _checked=False, span=seconds: self._choose(span))
            row.addWidget(button)
            self.spans[seconds] = button
        self._spans = holder
        flow.addWidget(holder)
        side.addWidget(self.panel)
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        left.setSizePolicy(policy)
        look.changed.connect(self._rescale)
        self._rescale()

    def _rescale(self) -> None:
        gap = self._look.px(8)
        for flow in self._flows:
            flow.setContentsMargins(gap, gap, gap, gap)
            flow.setSpacing(gap)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the room to the charts where the window is narrow; the keys + and - stay."""
        super().resizeEvent(event)
        roomy = self.width() >= self._look.px(_SPANS_MIN_WIDTH)
        self._spans.setVisible(roomy)
        self._replay.show_steps(roomy)
        enough = self.width() >= self._look.px(_NOTE_MIN_WIDTH)
        self.note.setVisible(enough)
        # The bar on top has the time as well.
        self._replay.clock.setVisible(enough)

    def _choose(self, span: float) -> None:
        self.span_chosen.emit(span)

    def show_span(self, seconds: float) -> None:
        """Show which time is in sight."""
        for span, button in self.spans.items():
            button.setChecked(abs(span - seconds) < 0.01 * span)

    def show_paused(self, paused: bool) -> None:
        """Show what the first button would do."""
        self.pause.set_icon_text("play" if paused else "pause", "Resume" if paused else "Pause")


def next_speed(speed: float, steps: int) -> float:
    """Return the next slower (negative) or faster speed of the list."""
    place = min(
        range(len(REPLAY_SPEEDS)),
        key=lambda index: (
            0.0 if REPLAY_SPEEDS[index] == speed else abs(min(REPLAY_SPEEDS[index], 1e9) - speed)
        ),
    )
    return REPLAY_SPEEDS[min(max(place + steps, 0), len(REPLAY_SPEEDS) - 1)]
