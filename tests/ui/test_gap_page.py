"""The page Model gap, driven by keys: the story of an answer, and what is on screen of it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QComboBox,
    QFileDialog,
    QLineEdit,
    QPushButton,
    QSlider,
    QWidget,
)
from pytestqt.qtbot import QtBot

import ui.gap.gap_page
import ui.main_window
from gsapp.dynamics.model import load_model
from gsapp.flight.cards import load_cards
from gsapp.foundation import GroundStationError
from gsapp.quantities import trace_color
from gsapp.quantities.constants import DEGREE
from tests.ui.gap_kit import ALPHA2, BACKLASH, THROTTLE, TITLES, FakeEngine, make_open
from tests.ui.window_kit import (
    ALT,
    CONTROL,
    LOOKS,
    SHIFT,
    activate,
    answer_dialog,
    check_labels,
    count,
    opened_window,
    pixels,
    press,
    until,
    write_flight,
)
from ui.gap import gap_text
from ui.gap.add_and_show import ForceEffectDialog
from ui.gap.search_jobs import GapReportJob, GapRequest
from ui.main_window import MainWindow
from ui.settings import next_flight_path
from ui.theme import THEMES
from ui.widgets.paint_primitives import level_colors

LONG = pytest.mark.long


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[MainWindow]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ui.gap.gap_page, "create_search_job_runner", FakeEngine)
        with opened_window(tmp_path_factory.mktemp("window")) as window:
            yield window


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    """Return the window as it was when it was opened."""
    gap = made.gap_page
    gap.search._job_runner = FakeEngine()
    gap.search.result = None
    gap.search.undo_stack.clear()
    gap.set_open_flight(None)
    if gap.setup is not None:
        gap.setup._show_paths(())
        gap.setup._update_state()
        gap.stack.setCurrentWidget(gap.setup)
    if gap.result_view is not None:
        gap.result_view.result = None
    made.display_style.set_theme("daylight")
    made.display_style.set_scale(100)
    made.display_style.set_units("US")
    made.store.change(gap_variable="alpha", gap_channel="q", gap_flights=())
    made.resize(1280, 800)
    for banner in list(made.banners.banners):
        made.banners.remove(banner)
    made.show_page("flight")
    activate(qtbot, made)
    yield made
    gap.search._job_runner.hold.set()
    gap.cancel()
    until(qtbot, lambda: not gap.busy)
    made.flight_controller.close_flight()


@pytest.fixture
def engine(window: MainWindow) -> FakeEngine:
    return window.gap_page.search._job_runner


@pytest.fixture
def story(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> MainWindow:
    window.gap_page.set_open_flight(write_flight(tmp_path))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Return)
    until(
        qtbot,
        lambda: window.gap_page.is_result_shown and len(window.gap_page.result_view.stages) == 4,
    )
    QApplication.processEvents()
    return window


def filled(plot: QWidget, color: str) -> float:
    box = plot.getPlotItem().getViewBox()
    inner = box.mapRectToScene(box.boundingRect()).toRect().adjusted(30, 4, -30, -4)
    shown = pixels(plot)[inner.top() : inner.bottom(), inner.left() : inner.right()]
    parts = np.stack([shown >> 16, (shown >> 8) & 255, shown & 255]).astype(int)
    wanted = np.array([int(color[place : place + 2], 16) for place in (1, 3, 5)])
    near = np.abs(parts - wanted[:, None, None]).sum(axis=0) < 110
    return float(near.any(axis=0).mean())


# Beginning


def test_the_empty_page_says_what_to_do_and_offers_it(window: MainWindow, qtbot: QtBot) -> None:
    qtbot.keyClick(window, Qt.Key.Key_F5)
    setup = window.gap_page.setup
    assert not setup.search.isEnabled()
    assert "No flight." in setup.message.text()
    # The keyboard stands where one goes on.
    assert setup.trial.hasFocus()
    asked = []
    setup.command_requested.disconnect()
    setup.command_requested.connect(asked.append)
    for button in (setup.open, setup.virtual):
        button.setFocus()
        press(qtbot, Qt.Key.Key_Space)
    assert asked == ["open_file", "virtual"]


def test_flights_are_listed_taken_out_and_remembered(window, qtbot, tmp_path):
    qtbot.keyClick(window, Qt.Key.Key_F5)
    setup = window.gap_page.setup
    one, other = write_flight(tmp_path / "a"), write_flight(tmp_path / "b")
    window.gap_page.set_open_flight(one)
    assert setup.paths == (one,)
    # Another flight that is opened is offered, not mixed in unasked.
    window.gap_page.set_open_flight(other)
    assert setup.paths == (one,)
    setup.add_open.setFocus()
    press(qtbot, Qt.Key.Key_Return)
    assert setup.paths == (one, other)
    setup.flights.setFocus()
    press(qtbot, Qt.Key.Key_Delete)
    assert setup.paths == (other,)
    setup.request_search()
    until(qtbot, lambda: window.gap_page.is_result_shown)
    assert window.store.current.gap_flights == (str(other),)
    other.unlink()
    setup._update_state()
    assert "no longer exists" in setup.message.text()


def test_a_search_runs_behind_and_the_open_flight_is_searched(window, qtbot, tmp_path, engine):
    """F5, Enter: progress with words, and the window goes on meanwhile."""
    flight = write_flight(tmp_path)
    window.flight_controller.flight_opener.open_flight(flight, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    engine.hold.clear()
    qtbot.keyClick(window, Qt.Key.Key_F5)
    press(qtbot, Qt.Key.Key_Return)
    strip = window.gap_page.strip
    # A second Enter does nothing.
    assert window.gap_page.setup.flights.hasFocus()
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: strip.isVisible() and "weighing" in strip.text_label.text())
    until(qtbot, lambda: strip.progress_bar.value() == 500)
    until(qtbot, lambda: "left" in strip.text_label.text())
    # Other commands act while it runs.
    qtbot.keyClick(window, Qt.Key.Key_U, CONTROL)
    assert window.display_style.units == "SI"
    # What is listed meanwhile is not in what runs, and is not called so.
    window.gap_page.setup.add_flight(write_flight(tmp_path / "another"))
    assert "next search" in window.gap_page.setup.message.text()
    engine.hold.set()
    until(qtbot, lambda: window.gap_page.is_result_shown)
    assert "2 flights, searched together" in window.gap_page.setup.message.text()
    assert not strip.isVisible()
    job = engine.jobs[0]
    assert isinstance(job, GapRequest)
    assert (job.flights, job.model) == ((flight,), "b777")


def test_stop_stops_and_what_was_known_stays(story, qtbot, engine):
    before = story.gap_page.search.result
    engine.hold.clear()
    press(qtbot, Qt.Key.Key_3, ALT)
    press(qtbot, Qt.Key.Key_Backspace, CONTROL)
    until(qtbot, story.gap_page.strip.isVisible)
    press(qtbot, Qt.Key.Key_Period, CONTROL)
    until(qtbot, lambda: not story.gap_page.search.running)
    assert story.gap_page.search.result is before
    assert story.gap_page.is_result_shown
    assert any("stopped" in text for text in story.banners.texts())
    # The button beside the progress does the same.
    press(qtbot, Qt.Key.Key_Backspace, CONTROL)
    until(qtbot, story.gap_page.strip.isVisible)
    story.gap_page.strip.stop_button.click()
    until(qtbot, lambda: not story.gap_page.search.running)


def test_a_search_goes_on_behind_other_places_and_its_result_is_kept(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, engine: FakeEngine
) -> None:
    engine.hold.clear()
    window.gap_page.set_open_flight(write_flight(tmp_path))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: window.gap_page.search.running)
    qtbot.keyClick(window, Qt.Key.Key_F2)
    until(qtbot, lambda: any("weighing" in text for text in window.banners.texts()))
    engine.hold.set()
    until(qtbot, lambda: window.gap_page.search.result is not None)
    assert window.pages.currentWidget() is not window.gap_page
    until(qtbot, lambda: any("grows with throttle" in text for text in window.banners.texts()))
    window.banners.banners[0].buttons[0].click()
    assert window.gap_page.is_result_shown
    qtbot.keyClick(window, Qt.Key.Key_F2)
    qtbot.keyClick(window, Qt.Key.Key_F5)
    assert window.gap_page.is_result_shown


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (GroundStationError("only one maneuver: fly one more of each kind"), "only one maneuver"),
        (ValueError("shapes differ"), "Internal error"),
    ],
)
def test_what_fails_is_told_in_a_sentence(
    window: MainWindow,
    qtbot: QtBot,
    tmp_path: Path,
    engine: FakeEngine,
    error: Exception,
    words: str,
) -> None:
    engine.fails = error
    window.gap_page.set_open_flight(write_flight(tmp_path))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: any(words in text for text in window.banners.texts()))
    assert window.gap_page.setup.search.isEnabled()


def test_a_new_search_can_be_left_for_the_answer_that_is_there(story, qtbot):
    press(qtbot, Qt.Key.Key_F, CONTROL)
    setup = story.gap_page.setup
    assert story.gap_page.stack.currentWidget() is setup
    assert setup is not None
    assert setup.back.isVisible()
    setup.back.setFocus()
    press(qtbot, Qt.Key.Key_Return)
    assert story.gap_page.is_result_shown


# Find


def check_map(window: MainWindow) -> None:
    table, theme = window.gap_page.result_view.stages["find"].map, window.display_style.theme
    seen = pixels(table.viewport())
    checked = 0
    for row, cells in enumerate(one.value for one in table.row_model.rows):
        for column in (0, 4):
            box = table.visualRect(table.row_model.index(row, column))
            if not table.viewport().rect().contains(box):
                continue
            fill, text = level_colors(theme, cells[column].level)
            inside = seen[box.top() + 3 : box.bottom() - 2, box.left() + 3 : box.right() - 2]
            assert (inside == int(fill[1:], 16)).mean() > 0.5, (theme.name, row, column)
            assert (inside == int(text[1:], 16)).any(), (theme.name, row, column)
            checked += 1
    assert checked >= 6


def test_the_map_shows_number_and_color_and_arrows_choose_a_cell(story, qtbot):
    view = story.gap_page.result_view.stages["find"]
    assert view.map.hasFocus()
    index = view.map.currentIndex()
    model = view.map.row_model
    assert (model.rows[index.row()].key, model.titles[index.column()]) == ("8", "Cm")
    check_map(story)
    assert model.index(7, 4).data() == "17"
    press(qtbot, Qt.Key.Key_Up)
    assert "maneuver 7" in view.trace.title.text()
    press(qtbot, Qt.Key.Key_Left, times=2)
    assert story.gap_page.result_view.selection.coefficient == "CZ"
    assert "CZ" in view.trace.title.text()
    assert "CZ" in view.cloud.title.text()


def test_levels_differ_and_their_numbers_are_readable() -> None:
    from ui.theme import contrast

    for theme in THEMES.values():
        colors = [level_colors(theme, level) for level in range(5)]
        assert len({fill for fill, _ in colors}) == 5
        least = 7.0 if theme.name != "dark" else 4.5
        assert min(contrast(fill, text) for fill, text in colors) >= least


def test_the_history_is_drawn_with_floor_and_region(story: MainWindow, qtbot: QtBot) -> None:
    """The trace in its color; the floor as a band; points right of 70 % throttle lie in a span."""
    view = story.gap_page.result_view.stages["find"]
    theme = story.display_style.theme
    assert count(view.trace.plot, theme.traces["blue"]) > 100
    floor = story.display_style.color("chosen").name()
    assert count(view.trace.plot, floor) > 1000
    assert view.variable.current_key == "throttle"
    assert count(view.cloud.plot, theme.event) > 500
    assert count(view.cloud.plot, theme.previous) > 100
    view.variable.box.setFocus()
    press(qtbot, Qt.Key.Key_Up)
    assert story.gap_page.result_view.selection.variable == "V"
    assert "ft/s" in view.cloud.plot.getPlotItem().getAxis("bottom").labelText
    qtbot.keyClick(story, Qt.Key.Key_U, CONTROL)
    assert "m/s" in view.cloud.plot.getPlotItem().getAxis("bottom").labelText


def test_charts_move_and_zoom_by_keys(story: MainWindow, qtbot: QtBot) -> None:
    plot = story.gap_page.result_view.stages["find"].trace.plot
    plot.setFocus()
    whole = plot.getPlotItem().getViewBox().viewRange()[0]
    press(qtbot, Qt.Key.Key_Up)
    zoomed = plot.getPlotItem().getViewBox().viewRange()[0]
    assert zoomed[1] - zoomed[0] == pytest.approx(0.7 * (whole[1] - whole[0]))
    press(qtbot, Qt.Key.Key_Right)
    assert plot.getPlotItem().getViewBox().viewRange()[0][0] > zoomed[0]
    press(qtbot, Qt.Key.Key_Home)
    assert plot.getPlotItem().getViewBox().viewRange()[0] == pytest.approx(whole)


def test_a_disagreement_in_words_leads_to_its_cell(story: MainWindow, qtbot: QtBot) -> None:
    view = story.gap_page.result_view.stages["find"]
    lines = view.lines.row_model.rows
    assert all(fact in lines[0].cells[1] for fact in ("Cm", "10 times", "throttle", "70 %"))
    view.lines.setFocus()
    press(qtbot, Qt.Key.Key_Down, times=3)
    key = view.lines.current_key()
    one = story.gap_page.search.result.discrepancy.disagreements[key]
    assert story.gap_page.result_view.selection.maneuver == one.maneuver
    assert "below 1 in a million" in view.detail.text()


# Through the models


def test_going_through_the_models_shrinks_the_map(story: MainWindow, qtbot: QtBot) -> None:
    view = story.gap_page.result_view.stages["find"]
    table = view.map
    texts = [table.row_model.rows[7].cells[4]]
    for _ in range(2):
        press(qtbot, Qt.Key.Key_Right, ALT)
        texts.append(table.row_model.rows[7].cells[4])
    assert [float(text) for text in texts] == pytest.approx([17, 5.2, 1.4], abs=0.2)
    assert story.gap_page.result_view.track.value() == 2
    assert "Slop" in story.gap_page.result_view.track.accessibleDescription()
    assert count(view.trace.plot, story.display_style.theme.previous) > 50
    track = story.gap_page.result_view.track
    track.setFocus()
    press(qtbot, Qt.Key.Key_Left)
    assert story.gap_page.result_view.selection.step == 1
    qtbot.mouseClick(track, Qt.MouseButton.LeftButton, pos=QPoint(4, 10))
    assert story.gap_page.result_view.selection.step == 0


# Name


def test_the_ranking_shows_evidence_and_what_is_known_of_each(story, qtbot):
    press(qtbot, Qt.Key.Key_2, ALT)
    view = story.gap_page.result_view.stages["name"]
    assert view.ranking.hasFocus()
    assert "right in 97 of 100" in view.winner.text()
    assert "24.5" in view.margin.text()
    assert TITLES["aero.Cm.speed"] in view.margin.text()
    # The bar is as long as the evidence.
    seen = pixels(view.ranking.viewport())
    ink = int(story.display_style.theme.text[1:], 16)

    def bar(row: int) -> int:
        box = view.ranking.visualRect(view.ranking.row_model.index(row, 1))
        return int((seen[box.center().y(), box.left() : box.right() - 58] == ink).sum())

    room = view.ranking.columnWidth(1) - 6 - 2 - 56
    assert bar(0) == pytest.approx(0.97 * room, abs=3)
    assert bar(1) <= 5
    assert view.effect.text() == TITLES[THROTTLE]
    press(qtbot, Qt.Key.Key_Down)
    assert view.effect.text() == TITLES["aero.Cm.speed"]
    headings = [heading for heading, _ in view.about._shown]
    assert "Mistaken for" in headings
    assert any("separates them" in heading for heading in headings)


def test_what_stands_for_a_set_names_the_others(story: MainWindow, qtbot: QtBot) -> None:
    answer = story.gap_page.result_view.result
    first, *rest = answer.discrepancy.effects
    first = replace(first, one_of=(THROTTLE, "aero.Cm.speed"))
    found = replace(answer.discrepancy, effects=(first, *rest))
    story.gap_page.result_view.show_result(replace(answer, discrepancy=found))
    press(qtbot, Qt.Key.Key_2, ALT)
    names = story.gap_page.result_view.stages["name"]
    text = f"cannot tell it from “{TITLES['aero.Cm.speed']}”"
    assert text in names.winner.text()
    assert "of 100" not in names.winner.text()
    press(qtbot, Qt.Key.Key_3, ALT)
    adds = story.gap_page.result_view.stages["add"]
    assert text in adds.sentences.text()


def test_what_the_flights_could_not_show_stands_there(story: MainWindow, qtbot: QtBot) -> None:
    press(qtbot, Qt.Key.Key_2, ALT)
    view = story.gap_page.result_view.stages["name"]
    cells = [line.cells for line in view.observability.row_model.rows]
    assert cells[0] == (
        TITLES["aero.Cm.alphadot"], "1.4 σ, too little", "elevator doublets twice as fast"
    )  # fmt: skip
    assert len(cells) == 3
    view.hidden_only.setFocus()
    press(qtbot, Qt.Key.Key_Space)
    assert len(view.observability.row_model.rows) == 1
    assert "Center of gravity" in view.alternatives._shown[0][0]
    assert "weigh" in view.alternatives._shown[0][1]


def test_after_the_last_effect_nothing_more_is_proven(story: MainWindow, qtbot: QtBot) -> None:
    press(qtbot, Qt.Key.Key_2, ALT)
    press(qtbot, Qt.Key.Key_Right, ALT, times=2)
    view = story.gap_page.result_view.stages["name"]
    assert "No further effect" in view.winner.text()
    assert not story.commands.actions["gap_accept"].isEnabled()


# Add


def test_effects_are_accepted_one_after_the_other(story: MainWindow, qtbot: QtBot) -> None:
    press(qtbot, Qt.Key.Key_3, ALT)
    view = story.gap_page.result_view.stages["add"]
    assert [line.cells[2] for line in view.effects.row_model.rows] == ["next", "later"]
    assert view.parameters.rows == (("Cm_throttle", "−0.0412 ± 0.0013"),)
    assert [line.cells for line in view.values.row_model.rows] == [
        ("Cmq", "−20.00", "−22.60 ± 0.42", "6.2 σ")
    ]
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    assert [line.cells[2] for line in view.effects.row_model.rows] == ["in the model", "next"]
    view.buttons["gap_accept"].setFocus()
    press(qtbot, Qt.Key.Key_Return)
    assert [line.cells[2] for line in view.effects.row_model.rows] == ["in the model"] * 2
    assert not view.buttons["gap_accept"].isEnabled()


def test_structure_without_a_name_is_said_to_be_that(window, qtbot, tmp_path, engine):
    """It stands among the effects of the model, with its size, and no confidence."""
    engine.effects = ("unnamed.CA.absbeta", BACKLASH)
    window.gap_page.set_open_flight(write_flight(tmp_path))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Return)
    until(qtbot, lambda: window.gap_page.is_result_shown)
    press(qtbot, Qt.Key.Key_3, ALT)
    view = window.gap_page.result_view.stages["add"]
    assert view.selected_effect == "unnamed.CA.absbeta"
    assert "not understood" in view.sentences.text()
    assert "100" not in view.sentences.text()
    assert view.structure.isVisible()
    color = window.display_style.theme.trace(trace_color("CA"))
    assert filled(view.structure.plot, color) > 0.2
    headline = gap_text.verdict_text(window.gap_page.search.result)
    assert TITLES[BACKLASH] in headline
    press(qtbot, Qt.Key.Key_Down)
    assert view.selected_effect == BACKLASH
    assert not view.structure.isVisible()
    press(qtbot, Qt.Key.Key_Up)


def test_structure_without_a_name_is_saved_as_a_table(window, qtbot, tmp_path, engine, monkeypatch):
    """With the box ticked, the model of the last step holds a table in place of the product."""
    target = tmp_path / "tabled.toml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    engine.effects = ("unnamed.CA.absbeta",)
    window.gap_page.set_open_flight(write_flight(tmp_path))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_Return)
    until(qtbot, lambda: window.gap_page.is_result_shown)
    press(qtbot, Qt.Key.Key_3, ALT)
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    box = window.gap_page.result_view.stages["add"].as_tables
    for expected in ("unnamed.CA.table_beta", "unnamed.CA.absbeta"):
        qtbot.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))
        press(qtbot, Qt.Key.Key_S, CONTROL)
        (effect,) = load_model(target).effects
        assert effect.id == expected


def test_an_effect_is_refused_and_that_is_taken_back(story, qtbot, engine):
    press(qtbot, Qt.Key.Key_3, ALT)
    view = story.gap_page.result_view.stages["add"]
    assert view.selected_effect == THROTTLE
    press(qtbot, Qt.Key.Key_Backspace, CONTROL)
    until(qtbot, lambda: len(engine.jobs) == 2 and not story.gap_page.busy)
    assert engine.jobs[1].refused == (THROTTLE,)
    rows = [line.cells for line in view.effects.row_model.rows]
    assert rows == [("1", TITLES[BACKLASH], "next"), ("–", TITLES[THROTTLE], "refused")]
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert [line.key for line in view.effects.row_model.rows] == [THROTTLE, BACKLASH]
    press(qtbot, Qt.Key.Key_Y, CONTROL)
    assert [line.cells[2] for line in view.effects.row_model.rows] == ["next", "refused"]
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert not story.commands.actions["undo"].isEnabled()
    # Nothing was searched again for going back and forth.
    assert len(engine.jobs) == 2


def test_another_effect_is_forced_from_a_list_that_can_be_searched(story, qtbot, engine):
    def fill(dialog: ForceEffectDialog) -> None:
        assert dialog.focusWidget() is dialog.search
        # What is in the model is not offered.
        keys = {row.key for row in dialog.listed.row_model.rows}
        assert THROTTLE not in keys
        qtbot.keyClicks(dialog.search, "no such thing")
        assert not dialog.button.isEnabled()
        dialog.search.clear()
        qtbot.keyClicks(dialog.search, "nonlinearly")
        assert dialog.button.isEnabled()
        qtbot.keyClick(dialog.search, Qt.Key.Key_Return)

    press(qtbot, Qt.Key.Key_3, ALT)
    answer_dialog(ForceEffectDialog, fill)
    press(qtbot, Qt.Key.Key_F, CONTROL | SHIFT)
    until(qtbot, lambda: len(engine.jobs) == 2 and not story.gap_page.busy)
    assert engine.jobs[1].forced == (ALPHA2,)
    view = story.gap_page.result_view.stages["add"]
    assert view.effects.row_model.rows[0].cells[2] == "next, forced"


def test_the_model_of_the_step_is_saved(story, qtbot, tmp_path, monkeypatch):
    target = tmp_path / "revised.toml"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(qtbot, Qt.Key.Key_3, ALT)
    press(qtbot, Qt.Key.Key_Return, CONTROL)
    press(qtbot, Qt.Key.Key_S, CONTROL)
    model = load_model(target)
    assert [effect.id for effect in model.effects] == [THROTTLE]
    assert model.parent == "b777"


def test_a_name_is_proposed_for_the_model_that_every_disk_takes(story, qtbot, monkeypatch):
    asked: list[str] = []

    def ask(_parent: object, _title: str, start: str, _kinds: str) -> tuple[str, str]:
        asked.append(Path(start).name)
        return "", ""

    answer = story.gap_page.search.result
    steps = tuple(
        replace(one, model=one.model.model_copy(update={"name": "B777: day 3/4"}))
        for one in answer.discrepancy.steps
    )
    named = replace(answer, discrepancy=replace(answer.discrepancy, steps=steps))
    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    monkeypatch.setattr(story.gap_page.result_view, "result", named)
    press(qtbot, Qt.Key.Key_3, ALT)
    press(qtbot, Qt.Key.Key_S, CONTROL)
    assert asked == ["B777- day 3-4.toml"]


# Show


def test_the_end_shows_before_and_after_on_a_maneuver_kept_out(story, qtbot):
    """Measured solid, computed dashed, the baseline gray; the last model, unless chosen."""
    press(qtbot, Qt.Key.Key_4, ALT)
    view, theme = story.gap_page.result_view.stages["show"], story.display_style.theme
    assert story.gap_page.result_view.selection.step == 2
    assert "Maneuver 6, held out" in view.overlay.title.text()
    # Of all channels the one whose gap shrank most.
    assert story.gap_page.result_view.selection.channel == "alpha"
    view.channel.box.setFocus()
    press(qtbot, Qt.Key.Key_Down)
    assert story.store.current.gap_channel == "q"
    box = view.overlay.plot.getPlotItem().getViewBox()
    inside = view.overlay.plot.mapFromScene(box.sceneBoundingRect()).boundingRect()
    inner = inside.adjusted(4, 4, -4, -4)
    shown_inside = pixels(view.overlay.plot)[
        inner.top() : inner.bottom(), inner.left() : inner.right()
    ]
    seen = {
        color: (shown_inside == int(color[1:], 16)).sum()
        for color in (theme.trace("blue"), theme.text, theme.previous)
    }
    assert min(seen.values()) > 40
    assert "94 ± 3 %" in view.closed.text()
    assert "2 and 6" in view.on.text()
    numbers = {line.key: line.cells for line in view.numbers.row_model.rows}
    assert numbers["q"][1].split() == ["1.38", "→", "0.23", "°/s"]
    assert numbers["q"][5].split() == ["100", "→", "100", "%"]
    # Dashes leave gaps: of the columns between both ends fewer hold the baseline.
    press(qtbot, Qt.Key.Key_Left, ALT, times=2)
    share = {name: filled(view.overlay.plot, theme.trace(name)) for name in ("blue", "previous")}
    assert share["blue"] > 0.97
    assert 0.4 < share["previous"] < 0.9
    press(qtbot, Qt.Key.Key_PageDown, ALT)
    assert "Maneuver 7, used" in view.overlay.title.text()
    assert story.gap_page.result_view.selection.channel == "q"


def test_bars_and_waterfall_are_as_long_as_the_numbers(story: MainWindow, qtbot: QtBot) -> None:
    press(qtbot, Qt.Key.Key_4, ALT)
    view, theme = story.gap_page.result_view.stages["show"], story.display_style.theme
    shown = pixels(view.bars)
    gray, blue = (int(color[1:], 16) for color in (theme.previous, theme.traces["blue"]))
    # alpha: from 7 to 1 floors; r: from 2 to 1.
    long, short = ((shown[row] == gray).sum() for row in (8, 5 * 34 + 8))
    assert long / short == pytest.approx(7 / 2, rel=0.03)
    after = (shown[8 + 14] == blue).sum()
    assert long / after == pytest.approx(7, rel=0.05)
    assert "7.0 to 1.0" in view.bars.accessibleDescription()
    falls = pixels(view.waterfall)
    lengths = [int((falls[row * 40 + 27] == gray).sum()) for row in range(3)]
    assert lengths[0] / lengths[1] == pytest.approx(5.2 / 2.05, rel=0.05)
    assert lengths[1] / lengths[2] == pytest.approx(2.05, rel=0.05)
    press(qtbot, Qt.Key.Key_Left, ALT, times=2)
    assert (pixels(view.bars)[8 + 14] == blue).sum() == pytest.approx(long, rel=0.02)


def test_the_report_is_written_behind_the_window(story, qtbot, tmp_path, monkeypatch, engine):
    target = tmp_path / "gap.html"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(qtbot, Qt.Key.Key_P, CONTROL)
    until(qtbot, lambda: any("gap.html" in text for text in story.banners.texts()))
    assert isinstance(engine.jobs[-1], GapReportJob)
    assert target.read_text(encoding="utf-8") == "report"
    assert story.gap_page.is_result_shown


# An adequate model


def test_a_model_without_a_gap_is_told_so(window, qtbot, tmp_path, engine):
    engine.effects = ()
    window.gap_page.search.search(GapRequest(flights=(tmp_path,)))
    qtbot.keyClick(window, Qt.Key.Key_F5)
    until(qtbot, lambda: window.gap_page.is_result_shown)
    story = window.gap_page.result_view
    assert "No effect is missing" in story.verdict.text()
    assert "residuals are at" in story.stages["find"].empty_label.text()
    for number, chapter in enumerate(("find", "name", "add", "show"), start=1):
        press(qtbot, getattr(Qt.Key, f"Key_{number}"), ALT)
        assert story.stage == chapter
    assert "%" not in story.stages["show"].closed.text()
    assert "No effect" in story.stages["add"].empty_label.text()


# All of it


def test_tab_reaches_every_control_and_each_has_a_name(story: MainWindow, qtbot: QtBot) -> None:
    page = story.gap_page.result_view
    for chapter in range(1, 5):
        press(qtbot, getattr(Qt.Key, f"Key_{chapter}"), ALT)
        view = page.stages[page.stage]
        wanted = {
            widget
            for kind in (QPushButton, QComboBox, QAbstractItemView, QLineEdit, QSlider)
            for widget in view.findChildren(kind)
            if widget.isVisibleTo(view)
            and widget.isEnabled()
            and widget.focusPolicy() & Qt.FocusPolicy.TabFocus
            and not isinstance(widget.parent(), (QComboBox, QAbstractItemView))
            and widget.window() is story
        }
        assert wanted
        reached = set()
        for _ in range(80):
            reached.add(QApplication.focusWidget())
            press(qtbot, Qt.Key.Key_Tab)
        assert wanted <= reached, [widget.accessibleName() for widget in wanted - reached]
        # What only scrolls shows no keyboard, and follows to what has it.
        assert story.gap_page.result_view not in reached
        for widget in wanted:
            assert widget.accessibleName(), widget
    for kind in (QAbstractButton, QComboBox, QAbstractItemView, QSlider):
        for widget in story.gap_page.setup.findChildren(kind):
            helper = isinstance(widget.parent(), (QComboBox, QAbstractItemView))
            inner = widget.objectName().startswith("qt_") or widget.window() is not story
            if not helper and not inner:
                assert widget.accessibleName(), widget


@pytest.mark.parametrize(
    ("size", "scale", "theme"), [LOOKS[1], *(pytest.param(*one, marks=LONG) for one in LOOKS[::2])]
)
def test_nothing_on_the_page_is_cut_and_nothing_overlaps(story, qtbot, size, scale, theme):
    story.display_style.set_theme(theme)
    story.display_style.set_scale(scale)
    story.resize(*size)
    page = story.gap_page.result_view
    for chapter in page.stages:
        page.go_to_stage(chapter)
        qtbot.wait(30)
        # Never wider than the window: what does not fit goes below.
        assert page.widget().width() <= page.viewport().width()
        check_labels(page.widget())
    numbers = page.stages["show"].numbers
    # Of the style sheet, and of the frame that Qt draws around a cell.
    padding = 2 * page._style.px(6) + 6
    for line in range(len(numbers.row_model.rows)):
        for column in range(6):
            if numbers.isColumnHidden(column):
                continue
            index = numbers.row_model.index(line, column)
            wide = numbers.fontMetrics().horizontalAdvance(numbers.row_model.data(index))
            assert wide + padding <= numbers.columnWidth(column), (
                numbers.row_model.data(index),
                column,
            )
    page.go_to_stage("find")
    QApplication.processEvents()
    check_map(story)


def test_the_maneuver_that_decides_becomes_the_first_test_card(
    story: MainWindow, engine: FakeEngine, qtbot: QtBot
) -> None:
    view = story.gap_page.result_view
    assert not view.cards_button.isVisible()
    assert not story.commands.actions["gap_cards"].isEnabled()
    view.show_result(replace(view.result, discrepancy=make_open(view.result.discrepancy)))
    assert "1 elevator doublet of 3 deg at 98 ft/s" in view.experiment_text.text()
    assert view.cards_button.isVisible()
    qtbot.mouseClick(view.cards_button, Qt.MouseButton.LeftButton)
    qtbot.mouseClick(view.cards_button, Qt.MouseButton.LeftButton)  # The same is there once.
    cards = load_cards(next_flight_path(story.store.path) / "cards.toml").cards
    assert [one.id for one in cards[:2]] == ["X1", "E1"]
    assert cards[0].amplitudes["de"] == pytest.approx(3.0 * DEGREE)
    assert any("X1" in one for one in story.banners.texts())
