"""The plot beside the charts: a flight of known content, chosen and zoomed by real events."""

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QBuffer, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gsapp.flight.flight_import import import_flight
from gsapp.flight.map_tiles import MapTile, MapTiles
from gsapp.flight.writers import write_block
from gsapp.quantities import Block
from gsapp.quantities.constants import EARTH_RADIUS
from tests.flight.test_map_tiles import write_tiles
from tests.ui.window_kit import until
from ui.flight.map_background import decode_tile
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


def png(side: int, color: str) -> bytes:
    """Return a square picture of one color."""
    picture, buffer = QImage(side, side, QImage.Format.Format_RGB32), QBuffer()
    picture.fill(QColor(color))
    picture.save(buffer, "PNG")
    return bytes(buffer.data().data())


@pytest.mark.parametrize(("side", "is_shown"), [(1024, True), (1025, False)])
def test_a_picture_larger_than_a_tile_is_not_unpacked(
    tmp_path: Path, side: int, is_shown: bool
) -> None:
    path = write_tiles(tmp_path / "map.mbtiles", [(0, 0, 0, None)])
    tile = MapTile(zoom=0, column=0, row=0, picture=png(side, "red"))
    image = decode_tile(tile, MapTiles(path))
    assert image.isNull() != is_shown


def test_the_track_lies_on_a_map(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> None:
    """A flight due east along a line between two rows of tiles, one row red and one blue."""
    zoom = 16
    latitude = 0.0  # the equator parts tiles
    times = np.arange(0.0, 40.0, 0.1)
    longitude = np.radians(13.0) + 20.0 * times / EARTH_RADIUS
    block = Block(
        channels=("latitude", "longitude"), times=times,
        values=np.column_stack([np.full(times.size, latitude), longitude]),
    )  # fmt: skip
    import_flight(write_block(tmp_path / "east.csv", block, "csv"), tmp_path / "east")
    first = int((13.0 + 180.0) / 360.0 * 2**zoom)
    equator = 2 ** (zoom - 1)
    tiles = [
        (zoom, column, row, png(256, "red" if row >= equator else "blue"))
        for column in range(first - 8, first + 9)
        for row in range(equator - 8, equator + 8)
    ]
    path = write_tiles(tmp_path / "map.mbtiles", tiles)
    controller = window.flight_controller
    controller.flight_opener.open_flight(tmp_path / "east", playing=False)
    until(qtbot, lambda: controller.is_replay and (window.view._state.replay.end or 0.0) > 39.0)
    controller.seek(39.0)
    window.commands.actions["panel_plot"].trigger()
    until(qtbot, lambda: window.view.plot.plot is not None)
    choose(window, qtbot, "track")
    until(qtbot, lambda: np.ptp(drawn(window)[0].x) > 1000.0)
    window.view.plot._map_row.chosen.emit(str(path))
    area = window.view.plot.plot.plot
    box = area.getPlotItem().getViewBox()

    def red(north: float) -> int:
        """Return by how much red exceeds blue there, 0 to 255."""
        place = area.mapFromScene(box.mapViewToScene(QPointF(1060.0, north)))  # ft
        shown = area.grab().toImage()
        ratio = shown.devicePixelRatio()
        color = shown.pixelColor(int(place.x() * ratio), int(place.y() * ratio))
        return color.red() - color.blue()

    until(qtbot, lambda: red(430.0) > 100)
    assert red(-430.0) < -100
    # Finer tiles do not undo what the user has zoomed to.
    whole = box.viewRange()[0]
    area.setFocus()
    QTest.keyClick(area, Qt.Key.Key_Up)
    wanted = window.view.plot._map._wanted
    until(qtbot, lambda: window.view.plot._map._wanted != wanted)
    until(qtbot, lambda: not window.view.plot._map._job.is_running)
    qtbot.wait(100)
    assert np.ptp(box.viewRange()[0]) < 0.8 * np.ptp(whole)
    # A map that is gone is told, and the track stays.
    path.unlink()
    window.view.plot.set_map(str(path))
    until(qtbot, lambda: str(path) in window.view.plot.note.text())
    assert abs(red(430.0)) < 30
    QTest.mouseClick(window.view.plot._map_row.remove, Qt.MouseButton.LeftButton)
    assert window.store.current.map_tiles == ""
