"""The actions that are possible now, each with its key, at least 44 points high."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QMenu, QPushButton, QSizePolicy, QWidget

from ui.commands import shortcut_text
from ui.dialogs.form_dialog import repolish
from ui.display_style import DisplayStyle
from ui.translation import tr


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionItem:
    """Something that can be done now."""

    id: str  # Name in code.
    text: str  # On the button.
    key: str = ""  # That does it; empty for none.
    is_default: bool = False  # Whether it is the one thing that is wanted now.
    disabled_reason: str = ""  # Why it cannot be done now; empty if it can.

    @property
    def label(self) -> str:
        text = tr(self.text)
        return f"{text}   {shortcut_text(self.key)}" if self.key else text


class ActionBar(QWidget):
    """One row of buttons; those without room are in the menu of the last one."""

    triggered = Signal(str)  # Id of the action.

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.offers: tuple[ActionItem, ...] = ()
        self._buttons: list[QPushButton] = []
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._row = QHBoxLayout(self)
        self.more = QPushButton(tr("More"))
        self.more.setAccessibleName(tr("More actions"))
        self.more.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self._menu = QMenu(self)
        self.more.setMenu(self._menu)
        self.more.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self._row.addWidget(self.more)
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._look.px
        self._row.setContentsMargins(px(16), px(4), px(16), px(6))
        self._row.setSpacing(px(8))
        self.updateGeometry()
        self._fit()

    def sizeHint(self) -> QSize:
        return QSize(self._look.px(320), self._look.sizes.control + self._look.px(10))

    def minimumSizeHint(self) -> QSize:
        return QSize(self._look.px(160), self.sizeHint().height())

    def show_actions(self, offers: Sequence[ActionItem]) -> None:
        if tuple(offers) == self.offers:
            return
        self.offers = tuple(offers)
        while len(self._buttons) < len(offers):
            self._make()
        for place, button in enumerate(self._buttons):
            offer = self.offers[place] if place < len(self.offers) else None
            if offer is None:
                continue
            button.setText(offer.label)
            button.setAccessibleName(offer.label)
            button.setEnabled(not offer.disabled_reason)
            button.setToolTip(offer.disabled_reason)
            role = "primary" if offer.is_default else ""
            if button.property("role") != role:
                button.setProperty("role", role)
                repolish(button)
        self._fit()

    def _make(self) -> None:
        button = QPushButton()
        # A press must not take the keyboard away from the page.
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        # As high as the bar: the style sheet knows a least height of its own.
        button.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        place = len(self._buttons)
        button.clicked.connect(lambda: self.triggered.emit(self.offers[place].id))
        self._row.insertWidget(place, button, 1)
        self._buttons.append(button)

    def _trigger(self, name: str) -> Callable[[], None]:
        return lambda: self.triggered.emit(name)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        gap = self._row.spacing()
        margins = self._row.contentsMargins()
        room = self.width() - margins.left() - margins.right()
        widths = [self._buttons[at].sizeHint().width() for at in range(len(self.offers))]
        shown = len(widths)
        if sum(widths) + gap * (len(widths) - 1) > room:
            room -= self.more.sizeHint().width() + gap
            while shown > 1 and sum(widths[:shown]) + gap * (shown - 1) > room:
                shown -= 1
        for place, button in enumerate(self._buttons):
            button.setVisible(place < shown)
        self._menu.clear()
        for offer in self.offers[shown:]:
            entry = self._menu.addAction(offer.label, self._trigger(offer.id))
            entry.setEnabled(not offer.disabled_reason)
        self.more.setVisible(shown < len(self.offers))
        # At once: until the next round of events the new words would stand in the old widths.
        self._row.activate()
