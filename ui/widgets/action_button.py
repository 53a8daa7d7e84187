"""Buttons that run commands: one alone, and a bar of all that can be done now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QMenu, QPushButton, QSizePolicy, QWidget

from ui.commands import action_hint, shortcut_text
from ui.dialogs.form_dialog import repolish
from ui.display_style import DisplayStyle
from ui.icons import create_icon
from ui.translation import tr
from ui.widgets.labels import plain_tooltip


def _icon_spaced_text(text: str, glyph: str) -> str:
    # Qt sets sign and word closer than the grid.
    return f" {text}" if glyph else text


class ActionButton(QPushButton):
    """A button that runs a command: same words, same key, grayed with it."""

    def __init__(self, action: QAction, words: str, style: DisplayStyle, glyph: str = "") -> None:
        super().__init__(_icon_spaced_text(words, glyph))
        self._style = style
        self._glyph = glyph
        self._action = action
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.clicked.connect(action.trigger)
        action.changed.connect(self._update_from_action)
        style.changed.connect(self._redraw)
        self._update_from_action()
        self._redraw()

    def _update_from_action(self) -> None:
        keys = shortcut_text(self._action.shortcut().toString())
        text = self._action.text().rstrip("…")
        self.setToolTip(action_hint(self._action))
        self.setAccessibleName(f"{text}, {keys}" if keys else text)
        self.setEnabled(self._action.isEnabled())

    def set_icon_text(self, glyph: str, text: str) -> None:
        """Show another sign and word."""
        if (glyph, _icon_spaced_text(text, glyph)) != (self._glyph, self.text()):
            self._glyph = glyph
            self.setText(_icon_spaced_text(text, glyph))
            self._redraw()

    def _redraw(self) -> None:
        if self._glyph:
            side = self._style.px(16)
            self.setIcon(create_icon(self._glyph, self._style.color("text"), side))
            self.setIconSize(QSize(side, side))


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

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
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
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._style.px
        self._row.setContentsMargins(px(16), px(4), px(16), px(6))
        self._row.setSpacing(px(8))
        self.updateGeometry()
        self._fit()

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(320), self._style.sizes.control + self._style.px(10))

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(160), self.sizeHint().height())

    def show_actions(self, offers: Sequence[ActionItem]) -> None:
        if tuple(offers) == self.offers:
            return
        self.offers = tuple(offers)
        while len(self._buttons) < len(offers):
            self._make()
        for index, button in enumerate(self._buttons):
            offer = self.offers[index] if index < len(self.offers) else None
            if offer is None:
                continue
            button.setText(offer.label)
            button.setAccessibleName(offer.label)
            button.setEnabled(not offer.disabled_reason)
            button.setToolTip(plain_tooltip(offer.disabled_reason))
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
        QWidget.setTabOrder(button, self.more)

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
        for index, button in enumerate(self._buttons):
            button.setVisible(index < shown)
        self._menu.clear()
        for offer in self.offers[shown:]:
            entry = self._menu.addAction(offer.label, self._trigger(offer.id))
            entry.setEnabled(not offer.disabled_reason)
        self.more.setVisible(shown < len(self.offers))
        # At once: until the next round of events the new words would stand in the old widths.
        self._row.activate()
