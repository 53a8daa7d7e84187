"""The menu of a table: it copies what the table shows, as tabs and lines."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QStandardItem, QStandardItemModel
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QTableView
from pytestqt.qtbot import QtBot

from ui.look import Look
from ui.pilot.text_table import TextTable
from ui.table_menu import TableMenu


@pytest.fixture
def table(qtbot: QtBot) -> QTableView:
    view = QTableView()
    qtbot.addWidget(view)
    model = QStandardItemModel(view)
    model.setHorizontalHeaderLabels(["Derivative", "Mean", "Bound"])
    for cells in (("Cmα", "−0.3", "0.01"), ("Cmq", "−9", "0.01")):
        model.appendRow([QStandardItem(cell) for cell in cells])
    view.setModel(model)
    view.verticalHeader().hide()
    TableMenu(view)
    view.resize(400, 200)
    with qtbot.waitExposed(view):
        view.show()
    return view


def trigger(view: QTableView | TextTable, words: str) -> list[list[str]]:
    """Choose an entry of the menu; return the clipboard as cells."""
    next(one for one in view.actions() if one.text() == words).trigger()
    return [line.split("\t") for line in QApplication.clipboard().text().split("\n")]


def test_a_value_a_row_and_the_table_are_copied(table: QTableView) -> None:
    """The right button first chooses the cell below it, as the menu is about that."""
    place = table.visualRect(table.model().index(1, 1)).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.RightButton, pos=place)
    assert table.currentIndex().row() == 1
    assert trigger(table, "Copy value") == [["−9"]]
    assert trigger(table, "Copy row") == [["Cmq", "−9", "0.01"]]
    whole = trigger(table, "Copy table")
    assert whole == [
        ["Derivative", "Mean", "Bound"],
        ["Cmα", "−0.3", "0.01"],
        ["Cmq", "−9", "0.01"],
    ]
    table.setColumnHidden(2, True)
    assert trigger(table, "Copy table") == [row[:2] for row in whole]


def test_a_press_beside_the_rows_changes_nothing(table: QTableView) -> None:
    table.selectRow(0)
    QTest.mouseClick(table.viewport(), Qt.MouseButton.RightButton, pos=QPoint(5, 198))
    assert table.currentIndex().row() == 0


def test_commands_of_the_table_come_first(qtbot: QtBot) -> None:
    view = QTableView()
    qtbot.addWidget(view)
    command = QAction("Zoom to the maneuver", view)
    TableMenu(view, [command])
    words = [one.text() for one in view.actions()]
    assert words == ["Zoom to the maneuver", "", "Copy value", "Copy row", "Copy table"]


def test_tables_of_the_debrief_are_copied(qtbot: QtBot) -> None:
    table = TextTable(Look(), "Score by card", ("Card", "Good"), 1)
    qtbot.addWidget(table)
    table.show_rows([("C1", "3"), ("C2", "1")], "none")
    assert trigger(table, "Copy table") == [["Card", "Good"], ["C1", "3"], ["C2", "1"]]
