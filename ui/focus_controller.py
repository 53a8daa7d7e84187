"""What a control needs when it gets the focus: to be in sight, and a name for screen readers."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import (
    QAbstractScrollArea,
    QApplication,
    QComboBox,
    QLabel,
    QScrollArea,
    QWidget,
)


class FocusController(QObject):
    """Scrolls to the control with the focus, and labels it if it is a combo box."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusChanged.connect(self._focus_changed)

    def _focus_changed(self, _former: QWidget | None, now: QWidget | None) -> None:
        if now is None:
            return
        if isinstance(now, QComboBox):
            _label(now)
        if is_out_of_sight(now):
            _scroll_to(now)


def is_out_of_sight(widget: QWidget) -> bool:
    """Return whether no pixel of a widget shows, scrolled away or covered."""
    seen = widget.viewport() if isinstance(widget, QAbstractScrollArea) else widget
    return seen.visibleRegion().isEmpty()


def _scroll_to(widget: QWidget) -> None:
    """Scroll all areas that hold a widget; Qt does so only for Tab from within the area."""
    parent = widget.parentWidget()
    while parent is not None:
        if isinstance(parent, QScrollArea):
            parent.ensureWidgetVisible(widget)
        parent = parent.parentWidget()


def _label(box: QComboBox) -> None:
    """Give a combo box a hidden label with its accessible name if no label stands beside it.

    On Linux Qt takes the name of a combo box from a label whose buddy it is; its accessible name
    counts on Windows and macOS only. `QAccessible::Focus` follows the signal that is used here.
    """
    name, parent, edit = box.accessibleName(), box.parentWidget(), box.lineEdit()
    if edit is not None:
        edit.setAccessibleName(name)
    if not name or parent is None:
        return
    beside = parent.findChildren(QLabel, "", Qt.FindChildOption.FindDirectChildrenOnly)
    if not any(label.buddy() is box for label in beside):
        label = QLabel(name, parent)
        label.hide()
        label.setBuddy(box)
