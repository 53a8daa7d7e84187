"""The curve as it forms: points and curve, and beside them how far the points lie off it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pyqtgraph
from PySide6.QtWidgets import QHBoxLayout, QWidget

from calibration.points import DIRECTION_TEXT, Direction
from calibration.polynomial_fit import evaluate_polynomial
from gsapp.quantities import FloatArray, trace_color
from ui.display_style import DisplayStyle
from ui.number_format import unit_text
from ui.translation import tr
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
    """Two charts over volts that share what they are drawn from.

    Parameters
    ----------
    look : DisplayStyle
        Colors and sizes.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._drawn: object = None
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(look.px(8))
        self.curve = AnalysisPlot(look, tr("Calibration curve"), high=170)
        self.residuals = AnalysisPlot(look, tr("Residuals"), high=170)
        row.addWidget(self.curve, 1)
        row.addWidget(self.residuals, 1)
        self._here = pyqtgraph.InfiniteLine(angle=90, movable=False)

    def show_view(self, view: WizardView) -> None:
        """Draw the points and the curve of a view, if they are others; move the line of now."""
        state = (
            view.instrument, view.points, view.calibration, view.check_result, self._look.theme.name
        )  # fmt: skip
        if state != self._drawn:
            self._drawn = state
            self._draw(view)
            self._here.setPen(pyqtgraph.mkPen(curve_color(self._look, "cursor"), width=1))
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
        words = tr("{count} points").format(count=len(view.points))
        self.curve.draw(
            curves,
            title=tr("Calibration curve"),
            bottom=tr("Volts"),
            left=tr("Angle [{unit}]").format(unit=unit),
            words=words,
        )
        self.residuals.draw(
            off,
            title=tr("Residuals"),
            bottom=tr("Volts"),
            left=tr("Off [{unit}]").format(unit=unit),
            words=words,
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
    """Return x and y of the points of each way."""
    return [
        (
            np.array([x for x, _, known in points if known == way]),
            np.array([y for _, y, known in points if known == way]),
        )
        for way, *_ in _DIRECTION_SYMBOLS
    ]
