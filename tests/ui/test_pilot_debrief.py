"""The debrief in the place Pilot: gone through by keys, drawn, kept in a catalog."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from gsapp.excitation.debrief import Debrief
from tests.ui.pilot_kit import BASE, debrief, flights, judged
from tests.ui.preflight_kit import as_opened, dress
from tests.ui.window_kit import (
    ALT,
    CONTROL,
    LOOKS,
    check_labels,
    pixels,
    press,
    until,
    write_flight,
)
from ui.main_window import MainWindow
from ui.pilot.debrief_controller import load_trends, save_debrief
from ui.pilot.debrief_page import (
    DebriefPage,
    build_maneuver_item,
    build_trend_rows,
    list_verdict_reasons,
)
from ui.pilot.page_state import FlightCues
from ui.settings import catalog_path


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    yield from as_opened(made, qtbot)
    made.pilot_page.show_page(debrief=False)


@pytest.fixture
def page(window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> DebriefPage:
    shown = debrief()
    monkeypatch.setattr(FlightCues, "is_open", True)
    monkeypatch.setattr(FlightCues, "debrief", lambda _self: shown)
    qtbot.keyClick(window, Qt.Key.Key_F3)
    press(qtbot, Qt.Key.Key_2, ALT)
    QApplication.processEvents()
    found = window.pilot_page.debrief.page
    found.list.select_row(0)
    return found


# Words


def test_a_maneuver_is_told_with_verdict_reason_and_what_was_wanted() -> None:
    line = build_maneuver_item(judged(), "US")
    assert line.text == "M7  aileron and rudder doublet"
    assert (line.state, line.state_text, line.note) == ("caution", "too small", "C1")
    assert line.detail.startswith("02:55.0, 100.0 ft/s")
    said = list_verdict_reasons(judged(), "US")
    assert said[0] == "rudder doublet too small: 50 % larger"
    assert "4.9 ° (wanted 7.0 °" in said[2]
    assert said[3].startswith("begun 1.2 s")
    assert "started without GO" in list_verdict_reasons(judged(go=False), "US")[3]


def test_flights_in_a_row_come_newest_first() -> None:
    rows = build_trend_rows(flights())
    assert [row[0][-1] for row in rows] == ["3", "2", "1"]
    assert rows[0][1:3] == ("9 of 12", "60 %")
    assert rows[0][3] == "aileron 0.9, rudder 0.8"


# Keys and pixels


def test_keys_go_through_the_maneuvers(page: DebriefPage, qtbot: QtBot) -> None:
    """Down goes on, Enter goes to the maneuver, Esc comes back, Alt+1 goes to the page."""
    assert page.list.hasFocus()
    assert page.headline.text().startswith("2026-05-12 flight 2")
    press(qtbot, Qt.Key.Key_Down)
    assert page.title.text() == "M2  aileron and rudder doublet: too small"
    assert "50 % larger" in page.reasons.text()
    press(qtbot, Qt.Key.Key_Return)
    assert page.scroll_area.hasFocus()
    press(qtbot, Qt.Key.Key_PageDown)
    assert page.scroll_area.verticalScrollBar().value() > 0
    press(qtbot, Qt.Key.Key_Escape)
    assert page.list.hasFocus()
    press(qtbot, Qt.Key.Key_1, ALT)
    window = page.window()
    assert isinstance(window, MainWindow)
    assert window.pilot_page.canvas.hasFocus()
    # The place comes back to where it was left.
    press(qtbot, Qt.Key.Key_2, ALT)
    qtbot.keyClick(window, Qt.Key.Key_F2)
    qtbot.keyClick(window, Qt.Key.Key_F3)
    assert page.list.hasFocus()


def test_the_chart_shows_the_input_within_the_wanted_band(page, window):
    """The aileron of M2 reaches into its band, the rudder stays below it; both in pixels."""
    page.list.select_item("M2")
    QApplication.processEvents()
    reached = []
    # Each surface in its color: aileron purple, rudder rust.
    for chart, low, name in zip(page.charts.surfaces, (4.0, 7.0), ("purple", "rust"), strict=True):
        ink = int(window.display_style.theme.trace(name)[1:], 16)
        assert chart.isVisible()
        bottom_axis = chart.plot.getPlotItem().getAxis("bottom")
        assert bottom_axis.clock  # of the flight, as on all pages
        assert bottom_axis.range[0] <= page.current_maneuver.verdict.t_input <= bottom_axis.range[1]
        box = chart.plot.getPlotItem().getViewBox()
        inner = box.mapRectToScene(box.boundingRect()).toRect().adjusted(4, 4, -4, -4)
        rows = np.flatnonzero((pixels(chart.plot, inner) == ink).any(axis=1)) + inner.top()
        bottom, top = box.viewRange()[1]
        per_pixel = (top - bottom) / box.mapRectToScene(box.boundingRect()).height()
        half = 0.5 * (rows[-1] - rows[0]) * per_pixel
        reached.append(half - low)
    assert reached[0] > 1.0
    assert reached[1] < -1.0


def test_a_maneuver_is_shown_in_the_charts(page, window, qtbot):
    press(qtbot, Qt.Key.Key_Down)
    press(qtbot, Qt.Key.Key_Return, Qt.KeyboardModifier.ShiftModifier)
    assert window.pages.currentWidget() is window.flight_page


def test_what_is_judged_while_it_is_looked_at_is_added(page, window, monkeypatch):
    whole = debrief()
    shown, events = [replace(whole, maneuvers=whole.maneuvers[:7])], [1]
    monkeypatch.setattr(FlightCues, "snapshot", lambda _self: replace(BASE, event_count=events[0]))
    monkeypatch.setattr(FlightCues, "debrief", lambda _self: shown[0])
    window.pilot_page.refresh()
    assert len(page.list.row_model.rows) == 7
    shown[0] = whole
    window.pilot_page.refresh()
    assert len(page.list.row_model.rows) == 7
    events[0] = 2
    window.pilot_page.refresh()
    assert len(page.list.row_model.rows) == 8


def test_a_flight_without_inputs_says_so(page, window, monkeypatch):
    monkeypatch.setattr(FlightCues, "debrief", lambda _self: Debrief(flight="x", maneuvers=()))
    window.pilot_page.refresh()
    assert "are flown" in page.title.text()
    assert not page.charts.isVisible()
    assert "no test cards" in page.cards.empty_label.text()


@pytest.mark.parametrize(
    ("size", "scale", "theme"),
    [LOOKS[1], *(pytest.param(*one, marks=pytest.mark.long) for one in LOOKS[::2])],
)
def test_nothing_is_cut_and_nothing_overlaps(page, window, size, scale, theme):
    dress(window, theme, scale)
    window.resize(*size)
    page.show_trends(flights())
    page.list.select_item("M2")
    page.focus_maneuver()
    for _ in range(3):
        QApplication.processEvents()
    body = page.scroll_area.widget()
    assert body.width() <= page.scroll_area.viewport().width()
    check_labels(body)
    page.set_initial_focus()
    for control in (page.list, page.scroll_area):
        assert control.accessibleName()


# The catalog


def test_a_debrief_is_kept_and_flights_are_compared(tmp_path: Path) -> None:
    """Kept twice it is there once; another flight comes after it."""
    catalog = tmp_path / "campaign.sqlite"
    assert load_trends(catalog) == ()
    for name in ("one", "one", "two"):
        made = replace(debrief(), flight=name)
        save_debrief(write_flight(tmp_path / name), made, catalog)
    (kept,) = load_trends(catalog)  # both files are called small.csv
    assert (kept.inputs, kept.good) == (8, 4)
    assert kept.amplitudes["dr"] == pytest.approx(0.49, abs=0.01)


def test_ctrl_s_keeps_the_open_flight(window, qtbot, tmp_path, monkeypatch):
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    shown = replace(debrief(), flight=window.flight_controller.name)
    monkeypatch.setattr(FlightCues, "debrief", lambda _self: shown)
    qtbot.keyClick(window, Qt.Key.Key_F3)
    press(qtbot, Qt.Key.Key_2, ALT)
    press(qtbot, Qt.Key.Key_S, CONTROL)
    catalog = catalog_path(window.store.current)
    until(qtbot, lambda: any(" is in " in text for text in window.banners.texts()))
    assert catalog.is_file()
    page = window.pilot_page.debrief.page
    rows = [widget.text() for widget in page.trends.findChildren(QLabel) if _stands(widget, page)]
    assert "4 of 8" in rows


def _stands(widget: QWidget, page: QWidget) -> bool:
    return widget.isVisibleTo(page) and widget.mapTo(page, QPoint(0, 0)) is not None
