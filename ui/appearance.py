"""Theme, scale and units: what the keys of the View menu change, live, and what is remembered."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from ui.fonts import sans
from ui.look import SCALES, Look
from ui.settings import SettingsStore
from ui.signs import sign_files
from ui.style import style_sheet
from ui.theme import THEMES


class Appearance(QObject):
    """Applies the look to the whole application and keeps it in the settings.

    Parameters
    ----------
    look : Look
        Shared by all widgets.
    store : SettingsStore
        Remembers.
    """

    def __init__(self, look: Look, store: SettingsStore, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._store = store
        self._signs = sign_files()
        look.changed.connect(self.apply)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what each command does."""
        return {
            "next_theme": self.next_theme,
            **{f"theme_{name}": partial(self._look.set_theme, name) for name in THEMES},
            "units": self.other_units,
            "larger": lambda: self.step_scale(1),
            "smaller": lambda: self.step_scale(-1),
            "normal_size": lambda: self._look.set_scale(SCALES[0]),
        }

    def apply(self) -> None:
        """Put style sheet and font in force, and remember."""
        application = QApplication.instance()
        look = self._look
        sheet = style_sheet(look, self._signs.paths(look))
        # Qt styles every widget anew even with the same sheet, as after a change of units.
        if isinstance(application, QApplication) and application.styleSheet() != sheet:
            application.setFont(sans(look.sizes.body))
            application.setStyleSheet(sheet)
        self._store.change(theme=look.theme.name, scale=look.scale, units=look.units)

    def next_theme(self) -> None:
        """Take the next theme of the three."""
        names = list(THEMES)
        self._look.set_theme(names[(names.index(self._look.theme.name) + 1) % len(names)])

    def other_units(self) -> None:
        """Switch between US customary and SI units."""
        self._look.set_units("SI" if self._look.units == "US" else "US")

    def step_scale(self, steps: int) -> None:
        """Make everything larger or smaller by one step."""
        place = min(range(len(SCALES)), key=lambda index: abs(SCALES[index] - self._look.scale))
        self._look.set_scale(SCALES[min(max(place + steps, 0), len(SCALES) - 1)])
