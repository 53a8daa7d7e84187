"""The search for a missing effect in flight: its switch, and evidence over the maneuvers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QPushButton, QVBoxLayout, QWidget

from gsapp.quantities import TRACE_COLORS, typeset
from ui.display_style import DisplayStyle
from ui.number_format import count_text
from ui.translation import tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label

if TYPE_CHECKING:
    from gsapp.discrepancy.results import DecidingExperiment
    from gsapp.session.live_estimation.live_search import LiveSearch, LiveSearchResult
    from ui.widgets.analysis_plot import AnalysisPlot, PlotCurve

_MOST_EFFECTS = 4
_MIN_EVIDENCE = 0.02  # Of an effect worth a line beside the likeliest.


def search_status_text(search: LiveSearch, units: str) -> str:
    """Return how the search stands and what to fly next, in words."""
    if not search.enabled:
        return ""
    if search.error_text:
        return tr("The search failed: {error}").format(error=search.error_text)
    last = search.steps[-1] if search.steps else None
    parts = []
    if last is not None:
        searched = count_text(last.maneuvers, "maneuver")
        parts.append(f"{searched}: {typeset(last.why)}")
        if last.unconfirmed:
            parts.append(
                tr("Not yet confirmed by further maneuvers: {effects}").format(
                    effects="; ".join(last.titles.get(one, one) for one in last.unconfirmed)
                )
            )
        if last.experiment is not None:
            from gsapp.report.discrepancy_text import experiment_text  # as the plot below

            parts.append(experiment_text(last.experiment, units))
    if search.is_running:
        parts.append(tr("Searching…"))
    return "\n".join(parts) or tr("Begins with the first maneuver.")


class EvidencePanel(QWidget):
    """Which effect is missing, by the maneuvers so far."""

    switched = Signal(bool)
    cards_requested = Signal(object)  # The test cards of the experiment that decides.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._steps: Sequence[LiveSearchResult] = ()
        self._experiment: DecidingExperiment | None = None
        column = arrange(QVBoxLayout(self), 4)
        column.setContentsMargins(12, 4, 12, 8)
        self._column = column
        self.switch = QCheckBox(tr("Search for missing effects"))
        self.switch.setToolTip(tr("After each maneuver, in a separate process at low priority"))
        self.switch.toggled.connect(self.switched)
        column.addWidget(self.switch)
        self.state = create_label("", "label", wrap=True)
        column.addWidget(self.state)
        self.cards_button = QPushButton(tr("Add to test cards"))
        self.cards_button.setToolTip(tr("Put these maneuvers before all other test cards"))
        self.cards_button.clicked.connect(self._request_cards)
        self.cards_button.setVisible(False)
        column.addWidget(self.cards_button, 0, Qt.AlignmentFlag.AlignLeft)
        self.plot: AnalysisPlot | None = None

    def show_search(self, steps: Sequence[LiveSearchResult], state: str, *, enabled: bool) -> None:
        """Show what searches gave, and a line on how they stand."""
        if self.switch.isChecked() != enabled:
            self.switch.blockSignals(True)
            self.switch.setChecked(enabled)
            self.switch.blockSignals(False)
        if self.state.text() != state:
            self.state.setText(state)
        self.state.setVisible(bool(state))
        self._experiment = steps[-1].experiment if steps and enabled else None
        self.cards_button.setVisible(self._experiment is not None and bool(self._experiment.cards))
        drawn = [one for one in steps if one.verdict] if enabled else []
        if drawn:
            self._draw(drawn)
        if self.plot is not None:
            self.plot.setVisible(bool(drawn))

    def _request_cards(self) -> None:
        if self._experiment is not None:
            self.cards_requested.emit(self._experiment.cards)

    def _draw(self, steps: Sequence[LiveSearchResult]) -> None:
        if self.plot is not None and self._steps == steps:
            return
        self._steps = steps
        if self.plot is None:
            from ui.widgets.analysis_plot import AnalysisPlot  # the window starts without it

            self.plot = AnalysisPlot(self._style, tr("Evidence"))
            self._column.addWidget(self.plot)
        self.plot.draw(
            evidence_curves(steps),
            title=tr("Evidence"),
            bottom=tr("maneuvers"),
            left=tr("probability, %"),
        )


def evidence_curves(steps: Sequence[LiveSearchResult]) -> list[PlotCurve]:
    """Return the probability of the likeliest effects over the number of maneuvers."""
    from ui.widgets.analysis_plot import PlotCurve

    now = steps[-1].evidence
    likely = [name for name, share in now.items() if share > _MIN_EVIDENCE]
    effects = (likely or list(now)[:1])[:_MOST_EFFECTS]
    counts = np.array([one.maneuvers for one in steps], dtype=np.float64)
    return [
        PlotCurve(
            x=counts,
            y=np.array([100.0 * one.evidence.get(name, 0.0) for one in steps]),
            color=color,
            name=name,
            points=len(steps) == 1,
        )
        for name, color in zip(effects, TRACE_COLORS, strict=False)
    ]
