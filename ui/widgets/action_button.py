"""A button that runs a command."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import (
    QAction,
)
from PySide6.QtWidgets import (
    QPushButton,
)

from ui.commands import action_hint, shortcut_text
from ui.display_style import DisplayStyle
from ui.icons import create_icon


def _icon_spaced_text(words: str, glyph: str) -> str:
    # Qt sets sign and word closer than the grid.
    return f" {words}" if glyph else words


class ActionButton(QPushButton):
    """A button that runs a command: same words, same key, grayed with it."""

    def __init__(self, action: QAction, words: str, look: DisplayStyle, glyph: str = "") -> None:
        super().__init__(_icon_spaced_text(words, glyph))
        self._look = look
        self._glyph = glyph
        self._action = action
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.clicked.connect(action.trigger)
        action.changed.connect(self._update_from_action)
        look.changed.connect(self._redraw)
        self._update_from_action()
        self._redraw()

    def _update_from_action(self) -> None:
        keys = shortcut_text(self._action.shortcut().toString())
        text = self._action.text().rstrip("…")
        self.setToolTip(action_hint(self._action))
        self.setAccessibleName(f"{text}, {keys}" if keys else text)
        self.setEnabled(self._action.isEnabled())

    def set_icon_text(self, glyph: str, words: str) -> None:
        """Show another sign and word."""
        if (glyph, _icon_spaced_text(words, glyph)) != (self._glyph, self.text()):
            self._glyph = glyph
            self.setText(_icon_spaced_text(words, glyph))
            self._redraw()

    def _redraw(self) -> None:
        if self._glyph:
            side = self._look.px(16)
            self.setIcon(create_icon(self._glyph, self._look.color("text"), side))
            self.setIconSize(QSize(side, side))
