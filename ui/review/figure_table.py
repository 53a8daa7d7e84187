"""A table of the report in the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import create_label
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.report.document import DocumentTable

_COLUMN_PADDING = 24
"""Points beside the words of a column."""
_MAX_VISIBLE_ROWS = 6
"""Rows in sight."""


class ReportTable(QWidget):
    """Shows one table with its caption; nothing while there is none."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._shown: DocumentTable | None = None
        self.lines: FittedTableView | None = None
        self.hide()

    def show_table(self, table: DocumentTable | None) -> None:
        if table == self._shown:
            return
        self._shown = table
        clear_layout(self._column)
        self.lines = None
        self.setVisible(table is not None)
        if table is None:
            return
        self._column.addWidget(create_label(table.caption, "label", wrap=True))
        widths = {place: self._width(table, place) for place in range(1, len(table.columns))}
        self.lines = FittedTableView(
            self._look, table.caption, table.columns, stretch=0, widths=widths,
            right=table.numeric, most=_MAX_VISIBLE_ROWS,
        )  # fmt: skip
        self.lines.show_rows(
            [TableRow(key=place, cells=row) for place, row in enumerate(table.rows)]
        )
        self._column.addWidget(self.lines)

    def _width(self, table: DocumentTable, place: int) -> int:
        words = (table.columns[place], *(row[place] for row in table.rows))
        metrics = QFontMetrics(self._look.font("body"))
        pixels = max(metrics.horizontalAdvance(one) for one in words)
        return round(pixels / self._look.sizes.scale) + _COLUMN_PADDING
