"""Summary of a run: what is known and how well, what to look at, linear models, what to write."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt
from PySide6.QtGui import QAction, QGuiApplication
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from ui.commands import Need
from ui.flight.controls import ActionButton
from ui.frame.steps import StepState
from ui.gap.parts import Choice, Lines, Pair, button_row
from ui.look import Look
from ui.pages import label
from ui.review.jobs import BeginJob
from ui.review.page import NO_RUN, ReviewPage
from ui.review.selection import Selection
from ui.review.summary_linear import LinearPanel
from ui.review.summary_lines import (
    ATTENTION_TITLES,
    DERIVATIVE_TITLES,
    REMARK,
    Attention,
    attention_lines,
    derivative_lines,
    derivative_words,
    table_text,
)
from ui.review.summary_writing import SummaryWriter
from ui.settings import SettingsStore
from ui.words import count_text

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome

_NOTHING = f"{NO_RUN} what came out is summed up here."
_DETAIL = 92
"""Points of height that words on a derivative take."""
_ROOMY = 670
"""Points of width of the table below which the columns give way that the detail has, too."""
_GIVE_WAY = (3, 7)


class SummaryPage(ReviewPage):
    """Tells what a run gave, and writes it down.

    Parameters
    ----------
    actions : mapping of str to QAction
        The commands.
    look : Look
        Colors, sizes, units.
    store : SettingsStore
        Remembers the folder that reports go to.
    selection : Selection
        The maneuver and the derivative that are looked at.
    begin_job : BeginJob
        Has something done in a process.
    """

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: Look,
        store: SettingsStore,
        selection: Selection,
        begin_job: BeginJob,
    ) -> None:
        super().__init__(look, "Summary")
        self._actions = actions
        self._selection = selection
        self._outcome: Outcome | None = None
        self.linear = LinearPanel(look, actions, begin_job)
        self.writer = SummaryWriter(store, begin_job, self)
        self.writer.told.connect(self._told)
        self._build()
        selection.maneuver_changed.connect(self._maneuver_chosen)
        selection.derivative_changed.connect(self._derivative_chosen)
        look.changed.connect(self._restyle)
        self._restyle()
        self.show_outcome(None)

    # Making

    def _build(self) -> None:
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        self._area = QScrollArea()
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        self._area.setWidgetResizable(True)
        self._area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        page = QWidget()
        page.setObjectName("page")
        page.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._area.setWidget(page)
        outer.addWidget(self._area)
        self._column = QVBoxLayout(page)
        self.headline = label("", "heading", wrap=True, remarks_in=self.look)
        self.trust = label("", wrap=True, remarks_in=self.look)
        self.trust.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._column.addWidget(self.headline)
        self._column.addWidget(self.trust)
        self._pair = Pair(self.look, (8, 5))
        self._column.addWidget(self._pair)
        self._column.addStretch(1)
        self._derivatives()
        self._attention()
        self._writing()
        self._add(self._pair.right, self.linear)
        self._pair.right.addStretch(1)

    def _derivatives(self) -> None:
        self.table = Lines(
            self.look, "Derivatives", DERIVATIVE_TITLES, stretch=REMARK,
            widths={0: 84, 1: 84, 2: 84, 3: 62, 4: 74, 5: 74, 6: 32, 7: 42, 8: 80},
            right=frozenset(range(1, REMARK)), least=6, most=40,
        )  # fmt: skip
        self.table.selectionModel().currentRowChanged.connect(lambda *_: self._row_chosen())
        self.table.opened.connect(lambda _key: self._actions["review_figures"].trigger())
        self.table.installEventFilter(self)
        self.detail = label("", wrap=True, remarks_in=self.look)
        self.detail.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.detail.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._add(self._pair.left, label("Derivatives, per radian", "strong"))
        self._add(self._pair.left, self.table)
        self._pair.left.addStretch(1)
        self._add(self._pair.right, label("The derivative chosen", "strong"))
        self._add(self._pair.right, self.detail)

    def _attention(self) -> None:
        self.attention_heading = label("Needs attention", "strong")
        self.attention = Lines(
            self.look, "What to look at", ATTENTION_TITLES, stretch=2, widths={0: 72, 1: 120},
            least=2, most=12,
        )  # fmt: skip
        self.attention.selectionModel().currentRowChanged.connect(lambda *_: self._looked_at())
        self.attention.opened.connect(lambda _key: self._actions["review_maneuvers"].trigger())
        self._add(self._pair.right, self.attention_heading)
        self._add(self._pair.right, self.attention)

    def _writing(self) -> None:
        look, actions = self.look, self._actions
        self.file = Choice(look, "One file", letters=24)
        self.buttons = {
            name: ActionButton(actions[name], words, look)
            for name, words in (
                ("review_report", "Report…"),
                ("review_everything", "Everything in a folder…"),
                ("review_copy", "Copy the table"),
                ("review_file", "Write it…"),
                ("review_open_written", "Open it"),
            )
        }
        self.buttons["review_report"].setProperty("role", "primary")
        right = self._pair.right
        self._add(right, label("Export", "strong"))
        first = ("review_report", "review_everything", "review_copy")
        self._add(right, button_row(look, *(self.buttons[name] for name in first)))
        self._add(right, button_row(look, self.file, self.buttons["review_file"]))
        self.told = label("", "muted", wrap=True)
        self.told.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._add(right, self.told)
        self.told.hide()
        self._add(right, button_row(look, self.buttons["review_open_written"]))
        self.buttons["review_open_written"].hide()

    def _add(self, column: QVBoxLayout, widget: QWidget) -> None:
        column.addWidget(widget)

    def _restyle(self) -> None:
        gap = self.look.px(16)
        # Words of another length must not push about what stands below.
        self.detail.setMinimumHeight(self.look.px(_DETAIL))
        self._column.setContentsMargins(self.look.px(24), gap, self.look.px(24), gap)
        self._column.setSpacing(self.look.px(8))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Leave out columns where the table has little room."""
        if watched is self.table and event.type() == QEvent.Type.Resize:
            self._fit()
        return super().eventFilter(watched, event)

    def _fit(self) -> None:
        narrow = self.table.width() < self.look.px(_ROOMY)
        for column in _GIVE_WAY:
            if self.table.isColumnHidden(column) != narrow:
                self.table.setColumnHidden(column, narrow)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this page do."""
        return {
            "review_report": lambda: self._with_outcome(
                lambda run: self.writer.ask_report(run, self.look.units, self.linear.comparison)
            ),
            "review_everything": lambda: self._with_outcome(
                lambda run: self.writer.ask_everything(run, self.look.units, self.linear.comparison)
            ),
            "review_file": lambda: self._with_outcome(
                lambda run: self.writer.ask_file(run, self.file.value, self.linear.comparison)
            ),
            "review_open_written": self.writer.open,
            "review_copy": self.copy,
            "review_compare": lambda: self._with_outcome(lambda _run: self.linear.compare()),
        }

    def _with_outcome(self, act: Callable[[Outcome], object]) -> None:
        if self._outcome is not None:
            act(self._outcome)

    @property
    def present(self) -> tuple[Need, ...]:
        """Return what commands may act on here."""
        found: list[Need] = []
        if self._outcome is not None:
            found.append("review_results")
        if self.writer.written is not None:
            found.append("review_written")
        return tuple(found)

    @property
    def state(self) -> StepState:
        """Return how the chapter stands: how many things there are to look at."""
        if self._outcome is None:
            return StepState(state="unknown")
        wild = len(self._outcome.summary.wild)
        if wild:
            return StepState(state="caution", words=count_text(wild, "wild maneuver"))
        earned = [name for name in self._outcome.summary.derivatives if not name.endswith("_0")]
        return StepState(state="plain", words=count_text(len(earned), "derivative"))

    def copy(self) -> None:
        """Put the table on the clipboard, as text with tabs."""
        if self._outcome is not None:
            QGuiApplication.clipboard().setText(table_text(self._outcome))
            self._told("The table is on the clipboard.")

    # Showing

    def begin(self) -> None:
        """Put the keyboard on the derivatives."""
        self.table.setFocus()
        if not self.table.currentIndex().isValid() and self.table.lines.lines:
            self.table.setCurrentIndex(self.table.lines.index(0, 0))

    def show_outcome(self, outcome: Outcome | None) -> None:
        """Show a run; None where there is none."""
        self._outcome = outcome
        self._pair.setVisible(outcome is not None)
        self.trust.setVisible(outcome is not None)
        if outcome is None:
            self.headline.setText(_NOTHING)
            return
        from gsapp.report.estimate_files import FILE_TITLES, file_names
        from gsapp.report.estimate_words import excluded_words, headline, honesty_words
        from gsapp.report.residual_words import residual_words

        kept = "" if outcome.number is None else f"Run {outcome.number}: "
        self.headline.setText(f"{kept}{headline(outcome.summary, outcome.result)}")
        said = (honesty_words(outcome.summary), *residual_words(outcome.result))
        self.trust.setText(" ".join((*said, *excluded_words(outcome.summary))))
        with QSignalBlocker(self.table.selectionModel()):
            self.table.show_lines(derivative_lines(outcome))
        with QSignalBlocker(self.attention.selectionModel()):
            lines = attention_lines(outcome)
            self.attention.show_lines(lines)
        self.attention.setVisible(bool(lines))
        self.attention_heading.setText("Needs attention" if lines else "Nothing needs attention")
        self.linear.show_outcome(outcome)
        names = [name for name in file_names(outcome) if name in FILE_TITLES]
        self.file.show_choices([(name, FILE_TITLES[name]) for name in names], self.file.value)
        self._derivative_chosen(self._selection.derivative)
        self._maneuver_chosen(self._selection.maneuver)
        self._tell_of(self._selection.derivative)
        self.changed.emit()

    def _told(self, words: str) -> None:
        self.told.setText(words)
        self.told.setVisible(bool(words))
        self.buttons["review_open_written"].setVisible(self.writer.written is not None)
        self.changed.emit()

    # What is looked at

    def _row_chosen(self) -> None:
        key = self.table.current_key()
        if isinstance(key, str):
            self._tell_of(key)
            self._selection.choose_derivative(key)

    def _tell_of(self, derivative: str) -> None:
        outcome = self._outcome
        words = derivative_words(outcome, derivative) if outcome and derivative else ""
        self.detail.setText(words or "Choose a derivative in the table.")

    def _looked_at(self) -> None:
        key = self.attention.current_key()
        if isinstance(key, Attention):
            self._selection.choose_maneuver(key.maneuver)
            if key.derivative:
                self._selection.choose_derivative(key.derivative)

    def _derivative_chosen(self, derivative: str) -> None:
        if self.table.current_key() != derivative:
            self.table.choose(derivative)

    def _maneuver_chosen(self, maneuver: str) -> None:
        current = self.attention.current_key()
        if isinstance(current, Attention) and current.maneuver == maneuver:
            return
        for line in self.attention.lines.lines:
            if isinstance(line.key, Attention) and line.key.maneuver == maneuver:
                with QSignalBlocker(self.attention.selectionModel()):
                    self.attention.choose(line.key)
                return
