"""The plot beside the charts: a flight of known content, chosen and zoomed by real events."""

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gsapp.flight.flight_import import import_flight
from gsapp.flight.writers import write_block
from gsapp.quantities import Block
from tests.ui.window_kit import until
from ui.main_window import MainWindow
from ui.widgets.analysis_plot import PlotCurve

RATE, LENGTH, SPEED = 100.0, 60.0, 30.0


@pytest.fixture
def opened(qtbot: QtBot, window: MainWindow, tmp_path: Path) -> MainWindow:
    """Return a window with a minute of flight: a circle, and pitch rate at 5 Hz."""
    times = np.arange(0.0, LENGTH, 1.0 / RATE)
    q = np.radians(3.0) * np.sin(2.0 * np.pi * 5.0 * times)
    values = np.column_stack([q, 2.0 * q, np.full(times.size, SPEED), 2.0 * np.pi * times / LENGTH])
    block = Block(channels=("q", "alpha", "V", "psi"), times=times, values=values)
    import_flight(write_block(tmp_path / "circle.csv", block, "csv"), tmp_path / "circle")
    controller = window.flight_controller
    controller.flight_opener.open_flight(tmp_path / "circle", playing=False)
    until(qtbot, lambda: controller.is_replay and (window.view._state.replay.end or 0.0) > 59.0)
    controller.seek(LENGTH - 0.1)
    window.commands.actions["panel_plot"].trigger()
    until(qtbot, lambda: len(drawn(window)) > 0 and drawn(window)[0].x.size > 20)
    return window


def drawn(window: MainWindow) -> tuple[PlotCurve, ...]:
    plot = window.view.plot.plot
    return () if plot is None else plot._drawn[0]


def choose(window: MainWindow, qtbot: QtBot, kind: str) -> None:
    """Choose what is plotted by keys."""
    box = window.view.plot.kind.box
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Home)
    for _ in range(box.findData(kind)):
        QTest.keyClick(box, Qt.Key.Key_Down)
    assert window.view.plot.kind.current_key == kind
    former = drawn(window)
    until(qtbot, lambda: drawn(window) is not former)


def test_the_spectrum_of_what_is_in_sight(opened: MainWindow, qtbot: QtBot) -> None:
    (curve,) = drawn(opened)
    assert curve.x[np.argmax(curve.y)] == pytest.approx(5.0, abs=0.1)
    # 3 deg/s: 4.5 (deg/s)² within a few lines of the spectrum.
    power = float(np.sum(10.0 ** (curve.y / 10.0)) * (curve.x[1] - curve.x[0]))
    assert power == pytest.approx(4.5, rel=0.05)
    # What the user has zoomed to stays in sight when the window in time changes.
    area = opened.view.plot.plot.plot
    whole = area.getPlotItem().getViewBox().viewRange()[0]
    middle = QPointF(area.rect().center())
    QApplication.sendEvent(
        area.viewport(),
        QWheelEvent(
            middle, area.mapToGlobal(middle), QPoint(), QPoint(0, 240),
            Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier,
            Qt.ScrollPhase.NoScrollPhase, False,
        ),
    )  # fmt: skip
    zoomed = area.getPlotItem().getViewBox().viewRange()[0]
    assert zoomed[1] - zoomed[0] < 0.8 * (whole[1] - whole[0])
    opened.view.charts.navigator.set_window(10.0)
    until(qtbot, lambda: drawn(opened)[0] is not curve)
    assert area.getPlotItem().getViewBox().viewRange()[0] == pytest.approx(zoomed)


def test_one_channel_over_another(opened: MainWindow, qtbot: QtBot) -> None:
    choose(opened, qtbot, "channels")
    (curve,) = drawn(opened)
    assert curve.points
    np.testing.assert_allclose(curve.x, 2.0 * curve.y, atol=1e-3)
    assert np.max(curve.y) == pytest.approx(3.0, rel=0.01)


def test_the_track_of_a_circle_closes(opened: MainWindow, qtbot: QtBot) -> None:
    # Half of it first: the plot grows with the track.
    opened.flight_controller.seek(LENGTH / 2.0)
    choose(opened, qtbot, "track")
    until(qtbot, lambda: np.ptp(drawn(opened)[0].y) > 10.0)
    opened.flight_controller.seek(LENGTH - 0.1)
    diameter = SPEED * LENGTH / np.pi / 0.3048  # ft
    until(qtbot, lambda: np.hypot(drawn(opened)[-1].x[0], drawn(opened)[-1].y[0]) < 0.1 * diameter)
    flight, *_, aircraft = drawn(opened)
    assert np.ptp(flight.x) == pytest.approx(diameter, rel=0.01)
    assert np.hypot(aircraft.x[0], aircraft.y[0]) < 0.02 * diameter
    low, high = opened.view.plot.plot.plot.getPlotItem().getViewBox().viewRange()
    area = opened.view.plot.plot.plot.getPlotItem().getViewBox()
    # All of it is in sight, in a panel that is higher than wide.
    assert low[0] <= np.min(flight.x) < np.max(flight.x) <= low[1]
    assert high[0] <= np.min(flight.y) < np.max(flight.y) <= high[1]
    # Both axes have one scale.
    assert (low[1] - low[0]) / area.width() == pytest.approx(
        (high[1] - high[0]) / area.height(), rel=0.02
    )
    assert opened.view.plot.note.isVisible()
