"""The menu of a table under the right button: its commands, and copying and saving as CSV.

Copied texts are what the table shows, separated by tabs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from PySide6.QtCore import QEvent, QModelIndex, QObject, Qt
from PySide6.QtGui import (
    QAction,
    QContextMenuEvent,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
)
from PySide6.QtWidgets import QAbstractItemView, QTableView, QWidget

from gsapp.foundation.delimited_text import delimited_text
from ui.dialogs.file_dialogs import ask_and_save
from ui.number_format import MINUS, sanitize_file_name
from ui.translation import tr

TableRows = Sequence[Sequence[str]]


def copy_rows(rows: TableRows) -> None:
    """Put rows on the clipboard, for a spreadsheet."""
    text = delimited_text(([cell.replace("\n", " ") for cell in row] for row in rows), "\t")
    QGuiApplication.clipboard().setText(text.removesuffix("\n"))


def format_csv(rows: TableRows) -> str:
    """Return rows as CSV, with the minus sign that other programs read."""
    return delimited_text([cell.replace(MINUS, "-") for cell in row] for row in rows)


def create_table_actions(owner: QWidget, table: Callable[[], TableRows]) -> tuple[QAction, ...]:
    """Return what every table offers.

    `owner`: its accessible name names the file.
    """

    def save() -> None:
        start = Path.home() / f"{sanitize_file_name(owner.accessibleName()) or 'table'}.csv"
        kinds = tr("Table (*.csv)")
        ask_and_save(
            owner, tr("Save as CSV"), start, kinds, lambda _path: format_csv(table()).encode()
        )

    return (
        _action(owner, tr("Copy table"), lambda: copy_rows(table())),
        _action(
            owner,
            tr("Copy as CSV"),
            lambda: QGuiApplication.clipboard().setText(format_csv(table())),
        ),
        _action(owner, tr("Save as CSV…"), save),
    )


def _action(owner: QWidget, text: str, act: Callable[[], object]) -> QAction:
    action = QAction(text, owner)
    action.triggered.connect(lambda _checked=False: act())
    return action


class TableMenu(QObject):
    """Puts copying and saving into the menu of a table or list, after its commands.

    Ctrl+C copies the selected rows.

    `table`: returns headings and rows as texts, where the cells of the model are not texts.
    """

    def __init__(
        self,
        view: QAbstractItemView,
        commands: Sequence[QAction] = (),
        table: Callable[[], TableRows] | None = None,
    ) -> None:
        super().__init__(view)
        self._view = view
        self._table = table
        self._followed: list[tuple[QAction, QWidget]] = []
        view.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self._of_row = [_action(view, tr("Copy row"), lambda: copy_rows(self._selected()))]
        if table is None:
            self._of_row.insert(
                0, _action(view, tr("Copy value"), lambda: copy_rows([[self._cell]]))
            )
        view.addActions([*self._of_row, *create_table_actions(view, lambda: self.rows)])
        self._rule: QAction | None = None
        for command in commands:
            self._add(command)
        # Qt sends the menu to the viewport without choosing the row below the mouse.
        view.viewport().installEventFilter(self)
        view.installEventFilter(self)

    def _add(self, command: QAction) -> None:
        if self._rule is None:
            self._rule = QAction(self._view)
            self._rule.setSeparator(True)
            self._view.insertAction(self._of_row[0], self._rule)
        self._view.insertAction(self._rule, command)

    def add_command(
        self, text: str, act: Callable[[], object], follows: QWidget | None = None
    ) -> None:
        """Offer something further for the row, for as long as its button `follows` is enabled."""
        action = _action(self._view, text, act)
        self._add(action)
        if follows is None:
            self._of_row.append(action)
        else:
            self._followed.append((action, follows))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        view = self._view
        if isinstance(event, QContextMenuEvent):
            self._enable()
        elif event.type() == QEvent.Type.MouseButtonPress and isinstance(event, QMouseEvent):
            index = view.indexAt(event.position().toPoint())
            right = event.button() == Qt.MouseButton.RightButton
            if watched is view.viewport() and right and index.isValid():
                self._choose(index)
                return True
        elif (
            watched is view
            and event.type() == QEvent.Type.KeyPress
            and isinstance(event, QKeyEvent)
            and event.matches(QKeySequence.StandardKey.Copy)
        ):
            copy_rows(self._selected())
            return True
        return False

    def _choose(self, index: QModelIndex) -> None:
        selection = self._view.selectionModel()
        if selection.isSelected(index):
            selection.setCurrentIndex(index, selection.SelectionFlag.NoUpdate)
        else:
            self._view.setCurrentIndex(index)

    def _enable(self) -> None:
        """Gray what is about a row where there is none."""
        has_row = self._view.currentIndex().isValid()
        for action in self._of_row:
            action.setEnabled(has_row)
        for action, button in self._followed:
            action.setEnabled(button.isEnabled())

    @property
    def rows(self) -> TableRows:
        """Return the table as texts: the headings, then the rows in their order on screen."""
        view = self._view
        if self._table is not None or not isinstance(view, QTableView):
            return () if self._table is None else self._table()
        model, header = view.model(), view.verticalHeader()
        sideways, down = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        columns = [at for at in range(model.columnCount()) if not view.isColumnHidden(at)]
        named = not header.isHidden()
        titles = [str(model.headerData(column, sideways) or "") for column in columns]
        rows = [[*([""] if named else []), *titles]]
        for row in range(model.rowCount()):
            name = [str(model.headerData(row, down))] if named else []
            rows.append([*name, *(str(model.index(row, at).data() or "") for at in columns)])
        return rows

    def _selected(self) -> TableRows:
        """Return the rows that are selected, or else the one that the keyboard is on."""
        index = self._view.currentIndex()
        chosen: Iterable[QModelIndex] = self._view.selectionModel().selectedIndexes()
        places = sorted({one.row() for one in chosen} or ({index.row()} - {-1}))
        rows = self.rows
        return [rows[place + 1] for place in places]

    @property
    def _cell(self) -> str:
        return str(self._view.currentIndex().data() or "")
