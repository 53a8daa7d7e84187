"""What the mouse does, done by keys: status bar, rail, menus, figures, time line, side panel."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMenu
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import SHIFT, activate, open_small_flight, opened_window, press, until
from ui.display_style import DisplayStyle
from ui.flight.side_panels import AlarmsPanel
from ui.main_window import MainWindow
from ui.review.timeline import Timeline
from ui.widgets.analysis_plot import AnalysisPlot, PlotCurve
from ui.widgets.row_model import TableRow

pytestmark = pytest.mark.usefixtures("alone")


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest,
           qapp: QApplication) -> Iterator[MainWindow]:  # fmt: skip
    qtbot, folder = QtBot(request), tmp_path_factory.mktemp("keys")
    with opened_window(folder) as window:
        yield open_small_flight(window, qtbot, folder)


@pytest.fixture
def flight(shared: MainWindow) -> MainWindow:
    QTest.qWait(0)  # Menus and tool tips of the test before close.
    shared.activateWindow()
    QTest.qWaitForWindowActive(shared)
    shared.show_page("flight")
    return shared


def menu_opened_by(qtbot: QtBot, key: Qt.Key, modifier: Qt.KeyboardModifier) -> list[str]:
    """Return the entries of the menu that a key opens; the menu is closed again."""
    entries: list[str] = []

    def look() -> None:
        menu = QApplication.activePopupWidget()
        if isinstance(menu, QMenu):
            entries.extend(action.text() for action in menu.actions() if action.text())
            menu.close()
        else:
            QTimer.singleShot(20, look)

    QTimer.singleShot(20, look)
    press(qtbot, key, modifier)
    until(qtbot, lambda: bool(entries))
    return entries


def test_the_status_bar_is_walked_and_pressed_by_keys(flight: MainWindow, qtbot: QtBot) -> None:
    tiles = flight.status_bar.item_widgets
    assert next(iter(tiles.values())).focusPolicy() == Qt.FocusPolicy.TabFocus
    next(iter(tiles.values())).setFocus()
    while not tiles["sound"].hasFocus():
        former = QApplication.focusWidget()
        press(qtbot, Qt.Key.Key_Right)
        assert QApplication.focusWidget() is not former
    muted = flight.store.current.muted
    press(qtbot, Qt.Key.Key_Return)
    assert flight.store.current.muted is not muted
    press(qtbot, Qt.Key.Key_Space)
    assert flight.store.current.muted is muted
    press(qtbot, Qt.Key.Key_Left)
    assert not tiles["sound"].hasFocus()
    # The mouse presses it once, and leaves the keyboard where it was.
    qtbot.mouseClick(tiles["sound"], Qt.MouseButton.LeftButton)
    assert flight.store.current.muted is not muted
    assert not tiles["sound"].hasFocus()
    flight.commands.actions["mute"].trigger()


def test_arrows_go_from_place_to_place_while_charts_are_shown(
    flight: MainWindow, qtbot: QtBot
) -> None:
    """Up and Down are keys of the charts, too."""
    flight.navigation_rail.buttons["flight"].setFocus()
    press(qtbot, Qt.Key.Key_Down)
    assert flight.navigation_rail.buttons["pilot"].isChecked()


def test_shift_f10_opens_the_menu_of_charts_and_of_tables(flight: MainWindow, qtbot: QtBot) -> None:
    flight.view.charts.setFocus()
    until(qtbot, flight.view.charts.hasFocus)
    assert menu_opened_by(qtbot, Qt.Key.Key_F10, SHIFT)
    activate(qtbot, flight)
    flight.view.show_panel(0)
    flight.view.channels.tree.setFocus()
    until(qtbot, flight.view.channels.tree.hasFocus)
    assert menu_opened_by(qtbot, Qt.Key.Key_F10, SHIFT)


def test_menus_have_mnemonics_of_their_own(flight: MainWindow, qtbot: QtBot) -> None:
    titles = [action.text() for action in flight.menuBar().actions()]
    letters = [title[title.index("&") + 1].casefold() for title in titles]
    assert len(set(letters)) == len(titles) >= 8


def test_the_side_panel_is_made_wider_and_narrower_by_keys(
    flight: MainWindow, qtbot: QtBot
) -> None:
    flight.view.show_panel(2)
    before = flight.view.tabs.width()
    flight.view.charts.setFocus()
    press(qtbot, Qt.Key.Key_F9, SHIFT, times=2)
    until(qtbot, lambda: flight.view.tabs.width() == before + 64)
    press(qtbot, Qt.Key.Key_F9, Qt.KeyboardModifier.ControlModifier)
    until(qtbot, lambda: flight.view.tabs.width() == before + 32)


def test_alarms_are_sorted_from_their_menu(qtbot: QtBot) -> None:
    panel = AlarmsPanel(DisplayStyle())
    qtbot.addWidget(panel)
    rows = [
        TableRow(key=key, cells=(key, text, "", "", "")) for key, text in (("1", "b"), ("2", "a"))
    ]
    panel.show_rows(rows)
    sort = next(one for one in panel.view.actions() if one.text() == "Sort by Alarm")
    for expected in (["a", "b"], ["b", "a"]):
        sort.trigger()
        assert [row.cells[1] for row in panel.view.row_model.rows] == expected


def test_values_of_a_figure_are_read_by_keys(qtbot: QtBot) -> None:
    plot = AnalysisPlot(DisplayStyle(), "Test")
    qtbot.addWidget(plot)
    x = np.linspace(0.0, 10.0, 101)
    line = PlotCurve(name="line", x=x, y=x, color="blue")
    plot.draw([line], title="Test", left="y, m", bottom="x, s", words="A line.")
    plot.resize(480, 320)
    plot.show()
    activate(qtbot, plot)
    area = plot.plot
    assert area.pointer is None
    QTest.keyClick(area, Qt.Key.Key_C)
    first = area.pointer.x()
    middle = area.accessibleDescription()
    assert middle
    QTest.keyClick(area, Qt.Key.Key_Right)
    assert area.pointer.x() > first
    assert area.accessibleDescription() != middle
    QTest.keyClick(area, Qt.Key.Key_C)
    assert area.pointer is None
    assert area.accessibleDescription() == "A line."


def test_a_part_of_the_time_line_is_selected_by_keys(qtbot: QtBot, tmp_path: Path) -> None:
    timeline = Timeline(DisplayStyle())
    qtbot.addWidget(timeline)
    timeline.show()
    activate(qtbot, timeline)
    for key in (Qt.Key.Key_C, Qt.Key.Key_A, Qt.Key.Key_Right, Qt.Key.Key_Right):
        QTest.keyClick(timeline, key)
    start, stop = timeline.marked_segment
    assert stop - start == pytest.approx(0.01 * timeline.view.seconds)
    QTest.keyClick(timeline, Qt.Key.Key_Escape)
    assert timeline.marked_segment is None
