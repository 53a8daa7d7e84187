"""Linear models of a run: their modes, and on demand how well they follow what they never saw."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.number_format import join_sentences
from ui.review.figure_computations import FigureComputations
from ui.review.review_jobs import JobSubmitter
from ui.review.summary_rows import (
    ERROR_TITLES,
    MODE_TITLES,
    build_error_rows,
    build_mode_rows,
    describe_comparison,
)
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import create_button_row
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation

_NO_COMPARISON_TEXT = QT_TR_NOOP(
    "Predicts maneuvers with three linear models fitted to other maneuvers (Seanor, section 7.4)."
)


class LinearModelsPanel(QWidget):
    """Modes and errors of the linear models.

    Parameters
    ----------
    look : DisplayStyle
        Sizes.
    actions : mapping of str to QAction
        The commands.
    begin_job : JobSubmitter
        Has the models compared in a process.
    """

    def __init__(
        self, look: DisplayStyle, actions: Mapping[str, QAction], begin_job: JobSubmitter
    ) -> None:
        super().__init__()
        self._look = look
        self._outcome: RunOutcome | None = None
        self._is_requested = False
        self._needs = FigureComputations(begin_job, self)
        self._needs.changed.connect(self._show_comparison)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.modes = FittedTableView(
            look, tr("Modes of the linear models"), MODE_TITLES, stretch=0,
            widths={1: 84, 2: 80, 3: 124}, right=frozenset({1, 2, 3}), least=2, most=8,
        )  # fmt: skip
        self.no_modes = create_label("", "muted", wrap=True, remarks_in=look)
        self.compared = create_label("", "muted", wrap=True, remarks_in=look)
        self.errors = FittedTableView(
            look, tr("Errors of the linear models"), ERROR_TITLES, stretch=0,
            widths={1: 96, 2: 84, 3: 88}, right=frozenset({1, 2, 3}), least=2, most=16,
        )  # fmt: skip
        self.button = ActionButton(actions["review_compare"], tr("Compare with flight"), look)
        for widget in (
            create_label(tr("Linear models from the means: modes"), "strong", wrap=True),
            self.modes,
            self.no_modes,
            create_label(tr("Linear models against flight"), "strong", wrap=True),
            self.compared,
            self.errors,
            create_button_row(look, self.button),
        ):
            self._column.addWidget(widget)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self._column.setSpacing(self._look.px(8))

    @property
    def comparison(self) -> LinearModelValidation | None:
        """Return what came of comparing the models of the run shown; None before."""
        return self._needs.comparison

    def show_outcome(self, outcome: RunOutcome) -> None:
        """Show the models of a run."""
        if outcome is not self._outcome:
            self._outcome = outcome
            self._is_requested = False
            self._needs.reset(outcome)
        self.modes.show_rows(build_mode_rows(outcome))
        self.modes.setVisible(bool(outcome.models))
        why_not = [text for text in outcome.remarks if text.startswith("no linear")]
        if not why_not and not outcome.models:
            why_not = [tr("no maneuver moved the surfaces of an axis")]
        self.no_modes.setText(join_sentences(why_not))
        self.no_modes.setVisible(bool(why_not))
        self._show_comparison()

    def compare(self) -> None:
        """Have the models compared with flight, once for each run."""
        self._is_requested = True
        self._needs.allow_retry()
        self._show_comparison()

    def _show_comparison(self) -> None:
        outcome, comparison = self._outcome, self._needs.comparison
        if outcome is None:
            return
        if comparison is not None:
            self.compared.setText(describe_comparison(comparison))
            self.errors.show_rows(build_error_rows(comparison))
        elif self._is_requested:
            self.compared.setText(self._needs.request("comparison", outcome))
        else:
            self.compared.setText(tr(_NO_COMPARISON_TEXT))
        self.errors.setVisible(comparison is not None and bool(comparison.axes))
        self.button.setVisible(comparison is None)
