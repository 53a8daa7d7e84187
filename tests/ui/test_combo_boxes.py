"""Combo boxes in all places and dialogs: keys choose a row, and the list shows all of them."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QWidget
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import answer_dialog, until, write_flight
from ui.dialogs.connect import ConnectDialog
from ui.dialogs.flight_dialogs import ExportDialog
from ui.dialogs.form_dialog import FormDialog
from ui.main_window import MainWindow

KEYS = {"Enter": Qt.Key.Key_Return, "keypad Enter": Qt.Key.Key_Enter, "Space": Qt.Key.Key_Space}


@pytest.fixture
def flight(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> MainWindow:
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded and window.view.replay.isVisible())
    return window


def boxes(holder: QWidget) -> list[QComboBox]:
    found = [box for box in holder.findChildren(QComboBox) if box.isVisible() and box.isEnabled()]
    return [box for box in found if box.count() > 1]


def assert_list_shows_all(box: QComboBox) -> None:
    box.showPopup()
    view = box.view()
    try:
        area = view.viewport().rect()
        for row in range(min(box.count(), box.maxVisibleItems())):
            shown = view.visualRect(box.model().index(row, 0))
            assert area.contains(shown), (box.accessibleName(), box.itemText(row))
    finally:
        box.hidePopup()


def choose_next(box: QComboBox, key: Qt.Key) -> None:
    before = box.currentIndex()
    heard: list[int] = []
    box.activated.connect(heard.append)
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Space)
    view = box.view()
    assert view.isVisible(), box.accessibleName()
    up = before == box.count() - 1
    QTest.keyClick(view, Qt.Key.Key_Up if up else Qt.Key.Key_Down)
    assert box.currentIndex() == before
    QTest.keyClick(view, key)
    assert not view.isVisible()
    assert box.currentIndex() == before + (-1 if up else 1)
    assert heard == [box.currentIndex()]


@pytest.mark.parametrize("key", KEYS.values(), ids=KEYS)
def test_a_key_chooses_in_a_dialog_and_leaves_it_open(window: MainWindow, key: Qt.Key) -> None:
    chosen: list[str] = []

    def answer(dialog: ConnectDialog) -> None:
        choose_next(dialog.link.kind, key)
        assert dialog.isVisible()
        chosen.append(dialog.link.kind.currentData())
        chosen.append(dialog.link.value)

    answer_dialog(ConnectDialog, answer)
    window.commands.actions["connect"].trigger()
    assert chosen == ["udpout", "udpout:127.0.0.1:14550"]


@pytest.mark.parametrize("key", KEYS.values(), ids=KEYS)
def test_a_key_chooses_on_the_flight_page(flight: MainWindow, key: Qt.Key) -> None:
    before = flight.flight_controller.speed
    choose_next(flight.view.replay.speed, key)
    assert flight.flight_controller.speed != before


def test_esc_leaves_the_choice_as_it_was(flight: MainWindow) -> None:
    box = flight.view.replay.speed
    before = box.currentIndex()
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Space)
    QTest.keyClick(box.view(), Qt.Key.Key_Down)
    QTest.keyClick(box.view(), Qt.Key.Key_Escape)
    assert not box.view().isVisible()
    assert box.currentIndex() == before


@pytest.mark.parametrize("scale", [100, 200])
def test_every_list_of_a_place_shows_its_rows(flight: MainWindow, scale: int) -> None:
    flight.display_style.set_scale(scale)
    seen = 0
    for command in ("place_preflight", "preflight_card", "preflight_cards", "place_flight",
                    "panel_channels", "place_pilot", "place_review", "review_estimate",
                    "review_figures", "place_gap"):  # fmt: skip
        action = flight.commands.actions[command]
        action.trigger()
        QApplication.processEvents()
        for box in boxes(flight):
            seen += 1
            assert_list_shows_all(box)
    assert seen >= 4


@pytest.mark.parametrize(
    ("command", "kind"), [("connect", ConnectDialog), ("export", ExportDialog)]
)
def test_every_list_of_a_dialog_shows_its_rows(
    flight: MainWindow, command: str, kind: type[FormDialog]
) -> None:
    seen: list[str] = []

    def answer(dialog: FormDialog) -> None:
        for box in boxes(dialog):
            assert_list_shows_all(box)
            seen.append(box.accessibleName())

    answer_dialog(kind, answer)
    flight.commands.actions[command].trigger()
    assert seen
