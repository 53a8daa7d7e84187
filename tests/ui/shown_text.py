"""All text that a window shows, hidden pages included where their widgets keep it: for walks."""

import html
import re
from collections.abc import Iterator
from typing import Any

import pytest
from matplotlib.backends.backend_agg import RendererAgg
from PySide6.QtCore import QAbstractListModel, Qt
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QComboBox,
    QGraphicsView,
    QLabel,
    QLineEdit,
    QMenu,
    QMenuBar,
    QTabBar,
    QTextEdit,
    QWidget,
)

_CELL_ROLES = (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole)


class PaintedText:
    """What is painted while it watches: by widgets of the window, and in figures."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.texts: set[str] = set()
        paint, draw = QPainter.drawText, RendererAgg.draw_text

        def watched_paint(painter: QPainter, *arguments: Any) -> Any:
            self.texts.update(one for one in arguments if isinstance(one, str))
            return paint(painter, *arguments)

        def watched_draw(
            renderer: Any, gc: Any, x: Any, y: Any, text: str, *rest: Any, **more: Any
        ) -> Any:
            self.texts.add(text)
            return draw(renderer, gc, x, y, text, *rest, **more)

        patch.setattr(QPainter, "drawText", watched_paint)
        patch.setattr(RendererAgg, "draw_text", watched_draw)


def shown_texts() -> dict[str, str]:
    found: dict[str, str] = {}
    for top in QApplication.topLevelWidgets():
        if top.isVisible():
            for widget in (top, *top.findChildren(QWidget)):
                if widget.isVisibleTo(top):
                    for text in _texts(widget):
                        if text:
                            plain = _plain(text)
                            found[plain] = f"{type(widget).__name__} in {_path(widget)}"
    return found


def _path(widget: QWidget) -> str:
    names = []
    parent = widget.parentWidget()
    while parent is not None and len(names) < 4:
        names.append(type(parent).__name__)
        parent = parent.parentWidget()
    return " < ".join(names)


def _plain(text: str) -> str:
    return html.unescape(re.sub(r"<[^<>]+>", "", text))


def _texts(widget: QWidget) -> Iterator[str]:
    yield from (widget.toolTip(), widget.accessibleName(), widget.accessibleDescription())
    yield from (widget.statusTip(), widget.whatsThis(), widget.windowTitle())
    if isinstance(widget, QLabel | QAbstractButton):
        yield widget.text()
    elif isinstance(widget, QLineEdit):
        yield from (widget.text(), widget.placeholderText())
    elif isinstance(widget, QTextEdit):
        yield widget.toPlainText()
    elif isinstance(widget, QComboBox):
        yield from (widget.itemText(place) for place in range(widget.count()))
    elif isinstance(widget, QTabBar):
        for place in range(widget.count()):
            yield from (widget.tabText(place), widget.tabToolTip(place))
    elif isinstance(widget, QMenuBar | QMenu):
        yield from _actions(widget)
    elif isinstance(widget, QAbstractItemView):
        yield from _cells(widget)
    elif isinstance(widget, QGraphicsView) and widget.scene() is not None:
        for item in widget.scene().items():
            if item.isVisible():
                yield from _drawn(item)


def _actions(menu: QMenuBar | QMenu) -> Iterator[str]:
    for action in menu.actions():
        yield from (action.text(), action.toolTip(), action.statusTip())
        if action.menu() is not None:
            yield from _actions(action.menu())


def _cells(view: QAbstractItemView) -> Iterator[str]:
    model = view.model()
    if model is None:
        return
    root = view.rootIndex()
    one = isinstance(model, QAbstractListModel)
    columns = range(1 if one else model.columnCount(root))
    for column in columns:
        for role in _CELL_ROLES:
            yield str(model.headerData(column, Qt.Orientation.Horizontal, role) or "")
    for row in range(model.rowCount(root)):
        for column in columns:
            for role in _CELL_ROLES:
                yield str(model.index(row, column, root).data(role) or "")


def _drawn(item: Any) -> Iterator[str]:
    for name in ("toPlainText", "text", "labelString"):
        text = getattr(item, name, None)
        if callable(text):
            yield str(text())
