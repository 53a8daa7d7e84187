"""A disk that does not answer, or takes long, does not hold up the window."""

import ctypes
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Timer

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QFileDialog, QPushButton
from pytestqt.qtbot import QtBot

from gsapp.flight.events import read_events
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.toml_document import FlightInfoFile
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.session.limits import Severity
from tests.ui.fuse_disk import FuseDisk
from tests.ui.window_kit import Aircraft, connect, free_port, open_window, until
from ui.dialogs.file_dialogs import ask_save_file
from ui.dialogs.form_dialog import PathField
from ui.disk_checks import path_kind
from ui.main_window import MainWindow
from ui.preflight.form_editor import FormEditor

_LONGEST = 1.5
"""Seconds between two ticks: what the window waits for a disk, and drawing on a busy machine."""


class StuckDisk:
    """A file system of which nothing answers any more, as a network drive whose server is gone."""

    def __init__(self, place: Path) -> None:
        place.mkdir(parents=True)
        self.place = place
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._server = os.open("/dev/fuse", os.O_RDWR)
        options = f"fd={self._server},rootmode=40755,user_id=0,group_id=0"
        if self._libc.mount(b"stuck", bytes(place), b"fuse", 0, options.encode()) != 0:
            os.close(self._server)
            raise PermissionError(ctypes.get_errno())

    def end(self) -> None:
        os.close(self._server)
        self._libc.umount2(bytes(self.place), 2)


@pytest.fixture
def stuck(tmp_path: Path) -> Iterator[Path]:
    try:
        disk = StuckDisk(tmp_path / "mounted" / "stuck")
    except OSError:
        pytest.skip("only root may mount a file system")
    yield disk.place
    disk.end()


class Ticks:
    def __init__(self) -> None:
        self.longest = 0.0
        self._last = time.monotonic()
        self._timer = QTimer(interval=5)
        self._timer.timeout.connect(self._tick)
        self._timer.start()

    def _tick(self) -> None:
        now = time.monotonic()
        self.longest = max(self.longest, now - self._last)
        self._last = now


@pytest.fixture
def make(qtbot: QtBot, tmp_path: Path, alone: None) -> Iterator[Callable[..., MainWindow]]:
    made: list[MainWindow] = []

    def window(**settings: object) -> MainWindow:
        one = open_window(tmp_path, **settings)
        qtbot.addWidget(one)
        qtbot.wait(50)
        made.append(one)
        return one

    yield window
    for one in made:
        one.flight_controller.close()


def longest_gap(qtbot: QtBot, act: Callable[[], object], milliseconds: int = 700) -> float:
    ticks = Ticks()

    def close() -> None:
        dialog = QApplication.activeModalWidget()
        if dialog is not None:
            dialog.close()

    QTimer.singleShot(0, act)
    QTimer.singleShot(milliseconds - 100, close)
    qtbot.wait(milliseconds)
    return ticks.longest


def test_a_stuck_disk_is_told_within_a_moment(stuck: Path, tmp_path: Path) -> None:
    begin = time.monotonic()
    assert path_kind(stuck / "flight") == "stuck"
    assert time.monotonic() - begin < 0.5
    begin = time.monotonic()
    assert path_kind(stuck / "flight" / "raw.tlog") == "stuck"
    assert time.monotonic() - begin < 0.05
    assert path_kind(tmp_path) == "folder"
    assert path_kind(tmp_path / "none") == "missing"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert path_kind(tmp_path / "pipe") == "special"


@pytest.mark.parametrize("name", ["raw.tlog", "flight.toml", "events.jsonl", "aircraft.toml"])
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_in_a_flight_folder_is_refused(
    make: Callable[..., MainWindow], qtbot: QtBot, tmp_path: Path, name: str
) -> None:
    folder = FlightFolder.create(tmp_path / "flight", FlightInfo(name="x")).path
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    window = make()
    assert (
        longest_gap(qtbot, lambda: window.flight_controller.flight_opener.open_flight(folder))
        < _LONGEST
    )
    until(qtbot, lambda: window.error_reporter.last_report is not None)
    assert name in window.error_reporter.last_report.message
    assert not window.flight_controller.is_open


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_opening_what_never_answers_can_be_cancelled(
    make: Callable[..., MainWindow], qtbot: QtBot, tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "endless.csv")
    window = make()
    starter = window.flight_controller.flight_opener
    cancelled: list[bool] = []
    starter.job_started.connect(
        lambda work, _done: work.canceled.connect(lambda: cancelled.append(True))
    )
    gap = longest_gap(qtbot, lambda: starter.open_flight(tmp_path / "endless.csv"))
    assert gap < _LONGEST
    starter.cancel()
    until(qtbot, lambda: bool(cancelled), 4000)
    # Another flight opens meanwhile.
    block = Block(channels=("alpha",), times=np.arange(100) / 50.0, values=np.zeros((100, 1)))
    starter.open_flight(write_flight_csv(tmp_path / "good.csv", block, "us"))
    until(qtbot, lambda: window.flight_controller.is_open)
    assert window.flight_controller.name == "good"


def test_a_flight_on_a_stuck_disk_leaves_the_window_alive(
    make: Callable[..., MainWindow], qtbot: QtBot, stuck: Path
) -> None:
    window = make()
    assert (
        longest_gap(qtbot, lambda: window.flight_controller.flight_opener.open_flight(stuck / "f"))
        < _LONGEST
    )


@pytest.mark.parametrize(
    "command", ["connect", "virtual", "open_file", "open_folder", "place_gap", "place_preflight"]
)
def test_what_is_remembered_of_a_stuck_disk_leaves_the_window_alive(
    make: Callable[..., MainWindow], qtbot: QtBot, stuck: Path, command: str
) -> None:
    lost = {
        "flights": str(stuck / "flights"),
        "folder": str(stuck / "folder"),
        "aircraft": str(stuck / "mine.toml"),
        "calibration": str(stuck / "mine"),
        "gap_flights": (str(stuck / "a"), str(stuck / "b")),
        "gap_aircraft": str(stuck / "mine.toml"),
    }
    first = make()  # what is imported and drawn for the first time takes as long as it takes
    longest_gap(qtbot, first.commands.actions[command].trigger)
    window = make(**lost)
    gap = longest_gap(qtbot, window.commands.actions[command].trigger, 1000)
    assert gap < 2 * _LONGEST


def test_a_flight_begins_in_the_usual_folder_where_the_other_is_stuck(
    make: Callable[..., MainWindow], stuck: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ui.settings.default_flights_folder", lambda: tmp_path / "usual")
    window = make(flights=str(stuck / "flights"))
    said: list[tuple[str, str]] = []
    window.flight_controller.message_posted.connect(lambda *words: said.append(words))
    assert window.flight_controller.flight_opener.next_flight_folder().parent == tmp_path / "usual"
    assert said[0][0] == "caution"
    assert window.store.current.flights == str(stuck / "flights")


def test_a_folder_of_many_files_and_a_long_table_leave_the_window_alive(
    make: Callable[..., MainWindow], qtbot: QtBot, tmp_path: Path
) -> None:
    crowded = tmp_path / "crowded"
    crowded.mkdir()
    for number in range(20_000):
        (crowded / f"{number}.csv").touch()
    window = make()
    gap = longest_gap(qtbot, lambda: window.flight_controller.flight_opener.open_flight(crowded))
    until(qtbot, lambda: window.error_reporter.last_report is not None)
    assert isinstance(window.error_reporter.last_report.details, str)
    assert gap < _LONGEST


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_among_the_certificates_is_refused(
    make: Callable[..., MainWindow], qtbot: QtBot, tmp_path: Path
) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    os.mkfifo(folder / "alpha.toml")
    make().commands.actions["place_preflight"].trigger()  # loads what is imported
    window = make(calibration=str(folder))
    assert longest_gap(qtbot, window.commands.actions["place_preflight"].trigger) < _LONGEST
    state = window.preflight_page.model.step_states()["calibration"]
    assert (state.text, "alpha.toml" in state.detail) == ("cannot be read", True)


@pytest.mark.parametrize("kind", ["save", "folder", "file"])
def test_a_file_dialog_does_not_begin_on_a_disk_that_stops(
    qtbot: QtBot, disk: FuseDisk, make: Callable[..., MainWindow], kind: str
) -> None:
    window, there = make(), disk.place / "flights"
    there.mkdir()
    field = PathField("Flights", window.display_style, folder=kind == "folder")
    field.edit.setText(str(there / "new.csv"))
    acts: dict[str, Callable[[], object]] = {
        "save": lambda: ask_save_file(window, "Export", there / "new.csv", "Table (*.csv)"),
        "folder": field.findChild(QPushButton).click,
        "file": field.findChild(QPushButton).click,
    }
    longest_gap(qtbot, lambda: QFileDialog.getExistingDirectory(window))  # the first takes longer
    disk.stop()
    Timer(3.0, disk.go_on).start()
    assert longest_gap(qtbot, acts[kind], 1000) < _LONGEST


def test_the_card_of_a_flight_on_a_disk_that_stops_does_not_hold_up_preflight(
    make: Callable[..., MainWindow], qtbot: QtBot, disk: FuseDisk
) -> None:
    folder = FlightFolder.create(disk.place / "flight", FlightInfo(name="x"))
    editor = FormEditor(FlightInfoFile(folder))
    disk.stop()
    assert longest_gap(qtbot, editor.reload_if_changed) < _LONGEST
    with pytest.raises(FlightError, match="respond"):
        editor.save()


def test_a_folder_of_its_own_says_what_is_wrong(tmp_path: Path) -> None:
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes")
    folder = FlightFolder.create(tmp_path / "flight", FlightInfo(name="x"))
    folder.info_file.unlink()
    os.mkfifo(folder.info_file)
    with pytest.raises(FlightError, match=r"flight\.toml"):
        FlightFolder.open(folder.path)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[FuseDisk]:
    try:
        made = FuseDisk(tmp_path / "disk")
    except OSError:
        pytest.skip("only root may mount a file system")
    yield made
    made.go_on()
    made.end()


@pytest.mark.parametrize("mode", ["live", "replay"])
def test_an_open_flight_survives_a_disk_that_stops_and_goes_on(
    make: Callable[..., MainWindow], qtbot: QtBot, disk: FuseDisk, mode: str
) -> None:
    window, folder, port = make(), disk.place / "flight", free_port()
    controller = window.flight_controller
    with Aircraft(port):
        connect(window, port, folder)
        until(qtbot, lambda: (controller.time or 0.0) > 3.0, 20_000)
        if mode == "replay":
            controller.recorders.stop_recording_and_wait()
            controller.close_flight()
            controller.flight_opener.open_flight(folder)
            until(qtbot, lambda: controller.is_loaded)
        qtbot.wait(1000)
        disk.stop()
        gap = longest_gap(qtbot, lambda: controller.mark(1.0, "stuck"), 3000)
        assert gap < _LONGEST
        # Nobody has to wait to see the mark, and the window says why nothing moves.
        assert [mark.text for mark in controller.session.marks] == ["stuck"]
        assert any("does not respond" in text for text in window.banners.texts())
        before = controller.time
        if mode == "live":
            assert controller.session.equipment.disk.severity is Severity.WARNING
            assert controller.session.equipment.link.state == "not read"
        disk.go_on()
        until(qtbot, lambda: not any("does not respond" in t for t in window.banners.texts()))
        if mode == "live":
            until(
                qtbot, lambda: controller.time > before + 3.0 and controller.session.feed.caught_up
            )
            until(qtbot, lambda: controller.session.equipment.disk.severity is Severity.NORMAL)
            until(qtbot, lambda: controller.session.equipment.link.state == "ok")
        qtbot.wait(300)
        assert [mark.text for mark in controller.session.marks] == ["stuck"]
        written = [one for one in read_events(folder / "events.jsonl").events if one.kind == "mark"]
        assert [one.text for one in written] == ["stuck"]
        controller.recorders.stop_recording_and_wait()


def test_looking_for_recorders_does_not_wait_for_the_disk_of_one(
    make: Callable[..., MainWindow], qtbot: QtBot, disk: FuseDisk
) -> None:
    window, port = make(), free_port()
    connect(window, port, disk.place / "flight")
    until(qtbot, lambda: window.flight_controller.is_recording, 20_000)
    window.flight_controller.close_flight()
    until(qtbot, lambda: len(window.flight_controller.recorders.others) == 1)
    disk.stop()
    assert longest_gap(qtbot, window.file_menu.offer_recorders) < _LONGEST
    # Known from the last look.
    assert [
        found.name
        for found in window.flight_controller.recorders.left_running
        and window.flight_controller.recorders.others
    ] == ["flight"]
    assert longest_gap(qtbot, window.close) < _LONGEST
    disk.go_on()
    for found in window.flight_controller.recorders.others:
        found.handle.stop()
