"""The chapter Estimate: what is asked for, the run, and the runs that were kept."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.foundation import GroundStationError
from ui.commands import Need
from ui.dialogs.form import Sentence
from ui.flight.controls import ActionButton
from ui.frame.steps import StepState
from ui.gap.parts import Pair
from ui.look import Look
from ui.pages import label
from ui.review.deeds import Deeds
from ui.review.estimate_asking import (
    FieldError,
    effect_parameters,
    is_effect,
    problem_of,
    run_request,
    unheld,
    wishes_of,
)
from ui.review.estimate_panel import EstimatePanel
from ui.review.estimate_table import last_values
from ui.review.estimate_wishes import Wishes
from ui.review.estimate_words import EXPLAINED, maneuver_count
from ui.review.jobs import NOT_KEPT, BeginJob, EstimateJob, RepeatJob
from ui.review.page import ReviewPage
from ui.review.runs_book import RunsBook
from ui.review.runs_view import RunsView
from ui.review.selection import Selection
from ui.settings import SettingsStore, catalog_path
from ui.words import sentences
from ui.work import CancelledError, Progress, Work

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome
    from gsapp.identification.runs.repeating import Repeated
    from gsapp.identification.runs.request import ChosenManeuver
    from gsapp.session.review import Review


class EstimatePage(ReviewPage):
    """Settings that explain themselves, one button, and the kept runs.

    Parameters
    ----------
    actions : mapping of str to QAction
        The commands.
    look : Look
        Colors, sizes, units.
    store : SettingsStore
        Remembers the settings.
    selection : Selection
        The maneuver that is looked at.
    review : Review
        The flights with their maneuvers.
    begin_job : BeginJob
        Has a run done.
    report_error : callable
        Where errors go.

    Attributes
    ----------
    estimated : Signal(object)
        An `Outcome` is there.
    """

    estimated = Signal(object)

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: Look,
        store: SettingsStore,
        selection: Selection,
        review: Review,
        begin_job: BeginJob,
        report_error: Callable[[BaseException], None],
    ) -> None:
        super().__init__(look, "Estimate")
        self._actions = actions
        self._store = store
        self._selection = selection
        self._review = review
        self._begin_job = begin_job
        self._report_error = report_error
        self._ready = False
        self._running = False
        self._problem: FieldError | None = None
        self._judged: Wishes | None = None
        self._followed = ""
        self._kept_before: set[int] | None = None
        self._told = ""
        self._deeds = Deeds()
        self._outcome: Outcome | None = None
        self._wishes = store.current.review_estimate
        self.book = RunsBook(lambda: catalog_path(store.current), report_error, self._deeds, self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self._head())
        area = QScrollArea()
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidgetResizable(True)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        page = QWidget()
        page.setObjectName("page")
        self._body = QVBoxLayout(page)
        self._pair = Pair(look, (1, 1))
        self.panel = EstimatePanel(look, self._wishes)
        self._pair.left.addWidget(self.panel)
        self._pair.left.addStretch(1)
        self.runs = RunsView(actions, look, self.book)
        self._pair.right.addWidget(self.runs)
        self._body.addWidget(self._pair)
        self._body.addStretch(1)
        area.setWidget(page)
        self.area = area
        column.addWidget(area, 1)
        self.panel.changed.connect(self._wished)
        self.panel.explained.connect(self.explain)
        self.panel.asked.connect(self.estimate)
        self.book.changed.connect(self._runs_read)
        self.runs.chosen.connect(self.changed)
        self.runs.opened.connect(self.repeat)
        self.runs.focused.connect(lambda: self.explain("runs"))
        selection.maneuver_changed.connect(lambda _maneuver: self.refresh())
        look.changed.connect(self._fit)
        self._fit()
        self.explain("run")
        self._load()
        self.book.read()

    def _head(self) -> QWidget:
        head = QFrame()
        head.setObjectName("banner")
        self._top = QVBoxLayout(head)
        row = QHBoxLayout()
        self.button = ActionButton(self._actions["review_run"], "Estimate", self.look)
        self.button.setProperty("role", "primary")
        self.button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        row.addWidget(self.button, 0, Qt.AlignmentFlag.AlignTop)
        words = QVBoxLayout()
        words.setSpacing(2)
        self.sentence = Sentence()
        self.sentence.setProperty("role", "")
        words.addWidget(self.sentence)
        self.explained = label("", "muted", wrap=True)
        self.explained.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self.explained.setAlignment(Qt.AlignmentFlag.AlignTop)
        words.addWidget(self.explained)
        row.addLayout(words, 1)
        row.setSpacing(self.look.px(16))
        self._top.addLayout(row)
        return head

    def _fit(self) -> None:
        px = self.look.px
        self._top.setContentsMargins(px(16), px(8), px(16), px(8))
        self._body.setContentsMargins(px(16), px(12), px(16), px(16))
        self.button.setMinimumHeight(px(44))
        self.button.setMinimumWidth(px(120))
        # Two lines, so that nothing jumps as the keyboard goes from field to field.
        self.explained.setMinimumHeight(2 * self.explained.fontMetrics().height() + px(2))

    def _load(self) -> None:
        """Load in a thread what runs are asked with: it takes a second."""

        def load(_progress: Progress) -> tuple[tuple[str, ...], tuple[str, ...]]:
            import gsapp.identification.runs.running  # noqa: F401
            from gsapp.dynamics.model import shipped_models
            from gsapp.identification.weights import shipped_weights

            return shipped_models(), shipped_weights()

        work = Work("Loading the settings", load, self)
        work.done.connect(self._loaded)
        work.failed.connect(self._report_error)
        work.start()

    def _loaded(self, names: tuple[tuple[str, ...], tuple[str, ...]]) -> None:
        models, weights = names
        self._ready = True
        self.panel.offer("model", models)
        self.panel.offer("weights", weights)
        self.refresh()

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this page do."""
        return {
            "review_run": self.estimate,
            "review_repeat": self.repeat,
            "review_use": self.use_again,
            "review_mark": self.runs.mark,
            "review_name": self.runs.name,
            "review_forget": self.runs.forget,
            "review_defaults": self.use_defaults,
        }

    @property
    def present(self) -> tuple[Need, ...]:
        """Return what commands may act on."""
        found: list[Need] = ["review_panel"]
        if self.can_run:
            found.append("review_ready")
        if self.runs.current is not None:
            found.append("review_run")
        return tuple(found)

    @property
    def can_run(self) -> bool:
        """Return whether what stands on the panel can be run now."""
        return (
            self._ready
            and not self._running
            and self._problem is None
            and bool(self._asked_maneuvers())
        )

    @property
    def state(self) -> StepState:
        """Return how the chapter stands."""
        if self._running:
            return StepState(state="plain", words="running")
        if self._problem is not None:
            return StepState(state="warning", words="a setting is wrong", detail=str(self._problem))
        outcome = self._outcome
        if outcome is None:
            return StepState(state="plain", words="no run yet")
        count = len(outcome.result.results)
        words = f"run {outcome.number}" if outcome.number is not None else "not kept"
        return StepState(state="plain", words=f"{words}: {count} maneuvers")

    @property
    def can_undo(self) -> bool:
        """Return whether a setting or a kept run was changed."""
        return self._deeds.can_undo

    @property
    def can_redo(self) -> bool:
        """Return whether a change was taken back."""
        return self._deeds.can_redo

    def undo(self) -> None:
        """Take back the last change of a setting or of a kept run."""
        self._deeds.undo()
        self.changed.emit()

    def redo(self) -> None:
        """Make the change again."""
        self._deeds.redo()
        self.changed.emit()

    def begin(self) -> None:
        """Put the keyboard on the button: Enter alone runs."""
        # Where the button must wait for what it needs, the keyboard waits with it.
        (self.button if self.button.isEnabled() else self).setFocus()
        self.explain("run")

    def showEvent(self, event: QShowEvent) -> None:
        """Look at what was changed on the other pages, and at the files anew."""
        super().showEvent(event)
        self._judged = None
        self.refresh()

    # What is asked for

    def explain(self, field: str) -> None:
        """Say what a field does and when to change it."""
        words = EXPLAINED[field]
        self.explained.setText(f"{words.title}: {words.does}")

    def _wished(self) -> None:
        """Take what the panel says now."""
        before, now = self._wishes, self.panel.wishes
        if now != before:
            self._take(now)
            self._deeds.record(lambda: self._show(before), lambda: self._show(now))
        else:
            self.refresh()

    def _take(self, wishes: Wishes) -> None:
        self._wishes = wishes
        self._told = ""
        self._store.change(review_estimate=wishes.model_dump())
        self.refresh()

    def _show(self, wishes: Wishes) -> None:
        """Show other wishes on the panel."""
        self.panel.show_wishes(wishes)
        self._take(wishes)

    def use_defaults(self) -> None:
        """Put all settings back to what they are at first."""
        self._replace(Wishes())

    def use_again(self) -> None:
        """Fill the panel with the settings of the kept run that has the keyboard."""
        run = self.runs.current
        if run is None:
            return
        try:
            request = run.request
            wishes = wishes_of(request)
            lost = unheld(request, wishes)
        except GroundStationError as error:
            self._report_error(error)
            return
        self._replace(wishes)
        rest = f", but for what this page does not hold: {', '.join(lost)}" if lost else ""
        self._told = f"The settings are those of {run.name}{rest}."
        self.refresh()

    def _replace(self, wishes: Wishes) -> None:
        before = self._wishes
        if wishes != before:
            self._show(wishes)
            self._deeds.record(lambda: self._show(before), lambda: self._show(wishes))
            self.changed.emit()

    def _asked_maneuvers(self) -> tuple[ChosenManeuver, ...]:
        """Return the maneuvers that would be used."""
        if not self._ready:
            return ()
        which = self._wishes.maneuvers
        if which == "chosen":
            chosen = self._review.chosen((self._selection.maneuver,))
        elif which == "all":
            chosen = self._review.chosen([row.id for row in self._review.rows()])
        else:
            chosen = self._review.chosen()
        surfaces = {"lon": {"de"}, "lat": {"da", "dr"}}.get(self._wishes.axis)
        if surfaces is None or self._wishes.six_degrees:
            return chosen
        return tuple(one for one in chosen if surfaces & set(one.inputs))

    def refresh(self) -> None:
        """Say what a run would do as everything stands."""
        self._follow_model()
        problem = self._judge()
        self.panel.show_problem(problem.field if problem else "", str(problem or ""))
        words, state = self._words()
        self.sentence.say(words, state)
        self.changed.emit()
        if self.hasFocus() and self.button.isEnabled():
            self.button.setFocus()

    def _follow_model(self) -> None:
        """Offer the parameters of the effects of the model that is chosen."""
        model, flights = self._wishes.model, self._review.flights
        if not self._ready or not flights or model == self._followed:
            return
        self._followed = model
        effects: dict[str, float] = {}
        # A model that cannot be read is said beside its field.
        with contextlib.suppress(GroundStationError, OSError):
            effects = effect_parameters(model, flights[0].aircraft) if model else {}
        gone = [n for n in self._wishes.derivatives if is_effect(n) and n not in effects]
        self.panel.derivatives.model_of.show_effects(effects)
        if gone:
            kept = {n: w for n, w in self._wishes.derivatives.items() if n not in gone}
            self._wishes = self._wishes.changed(derivatives=kept)
            self.panel.show_wishes(self._wishes)

    def _judge(self) -> FieldError | None:
        """Return what cannot be asked for, found out anew where the wishes are others."""
        if self._ready and self._judged != self._wishes:
            self._problem = problem_of(self._wishes)
            self._judged = self._wishes
        return self._problem

    def _words(self) -> tuple[str, str]:
        """Return what stands beside the button, and its state."""
        if not self._review.flights:
            return "There is no flight under review: add one under Maneuvers (Alt+1).", "caution"
        if not self._ready:
            return "Loading what runs are made with …", ""
        if self._problem is not None:
            return f"{self._problem}", "warning"
        if self._running:
            return f"{self._count()} · running; Ctrl+. stops it.", ""
        asked = self._asked_maneuvers()
        if not asked:
            return self._nothing(), "caution"
        return f"{self._told} {self._count()}".strip(), ""

    def _count(self) -> str:
        asked = self._asked_maneuvers()
        flights = len({one.flight for one in asked})
        return f"{maneuver_count([one.inputs for one in asked], flights)}."

    def _nothing(self) -> str:
        if self._wishes.maneuvers == "chosen":
            return "No maneuver is chosen: choose one under Maneuvers (Alt+1) or in a figure."
        if not self._review.rows():
            return "These flights have no maneuvers: add them under Maneuvers (Alt+1)."
        if self._wishes.axis != "both":
            return "No maneuver in use moved a surface of this axis: choose another axis."
        return "No maneuver is in use: check some under Maneuvers (Alt+1)."

    # Running

    def estimate(self) -> None:
        """Run what is asked for."""
        if not self.can_run:
            field = self._problem.field if self._problem is not None else ""
            self.panel.go_to(field)
            return
        try:
            request = run_request(
                self._wishes, self._review.paths, self._asked_maneuvers(), self.panel.label.text()
            )
        except FieldError as error:
            self.panel.show_problem(error.field, str(error))
            return
        self._begin()
        job = EstimateJob(request=request, catalog=self.book.catalog)
        self._begin_job(job, self._done, failed=self._failed)

    def repeat(self) -> None:
        """Do the kept run that has the keyboard again, exactly."""
        run = self.runs.current
        if run is None or self._running:
            return
        self._begin()
        job = RepeatJob(catalog=self.book.catalog, number=run.number)
        self._begin_job(job, self._repeated, failed=self._failed)

    def _begin(self) -> None:
        self._running = True
        self._told = ""
        if self.button.hasFocus():
            # It grays; the next control would take the next Enter.
            self.setFocus()
        self.refresh()

    def _done(self, found: object) -> None:
        outcome: Outcome = found  # type: ignore[assignment]
        self._running = False
        self.panel.label.clear()
        self.book.read()
        self._told = _ended(outcome)
        self.estimated.emit(outcome)
        self.refresh()

    def _repeated(self, found: object) -> None:
        repeated: Repeated = found  # type: ignore[assignment]
        self._running = False
        same = "The same to the last bit." if repeated.same else "It is not the same."
        self._told = " ".join((same, *(f"{one}." for one in repeated.differences)))
        self.estimated.emit(repeated.outcome)
        self.refresh()

    def _failed(self, error: BaseException) -> None:
        self._running = False
        self._told = ""
        if isinstance(error, CancelledError):
            # Whether it was stopped before it was kept is known when the catalog is read.
            self._kept_before = {run.number for run in self.book.runs}
            self.book.read()
        self.refresh()

    def _runs_read(self) -> None:
        """Say of a run that was stopped whether it was kept all the same."""
        if self._kept_before is None:
            return
        late = [run.number for run in self.book.runs if run.number not in self._kept_before]
        self._kept_before = None
        self._told = (
            f"Stopped when run {late[0]} was kept already; Delete in the list forgets it."
            if late
            else "Stopped; nothing was kept."
        )
        self.refresh()

    def show_outcome(self, outcome: Outcome | None) -> None:
        """Show the values of the run that is looked at beside the settings."""
        self._outcome = outcome
        values = {} if outcome is None else outcome.summary.derivatives
        found = {name: (one.value.mean, one.value.std) for name, one in values.items()}
        self.panel.derivatives.model_of.show_last(last_values(tuple(found), found))
        self.runs.show_number(None if outcome is None else outcome.number)


def _ended(outcome: Outcome) -> str:
    """Return how a run ended, in words."""
    results = outcome.result.results
    failed = [one.maneuver.id for one in results if one.estimate is None]
    name = f"Run {outcome.number}" if outcome.number is not None else "The run"
    said = [f"{name}: {len(outcome.summary.derivatives)} derivatives."]
    said += [sentences((one,)) for one in outcome.remarks if one.startswith(NOT_KEPT)]
    if failed:
        said.append(f"Not fitted: {', '.join(failed)}.")
    if outcome.summary.wild:
        said.append(f"Wild: {', '.join(one.maneuver for one in outcome.summary.wild)}.")
    said.append("Look at Figures (Alt+3), Summary (Alt+4).")
    return " ".join(said)
