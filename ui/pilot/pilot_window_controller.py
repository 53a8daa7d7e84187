"""Opening and closing the page's own window, and remembering that it was open."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from ui.display_style import DisplayStyle
from ui.pilot.pilot_window import PilotWindow
from ui.settings import SettingsStore

_SHARED_COMMANDS = ("mute", "acknowledge", "pilot_window", "next_theme")
"""Commands of the main window that its keys give here, too."""


class PilotWindowController(QObject):
    """The page's own window, where it is open.

    Parameters
    ----------
    acts : mapping of str to callable
        What those of the page do; they need not be enabled in the main window.
    """

    changed = Signal()

    def __init__(
        self,
        place: QWidget,
        actions: Mapping[str, QAction],
        acts: Mapping[str, Callable[[], object]],
        look: DisplayStyle,
        store: SettingsStore,
    ) -> None:
        super().__init__(place)
        self._place = place
        self._actions = actions
        self._acts = acts
        self._look = look
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
        self.window = PilotWindow(self._look, keys)
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
