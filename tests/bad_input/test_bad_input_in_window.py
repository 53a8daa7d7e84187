"""What the command line refuses, the window tells in a banner, and goes on."""

import random
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

import ui.main_window
from gsapp.flight import load_flight
from gsapp.flight.folder_setup import prepare_flight_folder
from tests.bad_input.bad_input_kit import is_running, use_endless_reader, use_reader
from tests.ui.window_kit import open_window, until, write_flight
from ui.background_job import BackgroundJob
from ui.dialogs.flight_requests import ConnectRequest
from ui.main_window import MainWindow


@pytest.fixture
def window(qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MainWindow]:
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "run"))
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
    made = open_window(tmp_path)
    qtbot.addWidget(made)
    yield made
    made.flight_controller.close()


def told(window: MainWindow, *words: str) -> bool:
    return any(all(word in text for word in words) for text in window.banners.texts())


def test_damaged_files_are_told_and_the_next_flight_opens(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    facts = prepare_flight_folder(tmp_path / "facts", channel_map="b777").path
    (facts / "flight.toml").write_text('takeoff_weigth = "3 lb"\n')
    window.flight_controller.flight_opener.open_flight(facts)
    until(qtbot, lambda: told(window, "flight.toml", "did you mean 'takeoff_weight'?"))
    mapped = prepare_flight_folder(tmp_path / "mapped", channel_map="b777").path
    text = (mapped / "channel_map.toml").read_text()
    (mapped / "channel_map.toml").write_text(text.replace('id = "alpha"', 'id = "alhpa"'))
    window.flight_controller.flight_opener.open_flight(mapped)
    until(qtbot, lambda: told(window, "channel_map.toml", "did you mean 'alpha'"))
    assert not window.flight_controller.is_open
    window.flight_controller.flight_opener.open_flight(write_flight(tmp_path), playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)


def test_a_log_of_nothing_is_no_flight(window: MainWindow, qtbot: QtBot, tmp_path: Path) -> None:
    """Neither charts nor the offer of a channel map, which would not help."""
    garbage = tmp_path / "garbage.tlog"
    garbage.write_bytes(random.Random(3).randbytes(5000))
    window.flight_controller.flight_opener.open_flight(garbage)
    until(qtbot, lambda: told(window, "holds no MAVLink message"))
    assert not window.flight_controller.is_open
    assert not told(window, "map")


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_a_reader_that_crashes_is_told_and_the_window_goes_on(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_reader(monkeypatch, tmp_path, "os.kill(os.getpid(), signal.SIGSEGV)")
    damaged = tmp_path / "damaged.mat"
    damaged.write_bytes(b"MATLAB 5.0")
    window.flight_controller.flight_opener.open_flight(damaged)
    until(qtbot, lambda: told(window, "damaged.mat", "SIGSEGV"))
    assert not window.flight_controller.is_open


def test_a_canceled_job_ends_the_process_that_reads(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    note = use_endless_reader(monkeypatch, tmp_path)
    (tmp_path / "f.mat").write_bytes(b"MATLAB 5.0")
    job = BackgroundJob("Opening", lambda _progress: load_flight(tmp_path / "f.mat"))
    shares: list[object] = []
    job.progressed.connect(lambda share, _text: shares.append(share))
    job.start()
    until(qtbot, lambda: 0.5 in shares)
    with qtbot.waitSignal(job.canceled):
        job.cancel()
    assert not is_running(int(note.read_text()))


def test_a_recording_in_which_nothing_arrived_opens(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    window.flight_controller.flight_opener.open_flight(
        prepare_flight_folder(tmp_path / "silent", channel_map="b777").path
    )
    until(qtbot, lambda: window.flight_controller.is_loaded)
    until(qtbot, lambda: told(window, "his flight contains no record"))
    picture = window.crew.view_state()
    assert "no samples" in picture.empty_text


def test_an_aircraft_with_mistakes_is_told_before_anything_is_made(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text('name = "mine"\n[geometry]\nspam = "3 ft"\n')
    window.flight_controller.flight_opener.connect_aircraft(
        ConnectRequest(
            link="udpin:127.0.0.1:14597", folder=tmp_path / "new", channel_map="b777",
            aircraft=str(tmp_path / "mine.toml"), calibration="b777",
        )
    )  # fmt: skip
    until(qtbot, lambda: told(window, "mine.toml", "geometry.spam", "did you mean 'span'?"))
    assert not window.flight_controller.is_open
    assert not (tmp_path / "new").exists()
