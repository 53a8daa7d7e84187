"""A plain table of words that wraps, for a few rows."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QVBoxLayout, QWidget

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.table_menu import create_table_actions


class TextTable(QWidget):
    """A heading, heads of columns, rows; or a sentence where there are none."""

    def __init__(self, look: DisplayStyle, title: str, heads: Sequence[str], stretch: int) -> None:
        super().__init__()
        self._look = look
        self._heads = tuple(map(tr, heads))
        self._rows: tuple[tuple[str, ...], ...] | None = None
        self._stretch = stretch
        self.setAccessibleName(title)
        self._column = column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(create_label(title, "heading", wrap=True))
        self.empty_label = create_label("", "muted", wrap=True)
        column.addWidget(self.empty_label)
        self._holder = QWidget()
        column.addWidget(self._holder)
        self.addActions(create_table_actions(self, lambda: (self._heads, *(self._rows or ()))))
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def show_rows(self, rows: Sequence[Sequence[str]], none: str) -> None:
        units = self._look.units
        made = tuple(tuple(convert_text_units(cell, units) for cell in row) for row in rows)
        self.empty_label.setText(none)
        self.empty_label.setVisible(not made)
        if made == self._rows:
            return
        self._rows = made
        # Never without a parent: it would be a window of its own for a moment.
        holder = QWidget(self)
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(self._look.px(16))
        grid.setVerticalSpacing(self._look.px(6))
        grid.setColumnStretch(self._stretch, 1)
        for place, head in enumerate(self._heads):
            grid.addWidget(create_label(head, "label", wrap=place == self._stretch), 0, place)
        for line, row in enumerate(made, start=1):
            for place, text in enumerate(row):
                cell = create_label(
                    text, "strong" if place == 0 else "", wrap=place >= self._stretch
                )
                grid.addWidget(cell, line, place, Qt.AlignmentFlag.AlignTop)
        holder.setVisible(bool(made))
        self._column.replaceWidget(self._holder, holder)
        self._holder.hide()
        self._holder.deleteLater()
        self._holder = holder
        self.setAccessibleDescription("; ".join(", ".join(row) for row in made) or none)
