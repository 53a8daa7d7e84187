"""The menu of a table: it copies what the table shows, as tabs and lines."""

import csv
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QStandardItem, QStandardItemModel
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QTableView, QWidget
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import answer_dialog
from ui.display_style import DisplayStyle
from ui.flight.channel_panel import ChannelPanel
from ui.pilot.debrief_page import TextTable
from ui.strips.strip_layout import StripLayout
from ui.widgets.status_list import StatusListItem, StatusListView
from ui.widgets.table_menu import TableMenu


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


def trigger(view: QWidget, text: str) -> list[list[str]]:
    next(one for one in view.actions() if one.text() == text).trigger()
    return [line.split("\t") for line in QApplication.clipboard().text().split("\n")]


def test_a_value_a_row_and_the_table_are_copied(table: QTableView) -> None:
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
    text = [one.text() for one in view.actions()]
    assert text == [
        "Zoom to the maneuver", "", "Copy value", "Copy row", "Copy table", "Copy as CSV",
        "Save as CSV…",
    ]  # fmt: skip


def test_tables_of_the_debrief_are_copied(qtbot: QtBot) -> None:
    table = TextTable(DisplayStyle(), "Score by card", ("Card", "Good"), 1)
    qtbot.addWidget(table)
    table.show_rows([("C1", "3"), ("C2", "1")], "none")
    assert trigger(table, "Copy table") == [["Card", "Good"], ["C1", "3"], ["C2", "1"]]


def test_a_table_is_saved_as_csv_with_a_minus_that_other_programs_read(
    table: QTableView, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = (str(tmp_path / "values"), "Table (*.csv)")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: chosen)
    trigger(table, "Save as CSV…")
    with (tmp_path / "values.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows == [["Derivative", "Mean", "Bound"], ["Cmα", "-0.3", "0.01"], ["Cmq", "-9", "0.01"]]
    assert trigger(table, "Copy as CSV")[:-1] == [[",".join(row)] for row in rows]
    # A disk that refuses is told.
    told: list[str] = []
    answer_dialog(QMessageBox, lambda box: told.append(box.text()))
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "values.csv" / "x.csv"), "")
    )
    trigger(table, "Save as CSV…")
    assert len(told) == 1


def test_a_list_of_painted_lines_is_copied_and_offers_its_commands(qtbot: QtBot) -> None:
    command = QAction("Show in charts")
    listed = StatusListView(DisplayStyle(), "Maneuvers", [command])
    qtbot.addWidget(listed)
    listed.set_items([
        StatusListItem(key="M1", text="M1  elevator doublet", state_text="good"),
        StatusListItem(key="M2", text="M2  rudder doublet", state_text="too small"),
    ])  # fmt: skip
    listed.resize(500, 300)
    with qtbot.waitExposed(listed):
        listed.show()
    assert listed.actions()[0] is command
    place = listed.visualRect(listed.row_model.index(1, 0)).center()
    QTest.mouseClick(listed.viewport(), Qt.MouseButton.RightButton, pos=place)
    assert listed.current_key == "M2"
    assert trigger(listed, "Copy row") == [["M2  rudder doublet", "", "too small", ""]]
    assert len(trigger(listed, "Copy table")) == 3


def test_channels_and_charts_have_menus(qtbot: QtBot) -> None:
    panel = ChannelPanel(DisplayStyle())
    qtbot.addWidget(panel)
    asked: list[StripLayout] = []
    panel.charts_changed.connect(asked.append)
    panel.show_channels(("alpha", "q"), StripLayout(), {})
    leaf = next(one for one in panel._channel_items() if one.text(0).endswith("Pitch rate"))
    panel.tree.setCurrentItem(leaf)
    trigger(panel.tree, "Show or hide in the charts")
    assert asked[-1].channels == ("q",)
    assert [row[-1] for row in trigger(panel.tree, "Copy table")][1:] == ["no", "yes"]
    panel.order.setCurrentRow(panel.order.count() - 1)
    trigger(panel.order, "Remove")
    assert asked[-1].channels == ()
