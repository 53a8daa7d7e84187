"""The charts beside the strips: what is drawn is seen whole."""

import csv
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import FIGURE_MENU
from ui.display_style import DisplayStyle
from ui.number_format import MINUS
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotCurve


@pytest.mark.parametrize(("scale", "width"), [(100, 280), (100, 700), (200, 560), (200, 900)])
def test_points_at_the_ends_are_not_cut(qtbot: QtBot, scale: int, width: int) -> None:
    style = DisplayStyle(scale=scale)
    chart = AnalysisPlot(style, "Residuals")
    qtbot.addWidget(chart)
    chart.resize(width, 3 * scale)
    points = PlotCurve(
        x=np.array([0.4, 2.5, 4.7]), y=np.array([-1.0, 0.0, 1.0]), color="blue", points=True,
        symbol="t",
    )  # fmt: skip
    with qtbot.waitExposed(chart):
        chart.show()
    chart.draw([points], title="Points", bottom="Volts", left="Off [deg]")
    qtbot.wait(50)

    box = chart.plot.getPlotItem().getViewBox()
    inside = box.mapToScene(box.rect()).boundingRect()
    half = style.px(11) / 2
    for x, y in zip(points.x, points.y, strict=True):
        at = box.mapViewToScene(QPointF(x, y))
        assert inside.left() + half <= at.x() <= inside.right() - half
        assert inside.top() + half <= at.y() <= inside.bottom() - half


@pytest.fixture
def history(qtbot: QtBot) -> AnalysisPlot:
    chart = AnalysisPlot(DisplayStyle(), "q of a maneuver")
    qtbot.addWidget(chart)
    chart.resize(700, 400)
    with qtbot.waitExposed(chart):
        chart.show()
    times = np.arange(100.0, 110.0, 0.02)
    curves = [
        PlotCurve(x=times, y=10.0 * np.sin(times), color="blue", name="measured"),
        PlotCurve(x=times, y=9.0 * np.sin(times), color="text", name="computed", dashed=True),
    ]
    chart.draw(curves, title="q", bottom=FLIGHT_TIME_LABEL, left="q, °/s")
    qtbot.wait(50)
    return chart


def pixel(chart: AnalysisPlot, x: float, y: float) -> QPointF:
    box = chart.plot.getPlotItem().getViewBox()
    return QPointF(chart.plot.mapFromScene(box.mapViewToScene(QPointF(x, y))))


def test_the_cursor_reads_all_curves_and_the_time(history: AnalysisPlot) -> None:
    words = history.plot.text_at(pixel(history, 105.0, 3.0)).splitlines()
    assert words[0] in ("01:44.99", "01:45.00", "01:45.01")
    found = {line.split()[1]: float(line.split()[2].replace(MINUS, "-")) for line in words[1:]}
    assert found["measured"] == pytest.approx(10.0 * np.sin(105.0), abs=0.2)
    assert found["computed"] == pytest.approx(0.9 * found["measured"], abs=0.01)
    assert all(line.startswith("q ") and line.endswith(" °/s") for line in words[1:])
    times = history.plot.getPlotItem().getAxis("bottom").tickStrings([101.0, 102.5], 1.0, 0.5)
    assert times == ["01:41.0", "01:42.5"]


def test_a_drag_zooms_to_its_rectangle_and_a_double_click_shows_everything(
    history: AnalysisPlot, qtbot: QtBot
) -> None:
    plot = history.plot
    box = plot.getPlotItem().getViewBox()
    whole = box.viewRange()
    view = plot.viewport()
    left = Qt.MouseButton.LeftButton
    start, end = (pixel(history, x, y).toPoint() for x, y in ((102.0, 5.0), (106.0, -5.0)))
    QTest.mousePress(view, left, pos=start)
    for share in (0.3, 0.6, 1.0):
        qtbot.wait(20)
        QTest.mouseMove(view, start + (end - start) * share)
    QTest.mouseRelease(view, left, pos=end)
    zoomed = box.viewRange()
    assert zoomed[0] == pytest.approx([102.0, 106.0], abs=0.25)
    assert zoomed[1] == pytest.approx([-5.0, 5.0], abs=0.8)
    QTest.mouseDClick(view, left, pos=start)
    qtbot.wait(20)
    assert box.viewRange()[0] == pytest.approx(whole[0])
    assert box.viewRange()[1] == pytest.approx(whole[1], abs=0.1)


def test_the_wheel_zooms_time_about_the_pointer(history: AnalysisPlot) -> None:
    box = history.plot.getPlotItem().getViewBox()
    before = box.viewRange()
    at = pixel(history, 103.0, 0.0)
    for held, factor in (
        (Qt.KeyboardModifier.ShiftModifier, 1.0),
        (Qt.KeyboardModifier.NoModifier, 0.8),
    ):
        event = QWheelEvent(
            at, history.plot.mapToGlobal(at), QPoint(), QPoint(0, 120),
            Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(history.plot.viewport(), event)
        (low, high), values = box.viewRange()
        assert high - low == pytest.approx(factor * (before[0][1] - before[0][0]))
        assert values == pytest.approx(before[1])
    assert 103.0 - low == pytest.approx(0.8 * (103.0 - before[0][0]), abs=0.05)


def test_the_menu_saves_the_chart_and_its_numbers(
    history: AnalysisPlot, tmp_path: Path, qtbot: QtBot
) -> None:
    copy_picture, copy_numbers, save_as, reset = history.plot.actions()
    assert [one.text() for one in (copy_picture, copy_numbers, save_as, reset)] == FIGURE_MENU
    for ending, begin in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF"), ("csv", b"")):
        path = tmp_path / f"chart.{ending}"
        with qtbot.waitSignal(history.menu.message_posted):
            history.menu.save(path)
        assert path.read_bytes().startswith(begin)
        assert path.stat().st_size > 2000
    rows = list(csv.reader((tmp_path / "chart.csv").open(encoding="utf-8")))
    assert rows[0] == ["curve", FLIGHT_TIME_LABEL, "q, °/s"]
    assert [float(cell) for cell in rows[1][1:]] == [100.0, 10.0 * np.sin(100.0)]
    with qtbot.waitSignal(history.menu.message_posted):
        copy_picture.trigger()
    assert QApplication.clipboard().mimeData().hasImage()
    with qtbot.waitSignal(history.menu.message_posted):
        copy_numbers.trigger()
    lines = QApplication.clipboard().text().splitlines()
    assert lines[0].split("\t") == rows[0]
    assert len(lines) == len(rows)
    history.draw([], title="q", bottom=FLIGHT_TIME_LABEL, left="q, °/s")
    assert not any(one.isEnabled() for one in history.plot.actions())
