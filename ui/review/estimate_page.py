"""The chapter Estimate: what is asked for, the run, and the runs that were kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import (
    QApplication,
    QFrame,
    QHBoxLayout,
    QSizePolicy,
    QVBoxLayout,
)

from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import SettingError
from gsapp.identification.axes import AXIS_SURFACES
from ui.commands import CommandRequirement, shortcut_text
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.estimate_form import EstimateForm
from ui.number_format import count_text, join_sentences, plain_shortcut_text
from ui.review.estimate_panel import EstimatePanel
from ui.review.estimate_request import (
    FIELD_HELP,
    EstimateValidator,
    build_run_request,
    field_help_text,
    find_unrestored_settings,
    form_from_request,
    format_maneuver_count,
    is_effect_parameter,
)
from ui.review.estimate_tables import format_last_values
from ui.review.review_steps import ReviewContext, ReviewStepPage
from ui.review.run_store import RunController, RunStore
from ui.review.runs_view import RunsView
from ui.settings import catalog_path
from ui.translation import tr
from ui.undo import UNDO_LIMIT, UndoCommand, UndoHistory, UndoStack
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import ScrollingPage, StackingColumns
from ui.window_frame.page_steps import StepStatus

if TYPE_CHECKING:
    from gsapp.identification.runs.request import SelectedManeuver
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.session.review import Review


def select_maneuvers(
    form: EstimateForm, review: Review, looked_at: str
) -> tuple[SelectedManeuver, ...]:
    """Return the maneuvers that a run would take; `looked_at` is the one that is chosen."""
    if form.maneuvers == "chosen":
        chosen = review.select_maneuvers((looked_at,))
    elif form.maneuvers == "all":
        chosen = review.select_maneuvers([row.id for row in review.rows()])
    else:
        chosen = review.select_maneuvers()
    if form.axis == "both" or form.six_degrees:
        return chosen
    return tuple(one for one in chosen if not set(AXIS_SURFACES[form.axis]).isdisjoint(one.inputs))


def describe_selection(maneuvers: tuple[SelectedManeuver, ...]) -> str:
    """Return what a run would take, in words."""
    flights = len({one.flight for one in maneuvers})
    return f"{format_maneuver_count([one.inputs for one in maneuvers], flights)}."


def describe_empty_selection(form: EstimateForm, review: Review) -> str:
    """Return why a run would take nothing, and what to do."""
    there = tr("on the Maneuvers page ({keys})").format(keys=plain_shortcut_text("Alt+1"))
    if form.maneuvers == "chosen":
        return tr("No maneuver selected: select one {there} or in a figure.").format(there=there)
    if not review.rows():
        return tr("These flights have no maneuvers: add some {there}.").format(there=there)
    if form.axis != "both":
        return tr("No maneuver in use moved a surface of this axis: choose another axis.")
    return tr("No maneuver is in use: check some {there}.").format(there=there)


class EstimateHeader(QFrame):
    """Stays in sight while the settings below it scroll."""

    def __init__(self, run: QAction, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("banner")
        self._column = QVBoxLayout(self)
        self._row = QHBoxLayout()
        self.button = ActionButton(run, tr("Estimate"), style)
        self.button.setProperty("role", "primary")
        self.button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._row.addWidget(self.button, 0, Qt.AlignmentFlag.AlignTop)
        text = QVBoxLayout()
        text.setSpacing(2)
        self.message = FieldMessage()
        self.message.setProperty("role", "")
        text.addWidget(self.message)
        self.explained = create_label("", "muted", wrap=True, remarks_in=style)
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        self.explained.setSizePolicy(policy)
        self.explained.setAlignment(Qt.AlignmentFlag.AlignTop)
        text.addWidget(self.explained)
        self._row.addLayout(text, 1)
        self._column.addLayout(self._row)
        style.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        px = self._style.px
        self._row.setSpacing(px(16))
        self._column.setContentsMargins(px(16), px(8), px(16), px(8))
        self.button.setMinimumHeight(px(44))
        self.button.setMinimumWidth(px(120))
        # Two lines, so that nothing jumps as the keyboard goes from field to field.
        self.explained.setMinimumHeight(2 * self.explained.fontMetrics().height() + px(2))

    def show_field_help(self, field: str) -> None:
        self.explained.setText(f"{tr(FIELD_HELP[field].title)}: {field_help_text(field)}")


class EstimatePage(ReviewStepPage):
    """Settings that explain themselves, one button, and the kept runs."""

    estimated = Signal(object)

    def __init__(self, context: ReviewContext, review: Review) -> None:
        super().__init__(context, tr("Estimate"))
        style, store, report_error = context.style, context.store, context.report_error
        self._review = review
        self._report_error = report_error
        self._checker = EstimateValidator(report_error, self)
        self._message = ""
        self._undo_stack = UndoStack(self)
        self._undo_stack.setUndoLimit(UNDO_LIMIT)
        self._outcome: RunOutcome | None = None
        self._form = store.current.review_estimate
        self.run_store = RunStore(
            lambda: catalog_path(store.current), report_error, self._undo_stack, self
        )
        self._runner = RunController(context.begin_job, self.run_store, self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.head = EstimateHeader(context.actions["review_run"], style)
        self.button, self.message = self.head.button, self.head.message
        column.addWidget(self.head)
        self.area = ScrollingPage()
        self._body = self.area.column
        self._pair = StackingColumns(style, (1, 1))
        self.panel = EstimatePanel(style, self._form)
        self._pair.left.addWidget(self.panel)
        self._pair.left.addStretch(1)
        self.runs = RunsView(context.actions, style, self.run_store)
        self._pair.right.addWidget(self.runs)
        self._body.addWidget(self._pair)
        self._body.addStretch(1)
        column.addWidget(self.area, 1)
        self.panel.changed.connect(self._panel_changed)
        self.panel.field_focused.connect(self.head.show_field_help)
        self.panel.run_requested.connect(self.estimate)
        self._runner.changed.connect(self._run_changed)
        self._runner.estimated.connect(self._estimated)
        self.runs.chosen.connect(self.changed)
        self.runs.opened.connect(self.repeat)
        self.runs.focused.connect(lambda: self.head.show_field_help("runs"))
        context.selection.maneuver_changed.connect(lambda _maneuver: self.refresh())
        style.changed.connect(self._fit)
        self._fit()
        self.head.show_field_help("run")
        self._checker.loaded.connect(self._loaded)
        self.run_store.reload()

    def _fit(self) -> None:
        px = self.display_style.px
        self._body.setContentsMargins(px(16), px(12), px(16), px(16))

    def _loaded(self, models: Sequence[str], weights: Sequence[str]) -> None:
        self.panel.set_file_choices("model", models)
        self.panel.set_file_choices("weights", weights)
        self.refresh()

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "review_run": self.estimate,
            "review_repeat": self.repeat,
            "review_use": self.load_selected_run,
            "review_mark": self.runs.toggle_mark,
            "review_name": self.runs.rename,
            "review_forget": self.runs.remove,
            "review_defaults": self.use_defaults,
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        found: list[CommandRequirement] = ["review_panel"]
        if self.can_run:
            found.append("review_ready")
        if self.runs.current_run is not None:
            found.append("review_run")
        return tuple(found)

    @property
    def can_run(self) -> bool:
        return (
            self._checker.ready
            and not self._runner.running
            and self._checker.problem is None
            and bool(self.selected_maneuvers)
        )

    @property
    def state(self) -> StepStatus:
        if self._runner.running:
            return StepStatus(state="plain", text=tr("running"))
        if self._checker.problem is not None:
            return StepStatus(
                state="warning", text=tr("a setting is wrong"), detail=str(self._checker.problem)
            )
        outcome = self._outcome
        if outcome is None:
            kept = len(self.run_store.runs)
            text = (
                tr("{runs} saved").format(runs=count_text(kept, "run"))
                if kept
                else tr("no run yet")
            )
            return StepStatus(state="plain", text=text)
        count = len(outcome.result.results)
        text = (
            tr("run {number}").format(number=outcome.number)
            if outcome.number is not None
            else tr("not saved")
        )
        detail = f"{text}: {count_text(count, 'maneuver')}"
        return StepStatus(state="plain", text=text, detail=detail)

    @property
    def undo_history(self) -> UndoHistory:
        return self._undo_stack

    def set_initial_focus(self) -> None:
        # Where the button must wait for what it needs, the keyboard waits with it.
        (self.button if self.button.isEnabled() else self).setFocus()
        self.head.show_field_help("run")

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._checker.invalidate()
        self.refresh()

    # What is asked for

    def _panel_changed(self) -> None:
        before, now = self._form, self.panel.form
        if now != before:
            self._apply_form(now)
            self._push(tr("change of a setting"), before, now)
        else:
            self.refresh()

    def _apply_form(self, form: EstimateForm) -> None:
        self._form = form
        self._message = self._runner.status_text = ""
        self._store.change(review_estimate=form.model_dump())
        self.refresh()

    def _show(self, form: EstimateForm) -> None:
        self.panel.show_form(form)
        self._apply_form(form)

    def use_defaults(self) -> None:
        self._replace(EstimateForm())

    def load_selected_run(self) -> None:
        run = self.runs.current_run
        if run is None:
            return
        try:
            request = run.request
            form = form_from_request(request)
            lost = find_unrestored_settings(request, form)
        except GroundStationError as error:
            self._report_error(error)
            return
        self._replace(form)
        rest = (
            tr(", except what this page does not show: {lost}").format(lost=", ".join(lost))
            if lost
            else ""
        )
        self._message = tr("The settings are those of {name}{rest}.").format(
            name=run.name, rest=rest
        )
        self.refresh()

    def _replace(self, form: EstimateForm) -> None:
        before = self._form
        if form != before:
            self._show(form)
            self._push(tr("change of settings"), before, form)
            self.changed.emit()

    def _push(self, text: str, before: EstimateForm, now: EstimateForm) -> None:
        self._undo_stack.push(
            UndoCommand(text, lambda: self._show(before), lambda: self._show(now))
        )

    @property
    def selected_maneuvers(self) -> tuple[SelectedManeuver, ...]:
        if not self._checker.ready:
            return ()
        return select_maneuvers(self._form, self._review, self._selection.maneuver)

    def refresh(self) -> None:
        self._follow_model()
        problem = self._checker.validate(self._form)
        self.panel.show_problem(problem.field if problem else "", str(problem or ""))
        text, state = self._status_message()
        self.message.set_message(text, state)
        self.changed.emit()
        if self.hasFocus() and self.button.isEnabled():
            self.button.setFocus()

    def _follow_model(self) -> None:
        """Offer the parameters of the effects of the model that is chosen."""
        flights = self._review.flights
        if not flights or not self._checker.load_model_effects(
            self._form.model, flights[0].aircraft
        ):
            return
        effects = self._checker.effects
        gone = {n for n in self._form.derivatives if is_effect_parameter(n)} - set(effects)
        self.panel.derivatives.show_effects(effects)
        if gone:
            kept = {n: w for n, w in self._form.derivatives.items() if n not in gone}
            self._form = self._form.with_changes(derivatives=kept)
            self.panel.show_form(self._form)

    def _status_message(self) -> tuple[str, str]:
        if not self._review.flights:
            keys = shortcut_text("Alt+1")
            text = tr("No flight under review: add one on the Maneuvers page ({keys}).").format(
                keys=keys
            )
            return text, "caution"
        if not self._checker.ready:
            return tr("Loading …"), ""
        if self._checker.problem is not None:
            return join_sentences((str(self._checker.problem),)), "warning"
        if self._runner.running:
            return (
                tr("{selection} Running; {keys} stops it.").format(
                    selection=describe_selection(self.selected_maneuvers),
                    keys=shortcut_text("Ctrl+."),
                ),
                "",
            )
        if not self.selected_maneuvers:
            return describe_empty_selection(self._form, self._review), "caution"
        return (
            f"{self._message or self._runner.status_text} "
            f"{describe_selection(self.selected_maneuvers)}".strip(),
            "",
        )

    # Running

    def estimate(self) -> None:
        if not self.can_run:
            field = self._checker.problem.field if self._checker.problem is not None else ""
            self.panel.focus_field(field)
            self.area.ensureWidgetVisible(QApplication.focusWidget() or self.panel)
            return
        try:
            request = build_run_request(
                self._form, self._review.paths, self.selected_maneuvers, self.panel.label.text()
            )
        except SettingError as error:
            self.panel.show_problem(error.field, str(error))
            return
        self._runner.estimate(request)

    def repeat(self) -> None:
        run = self.runs.current_run
        if run is not None:
            self._runner.repeat(run.number)

    def _run_changed(self) -> None:
        if self._runner.running:
            self._message = ""
            if self.button.hasFocus():
                # It grays; the next control would take the next Enter.
                self.setFocus()
        self.refresh()

    def _estimated(self, outcome: RunOutcome) -> None:
        if self.panel.label.text().strip() == outcome.request.label:
            # One that was typed meanwhile is for the next run.
            self.panel.label.clear()
        self.estimated.emit(outcome)

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        self._outcome = outcome
        values = {} if outcome is None else outcome.summary.derivatives
        found = {name: (one.value.mean, one.value.std) for name, one in values.items()}
        self.panel.derivatives.show_last(format_last_values(tuple(found), found))
        self.runs.show_run(None if outcome is None else outcome.number)
