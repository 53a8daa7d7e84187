"""The page Figures: points lie where their values are, are chosen by mouse and keys, and grayed."""

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QGuiApplication, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMainWindow
from pytestqt.qtbot import QtBot

from gsapp.foundation import FlightError
from gsapp.identification import equation_error
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.summary.method_comparison import compare_methods
from gsapp.quantities import clock_text
from gsapp.report.fit_diagnostics import method_comparison_table
from gsapp.report.ftr_histories import FlightEstimateHistory
from gsapp.report.palette import PRINT_PALETTE
from tests.report.campaign_kit import WILD, gusty, outcome
from tests.ui.window_kit import FIGURE_MENU, until
from ui.background_job import JobCanceledError
from ui.commands import CommandSet
from ui.display_style import DisplayStyle
from ui.review.figure_data import FigureData, comparison_run_option, find_result
from ui.review.figure_geometry import (
    ManeuverPoint,
    Subplot,
    ViewRange,
    is_usable_view,
    next_point,
    pan_view,
    zoom_view,
)
from ui.review.figure_kinds import FIGURE_KINDS
from ui.review.figure_renderer import FigureSize, window_palette
from ui.review.figures_page import FiguresPage
from ui.review.review_jobs import FtrHistoryJob, ReviewJob
from ui.review.review_steps import ReviewContext, ReviewSelection
from ui.settings import SettingsStore
from ui.shortcut_filter import ShortcutOverrideFilter
from ui.theme import THEMES, contrast


@dataclass
class Asked:
    jobs: list[tuple[ReviewJob, Callable[[object], None], Any]] = field(default_factory=list)

    def __call__(
        self, job: ReviewJob, done: Callable[[object], None], *, failed: Any = None
    ) -> None:
        self.jobs.append((job, done, failed))


@dataclass
class Bench:
    """The page in a small window of its own."""

    window: QMainWindow
    page: FiguresPage
    style: DisplayStyle
    selection: ReviewSelection
    asked: Asked
    commands: CommandSet
    qtbot: QtBot

    def settle(self) -> None:
        until(self.qtbot, lambda: self.page.view.is_up_to_date, 20_000)

    def key(self, key: Qt.Key, modifiers: Qt.KeyboardModifier | None = None) -> None:
        QTest.keyClick(QApplication.focusWidget(), key, modifiers or Qt.KeyboardModifier.NoModifier)

    def show(self, group: str, over: str = "number") -> None:
        self.page.show_kind("values")
        self.page.frame.option_chosen.emit("group", group)
        self.page.frame.option_chosen.emit("over", over)
        self.settle()

    def pane(self, name: str) -> Subplot:
        drawing = self.page.view.rendered_figure
        return next(one for one in drawing.subplots if one.name == f"derivative:{name}")

    def place(self, name: str, x: float, y: float) -> QPoint:
        pane = self.pane(name)
        across = (x - pane.view.x[0]) / (pane.view.x[1] - pane.view.x[0])
        up = (y - pane.view.y[0]) / (pane.view.y[1] - pane.view.y[0])
        return QPoint(
            round(pane.left + across * (pane.right - pane.left)),
            round(pane.bottom - up * (pane.bottom - pane.top)),
        )

    def color(self, at: QPoint) -> QColor:
        drawing = self.page.view.rendered_figure
        ratio = drawing.image.devicePixelRatio()
        return drawing.image.pixelColor(round(at.x() * ratio), round(at.y() * ratio))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[tuple[Any, ...]]:
    """Return the page in a window, made once."""
    window = QMainWindow()
    style, selection, asked = DisplayStyle(), ReviewSelection(window), Asked()
    commands = CommandSet(window)
    store = SettingsStore(tmp_path_factory.mktemp("settings") / "window.toml")
    page = FiguresPage(
        ReviewContext(
            actions=commands.actions, style=style, store=store, selection=selection,
            begin_job=asked, report_error=print,
        )
    )  # fmt: skip
    for name, act in page.handlers.items():
        commands.actions[name].triggered.connect(lambda _checked=False, act=act: act())
    page.changed.connect(lambda: commands.update_enabled(["review", *page.present]))
    keeper = ShortcutOverrideFilter(window)
    keeper.install()
    window.setCentralWidget(page)
    window.resize(900, 540)
    window.show()
    yield window, page, style, selection, asked, commands
    keeper.remove()
    window.close()
    window.deleteLater()


@pytest.fixture
def bench(made: tuple[Any, ...], qtbot: QtBot) -> Bench:
    """Return the page as it is when a run has just ended."""
    bench = Bench(*made, qtbot)
    bench.style.set_theme("daylight")
    bench.style.set_scale(100)
    bench.style.set_units("US")
    bench.asked.jobs.clear()
    bench.selection.select_maneuver("")
    bench.selection.select_derivative("")
    material = bench.page._data
    if material is None or material.outcome is not outcome():
        bench.page.show_outcome(None)
        bench.page.show_outcome(outcome())
    # What stands already is not drawn again.
    if (
        bench.page.kind.id != "values"
        or bench.page.view.canvas.views
        or (bench.page._chosen.get("group") != "Cm")
    ):
        bench.show("Cm")
    bench.page.view.canvas.current = None
    bench.settle()
    bench.window.activateWindow()
    bench.page.view.canvas.setFocus()
    return bench


def point(name: str, maneuver: str) -> Any:
    return next(
        one for one in outcome().summary.derivatives[name].points if one.maneuver == maneuver
    )


def near(one: QColor, other: str, reach: int = 24) -> bool:
    wanted = QColor(other)
    pairs = zip(one.getRgb()[:3], wanted.getRgb()[:3], strict=True)
    return max(abs(a - b) for a, b in pairs) <= reach


def test_equation_error_shows_coefficients_and_says_why_it_has_no_residuals() -> None:
    done = outcome()
    first = done.result.results[0]
    fitted = replace(first, estimate=equation_error.estimate([first.maneuver], "lon"))
    changed = replace(done, result=replace(done.result, results=(fitted,)))
    material = FigureData(outcome=changed, others=(done,), maneuver=first.maneuver.id)
    kinds, room = {one.id: one for one in FIGURE_KINDS}, FigureSize(width=7.0, height=4.0)
    picture = kinds["fit"].build(material, PRINT_PALETTE, room)
    assert not isinstance(picture, str)
    assert "coefficients" in picture.caption
    assert comparison_run_option(material).choices == (("", "no other run"),)
    assert len(comparison_run_option(replace(material, outcome=done)).choices) == 2
    said = kinds["residuals"].build(material, PRINT_PALETTE, room)
    assert isinstance(said, str)
    assert said.startswith("Equation error")
    still = equation_error.estimate([first.maneuver], "lon", free=())
    nothing = replace(first, estimate=replace(still, histories=(), free=()))
    empty = replace(done, result=replace(done.result, results=(nothing,)))
    said = kinds["fit"].build(replace(material, outcome=empty), PRINT_PALETTE, room)
    assert f"maneuver {first.maneuver.id}" in said


def test_a_point_lies_at_its_value_and_a_click_on_it_chooses_its_maneuver(bench: Bench) -> None:
    traces = THEMES["daylight"].traces
    for maneuver, color in (("1:M3", "blue"), ("2:M6", "rust")):
        one = point("Cm_q", maneuver)
        at = bench.place("Cm_q", one.number, one.value)
        assert near(bench.color(at), traces[color])
        canvas = bench.page.view.canvas
        QTest.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=at)
        assert bench.selection.maneuver == maneuver
        assert bench.selection.derivative == "Cm_q"
        assert maneuver in bench.page.frame.detail.text()
        text = canvas.text_at(QPointF(at))
        assert f"Maneuver {maneuver}" in text
        assert "ft/s" in text
    empty = bench.place("Cm_q", 2.5, point("Cm_q", "1:M3").value)
    assert "Maneuver" not in bench.page.view.canvas.text_at(QPointF(empty))


def test_a_choice_made_elsewhere_is_ringed_without_drawing_anew(bench: Bench) -> None:
    canvas = bench.page.view.canvas
    before = canvas.rendered_figure
    bench.selection.select_maneuver("1:M1")
    assert canvas.rendered_figure is before
    one = point("Cm_de", "1:M1")
    at = bench.place("Cm_de", one.number, one.value)
    shown = canvas.grab().toImage()
    ratio = shown.devicePixelRatio()
    ring = [
        shown.pixelColor(round((at.x() + r) * ratio), round(at.y() * ratio)) for r in range(-9, -4)
    ]
    assert any(near(color, THEMES["daylight"].selection) for color in ring)
    assert bench.page.present == ("review_figure", "review_picture", "review_point")


def test_a_maneuver_is_left_out_by_a_key_grayed_and_taken_back(bench: Bench) -> None:
    told: list[Any] = []
    bench.page.exclusion_changed.connect(told.append)
    bench.selection.select_maneuver("1:M2")
    bench.commands.actions["review_exclude"].trigger()
    bench.settle()
    assert told[-1].summary.excluded_maneuvers == {"1:M2"}
    assert bench.page.state.text == "trial, 1 excluded"
    one = point("Cm_alpha", "1:M2")
    at = bench.place("Cm_alpha", one.number, one.value)
    assert near(bench.color(at), THEMES["daylight"].previous)
    assert "manually" in bench.page.view.canvas.text_at(QPointF(at))
    assert bench.page.undo_history.undoText() == "exclude 1:M2"
    # The place hands the outcome back to all pages; that is no new run.
    bench.page.show_outcome(told[-1])
    bench.page.undo()
    assert told[-1].summary.excluded_maneuvers == frozenset()
    before = outcome().summary.derivatives["Cm_alpha"].value
    assert told[-1].summary.derivatives["Cm_alpha"].value == before
    bench.page.redo()
    assert told[-1].summary.excluded_maneuvers == {"1:M2"}
    bench.page.undo()
    bench.settle()
    at = bench.place("Cm_alpha", one.number, one.value)
    assert near(bench.color(at), THEMES["daylight"].traces["blue"])
    bench.page.exclusion_changed.disconnect(told.append)


def test_the_wild_maneuver_is_gray_in_sight_and_says_why(bench: Bench) -> None:
    drawing = bench.page.view.rendered_figure
    pane = bench.pane("Cm_de")
    spot = next(
        one for one in drawing.points if (one.subplot_index, one.maneuver) == (pane.index, WILD)
    )
    at = QPoint(round(spot.x), round(spot.y))
    around = [bench.color(at + QPoint(x, y)) for x in (-2, -1, 0, 1, 2) for y in (-2, -1, 0, 1, 2)]
    assert any(near(one, THEMES["daylight"].previous) for one in around)
    text = bench.page.view.canvas.text_at(QPointF(spot.x, spot.y))
    assert "Excluded" in text
    assert "sigma" in text


def test_arrows_walk_over_all_points_and_enter_opens_the_fit(bench: Bench) -> None:
    seen = []
    for _ in range(7):
        bench.key(Qt.Key.Key_Right)
        seen.append(bench.selection.maneuver)
    assert seen == ["1:M1", "1:M2", "1:M3", "1:M4", WILD, "2:M6", "2:M6"]
    first = bench.selection.derivative
    bench.key(Qt.Key.Key_Down)
    assert bench.selection.derivative != first
    assert bench.selection.maneuver == "2:M6"
    bench.key(Qt.Key.Key_Return)
    bench.settle()
    assert bench.page.kind.id == "fit"
    assert "2:M6" in bench.page.frame.caption.text()
    bench.commands.actions["review_figure_previous_maneuver"].trigger()
    bench.settle()
    assert WILD in bench.page.frame.caption.text()
    bench.commands.actions["review_previous_figure"].trigger()
    assert bench.page.kind.id == "values"


def test_every_method_stands_below_the_fit(bench: Bench) -> None:
    page, table = bench.page, bench.page.frame.table
    page.show_outcome(gusty())
    page.open_fit("M1")
    bench.settle()
    assert table.lines is not None
    rows = {one.cells[0]: one.cells for one in table.lines.row_model.rows}
    (value,) = [one for one in compare_methods(gusty().result.results[0]) if one.name == "Cm_q"]
    shown = method_comparison_table(gusty().result.results[0])
    assert shown is not None
    cell = rows["Cm_q"][shown.columns.index("equation error")]
    assert float(cell) == pytest.approx(value.values["ee"][0], abs=0.01)
    assert table.isVisible()


def test_space_shows_a_chart_large_and_the_kind_again(bench: Bench) -> None:
    bench.key(Qt.Key.Key_Right)
    name = bench.selection.derivative
    bench.key(Qt.Key.Key_Space)
    bench.settle()
    drawing = bench.page.view.rendered_figure
    assert [one.name for one in drawing.subplots] == [f"derivative:{name}"]
    bench.key(Qt.Key.Key_Space)
    bench.settle()
    assert len(bench.page.view.canvas.subplots) == 3


def test_zoom_keeps_the_chosen_point_in_place_and_home_shows_all(bench: Bench) -> None:
    """Plus narrows both axes about the point, at once in a stand-in and then drawn; Home undoes."""
    canvas = bench.page.view.canvas
    bench.key(Qt.Key.Key_Right)
    bench.key(Qt.Key.Key_Right)
    pane = canvas.subplot_at(canvas.subplot_index)
    spot = canvas.current
    bench.key(Qt.Key.Key_Plus)
    (standing,) = [
        one
        for one in canvas.visible_points()
        if (one.subplot_index, one.maneuver) == (spot.subplot_index, "1:M2")
    ]
    assert (standing.x, standing.y) == pytest.approx((spot.x, spot.y))
    bench.settle()
    zoomed_pane = canvas.subplot_at(pane.index)
    for drawn, before in ((zoomed_pane.view.x, pane.view.x), (zoomed_pane.view.y, pane.view.y)):
        assert drawn[1] - drawn[0] == pytest.approx(0.8 * (before[1] - before[0]))
    bench.key(Qt.Key.Key_Home)
    bench.settle()
    after = canvas.subplot_at(pane.index)
    assert after.view.x == pytest.approx(pane.view.x)


def drag(canvas: Any, start: QPoint, way: QPoint, *, shift: bool = False) -> None:
    held = Qt.KeyboardModifier.ShiftModifier if shift else Qt.KeyboardModifier.NoModifier
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, held, start)
    QTest.mouseMove(canvas, start + way / 3)
    QTest.mouseMove(canvas, start + way)
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, held, start + way)


def test_a_drag_with_shift_moves_the_times_of_all_responses_together(bench: Bench) -> None:
    bench.page.open_fit("1:M1")
    bench.settle()
    canvas = bench.page.view.canvas
    pane = canvas.subplots[0]
    drag(canvas, QPoint(round(pane.left + 200), round(pane.top + 20)), QPoint(-100, 8), shift=True)
    bench.settle()
    step = 100 / (pane.right - pane.left) * (pane.view.x[1] - pane.view.x[0])
    for former, now in zip([pane] * len(canvas.subplots), canvas.subplots, strict=True):
        assert now.view.x[0] == pytest.approx(former.view.x[0] + step)
    assert canvas.subplots[0].view.y == pytest.approx(pane.view.y)


def test_a_drag_zooms_to_its_rectangle_and_a_double_click_shows_everything(bench: Bench) -> None:
    bench.page.open_fit("1:M1")
    bench.settle()
    canvas = bench.page.view.canvas
    whole = [pane.view for pane in canvas.subplots]
    pane = canvas.subplots[1]
    wide, high = pane.right - pane.left, pane.bottom - pane.top
    start = QPoint(round(pane.left + 0.25 * wide), round(pane.top + 0.2 * high))
    drag(canvas, start, QPoint(round(0.5 * wide), round(0.4 * high)))
    bench.settle()
    (low, high_x), (bottom, top) = pane.view.x, pane.view.y
    span, tall = high_x - low, top - bottom
    for now in canvas.subplots:
        assert now.view.x == pytest.approx((low + 0.25 * span, low + 0.75 * span), abs=0.01 * span)
    expected = (bottom + 0.4 * tall, bottom + 0.8 * tall)
    assert canvas.subplots[1].view.y == pytest.approx(expected, abs=0.05 * tall)
    assert canvas.subplots[0].view.y == pytest.approx(whole[0].y)
    QTest.mouseDClick(canvas, Qt.MouseButton.LeftButton, pos=start)
    bench.settle()
    for now, former in zip(canvas.subplots, whole, strict=True):
        assert now.view.x == pytest.approx(former.x)
        assert now.view.y == pytest.approx(former.y)
    drag(canvas, start, QPoint(round(0.5 * wide), 3))
    bench.settle()
    assert canvas.subplots[1].view.y == pytest.approx(pane.view.y)
    assert canvas.subplots[0].view.x[0] > low


def test_no_rectangle_is_painted_while_the_pointer_is_outside(bench: Bench) -> None:
    canvas = bench.page.view.canvas
    start = QPoint(round(canvas.subplots[0].left + 20), round(canvas.subplots[0].top + 20))
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=start)
    QTest.mouseMove(canvas, start + QPoint(60, 40))
    QApplication.sendEvent(canvas, QEvent(QEvent.Type.Leave))
    with bench.qtbot.capture_exceptions() as raised:
        canvas.grab()
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=start)
    assert raised == []


def test_the_cursor_reads_the_curves_at_its_time_in_the_units_chosen(bench: Bench) -> None:
    bench.page.open_fit("1:M1")
    bench.settle()
    canvas = bench.page.view.canvas
    (history,) = find_result(outcome(), "1:M1").estimate.histories
    pane = next(one for one in canvas.subplots if one.y_title.startswith("q"))
    x = (pane.left + pane.right) / 2
    words = canvas.text_at(QPointF(x, pane.top + 5)).splitlines()
    time = (pane.view.x[0] + pane.view.x[1]) / 2
    assert words[0] == clock_text(time, decimals=2)
    near_sample = int(np.abs(history.times - time).argmin())
    for line, values in zip(words[1:], (history.measured, history.computed), strict=True):
        q = np.degrees(values[near_sample, history.channels.index("q")])
        kind = "measured" if values is history.measured else "computed"
        assert line == f"q {kind} {q:.4g} °/s"
    QTest.mouseMove(canvas, QPoint(round(x), round(pane.top + 30)))
    seen = canvas.grab().toImage()
    canvas.pointer = None
    assert seen != canvas.grab().toImage()


def test_the_wheel_zooms_and_with_shift_the_page_scrolls(bench: Bench) -> None:
    bench.page.open_fit("1:M1")
    bench.settle()
    canvas = bench.page.view.canvas
    pane = canvas.subplots[0]
    at = QPointF(pane.left + 0.3 * (pane.right - pane.left), pane.top + 10)
    for held in (Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.NoModifier):
        event = QWheelEvent(
            at, canvas.mapToGlobal(at), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton, held,
            Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(canvas, event)
        bench.settle()
        zooms = held == Qt.KeyboardModifier.NoModifier
        span, former = (one.view.x[1] - one.view.x[0] for one in (canvas.subplots[0], pane))
        assert span == pytest.approx(former * (0.8 if zooms else 1.0))
    still = pane.view.x[0] + 0.3 * (pane.view.x[1] - pane.view.x[0])
    now = canvas.subplots[0].view.x
    assert now[0] + 0.3 * (now[1] - now[0]) == pytest.approx(still)
    next(one for one in canvas.actions() if one.text() == "Reset zoom").trigger()
    bench.settle()
    assert canvas.subplots[0].view.x == pytest.approx(pane.view.x)


def test_words_below_a_figure_are_about_a_point_that_it_draws(bench: Bench) -> None:
    bench.selection.select_maneuver("1:M1")
    assert "Maneuver 1:M1" in bench.page.frame.detail.text()
    without = replace(
        outcome(),
        summary=replace(
            outcome().summary,
            derivatives={
                name: replace(
                    one, points=tuple(two for two in one.points if two.maneuver != "1:M1"),
                )
                for name, one in outcome().summary.derivatives.items()
            },
        ),
    )  # fmt: skip
    bench.page.show_outcome(without)
    bench.settle()
    assert all(spot.maneuver != "1:M1" for spot in bench.page.view.canvas.points)
    assert bench.page.frame.detail.text() == ""


@pytest.mark.parametrize(("theme", "scale"), [("dark", 200), ("high-contrast", 100)])
def test_figures_take_theme_and_scale_of_the_window(bench: Bench, theme: str, scale: int) -> None:
    """Background and ink are the theme's; at 200 % margins, and so letters, are twice as large."""
    left = bench.page.view.canvas.subplots[0].left
    bench.style.set_theme(theme)
    bench.style.set_scale(scale)
    bench.settle()
    drawing = bench.page.view.rendered_figure
    assert drawing.subplots[0].left == pytest.approx(scale / 100 * left, abs=2)
    assert drawing.image.pixelColor(2, drawing.image.height() - 3) == QColor(THEMES[theme].plot)
    image = drawing.image
    ink = QColor(THEMES[theme].text).rgb()
    titles = round(drawing.subplots[0].top)
    assert any(image.pixel(x, y) == ink for y in range(titles) for x in range(40, 400))


@pytest.mark.parametrize("theme", ["daylight", "high-contrast"])
def test_words_in_figures_stand_out_seven_to_one(theme: str) -> None:
    palette = window_palette(THEMES[theme])
    for color in (palette.ink, palette.secondary_ink):
        assert contrast(color, palette.background) >= 7.0
    for color in palette.traces.values():
        assert contrast(color, palette.background) >= 3.0


def test_drawing_is_done_beside_the_window_and_stale_orders_are_dropped(bench: Bench) -> None:
    made: list[tuple[str, str]] = []
    shown: list[object] = []
    bench.page.view.drawn.connect(lambda drawing: shown.append(drawing.message))

    def order(words: str) -> Callable[..., str]:
        def make(_palette: object, _room: object) -> str:
            made.append((words, threading.current_thread().name))
            return words

        return make

    for words in ("one", "two", "three"):
        bench.page.view.show_figure(order(words))
        bench.page.view._submit()
    bench.settle()
    assert shown[-1] == "three"
    assert "one" not in shown[:-1] or made[0][0] == "one"
    assert {thread for _, thread in made} == {"figures"}
    assert shown.count("three") >= 1
    assert "two" not in shown


_LEAVES = """
import time
from PySide6.QtCore import QCoreApplication
from gsapp.report.palette import PRINT_PALETTE
from gsapp.report.document import DocumentFigure
from ui.review.figure_renderer import FigureRenderer, FigureSize, RenderRequest

def draw(container):
    print("drawing", flush=True)
    container.subplots().plot(range(50))
    time.sleep(0.5)
    print("drawn", flush=True)

app = QCoreApplication([])
drawer = FigureRenderer()
picture = DocumentFigure(name="it", caption="", height=4.0, draw=draw)
room = FigureSize(width=6.0, height=4.0)
drawer.submit(
    RenderRequest(
        request_id=1, build=lambda *_: picture, palette=lambda: PRINT_PALETTE, room=room, dpi=100.0
    )
)
time.sleep(0.15)
"""


def test_leaving_while_a_figure_is_drawn_ends_in_order() -> None:
    """A program that ends at once waits for the figure that it began, and is not torn down."""
    done = subprocess.run(
        [sys.executable, "-c", _LEAVES], capture_output=True, text=True, check=False, timeout=240
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == ["drawing", "drawn"]


def test_histories_are_heard_once_and_a_late_answer_is_dropped(bench: Bench) -> None:
    """One job for the flights; stopped, it is asked again; one for another run is not shown."""
    page = bench.page
    # Other flights than in the tests before, so that nothing is known of them.
    request = outcome().request.with_changes(flights=(Path("X"), Path("Y")))
    page.show_outcome(replace(outcome(), request=request, result=_same_result()))
    page.show_kind("online")
    page.show_kind("values")
    page.show_kind("online")
    bench.settle()
    (asked,) = bench.asked.jobs
    assert isinstance(asked[0], FtrHistoryJob)
    drawing = page.view.rendered_figure
    assert "FTR" in drawing.message
    asked[2](JobCanceledError())
    bench.settle()
    assert "stopped" in page.view.canvas.rendered_figure.message  # type: ignore[union-attr]
    page.show_kind("online")
    late, (_, done, _) = bench.asked.jobs
    late[1]((FlightEstimateHistory(flight="nowhere"),))
    times = np.linspace(0.0, 60.0, 50)
    history = EstimateHistory(
        name="Cm_alpha", times=times, values=np.full(50, -0.33), stds=np.full(50, 0.01),
        signal_to_noise=np.full(50, 9.0),
    )  # fmt: skip
    done((FlightEstimateHistory(flight="A", histories={"Cm_alpha": history}),))
    bench.settle()
    assert {spot.maneuver for spot in page.view.canvas.points} == {f"1:M{k}" for k in (1, 2, 3, 4)}
    page.show_outcome(outcome())
    count = len(bench.asked.jobs)
    done((FlightEstimateHistory(flight="nowhere"),))
    assert page._computations.ftr_histories is None
    assert len(bench.asked.jobs) >= count


def _same_result() -> Any:
    return replace(outcome().result)


def test_histories_are_those_of_the_flight_that_was_looked_at_before_the_run(bench: Bench) -> None:
    done = outcome()
    last = done.result.results[-1].maneuver
    assert last.flight != done.result.results[0].maneuver.flight
    bench.page.show_outcome(None)
    bench.selection.select_maneuver(last.id)
    bench.page.show_outcome(done)
    bench.page.show_kind("online")
    bench.asked.jobs[-1][1](
        tuple(
            FlightEstimateHistory(flight=name)
            for name in {one.maneuver.flight: 0 for one in done.result.results}
        )
    )
    assert bench.page.frame.choices["flight"].current_key == last.flight
    bench.settle()


def test_copy_and_save_give_the_figure_and_its_numbers(bench: Bench, tmp_path: Path) -> None:
    assert [one.text() for one in bench.page.view.canvas.actions()][:4] == FIGURE_MENU
    clipboard = QGuiApplication.clipboard()
    with bench.qtbot.waitSignal(bench.page.menu.message_posted):
        bench.commands.actions["review_figure_copy"].trigger()
    assert clipboard.mimeData().hasImage()
    with bench.qtbot.waitSignal(bench.page.menu.message_posted):
        bench.commands.actions["review_figure_copy_numbers"].trigger()
    assert clipboard.text().splitlines()[0].startswith("derivative\tmaneuver")
    with bench.qtbot.waitSignal(bench.page.menu.message_posted):
        bench.page.menu.save(tmp_path / "figure.csv")
    rows = (tmp_path / "figure.csv").read_text(encoding="utf-8").splitlines()
    names = ("Cm_alpha", "Cm_q", "Cm_de")
    assert len(rows) == 1 + sum(len(outcome().summary.derivatives[n].points) for n in names)


def test_without_a_run_there_is_no_figure_to_copy(bench: Bench) -> None:
    bench.page.show_outcome(None)
    with pytest.raises(FlightError):
        bench.page._content(".png")()


SPOTS = st.lists(
    st.builds(
        ManeuverPoint,
        subplot_index=st.integers(0, 3),
        maneuver=st.integers(0, 9).map(str),
        x=st.floats(0, 500),
        y=st.floats(0, 300),
    ),
    min_size=1,
    unique_by=lambda one: (one.subplot_index, one.maneuver),
)


@given(
    low=st.floats(-100, 100), span=st.floats(1e-3, 100),
    steps=st.lists(st.sampled_from(["in", "out", "left", "up"]), max_size=60),
)  # fmt: skip
@settings(max_examples=40)
def test_whatever_is_zoomed_and_moved_some_of_the_whole_stays_in_sight(
    low: float, span: float, steps: list[str]
) -> None:
    whole = view = ViewRange(x=(low, low + span), y=(low + span, low))
    for step in steps:
        wanted = {
            "in": zoom_view(view, 0.3, 0.8, 0.5, only_x=False),
            "out": zoom_view(view, 0.3, 0.8, 2.0, only_x=False),
            "left": pan_view(view, -0.4, 0.0, only_x=False),
            "up": pan_view(view, 0.0, 0.4, only_x=False),
        }[step]
        view = wanted if is_usable_view(wanted, whole) else view
    for part, every in ((view.x, whole.x), (view.y, whole.y)):
        assert 1e-3 * span * 0.99 <= abs(part[1] - part[0]) <= 4.0 * span * 1.01
        assert min(part) < max(every)
        assert max(part) > min(every)


@settings(max_examples=40)
@given(spots=SPOTS)
def test_a_walk_to_the_right_meets_every_point_of_a_chart_once(spots: list[ManeuverPoint]) -> None:
    here = next_point(spots, None, "right")
    row = [one for one in spots if one.subplot_index == here.subplot_index]
    while (before := next_point(spots, here, "left")) != here:
        assert before is not None
        here = before
    met = [here]
    while (after := next_point(spots, met[-1], "right")) != met[-1]:
        assert after is not None
        met.append(after)
    assert sorted(met, key=id) == sorted(row, key=id)
    assert [one.x for one in met] == sorted(one.x for one in row)


@settings(max_examples=40)
@given(
    low=st.floats(-100, 100), span=st.floats(1e-3, 100), share=st.floats(0, 1),
    factor=st.floats(0.1, 10),
)  # fmt: skip
def test_zoom_and_move_keep_what_they_promise(
    low: float, span: float, share: float, factor: float
) -> None:
    view = ViewRange(x=(low, low + span), y=(low, low + span))
    still = low + share * span
    near = zoom_view(view, share, share, factor, only_x=False)
    assert near.x[0] + share * (near.x[1] - near.x[0]) == pytest.approx(still, abs=1e-6 * span)
    assert near.x[1] - near.x[0] == pytest.approx(factor * span)
    assert zoom_view(view, share, share, factor, only_x=True).y == view.y
    back = pan_view(pan_view(view, share, share, only_x=False), -share, -share, only_x=False)
    assert back.x == pytest.approx(view.x, abs=1e-6 * span)
