"""Which keys a focused control keeps for itself before they become commands of the window."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QRectF, Qt
from PySide6.QtGui import QContextMenuEvent, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QTabBar,
    QWidget,
)

from ui.widgets.time_slider import TimeSlider

_ARROWS = frozenset(
    {
        Qt.Key.Key_Left,
        Qt.Key.Key_Right,
        Qt.Key.Key_Up,
        Qt.Key.Key_Down,
        Qt.Key.Key_Home,
        Qt.Key.Key_End,
        Qt.Key.Key_PageUp,
        Qt.Key.Key_PageDown,
    }
)


class ArrowKeyNavigation:
    """Marks a control of one's own that moves by the arrows, as a list does."""


_MOVE_KEYS = frozenset({Qt.Key.Key_Up, Qt.Key.Key_Down})  # With Alt a list moves its line.
_ACTIVATION_KEYS = frozenset({Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter})
_NON_REPEATING_KEYS = _ACTIVATION_KEYS | {Qt.Key.Key_Delete}
"""What these do, they do once for each press, however long they are held."""
_TEXT_INPUTS = (QLineEdit, QPlainTextEdit, QAbstractSpinBox)
_ALLOWED = Qt.KeyboardModifier.KeypadModifier
_RESERVED_KEYS: tuple[tuple[type, frozenset[Qt.Key]], ...] = (
    (QAbstractItemView, _ARROWS | _ACTIVATION_KEYS),
    (QComboBox, _ARROWS | _ACTIVATION_KEYS),
    (QTabBar, _ARROWS),
    (TimeSlider, _ARROWS),
    (ArrowKeyNavigation, _ARROWS | _ACTIVATION_KEYS),
    (QAbstractButton, _ACTIVATION_KEYS),
    (QLineEdit, frozenset({Qt.Key.Key_Return, Qt.Key.Key_Enter})),
)


class ShortcutOverrideFilter(QObject):
    """Event filter of all that has had the focus: lists keep arrows, buttons Space and Enter.

    Letters stay commands of the window everywhere but in text fields, which Qt sees to. A key that
    is held presses, turns or deletes once: a second time would be another line, or back again.
    Shift+F10 opens the context menu; on X11 Qt obeys the menu key alone.

    It is not one of the application, which would see all events: a change of theme sends a hundred
    thousand.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._at_work = False

    def install(self) -> None:
        """Follow the focus from now on."""
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusChanged.connect(self._focus_changed)
            self._focus_changed(None, application.focusWidget())
            self._at_work = True

    def remove(self) -> None:
        """Let all keys be. May be called twice."""
        self._at_work = False

    def _focus_changed(self, _former: QWidget | None, now: QWidget | None) -> None:
        if now is not None:
            now.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if not self._at_work:
            return False
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            if _popup_of_combo_box(watched) or _is_reserved(watched, event):
                event.accept()
                return True
        elif event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            if (popup := _popup_of_combo_box(watched)) is not None:
                return self._commits(popup, event)
            if (
                event.isAutoRepeat()
                and Qt.Key(event.key()) in _NON_REPEATING_KEYS
                and _triggers_action(watched)
            ):
                return True
            if (
                isinstance(watched, QWidget)
                and event.key() == Qt.Key.Key_F10
                and event.modifiers() == Qt.KeyboardModifier.ShiftModifier
            ):
                _open_context_menu(watched)
                return True
            enter = event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter)
            if enter and isinstance(watched, QAbstractButton) and watched.window().isWindow():
                # Outside dialogs Qt presses buttons with Space only.
                watched.click()
                return True
        return False

    def _commits(self, popup: QAbstractItemView, event: QKeyEvent) -> bool:
        """Choose the current row of an opened combo box with Enter or Space, and close it.

        Qt does so for Enter alone, and not with the press but when it asks whether the key is a
        shortcut; the press would then reach the dialog, or open the box again.
        """
        if Qt.Key(event.key()) not in _ACTIVATION_KEYS:
            return False
        if not event.isAutoRepeat():
            popup.removeEventFilter(self)  # until it has the focus again
            asked = QKeyEvent(
                QEvent.Type.ShortcutOverride, Qt.Key.Key_Return, Qt.KeyboardModifier.NoModifier
            )
            QApplication.sendEvent(popup, asked)
        return True


def _open_context_menu(focus: QWidget) -> None:
    """Open the context menu where the menu key would."""
    cursor = focus.inputMethodQuery(Qt.InputMethodQuery.ImCursorRectangle)
    at = cursor.toRect().center() if isinstance(cursor, QRectF) else cursor.center()
    QApplication.sendEvent(
        focus,
        QContextMenuEvent(QContextMenuEvent.Reason.Keyboard, at, focus.mapToGlobal(at)),
    )


def _popup_of_combo_box(watched: QObject) -> QAbstractItemView | None:
    if not isinstance(watched, QAbstractItemView):
        return None
    container = watched.parentWidget()
    inside = container is not None and isinstance(container.parentWidget(), QComboBox)
    return watched if inside else None


def _is_reserved(watched: QObject, event: QKeyEvent) -> bool:
    """Return whether a control, or one that it stands in, keeps a key to itself."""
    if event.key() == Qt.Key.Key_Escape and _edits_in_place(watched):
        return True
    moving = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
    plain = not (event.modifiers() & ~_ALLOWED)
    key = Qt.Key(event.key())
    control: QObject | None = watched
    while isinstance(control, QWidget):
        kind, keys = next(
            (one for one in _RESERVED_KEYS if isinstance(control, one[0])), (None, frozenset())
        )
        if (plain and key in keys) or (moving and kind is QAbstractItemView and key in _MOVE_KEYS):
            return True
        control = None if control.isWindow() else control.parentWidget()
    return False


def _triggers_action(watched: QObject) -> bool:
    """Return whether a key acts here; into a text it is typed, for as long as it is held."""
    if isinstance(watched, QComboBox):
        return not watched.isEditable()
    return isinstance(watched, QWidget) and not isinstance(watched, _TEXT_INPUTS)


def _edits_in_place(watched: QObject) -> bool:
    if not isinstance(watched, QLineEdit):
        return False
    viewport = watched.parentWidget()
    view = viewport.parentWidget() if isinstance(viewport, QWidget) else None
    return isinstance(view, QAbstractItemView)
