"""The pilot's page in a window of its own, full screen on a second screen where there is one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from PySide6.QtCore import QEvent, QKeyCombination, QPoint, QRect, Qt, Signal
from PySide6.QtGui import QCloseEvent, QGuiApplication, QKeyEvent, QKeySequence, QScreen
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.commands import FULL_SCREEN_KEYS
from ui.display_style import DisplayStyle
from ui.pilot.pilot_canvas import PilotCanvas
from ui.translation import tr

_WINDOW_SHARE: Final = 0.75
"""Of its screen, where the window does not fill it: on the only one, or after F11 on a second."""


class PilotWindow(QWidget):
    """The page alone; it obeys the keys of the page, F11, and Esc to be closed.

    Parameters
    ----------
    keys : mapping of str to callable
        What keys do, in the portable text of key sequences.
    """

    closed = Signal()

    def __init__(self, look: DisplayStyle, keys: Mapping[str, Callable[[], object]]) -> None:
        super().__init__()
        self.setObjectName("page")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setWindowTitle(tr("Pilot – Ground station"))
        self.setAccessibleName(tr("Pilot page, window of its own"))
        full_screen = dict.fromkeys(FULL_SCREEN_KEYS, self.toggle_full_screen)
        self._keys = {**keys, **full_screen, "Esc": self.close}
        self.canvas = PilotCanvas(look)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.canvas)
        self.setMinimumSize(320, 200)

    def open_on_other_screen(self, main: QWidget) -> None:
        """Fill a screen that the main window is not on, or show a window on the only one."""
        other = find_other_screen(main.screen(), QGuiApplication.screens())
        here = other or main.screen()
        room = here.availableGeometry()
        # In the middle: at its edge the title bar would stand beyond the screen.
        place = QRect(QPoint(), room.size() * _WINDOW_SHARE)
        place.moveCenter(room.center())
        self.setGeometry(place)
        if other is not None:
            self.showFullScreen()
        else:
            self.show()

    def toggle_full_screen(self) -> None:
        self.setWindowState(self.windowState() ^ Qt.WindowState.WindowFullScreen)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        # On macOS the arrows are keys of the keypad, everywhere one Enter is.
        modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        pressed = QKeySequence(QKeyCombination(modifiers, Qt.Key(event.key())))
        act = self._keys.get(pressed.toString())
        if act is None:
            super().keyPressEvent(event)
        else:
            act()

    def closeEvent(self, event: QCloseEvent) -> None:
        super().closeEvent(event)
        self.closed.emit()


def find_other_screen(main: QScreen | None, screens: list[QScreen]) -> QScreen | None:
    """Return a screen that is not the main window's; None where there is but one."""
    return next((screen for screen in screens if screen is not main), None)
