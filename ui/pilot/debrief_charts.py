"""A maneuver as small charts: what its surfaces did, within what was wanted, and the answer."""

from __future__ import annotations

from typing import Final

from PySide6.QtWidgets import QGridLayout, QWidget

from gsapp.excitation.debrief_maneuver import JudgedManeuver
from gsapp.flight.cards.card import SURFACES
from gsapp.quantities import FloatArray, channel, from_si, trace_color
from ui.gap.chart import FLIGHT_TIME, Band, Chart, Curve
from ui.look import Look
from ui.words import symbol_text, unit_text

_MOST: Final = 2
"""Surfaces that are drawn; no input moves more of them on purpose."""
_RATES: Final = ("p", "q", "r")
_HIGH: Final = 150


class ManeuverCharts(QWidget):
    """The charts of one maneuver.

    Parameters
    ----------
    look : Look
        Colors, sizes, units.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self.surfaces = [Chart(look, f"Surface {place + 1}", high=_HIGH) for place in range(_MOST)]
        self.answer = Chart(look, "Response", high=_HIGH)
        for place, chart in enumerate(self.surfaces):
            self._grid.addWidget(chart, 0, place)
        self._grid.addWidget(self.answer, 1, 0, 1, _MOST)

    def show_maneuver(self, judged: JudgedManeuver) -> None:
        """Draw another maneuver."""
        self._grid.setSpacing(self._look.px(8))
        shown = [name for name in judged.verdict.surfaces if name in judged.curves.series]
        for chart, name in zip(self.surfaces, (*shown, "", ""), strict=False):
            chart.setVisible(bool(name))
            if name:
                self._draw_surface(chart, judged, name)
        self._draw_answer(judged)

    def _draw_surface(self, chart: Chart, judged: JudgedManeuver, name: str) -> None:
        values = judged.curves.series[name]
        moved = self._shown(name, values - values[0])
        bands = []
        wanted = None if judged.wanted is None else judged.wanted.amplitudes.get(name)
        if wanted is not None:
            low, high = (float(self._shown(name, end)) for end in (wanted.low, wanted.high))
            bands = [
                Band(low=low, high=high, name="wanted", wanted=True),
                Band(low=-high, high=-low, wanted=True),
            ]
        title = SURFACES.get(name, name).capitalize()
        curve = Curve(x=judged.curves.times, y=moved, color=trace_color(name), name="moved")
        chart.draw(
            [curve],
            [*bands, self._hands_off(judged)],
            title=title,
            bottom=FLIGHT_TIME,
            left=f"From trim [{self._unit(name)}]",
            words=f"{title} of {judged.verdict.id}",
        )

    def _draw_answer(self, judged: JudgedManeuver) -> None:
        names = [name for name in _RATES if name in judged.curves.series]
        curves = [
            Curve(
                x=judged.curves.times,
                y=self._shown(name, judged.curves.series[name]),
                color=trace_color(name),
                name=symbol_text(channel(name).symbol),
            )
            for name in names
        ]
        unit = self._unit("q")
        self.answer.draw(
            curves,
            [self._hands_off(judged)],
            title="Response" if curves else "Response not measured",
            bottom=FLIGHT_TIME,
            left=f"Rate [{unit}]",
            words=f"Rates of {judged.verdict.id}",
        )

    def _hands_off(self, judged: JudgedManeuver) -> Band:
        verdict = judged.verdict
        return Band(
            low=verdict.t_input_end,
            high=verdict.t_end,
            name="hands off",
            across=False,
        )

    def _unit(self, name: str) -> str:
        return unit_text(channel(name).display_unit(self._look.units))

    def _shown(self, name: str, values: FloatArray | float) -> FloatArray:
        spec = channel(name)
        return from_si(values, spec.display_unit(self._look.units), spec.quantity)
