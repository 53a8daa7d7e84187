"""A row of widgets that breaks into further rows where the window is narrow."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtWidgets import QLayout, QLayoutItem, QWidget

LayoutT = TypeVar("LayoutT", bound=QLayout)


def arrange(layout: LayoutT, spacing: int, *margins: int) -> LayoutT:
    """Return a layout with a spacing, and margins left, top, right and bottom; zero by default."""
    layout.setSpacing(spacing)
    layout.setContentsMargins(*margins or (0, 0, 0, 0))
    return layout


def clear_layout(layout: QLayout) -> None:
    """Remove all items of a layout, and delete their widgets."""
    while (item := layout.takeAt(0)) is not None:
        if (widget := item.widget()) is not None:
            widget.hide()
            widget.deleteLater()


class FlowLayout(QLayout):
    """Places its items side by side and begins a new row when one does not fit.

    `fill`: whether what is left of a row's width goes to its items: to those that expand, or else
    to all alike.
    """

    def __init__(self, parent: QWidget, *, spacing: int = 8, fill: bool = False) -> None:
        super().__init__(parent)
        self._items: list[QLayoutItem] = []
        self._fill = fill
        self.setSpacing(spacing)
        self.setContentsMargins(0, 0, 0, 0)

    def addItem(self, item: QLayoutItem) -> None:
        self._items.append(item)

    def count(self) -> int:
        return len(self._items)

    def itemAt(self, index: int) -> QLayoutItem | None:
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index: int) -> QLayoutItem | None:
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self) -> Qt.Orientation:
        return Qt.Orientation(0)

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        return self._place(QRect(0, 0, width, 0), apply=False)

    def setGeometry(self, rect: QRect) -> None:
        super().setGeometry(rect)
        self._place(rect, apply=True)

    def sizeHint(self) -> QSize:
        width = sum(item.sizeHint().width() for item in self._shown())
        width += self.spacing() * max(0, len(self._shown()) - 1)
        margins = self.contentsMargins()
        return QSize(width + margins.left() + margins.right(), self.minimumSize().height())

    def minimumSize(self) -> QSize:
        size = QSize(0, 0)
        for item in self._shown():
            size = size.expandedTo(item.minimumSize())
        margins = self.contentsMargins()
        return size + QSize(margins.left() + margins.right(), margins.top() + margins.bottom())

    def _shown(self) -> list[QLayoutItem]:
        return [item for item in self._items if not item.isEmpty()]

    def _rows(self, width: int) -> list[list[QLayoutItem]]:
        rows: list[list[QLayoutItem]] = []
        used = 0
        for item in self._shown():
            wide = item.sizeHint().width()
            if rows and used + self.spacing() + wide <= width:
                rows[-1].append(item)
                used += self.spacing() + wide
            else:
                rows.append([item])
                used = wide
        return rows

    def _place(self, rect: QRect, *, apply: bool) -> int:
        margins = self.contentsMargins()
        inner = rect.adjusted(margins.left(), margins.top(), -margins.right(), -margins.bottom())
        y = inner.top()
        rows = self._rows(inner.width())
        for row in rows:
            height = max(_height(item, inner.width()) for item in row)
            x = inner.left()
            wanted = sum(item.sizeHint().width() for item in row)
            spare = max(0, inner.width() - wanted - self.spacing() * (len(row) - 1))
            growing = [item for item in row if _expands(item)] or row
            for item in row:
                share = 0
                if self._fill and item in growing:
                    share = spare // (len(growing) - growing.index(item))
                    spare -= share
                width = min(item.sizeHint().width(), inner.width()) + share
                if apply:
                    high = height if self._fill else _height(item, inner.width())
                    item.setGeometry(QRect(QPoint(x, y), QSize(width, high)))
                x += width + self.spacing()
            y += height + self.spacing()
        if rows:
            y -= self.spacing()
        return y - rect.top() + margins.bottom()


def _expands(item: QLayoutItem) -> bool:
    return bool(item.expandingDirections() & Qt.Orientation.Horizontal)


def _height(item: QLayoutItem, room: int) -> int:
    size = item.sizeHint()
    if item.hasHeightForWidth():
        return item.heightForWidth(min(size.width(), room))
    return size.height()
