"""The frame of the window: commands, places, look, panels, errors, and that nothing is cut."""

import gc
import math
import re
import weakref
from collections.abc import Callable
from fnmatch import fnmatchcase
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QObject, QPoint, QRect, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QFontMetrics, QGuiApplication, QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QFileDialog,
    QLabel,
    QLineEdit,
    QListView,
    QListWidget,
    QMessageBox,
    QPushButton,
    QRadioButton,
    QScrollArea,
    QSplitter,
    QStyle,
    QStyleOptionViewItem,
    QTabBar,
    QToolButton,
    QTreeWidget,
    QVBoxLayout,
    QWidget,
)
from pytestqt.qtbot import QtBot

import ui.main_window
from calibration.validity import CalibrationStatus
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import GroundStationError
from gsapp.quantities import Block, channel
from gsapp.session.equipment_monitor import DiskSummary, LinkSummary, RecorderSummary
from gsapp.session.limits import LimitBands, Severity
from gsapp.session.user_limit_store import UserLimitStore
from gsapp.telemetry.link_registry import parse_link
from tests.ui.window_kit import (
    activate,
    answer_dialog,
    in_window,
    open_small_flight,
    open_window,
    settled_places,
    until,
    write_flight,
)
from ui.background_job import BackgroundJob, JobProgress
from ui.commands import COMMANDS, CommandSet, shortcut_text
from ui.dialogs.connect import ConnectDialog, ConnectionOptions
from ui.dialogs.file_dialogs import flight_name_filter, log_name_filter
from ui.dialogs.flight_dialogs import RangeDialog, ask_closing
from ui.dialogs.limits import LimitsDialog, check_limits
from ui.dialogs.virtual_flight import VirtualFlightDialog, VirtualFlightOptions
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight.channel_panel import ChannelPanel
from ui.flight.flight_view import create_chart_menu
from ui.flight.side_panels import AlarmsPanel, ListPanel, MarksPanel, MessagesPanel
from ui.help_menu import MessagesDialog, ShortcutsDialog
from ui.main_window import MainWindow
from ui.number_format import channel_value_text
from ui.settings import Settings, SettingsStore, initial_dialog_folder, limits_path
from ui.shortcut_filter import ShortcutOverrideFilter
from ui.strips.chart_keys import KEY_ACTIONS
from ui.theme import THEMES, contrast
from ui.widgets.row_model import TableRow, TableRowModel
from ui.widgets.table_view import TableRowView
from ui.widgets.time_slider import TimeSlider
from ui.window_frame.navigation_rail import NavigationButton
from ui.window_frame.status_bar_model import AlarmSummary, StatusBarData, create_status_items
from ui.window_frame.step_page import StepButton

pytestmark = pytest.mark.usefixtures("alone")


@pytest.fixture
def flight(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> MainWindow:
    open_small_flight(window, qtbot, tmp_path)
    until(qtbot, window.view.replay.isVisible)
    window.flight_controller.seek(19.0)
    until(qtbot, lambda: window.flight_controller.is_up_to_date)
    window.flight_controller.poller.tick()
    return window


# Keys


def test_every_key_goes_to_its_place(window: MainWindow, qtbot: QtBot) -> None:
    for index, key in enumerate((Qt.Key.Key_F1, Qt.Key.Key_F2, Qt.Key.Key_F3, Qt.Key.Key_F4,
                                 Qt.Key.Key_F5)):  # fmt: skip
        qtbot.keyClick(window, key)
        assert window.pages.currentIndex() == index
        assert list(window.navigation_rail.buttons.values())[index].isChecked()


def test_commands_without_handler_are_refused(qtbot: QtBot) -> None:
    holder = QWidget()
    qtbot.addWidget(holder)
    with pytest.raises(ValueError, match="mark"):
        CommandSet(holder).bind({c.id: holder.close for c in COMMANDS if c.id != "mark"})


def test_help_lists_every_key_and_can_be_searched(qtbot: QtBot) -> None:
    dialog = ShortcutsDialog(DisplayStyle())
    qtbot.addWidget(dialog)
    listed = "\n".join(dialog.rows())
    for command in COMMANDS:
        for key in command.shortcuts:
            assert key.lower() in listed
    dialog.search.setText("acknowledge")
    assert len(dialog.rows()) == 1


@pytest.mark.parametrize("command", ["connect", "virtual", "keys"])
def test_a_dialog_that_was_answered_is_gone(window: MainWindow, qtbot: QtBot, command: str) -> None:
    """The window would keep it, and style it anew with every theme."""
    answer_dialog(QDialog, lambda dialog: dialog.reject())
    window.commands.actions[command].trigger()
    until(qtbot, lambda: not window.findChildren(QDialog), 2_000)


def test_tab_stops_in_the_help_where_it_is_seen(window: MainWindow, qtbot: QtBot) -> None:
    def inspect(dialog: ShortcutsDialog) -> None:
        (area,) = dialog.findChildren(QScrollArea)
        qtbot.keyClick(dialog.search, Qt.Key.Key_Tab)
        assert area.hasFocus()
        assert area.accessibleName()
        image = dialog.grab().toImage()
        rim = image.pixelColor(in_window(area, dialog).topLeft() * image.devicePixelRatio())
        assert rim.name() == window.display_style.theme.text
        dialog.reject()

    answer_dialog(ShortcutsDialog, inspect)
    window.commands.actions["keys"].trigger()


def test_letters_typed_into_a_field_are_no_commands(flight: MainWindow, qtbot: QtBot) -> None:
    flight.view.show_panel(0)
    qtbot.keyClicks(flight.view.channels.search, "mk")
    assert flight.view.channels.search.text() == "mk"
    assert not flight.flight_controller.session.marks
    speed = flight.flight_controller.session.replay_feed
    button = flight.view.controls.spans[10.0]
    button.setFocus()
    qtbot.keyClick(button, Qt.Key.Key_Space)
    assert flight.view.charts.view.window == 10.0
    assert not speed.playing


def hold(
    key: Qt.Key, text: str = "", modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier
) -> None:
    focus = QApplication.focusWidget()
    assert focus is not None
    for repeated in (False, *[True] * 5):
        QTest.simulateEvent(focus, True, key, modifier, text, repeated)
    QTest.simulateEvent(focus, False, key, modifier, text, False)


def test_only_what_has_had_the_keyboard_is_looked_at_for_keys(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A filter of the application would see every event: a third of the time of a new theme."""
    seen: set[int] = set()

    class Watched(ShortcutOverrideFilter):
        def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's
            seen.add(id(watched))
            return super().eventFilter(watched, event)

    monkeypatch.setattr(ui.main_window, "ShortcutOverrideFilter", Watched)
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    activate(qtbot, window)
    window.display_style.set_theme("dark")
    assert 0 < len(seen) < 10
    assert len(window.findChildren(QWidget)) > 100


def test_a_key_that_is_held_does_once_what_does_not_move(flight: MainWindow, qtbot: QtBot) -> None:
    controller = flight.flight_controller
    flight.view.charts.setFocus()
    hold(Qt.Key.Key_M, "m")
    assert len(controller.session.marks) == 1
    playing = controller.session.replay_feed.playing
    hold(Qt.Key.Key_Space, " ")
    assert controller.session.replay_feed.playing is not playing
    controller.session.replay_feed.pause()
    before = controller.time
    hold(Qt.Key.Key_Comma, ",")
    assert controller.time == pytest.approx(before - 6 * 0.02)


def test_a_control_is_pressed_once_and_a_text_goes_on_while_a_key_is_held(
    flight: MainWindow, qtbot: QtBot
) -> None:
    pressed = []
    button = flight.view.controls.spans[10.0]
    button.clicked.connect(lambda: pressed.append(True))
    button.setFocus()
    hold(Qt.Key.Key_Return)
    assert len(pressed) == 1
    flight.view.show_panel(0)
    hold(Qt.Key.Key_Space, " ")
    hold(Qt.Key.Key_M, "m")
    assert flight.view.channels.search.text() == 6 * " " + 6 * "m"
    assert not flight.flight_controller.session.marks


def test_escape_comes_back_to_the_charts(flight: MainWindow, qtbot: QtBot) -> None:
    flight.view.show_panel(0)
    assert flight.view.channels.search.hasFocus()
    qtbot.keyClick(flight.view.channels.search, Qt.Key.Key_Escape)
    assert flight.view.charts.hasFocus()


def test_the_empty_list_of_values_names_the_keys_that_set_cursors(flight: MainWindow) -> None:
    sentence = " ".join(label.text() for label in flight.view.values.findChildren(QLabel))
    first = {action.id: action.keys[0] for action in KEY_ACTIONS}
    for action in ("cursor", "set_a", "set_b"):
        assert f" {first[action]}" in sentence


def test_the_start_page_names_the_keys_of_files_and_of_folders(window: MainWindow) -> None:
    card = window.flight_page.start.buttons["open_file"]
    for command in ("open_file", "open_folder"):
        keys = shortcut_text(window.commands.actions[command].shortcut().toString())
        assert keys in f"{card.accessibleName()} {card.accessibleDescription()}"


def test_the_side_panel_is_opened_and_closed_where_it_is_seen(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Without a flight, and at the other places, its key would act unseen on the next flight."""
    view = window.view
    qtbot.keyClick(window, Qt.Key.Key_F9)
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded and view.tabs.isVisible())
    qtbot.keyClick(window, Qt.Key.Key_F1)
    qtbot.keyClick(window, Qt.Key.Key_F9)
    qtbot.keyClick(window, Qt.Key.Key_F2)
    assert view.tabs.isVisible()
    qtbot.keyClick(window, Qt.Key.Key_F9)
    assert not view.tabs.isVisible()
    assert not window.store.current.side_panel


def test_channels_are_chosen_ordered_and_saved_by_keys(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    panel = flight.view.channels
    assert flight.view.charts.strip_layout.channels == ("de", "alpha", "q", "V")
    flight.view.show_panel(0)
    panel.search.setText("angle of attack")
    qtbot.keyClick(panel.search, Qt.Key.Key_Return)
    assert "alpha" not in flight.view.charts.strip_layout.channels
    qtbot.keyClick(panel.search, Qt.Key.Key_Return)
    assert "alpha" in flight.view.charts.strip_layout.channels
    last = panel.order.count() - 1
    panel.order.setCurrentRow(last)
    panel.order.setFocus()
    qtbot.keyClick(panel.order, Qt.Key.Key_Up, Qt.KeyboardModifier.AltModifier)
    assert panel.order.currentRow() == last - 1
    order = flight.view.charts.strip_layout.channels
    panel.layout_saved.emit("Doublets")
    assert flight.store.current.layout == "Doublets"
    flight.view.layouts.show_layout("Overview")
    flight.view.layouts.show_layout("Doublets")
    assert flight.view.charts.strip_layout.channels == order
    flight.close()
    again = open_window(tmp_path)
    qtbot.addWidget(again)
    assert again.view.layouts._layouts.load("Doublets").channels == order


def test_a_layout_goes_to_a_file_and_comes_from_one(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "crew"  # the dialog adds the ending
    choices = {"getSaveFileName": str(path), "getOpenFileName": f"{path}.toml"}
    for name, chosen in choices.items():
        monkeypatch.setattr(
            QFileDialog, name, lambda *_, chosen=chosen: (chosen, "Layout (*.toml)")
        )
    panel, charts = flight.view.channels, flight.view.charts
    panel.layout_saved.emit("Doublets")
    exported = charts.strip_layout
    panel.export_requested.emit()
    flight.view.layouts.show_layout("Overview")
    panel.import_requested.emit()
    # The name is taken, and the layout that has it stays.
    assert flight.store.current.layout == "Doublets 2"
    assert charts.strip_layout.groups == exported.groups
    assert flight.view.layouts._layouts.names == ("Doublets", "Doublets 2")
    # What cannot be read is told, and nothing is changed.
    path.with_suffix(".toml").write_text("groups = 5")
    answered: list[str] = []
    answer_dialog(QMessageBox, lambda box: answered.append(box.text()))
    panel.import_requested.emit()
    assert answered
    assert flight.store.current.layout == "Doublets 2"


def test_a_channel_that_never_has_a_sample_gets_no_chart(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    times = np.arange(1000) / 50.0
    values = np.column_stack([0.05 * np.sin(times), np.full(times.size, math.nan)])
    block = Block(channels=("alpha", "beta"), times=times, values=values)
    path = write_flight_csv(tmp_path / "empty column.csv", block, "us")
    window.flight_controller.flight_opener.open_flight(path, playing=False)
    charts = window.view.charts
    until(
        qtbot,
        lambda: window.flight_controller.is_loaded and charts.strip_layout.channels == ("alpha",),
    )
    # It can still be chosen, and is said to be empty.
    assert window.view._state.available == ("alpha", "beta")


# Marks


def test_a_note_is_typed_in_place_found_again_and_taken_back(
    flight: MainWindow, qtbot: QtBot
) -> None:
    controller = flight.flight_controller
    flight.crew.add_note()
    editor = flight.view.marks.view.findChild(QLineEdit)
    editor.setText("gust from the left")
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    until(qtbot, lambda: controller.session.marks[0].text == "gust from the left")
    # The next key is for the charts again.
    until(qtbot, flight.view.charts.hasFocus)
    marks = controller.session.marks
    assert [mark.kind for mark in marks] == ["note"]
    assert marks[0].time == pytest.approx(19.0)
    controller.seek(3.0)
    flight.crew.step_mark(1)
    assert controller.time == pytest.approx(19.0)
    flight.view.marks.deleted.emit(marks[0].id)
    assert not controller.session.marks
    controller.undo_mark()
    assert len(controller.session.marks) == 1


def test_the_keyboard_goes_into_no_panel_that_nobody_sees(flight: MainWindow, qtbot: QtBot) -> None:
    flight.show_page("pilot")
    flight.commands.actions["note"].trigger()
    editor = flight.view.marks.view.findChild(QLineEdit)
    assert editor.isVisible()
    qtbot.keyClicks(editor, "gust")
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    until(qtbot, flight.view.charts.hasFocus)
    assert flight.flight_controller.session.marks[0].text == "gust"

    # Pressed in the bar, which stands above every place.
    flight.show_page("review")
    flight.status_bar.pressed.emit("alarms")
    assert flight.view.alarms.isVisible()


@pytest.mark.parametrize("end", ["another flight", "closed", "window"])
def test_a_note_half_typed_is_kept_when_its_flight_goes(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path, end: str
) -> None:
    controller = flight.flight_controller
    former = controller.session
    flight.crew.add_note()
    qtbot.keyClicks(flight.view.marks.view.findChild(QLineEdit), "half typ")
    if end == "window":
        flight.close()
    elif end == "closed":
        controller.close_flight()
    else:
        controller.flight_opener.open_flight(write_flight(tmp_path / "other"), playing=False)
        until(qtbot, lambda: controller.session is not former)
    assert [mark.text for mark in former.marks] == ["half typ"]


# Look


def test_another_window_of_the_same_look_styles_nothing_anew(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, qapp: QApplication
) -> None:
    sheet = qapp.styleSheet()
    assert "gsapp-signs-" in sheet
    other = open_window(tmp_path / "other")
    qtbot.addWidget(other)
    assert qapp.styleSheet() == sheet
    other.flight_controller.close()


def test_themes_units_and_scale_change_at_once_and_are_remembered(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    seen = set()
    for _ in THEMES:
        qtbot.keyClick(flight, Qt.Key.Key_T, Qt.KeyboardModifier.ControlModifier)
        image = flight.grab().toImage()
        color = image.pixelColor(image.width() - 300, 10).name()
        assert color == flight.display_style.theme.background
        seen.add(color)
    assert len(seen) == 3
    qtbot.keyClick(flight, Qt.Key.Key_U, Qt.KeyboardModifier.ControlModifier)
    assert flight.display_style.units == "SI"
    before = flight.status_bar.height()
    flight.appearance.step_scale(3)
    until(qtbot, lambda: flight.status_bar.height() > before)
    flight.close()
    kept = SettingsStore(flight.store.path).current
    assert (kept.units, kept.scale, kept.theme) == ("SI", 150, flight.display_style.theme.name)
    assert kept.geometry


@pytest.mark.parametrize(
    ("size", "scale"),
    [((1280, 800), 100), ((1280, 800), 200), ((2560, 1600), 200), ((1024, 640), 125)],
)
def test_nothing_is_cut_and_nothing_overlaps(
    flight: MainWindow, qtbot: QtBot, size: tuple[int, int], scale: int
) -> None:
    flight.display_style.set_scale(scale)
    flight.resize(*size)
    qtbot.wait(30)
    whole = QRect(QPoint(0, 0), flight.size())
    parts = [in_window(view, flight) for view in flight.status_bar.item_widgets.values()]
    parts += [
        in_window(widget, flight)
        for widget in (flight.view.charts, flight.view.tabs, flight.view.replay.slider,
                       flight.view.controls, *flight.navigation_rail.buttons.values())
        if widget.isVisibleTo(flight)
    ]  # fmt: skip
    for index, part in enumerate(parts):
        assert whole.contains(part), index
        for other in parts[index + 1 :]:
            assert not part.intersects(other)
    shown = [
        button
        for button in flight.view.controls.findChildren(QAbstractButton)
        if button.isVisibleTo(flight)
    ]
    for button in shown:
        assert button.width() >= button.sizeHint().width(), button.text()
    for one, other in pairwise([in_window(button, flight) for button in shown]):
        assert not one.intersects(other)
    assert flight.view.charts.height() >= 160 * scale / 100


@pytest.mark.parametrize("scale", [100, 150, 250])
def test_all_tabs_of_the_side_panel_are_in_sight(
    flight: MainWindow, qtbot: QtBot, scale: int
) -> None:
    flight.display_style.set_scale(scale)
    for index in range(12):
        flight.flight_controller.session.alarm_registry.raise_(
            f"x{index}", Severity.WARNING, 1.0, "too fast"
        )
    flight.flight_controller.poller.tick()
    tabs = flight.view.tabs
    bar = tabs.tabBar()
    for chosen in range(tabs.count()):
        flight.view.show_panel(chosen)
        until(qtbot, lambda: tabs.tabText(3).startswith("Alarms 1"))
        qtbot.wait(10)
        places = [bar.tabRect(index) for index in range(tabs.count())]
        assert all(tabs.rect().contains(place) for place in places)
        # Qt shows its arrows when it leaves words out.
        assert not any(arrow.isVisible() for arrow in bar.findChildren(QToolButton))


def test_charts_reach_the_panel_also_after_a_layout_while_hidden(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    window.grab()
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    view = window.view
    until(qtbot, lambda: window.flight_controller.is_loaded and view.tabs.isVisible())
    qtbot.wait(20)
    assert view.tabs.geometry().right() == view.width() - 1
    gap = view.tabs.geometry().left() - view.charts.geometry().right() - 1
    assert 0 <= gap <= 2


def test_menus_without_room_are_behind_an_arrow_that_is_seen(
    window: MainWindow, qtbot: QtBot
) -> None:
    window.display_style.set_scale(250)
    more = window.menuBar().findChild(QToolButton, "qt_menubar_ext_button")
    until(qtbot, more.isVisible)
    image = more.grab().toImage()
    colors = {
        image.pixelColor(x, y).name() for x in range(image.width()) for y in range(image.height())
    }
    assert window.display_style.color("text").name() in colors


@pytest.fixture
def _wide_words(monkeypatch: pytest.MonkeyPatch) -> None:
    for hint in ("sizeHint", "minimumSizeHint"):
        monkeypatch.setattr(ChannelPanel, hint, lambda _self: QSize(500, 300), raising=False)


@pytest.mark.usefixtures("_wide_words")
def test_the_panel_leaves_no_gap_where_its_words_are_wide(flight: MainWindow) -> None:
    panel = flight.view.tabs
    assert panel.minimumSizeHint().width() > panel.width()
    assert in_window(panel, flight).right() == flight.rect().right()


def test_every_control_has_a_name(flight: MainWindow) -> None:
    for kind in (QAbstractButton, QComboBox, QLineEdit, QAbstractItemView):
        for widget in flight.findChildren(kind):
            inner = widget.objectName().startswith("qt_") or widget.parent() is None
            helper = isinstance(widget.parent(), (QComboBox, QLineEdit, QAbstractItemView))
            popup = widget.window() is not flight
            if not (inner or helper or popup) and widget.isVisibleTo(widget.parentWidget()):
                named = widget.accessibleName() or getattr(widget, "text", str)()
                assert named or type(widget).__name__ in ("QToolButton", "CloseButton"), widget


def test_tab_stops_only_where_the_keyboard_is_seen(flight: MainWindow, qtbot: QtBot) -> None:
    for place in ("preflight", "review", "gap"):
        flight.show_page(place)
    until(qtbot, lambda: not flight.review_page.work.running)
    stops = [
        area.metaObject().className()
        for area in flight.findChildren(QScrollArea)
        if area.focusPolicy() & Qt.FocusPolicy.TabFocus
    ]
    assert not {"ManeuversPanel", "SearchSetupPage", "StartPage"} & {*stops}
    masses = [
        line for line in flight.findChildren(QLineEdit) if line.accessibleName() == "Mass, row 1"
    ]
    assert len(masses) == 1
    place = masses[0].nextInFocusChain()
    assert isinstance(place, QLineEdit)
    assert place.accessibleName() == "Ahead of CG, row 1"


@pytest.mark.parametrize("theme", list(THEMES))
def test_the_buttons_of_a_file_dialog_have_their_signs(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, theme: str
) -> None:
    window.display_style.set_theme(theme)
    dialog = QFileDialog(window, "Open", str(tmp_path))
    qtbot.addWidget(dialog)
    dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
    dialog.show()
    activate(qtbot, dialog)
    image = dialog.findChild(QToolButton, "toParentButton").grab().toImage()
    margin = 4
    ink = [
        (x, y)
        for x in range(margin, image.width() - margin)
        for y in range(margin, image.height() - margin)
        if contrast(image.pixelColor(x, y).name(), window.display_style.theme.plot) >= 7.0
    ]
    wide, high = (max(axis) - min(axis) + 1 for axis in zip(*ink, strict=True))
    assert wide >= 10
    assert high >= 5


@pytest.mark.parametrize("theme", list(THEMES))
def test_a_line_of_ink_says_where_the_keyboard_is(
    window: MainWindow, qtbot: QtBot, theme: str
) -> None:
    """Round lists, tables, trees and check boxes, too; and nothing moves when it comes."""
    window.display_style.set_theme(theme)
    boxed = QListWidget()
    boxed.setProperty("role", "boxed")
    lines = TableRowView(
        TableRowModel(window.display_style, ("Time", "Mark")),
        window.display_style,
        "Marks",
        1,
        {0: 60},
    )
    tabs = QTabBar()
    tabs.addTab("Marks")
    read = QScrollArea()
    read.setProperty("role", "read")
    kinds = (QCheckBox("Use it"), QRadioButton("One"), QTreeWidget(), QListView(), boxed, lines,
             tabs, read)  # fmt: skip
    page = QDialog(window)
    column = QVBoxLayout(page)
    for one in kinds:
        column.addWidget(one)
    page.show()
    activate(qtbot, page)

    def rim(widget: QWidget) -> tuple[str, QRect, QRect]:
        image = page.grab().toImage()
        place = widget.geometry()
        inside = widget.viewport().geometry() if isinstance(widget, QAbstractItemView) else place
        # Its second pixel, where what is boxed anyway has no line.
        deep = 0 if isinstance(widget, QAbstractButton) else 1
        left = place.left() + 2 if widget is tabs else place.center().x()
        spot = QPoint(left, place.top() + deep) * image.devicePixelRatio()
        return image.pixelColor(spot).name(), place, inside

    for one, other in pairwise((*kinds, kinds[0])):
        other.setFocus()
        without, *before = rim(one)
        one.setFocus()
        ink, *after = rim(one)
        assert contrast(ink, without) >= 3.0, type(one).__name__
        assert contrast(ink, window.display_style.theme.background) >= 7.0
        assert before == after


@pytest.mark.parametrize("theme", list(THEMES))
def test_a_filled_button_shows_the_keyboard(window: MainWindow, qtbot: QtBot, theme: str) -> None:
    window.display_style.set_theme(theme)
    primary, checked = QPushButton("Estimate"), QPushButton("1 min")
    primary.setProperty("role", "primary")
    checked.setCheckable(True)
    checked.setChecked(True)
    page = QDialog(window)
    column = QVBoxLayout(page)
    for one in (primary, checked):
        one.setAutoDefault(False)
        column.addWidget(one)
    page.show()
    activate(qtbot, page)

    def gaps(button: QPushButton) -> int:
        image = page.grab().toImage()
        ratio, box = image.devicePixelRatio(), button.geometry()
        spots = [QPoint(box.center().x(), box.top() + deep) * ratio for deep in range(4)]
        ink = window.display_style.theme.text
        return sum(contrast(image.pixelColor(spot).name(), ink) >= 3.0 for spot in spots)

    for one, other in ((primary, checked), (checked, primary)):
        other.setFocus()
        assert gaps(one) == 0
        one.setFocus()
        assert gaps(one) >= 1


def test_the_line_of_the_keyboard_is_seen_where_none_was_chosen(qtbot: QtBot) -> None:
    panel = MarksPanel(DisplayStyle())
    qtbot.addWidget(panel)
    panel.show()
    activate(qtbot, panel)
    panel.show_rows([TableRow(key=key, cells=("00:01", f"Mark {key}")) for key in "ab"])
    assert panel.view.current_key() is None
    panel.view.setFocus(Qt.FocusReason.TabFocusReason)
    until(qtbot, panel.view.hasFocus)
    assert panel.view.current_key() == "a"
    assert [index.row() for index in panel.view.selectionModel().selectedRows()] == [0]


def test_tab_goes_round_each_place_without_a_flight(window: MainWindow, qtbot: QtBot) -> None:
    for key, name in ((Qt.Key.Key_F1, "preflight"), (Qt.Key.Key_F3, "pilot"),
                      (Qt.Key.Key_F4, "review"), (Qt.Key.Key_F5, "gap")):  # fmt: skip
        qtbot.keyClick(window, key)
        activate(qtbot, window)
        stops = [
            one
            for one in window.findChildren(QWidget)
            if one.focusPolicy() & Qt.FocusPolicy.TabFocus
            and one.window() is window
            and one.isVisibleTo(window)
            and one.isEnabled()
            and one.focusProxy() is None
        ]
        for way in (Qt.Key.Key_Tab, Qt.Key.Key_Backtab):
            seen: list[QWidget] = []
            while (focus := QApplication.focusWidget()) not in seen:
                seen.append(focus)
                qtbot.keyClick(focus, way)
            assert set(stops) <= set(seen), name
        buttons = [one for one in seen if isinstance(one, NavigationButton | StepButton)]
        assert window.navigation_rail.buttons[name] in buttons
        assert all(one.isChecked() for one in buttons)


# Errors


def test_an_error_in_a_slot_becomes_a_banner_and_can_be_copied(
    window: MainWindow, qtbot: QtBot
) -> None:
    window.error_reporter.install()
    try:
        QTimer.singleShot(0, lambda: 1 / 0)
        until(qtbot, lambda: bool(window.banners.texts()))
    finally:
        window.error_reporter.remove()
    assert "ZeroDivisionError" in window.banners.texts()[0]
    assert "Traceback" not in window.banners.texts()[0]
    window.help_menu.copy_details()
    assert "Traceback" in QGuiApplication.clipboard().text()
    window.banners.dismiss()
    window.banners.dismiss()
    assert not window.banners.texts()


def test_expected_errors_are_shown_in_their_own_words(window: MainWindow, qtbot: QtBot) -> None:
    window.error_reporter.report(GroundStationError("the port is gone; plug it in again"))
    until(qtbot, lambda: "the port is gone; plug it in again" in window.banners.texts())


def test_what_was_said_of_a_flight_goes_when_another_opens(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Also that one could not be opened; what happens on opening the next one stays."""
    flight_controller, banners = window.flight_controller, window.banners
    garbage = tmp_path / "garbage.tlog"
    garbage.write_bytes(bytes(range(1, 250)) * 40)
    flight_controller.flight_opener.open_flight(garbage)
    until(qtbot, lambda: any("garbage.tlog" in text for text in banners.texts()))
    assert not any("Garbage" in text for text in banners.texts())
    flight_controller.flight_opener.open_flight(tmp_path / "absent.tlog")
    until(qtbot, lambda: any("absent.tlog" in text for text in banners.texts()))
    assert len(banners.texts()) == 2
    window.error_reporter.report(GroundStationError("the card of the flight cannot be read"))
    flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: flight_controller.name == "small")
    assert banners.texts() == ("the card of the flight cannot be read",)


def test_a_dialog_begins_in_a_folder_that_is_there(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[str] = []

    def asked(_parent: QWidget, _title: str, start: str, *_: object) -> tuple[str, str]:
        begun.append(start)
        return "", ""

    monkeypatch.setattr(QFileDialog, "getOpenFileName", asked)
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *all_: asked(*all_)[0])
    window.store.change(flights=str(tmp_path / "documents" / "flights"))
    held = Qt.KeyboardModifier.ControlModifier
    qtbot.keyClick(window, Qt.Key.Key_O, held)
    (tmp_path / "documents" / "flights").mkdir(parents=True)
    qtbot.keyClick(window, Qt.Key.Key_O, held | Qt.KeyboardModifier.ShiftModifier)
    assert begun == [str(tmp_path), str(tmp_path / "documents" / "flights")]


@pytest.mark.parametrize("name", ["00000012.BIN", "flight.tlog", "log.ulg", "table.parquet"])
@pytest.mark.parametrize("kinds", [flight_name_filter(), log_name_filter()])
def test_a_dialog_shows_what_can_be_opened(kinds: str, name: str) -> None:
    offered, everything = (re.findall(r"\*[.\w]*", kind) for kind in kinds.split(";;"))
    assert any(fnmatchcase(name, pattern) for pattern in offered)
    assert everything == ["*"]


@pytest.mark.parametrize(
    ("remembered", "opened", "there"),
    [("report", "opened", "report"), ("gone/too", "opened", ""), ("", "opened", "opened")],
)
def test_a_folder_that_is_gone_is_no_place_to_begin(
    remembered: str, opened: str, there: str, tmp_path: Path
) -> None:
    (tmp_path / "report").mkdir()
    (tmp_path / "opened").mkdir()
    settings = Settings(folder=str(tmp_path / opened))
    found = initial_dialog_folder(settings, str(tmp_path / remembered) if remembered else "")
    assert found == tmp_path / there


def test_a_work_can_be_cancelled_and_says_how_far_it_is(window: MainWindow, qtbot: QtBot) -> None:
    def count(progress: JobProgress) -> None:
        while True:
            progress(0.5, "counting")

    work = BackgroundJob("Counting", count, window)
    window.file_menu.jobs.show_job(work, "Done.")
    work.start()
    until(qtbot, lambda: any("counting" in text for text in window.banners.texts()))
    window.banners.banners[0].buttons[0].click()
    until(qtbot, lambda: any("cancelled" in text for text in window.banners.texts()))


def test_a_bad_link_cannot_be_connected(qtbot: QtBot, tmp_path: Path) -> None:
    choices = ConnectionOptions(
        aircraft=("b777",), channel_maps=("b777",), calibrations=("b777",), parse=parse_link,
        list_ports=lambda: (("/dev/ttyUSB0", "/dev/ttyUSB0 (radio)"),),
    )  # fmt: skip
    dialog = ConnectDialog(Settings(), DisplayStyle(), choices, tmp_path)
    qtbot.addWidget(dialog)
    assert dialog.button.isEnabled()
    dialog.link.text.setEditText("udp:14550")
    assert not dialog.button.isEnabled()
    assert "is not a link" in dialog.link.message.text()
    dialog.link.kind.setCurrentIndex(dialog.link.kind.findData("udpin"))
    dialog.link.port.set_value(14551)
    assert dialog.request.link == "udpin:127.0.0.1:14551"
    assert dialog.button.isEnabled()


def test_a_serial_link_that_was_typed_stays_what_it_is(qtbot: QtBot, tmp_path: Path) -> None:
    """The boxes above show it, so that a change of the speed does not name another port."""
    listed = [("/dev/ttyUSB0", "/dev/ttyUSB0 (radio)")]
    choices = ConnectionOptions(
        aircraft=("b777",), channel_maps=("b777",), calibrations=("b777",), parse=parse_link,
        list_ports=lambda: tuple(listed),
    )  # fmt: skip
    dialog = ConnectDialog(Settings(), DisplayStyle(), choices, tmp_path)
    qtbot.addWidget(dialog)
    link = dialog.link
    named = tmp_path / "telemetry"
    link.text.setEditText(f"serial:{named}:500000")
    assert "is not connected" in link.message.text()
    assert (link.device.currentText(), link.baud.currentText()) == (str(named), "500,000")
    # A name for a port, as rules of the system give it, is in no list of ports.
    named.touch()
    link.text.setEditText(f"serial:{named}:57600")
    assert link.input_check.state == "good"
    listed.append(("/dev/ttyUSB1", "/dev/ttyUSB1 (another)"))
    link.refresh_ports()
    assert [link.device.itemText(at) for at in range(3)] == [
        "/dev/ttyUSB0 (radio)", "/dev/ttyUSB1 (another)", str(named),
    ]  # fmt: skip
    link.baud.setCurrentIndex(1)
    link.baud.activated.emit(1)
    assert dialog.request.link == f"serial:{named}:115200"
    # What is listed takes its place.
    link.text.setEditText("text:/dev/ttyUSB1:115200")
    assert (link.device.count(), link.device.currentIndex()) == (2, 1)


def test_a_note_goes_by_itself_and_what_matters_stays(window: MainWindow, qtbot: QtBot) -> None:
    window.banners.note_timeout_ms = 50
    window.banners.show_banner("caution", "Disk nearly full.")
    window.banners.show_banner("note", "A recording ended.", ("Replay it", window.update))
    window.banners.show_banner("note", "Exported.")
    assert "Exported." in window.banners.texts()
    until(qtbot, lambda: "Exported." not in window.banners.texts())
    assert window.banners.texts() == ("A recording ended.", "Disk nearly full.")


def test_new_lines_leave_the_chosen_line_and_its_editor_alone(qtbot: QtBot) -> None:
    panel = MarksPanel(DisplayStyle())
    qtbot.addWidget(panel)
    panel.show()

    def show(*keys: str) -> None:
        panel.show_rows([TableRow(key=key, cells=("00:01", f"Mark {key}")) for key in keys])

    show("b", "d")
    panel.begin_edit("d")
    editor = panel.view.findChild(QLineEdit)
    assert editor.accessibleName() == "Mark"
    show("a", "b", "d")
    show("a", "b", "c", "d")
    assert panel.view.current_key() == "d"
    assert panel.view.findChild(QLineEdit) is editor
    assert [line.key for line in panel.view.row_model.rows] == ["a", "b", "c", "d"]
    show("d", "a")
    assert panel.view.current_key() == "d"


@pytest.mark.parametrize("maximized", [False, True])
def test_a_full_screen_comes_back_to_what_was_before(
    window: MainWindow, qtbot: QtBot, *, maximized: bool
) -> None:
    if maximized:
        window.showMaximized()
        until(qtbot, window.isMaximized)
    qtbot.keyClick(window, Qt.Key.Key_F11)
    until(qtbot, window.isFullScreen)
    assert window.menuBar().isVisible()
    qtbot.keyClick(window, Qt.Key.Key_F11)
    until(qtbot, lambda: not window.isFullScreen())
    assert window.isMaximized() == maximized


def test_the_side_panel_is_drawn_wider_and_stays_so(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    flight.show_page("flight")
    handle = flight.view.findChild(QSplitter).handle(1)
    tabs, charts = flight.view.tabs, flight.view.charts
    usual = tabs.width()

    def drag(by: int) -> None:
        start = handle.rect().center()
        qtbot.mousePress(handle, Qt.MouseButton.LeftButton, pos=start)
        qtbot.mouseMove(handle, start + QPoint(by, 0))
        qtbot.mouseRelease(handle, Qt.MouseButton.LeftButton, pos=start + QPoint(by, 0))

    drag(-100)
    wide = tabs.width()
    assert wide == pytest.approx(usual + 100, abs=5)
    until(qtbot, lambda: SettingsStore(flight.store.path).current.panel_width == wide)
    flight.resize(1300, 800)
    until(qtbot, lambda: charts.width() + tabs.width() > 1200)
    assert tabs.width() == wide
    drag(-900)
    assert charts.isVisible()
    assert charts.width() >= 420
    drag(900)
    assert tabs.width() == usual


def test_headings_of_the_charts_grow_with_the_text(flight: MainWindow, qtbot: QtBot) -> None:
    order = flight.findChild(ChannelPanel).order
    headings = [item for row in range(order.count()) if (item := order.item(row)).font().bold()]
    assert headings
    assert {item.font().pixelSize() for item in headings} == {11}
    qtbot.keyClick(flight, Qt.Key.Key_Plus, Qt.KeyboardModifier.ControlModifier)
    assert {item.font().pixelSize() for item in headings} == {flight.display_style.sizes.label}
    assert flight.display_style.sizes.label > 11


@pytest.mark.parametrize("theme", list(THEMES))
def test_a_chosen_channel_and_an_empty_field_have_the_colors_of_the_theme(
    flight: MainWindow, qtbot: QtBot, theme: str
) -> None:
    flight.display_style.set_theme(theme)
    panel = flight.findChild(ChannelPanel)
    tree = panel.tree
    for focused in (panel.search, tree):
        tree.setCurrentItem(tree.topLevelItem(0).child(0))
        focused.setFocus()
        until(qtbot, focused.hasFocus)
        line = tree.visualItemRect(tree.currentItem())
        image = tree.viewport().grab().toImage()
        ratio = image.devicePixelRatio()
        indent, item = (
            image.pixelColor(round(x * ratio), round((line.top() + 2) * ratio)).name()
            for x in (3, line.right() - 3)
        )
        assert indent == item
    for field in [*flight.findChildren(QLineEdit), *flight.findChildren(QComboBox)]:
        field.ensurePolished()
        text = field.palette().color(QPalette.ColorRole.PlaceholderText)
        assert text.alpha() == 255
        least = 4.5 if theme == "dark" else 7.0
        assert contrast(text.name(), flight.display_style.theme.plot) >= least


@pytest.mark.parametrize("button", [Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton])
def test_only_the_left_button_presses(
    flight: MainWindow, qtbot: QtBot, button: Qt.MouseButton
) -> None:
    slider = flight.findChild(TimeSlider)
    muted, before = flight.store.current.muted, flight.flight_controller.time
    left = Qt.MouseButton.LeftButton
    sound = flight.status_bar.item_widgets["sound"]
    for pressed in (button, left):
        qtbot.mouseClick(sound, pressed, pos=sound.rect().center())
        assert (flight.store.current.muted != muted) == (pressed == left)
        qtbot.mouseClick(slider, pressed, pos=slider.rect().center())
        assert (flight.flight_controller.time != before) == (pressed == left)


@pytest.mark.parametrize("kind", [MarksPanel, AlarmsPanel, MessagesPanel])
@pytest.mark.parametrize("scale", [100, 200])
def test_times_are_whole_after_an_hour(
    window: MainWindow, qtbot: QtBot, kind: type[ListPanel], scale: int
) -> None:
    window.display_style.set_scale(scale)
    panel = kind(window.display_style)
    qtbot.addWidget(panel)
    panel.setStyleSheet(QApplication.instance().styleSheet())
    panel.resize(500, 300)
    panel.show()
    others = ("words",) * (panel.view.row_model.columnCount() - 1)
    panel.show_rows([TableRow(key=1, cells=("1:06:48.9", *others), is_bold=True)])
    view = panel.view
    assert view.sizeHintForColumn(0) <= view.columnWidth(0)


@pytest.mark.parametrize("scale", [100, 200])
def test_the_last_line_of_long_words_in_a_table_is_not_cut(
    window: MainWindow, qtbot: QtBot, scale: int
) -> None:
    """A row is as high as the words are that wrap within the padding of the style."""
    window.display_style.set_scale(scale)
    panel = AlarmsPanel(window.display_style)
    qtbot.addWidget(panel)
    panel.setStyleSheet(QApplication.instance().styleSheet())
    panel.resize(500, 300)
    panel.show()
    words = ["nothing received for more " * 3 + "n" * length for length in range(1, 16)]
    lines = [
        TableRow(key=row, cells=(f"00:{row:02}.0", one, "", "", ""), is_bold=bool(row % 2))
        for row, one in enumerate(words)
    ]
    panel.show_rows(lines)
    view, style = panel.view, panel.view.style()
    QApplication.processEvents()
    margin = style.pixelMetric(QStyle.PixelMetric.PM_FocusFrameHMargin, None, view) + 1
    for row in range(len(lines)):
        index = view.row_model.index(row, 1)
        option = QStyleOptionViewItem()
        view.initViewItemOption(option)
        view.itemDelegate().initStyleOption(option, index)
        option.rect = view.visualRect(index)
        inside = style.subElementRect(QStyle.SubElement.SE_ItemViewItemText, option, view)
        inside.adjust(margin, 0, -margin, 0)
        needed = QFontMetrics(option.font).boundingRect(
            QRect(0, 0, inside.width(), 10_000), Qt.TextFlag.TextWordWrap, option.text
        )
        assert inside.height() >= needed.height(), option.text


@pytest.mark.parametrize("size", [(1440, 900), (1280, 800)])
def test_all_columns_of_the_alarms_are_in_sight(
    flight: MainWindow, qtbot: QtBot, size: tuple[int, int]
) -> None:
    panel, board = flight.view.alarms, flight.flight_controller.session.alarm_registry
    flight.resize(*size)
    flight.view.show_panel(2)
    before = flight.view.tabs.width()
    flight.view.show_panel(3)
    board.raise_("x", Severity.CAUTION, 1.0, "pitch gyro saturated")
    acknowledge = next(one for one in panel.findChildren(QPushButton) if "(K)" in one.text())
    until(qtbot, acknowledge.isEnabled)
    view = panel.view
    last = view.columnViewportPosition(4) + view.columnWidth(4)
    until(qtbot, lambda: view.viewport().width() >= last)
    assert view.horizontalScrollBar().maximum() == 0
    assert flight.view.charts.width() > 0.45 * size[0]
    flight.flight_controller.acknowledge("crew")
    until(qtbot, lambda: not acknowledge.isEnabled())
    assert acknowledge.toolTip()
    flight.view.show_panel(2)
    assert flight.view.tabs.width() == before


def test_the_alarms_of_a_replay_say_that_cues_are_missing_until_it_was_played(
    flight: MainWindow, qtbot: QtBot
) -> None:
    note = flight.view.alarms.cues_note
    flight.view.show_panel(3)
    flight.flight_controller.seek(0.5)
    until(qtbot, note.isVisible)
    flight.flight_controller.seek(math.inf)
    until(qtbot, note.isHidden)
    flight.flight_controller.seek(0.5)
    until(qtbot, note.isVisible)


def test_an_alarm_is_in_sight_at_every_scale(flight: MainWindow, qtbot: QtBot) -> None:
    flight.flight_controller.session.alarm_registry.raise_(
        "x", Severity.WARNING, 1.0, "angle of sideslip too large " * 3
    )
    flight.display_style.set_scale(250)
    flight.flight_controller.poller.tick()
    until(qtbot, lambda: flight.status_bar.item_widgets["alarms"].item.state == "warning")
    until(
        qtbot,
        lambda: (
            flight.status_bar.rect().contains(flight.status_bar.item_widgets["alarms"].geometry())
            and flight.status_bar.item_widgets["alarms"].height() > 40
        ),
    )
    assert in_window(flight.status_bar, flight).right() <= flight.width()


def test_tab_goes_through_a_dialog_as_one_reads_and_enter_does_it(
    qtbot: QtBot, tmp_path: Path
) -> None:
    choices = VirtualFlightOptions(
        plans=("default",), effects=lambda: (("aero.Cm.q", "No damping"),)
    )
    dialog = VirtualFlightDialog(DisplayStyle(), choices, tmp_path)
    qtbot.addWidget(dialog)
    dialog.show()
    activate(qtbot, dialog)
    until(qtbot, lambda: dialog.effects.count() == 1)
    # Without a parent the dialog would go with it, in the midst of its end.
    until(qtbot, lambda: not dialog.findChildren(BackgroundJob))
    place = dialog.folder_field
    chain = [dialog.plan, dialog.speed, dialog.seed, dialog.thin, dialog.search, dialog.effects,
             place.title, place.name, place.parent_folder.edit]  # fmt: skip
    for field in chain:
        assert QApplication.focusWidget() is field
        qtbot.keyClick(field, Qt.Key.Key_Tab)
    place.name.setFocus()
    with qtbot.waitSignal(dialog.submitted):
        qtbot.keyClick(place.name, Qt.Key.Key_Return)
    assert dialog.isVisible()
    dialog.accept()  # as once the recording has begun
    assert not dialog.isVisible()


def test_the_y_range_of_a_chart_is_typed(flight: MainWindow, qtbot: QtBot) -> None:
    charts = flight.view.charts
    charts.setFocus()
    charts.perform("chart_down")

    def answer(dialog: RangeDialog, low: str, high: str) -> None:
        dialog.low.setText("7")
        dialog.high.setText("7")
        assert not dialog.button.isEnabled()
        dialog.low.setText(low)
        dialog.high.setText(high)
        dialog.button.click()

    answer_dialog(RangeDialog, lambda dialog: answer(dialog, "−2,5", "12"))
    qtbot.keyClick(charts, Qt.Key.Key_Y, Qt.KeyboardModifier.ShiftModifier)
    until(qtbot, lambda: bool(charts.model.selected_chart.ticks))
    assert charts.model.selected_chart.specs[0].id == "alpha"
    assert (charts.model.selected_chart.low, charts.model.selected_chart.high) == pytest.approx(
        (-2.5, 12.0)
    )
    assert charts.model.selected_chart.ticks[0] >= -2.5
    assert charts.strip_layout.strips[1].high == pytest.approx(math.radians(12.0))
    activate(qtbot, flight)
    answer_dialog(RangeDialog, lambda dialog: answer(dialog, "", ""))
    qtbot.keyClick(charts, Qt.Key.Key_Y, Qt.KeyboardModifier.ShiftModifier)
    assert charts.strip_layout.strips[1].range == "auto"


def test_the_limits_of_a_chart_are_typed_kept_and_reset(
    flight: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """In the units of the screen: band, alarm, file; another window knows them; reset ends them."""
    charts = flight.view.charts
    session = flight.flight_controller.session
    assert session is not None

    def ask(window: MainWindow, answer: Callable[[LimitsDialog], object]) -> None:
        activate(qtbot, window)
        window.view.charts.setFocus()
        until(qtbot, lambda: window.view.charts.model.selected_chart is not None)
        answer_dialog(LimitsDialog, answer)
        qtbot.keyClick(window.view.charts, Qt.Key.Key_L, Qt.KeyboardModifier.ShiftModifier)

    def type_both(dialog: LimitsDialog) -> None:
        assert not dialog.reset.isEnabled()
        high = dialog.edits["warning_high"]
        assert QApplication.focusWidget() is high
        qtbot.keyClicks(high, "four")
        assert not dialog.button.isEnabled()
        high.clear()
        qtbot.keyClicks(high, "4")
        for _ in range(2):
            qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
        qtbot.keyClicks(dialog.edits["caution_low"], "5")
        assert "must become smaller" in dialog.message.text()
        assert not dialog.button.isEnabled()
        dialog.edits["caution_low"].setText("−30")
        qtbot.keyClick(dialog.edits["caution_low"], Qt.Key.Key_Return)

    charts.perform("chart_down")
    ask(flight, type_both)
    assert session.limits.bands("alpha") == LimitBands(
        warning_high=pytest.approx(math.radians(4.0)), caution_low=pytest.approx(math.radians(-30))
    )
    until(
        qtbot, lambda: (one := charts.model.selected_chart) is not None and one.limits is not None
    )
    flight.flight_controller.seek(5.0)
    until(qtbot, lambda: session.alarm_registry.get("alpha:high") is not None)
    flight.flight_controller.close_flight()

    other = MainWindow(SettingsStore(flight.store.path), ErrorReporter())
    qtbot.addWidget(other)
    other.show()
    other.flight_controller.flight_opener.open_flight(session.path)
    until(
        qtbot,
        lambda: other.flight_controller.is_open and bool(other.view.charts.strip_layout.strips),
    )
    assert other.flight_controller.session.limits.bands("alpha").warning_high == pytest.approx(
        math.radians(4.0)
    )
    other.view.charts.perform("chart_down")
    ask(other, lambda dialog: dialog.reset.click())
    assert not other.flight_controller.session.limits.has_user_limits("alpha")
    assert "alpha" not in (flight.store.path.parent / "limits.toml").read_text(encoding="utf-8")
    other.flight_controller.close()


def test_limits_typed_in_another_window_count_here_at_once(
    flight: MainWindow, qtbot: QtBot
) -> None:
    limits = flight.flight_controller.session.limits
    other = UserLimitStore(limits_path(flight.store.path))
    other.write("alpha", LimitBands(warning_high=math.radians(4.0)), "US")
    until(qtbot, lambda: limits.has_user_limits("alpha"))
    assert limits.bands("alpha").warning_high == pytest.approx(math.radians(4.0))
    other.write("alpha", None, "US")
    until(qtbot, lambda: not limits.has_user_limits("alpha"))


@pytest.mark.parametrize(
    ("texts", "state", "words"),
    [
        (["", "", "", ""], "caution", "No limits"),
        (["10", "8", "-2", "-4"], "good", "at once"),
        (["10", "", "", "10"], "warning", "must become smaller"),
        (["10", "x", "", ""], "warning", "Write numbers"),
        (["400", "", "", ""], "caution", "never reached"),
    ],
)
def test_typed_limits_are_judged(texts: list[str], state: str, words: str) -> None:
    verdict = check_limits(texts, (-1.0, 1.0), math.radians)
    assert (verdict.state, words in verdict.message) == (state, True)


# The bar


def test_the_bar_says_every_state_in_words_and_never_a_stale_number() -> None:
    silent = LinkSummary(state="silent", severity=Severity.WARNING, rate=100.0, age=7.0)
    facts = StatusBarData(
        name="f", time=12.0, stale=True, link=silent,
        recorder=RecorderSummary(
            state="failed", severity=Severity.WARNING, received_bytes=2_000_000
        ),
        disk=DiskSummary(free_bytes=10**9), calibration="18",
        calibration_status=CalibrationStatus(state="warning", summary="2 uncalibrated", detail=""),
        alarms=AlarmSummary(sentences=("Too fast",), severe=True, active=1), muted=True,
    )  # fmt: skip
    parts = {part.id: part for part in create_status_items(facts)}
    assert (parts["link"].value, parts["link"].state) == ("–", "warning")
    assert parts["link"].note == "silent 7.0 s"
    assert (parts["flight"].value, parts["flight"].state) == ("–", "unknown")
    garbage = LinkSummary(state="unreadable", severity=Severity.WARNING, rate=0.0)
    port = RecorderSummary(state="recording", source_state="udpout:10.0.0.7:14550: cannot send")
    part = {
        part.id: part
        for part in create_status_items(StatusBarData(name="f", link=garbage, recorder=port))
    }
    assert (part["link"].note, part["link"].state) == ("unreadable", "warning")
    assert "udpout:10.0.0.7:14550: cannot send." in part["link"].detail
    assert parts["record"].note == "recorder failed"
    assert parts["calibration"].note == "2 uncalibrated"
    assert (parts["alarms"].value, parts["alarms"].state) == ("Too fast", "warning")
    assert parts["sound"].value == "off"


def test_the_bar_tells_a_healthy_flight_in_numbers() -> None:
    facts = StatusBarData(
        name="f", time=61.25, link=LinkSummary(state="ok", rate=412.3, age=0.12, loss=0.004),
        recorder=RecorderSummary(state="recording", received_bytes=3_210_000, growing=True),
        disk=DiskSummary(free_bytes=118 * 10**9), aircraft="B777",
    )  # fmt: skip
    parts = {part.id: part for part in create_status_items(facts)}
    assert parts["flight"].value == "01:01.2"
    assert (parts["link"].value, parts["link"].note) == ("412/s", "0.1 s old, 0.4 % lost")
    assert (parts["record"].value, parts["record"].note) == ("3.21 MB", "growing, 118 GB left")
    assert parts["link"].state == parts["record"].state == "good"


def test_a_work_that_has_ended_is_gone_and_may_still_be_asked(qtbot: QtBot) -> None:
    """Each would stay as long as the window, with all that it was made with."""
    parent, told = QObject(), []
    held = set(map(str, range(3)))
    gone = weakref.ref(held)

    def begin(words: set[str]) -> BackgroundJob:
        work = BackgroundJob("Reading", lambda _progress: len(words), parent)
        work.done.connect(told.append)
        work.start()
        return work

    kept = begin({"a"})
    begin(held)
    del held
    qtbot.waitUntil(lambda: sorted(told) == [1, 3] and not parent.children())
    # Its thread may hold it for a moment longer, in a circle.
    qtbot.waitUntil(lambda: gc.collect() >= 0 and gone() is None)
    assert not kept.is_running
    kept.cancel()


def test_a_work_may_end_while_its_window_goes(qtbot: QtBot) -> None:
    """The end of its thread and the end of its parent meet; a crash would end this process."""
    told: list[object] = []
    threads = []
    for _ in range(50):
        parent = QObject()
        work = BackgroundJob("Reading", lambda _progress: 1, parent)
        work.done.connect(told.append)
        work.start()
        threads.append(work._thread)
        del parent, work
    qtbot.waitUntil(lambda: not any(thread is not None and thread.is_alive() for thread in threads))
    qtbot.wait(1)
    assert not told


def test_a_work_may_hold_the_last_reference_to_its_window(qtbot: QtBot) -> None:
    told: list[int] = []
    gone = []

    def begin() -> None:
        parent = QObject()
        parent.destroyed.connect(lambda: gone.append(True))
        work = BackgroundJob("Reading", lambda _progress: 1, parent)
        work.done.connect(lambda _result: told.append(len(parent.children())))
        work.start()

    begin()
    qtbot.waitUntil(lambda: bool(gone))
    assert told == [1]


# The end


def test_a_desktop_that_logs_out_closes_the_window_unasked(
    window: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[object] = []
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *names: asked.append(names) or "stay")
    monkeypatch.setattr(
        type(window.flight_controller), "is_recording", property(lambda _desk: True)
    )
    window.close()
    assert window.isVisible()
    assert len(asked) == 1
    QApplication.instance().commitDataRequest.emit(None)
    window.close()
    assert not window.isVisible()
    assert len(asked) == 1


@pytest.mark.parametrize("waits", [False, True])
def test_a_session_that_ends_is_not_held_up_by_a_question(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, waits: bool
) -> None:
    monkeypatch.setattr(ui.main_window, "ask_closing", ask_closing)
    monkeypatch.setattr(
        type(window.flight_controller), "is_recording", property(lambda _desk: True)
    )
    stopped: list[str] = []
    monkeypatch.setattr(
        window.flight_controller.recorders, "stop_recording_and_wait", lambda: stopped.append("?")
    )
    if waits:
        answer_dialog(QMessageBox, lambda _box: window.close_without_asking())
        window.close()
    else:
        window.close_without_asking()
    assert not window.isVisible()
    assert SettingsStore(window.store.path).current.geometry
    assert not stopped


@pytest.mark.parametrize(
    ("key", "works", "answer"),
    [
        (Qt.Key.Key_Return, (), "leave"),
        (Qt.Key.Key_Escape, (), "stay"),
        (Qt.Key.Key_Return, ("Estimating",), "stay"),
    ],
)
@pytest.mark.parametrize("flights", [("flight 3",), ()])
def test_a_key_in_haste_ends_no_recording_and_gives_up_no_work(
    window: MainWindow,
    qtbot: QtBot,
    key: Qt.Key,
    flights: tuple[str, ...],
    works: tuple[str, ...],
    answer: str,
) -> None:
    answer_dialog(QMessageBox, lambda box: qtbot.keyClick(box, key))
    assert ask_closing(window, flights, works) == answer


def test_the_log_of_alarms_is_whole_sorted_copied_and_leads_into_the_replay(
    flight: MainWindow, qtbot: QtBot
) -> None:
    """Also what lies after the playhead, and what was seen and is over; ticks stand beside it."""
    controller = flight.flight_controller
    assert controller.session is not None
    session, panel = controller.session, flight.view.alarms
    controller.seek(0.5)
    flight.view.show_panel(3)
    session.set_user_limits("alpha", LimitBands(caution_high=0.06))
    # alpha passes 3.4 degrees every 2 s.
    until(qtbot, lambda: len(panel.view.row_model.rows) == 10)
    slider = flight.view.replay.slider
    assert len(slider._alarms) == len(flight.view.charts.model.alarms) == 10
    controller.seek(3.0)
    until(qtbot, lambda: bool(controller.unacknowledged_alarms()))
    flight.commands.actions["acknowledge"].trigger()
    until(qtbot, lambda: "menu" in panel.view.row_model.rows[-1].cells[-1])
    controller.seek(5.0)
    until(qtbot, flight.commands.actions["acknowledge"].isEnabled)
    flight.activateWindow()
    qtbot.keyClick(flight, Qt.Key.Key_K)
    until(qtbot, lambda: "key K" in panel.view.row_model.rows[-2].cells[-1])
    onsets = [line.sort_values[0] for line in panel.view.row_model.rows]
    assert onsets == sorted(onsets, reverse=True)
    panel.view.sortByColumn(0, Qt.SortOrder.AscendingOrder)
    assert len(panel.view.row_model.rows) == 10
    last = panel.view.row_model.index(9, 0)
    panel.view.scrollTo(last)
    where = panel.view.visualRect(last).center()
    qtbot.mouseClick(panel.view.viewport(), Qt.MouseButton.LeftButton, pos=where)
    qtbot.keyClick(panel.view, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    copied = QGuiApplication.clipboard().text().split("\t")
    assert copied[0] == "00:18.2"
    assert len(copied) == panel.view.row_model.columnCount()
    next(one for one in panel.view.actions() if one.text() == "Copy table").trigger()
    assert len(QGuiApplication.clipboard().text().splitlines()) == 11
    qtbot.keyClick(panel.view, Qt.Key.Key_Return)
    assert controller.time == pytest.approx(max(onsets))


@pytest.mark.parametrize("scale", [100, 200])
def test_a_message_moves_nothing_and_covers_nothing(
    flight: MainWindow, qtbot: QtBot, scale: int
) -> None:
    flight.display_style.set_scale(scale)
    QApplication.processEvents()
    before = settled_places(qtbot, flight, flight.pages, flight.view.charts)
    banner = flight.banners.show_banner("caution", "The disk is nearly full. " * 12)
    until(qtbot, banner.isVisible)
    assert settled_places(qtbot, flight, flight.pages, flight.view.charts) == before
    assert not in_window(flight.banners, flight).intersects(before[0])
    assert flight.rect().contains(in_window(flight.banners, flight))
    # What does not fit the line is in the list.
    qtbot.mouseClick(banner.label, Qt.MouseButton.LeftButton)
    (listed,) = flight.findChildren(MessagesDialog)
    assert listed.view.row_model.rows[0].cells[2] == banner.label.text()
    listed.close()


def test_closed_messages_are_listed_and_shown_again(window: MainWindow, qtbot: QtBot) -> None:
    copied: list[str] = []
    banners = window.banners
    banners.show_banner("warning", "Failed once.", ("Copy details", lambda: copied.append("x")))
    withdrawn = banners.show_banner("note", "A recorder runs.", ("Attach", copied.clear))
    qtbot.mouseClick(banners.next_button, Qt.MouseButton.LeftButton)
    assert [one.isVisible() for one in banners.banners] == [False, True]
    window.commands.actions["dismiss"].trigger()
    banners.remove(withdrawn)
    assert banners.texts() == ()
    window.commands.actions["messages"].trigger()
    (listed,) = window.findChildren(MessagesDialog)
    assert [line.cells[1:] for line in listed.view.row_model.rows] == [
        ("Note", "A recorder runs."), ("Failed", "Failed once."),
    ]  # fmt: skip
    for row in (1, 1):
        listed.view.selectRow(row)
        qtbot.mouseClick(listed.show_again_button, Qt.MouseButton.LeftButton)
    # An offer that was withdrawn is not made again.
    assert [[it.text() for it in one.buttons] for one in banners.banners] == [[], ["Copy details"]]
    banners.banners[1].buttons[0].click()
    assert copied == ["x"]
    listed.close()


@pytest.mark.parametrize("scale", [100, 150])
def test_every_menu_is_one_column(window: MainWindow, scale: int) -> None:
    window.display_style.set_scale(scale)
    pending = [action.menu() for action in window.menuBar().actions()]
    count = 0
    while pending:
        menu = pending.pop()
        count += 1
        heights = [menu.actionGeometry(action).height() for action in menu.actions()]
        assert sum(heights) < 800, menu.title()
        pending += [action.menu() for action in menu.actions() if action.menu() is not None]
    assert count > 16


def test_the_menu_of_a_chart_copies_hides_marks_and_scales(
    flight: MainWindow, qtbot: QtBot
) -> None:
    view, charts = flight.view, flight.view.charts
    charts.navigator.set_cursor("a", 4.0)
    charts.navigator.set_cursor("b", 8.0)

    def choose(words: str) -> None:
        menu = create_chart_menu(
            charts, view._state, flight.commands.actions, 5.5, flight.display_style.units, view
        )
        (action,) = [one for one in menu.actions() if one.text().startswith(words)]
        action.trigger()

    shown = charts.strip_layout.channels
    spec = charts.model.selected_chart.specs[0]
    choose(f"Copy {spec.title}")
    value = charts.model.value_at(spec.id, 5.5)
    assert QGuiApplication.clipboard().text() == channel_value_text(
        spec, value, flight.display_style.units
    )
    choose("Mark 00:05.5")
    assert flight.flight_controller.mark_times() == pytest.approx((5.5,))
    choose("Zoom to A and B")
    assert charts.view.seconds == pytest.approx(4.8)
    charts.editor.set_range((0.0, 1.0))
    assert charts.model.selected_chart.strip.range == "fixed"
    choose("Autoscale")
    assert charts.model.selected_chart.strip.range == "auto"
    choose("Hide ")
    assert charts.strip_layout.channels == shown[1:]


def test_a_chart_takes_further_channels_of_its_quantity_from_its_menu(
    flight: MainWindow, qtbot: QtBot
) -> None:
    view, charts = flight.view, flight.view.charts
    menus = []

    def actions() -> dict[str, QAction]:
        menu = create_chart_menu(
            charts, view._state, flight.commands.actions, 5.5, flight.display_style.units, view
        )
        menus.append(menu)
        return {one.text(): one for one in menu.actions()}

    position = charts.strip_layout.channels.index("alpha")
    charts.editor.select(position)
    further = actions()["Add channel"].menu().actions()
    assert [one.text() for one in further] == [channel("de").title]
    further[0].trigger()
    assert [spec.id for spec in charts.model.selected_chart.specs] == ["alpha", "de"]
    assert "Add channel" not in actions()
    # What is saved is what is on screen, in a file of its own.
    store = view.layouts._layouts
    store.save(charts.strip_layout, "compared")
    saved = store.load("compared").strips[position]
    assert [one.channel for one in saved.traces] == ["alpha", "de"]
    actions()[f"Remove {channel('alpha').title}"].trigger()
    assert [spec.id for spec in charts.model.selected_chart.specs] == ["de"]
    assert not any(text.startswith("Remove ") for text in actions())
    strips = charts.strip_layout.strips
    charts.editor.select([strip.channel for strip in strips].index("q"))
    assert "Add channel" not in actions()


def test_values_at_cursors_stand_once(flight: MainWindow, qtbot: QtBot) -> None:
    """In the table where it is open, else in one narrow column beside the charts."""
    charts = flight.view.charts
    flight.resize(1440, 900)
    flight.view.show_panel(0)
    charts.advance()
    whole = charts.geometry_in_pixels.plot.width
    for name, time in (("a", 3.0), ("b", 5.0), ("cursor", 4.0)):
        charts.navigator.set_cursor(name, time)
    charts.advance()
    assert charts.geometry_in_pixels.plot.width > 0.85 * whole
    assert len(charts.geometry_in_pixels.cursors) == 1
    flight.view.show_panel(1)
    charts.advance()
    assert charts.geometry_in_pixels.plot.width == whole
