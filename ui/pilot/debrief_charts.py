"""A maneuver as small charts: what its surfaces did, within what was wanted, and the response."""

from __future__ import annotations

from typing import Final

import numpy as np
from PySide6.QtWidgets import QGridLayout, QWidget

from gsapp.excitation.debrief import EvaluatedManeuver
from gsapp.quantities import SURFACE_NAMES, FloatArray, channel, from_si, trace_color
from ui.display_style import DisplayStyle
from ui.number_format import symbol_text, unit_text
from ui.translation import tr
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve

_MAX_SURFACES: Final = 2
"""Surfaces that are drawn; no input moves more of them on purpose."""
_RATE_CHANNELS: Final = ("p", "q", "r")
_MIN_CHART_HEIGHT: Final = 150


class ManeuverCharts(QWidget):
    """The charts of one maneuver.

    Parameters
    ----------
    look : DisplayStyle
        Colors, sizes, units.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self.surfaces = [
            AnalysisPlot(
                look, tr("Surface {place}").format(place=place + 1), high=_MIN_CHART_HEIGHT
            )
            for place in range(_MAX_SURFACES)
        ]
        self.response = AnalysisPlot(look, tr("Response"), high=_MIN_CHART_HEIGHT)
        for place, chart in enumerate(self.surfaces):
            self._grid.addWidget(chart, 0, place)
        self._grid.addWidget(self.response, 1, 0, 1, _MAX_SURFACES)

    def show_maneuver(self, judged: EvaluatedManeuver) -> None:
        """Draw another maneuver."""
        self._grid.setSpacing(self._look.px(8))
        shown = [name for name in judged.verdict.surfaces if name in judged.curves.series]
        for chart, name in zip(self.surfaces, (*shown, "", ""), strict=False):
            chart.setVisible(bool(name))
            if name:
                self._draw_surface(chart, judged, name)
        self._draw_response(judged)

    def _draw_surface(self, chart: AnalysisPlot, judged: EvaluatedManeuver, name: str) -> None:
        values = judged.curves.series[name]
        moved = self._to_display(name, values - values[0])
        bands = []
        wanted = None if judged.target_input is None else judged.target_input.amplitudes.get(name)
        if wanted is not None:
            low, high = self._to_display(name, np.array([wanted.low, wanted.high])).tolist()
            bands = [
                PlotBand(low=low, high=high, name=tr("wanted"), is_target=True),
                PlotBand(low=-high, high=-low, is_target=True),
            ]
        title = SURFACE_NAMES.get(name, name).capitalize()
        curve = PlotCurve(x=judged.curves.times, y=moved, color=trace_color(name), name=tr("moved"))
        chart.draw(
            [curve],
            [*bands, self._hands_off(judged)],
            title=title,
            bottom=FLIGHT_TIME_LABEL,
            left=tr("From trim [{unit}]").format(unit=self._unit(name)),
            words=tr("{title} of {id}").format(title=title, id=judged.verdict.id),
        )

    def _draw_response(self, judged: EvaluatedManeuver) -> None:
        names = [name for name in _RATE_CHANNELS if name in judged.curves.series]
        curves = [
            PlotCurve(
                x=judged.curves.times,
                y=self._to_display(name, judged.curves.series[name]),
                color=trace_color(name),
                name=symbol_text(channel(name).symbol),
            )
            for name in names
        ]
        unit = self._unit("q")
        self.response.draw(
            curves,
            [self._hands_off(judged)],
            title=tr("Response") if curves else tr("Response not measured"),
            bottom=FLIGHT_TIME_LABEL,
            left=tr("Rate [{unit}]").format(unit=unit),
            words=tr("Rates of {id}").format(id=judged.verdict.id),
        )

    def _hands_off(self, judged: EvaluatedManeuver) -> PlotBand:
        verdict = judged.verdict
        return PlotBand(
            low=verdict.t_input_end,
            high=verdict.t_end,
            name=tr("hands off"),
            is_horizontal=False,
        )

    def _unit(self, name: str) -> str:
        return unit_text(channel(name).display_unit(self._look.units))

    def _to_display(self, name: str, values: FloatArray) -> FloatArray:
        spec = channel(name)
        return from_si(values, spec.display_unit(self._look.units), spec.quantity)
