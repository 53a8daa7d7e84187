"""Taking the keys of the sticks from the page while a trainee flies."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

from ui.pilot.stick_keys import StickKeys
from ui.pilot.training_flight import TrainingFlight

_MODIFIERS: Final = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.KeypadModifier
    | Qt.KeyboardModifier.ShiftModifier
)
"""Keys with any other one are commands, as ever."""


class StickKeyFilter(QObject):
    """Event filter of the page: keys of the sticks move them, and are no commands meanwhile."""

    def __init__(self, training: TrainingFlight, page: QWidget) -> None:
        super().__init__(page)
        self._training = training
        page.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind == QEvent.Type.FocusOut:
            self._training.keys.release_all()
        elif isinstance(event, QKeyEvent) and self._is_ours(event):
            key = Qt.Key(event.key())
            if kind == QEvent.Type.KeyPress:
                trim = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
                self._training.press(key, trim=trim, again=event.isAutoRepeat())
            elif kind == QEvent.Type.KeyRelease and not event.isAutoRepeat():
                self._training.release(key)
            event.accept()
            return True
        return False

    def _is_ours(self, event: QKeyEvent) -> bool:
        if not StickKeys.is_stick_key(Qt.Key(event.key())):
            return False
        # A key that went down while the trainee had it may come up later.
        released = event.type() == QEvent.Type.KeyRelease
        return released or (
            self._training.trainee_has_control and not event.modifiers() & ~_MODIFIERS
        )
