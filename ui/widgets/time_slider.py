"""The whole flight as a line, with its marks and alarms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from ui.display_style import DisplayStyle
from ui.icons import paint_indicator
from ui.number_format import clock_text
from ui.strips.chart_annotations import AlarmSpan
from ui.translation import tr


class TimeSlider(QWidget):
    """The whole flight as a line, marks above it and alarms below; pressed it goes there."""

    moved = Signal(float)  # Flight time to go to, s.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._range = (0.0, 0.0)
        self._time = 0.0
        self._marks: tuple[float, ...] = ()
        self._alarms: tuple[AlarmSpan, ...] = ()
        self._dragged = False
        self.setAccessibleName(tr("Time in the flight"))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setToolTip(tr("Click to go there; Left and Right move by 1 s"))

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(160), self._style.px(24))

    def show_time(
        self,
        time: float,
        first: float,
        last: float,
        marks: Sequence[float],
        alarms: Sequence[AlarmSpan] = (),
    ) -> None:
        new = (time, (first, last), tuple(marks), tuple(alarms))
        if new != (self._time, self._range, self._marks, self._alarms):
            self._time, self._range, self._marks, self._alarms = new
            self.setAccessibleDescription(
                tr("{time} of {last}").format(
                    time=clock_text(time, decimals=1), last=clock_text(last, decimals=1)
                )
            )
            self.update()

    def _line(self) -> QRectF:
        pad = self._style.px(8)
        return QRectF(self.rect()).adjusted(pad, 0, -pad, 0)

    def _x_at(self, time: float) -> float:
        line, (first, last) = self._line(), self._range
        share = (time - first) / (last - first) if last > first else 0.0
        return line.left() + min(max(share, 0.0), 1.0) * line.width()

    def _time_at(self, x: float) -> float:
        line, (first, last) = self._line(), self._range
        share = (x - line.left()) / line.width() if line.width() > 0 else 0.0
        return first + min(max(share, 0.0), 1.0) * (last - first)

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, line = self._style, self._line()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, thick = line.center().y(), style.px(4)
        track = QRectF(line.left(), middle - thick / 2, line.width(), thick)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(style.color("line"))
        painter.drawRoundedRect(track, thick / 2, thick / 2)
        here = self._x_at(self._time)
        painter.setBrush(style.color("muted"))
        painter.drawRoundedRect(
            QRectF(track.left(), track.top(), here - track.left(), thick), thick / 2, thick / 2
        )
        painter.setBrush(style.color("span_edge"))
        side = style.px(4)
        for mark in self._marks:
            x, top = self._x_at(mark), middle - style.px(11)
            painter.drawPolygon(
                QPolygonF([QPointF(x - side, top), QPointF(x + side, top), QPointF(x, top + side)])
            )
            painter.drawRect(QRectF(x - 0.5, top, 1, style.px(12)))
        for alarm in self._alarms:
            # Triangle or square, as everywhere: the shape tells the state without its color.
            box = QRectF(self._x_at(alarm.start) - side, middle + style.px(3), 2 * side, 2 * side)
            state: Literal["caution", "warning"]
            state = "warning" if alarm.state == "warning" else "caution"
            paint_indicator(painter, state, box, style.state_color(state))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(style.color("text"))
        radius = style.px(7 if self.hasFocus() else 6)
        painter.drawEllipse(QPointF(here, middle), radius, radius)
        if self.hasFocus():
            painter.setBrush(style.color("background"))
            painter.drawEllipse(QPointF(here, middle), radius / 2, radius / 2)
        painter.end()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        self._dragged = True
        self.moved.emit(self._time_at(event.position().x()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._dragged:
            self.moved.emit(self._time_at(event.position().x()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._dragged = False

    def keyPressEvent(self, event: QKeyEvent) -> None:
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
