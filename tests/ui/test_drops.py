"""Flights dropped from a file manager."""

from pathlib import Path

from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import until, write_flight
from ui.main_window import MainWindow

_HERE = QPoint(20, 20)
_ALL = Qt.DropAction.CopyAction | Qt.DropAction.MoveAction
_LEFT, _NO_KEY = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier


def drop(target: QWidget, data: QMimeData) -> Qt.DropAction | None:
    entered = QDragEnterEvent(_HERE, _ALL, data, _LEFT, _NO_KEY)
    QApplication.sendEvent(target, entered)
    if not entered.isAccepted():
        return None
    # Qt hands the rest to whoever took the first.
    dropped = QDropEvent(_HERE, _ALL, data, _LEFT, _NO_KEY)
    dropped.setDropAction(Qt.DropAction.MoveAction)
    QApplication.sendEvent(target, dropped)
    assert dropped.isAccepted()
    return dropped.dropAction()


def files(*paths: Path) -> QMimeData:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    return data


def test_a_flight_dropped_on_the_window_opens_and_stays_where_it_lies(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    flight = write_flight(tmp_path / "a flight, dropped")
    assert drop(window.view.charts, files(flight)) is Qt.DropAction.CopyAction
    assert not window.flight_controller.is_open  # the file manager is answered first
    until(qtbot, lambda: window.flight_controller.is_loaded)
    assert window.flight_controller.session.path == flight


def test_several_are_offered_to_the_review(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    drop(window, files(tmp_path / "one", tmp_path / "two"))
    until(qtbot, lambda: bool(window.banners.texts()))
    (said,) = window.banners.texts()
    assert "2 were dropped" in said
    assert not window.flight_controller.is_open


def test_what_is_no_file_is_refused(window: MainWindow) -> None:
    text, page = QMimeData(), QMimeData()
    text.setText("a flight")
    page.setUrls([QUrl("https://example.org/flight.tlog")])
    assert drop(window, text) is None
    assert drop(window, page) is None


def test_the_review_and_the_search_take_what_is_dropped_on_them(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    flights = [write_flight(tmp_path / name) for name in ("one", "two")]
    window.show_page("gap")
    drop(window.gap_page.stack.currentWidget(), files(*flights))
    setup = window.gap_page.setup
    until(qtbot, lambda: setup.paths == tuple(flights))
    window.show_page("review")
    window.review_page.go_to_step("summary")
    drop(window.review_page.stack.currentWidget(), files(*flights))
    until(qtbot, lambda: [*window.review_page.review.paths] == flights)
    assert window.review_page.step == "maneuvers"
    assert not window.flight_controller.is_open
