"""The whole life of a flight in the window, with real sockets, files and processes."""

import itertools
import os
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QMenu
from pytestqt.qtbot import QtBot

import ui.main_window
from gsapp.decoding.dialect import dialect
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files.record_files import RawFile
from gsapp.foundation import FlightError
from gsapp.session import Session
from gsapp.session.snapshot import SessionSnapshot
from gsapp.telemetry.recorder_control import find_recorder, find_recorders
from tests.ui.window_kit import (
    KILL,
    Aircraft,
    activate,
    alpha_sent,
    answer_dialog,
    connect,
    free_port,
    is_followed,
    open_small_flight,
    open_window,
    until,
    write_flight,
)
from ui.background_job import BackgroundJob, JobProgress
from ui.dialogs.flight_requests import ConnectRequest
from ui.dialogs.mavlink_inspector import MavlinkInspector
from ui.main_window import MainWindow
from ui.settings import next_flight_path

pytestmark = pytest.mark.usefixtures("alone")


def press(qtbot: QtBot, window: MainWindow, key: Qt.Key, *modifiers: Qt.KeyboardModifier) -> None:
    held = Qt.KeyboardModifier.NoModifier
    for modifier in modifiers:
        held |= modifier
    qtbot.keyClick(window.view.charts, key, held)


def samples(window: MainWindow) -> int:
    history = window.flight_controller.history
    if history is None or history.end is None or "alpha" not in history.channels:
        return 0
    return int(np.isfinite(history.samples("alpha", 0, history.index(history.end) + 1)).sum())


def traced_pixels(window: MainWindow) -> int:
    image = window.view.charts.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    pixels = np.frombuffer(image.constBits(), dtype=np.uint32) & 0xFFFFFF
    colors = [int(color[1:], 16) for color in window.display_style.theme.traces.values()]
    return int(np.isin(pixels, colors).sum())


def test_the_flown_system_is_shown_and_chosen_on_the_link_tile(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """One click on a system of the menu: the flight is read again, and says so."""
    controller = window.flight_controller
    port, folder = free_port(), tmp_path / "flights" / "first"
    controller.flight_opener.connect_aircraft(
        ConnectRequest(
            link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="ardupilot-plane",
            aircraft="b777", calibration="",
        )
    )  # fmt: skip
    until(qtbot, lambda: controller.is_open)
    stop = threading.Event()

    def transmit() -> None:
        senders = {number: dialect().MAVLink(None, srcSystem=number) for number in (1, 7)}
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for k in itertools.count():
                if stop.wait(0.02):
                    return
                for number, packer in senders.items():
                    roll = dialect().MAVLink_attitude_message(20 * k, 0.1 * number, *(5 * [0.0]))
                    beat = dialect().MAVLink_heartbeat_message(1, 3, 0, 0, 4, 3)
                    for message in (roll, beat):
                        data = message.pack(packer)
                        packer.seq = (packer.seq + 1) % 256
                        sender.sendto(data, ("127.0.0.1", port))

    transmitter = threading.Thread(target=transmit)
    transmitter.start()
    try:
        tile = window.status_bar.item_widgets["link"]
        until(qtbot, lambda: tile.item.title == "LINK  SYSTEM 1")
        former = controller.session
        report = former.link_report() if former is not None else None
        assert [vehicle.system for vehicle in report.vehicles] == [1, 7]
        qtbot.mouseClick(tile, Qt.MouseButton.LeftButton)
        menu = window.findChild(QMenu, "flown_system")
        until(qtbot, menu.isVisible)
        choices = [action for action in menu.actions() if action.isCheckable()]
        assert [action.isChecked() for action in choices] == [True, False]
        choices[1].trigger()
        menu.close()
        until(qtbot, lambda: tile.item.title == "LINK  SYSTEM 7")
        assert controller.session is not former
        until(qtbot, lambda: controller.session.history.has("phi"))
        assert controller.session.history.last("phi")[1] == pytest.approx(0.7)
    finally:
        stop.set()
        transmitter.join()
        controller.recorders.stop_recording_and_wait()


def test_what_arrives_and_is_in_no_channel_is_not_called_nothing(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    lines = tmp_path / "bench.toml"
    lines.write_text('name = "bench"\n[text]\ncolumns = ["alpha [deg]"]\n', encoding="utf-8")
    port = free_port()
    request = ConnectRequest(
        link=f"udpin:127.0.0.1:{port}", folder=tmp_path / "flights" / "first",
        channel_map=str(lines), aircraft="b777", calibration="b777",
    )  # fmt: skip
    window.flight_controller.flight_opener.connect_aircraft(request)

    def said() -> str:
        return window.crew.view_state().empty_text

    until(qtbot, lambda: window.flight_controller.is_open)
    assert "Nothing received" in said()
    with Aircraft(port):
        until(qtbot, lambda: said() != "Nothing received yet")
    assert "channel map bench" in said()
    window.flight_controller.recorders.stop_recording_and_wait()


def test_from_the_first_byte_to_the_end_of_the_recording(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Connect, record, draw, mark, pause, close, find again, stop: as a crew would."""
    port, folder = free_port(), tmp_path / "flights" / "first"
    with Aircraft(port):
        connect(window, port, folder)
        until(qtbot, lambda: window.flight_controller.is_open and samples(window) > 60)
        history = window.flight_controller.history
        until(qtbot, lambda: traced_pixels(window) > 200)
        # What is drawn is what was sent, through volts, converter and certificates.
        drawn = history.block(("alpha",), 0.0, history.end)
        known = ~np.isnan(drawn["alpha"])
        sent = alpha_sent(drawn.times[known])
        assert known.sum() > 40
        np.testing.assert_allclose(drawn["alpha"][known], sent, atol=1e-4)

        # The bar tells of link and recorder, each in words and numbers.
        bar = window.status_bar.item_widgets
        until(qtbot, lambda: bar["link"].item.value.endswith("/s"))
        until(qtbot, lambda: bar["record"].item.note.startswith("growing"))
        assert "B" in bar["record"].item.value
        assert bar["aircraft"].item.value == "B777"
        until(
            qtbot,
            lambda: any(
                "Engines" in line.cells[1] for line in window.view.messages.view.row_model.rows
            ),
        )

        # The link in detail, for as long as one looks.
        seen: list[list[tuple[str, ...]]] = []

        def look_at_link(dialog: MavlinkInspector) -> None:
            def rows() -> list[tuple[str, ...]]:
                return [line.cells for line in dialog.messages.view.row_model.rows]

            before = rows()
            until(qtbot, lambda: rows()[0][1] != before[0][1])
            seen.append(rows())
            assert "System 1, component 1" in dialog.senders.text()
            assert "0 % lost" in dialog.senders.text()

        answer_dialog(MavlinkInspector, look_at_link)
        press(qtbot, window, Qt.Key.Key_I, Qt.KeyboardModifier.ControlModifier)
        volts = next(cells for cells in seen[0] if cells[0] == "DEBUG_FLOAT_ARRAY")
        assert float(volts[2]) > 5.0
        assert volts[4].endswith(" ms")

        # A mark with one key; its text afterwards.
        press(qtbot, window, Qt.Key.Key_M)
        until(qtbot, lambda: len(window.view.marks.view.row_model.rows) == 1)
        key = window.view.marks.view.row_model.rows[0].key
        window.view.marks.edited.emit(key, "first mark")
        assert window.flight_controller.session.marks[0].text == "first mark"

        # A paused display stands still, the recording goes on.
        press(qtbot, window, Qt.Key.Key_Space)
        assert window.view.charts.view.paused
        held, end = window.view.charts.view.columns, history.end
        until(qtbot, lambda: history.end > end + 0.3)
        assert window.view.charts.view.columns == held
        press(qtbot, window, Qt.Key.Key_Home)
        assert not window.view.charts.view.paused

        # Closing the window leaves the recorder running; the next window finds it with one key.
        window.close()
        recorder = find_recorder(folder)
        assert recorder is not None
        again = open_window(tmp_path)
        qtbot.addWidget(again)
        assert any("Ctrl+R" in text for text in again.banners.texts())
        activate(qtbot, again)
        qtbot.wait(50)
        qtbot.keyClick(again, Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier)
        until(
            qtbot,
            lambda: again.flight_controller.is_open and (again.flight_controller.time or 0.0) > 1.0,
        )
        until(
            qtbot,
            lambda: (
                [line.cells[1] for line in again.view.marks.view.row_model.rows] == ["first mark"]
            ),
        )
        until(qtbot, lambda: again.flight_controller.is_recording)

    # The aircraft is silent now: no number of it is left standing.
    until(qtbot, lambda: again.status_bar.item_widgets["link"].item.state == "warning")
    assert again.status_bar.item_widgets["link"].item.value == "–"
    assert again.status_bar.item_widgets["flight"].item.value == "–"

    again.flight_controller.recorders.stop_recording()
    until(qtbot, lambda: any("has ended" in text for text in again.banners.texts()))
    # Read once, the flight that has landed opens in a moment.
    until(qtbot, lambda: any(FlightFolder(path=folder).cache_folder.glob("*.npz")))
    assert find_recorder(folder) is None
    assert again.status_bar.item_widgets["record"].item.value == "stopped"
    again.flight_controller.close()


def test_a_flight_is_replayed_with_keys_alone(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    controller = window.flight_controller
    open_small_flight(window, qtbot, tmp_path)
    until(qtbot, window.view.replay.isVisible)
    assert controller.replay_span == (0.0, pytest.approx(19.98))
    start = controller.time

    press(qtbot, window, Qt.Key.Key_Space)
    until(qtbot, lambda: (controller.time or 0.0) > 0.2)
    press(qtbot, window, Qt.Key.Key_Space)
    held = controller.time
    qtbot.wait(60)
    assert controller.time == held > start

    press(qtbot, window, Qt.Key.Key_Period)
    # It was held between two samples, and goes to the next one.
    assert held < controller.time <= held + 0.02 + 1e-9
    assert controller.time * 50 == pytest.approx(round(controller.time * 50))
    press(qtbot, window, Qt.Key.Key_BracketRight)
    assert controller.speed == 2.0
    until(qtbot, lambda: window.view.replay.speed.currentText() == "2x")

    # By the slider, with the keyboard: 10 s on, to the end, back to the start.
    slider = window.view.replay.slider
    slider.setFocus()
    controller.seek(5.0)
    controller.poller.tick()
    until(qtbot, lambda: slider.accessibleDescription().startswith("00:05"))
    qtbot.keyClick(slider, Qt.Key.Key_PageDown)
    assert controller.time == pytest.approx(15.0)
    qtbot.keyClick(slider, Qt.Key.Key_Home)
    assert controller.time == 0.0

    # As fast as it can, to the end.
    controller.set_speed(float("inf"))
    press(qtbot, window, Qt.Key.Key_Space)
    until(qtbot, lambda: controller.time == pytest.approx(19.98))
    assert traced_pixels(window) > 200


def test_a_recording_is_not_forgotten_when_another_flight_opens(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []
    answers = iter(("stay", "stop"))

    def answer(_parent: object, flights: list[str], _works: object) -> str:
        asked.append(flights)
        return next(answers)

    monkeypatch.setattr(ui.main_window, "ask_closing", answer)
    folder = tmp_path / "flights" / "first"
    connect(window, free_port(), folder)
    until(qtbot, lambda: window.flight_controller.is_recording)
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_replay)
    assert any("still recording" in text for text in window.banners.texts())
    window.close()
    assert window.isVisible()
    window.close()
    assert not window.isVisible()
    assert asked == [["first"], ["first"]]
    assert find_recorder(folder) is None


def test_cursors_give_values_and_differences(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """A and B half a period of alpha apart: the table says twice the amplitude."""
    open_small_flight(window, qtbot, tmp_path)
    window.flight_controller.seek(19.0)
    until(qtbot, lambda: window.flight_controller.is_up_to_date)
    window.view.show_panel(1)
    window.view.charts.navigator.set_cursor("a", 10.5)
    window.view.charts.navigator.set_cursor("b", 11.5)
    lines = {line.key: line.cells for line in window.view.values.view.row_model.rows}
    assert lines["alpha"][2:] == ("4.6", "1.1", "−3.4")
    assert lines["V"][2:] == ("100.0", "100.0", "0.0")
    assert "B − A 1.00 s" in window.view.values.times.text().replace("\N{NO-BREAK SPACE}", " ")
    window.appearance.toggle_units()
    lines = {line.key: line.cells for line in window.view.values.view.row_model.rows}
    assert lines["V"][0] == "V m/s"
    assert lines["V"][2] == "30.5"


def test_files_that_cannot_be_read_are_told_in_a_sentence(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("time [s],alpha [volts]\n0,1\n1,2\n")
    window.flight_controller.flight_opener.open_flight(bad)
    until(qtbot, lambda: bool(window.banners.texts()))
    assert "alpha" in window.banners.texts()[0]
    assert not window.flight_controller.is_open
    window.flight_controller.flight_opener.open_flight(tmp_path / "nowhere")
    until(qtbot, lambda: any("nowhere" in text for text in window.banners.texts()))


def test_a_port_in_use_is_told_and_the_window_goes_on(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    def told() -> bool:
        return any("in use" in text for text in window.banners.texts())

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        link = f"udpin:127.0.0.1:{taken.getsockname()[1]}"
        window.flight_controller.flight_opener.connect_link(link)
        until(
            qtbot,
            lambda: told() or window.status_bar.item_widgets["link"].item.state == "warning",
            15_000,
        )
    if window.flight_controller.is_recording:
        window.flight_controller.recorders.stop_recording_and_wait()


def test_a_flight_is_exported_in_the_background(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    from gsapp.flight import load_flight

    open_small_flight(window, qtbot, tmp_path)
    target = tmp_path / "out.csv"
    work = BackgroundJob(
        "Exporting",
        lambda progress: window.flight_controller.export("csv", target, progress),
        window,
    )
    window.file_menu.jobs.show_job(work, "Exported.")
    work.start()
    until(qtbot, lambda: "Exported." in window.banners.texts())
    assert load_flight(target).block.channels == load_flight(tmp_path / "small.csv").block.channels


@dataclass(slots=True, kw_only=True)
class Held:
    """Halts a work in the middle of its file."""

    begun: threading.Event = field(default_factory=threading.Event)
    goes_on: threading.Event = field(default_factory=threading.Event)

    def halt(self) -> None:
        self.begun.set()
        self.goes_on.wait(10.0)

    def within(self, progress: JobProgress) -> Callable[[float | None, str], None]:
        def tell(share: float | None, text: str) -> None:
            if share:
                self.halt()
            progress(share, text)

        return tell


@pytest.mark.parametrize("kind", ["csv", "mat", "parquet"])
@pytest.mark.parametrize("closes", [False, True])
def test_an_export_that_is_given_up_leaves_nothing_behind(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    kind: str, closes: bool,
) -> None:  # fmt: skip
    """By a press on Cancel, or with the window, which asks before."""
    open_small_flight(window, qtbot, tmp_path)
    held, target = Held(), tmp_path / "out" / f"flight.{kind}"
    work = BackgroundJob(
        "Exporting",
        lambda told: window.flight_controller.export(kind, target, held.within(told)),
        window,
    )
    window.file_menu.jobs.show_job(work, "Exported.")
    work.start()
    assert held.begun.wait(10.0)
    assert len(list(target.parent.iterdir())) == 1
    asked: list[tuple[str, ...]] = []
    if closes:
        monkeypatch.setattr(
            ui.main_window, "ask_closing", lambda *given: asked.append(given[-1]) or "leave"
        )
        threading.Timer(0.1, held.goes_on.set).start()
        window.close()
        assert asked == [("Exporting",)]
    else:
        work.cancel()
        held.goes_on.set()
        until(qtbot, lambda: not window.file_menu.jobs.unfinished_jobs)
        assert "Exported." not in window.banners.texts()
    assert list(target.parent.iterdir()) == []


def test_an_export_that_is_cancelled_when_it_is_done_is_told_as_done(
    window: MainWindow, qtbot: QtBot
) -> None:
    held = Held()
    work = BackgroundJob("Exporting", lambda _told: held.halt(), window)
    window.file_menu.jobs.show_job(work, "Exported.")
    work.start()
    assert held.begun.wait(10.0)
    work.cancel()
    held.goes_on.set()
    until(qtbot, lambda: "Exported." in window.banners.texts())


@pytest.mark.skipif(sys.platform == "win32", reason="Windows renames no folder with open files")
@pytest.mark.skipif(os.name == "nt", reason="Windows does not rename folders of open files")
def test_a_flight_folder_that_disappears_is_said_and_its_recording_followed(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is renamed: an alarm says so, the window goes on with all samples, and it can be ended."""
    controller = window.flight_controller
    port = free_port()
    with Aircraft(port):
        controller.flight_opener.connect_link(
            f"udpin:127.0.0.1:{port}", channel_map="b777", aircraft="b777"
        )
        until(qtbot, lambda: controller.is_open and samples(window) > 20)
        folder = controller.session.path
        part = window.status_bar.item_widgets["record"]
        until(qtbot, lambda: part.item.state == "good")
        first = controller.history.start
        folder.rename(folder.with_name("elsewhere"))
        beside = folder.with_name(f"{folder.name}-2")
        until(qtbot, lambda: is_followed(window, beside))
        until(qtbot, lambda: samples(window) > 60 and part.item.state == "good")
        assert controller.history.start == first
        alarm = controller.session.alarm_registry.get("folder")
        assert not alarm.acknowledged
        # Asked at closing, the crew stays; then it ends the recording with the key.
        asked: list[str] = []
        monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: asked.append("?") or "stay")
        assert not window.close()
        assert asked == ["?"]
        monkeypatch.setattr("ui.file_menu_controller.ask_stop", lambda *_: True)
        press(
            qtbot, window, Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier,
            Qt.KeyboardModifier.ShiftModifier,
        )  # fmt: skip
        until(qtbot, lambda: part.item.value == "stopped")
    assert find_recorders() == []
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")


def test_a_record_that_cannot_be_read_floods_neither_window_nor_log(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    raised: list[object] = []
    window.error_reporter.error_reported.connect(raised.append)
    port = free_port()
    with Aircraft(port):
        window.flight_controller.flight_opener.connect_link(
            f"udpin:127.0.0.1:{port}", channel_map="b777", aircraft="b777"
        )
        until(qtbot, lambda: window.flight_controller.is_open and samples(window) > 20)

        def refuse(file: RawFile) -> int:
            raise FlightError(f"{file.path.name} cannot be read (Device not configured)")

        monkeypatch.setattr(RawFile, "size", refuse)
        os.kill(window.flight_controller.session.recorder.pid, KILL)
        until(
            qtbot, lambda: window.status_bar.item_widgets["record"].item.note == "recorder failed"
        )
        qtbot.wait(1500)
    told = [text for text in window.banners.texts() if "Device not configured" in text]
    assert len(told) == 1
    assert raised == []


def test_what_fails_in_a_replay_is_told_once(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    open_small_flight(window, qtbot, tmp_path)
    calls: list[float] = []

    def fail(_session: Session, budget: float) -> None:
        calls.append(budget)
        raise ZeroDivisionError("in the middle")

    window.flight_controller.toggle_play()
    for _ in range(2):
        calls.clear()
        with monkeypatch.context() as patch:
            patch.setattr(Session, "update", fail)
            until(qtbot, lambda: any("in the middle" in text for text in window.banners.texts()))
            window.banners.dismiss()
            qtbot.wait(1000)
            assert window.banners.texts() == ()
            assert len(calls) <= 4
        now = window.flight_controller.session.now
        until(qtbot, lambda before=now: window.flight_controller.session.now != before)


def test_what_heals_and_fails_again_is_told_again(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A crew that closed the banner of the first time would else look at charts that stand."""
    open_small_flight(window, qtbot, tmp_path)
    snapshot, problem, asked = Session.snapshot, [""], [0]

    def take_snapshot(session: Session) -> SessionSnapshot:
        asked[0] += 1
        return replace(snapshot(session), problem=problem[0])

    monkeypatch.setattr(Session, "snapshot", take_snapshot)
    for _ in range(2):
        problem[0] = "raw.tlog cannot be read (Device not configured)"
        until(qtbot, lambda: problem[0] in window.banners.texts())
        while window.banners.texts():
            window.banners.dismiss()
        problem[0], before = "", asked[0]
        until(qtbot, lambda seen=before: asked[0] > seen + 2)
        assert window.banners.texts() == ()


@pytest.mark.parametrize("moment", ["early", "late", "done"])
def test_a_connection_that_is_cancelled_leaves_nothing_behind(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    """Neither recorder nor folder: connecting again works at once, and the card still waits."""
    controller = window.flight_controller
    card = next_flight_path(window.store.path) / "flight.toml"
    card.parent.mkdir(parents=True, exist_ok=True)
    card.write_text('notes = "new tire"\n', encoding="utf-8")
    works: list[BackgroundJob] = []
    ended: list[str] = []

    def keep(work: BackgroundJob, _done: str) -> None:
        works.append(work)
        work.canceled.connect(lambda: ended.append("cancelled"))

    controller.job_started.connect(keep)
    follow = Session.follow

    def slow(folder: Path, **options: object) -> Session:
        # Cancelled in the very moment in which the work ends.
        made = follow(folder, **options)
        if moment == "late" and not ended:
            works[0].cancel()
        return made

    monkeypatch.setattr(Session, "follow", slow)
    finish = BackgroundJob._finish

    def cancel_and_finish(work: BackgroundJob, result: object, error: BaseException | None) -> None:
        if moment == "done" and not ended:
            work.cancel()
        finish(work, result, error)

    link = f"udpin:127.0.0.1:{free_port()}"
    flights = tmp_path / "flights"
    if moment == "done":
        monkeypatch.setattr(BackgroundJob, "_finish", cancel_and_finish)
    controller.flight_opener.connect_link(link)
    if moment == "early":
        works[0].cancel()
    until(qtbot, lambda: bool(ended))
    until(qtbot, lambda: find_recorders() == [] and not list(flights.glob("*")))
    assert not controller.is_open
    assert "new tire" in card.read_text(encoding="utf-8")
    controller.flight_opener.connect_link(link)
    until(qtbot, lambda: controller.is_open)
    assert window.banners.texts() == () or not any(
        "in use" in one for one in window.banners.texts()
    )
    assert "new tire" in (controller.session.path / "flight.toml").read_text(encoding="utf-8")
    assert "new tire" not in card.read_text(encoding="utf-8")
    controller.recorders.stop_recording_and_wait()


def test_a_connection_that_is_cancelled_keeps_what_came(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    works: list[BackgroundJob] = []
    window.flight_controller.job_started.connect(lambda work, _done: works.append(work))

    def wait(folder: Path, **_options: object) -> Session:
        deadline = time.monotonic() + 20.0
        while not FlightFolder(path=folder).nonempty_raw_files and time.monotonic() < deadline:
            time.sleep(0.01)
        works[0].cancel()
        raise FlightError("not wanted any more")

    monkeypatch.setattr(Session, "follow", wait)
    port = free_port()
    with Aircraft(port):
        window.flight_controller.flight_opener.connect_link(f"udpin:127.0.0.1:{port}")
        until(qtbot, lambda: any(" is in " in text for text in window.banners.texts()))
    assert find_recorders() == []
    (folder,) = (window.flight_controller.flight_opener.next_flight_folder().parent).glob("*")
    assert FlightFolder(path=folder).nonempty_raw_files


@pytest.mark.parametrize("sends", [False, True])
def test_a_connection_that_fails_leaves_no_recorder_behind(
    window: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, sends: bool
) -> None:
    """It ran on unseen, and held the link against the next attempt."""
    controller = window.flight_controller
    card = next_flight_path(window.store.path) / "flight.toml"
    card.parent.mkdir(parents=True, exist_ok=True)
    card.write_text('notes = "new tire"\n', encoding="utf-8")
    follow = Session.follow

    def fail(folder: Path, **_options: object) -> Session:
        deadline = time.monotonic() + 20.0
        while (
            sends
            and not FlightFolder(path=folder).nonempty_raw_files
            and time.monotonic() < deadline
        ):
            time.sleep(0.01)
        raise FlightError("the map was taken away")

    monkeypatch.setattr(Session, "follow", fail)
    port = free_port()
    link = f"udpin:127.0.0.1:{port}"
    with Aircraft(port) if sends else nullcontext():
        controller.flight_opener.connect_link(link)
        until(qtbot, lambda: any("taken away" in text for text in window.banners.texts()))
    assert find_recorders() == []
    kept = list(controller.flight_opener.next_flight_folder().parent.glob("*"))
    assert [FlightFolder(path=one).nonempty_raw_files != () for one in kept] == (
        [True] if sends else []
    )
    assert any("given up is in" in text for text in window.banners.texts()) == sends
    # The card went with the bytes, or waits on.
    assert ("new tire" in card.read_text(encoding="utf-8")) != sends
    monkeypatch.setattr(Session, "follow", follow)
    controller.flight_opener.connect_link(link)
    until(qtbot, lambda: controller.is_open)
    controller.recorders.stop_recording_and_wait()


def test_a_second_connection_joins_the_recorder_of_the_first(
    window: MainWindow, qtbot: QtBot
) -> None:
    controller = window.flight_controller
    link = f"udpin:127.0.0.1:{free_port()}"
    controller.flight_opener.connect_link(link)
    qtbot.wait(20)
    controller.flight_opener.connect_link(link)
    until(qtbot, lambda: controller.is_open)
    qtbot.wait(600)
    assert [handle.folder for handle in find_recorders()] == [controller.session.path.absolute()]
    assert controller.session.recorder.is_alive()
    controller.recorders.stop_recording_and_wait()


def test_the_end_of_heartbeats_is_a_caution_before_the_recording_is_stopped(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where none are sent, there is nothing to say."""
    asked: list[str] = []
    monkeypatch.setattr(
        "ui.file_menu_controller.ask_stop", lambda *given: asked.append(given[-1]) or False
    )
    controller = window.flight_controller
    for name, heartbeat in (("first", True), ("second", False)):
        controller.flight_opener.connect_aircraft(
            ConnectRequest(
                link=f"udpin:127.0.0.1:{free_port()}", folder=tmp_path / "flights" / name,
                channel_map="b777", aircraft="b777", calibration="b777", heartbeat=heartbeat,
            )
        )  # fmt: skip
        until(qtbot, lambda name=name: controller.is_open and controller.name == name)
        recorder = controller.session.equipment
        until(qtbot, lambda monitor=recorder: monitor.recorder.state == "recording")
        if heartbeat:
            until(qtbot, lambda monitor=recorder: monitor.recorder.heartbeats > 0)
        window.file_menu.stop_recording()
        assert bool(asked.pop()) is heartbeat
        controller.recorders.stop_recording_and_wait()
