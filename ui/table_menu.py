"""The menu of a table under the right button: what the table can do, and copying for a spreadsheet.

Copied texts are what the table shows, separated by tabs.
"""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QGuiApplication, QMouseEvent
from PySide6.QtWidgets import QTableView


class TableMenu(QObject):
    """Puts "Copy value", "Copy row" and "Copy table" into the menu of a table, after its commands.

    Parameters
    ----------
    view : QTableView
    commands : sequence of QAction
        What else the menu offers for the row under the mouse.
    """

    def __init__(self, view: QTableView, commands: Sequence[QAction] = ()) -> None:
        super().__init__(view)
        self._view = view
        view.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        for words, act in (
            ("Copy value", lambda: _copy([[self._cell(view.currentIndex().column())]])),
            ("Copy row", lambda: _copy([self._row(view.currentIndex().row())])),
            ("Copy table", lambda: _copy(self.rows)),
        ):
            action = QAction(words, view)
            action.triggered.connect(act)
            view.addAction(action)
        if commands:
            rule = QAction(view)
            rule.setSeparator(True)
            view.insertActions(view.actions()[0], [*commands, rule])
        # Qt sends the menu to the viewport without choosing the row below the mouse.
        view.viewport().installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        """Choose the cell under the right button before its menu opens."""
        if event.type() == QEvent.Type.MouseButtonPress and isinstance(event, QMouseEvent):
            index = self._view.indexAt(event.position().toPoint())
            selection = self._view.selectionModel()
            if event.button() == Qt.MouseButton.RightButton and index.isValid():
                if selection.isSelected(index):
                    selection.setCurrentIndex(index, selection.SelectionFlag.NoUpdate)
                else:
                    self._view.setCurrentIndex(index)
                return True
        return False

    @property
    def rows(self) -> list[list[str]]:
        """Return the table as texts: the headings, then the rows in their order on screen."""
        model, header = self._view.model(), self._view.verticalHeader()
        titles = [str(model.headerData(column, Qt.Orientation.Horizontal) or "")
                  for column in self._columns()]  # fmt: skip
        first = [] if header.isHidden() else [""]
        return [[*first, *titles], *(self._row(row) for row in range(model.rowCount()))]

    def _columns(self) -> list[int]:
        view = self._view
        return [one for one in range(view.model().columnCount()) if not view.isColumnHidden(one)]

    def _row(self, row: int) -> list[str]:
        model, header = self._view.model(), self._view.verticalHeader()
        if row < 0:
            return []
        name = [] if header.isHidden() else [str(model.headerData(row, Qt.Orientation.Vertical))]
        return [*name, *(str(model.index(row, one).data() or "") for one in self._columns())]

    def _cell(self, column: int) -> str:
        index = self._view.currentIndex().siblingAtColumn(column)
        return str(index.data() or "") if index.isValid() else ""


def _copy(rows: Sequence[Sequence[str]]) -> None:
    lines = ("\t".join(cell.replace("\n", " ") for cell in row) for row in rows)
    QGuiApplication.clipboard().setText("\n".join(lines))
