"""The pilot's page in a window of its own, full screen on a second screen where there is one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from PySide6.QtCore import QEvent, QKeyCombination, QObject, QPoint, QRect, Qt, Signal
from PySide6.QtGui import QAction, QCloseEvent, QGuiApplication, QKeyEvent, QKeySequence, QScreen
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.commands import FULL_SCREEN_KEYS
from ui.display_style import DisplayStyle
from ui.pilot.pilot_canvas import PilotCanvas
from ui.settings import SettingsStore
from ui.translation import tr

_WINDOW_SHARE: Final = 0.75
"""Of its screen, where the window does not fill it: on the only one, or after F11 on a second."""


class PilotWindow(QWidget):
    """The page alone; it obeys `keys` (portable key sequences), F11, and Esc to be closed."""

    closed = Signal()

    def __init__(self, style: DisplayStyle, keys: Mapping[str, Callable[[], object]]) -> None:
        super().__init__()
        self.setObjectName("page")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setWindowTitle(tr("Pilot – Ground station"))
        self.setAccessibleName(tr("Pilot page, separate window"))
        full_screen = dict.fromkeys(FULL_SCREEN_KEYS, self.toggle_full_screen)
        self._keys = {**keys, **full_screen, "Esc": self.close}
        self.canvas = PilotCanvas(style)
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


_SHARED_COMMANDS = ("mute", "acknowledge", "pilot_window", "next_theme")
"""Commands of the main window that its keys give here, too."""


class PilotWindowController(QObject):
    """The page's own window; commands act there even where the main window has them gray."""

    changed = Signal()

    def __init__(
        self,
        place: QWidget,
        actions: Mapping[str, QAction],
        acts: Mapping[str, Callable[[], object]],
        style: DisplayStyle,
        store: SettingsStore,
    ) -> None:
        super().__init__(place)
        self._place = place
        self._actions = actions
        self._acts = acts
        self._style = style
        self._store = store
        self.window: PilotWindow | None = None

    def toggle(self) -> None:
        if self.window is None:
            self.open()
        else:
            self.window.close()

    def open(self) -> None:
        """Open it, on another screen if there is one."""
        acts = {**{name: self._actions[name].trigger for name in _SHARED_COMMANDS}, **self._acts}
        keys = {
            key.toString(): act
            for name, act in acts.items()
            for key in self._actions[name].shortcuts()
        }
        self.window = PilotWindow(self._style, keys)
        self.window.closed.connect(self._closed)
        self.window.open_on_other_screen(self._place.window())
        self._remember(is_open=True)

    def _closed(self) -> None:
        self.window = None
        self._remember(is_open=False)

    def _remember(self, *, is_open: bool) -> None:
        self._store.change(pilot_window=is_open)
        self._actions["pilot_window"].setChecked(is_open)
        self.changed.emit()

    def close_with_main(self) -> None:
        """Close it with the main window; it is remembered as open."""
        window, self.window = self.window, None
        if window is not None:
            window.closed.disconnect()
            window.close()
            window.deleteLater()
