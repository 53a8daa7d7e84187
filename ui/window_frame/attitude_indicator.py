"""Bank, pitch and airspeed at a glance, below the places."""

from __future__ import annotations

import math
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from gsapp.quantities import channel
from ui.display_style import DisplayStyle
from ui.number_format import DASH, channel_value_text
from ui.strips.pixel_columns import SampleSource
from ui.translation import tr

_MAX_AGE: Final = 2.0  # s of a sample that is shown
_SPEEDS: Final = ("Vc", "V")  # The first that is there.
_HEIGHT: Final = 112  # Points that it takes where there is room.
_MIN_DIAMETER: Final = 40  # Points below which nothing is drawn.
_PITCH_RANGE: Final = math.radians(40.0)  # From the top of the disk to its bottom.
_LADDER: Final = (-20, -10, 10, 20)  # Degrees of pitch with a line.


class AttitudeIndicator(QWidget):
    """The horizon as seen from the aircraft, and airspeed below it; empty without attitude."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        # It never makes the window higher.
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.setAccessibleName(tr("Attitude and airspeed"))
        self.attitude: tuple[float, float] | None = None
        """Bank and pitch, rad."""
        self.speed_text = ""
        style.changed.connect(self.updateGeometry)
        self.hide()

    def sizeHint(self) -> QSize:
        return QSize(0, self._style.px(_HEIGHT))

    def show_flight(self, history: SampleSource | None, now: float | None) -> None:
        """Show the newest samples; those older than two seconds are missing."""

        def newest(name: str) -> float | None:
            if history is None or now is None or name not in history.channels:
                return None
            found = history.last(name)
            return found[1] if found is not None and now - found[0] <= _MAX_AGE else None

        bank, pitch = newest("phi"), newest("theta")
        held = () if history is None else history.channels
        name = next((one for one in _SPEEDS if one in held), "")
        text = ""
        if name:
            text = channel_value_text(channel(name), newest(name), self._style.units)
        attitude = None if bank is None or pitch is None else (bank, pitch)
        self.setHidden("phi" not in held or "theta" not in held)
        if (attitude, text) == (self.attitude, self.speed_text):
            return
        self.attitude, self.speed_text = attitude, text
        self.setAccessibleDescription(self._description())
        self.update()

    def _description(self) -> str:
        if self.attitude is None:
            return tr("No attitude, airspeed {speed}").format(speed=self.speed_text or DASH)
        bank, pitch = (round(math.degrees(angle)) for angle in self.attitude)
        return tr("Bank {bank}°, pitch {pitch}°, airspeed {speed}").format(
            bank=bank, pitch=pitch, speed=self.speed_text or DASH
        )

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, px = self._style, self._style.px
        words = px(18)
        diameter = min(self.width() - px(12), self.height() - words - px(8))
        if diameter < px(_MIN_DIAMETER):
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        disk = QRectF((self.width() - diameter) / 2.0, px(4), diameter, diameter)
        self._paint_disk(painter, disk)
        painter.setPen(style.color("text"))
        painter.setFont(style.font("label", strong=True))
        below = QRectF(0.0, disk.bottom() + px(2), self.width(), words)
        painter.drawText(below, Qt.AlignmentFlag.AlignCenter, self.speed_text or DASH)
        painter.end()

    def _paint_disk(self, painter: QPainter, disk: QRectF) -> None:
        style = self._style
        line = QPen(style.color("text"), style.px(1.5))
        rim = QPainterPath()
        rim.addEllipse(disk)
        painter.save()
        painter.setClipPath(rim)
        painter.fillRect(disk, style.color("plot"))
        half = disk.height() / 2.0
        if self.attitude is None:
            painter.fillRect(disk, QColor(style.color("axis")))
            painter.setPen(line)
            painter.drawText(disk, Qt.AlignmentFlag.AlignCenter, DASH)
        else:
            bank, pitch = self.attitude
            painter.translate(disk.center())
            painter.rotate(-math.degrees(bank))
            scale = disk.height() / _PITCH_RANGE
            # Beyond the disk a rest of ground or sky stays in sight: it shows where level is.
            down = min(max(scale * pitch, -0.7 * half), 0.7 * half)
            painter.fillRect(QRectF(-2 * half, down, 4 * half, 4 * half), style.color("axis"))
            painter.setPen(line)
            painter.drawLine(QPointF(-half, down), QPointF(half, down))
            for degrees in _LADDER:
                y = down - scale * math.radians(degrees)
                painter.drawLine(QPointF(-0.15 * half, y), QPointF(0.15 * half, y))
        painter.restore()
        painter.setPen(QPen(style.color("text"), style.px(2)))
        painter.drawEllipse(disk)
        if self.attitude is None:
            return
        painter.setPen(QPen(style.color("text"), style.px(3)))
        center = disk.center()
        for side in (-1.0, 1.0):  # the wings
            painter.drawLine(
                center + QPointF(0.25 * side * half, 0.0), center + QPointF(0.6 * side * half, 0.0)
            )
        painter.drawPoint(center)
