"""The steps side by side, each with its state as shape, color and words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QAction, QFont, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtWidgets import QAbstractButton, QHBoxLayout, QSizePolicy, QWidget

from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.icons import paint_indicator
from ui.shortcut_filter import ArrowKeyNavigation
from ui.translation import tr
from ui.window_frame.exclusive_button_group import ExclusiveButtonGroup
from ui.window_frame.page_steps import PageStep, StepStatus

_LOW_WINDOW_HEIGHT = 440
"""Points of height of the window below which the words of a step take one line."""


class StepButton(QAbstractButton, ArrowKeyNavigation):
    """One step: number and title, below them how it stands."""

    def __init__(self, number: int, step: PageStep, action: QAction, look: DisplayStyle) -> None:
        super().__init__()
        self.step = step
        self.state = StepStatus()
        self.is_low = False
        self._look = look
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
        said = f"{title}: {words}" if words else title
        self.setAccessibleName(f"{said}, {self._keys}")
        self.setToolTip(f"{self.state.detail or tr(self.step.purpose)} ({self._keys})")

    def sizeHint(self) -> QSize:
        return QSize(self._look.px(120), self._look.px(48 if self.is_low else 56))

    def _title_font(self) -> QFont:
        font = self._look.font("body", strong=True)
        font.setPixelSize(self._look.px(15))
        return font

    def paintEvent(self, _event: QPaintEvent) -> None:
        look, box = self._look, QRectF(self.rect())
        painter = QPainter(self)
        chosen = self.isChecked()
        if chosen or self.underMouse():
            painter.fillRect(box, look.color("panel" if chosen else "hover"))
        if chosen:
            high = look.px(3)
            painter.fillRect(QRectF(0, box.height() - high, box.width(), high), look.color("text"))
        left, side = look.px(12), look.px(12)
        wide = box.width() - left - look.px(8)
        font = self._title_font()
        painter.setFont(font)
        painter.setPen(look.color("text" if chosen else "muted"))
        line = QRectF(left, look.px(6), wide, look.px(20))
        title = QFontMetricsF(font).elidedText(self.text(), Qt.TextElideMode.ElideRight, wide)
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, title)
        room = wide
        if not self.is_low:
            used = QFontMetricsF(font).horizontalAdvance(title) + look.px(10)
            painter.setFont(look.font("small"))
            painter.setPen(look.color("muted"))
            painter.drawText(
                line.adjusted(used, 1, 0, 1), Qt.AlignmentFlag.AlignVCenter, self._keys
            )
        shown = self.state
        top = look.px(26)
        if shown.state != "plain" and shown.text:
            color = look.state_color(shown.state)
            paint_indicator(painter, shown.state, QRectF(left, top + look.px(2), side, side), color)
            left += side + look.px(6)
            room -= side + look.px(6)
        painter.setFont(look.font("body"))
        painter.setPen(look.state_color(shown.state))
        self._draw_status_text(painter, QRectF(left, top, room, box.height() - top - look.px(4)))
        if self.hasFocus():
            painter.setPen(look.color("accent"))
            painter.drawRect(box.adjusted(1, 1, -2, -2))
        painter.end()

    def _draw_status_text(self, painter: QPainter, box: QRectF) -> None:
        """Draw the words in one line, or in two; what does not fit is in the tool tip."""
        metrics = QFontMetricsF(painter.font())
        lines = 1 if self.is_low or box.height() < 2 * metrics.height() else 2
        words = self.state.text
        if lines == 1 or metrics.horizontalAdvance(words) <= box.width():
            words = metrics.elidedText(words, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignTop, words)


class StepList(QWidget):
    """All steps in a row.

    Parameters
    ----------
    actions : mapping of str to QAction
        ``<prefix>_<id>`` goes to a step.
    """

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: DisplayStyle,
        steps: Sequence[PageStep],
        *,
        prefix: str,
        name: str,
    ) -> None:
        super().__init__()
        self._look = look
        self.setObjectName("bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(name)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 1)
        row.setSpacing(0)
        self._group = ExclusiveButtonGroup(self)
        self.buttons: dict[str, StepButton] = {}
        for number, step in enumerate(steps, start=1):
            button = StepButton(number, step, actions[f"{prefix}_{step.id}"], look)
            self._group.add_button(button)
            row.addWidget(button, 1)
            self.buttons[step.id] = button
        look.changed.connect(self._refresh)

    def show_step(self, step_id: str) -> None:
        self.buttons[step_id].setChecked(True)

    def show_state(self, step_id: str, state: StepStatus) -> None:
        self.buttons[step_id].show_state(state)

    def fit(self, window_height: int) -> None:
        low = window_height < self._look.px(_LOW_WINDOW_HEIGHT)
        for button in self.buttons.values():
            if button.is_low != low:
                button.is_low = low
                self._refresh()

    def _refresh(self) -> None:
        for button in self.buttons.values():
            button.updateGeometry()
            button.update()
