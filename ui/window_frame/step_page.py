"""The pages of the window: their common base, and the steps that some lead through."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Generic, Literal, TypeVar

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QFont,
    QFontMetricsF,
    QHideEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import (
    QAbstractButton,
    QHBoxLayout,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ui.commands import COMMANDS, CommandRequirement, shortcut_text
from ui.display_style import DisplayStyle
from ui.icons import paint_indicator
from ui.settings import SettingsStore
from ui.shortcut_filter import ArrowKeyNavigation
from ui.translation import tr
from ui.undo import UndoHistory
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import plain_tooltip
from ui.widgets.layout_widgets import PageStack
from ui.window_frame.banners import BannerStack
from ui.window_frame.job_banner import JobBanner, JobProgressPanel
from ui.window_frame.navigation_rail import ExclusiveButtonGroup
from ui.window_frame.page_steps import PageStep, StepStatus

_LOW_WINDOW_HEIGHT = 440
"""Points of height of the window below which the words of a step take one line."""


class StepButton(QAbstractButton, ArrowKeyNavigation):
    """One step: number and title, below them how it stands."""

    def __init__(self, number: int, step: PageStep, action: QAction, style: DisplayStyle) -> None:
        super().__init__()
        self.step = step
        self.state = StepStatus()
        self.is_low = False
        self.has_small_title = False
        self._style = style
        self._keys = shortcut_text(action.shortcut().toString())
        self.setText(f"{number}  {tr(step.title)}")
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.clicked.connect(action.trigger)
        self._describe()

    def show_state(self, state: StepStatus) -> None:
        """Show another state."""
        if state != self.state:
            self.state = state
            self._describe()
            self.update()

    def _describe(self) -> None:
        words = self.state.text
        title = tr(self.step.title)
        text = f"{title}: {words}" if words else title
        self.setAccessibleName(f"{text}, {self._keys}")
        self.setToolTip(
            plain_tooltip(f"{self.state.detail or tr(self.step.purpose)} ({self._keys})")
        )

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(120), self._style.px(48 if self.is_low else 56))

    def _title_font(self) -> QFont:
        if self.has_small_title:
            return self._style.font("label", strong=True)
        font = self._style.font("body", strong=True)
        font.setPixelSize(self._style.px(15))
        return font

    @property
    def is_title_cut(self) -> bool:
        room = self.width() - self._style.px(20)
        return QFontMetricsF(self._title_font()).horizontalAdvance(self.text()) > room

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, box = self._style, QRectF(self.rect())
        painter = QPainter(self)
        chosen = self.isChecked()
        if chosen or self.underMouse():
            painter.fillRect(box, style.color("panel" if chosen else "hover"))
        if chosen:
            high = style.px(3)
            painter.fillRect(QRectF(0, box.height() - high, box.width(), high), style.color("text"))
        left, side = style.px(12), style.px(12)
        wide = box.width() - left - style.px(8)
        font = self._title_font()
        painter.setFont(font)
        painter.setPen(style.color("text" if chosen else "muted"))
        line = QRectF(left, style.px(6), wide, style.px(20))
        title = QFontMetricsF(font).elidedText(self.text(), Qt.TextElideMode.ElideRight, wide)
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, title)
        room = wide
        if not self.is_low:
            used = QFontMetricsF(font).horizontalAdvance(title) + style.px(10)
            painter.setFont(style.font("small"))
            painter.setPen(style.color("muted"))
            painter.drawText(
                line.adjusted(used, 1, 0, 1), Qt.AlignmentFlag.AlignVCenter, self._keys
            )
        shown = self.state
        top = style.px(26)
        if shown.state != "plain" and shown.text:
            color = style.state_color(shown.state)
            paint_indicator(
                painter, shown.state, QRectF(left, top + style.px(2), side, side), color
            )
            left += side + style.px(6)
            room -= side + style.px(6)
        painter.setFont(style.font("body"))
        painter.setPen(style.state_color(shown.state))
        self._draw_status_text(painter, QRectF(left, top, room, box.height() - top - style.px(4)))
        if self.hasFocus():
            painter.setPen(style.color("accent"))
            painter.drawRect(box.adjusted(1, 1, -2, -2))
        painter.end()

    def _draw_status_text(self, painter: QPainter, box: QRectF) -> None:
        """Draw the words in one line, or in two; what does not fit is in the tool tip."""
        metrics = QFontMetricsF(painter.font())
        lines = 1 if self.is_low or box.height() < 2 * metrics.height() else 2
        text = self.state.text
        if lines == 1 or metrics.horizontalAdvance(text) <= box.width():
            text = metrics.elidedText(text, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignTop, text)


class StepList(QWidget):
    """All steps in a row.

    `actions`: ``<prefix>_<id>`` goes to a step.
    """

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        steps: Sequence[PageStep],
        *,
        prefix: str,
        name: str,
    ) -> None:
        super().__init__()
        self._style = style
        self.setObjectName("bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(name)
        self._row = row = arrange(QHBoxLayout(self), 0, 0, 0, 0, 1)
        self._group = ExclusiveButtonGroup(self)
        self.buttons: dict[str, StepButton] = {}
        for number, step in enumerate(steps, start=1):
            button = StepButton(number, step, actions[f"{prefix}_{step.id}"], style)
            self._group.add_button(button)
            row.addWidget(button, 1)
            self.buttons[step.id] = button
        style.changed.connect(self._refresh)

    def show_step(self, step_id: str) -> None:
        self.buttons[step_id].setChecked(True)

    def show_state(self, step_id: str, state: StepStatus) -> None:
        self.buttons[step_id].show_state(state)

    def fit(self, window_height: int) -> None:
        low = window_height < self._style.px(_LOW_WINDOW_HEIGHT)
        for button in self.buttons.values():
            if button.is_low != low:
                button.is_low = low
                self._refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_titles()

    def _fit_titles(self) -> None:
        """Make all titles small where one has no room."""
        buttons = self.buttons.values()
        self._row.activate()
        for button in buttons:
            button.has_small_title = False
        if any(button.is_title_cut for button in buttons):
            for button in buttons:
                button.has_small_title = True

    def _refresh(self) -> None:
        self._fit_titles()
        for button in self.buttons.values():
            button.updateGeometry()
            button.update()


class AbstractStepPage(QWidget):
    """One step of a page."""

    changed = Signal()  # Other commands are of use, or the step stands differently.

    def __init__(self, style: DisplayStyle, name: str) -> None:
        super().__init__()
        self.display_style = style
        self.setAccessibleName(name)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {}

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        """Return what commands may act on here, beside going from step to step."""
        return ()

    @property
    def undo_history(self) -> UndoHistory | None:
        """Return the changes made here; None while nothing can be changed."""
        return None

    def undo(self) -> None:
        if self.undo_history is not None:
            self.undo_history.undo()
            self.show_restored()

    def redo(self) -> None:
        if self.undo_history is not None:
            self.undo_history.redo()
            self.show_restored()

    def show_restored(self) -> None:
        """Show what was undone or redone."""
        self.changed.emit()

    def set_initial_focus(self) -> None:
        """Put the keyboard where one goes on."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Show what changed beside this page."""

    def flush(self) -> None:
        """Write what is still being typed."""


class WindowPage(QWidget):
    """One page of the window: a stack of views below one another's bars."""

    changed = Signal()  # Other commands are of use now.
    show_requested = Signal()  # The page should be on screen.

    def __init__(
        self, name: str, actions: Mapping[str, QAction], style: DisplayStyle, store: SettingsStore
    ) -> None:
        super().__init__()
        self._actions = actions
        self._style = style
        self._store = store
        self.setAccessibleName(name)
        self.column = arrange(QVBoxLayout(self), 0)
        self.stack = PageStack()
        self.column.addWidget(self.stack, 1)

    @property
    def shown(self) -> bool:
        return self.isVisible()

    @property
    def undo_history(self) -> UndoHistory | None:
        """Return the changes made in the view on screen; None while nothing can be changed."""
        return None

    def undo(self) -> None:
        """Undo the last change in the view on screen."""

    def redo(self) -> None:
        """Redo the change that was undone last."""

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.changed.emit()


class JobPage(WindowPage):
    """A page with jobs in the background: their progress on top, in a banner while it is hidden."""

    def __init__(
        self,
        name: str,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        job_name: str,
        cancel_command: str,
    ) -> None:
        super().__init__(name, actions, style, store)
        self._banners = banners
        self._banner = JobBanner(banners, self.cancel)
        self.strip = JobProgressPanel(style, actions[cancel_command], job_name)
        self.column.insertWidget(0, self.strip)

    @property
    def busy(self) -> bool:
        raise NotImplementedError

    def cancel(self) -> None:
        raise NotImplementedError

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._banner.clear()

    def hideEvent(self, event: QHideEvent) -> None:
        if self.busy:
            self._banner.show(self.strip.title)
        super().hideEvent(event)

    def _show_began(self, title: str) -> None:
        self.strip.start(title)
        if not self.isVisible():
            self._banner.show(self.strip.title)
        self.changed.emit()

    def _show_progress(self, share: float | None, text: str) -> None:
        self.strip.set_progress(share, text)
        self._banner.set_progress(share, text)

    def _show_ended(self, title: str, how: str) -> None:
        self.strip.hide()
        self._banner.remove()
        if how == "cancelled":
            self._banners.show_banner("note", tr("{title}: stopped.").format(title=title))
        self.changed.emit()


Step = TypeVar("Step", bound=AbstractStepPage)


class MultiStepPage(WindowPage, Generic[Step]):
    """A page that leads from step to step; each is made when it is first seen."""

    # Before the id of a step, in the id of the command that goes there.
    prefix: ClassVar[Literal["preflight", "review"]]
    setting: ClassVar[str]  # Remembers the step.
    all_steps: ClassVar[tuple[PageStep, ...]]
    step_list_name: ClassVar[str]  # Accessible name of the row of steps.
    # Before the ids of the commands that the steps handle.
    step_command_prefixes: ClassVar[tuple[str, ...]]

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.pages: dict[str, Step] = {}  # The steps that were seen, by id.
        self.step = ""  # The one on screen; empty before the first.
        self.steps = StepList(
            self._actions,
            self._style,
            self.all_steps,
            prefix=self.prefix,
            name=tr(self.step_list_name),
        )
        self.column.insertWidget(0, self.steps)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        steps = {
            f"{self.prefix}_{step.id}": lambda name=step.id: self.go_to_step(name)
            for step in self.all_steps
        }
        own = {**steps, **self.own_handlers}
        of_steps = {
            command.id: lambda name=command.id: self._handle_in_step(name)
            for command in COMMANDS
            if command.id.startswith(self.step_command_prefixes) and command.id not in own
        }
        return {**own, **of_steps}

    @property
    def own_handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands do that are for no single step."""
        return {}

    def _handle_in_step(self, command: str) -> None:
        """Run a command in the step on screen, or else in the one that has it."""
        for page in (self.step_page, *self.pages.values()):
            if page is not None and command in page.handlers:
                page.handlers[command]()
                return

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        if not self.shown or not self.step:
            return ()
        page = self.step_page
        return (self.prefix, *(page.present if page is not None else ()))

    @property
    def step_page(self) -> Step | None:
        """Return the step on screen; None before the first."""
        return self.pages.get(self.step)

    @property
    def undo_history(self) -> UndoHistory | None:
        page = self.step_page
        return None if page is None else page.undo_history

    def undo(self) -> None:
        if self.step_page is not None:
            self.step_page.undo()

    def redo(self) -> None:
        if self.step_page is not None:
            self.step_page.redo()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.go_to_step(self.step or getattr(self._store.current, self.setting), begin=False)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.steps.fit(self.window().height())

    def go_to_step(self, step_id: str, *, begin: bool = True) -> None:
        self.stack.setCurrentWidget(self.get_page(step_id))
        self.step = step_id
        self.steps.show_step(step_id)
        self._store.change(**{self.setting: step_id})
        self.refresh()
        if begin:
            self.set_initial_focus()
        self.changed.emit()

    def get_page(self, step_id: str) -> Step:
        """Return a step, made if it was not seen yet."""
        if step_id not in self.pages:
            page = self.pages[step_id] = self.make_page(step_id)
            page.changed.connect(self._page_changed)
            self.stack.addWidget(page)
        return self.pages[step_id]

    def make_page(self, step_id: str) -> Step:
        """Make a step; what it is made of is loaded with it."""
        raise NotImplementedError

    def refresh(self) -> None:
        raise NotImplementedError

    def _page_changed(self) -> None:
        self.refresh()
        self.changed.emit()

    def set_initial_focus(self) -> None:
        if self.step:
            self.pages[self.step].set_initial_focus()
