"""The first chapter of the review, driven by keys and mouse: maneuvers corrected by hand."""

import json
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from gsapp.flight.catalog import Catalog, search_maneuvers
from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_PROGRAM
from gsapp.flight.writers import write_block
from gsapp.quantities import CHANNELS
from gsapp.session.review import open_reviewed_flight
from tests.flight.maneuver_kit import EVERYTHING, make_flight
from tests.ui.window_kit import ALT, CONTROL, SHIFT, activate, answer_dialog, pixels, press, until
from ui.display_style import DisplayStyle, mix_colors
from ui.main_window import MainWindow
from ui.number_format import MINUS, clock_text
from ui.review.maneuvers_page import GradeDialog, ManeuversPage
from ui.review.maneuvers_table import COLUMN_INDEXES
from ui.review.timeline_painter import (
    TimelineChart,
    TimelineCurve,
    TimelineSpan,
    TimeScale,
    draw_curve_names,
    draw_labels,
)
from ui.review.timeline_widget import VisibleTimeRange
from ui.settings import catalog_path
from ui.strips.chart_annotations import DisplayFormat
from ui.theme import THEMES, contrast

PLAIN = Qt.KeyboardModifier.NoModifier


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("record") / "a.csv"
    return write_block(path, make_flight(EVERYTHING, seconds=125.0, rate=50.0).block, "csv", "us")


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot, record: Path, tmp_path: Path) -> Iterator[MainWindow]:
    """Return the window at the review of one flight of its own, as it was opened by keys."""
    made.display_style.set_theme("daylight")
    made.display_style.set_scale(100)
    made.resize(1280, 800)
    activate(qtbot, made)
    made.show_page("flight")
    qtbot.keyClick(made, Qt.Key.Key_F4)
    qtbot.keyClick(made, Qt.Key.Key_1, ALT)
    page = page_of(made)
    page.opening.open([Path(shutil.copy(record, tmp_path / "a.csv"))])
    until(qtbot, lambda: bool(page.review.flights) and not page.opening.status_text)
    page.set_initial_focus()
    yield made
    until(qtbot, lambda: not page.catalog_writer.busy)
    while page.flights.flight is not None:
        page.flights.remove_flight()
    catalog_path(made.store.current).unlink(missing_ok=True)


def page_of(window: MainWindow) -> ManeuversPage:
    page = window.review_page.step_page
    assert isinstance(page, ManeuversPage)
    return page


def chosen_columns(page: ManeuversPage) -> tuple[float, float]:
    timeline = page.timeline
    plot, style = timeline.regions.plot, page.display_style
    shown = pixels(timeline)
    shade = mix_colors(style.theme.plot, style.theme.traces["blue"], 0.24).rgb() & 0xFFFFFF
    rows = shown[round(plot.top()) + 2 : round(plot.bottom()) - 2]
    columns = np.flatnonzero((rows == shade).sum(axis=0) > 20)
    assert columns.size
    return timeline.scale.time(columns[0]), timeline.scale.time(columns[-1] + 1)


def drag(
    qtbot: QtBot, page: ManeuversPage, start: float, stop: float, *, drop: bool = True
) -> None:
    timeline = page.timeline
    height = round(timeline.regions.plot.top()) + 12
    places = [QPoint(round(timeline.scale.x(time)), height) for time in (start, stop)]
    qtbot.mousePress(timeline, Qt.MouseButton.LeftButton, pos=places[0])
    for share in (0.3, 0.7, 1.0):
        at = QPointF(places[0]) + share * QPointF(places[1] - places[0])
        move(timeline, at.toPoint())
    if drop:
        qtbot.mouseRelease(timeline, Qt.MouseButton.LeftButton, pos=places[1])


def move(widget: QWidget, at: QPoint) -> None:
    left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
    where = QPointF(widget.mapToGlobal(at))
    event = QMouseEvent(QEvent.Type.MouseMove, QPointF(at), where, none, left, PLAIN)
    QApplication.sendEvent(widget, event)
    QApplication.processEvents()


def written(page: ManeuversPage) -> list[str]:
    path = Path(f"{page.flights.flight.path}.events.jsonl")
    return [json.loads(line)["text"] for line in path.read_text().splitlines()]


def test_edges_are_moved_by_keys_and_taken_back(window, qtbot):
    """A tenth of a second and one sample at a time; spans, grade and file agree."""
    page = page_of(window)
    press(qtbot, Qt.Key.Key_PageDown, ALT)
    second = page.flights.flight["2"]
    assert "aileron doublet" in page.details.title.text()
    press(qtbot, Qt.Key.Key_Return)
    press(qtbot, Qt.Key.Key_Right, CONTROL, times=3)
    press(qtbot, Qt.Key.Key_Left, ALT | SHIFT, times=2)
    start, stop = second.t_start + 0.3, second.t_end - 0.04
    moved = page.flights.flight["2"]
    assert (moved.t_start, moved.t_end) == (pytest.approx(start), pytest.approx(stop))
    assert chosen_columns(page) == (pytest.approx(start, abs=0.03), pytest.approx(stop, abs=0.03))
    edges = f"{clock_text(start, decimals=2)} to {clock_text(stop, decimals=2)}"
    assert edges in page.details.times.text()
    assert len(written(page)) == 5
    found = open_reviewed_flight(page.flights.flight.path)["2"]
    assert (found.t_start, found.t_end) == (pytest.approx(start), pytest.approx(stop))
    press(qtbot, Qt.Key.Key_Z, CONTROL, times=5)
    assert page.flights.flight["2"] == second
    assert "Undone: move 2" in page.details.message.text()
    press(qtbot, Qt.Key.Key_Y, CONTROL)
    assert page.flights.flight["2"].t_start == pytest.approx(second.t_start + 0.1)
    # What cannot be is said, and changes nothing.
    press(qtbot, Qt.Key.Key_PageDown, ALT, times=4)
    press(qtbot, Qt.Key.Key_J, CONTROL)
    assert "merging needs two" in page.details.message.text()
    assert len(written(page)) == 11


def test_an_edge_is_dragged_and_its_grade_follows(window, qtbot):
    """While it is held the page says what it would be; Esc leaves it, letting go writes it."""
    page = page_of(window)
    one = page.flights.flight["1"]
    grade = f"Grade {one.grade}"
    assert page.details.grade.text() == grade
    press(qtbot, Qt.Key.Key_Return)
    drag(qtbot, page, one.t_end, one.t_input_end + 0.2, drop=False)
    assert page.details.grade.text() > grade
    assert "hands off" in page.details.reasons.text()
    assert chosen_columns(page)[1] == pytest.approx(one.t_input_end + 0.2, abs=0.05)
    press(qtbot, Qt.Key.Key_Escape)
    assert page.details.grade.text() == grade
    assert page.flights.flight["1"] == one
    drag(qtbot, page, one.t_end, one.t_end - 1.0)
    moved = page.flights.flight["1"]
    assert moved.t_end == pytest.approx(one.t_end - 1.0, abs=0.03)
    assert moved.t_end in page.flights.flight.flight.block.times
    assert written(page) == [f"move 1 to {moved.t_start:.2f} to {moved.t_end:.2f} s"]


def test_values_are_read_at_a_line_that_keys_move(window, qtbot):
    page = page_of(window)
    one = page.flights.flight["1"]
    page.timeline.zoom_to(one.t_start, one.t_end)
    pixels(page.timeline)
    press(qtbot, Qt.Key.Key_C)
    press(qtbot, Qt.Key.Key_Left, times=12)
    time = page.timeline.pointer
    block = page.flights.flight.flight.block
    sample = np.degrees(block["de"][np.argmin(np.abs(block.times - time))])
    said = page.timeline.accessibleDescription()
    assert f"at {clock_text(time, decimals=2)} δe {sample:.1f}".replace("-", MINUS) in said
    muted = int(page.display_style.color("muted").name()[1:], 16)
    lines = np.flatnonzero((pixels(page.timeline) == muted).sum(axis=0) > 100)
    assert lines == pytest.approx([page.timeline.scale.x(time)], abs=1.0)
    press(qtbot, Qt.Key.Key_Escape)
    assert page.timeline.pointer is None


def test_a_stretch_is_added_merged_named_and_noted(window, qtbot):
    """By mouse and keys; the events file and the catalog hold it."""
    page = page_of(window)
    page.timeline.zoom_to(58.0, 80.0)
    drag(qtbot, page, 65.0, 69.0)
    assert page.timeline.marked_segment is not None
    press(qtbot, Qt.Key.Key_N, CONTROL)
    assert page.timeline.marked_segment is None
    added = page.flights.flight["6"]
    assert (added.t_start, added.t_end) == (
        pytest.approx(65.0, abs=0.1),
        pytest.approx(69, abs=0.1),
    )
    assert window.review_page.selection.maneuver == "6"
    # With the next one in time.
    press(qtbot, Qt.Key.Key_J, CONTROL)
    merged = page.flights.flight["6"]
    assert (merged.t_start, merged.inputs) == (added.t_start, ("da",))
    press(qtbot, Qt.Key.Key_B, CONTROL)
    editor = QApplication.focusWidget()
    assert isinstance(editor, QLineEdit)
    qtbot.keyClicks(editor, "calm air")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page.flights.flight["6"].note == "calm air")
    press(qtbot, Qt.Key.Key_N, CONTROL | SHIFT)
    qtbot.keyClicks(QApplication.focusWidget(), "aileron")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: window.review_page.selection.maneuver == "aileron")
    assert page.flights.flight["aileron"].note == "calm air"
    assert written(page)[1:] == ["merge 6, 2", "note on 6", "rename 6 to aileron"]
    kept_in_file = open_reviewed_flight(page.flights.flight.path).maneuvers
    assert [one.id for one in kept_in_file] == ["1", "aileron", "3", "4", "5"]
    until(qtbot, lambda: not page.catalog_writer.busy)
    with Catalog(catalog_path(window.store.current)) as opened:
        kept = {one.maneuver.id: one.maneuver for one in search_maneuvers(opened)}
    assert kept["aileron"].note == "calm air"
    assert len(kept) == 5


def test_a_long_name_is_read_in_the_table(window, qtbot):
    page = page_of(window)
    press(qtbot, Qt.Key.Key_PageDown, ALT)
    press(qtbot, Qt.Key.Key_N, CONTROL | SHIFT)
    qtbot.keyClicks(QApplication.focusWidget(), "gusty second try")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: window.review_page.selection.maneuver == "gusty second try")
    table = page.table
    cell = table.currentIndex().siblingAtColumn(COLUMN_INDEXES["id"])
    until(
        qtbot,
        lambda: table.columnWidth(COLUMN_INDEXES["id"]) >= table.sizeHintForIndex(cell).width(),
    )
    columns = sum(table.columnWidth(place) for place in COLUMN_INDEXES.values())
    assert columns == table.viewport().width()


def test_what_the_estimate_takes_is_chosen_in_the_table(window, qtbot):
    """Space, U and a grade by hand decide; several rows are removed as one change."""
    page = page_of(window)
    page.table.setFocus()
    press(qtbot, Qt.Key.Key_Down)
    press(qtbot, Qt.Key.Key_Space)
    until(qtbot, lambda: [one.id for one in page.review.select_maneuvers()] == ["1", "3", "4", "5"])
    assert not page.bar.use.isChecked()
    press(qtbot, Qt.Key.Key_Z, CONTROL)
    assert len(page.review.select_maneuvers()) == 5
    press(qtbot, Qt.Key.Key_U)
    until(qtbot, lambda: len(page.review.select_maneuvers()) == 4)
    press(qtbot, Qt.Key.Key_U)
    until(qtbot, lambda: len(page.review.select_maneuvers()) == 5)

    def grade(dialog: GradeDialog) -> None:
        dialog.choice.setCurrentIndex(3)
        qtbot.keyClicks(dialog.reason, "a gust")
        dialog.accept()

    answer_dialog(GradeDialog, grade)
    press(qtbot, Qt.Key.Key_G, CONTROL | SHIFT)
    graded = page.flights.flight["2"]
    assert (graded.grade, graded.reasons) == ("D", ("a gust",))
    assert [one.id for one in page.review.select_maneuvers()] == ["1", "3", "4", "5"]
    assert "manual" in page.details.grade.text()
    cell = page.table.currentIndex().siblingAtColumn(COLUMN_INDEXES["grade"])
    assert cell.data() == "D (manual)"
    assert page.table.sizeHintForIndex(cell).width() <= page.table.columnWidth(cell.column())
    window.activateWindow()
    page.table.setFocus()
    until(qtbot, lambda: QApplication.focusWidget() is page.table)
    press(qtbot, Qt.Key.Key_Down, SHIFT)
    assert page.table.selected_ids == ("2", "3")
    press(qtbot, Qt.Key.Key_Delete)
    assert [one.id for one in page.flights.flight.maneuvers] == ["1", "4", "5"]
    press(qtbot, Qt.Key.Key_Z, CONTROL, times=2)
    assert len(page.review.select_maneuvers()) == 5
    # Sorted by what it says, not by its letters: 96 s before 107 s.
    page.table.sortByColumn(3, Qt.SortOrder.AscendingOrder)
    order = [page.table.model().index(row, 1).data() for row in range(5)]
    assert order == ["1", "2", "3", "4", "5"]


def test_a_grade_goes_to_the_maneuver_that_was_asked_about(window, qtbot, tmp_path):
    page = page_of(window)
    window.review_page.selection.select_maneuver("2")

    def grade(dialog: GradeDialog) -> None:
        open_reviewed_flight(tmp_path / "a.csv").remove("2")
        until(qtbot, lambda: window.review_page.selection.maneuver != "2")
        dialog.choice.setCurrentIndex(3)
        dialog.accept()

    answer_dialog(GradeDialog, grade)
    press(qtbot, Qt.Key.Key_G, CONTROL | SHIFT)
    assert all(one.graded_by == GRADED_BY_PROGRAM for one in page.flights.flight.maneuvers)
    assert "'2'" in page.details.message.text()


def test_a_note_is_typed_on_while_another_flight_opens(window, qtbot, record, tmp_path):
    page = page_of(window)
    window.review_page.selection.select_maneuver("2")
    press(qtbot, Qt.Key.Key_B, CONTROL)
    qtbot.keyClicks(QApplication.focusWidget(), "gut")
    press(qtbot, Qt.Key.Key_Left)
    open_reviewed_flight(tmp_path / "a.csv").move("2", 35.0, 41.0)
    until(qtbot, lambda: page.flights.flight["2"].t_start == pytest.approx(35.0, abs=0.05))
    qtbot.keyClicks(QApplication.focusWidget(), "s")
    page.opening.open([Path(shutil.copy(record, tmp_path / "b.csv"))])
    until(qtbot, lambda: len(page.review.flights) == 2 and not page.opening.status_text)
    assert window.review_page.selection.maneuver == "1:2"
    qtbot.keyClicks(QApplication.focusWidget(), "t, not ca")
    press(qtbot, Qt.Key.Key_Return)
    until(qtbot, lambda: page.flights.flight["2"].note == "gust, not cat")


def test_two_flights_and_another_window(window, qtbot, record, tmp_path, monkeypatch):
    """A maneuver chosen anywhere brings its flight; changes made elsewhere are followed."""
    page = page_of(window)
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *_: ([str(tmp_path / "b.csv")], ""))
    shutil.copy(record, tmp_path / "b.csv")
    press(qtbot, Qt.Key.Key_F, CONTROL | ALT)
    until(qtbot, lambda: len(page.review.flights) == 2 and not page.opening.status_text)
    # The one that was looked at is called otherwise now.
    assert window.review_page.selection.maneuver == "1:1"
    window.review_page.selection.select_maneuver("2:4")
    assert page.flights.flight.name == "b"
    assert page.timeline.accessibleDescription().startswith("maneuver 4")
    # Everything on the page calls it so, but what is typed is the name alone.
    assert page.details.title.text().startswith("Maneuver 2:4, ")
    cell = page.table.currentIndex().siblingAtColumn(COLUMN_INDEXES["id"])
    assert cell.data() == "2:4"
    assert cell.data(Qt.ItemDataRole.EditRole) == "4"
    other = open_reviewed_flight(tmp_path / "b.csv")
    other.remove("4")
    until(qtbot, lambda: len(page.flights.flight.maneuvers) == 4)
    # Its neighbor is looked at in its place.
    assert window.review_page.selection.maneuver in ("2:3", "2:5")
    assert len(window.store.current.review_flights) == 2
    monkeypatch.setattr(
        QFileDialog, "getOpenFileNames", lambda *_: ([str(tmp_path / "none.csv")], "")
    )
    press(qtbot, Qt.Key.Key_F, CONTROL | ALT)
    until(qtbot, lambda: "none.csv is not opened" in page.details.message.text())


def test_the_time_line_in_another_theme_and_size(window, qtbot):
    page = page_of(window)
    theme = "high-contrast"
    window.display_style.set_theme(theme)
    window.display_style.set_scale(200)
    QApplication.processEvents()
    one = page.flights.flight["3"]
    window.review_page.selection.select_maneuver("3")
    page.zoom()
    assert chosen_columns(page) == (
        pytest.approx(one.t_start, abs=0.05), pytest.approx(one.t_end, abs=0.05),
    )  # fmt: skip
    colors = THEMES[theme]
    shade = mix_colors(colors.plot, colors.traces["blue"], 0.24).name()
    assert contrast(colors.selection, shade) > 3.0
    shown = pixels(page.timeline)
    x = round(page.timeline.scale.x(one.t_start))
    plot = page.timeline.regions.plot
    edge = shown[round(plot.top()) + 4 : round(plot.bottom()) - 4, x]
    assert (edge == int(colors.selection[1:], 16)).mean() > 0.8


@settings(max_examples=100, deadline=None)
@given(
    actions=st.lists(
        st.tuples(st.sampled_from(["zoom", "pan", "show", "bring"]), st.floats(-30.0, 130.0)),
        max_size=12,
    )
)
def test_the_view_never_leaves_the_flight(actions):
    view = VisibleTimeRange(10.0, 110.0)
    for action, size in actions:
        if action == "zoom":
            view.zoom(0.5 + abs(size) / 50.0, size)
        elif action == "pan":
            view.pan(size)
        elif action == "show":
            view.show(size, size + 7.0)
        else:
            low = min(max(size, 10.0), 104.0)
            view.scroll_to(low, low + 6.0)
            assert view.start <= low + 1e-9
            assert view.stop >= low + 6.0 - 1e-9
        assert view.start >= 10.0 - 1e-9
        assert view.stop <= 110.0 + 1e-9
        assert view.seconds >= 0.5 - 1e-9


def test_names_hide_no_more_of_the_lines_than_their_letters_need(qapp: QApplication) -> None:
    """At large sizes of text a ground of their own would hide half a minute."""
    style = DisplayStyle(scale=200)
    unit = CHANNELS["alpha"].display_unit("US")
    times = np.arange(3.0)
    lines = tuple(
        TimelineCurve(
            channel=name, title=name, color="blue", times=times, values=times, is_min_max=False,
            display=DisplayFormat.for_channel(CHANNELS[name], "US"),
        )
        for name in ("alpha", "beta")
    )  # fmt: skip
    chart = TimelineChart(lines=lines, unit=unit, low=0.0, high=2.0)
    image = QImage(400, 80, QImage.Format.Format_RGB32)
    image.fill(QColor("#ff00ff"))
    painter = QPainter(image)
    draw_curve_names(painter, style, chart, QRectF(0, 0, 400, 80), ("alpha", "beta"))
    painter.end()
    shown = np.frombuffer(image.constBits(), dtype=np.uint32).reshape(80, 400)
    changed = shown != 0xFFFF00FF
    rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    covered = changed[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    assert 0.1 < covered.mean() < 0.75


@pytest.mark.parametrize("long", ["short one, gusty A", "one that is longer than the flight A"])
def test_the_chosen_maneuver_is_named_whatever_the_room(qapp: QApplication, long: str) -> None:
    style = DisplayStyle()
    spans = tuple(
        TimelineSpan(id=name, start=12.0 * index, stop=12.0 * index + 5.0, label=label, grade="A")
        for index, (name, label) in enumerate({"1": "1 A", long[:-2]: long, "3": "3 A"}.items())
    )
    lane = QRectF(0, 0, 150, 20)
    scale = TimeScale(start=0.0, stop=36.0, left=0.0, right=150.0)

    def inked(chosen: str, shown: Sequence[TimelineSpan]) -> np.ndarray:
        image = QImage(150, 20, QImage.Format.Format_RGB32)
        image.fill(QColor("#ffffff"))
        painter = QPainter(image)
        draw_labels(painter, style, shown, scale, lane, chosen)
        painter.end()
        pixels = np.frombuffer(image.constBits(), dtype=np.uint32).reshape(20, 150)
        return np.flatnonzero((pixels != 0xFFFFFFFF).any(axis=0))

    first, middle, last = spans
    alone = inked(middle.id, (middle,))
    assert np.ptp(alone) > 60
    assert set(alone) <= set(inked(middle.id, spans))
    # Without it the others stand as if it had no name.
    assert set(inked("1", spans)) == set(inked("1", (first, last)))
