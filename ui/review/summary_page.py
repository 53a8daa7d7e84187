"""Summary of a run: what is known and how well, what to look at, linear models, what to write."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt
from PySide6.QtGui import QAction, QGuiApplication
from PySide6.QtWidgets import QVBoxLayout, QWidget

from gsapp.foundation import GroundStationError
from ui.commands import CommandRequirement
from ui.display_style import DisplayStyle
from ui.number_format import count_text, join_sentences
from ui.review.forms_panel import DerivativeFormsPanel
from ui.review.job_queue import FigureComputations
from ui.review.review_jobs import JobSubmitter
from ui.review.review_steps import ReviewContext, ReviewStepPage, no_run_text
from ui.review.summary_export import SummaryExporter
from ui.review.summary_rows import (
    ATTENTION_TITLES,
    DERIVATIVE_TITLES,
    ERROR_TITLES,
    MODE_TITLES,
    REMARK_COLUMN,
    AttentionItem,
    build_attention_rows,
    build_derivative_rows,
    build_error_rows,
    build_mode_rows,
    describe_comparison,
    describe_derivative,
    format_derivative_table,
)
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import (
    LabeledComboBox,
    ScrollingPage,
    StackingColumns,
    add_widgets,
    create_button_row,
)
from ui.widgets.table_view import FittedTableView
from ui.window_frame.page_steps import StepStatus

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation

_NO_COMPARISON_TEXT = QT_TR_NOOP(
    "Predicts maneuvers with three linear models fitted to other maneuvers (Seanor, section 7.4)."
)


class LinearModelsPanel(QWidget):
    """Modes and errors of the linear models."""

    def __init__(
        self, style: DisplayStyle, actions: Mapping[str, QAction], begin_job: JobSubmitter
    ) -> None:
        super().__init__()
        self._style = style
        self._outcome: RunOutcome | None = None
        self._is_requested = False
        self._needs = FigureComputations(begin_job, self)
        self._needs.changed.connect(self._show_comparison)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.modes = FittedTableView(
            style, tr("Modes of the linear models"), MODE_TITLES, stretch=0,
            widths={1: 84, 2: 80, 3: 124}, right=frozenset({1, 2, 3}), least=2, most=8,
        )  # fmt: skip
        self.no_modes = create_label("", "muted", wrap=True, remarks_in=style)
        self.compared = create_label("", "muted", wrap=True, remarks_in=style)
        self.errors = FittedTableView(
            style, tr("Errors of the linear models"), ERROR_TITLES, stretch=0,
            widths={1: 96, 2: 84, 3: 88}, right=frozenset({1, 2, 3}), least=2, most=16,
        )  # fmt: skip
        self.button = ActionButton(actions["review_compare"], tr("Compare with flight"), style)
        add_widgets(
            self._column,
            create_label(tr("Linear models from the means: modes"), "strong", wrap=True),
            self.modes,
            self.no_modes,
            create_label(tr("Linear models against flight"), "strong", wrap=True),
            self.compared,
            self.errors,
            create_button_row(style, self.button),
        )
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self._column.setSpacing(self._style.px(8))

    @property
    def comparison(self) -> LinearModelValidation | None:
        """Return what came of comparing the models of the run shown; None before."""
        return self._needs.comparison

    def show_outcome(self, outcome: RunOutcome) -> None:
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


_DETAIL_HEIGHT = 92
"""Points of height that words on a derivative take."""
_FULL_TABLE_WIDTH = 1000
"""Points of width of the table below which the columns give way that the detail has, too."""
_OPTIONAL_COLUMNS = (6, 7, 10, 11)


class SummaryPage(ReviewStepPage):
    """Tells what a run gave, and writes it down."""

    def __init__(self, context: ReviewContext) -> None:
        super().__init__(context, tr("Summary"))
        style, selection = context.style, context.selection
        self._outcome: RunOutcome | None = None
        self._accepted: RunOutcome | None = None
        """Whose vanes the aircraft file states by now."""
        self.linear = LinearModelsPanel(style, context.actions, context.begin_job)
        self.forms = DerivativeFormsPanel(style)
        self.writer = SummaryExporter(context.store, context.begin_job, self)
        self.writer.status_reported.connect(self._show_message)
        self._build()
        selection.maneuver_changed.connect(self._maneuver_chosen)
        selection.derivative_changed.connect(self._derivative_chosen)
        style.changed.connect(self._restyle)
        self._restyle()
        self.show_outcome(None)

    # Making

    def _build(self) -> None:
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        self._area = ScrollingPage()
        outer.addWidget(self._area)
        self._column = self._area.column
        self.headline = create_label("", "heading", wrap=True, remarks_in=self.display_style)
        self.validity = create_label("", wrap=True, remarks_in=self.display_style)
        self.validity.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._pair = StackingColumns(self.display_style, (8, 5))
        add_widgets(self._column, self.headline, self.validity, self._pair)
        self._column.addStretch(1)
        self._derivatives()
        self._pair.left.addWidget(self.forms)
        self._pair.left.addStretch(1)
        self._attention()
        self._writing()
        self._pair.right.addWidget(self.linear)
        self._pair.right.addStretch(1)

    def _derivatives(self) -> None:
        self.table = FittedTableView(
            self.display_style, tr("Derivatives"), DERIVATIVE_TITLES, stretch=REMARK_COLUMN,
            widths={0: 62, 1: "−0.000123", 2: "0.000012", 3: "0.000012", 4: 84, 5: 84, 6: 60,
                    7: "0.000123", 8: 70, 9: 30, 10: 38, 11: 66},
            right=frozenset(range(1, REMARK_COLUMN)), least=6, most=40,
            title_details={0: tr("Derivative"), 6: tr("Bound in percent of the mean")},
        )  # fmt: skip
        self.table.selectionModel().currentRowChanged.connect(lambda *_: self._row_chosen())
        self.table.opened.connect(lambda _key: self._actions["review_figures"].trigger())
        self.table.installEventFilter(self)
        self.detail = create_label("", wrap=True, remarks_in=self.display_style)
        self.detail.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.detail.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        heading = create_label(tr("Derivatives, per radian"), "strong")
        add_widgets(self._pair.left, heading, self.table)
        heading = create_label(tr("Selected derivative"), "strong")
        add_widgets(self._pair.right, heading, self.detail)

    def _attention(self) -> None:
        self.attention_heading = create_label(tr("Needs attention"), "strong")
        self.attention = FittedTableView(
            self.display_style, tr("Remarks"), ATTENTION_TITLES, stretch=2, widths={0: 72,
            1: 120},
            least=2, most=12,
        )  # fmt: skip
        self.attention.selectionModel().currentRowChanged.connect(
            lambda *_: self._select_attention_item()
        )
        self.attention.opened.connect(lambda _key: self._actions["review_maneuvers"].trigger())
        self.instruments = create_label("", "caution", wrap=True, remarks_in=self.display_style)
        self.update_aircraft = ActionButton(
            self._actions["review_update_aircraft"],
            tr("Update aircraft file"),
            self.display_style,
        )
        add_widgets(
            self._pair.right,
            self.attention_heading,
            self.attention,
            self.instruments,
            create_button_row(self.display_style, self.update_aircraft),
        )

    def _writing(self) -> None:
        style, actions = self.display_style, self._actions
        self.file = LabeledComboBox(style, tr("One file"), letters=24)
        self.buttons = {
            name: ActionButton(actions[name], text, style)
            for name, text in (
                ("review_report", tr("Report…")),
                ("review_everything", tr("Everything in a folder…")),
                ("review_copy", tr("Copy the table")),
                ("review_file", tr("Write it…")),
                ("review_open_written", tr("Open it")),
            )
        }
        self.buttons["review_report"].setProperty("role", "primary")
        self.message = create_label("", "muted", wrap=True)
        self.message.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        first = ("review_report", "review_everything", "review_copy")
        add_widgets(
            self._pair.right,
            create_label(tr("Export"), "strong"),
            create_button_row(style, *(self.buttons[name] for name in first)),
            create_button_row(style, self.file, self.buttons["review_file"]),
            self.message,
            create_button_row(style, self.buttons["review_open_written"]),
        )
        self.message.hide()
        self.buttons["review_open_written"].hide()

    def _restyle(self) -> None:
        gap = self.display_style.px(16)
        # Words of another length must not push about what stands below.
        self.detail.setMinimumHeight(self.display_style.px(_DETAIL_HEIGHT))
        self._column.setContentsMargins(
            self.display_style.px(24), gap, self.display_style.px(24), gap
        )
        self._column.setSpacing(self.display_style.px(8))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.table and event.type() == QEvent.Type.Resize:
            self._fit()
        return super().eventFilter(watched, event)

    def _fit(self) -> None:
        narrow = self.table.width() < self.display_style.px(_FULL_TABLE_WIDTH)
        for column in _OPTIONAL_COLUMNS:
            if self.table.isColumnHidden(column) != narrow:
                self.table.setColumnHidden(column, narrow)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "review_report": self._export_report,
            "review_everything": partial(self._export_report, everything=True),
            "review_file": self._export_file,
            "review_open_written": self.writer.open_written,
            "review_copy": self.copy_table,
            "review_update_aircraft": self._update_aircraft_file,
            "review_compare": self.linear.compare,
        }

    def _export_report(self, *, everything: bool = False) -> None:
        units, linear = self.display_style.units, self.linear.comparison
        if self._outcome is not None:
            self.writer.export_report(self._outcome, units, linear, everything=everything)

    def _export_file(self) -> None:
        if self._outcome is not None:
            self.writer.export_file(self._outcome, self.file.current_key, self.linear.comparison)

    def _update_aircraft_file(self) -> None:
        from gsapp.identification.runs.run_execution import accept_instruments

        if self._outcome is None:
            return
        try:
            files = accept_instruments(self._outcome)
        except (GroundStationError, OSError) as error:
            self.instruments.setText(join_sentences((str(error),)))
            return
        self._accepted = self._outcome
        names = ", ".join(str(one) for one in files)
        self.instruments.setText(tr("Instruments updated in {names}.").format(names=names))
        self.changed.emit()

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        found: list[CommandRequirement] = []
        if self._outcome is not None:
            found.append("review_results")
            if self._outcome.sensor_values and self._outcome is not self._accepted:
                found.append("review_instruments")
        if self.writer.written is not None:
            found.append("review_written")
        return tuple(found)

    @property
    def state(self) -> StepStatus:
        if self._outcome is None:
            return StepStatus(state="unknown")
        wild = len(self._outcome.summary.outlying_maneuvers)
        if wild:
            return StepStatus(state="caution", text=count_text(wild, "outlying maneuver"))
        earned = [name for name in self._outcome.summary.derivatives if not name.endswith("_0")]
        return StepStatus(state="plain", text=count_text(len(earned), "derivative"))

    def copy_table(self) -> None:
        if self._outcome is not None:
            QGuiApplication.clipboard().setText(format_derivative_table(self._outcome))
            self._show_message(tr("The table is on the clipboard."))

    # Showing

    def set_initial_focus(self) -> None:
        self.table.setFocus()
        if not self.table.currentIndex().isValid() and self.table.row_model.rows:
            self.table.setCurrentIndex(self.table.row_model.index(0, 0))

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        self._outcome = outcome
        self._pair.setVisible(outcome is not None)
        self.validity.setVisible(outcome is not None)
        if outcome is None:
            self.headline.setText(no_run_text(tr("its results are summarized here.")))
            return
        from gsapp.report.estimate_export import FILE_TITLES, file_names
        from gsapp.report.estimate_text import (
            bound_consistency_text,
            estimate_headline,
            exclusion_text,
        )
        from gsapp.report.residual_text import residual_text

        kept = "" if outcome.number is None else tr("Run {number}: ").format(number=outcome.number)
        self.headline.setText(f"{kept}{estimate_headline(outcome.summary, outcome.result)}")
        remarks = (bound_consistency_text(outcome.summary), *residual_text(outcome.result))
        self.validity.setText(" ".join((*remarks, *exclusion_text(outcome.summary))))
        with QSignalBlocker(self.table.selectionModel()):
            self.table.show_rows(build_derivative_rows(outcome))
        with QSignalBlocker(self.attention.selectionModel()):
            lines = build_attention_rows(outcome)
            self.attention.show_rows(lines)
        self.attention.setVisible(bool(lines))
        self.instruments.setText(join_sentences(one.text for one in outcome.instruments))
        self.instruments.setVisible(bool(outcome.instruments))
        self.update_aircraft.setVisible(bool(outcome.sensor_values))
        self.attention_heading.setText(
            tr("Needs attention") if lines or outcome.instruments else tr("Nothing needs attention")
        )
        self.linear.show_outcome(outcome)
        self.forms.show_outcome(outcome)
        names = [name for name in file_names(outcome) if name in FILE_TITLES]
        self.file.set_choices([(name, FILE_TITLES[name]) for name in names], self.file.current_key)
        self._derivative_chosen(self._selection.derivative)
        self._maneuver_chosen(self._selection.maneuver)
        self._show_detail(self._selection.derivative)
        self.changed.emit()

    def _show_message(self, text: str) -> None:
        self.message.setText(text)
        self.message.setVisible(bool(text))
        self.buttons["review_open_written"].setVisible(self.writer.written is not None)
        self.changed.emit()

    # What is looked at

    def _row_chosen(self) -> None:
        key = self.table.current_key()
        if isinstance(key, str):
            self._show_detail(key)
            self._selection.select_derivative(key)

    def _show_detail(self, derivative: str) -> None:
        outcome = self._outcome
        text = describe_derivative(outcome, derivative) if outcome and derivative else ""
        self.detail.setText(text or tr("Choose a derivative in the table."))

    def _select_attention_item(self) -> None:
        key = self.attention.current_key()
        if isinstance(key, AttentionItem):
            self._selection.select_maneuver(key.maneuver)
            if key.derivative:
                self._selection.select_derivative(key.derivative)

    def _derivative_chosen(self, derivative: str) -> None:
        if self.table.current_key() != derivative:
            self.table.select_row(derivative)

    def _maneuver_chosen(self, maneuver: str) -> None:
        current = self.attention.current_key()
        if isinstance(current, AttentionItem) and current.maneuver == maneuver:
            return
        for line in self.attention.row_model.rows:
            if isinstance(line.key, AttentionItem) and line.key.maneuver == maneuver:
                with QSignalBlocker(self.attention.selectionModel()):
                    self.attention.select_row(line.key)
                return
