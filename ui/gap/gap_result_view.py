"""The result of a search, told in four steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.discrepancy.results import DecidingExperiment
from gsapp.report.discrepancy_text import experiment_text
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.gap.add_and_show import AddStage, ShowStage
from ui.gap.find_and_name import FindStage, NameStage, StageView
from ui.gap.gap_selection import (
    GapSelection,
    find_most_closed_channel,
    find_worst_held_out,
    initial_selection,
    list_model_names,
    nearest_valid_selection,
)
from ui.gap.gap_stages import GAP_STAGES
from ui.gap.gap_text import verdict_state, verdict_text
from ui.gap.gap_view_models import find_step_effect
from ui.gap.gap_widgets import StepSlider
from ui.gap.search_jobs import SearchResult
from ui.icons import IndicatorState, paint_indicator
from ui.settings import SettingsStore
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import ScrollingPage
from ui.window_frame.navigation_rail import ExclusiveButtonGroup

if TYPE_CHECKING:
    from gsapp.dynamics.model import Model

_ONE_ROW_WIDTH = 900
_CREATE_INTERVAL_MS = 150


class _VerdictIcon(QWidget):
    """The shape of the verdict's state."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._state: IndicatorState = "plain"

    def show_state(self, state: IndicatorState) -> None:
        self._state = state
        self.setVisible(state != "plain")
        self.setFixedSize(self._style.px(20), self._style.px(20))
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        box = QRectF(self.rect()).adjusted(2, 2, -2, -2)
        paint_indicator(painter, self._state, box, self._style.state_color(self._state))
        painter.end()


class _ScrollContent(QWidget):
    """The page that scrolls: side by side it asks for what it needs, stacked for what it likes."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style

    def heightForWidth(self, width: int) -> int:
        layout = self.layout()
        if layout is None:
            return -1
        if width < self._style.px(_ONE_ROW_WIDTH):
            # It scrolls anyway: tables within it need not.
            return layout.totalHeightForWidth(width)
        return layout.minimumHeightForWidth(width)


class GapResultView(ScrollingPage):
    """Verdict, the way through the models, and one of the four steps."""

    step_changed = Signal()

    def __init__(
        self, actions: Mapping[str, QAction], style: DisplayStyle, store: SettingsStore
    ) -> None:
        super().__init__(_ScrollContent(style))
        self._style = style
        self._store = store
        self._actions = actions
        self.result: SearchResult | None = None
        self.selection = GapSelection()
        self._moved = self._chose = self._tuned = False
        self.setAccessibleName(tr("Search result"))
        self.column.addLayout(self._create_header())
        self.column.addWidget(self._create_navigation())
        self.stages: dict[str, StageView] = {}
        self._next = QTimer(self)
        self._next.setSingleShot(True)
        self._next.timeout.connect(self._complete)
        self.stage = ""
        style.changed.connect(self._restyle)
        self._restyle()

    def _create_header(self) -> QVBoxLayout:
        head = QVBoxLayout()
        row = QHBoxLayout()
        row.setSpacing(self._style.px(10))
        self._sign = _VerdictIcon(self._style)
        row.addWidget(self._sign, 0, Qt.AlignmentFlag.AlignVCenter)
        self.verdict = create_label("", "title", wrap=True)
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        policy.setHeightForWidth(True)
        self.verdict.setSizePolicy(policy)
        row.addWidget(self.verdict, 1)
        self.search_button = ActionButton(
            self._actions["gap_search"], tr("New search…"), self._style
        )
        row.addWidget(self.search_button, 0, Qt.AlignmentFlag.AlignTop)
        head.addLayout(row)
        self.reason = create_label("", wrap=True, remarks_in=self._style)
        self.reason.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        head.addWidget(self.reason)
        row = QHBoxLayout()
        row.setSpacing(self._style.px(10))
        self.experiment_text = create_label("", wrap=True)
        self.experiment_text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.cards_button = ActionButton(
            self._actions["gap_cards"], tr("Add to test cards"), self._style
        )
        row.addWidget(self.experiment_text, 1)
        row.addWidget(self.cards_button, 0, Qt.AlignmentFlag.AlignTop)
        head.addLayout(row)
        self.about = create_label("", "hint", wrap=True)
        head.addWidget(self.about)
        return head

    def _create_navigation(self) -> QWidget:
        holder = QWidget()
        self._navigation_box = QBoxLayout(QBoxLayout.Direction.LeftToRight, holder)
        self._navigation_box.setContentsMargins(0, 0, 0, 0)
        chapters = QWidget()
        row = QHBoxLayout(chapters)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(self._style.px(4))
        self.buttons: dict[str, QPushButton] = {}
        self._group = ExclusiveButtonGroup(self)
        for number, stage in enumerate(GAP_STAGES, start=1):
            action = self._actions[f"gap_{stage.id}"]
            title, question = tr(stage.title), tr(stage.purpose)
            button = QPushButton(f"{number}  {title}")
            button.setCheckable(True)
            key = shortcut_text(action.shortcut().toString())
            button.setAccessibleName(
                tr("Step {number}, {title}: {question}").format(
                    number=number, title=title, question=question
                )
            )
            button.setToolTip(f"{question} ({key})")
            button.clicked.connect(lambda _checked=False, name=stage.id: self.go_to_stage(name))
            self._group.add_button(button)
            row.addWidget(button)
            self.buttons[stage.id] = button
        self._navigation_box.addWidget(chapters)
        self.track = StepSlider(self._style)
        self.track.valueChanged.connect(self._slider_moved)
        self._navigation_box.addWidget(self.track, 1)
        return holder

    # The four steps

    def _get_stage(self, name: str) -> StageView:
        if name not in self.stages:
            style, actions = self._style, self._actions
            kinds: Mapping[str, Callable[[], StageView]] = {
                "find": lambda: FindStage(style),
                "name": lambda: NameStage(style),
                "add": lambda: AddStage(style, actions),
                "show": lambda: ShowStage(style, actions),
            }
            view = kinds[name]()
            view.setAccessibleName(tr(next(one.title for one in GAP_STAGES if one.id == name)))
            view.selection_requested.connect(self._choose)
            view.hide()
            self.column.addWidget(view, 1)
            self.stages[name] = view
        return self.stages[name]

    def _complete(self) -> None:
        """Make the steps that nobody asked for yet, one at a time, so that nothing waits long."""
        missing = [one.id for one in GAP_STAGES if one.id not in self.stages]
        if missing:
            self._get_stage(missing[0])
            self._next.start(_CREATE_INTERVAL_MS)

    # What is shown

    def show_result(self, result: SearchResult) -> None:
        """Show a result; what was looked at stays where a former one was of the same flights."""
        former = self.result
        self.result = result
        if former is not None and result.continues(former):
            self.selection = nearest_valid_selection(result, self.selection)
        else:
            settings = self._store.current
            self.selection = initial_selection(
                result, variable=settings.gap_variable, channel=settings.gap_channel
            )
            self._moved = self._chose = self._tuned = False
        self._show_verdict()
        if self.stage and former is not None and result.continues(former):
            self.set_selection(self.selection)
        else:
            self.go_to_stage("find", focus=False)

    def _show_verdict(self) -> None:
        result = self.result
        if result is None:
            return
        self.verdict.setText(verdict_text(result))
        self._sign.show_state(verdict_state(result.discrepancy))
        self.reason.setText(result.discrepancy.why)
        self.about.setText(result.request.text)
        one = self.experiment
        self.experiment_text.setText("" if one is None else experiment_text(one, self._style.units))
        for part in (self.experiment_text, self.cards_button):
            part.setVisible(one is not None)

    @property
    def experiment(self) -> DecidingExperiment | None:
        """Return what to fly next, if the search left a question open."""
        return None if self.result is None else self.result.discrepancy.experiment

    def _choose(self, selection: GapSelection) -> None:
        former = self.selection
        self._chose |= selection.maneuver != former.maneuver
        if self.stage == "show" and selection.channel != former.channel:
            self._tuned = True
            self._store.change(gap_channel=selection.channel)
        if selection.variable != former.variable:
            self._store.change(gap_variable=selection.variable)
        self.set_selection(selection)

    def set_selection(self, selection: GapSelection) -> None:
        if self.result is None:
            return
        self.selection = nearest_valid_selection(self.result, selection)
        self.track.show_steps(list_model_names(self.result), self.selection.step)
        self.stages[self.stage].show_result(self.result, self.selection)
        self.step_changed.emit()

    def go_to_stage(self, stage: str, *, focus: bool = True) -> None:
        if self.result is None:
            return
        last = len(self.result.discrepancy.steps) - 1
        if stage == "show":
            # The story's end shows what was won, unless the crew chose something itself.
            if not self._moved and self.selection.step == 0:
                self.selection = replace(self.selection, step=last)
            if not self._chose and (kept := find_worst_held_out(self.result, self.selection)):
                self.selection = replace(self.selection, maneuver=kept)
            if not self._tuned and (name := find_most_closed_channel(self.result)):
                self.selection = replace(self.selection, channel=name)
        self.stage = stage
        self._get_stage(stage)
        self._next.start(_CREATE_INTERVAL_MS)
        for name, view in self.stages.items():
            view.setVisible(name == stage)
        self.buttons[stage].setChecked(True)
        self.set_selection(self.selection)
        self.verticalScrollBar().setValue(0)
        if focus:
            self.stages[stage].set_initial_focus()

    def set_initial_focus(self) -> None:
        if self.stage:
            self.stages[self.stage].set_initial_focus()

    # Moving

    def _slider_moved(self, step: int) -> None:
        self._moved = True
        self.set_selection(replace(self.selection, step=step))

    def move_step(self, steps: int) -> None:
        self._moved = True
        self.set_selection(replace(self.selection, step=self.selection.step + steps))

    def next_maneuver(self, steps: int) -> None:
        if self.result is None or not self.result.discrepancy.maneuvers:
            return
        ids = [view.id for view in self.result.discrepancy.maneuvers]
        self._chose = True
        index = ids.index(self.selection.maneuver) + steps
        self.set_selection(replace(self.selection, maneuver=ids[min(max(index, 0), len(ids) - 1)]))

    @property
    def can_accept(self) -> bool:
        if self.result is None:
            return False
        return find_step_effect(self.result, self.selection.step + 1) is not None

    @property
    def selected_model(self) -> Model:
        """Return the model of the step shown; at the last, with tables where the crew wants them.

        Raise ValueError without a result.
        """
        if self.result is None:
            raise ValueError("no result")
        found = self.result.discrepancy
        model, add = found.steps[self.selection.step].model, self.stages.get("add")
        if (
            isinstance(add, AddStage)
            and add.as_tables.isChecked()
            and self.selection.step == len(found.steps) - 1
        ):
            from gsapp.discrepancy.unexplained_structure import with_tables

            return with_tables(model, found.structures)
        return model

    @property
    def chosen_effect(self) -> str:
        if self.result is None:
            return ""
        view = self.stages.get(self.stage)
        if isinstance(view, NameStage) and view.candidate:
            return view.candidate
        if isinstance(view, AddStage) and view.selected_effect:
            return view.selected_effect
        for step in (self.selection.step + 1, self.selection.step):
            if (effect := find_step_effect(self.result, step)) is not None:
                return effect.effect
        return ""

    # Look

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        style = self._style
        wide = self.viewport().width() >= style.px(_ONE_ROW_WIDTH)
        side, down = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._navigation_box.setDirection(side if wide else down)
        self._navigation_box.setSpacing(style.px(24 if wide else 8))

    def _restyle(self) -> None:
        style = self._style
        margin = style.px(16)
        self.column.setContentsMargins(margin, style.px(12), margin, margin)
        self.column.setSpacing(style.px(12))
        for button in self.buttons.values():
            button.setMinimumHeight(style.px(36))
        self._fit()
        self._show_verdict()
        if self.result is not None:
            self.set_selection(self.selection)
