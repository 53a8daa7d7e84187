"""Below the charts: pause, marks, time in sight; and the bar that runs a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QPushButton, QSizePolicy, QWidget

from ui.display_style import DisplayStyle
from ui.number_format import clock_text, time_span_text
from ui.strips.chart_annotations import AlarmSpan
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.flow_layout import FlowLayout, arrange
from ui.widgets.labels import create_label
from ui.widgets.time_slider import TimeSlider

TIME_SPANS = (10.0, 30.0, 60.0, 120.0, 600.0)  # Seconds in sight that have a button.

REPLAY_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, float("inf"))
"""Speeds of a replay; the last is as fast as it can."""


_SPANS_MIN_WIDTH = 640  # Points of width below which the buttons for the time in sight give way.


_NOTE_MIN_WIDTH = 520  # Points of width below which only the key N notes.


def speed_text(speed: float) -> str:
    """Return ``0.1x``, ``1x``, ``max``."""
    return tr("max") if speed == float("inf") else f"{speed:g}x"


class ReplayBar(QWidget):
    """Runs a replay: play, speed, step, go to time."""

    speed_chosen = Signal(float)  # Times as fast as the flight was; infinite is as fast as it can.
    moved = Signal(float)  # Flight time to go to, s.

    def __init__(self, actions: Mapping[str, QAction], style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        self.play = ActionButton(actions["chart_pause"], tr("Play"), style, "play")
        self.back = ActionButton(actions["step_back"], "−1", style)
        self.step = ActionButton(actions["step"], "+1", style)
        self.go_to = ActionButton(actions["go_to"], tr("Go to…"), style)
        self.speed = QComboBox()
        self.speed.setAccessibleName(tr("Speed of the replay"))
        self.speed.setToolTip(tr("Speed of the replay ([ slower, ] faster)"))
        self.speed.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        for speed in REPLAY_SPEEDS:
            self.speed.addItem(speed_text(speed), speed)
        self.speed.activated.connect(
            lambda index: self.speed_chosen.emit(float(self.speed.itemData(index)))
        )
        self.clock = create_label("")
        self.clock.setProperty("role", "number")
        self.clock.setMinimumWidth(style.px(112))
        for widget in (self.play, self.back, self.step, self.speed, self.go_to, self.clock):
            row.addWidget(widget)
        self._row = row
        self.slider = TimeSlider(style)  # The whole flight with its marks; stands above this bar.
        self.slider.moved.connect(self.moved)
        style.changed.connect(self._rescale)
        self._rescale()

    def _rescale(self) -> None:
        self._row.setSpacing(self._style.px(8))
        self.clock.setMinimumWidth(self._style.px(112))
        self.slider.updateGeometry()

    def show_bar(self, shown: bool) -> None:
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
        self.play.set_icon_text(
            "pause" if playing else "play", tr("Pause") if playing else tr("Play")
        )
        index = min(range(len(REPLAY_SPEEDS)), key=lambda place: abs(REPLAY_SPEEDS[place] - speed))
        if speed == REPLAY_SPEEDS[-1]:
            index = len(REPLAY_SPEEDS) - 1
        if not self.speed.view().isVisible() and self.speed.currentIndex() != index:
            self.speed.setCurrentIndex(index)


class ControlRow(QWidget):
    """Pause or the replay's tools, mark, note, time in sight, side panel."""

    span_chosen = Signal(float)  # Seconds to show.

    def __init__(
        self, actions: Mapping[str, QAction], style: DisplayStyle, replay: ReplayBar
    ) -> None:
        super().__init__()
        self._style = style
        self._replay = replay
        outer = arrange(QHBoxLayout(self), 0)
        left, right = QWidget(), QWidget()
        outer.addWidget(left, 1)
        outer.addWidget(right, 0, Qt.AlignmentFlag.AlignTop)
        flow = FlowLayout(left, spacing=style.px(8))
        side = FlowLayout(right, spacing=style.px(8))
        self._flows = (flow, side)
        self.pause = ActionButton(actions["chart_pause"], tr("Pause"), style, "pause")
        self.mark = ActionButton(actions["mark"], tr("Mark"), style, "flag")
        self.note = ActionButton(actions["note"], tr("Note"), style)
        self.panel = ActionButton(actions["side_panel"], tr("Panel"), style, "panel")
        for widget in (replay, self.pause, self.mark, self.note):
            flow.addWidget(widget)
        self.spans: dict[float, QPushButton] = {}
        holder = QWidget()
        row = arrange(QHBoxLayout(holder), style.px(4))
        for seconds in TIME_SPANS:
            button = QPushButton(time_span_text(seconds))
            button.setProperty("role", "segment")
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAccessibleName(tr("Show {seconds}").format(seconds=time_span_text(seconds)))
            button.setToolTip(
                tr("Show {seconds} (+ zooms in, - out)").format(seconds=time_span_text(seconds))
            )
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
        style.changed.connect(self._rescale)
        self._rescale()

    def _rescale(self) -> None:
        gap = self._style.px(8)
        for flow in self._flows:
            flow.setContentsMargins(gap, gap, gap, gap)
            flow.setSpacing(gap)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        roomy = self.width() >= self._style.px(_SPANS_MIN_WIDTH)
        self._spans.setVisible(roomy)
        self._replay.show_steps(roomy)
        enough = self.width() >= self._style.px(_NOTE_MIN_WIDTH)
        self.note.setVisible(enough)
        # The bar on top has the time as well.
        self._replay.clock.setVisible(enough)

    def _choose(self, span: float) -> None:
        self.span_chosen.emit(span)

    def show_span(self, seconds: float) -> None:
        for span, button in self.spans.items():
            button.setChecked(abs(span - seconds) < 0.01 * span)

    def show_paused(self, paused: bool) -> None:
        """Show what the first button would do."""
        self.pause.set_icon_text(
            "play" if paused else "pause", tr("Resume") if paused else tr("Pause")
        )


def next_speed(speed: float, steps: int) -> float:
    """Return the next slower (negative) or faster speed of the list."""
    place = min(
        range(len(REPLAY_SPEEDS)),
        key=lambda index: (
            0.0 if REPLAY_SPEEDS[index] == speed else abs(min(REPLAY_SPEEDS[index], 1e9) - speed)
        ),
    )
    return REPLAY_SPEEDS[min(max(place + steps, 0), len(REPLAY_SPEEDS) - 1)]
