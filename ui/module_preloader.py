"""What is loaded before it is asked for, while nothing on the screen moves that could hitch."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from threading import Thread

from PySide6.QtCore import QObject, QTimer

_MANEUVER_MODULES = ("scipy.signal",)
"""What the first maneuver needs and charts do not: a third of a second to load."""
_PAGE_BACKEND_MODULES = (
    "scipy.special",
    "calibration.plan",
    "calibration.wizard",
    "gsapp.flight.info_checks",
    "gsapp.identification.runs.run_execution",
    "gsapp.session.checklist",
    "gsapp.session.review",
)
"""What the pages of Preflight and Review need, without windows."""
_PAGE_MODULES = (
    "pyqtgraph.Qt",
    "pyqtgraph",
    "ui.preflight.preflight_model",
    "ui.preflight.wizard_calibration_panel",
    "ui.preflight.wizard_page",
    "ui.preflight.flight_card_page",
    "ui.preflight.checklist_page",
    "ui.preflight.cards_page",
    "ui.review.maneuvers_page",
    "ui.review.estimate_page",
    "ui.review.figures_page",
    "ui.review.summary_page",
)
"""The pages; what has to do with windows is loaded where windows are made."""
_IMPORT_INTERVAL_MS = 30  # From one of them to the next, for keys and mouse.


def preload_maneuver_modules() -> None:
    """Load it in a thread: in the middle of a flight the window would stand still for it.

    Even so it hitches once, for a tenth of a second at most.
    """
    _load_in_thread(_MANEUVER_MODULES)


class ModulePreloader(QObject):
    """Loads what maneuvers, Preflight and Review need, from `begin` on, until a flight moves.

    A first visit to one of those places would else hold up a flight for half a second.
    """

    def __init__(self, is_idle: Callable[[], bool], parent: QObject) -> None:
        super().__init__(parent)
        self._is_idle = is_idle
        self._remaining = list(_PAGE_MODULES)
        self._thread: Thread | None = None

    def start(self) -> None:
        """Load in a thread what can be, and the rest bit by bit."""
        self._thread = _load_in_thread(_MANEUVER_MODULES + _PAGE_BACKEND_MODULES)
        self._load_next()

    def _load_next(self) -> None:
        if self._remaining and self._is_idle():
            # One after the other: two threads could want the same module of each other.
            if self._thread is None or not self._thread.is_alive():
                importlib.import_module(self._remaining.pop(0))
            QTimer.singleShot(_IMPORT_INTERVAL_MS, self, self._load_next)


def _load_in_thread(names: tuple[str, ...]) -> Thread:
    def load() -> None:
        for name in names:
            importlib.import_module(name)

    thread = Thread(target=load, name="loading")
    thread.start()
    return thread
