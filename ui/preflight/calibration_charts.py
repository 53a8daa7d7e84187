"""The points of an instrument, as a list and as charts: curve and residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pyqtgraph
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from calibration.points import DIRECTION_TEXT, Direction
from calibration.polynomial_fit import evaluate_polynomial
from gsapp.quantities import FloatArray, trace_color
from ui.display_style import DisplayStyle
from ui.icons import paint_indicator
from ui.number_format import unit_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.analysis_plot import AnalysisPlot, PlotCurve
from ui.widgets.paint_primitives import curve_color

if TYPE_CHECKING:
    from calibration.wizard import WizardView


_CURVE_SAMPLES = 120
_DIRECTION_SYMBOLS: tuple[tuple[Direction, str], ...] = (
    ("up", "t1"),
    ("down", "t"),
    ("single", "o"),
)
"""Directions with the shape of their points; pyqtgraph calls a triangle up ``t1``."""


class CalibrationCharts(QWidget):
    """Two charts over volts that share what they are drawn from."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._drawn: object = None
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(style.px(8))
        self.curve = AnalysisPlot(style, tr("Calibration curve"), high=170)
        self.residuals = AnalysisPlot(style, tr("Residuals"), high=170)
        row.addWidget(self.curve, 1)
        row.addWidget(self.residuals, 1)
        self._here = pyqtgraph.InfiniteLine(angle=90, movable=False)

    def show_view(self, view: WizardView) -> None:
        """Draw the points and the curve of a view, if they are others; move the line of now."""
        state = (
            view.instrument, view.points, view.calibration, view.check_result,
            self._style.theme.name,
        )  # fmt: skip
        if state != self._drawn:
            self._drawn = state
            self._draw(view)
            self._here.setPen(pyqtgraph.mkPen(curve_color(self._style, "cursor"), width=1))
            self.curve.plot.getPlotItem().addItem(self._here, ignoreBounds=True)
        reading = view.reading
        known = reading is not None and np.isfinite(reading.volts)
        self._here.setVisible(bool(known))
        if reading is not None and known:
            self._here.setValue(reading.volts)

    def _draw(self, view: WizardView) -> None:
        instrument, calibration = view.instrument, view.calibration
        unit = unit_text(instrument.unit) if instrument is not None else ""
        color = "ink" if instrument is None else trace_color(instrument.channel)
        points = _split_by_direction([(p.volts, p.value, p.direction) for p in view.points])
        curves = [
            PlotCurve(
                x=x, y=y, color=color, points=True, symbol=symbol,
                name=DIRECTION_TEXT[way] or tr("both directions"),
            )
            for (x, y), (way, symbol) in zip(points, _DIRECTION_SYMBOLS, strict=True)
            if x.size
        ]  # fmt: skip
        off: list[PlotCurve] = []
        if view.residuals:
            volts = np.array([point.volts for point in view.points])
            places = np.linspace(volts.min(), volts.max(), _CURVE_SAMPLES)
            if calibration is not None:
                line = evaluate_polynomial(calibration.fit.coefficients, places)
                curves.insert(0, PlotCurve(x=places, y=line, color="ink", name=tr("curve")))
            off = self._residuals(view, places, color)
        text = tr("{count} points").format(count=len(view.points))
        self.curve.draw(
            curves,
            title=tr("Calibration curve"),
            bottom=tr("Volts"),
            left=tr("Angle [{unit}]").format(unit=unit),
            words=text,
        )
        self.residuals.draw(
            off,
            title=tr("Residuals"),
            bottom=tr("Volts"),
            left=tr("Off [{unit}]").format(unit=unit),
            words=text,
        )

    def _residuals(self, view: WizardView, places: FloatArray, color: str) -> list[PlotCurve]:
        """Return each branch as a line through its points: their distance is the hysteresis."""
        calibration = view.calibration
        made = [PlotCurve(x=places[[0, -1]], y=np.zeros(2), color="muted")]
        if calibration is not None:
            width = calibration.quality.half_width(places)
            for sign in (-1.0, 1.0):
                name = tr("95 % bound") if sign > 0 else ""
                made.append(
                    PlotCurve(x=places, y=sign * width, color="previous", name=name, dashed=True)
                )
        points = _split_by_direction(
            [
                (point.volts, residual, point.direction)
                for point, residual in zip(view.points, view.residuals, strict=True)
            ]
        )
        for (x, y), (way, symbol) in zip(points, _DIRECTION_SYMBOLS, strict=True):
            if not x.size:
                continue
            order = np.argsort(x)
            if way != "single":
                made.append(PlotCurve(x=x[order], y=y[order], color=color, dashed=way == "down"))
            made.append(PlotCurve(x=x, y=y, color=color, points=True, symbol=symbol))
        return made


def _split_by_direction(
    points: list[tuple[float, float, str]],
) -> list[tuple[FloatArray, FloatArray]]:
    return [
        (
            np.array([x for x, _, known in points if known == way]),
            np.array([y for _, y, known in points if known == way]),
        )
        for way, *_ in _DIRECTION_SYMBOLS
    ]


_ROW, _HEAD = 26, 24
_ALIGN = Qt.AlignmentFlag
_TITLES = (QT_TR_NOOP("Set to"), QT_TR_NOOP("Volts"), QT_TR_NOOP("Residual"))


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPointRow:
    """One point, taken or still to be taken."""

    value: str
    direction: Direction = "single"
    """Whether the value increases or decreases as it is reached."""
    volts: str = ""
    residual: str = ""
    """As shown; volts and residual are empty where it was not taken yet."""
    share: float = 0.0
    """Residual over the largest of them, or over the error of a setting where that is larger; -1 to
    1."""
    remark: str = ""
    """What is odd about it; empty for nothing."""
    index: int | None = None
    """Place among the points taken; None for a setting still to come."""
    current: bool = False
    """Whether it is to be taken now."""

    @property
    def accessible_text(self) -> str:
        way = DIRECTION_TEXT[self.direction]
        parts: tuple[str, ...]
        if self.index is None:
            parts = (self.value, way, tr("now") if self.current else tr("pending"))
        else:
            parts = (self.value, way, self.volts, self.residual, self.remark)
        return ", ".join(part for part in parts if part)


class CalibrationPointList(QWidget):
    """Draws the rows; a press chooses one."""

    point_selected = Signal(int)  # place among the points taken

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.rows: tuple[CalibrationPointRow, ...] = ()
        self.choice: int | None = None
        self.setAccessibleName(tr("Points"))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        style.changed.connect(self._restyle)

    def _restyle(self) -> None:
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        rows = max(len(self.rows), 3)
        return QSize(self._style.px(320), self._style.px(_HEAD) + rows * self._style.px(_ROW))

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(240), self.sizeHint().height())

    def show_rows(self, rows: tuple[CalibrationPointRow, ...], choice: int | None) -> None:
        """Show other rows, one of the points taken being chosen."""
        if (rows, choice) == (self.rows, self.choice):
            return
        longer = len(rows) != len(self.rows)
        self.rows, self.choice = rows, choice
        self.setAccessibleDescription("; ".join(row.accessible_text for row in rows))
        if longer:
            self.updateGeometry()
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        place = int((event.position().y() - self._style.px(_HEAD)) // self._style.px(_ROW))
        if 0 <= place < len(self.rows) and self.rows[place].index is not None:
            self.point_selected.emit(self.rows[place].index)

    def _columns(self) -> tuple[QRectF, QRectF, QRectF, QRectF]:
        """Return the columns of a row at the top: way and setting, volts, residual, bar."""
        px, wide = self._style.px, float(self.width())
        high = px(_ROW)
        first = min(0.34 * wide, px(150))
        volts = min(0.24 * wide, px(90))
        number = min(0.24 * wide, px(110))
        left = px(6)
        return (
            QRectF(left, 0, first, high),
            QRectF(left + first, 0, volts, high),
            QRectF(left + first + volts, 0, number, high),
            QRectF(left + first + volts + number + px(12), 0,
                   max(wide - left - first - volts - number - px(20), 0.0), high),
        )  # fmt: skip

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        columns = self._columns()
        painter.setFont(style.font("label"))
        painter.setPen(style.color("muted"))
        head = style.px(_HEAD)
        for title, column, right in zip(_TITLES, columns[:3], (False, True, True), strict=True):
            box = QRectF(column.left(), 0, column.width(), head)
            side = _ALIGN.AlignRight if right else _ALIGN.AlignLeft
            painter.drawText(box, _ALIGN.AlignVCenter | side, tr(title))
        top = float(head)
        for row in self.rows:
            self._paint_row(painter, row, top, columns)
            top += style.px(_ROW)
        painter.end()

    def _paint_row(
        self, painter: QPainter, row: CalibrationPointRow, top: float, columns: tuple[QRectF, ...]
    ) -> None:
        style, px = self._style, self._style.px
        whole = QRectF(0, top, self.width(), px(_ROW))
        taken = row.index is not None
        if taken and row.index == self.choice:
            painter.fillRect(whole, style.color("chosen"))
            painter.fillRect(QRectF(0, top, px(3), px(_ROW)), style.color("text"))
        if row.current:
            painter.setPen(QPen(style.color("target"), px(2)))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(whole.adjusted(1, 1, -1, -1), px(4), px(4))
        ink = style.color("text" if taken else "target" if row.current else "muted")
        setting, volts, residual, bar = (column.translated(0, top) for column in columns)
        self._paint_direction(painter, row, setting, ink)
        painter.setFont(style.font("body", strong=row.current))
        painter.setPen(ink)
        painter.drawText(setting.adjusted(px(20), 0, 0, 0), _ALIGN.AlignVCenter, row.value)
        painter.setFont(style.font("body"))
        right = _ALIGN.AlignVCenter | _ALIGN.AlignRight
        painter.drawText(volts, right, row.volts)
        painter.drawText(residual, right, row.residual)
        if taken:
            self._paint_bar(painter, row, bar)

    def _paint_direction(
        self, painter: QPainter, row: CalibrationPointRow, box: QRectF, ink: object
    ) -> None:
        px = self._style.px
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ink)
        x, y, half = box.left() + px(8), box.center().y(), px(5)
        if row.direction != "single":
            tip = -half if row.direction == "up" else half
            foot = -0.8 * tip
            corners = [
                QPointF(x - half, y + foot),
                QPointF(x + half, y + foot),
                QPointF(x, y + tip),
            ]
            painter.drawPolygon(QPolygonF(corners))
        else:
            painter.drawEllipse(QPointF(x, y), 0.7 * half, 0.7 * half)

    def _paint_bar(self, painter: QPainter, row: CalibrationPointRow, box: QRectF) -> None:
        style, px = self._style, self._style.px
        if box.width() < px(24):
            return
        if row.remark:
            sign = QRectF(box.left(), box.center().y() - px(7), px(14), px(14))
            paint_indicator(painter, "caution", sign, style.color("caution"))
            painter.setFont(style.font("label", strong=True))
            painter.setPen(style.color("caution"))
            painter.drawText(box.adjusted(px(18), 0, 0, 0), _ALIGN.AlignVCenter, row.remark)
            return
        if not row.residual:
            return
        middle = box.center().x()
        half = 0.5 * box.width()
        painter.setPen(QPen(style.color("axis"), 1))
        painter.drawLine(QPointF(middle, box.top() + px(4)), QPointF(middle, box.bottom() - px(4)))
        painter.fillRect(
            QRectF(middle, box.center().y() - px(4), half * row.share, px(8)), style.color("text")
        )
