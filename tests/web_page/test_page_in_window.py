"""The page of the window: switched at the REC tile, with the charts of the layout."""

import http.client
import json
import socket
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMenu, QPushButton
from pytestqt.qtbot import QtBot

from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from tests.telemetry.conftest import free_port
from tests.ui.window_kit import answer_dialog, open_small_flight, open_window, until
from ui.main_window import MainWindow
from ui.sharing_menu import ShareDialog
from ui.strips.strip_layout import Strip, StripGroup, StripLayout, Trace


@pytest.fixture
def window(tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> Iterator[MainWindow]:
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    made = open_window(tmp_path, shares=(f"http:127.0.0.1:{free_port(socket.SOCK_STREAM)}",))
    made.disable_close_questions()
    qtbot.addWidget(made)
    yield made
    made.close()


def open_menu(window: MainWindow, qtbot: QtBot) -> QMenu:
    rec = window.status_bar.item_widgets["record"]
    qtbot.mouseClick(rec, Qt.MouseButton.LeftButton)
    menu = window.findChild(QMenu, "recorders")
    until(qtbot, menu.isVisible)
    return menu


def trigger(window: MainWindow, qtbot: QtBot, text: str) -> None:
    menu = open_menu(window, qtbot)
    (action,) = [one for one in menu.actions() if text in one.text()]
    action.trigger()
    menu.close()
    until(qtbot, lambda: window.findChild(QMenu, "recorders") is None)


def read_frames(window: MainWindow, qtbot: QtBot, count: int = 3) -> list[dict[str, Any]]:
    port = int(window.web_page.link.rpartition(":")[2])

    def read() -> list[dict[str, Any]]:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20.0)
        connection.request("GET", "/frames")
        with connection.getresponse() as answer:
            return [json.loads(answer.readline()) for _ in range(count)]

    with ThreadPoolExecutor() as pool:
        reading = pool.submit(read)
        until(qtbot, reading.done)
    return reading.result()


def test_the_page_shows_what_the_window_shows(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port = window.store.current.shares[0].rpartition(":")[2]
    open_small_flight(window, qtbot, tmp_path)
    trigger(window, qtbot, port)
    assert window.web_page.url == f"http://127.0.0.1:{port}/"
    window.flight_controller.seek(12.0)
    until(qtbot, lambda: window.flight_controller.time == pytest.approx(12.0, abs=0.1))
    frame = read_frames(window, qtbot)[-1]
    assert (frame["flight"], frame["time"][:5]) == ("small", "00:12")
    layout = window.view.charts.strip_layout
    with_data = set(window.flight_controller.history.channels_with_data)
    assert len(frame["strips"]) == len([one for one in layout.strips if one.channel in with_data])
    # Another layout, with two lines in one chart.
    alpha, q = Strip(traces=(Trace(channel="alpha"),)), Strip(traces=(Trace(channel="q"),))
    window.view.charts.set_layout(StripLayout(groups=(StripGroup(strips=(q, alpha)),)))
    strips = read_frames(window, qtbot)[-1]["strips"]
    assert [one["lines"][0]["title"].split()[0] for one in strips] == ["q", "α"]
    # In the units of the window.
    assert strips[0]["unit"] == "°/s"
    curve = read_frames(window, qtbot)[0]["curves"][0]
    assert max(value for value in curve[1] if value is not None) == pytest.approx(11.46, abs=0.1)
    # Those of the time after a playhead that went back are gone.
    window.flight_controller.seek(2.0)
    until(qtbot, lambda: window.flight_controller.time == pytest.approx(2.0, abs=0.1))
    frame = read_frames(window, qtbot)[0]
    assert frame["first"] + len(frame["curves"][0][0]) <= 21
    window.flight_controller.close_flight()
    frame = read_frames(window, qtbot)[-1]
    assert (frame["cue"]["status_text"], frame["curves"]) == ("NO FLIGHT", [])
    rec = window.status_bar.item_widgets["record"]
    until(qtbot, lambda: "SHARED" in rec.item.title)
    trigger(window, qtbot, "Show in browsers")
    assert window.web_page.url == ""
    until(qtbot, lambda: "SHARED" not in rec.item.title)
    with pytest.raises(ConnectionRefusedError):
        http.client.HTTPConnection("127.0.0.1", int(port)).connect()


def test_the_address_with_its_key_is_copied(window: MainWindow, qtbot: QtBot) -> None:
    link = f"http:0.0.0.0:{free_port(socket.SOCK_STREAM)}"

    def type_address(dialog: ShareDialog) -> None:
        dialog.edit.setText(link)
        assert dialog.button.isEnabled()
        dialog.accept()

    answer_dialog(ShareDialog, type_address)
    window.file_menu.sharing.ask_address()
    assert window.store.current.shares[0] == window.web_page.link == link
    assert len(window.web_page.url.partition("#")[2]) == 10
    assert any(window.web_page.url in text for text in window.banners.texts())
    (copy,) = [one for one in window.banners.findChildren(QPushButton) if one.text() == "Copy"]
    qtbot.mouseClick(copy, Qt.MouseButton.LeftButton)
    assert QGuiApplication.clipboard().text() == window.web_page.url
    QGuiApplication.clipboard().clear()
    trigger(window, qtbot, "Copy http://")
    assert QGuiApplication.clipboard().text() == window.web_page.url


def test_a_port_in_use_is_said(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> None:
    open_small_flight(window, qtbot, tmp_path)
    port = window.store.current.shares[0].rpartition(":")[2]
    with socket.create_server(("127.0.0.1", int(port))):
        trigger(window, qtbot, port)
        assert window.web_page.link == ""
        assert any(port in text for text in window.banners.texts())
