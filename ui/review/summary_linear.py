"""Linear models of a run: their modes, and on demand how well they follow what they never saw."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.flight.controls import ActionButton
from ui.gap.parts import Lines, button_row
from ui.look import Look
from ui.pages import label
from ui.review.figures_needs import FigureNeeds
from ui.review.jobs import BeginJob
from ui.review.summary_lines import (
    ERROR_TITLES,
    MODE_TITLES,
    comparison_words,
    error_lines,
    mode_lines,
)
from ui.words import sentences

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome
    from gsapp.identification.summary.linear_comparison import LinearComparison

_NO_COMPARISON = (
    "Predicts maneuvers with three linear models fitted to other maneuvers (Seanor, WVU "
    "dissertation, section 7.4)."
)


class LinearPanel(QWidget):
    """Modes and errors of the linear models.

    Parameters
    ----------
    look : Look
        Sizes.
    actions : mapping of str to QAction
        The commands.
    begin_job : BeginJob
        Has the models compared in a process.
    """

    def __init__(self, look: Look, actions: Mapping[str, QAction], begin_job: BeginJob) -> None:
        super().__init__()
        self._look = look
        self._outcome: Outcome | None = None
        self._wanted = False
        self._needs = FigureNeeds(begin_job, self)
        self._needs.changed.connect(self._show_comparison)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.modes = Lines(
            look, "Modes of the linear models", MODE_TITLES, stretch=0,
            widths={1: 84, 2: 80, 3: 124}, right=frozenset({1, 2, 3}), least=2, most=8,
        )  # fmt: skip
        self.no_modes = label("", "muted", wrap=True, remarks_in=look)
        self.compared = label("", "muted", wrap=True, remarks_in=look)
        self.errors = Lines(
            look, "Errors of the linear models", ERROR_TITLES, stretch=0,
            widths={1: 96, 2: 84, 3: 88}, right=frozenset({1, 2, 3}), least=2, most=16,
        )  # fmt: skip
        self.button = ActionButton(actions["review_compare"], "Compare with flight", look)
        for widget in (
            label("Linear models made from the means: modes", "strong", wrap=True),
            self.modes,
            self.no_modes,
            label("Linear models against flight", "strong", wrap=True),
            self.compared,
            self.errors,
            button_row(look, self.button),
        ):
            self._column.addWidget(widget)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self._column.setSpacing(self._look.px(8))

    @property
    def comparison(self) -> LinearComparison | None:
        """Return what came of comparing the models of the run shown; None before."""
        return self._needs.comparison

    def show_outcome(self, outcome: Outcome) -> None:
        """Show the models of a run."""
        if outcome is not self._outcome:
            self._outcome = outcome
            self._wanted = False
            self._needs.forget(outcome)
        self.modes.show_lines(mode_lines(outcome))
        self.modes.setVisible(bool(outcome.models))
        why_not = [text for text in outcome.remarks if text.startswith("no linear")]
        if not why_not and not outcome.models:
            why_not = ["no maneuver moved the surfaces of an axis"]
        self.no_modes.setText(sentences(why_not))
        self.no_modes.setVisible(bool(why_not))
        self._show_comparison()

    def compare(self) -> None:
        """Have the models compared with flight, once for each run."""
        self._wanted = True
        self._needs.again()
        self._show_comparison()

    def _show_comparison(self) -> None:
        outcome, comparison = self._outcome, self._needs.comparison
        if outcome is None:
            return
        if comparison is not None:
            self.compared.setText(comparison_words(comparison))
            self.errors.show_lines(error_lines(comparison))
        elif self._wanted:
            self.compared.setText(self._needs.ask("comparison", outcome))
        else:
            self.compared.setText(_NO_COMPARISON)
        self.errors.setVisible(comparison is not None and bool(comparison.axes))
        self.button.setVisible(comparison is None)
