"""What a screen reader is told of a window, and where the keys lead in it."""

from collections.abc import Iterator

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QAccessible, QAccessibleInterface, QFontMetrics
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QApplication,
    QCheckBox,
    QComboBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QScrollBar,
    QTabBar,
    QTextBrowser,
    QToolButton,
    QWidget,
)

from ui.focus_controller import is_out_of_sight
from ui.window_frame.navigation_rail import ExclusiveButtonGroup
from ui.window_frame.status_bar import StatusItemWidget
from ui.window_frame.step_page import StepButton

Role = QAccessible.Role

_CONTROL_ROLES = frozenset(
    {
        Role.Button, Role.ButtonDropDown, Role.ButtonMenu, Role.CheckBox, Role.ComboBox,
        Role.Dialog, Role.EditableText, Role.List, Role.MenuItem, Role.PageTab, Role.RadioButton,
        Role.Slider, Role.SpinBox, Role.Table, Role.Tree,
    }
)  # fmt: skip
_CELL_ROLES = frozenset({Role.Cell, Role.ListItem, Role.TreeItem})
_HEADER_ROLES = frozenset({Role.ColumnHeader, Role.RowHeader})
_MOUSE_EVENTS = (
    "mousePressEvent", "mouseReleaseEvent", "mouseMoveEvent", "mouseDoubleClickEvent", "wheelEvent",
)  # fmt: skip
_INSIDE = frozenset({"qt_scrollarea_viewport", "ScrollLeftButton", "ScrollRightButton"})
"""Names of parts of Qt's controls that have no keys of their own."""
_MOST_STOPS = 200


def accessible_nodes(node: QAccessibleInterface) -> Iterator[QAccessibleInterface]:
    """Yield a node and all below it that are not hidden."""
    if node.state().invisible:
        return
    yield node
    for index in range(node.childCount()):
        child = node.child(index)
        if child is not None and child.isValid():
            yield from accessible_nodes(child)


def spoken_name(node: QAccessibleInterface) -> str:
    """Return the name; of a combo box not its value, which Qt gives as name on Linux."""
    widget = node.object()
    if isinstance(widget, QComboBox):
        return widget.accessibleName() or label_name(node)
    return node.text(QAccessible.Text.Name)


def label_name(node: QAccessibleInterface) -> str:
    """Return the text of the label that a screen reader finds for a control."""
    for other, relation in node.relations():
        if relation == QAccessible.RelationFlag.Label:
            return other.text(QAccessible.Text.Name)
    return ""


def handles_mouse(widget: QObject | None) -> bool:
    """Return whether a widget of the program's own handles the mouse itself."""
    own = (kind for kind in type(widget).__mro__ if kind.__module__.startswith("ui."))
    return any(name in vars(kind) for kind in own for name in _MOUSE_EVENTS)


def unnamed_controls(top: QWidget) -> Iterator[str]:
    """Yield the path of each control without a name, or with one of signs only."""
    for node in accessible_nodes(QAccessible.queryAccessibleInterface(top)):
        widget = node.object()
        role, state = node.role(), node.state()
        is_own = isinstance(widget, QWidget) and (
            handles_mouse(widget)
            or (widget.focusPolicy() != Qt.FocusPolicy.NoFocus and widget.focusProxy() is None)
        )
        if isinstance(widget, QScrollBar | QLabel):
            continue  # The keys of what it scrolls; its own text.
        if role in _CELL_ROLES:
            needs, letters = bool(state.checkable), True
        else:
            needs = role in _CONTROL_ROLES | _HEADER_ROLES or is_own
            letters = role not in _HEADER_ROLES
        name = spoken_name(node)
        if needs and not (any(map(str.isalpha, name)) if letters else name.strip()):
            yield f"{role.name} {name!r} of {_path(node)}"


def _path(node: QAccessibleInterface | None) -> str:
    names: list[str] = []
    while node is not None and node.isValid() and len(names) < 4:
        widget = node.object()
        names.append(type(widget).__name__ if widget is not None else node.role().name)
        node = node.parent()
    return " < ".join(names)


def describe(widget: QWidget | None) -> str:
    if widget is None:
        return "nothing"
    node = QAccessible.queryAccessibleInterface(widget)
    return f"{type(widget).__name__} {spoken_name(node)!r}"


def controls(top: QWidget) -> Iterator[QWidget]:
    """Yield what one can press, choose from, type into or drag."""
    kinds = (QAbstractButton, QComboBox, QLineEdit, QPlainTextEdit, QAbstractItemView,
             QAbstractSlider, QTabBar)  # fmt: skip
    for widget in top.findChildren(QWidget):
        if widget.window() is not top or not widget.isVisible() or not widget.isEnabled():
            continue
        if isinstance(widget, QScrollBar | QHeaderView | QLabel) or widget.objectName() in _INSIDE:
            continue
        has_menu = widget.contextMenuPolicy() == Qt.ContextMenuPolicy.ActionsContextMenu
        wanted = isinstance(widget, kinds) or handles_mouse(widget)
        if widget.focusProxy() is None and (wanted or (has_menu and widget.actions())):
            yield widget


def is_reached_by_arrows(widget: QWidget) -> bool:
    """Return whether Tab stops at one of a group, and arrows lead from there to the widget."""
    if isinstance(widget, StatusItemWidget):
        return True
    return isinstance(widget, QAbstractButton) and isinstance(widget.group(), ExclusiveButtonGroup)


class TabRing:
    """Where Tab leads from the focus until it comes round."""

    def __init__(self, top: QWidget) -> None:
        self.stops: list[QWidget] = []
        self.out_of_sight: list[QWidget] = []
        self.start = QApplication.focusWidget()
        self.trap = ""
        while len(self.stops) < _MOST_STOPS:
            _press_tab(Qt.Key.Key_Tab)
            focus = QApplication.focusWidget()
            if focus is None or focus.window() is not top:
                self.trap = f"Tab leaves the window after {describe(self._last)}"
                return
            if self.stops and focus is self._last and isinstance(focus, QTextBrowser):
                continue  # From link to link.
            if focus in self.stops:
                break
            self.stops.append(focus)
            if is_out_of_sight(focus) and not focus.size().isEmpty():
                self.out_of_sight.append(focus)
        if self.stops and focus is not self.stops[0]:
            self.trap = f"Tab goes round from {describe(self._last)} to {describe(focus)}"
            return
        self._go_back()

    @property
    def _last(self) -> QWidget | None:
        return self.stops[-1] if self.stops else self.start

    def _go_back(self) -> None:
        """Find out whether Shift+Tab leads the same way back."""
        for stop in [*self.stops[:0:-1], self.stops[0]]:
            former = QApplication.focusWidget()
            _press_tab(Qt.Key.Key_Backtab)
            while isinstance(former, QTextBrowser) and former.hasFocus():
                _press_tab(Qt.Key.Key_Backtab)
            if QApplication.focusWidget() is not stop:
                self.trap = f"Shift+Tab misses {describe(stop)}"
                return


def _press_tab(key: Qt.Key) -> None:
    shift, none = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.NoModifier
    focus = QApplication.focusWidget()
    if focus is not None:
        QTest.keyClick(focus, key, shift if key == Qt.Key.Key_Backtab else none)


def cut_texts(top: QWidget) -> Iterator[str]:
    """Yield each text of a label, button or tab that has less room than it needs."""
    for widget in top.findChildren(QWidget):
        if widget.window() is not top or not widget.isVisible():
            continue
        if isinstance(widget, QTabBar):
            yield from _cut_tabs(widget)
        elif isinstance(widget, StepButton):
            if widget.is_title_cut:
                yield f"title of {describe(widget)}"
        elif isinstance(widget, QLabel | QPushButton | QToolButton | QCheckBox) and widget.text():
            wraps = isinstance(widget, QLabel) and widget.wordWrap()
            need = widget.sizeHint()
            high = widget.heightForWidth(widget.width()) if wraps else need.height()
            elided = type(widget).__name__ == "_ElidedLabel"  # The tool tip has it whole.
            if not wraps and not elided and widget.width() < need.width() - 1:
                yield f"{describe(widget)}: {widget.width()} of {need.width()} pixels wide"
            if widget.height() < high - 1:
                yield f"{describe(widget)}: {widget.height()} of {high} pixels high"


def _cut_tabs(bar: QTabBar) -> Iterator[str]:
    words = QFontMetrics(bar.font())
    for index in range(bar.count()):
        box, text = bar.tabRect(index), bar.tabText(index)
        if box.width() < bar.minimumTabSizeHint(index).width() or not bar.rect().contains(box):
            yield f"tab {text!r}: {box.width()} of {words.horizontalAdvance(text)} pixels"
