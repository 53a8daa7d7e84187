"""Sections of a form in as many columns as the window has room for."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.widgets.labels import create_label

_MIN_COLUMN_WIDTH = 360
"""Points a column needs."""


class FormSection(QFrame):
    """A framed part of a form: heading, then rows of fields."""

    def __init__(self, look: DisplayStyle, title: str) -> None:
        super().__init__()
        self._look = look
        self.setObjectName("card")
        self.column = QVBoxLayout(self)
        self.column.addWidget(create_label(title, "heading"))
        look.changed.connect(self._fit)
        self._fit()

    def add(self, *widgets: QWidget) -> None:
        for widget in widgets:
            self.column.addWidget(widget)

    def _fit(self) -> None:
        px = self._look.px
        self.column.setContentsMargins(px(16), px(12), px(16), px(12))
        self.column.setSpacing(px(8))


class FormColumns(QScrollArea):
    """Sections that stand in columns and scroll down."""

    def __init__(self, look: DisplayStyle, most: int = 3) -> None:
        super().__init__()
        self._look = look
        self._most = most
        self._sections: tuple[tuple[QWidget, int], ...] = ()
        self._shown = 0
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        page = QWidget()
        page.setObjectName("page")
        self._outer = QVBoxLayout(page)
        self.head = QVBoxLayout()
        self._outer.addLayout(self.head)
        self._row = QHBoxLayout()
        self._outer.addLayout(self._row)
        self._outer.addStretch(1)
        self._columns = [QVBoxLayout() for _ in range(most)]
        for column in self._columns:
            column.addStretch(1)
            self._row.addLayout(column, 1)
        self.setWidget(page)
        look.changed.connect(self._fit)

    def show_sections(self, sections: Sequence[tuple[QWidget, int]]) -> None:
        """Show the sections, each with its column where there is room for all columns."""
        self._sections = tuple(sections)
        self._shown = 0
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self._look.px
        margin = px(16)
        self._outer.setContentsMargins(margin, margin, margin, margin)
        self._outer.setSpacing(margin)
        self._row.setSpacing(margin)
        for column in self._columns:
            column.setSpacing(margin)
        room = self.viewport().width() - 2 * margin
        count = min(max((room + margin) // (px(_MIN_COLUMN_WIDTH) + margin), 1), self._most)
        if count == self._shown or not self._sections:
            return
        self._shown = count
        for place, column in enumerate(self._columns):
            self._row.setStretch(place, 1 if place < count else 0)
            for section, _wish in self._sections:
                # An item that is taken out instead goes on measuring the widget in its stead.
                column.removeWidget(section)
        for section, wish in self._sections:
            column = self._columns[min(wish, count - 1)]
            column.insertWidget(column.count() - 1, section)
