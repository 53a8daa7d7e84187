"""A flight folder that is removed, renamed or replaced under its recorder: nothing is lost."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Self

import pytest

from gsapp.decoding.framing import Framer
from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.raw_files import FRAMES_FILE, RawTail, RawWriter
from gsapp.foundation import FlightError
from gsapp.telemetry.recorder_control import find_recorder, find_recorders
from gsapp.telemetry.recorder_folder import next_free_folder, record_state
from gsapp.telemetry.recorder_process import record_link
from gsapp.telemetry.recorder_status import RecorderStatus

pytestmark = [
    pytest.mark.usefixtures("own_runtime"),
    pytest.mark.skipif(os.name == "nt", reason="Windows does not let go of files that are open"),
]

NOTICED = 2.0
"""Seconds within which the recorder goes on elsewhere."""


def frames_in(folder: Path) -> list[bytes]:
    return [item.data for item in RawTail(folder).poll()]


class Recording:
    """A recorder in a thread, and an aircraft that sends it numbered frames."""

    def __init__(self, folder: Path, port: int, frames: list[bytes]) -> None:
        self.folder = folder
        self._port = port
        self._frames = iter(frames)
        self._stop = threading.Event()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sent: list[bytes] = []
        self.last: RecorderStatus | None = None
        self._thread = threading.Thread(target=self._record)

    def _record(self) -> None:
        self.last = record_link(f"udpin:127.0.0.1:{self._port}", self.folder, stop=self._stop)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._socket.close()

    def send(self, count: int) -> None:
        for _ in range(count):
            self.sent.append(next(self._frames))
            self._socket.sendto(self.sent[-1], ("127.0.0.1", self._port))
            time.sleep(0.001)

    def stop(self) -> RecorderStatus:
        self._stop.set()
        self._thread.join(20)
        assert not self._thread.is_alive()
        assert self.last is not None
        return self.last


@pytest.fixture
def recording(tmp_path: Path, frames, port, patience) -> Iterator[Recording]:
    folder = tmp_path / "flight"
    prepare_flight_folder(folder, aircraft="b777", channel_map="b777")
    with Recording(folder, port(socket.SOCK_DGRAM), frames(400)) as running:
        patience(lambda: find_recorder(folder) and (folder / "recorder.json").exists())
        running.send(50)
        patience(lambda: len(frames_in(folder)) == 50)
        # The settings were read once.
        time.sleep(0.6)
        yield running


def replace(folder: Path) -> None:
    folder.rename(folder.with_name("away"))
    folder.mkdir()


@pytest.mark.parametrize(
    "harm",
    [
        shutil.rmtree,
        lambda folder: folder.rename(folder.with_name("away")),
        replace,
        lambda folder: (folder / FRAMES_FILE).unlink(),
    ],
    ids=["removed", "renamed", "replaced", "raw file removed"],
)
def test_a_record_whose_folder_is_gone_goes_on_beside_it_with_everything(
    recording: Recording, patience, harm: Callable[[Path], object]
) -> None:
    folder, beside = recording.folder, recording.folder.with_name("flight-2")
    harm(folder)
    began = time.monotonic()
    recording.send(20)
    patience(lambda: len(frames_in(beside)) == 70 if beside.is_dir() else False)
    assert time.monotonic() - began < NOTICED
    recording.send(30)
    patience(lambda: len(frames_in(beside)) == 100)
    assert frames_in(beside) == recording.sent
    # Whoever knows the former name finds the recorder, once, and can stop it.
    patience(lambda: len(find_recorders()) == 1 and find_recorders()[0].folder == beside)
    handle = find_recorder(folder)
    assert handle.folder == beside
    # The record can be read as the one before.
    assert FlightFolder(path=beside).aircraft() is not None
    assert FlightFolder(path=beside).channel_map_file.is_file()
    assert handle.stop()
    status = recording.stop()
    assert (status.folder, status.moved_from) == (str(beside), str(folder))
    assert (status.frames, status.unwritten_frames, status.dropped_bytes) == (100, 0, 0)
    assert find_recorders() == []


def test_a_folder_removed_in_the_last_moment_is_kept_too(recording: Recording) -> None:
    shutil.rmtree(recording.folder)
    status = recording.stop()
    assert frames_in(Path(status.folder)) == recording.sent
    assert status.unwritten_frames == 0


def test_what_is_in_removed_files_alone_is_counted_as_lost(tmp_path: Path, frames) -> None:
    framer, writer = Framer(), RawWriter(tmp_path / "flight")
    writer.append(1, framer.feed(b"".join(frames(5))))
    shutil.rmtree(tmp_path / "flight")
    assert not writer.is_folder_writable()
    writer.close()
    assert writer.state.unwritten[FRAMES_FILE] == writer.state.frames == 5
    assert writer.state.lost_bytes > 0


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write all")
def test_a_folder_made_read_only_is_left(recording: Recording, patience) -> None:
    recording.folder.chmod(0o555)
    recording.send(10)
    beside = recording.folder.with_name("flight-2")
    patience(lambda: beside.is_dir() and len(frames_in(beside)) == 60)
    recording.folder.chmod(0o755)


@pytest.mark.parametrize("room_beside", [True, pytest.param(False, marks=pytest.mark.long)])
def test_the_command_fails_and_counts_what_reached_the_disk(
    tmp_path: Path, frames, port, patience, room_beside: bool
) -> None:
    """Without room beside the folder it waits, says so, and gives up when asked again."""
    number, folder = port(socket.SOCK_DGRAM), tmp_path / "day" / "flight"
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "gsapp.cli", "record", f"udpin:127.0.0.1:{number}",
         "--out", str(folder)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        patience((folder / "recorder.json").exists)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            for frame in frames(60):
                link.sendto(frame, ("127.0.0.1", number))
                time.sleep(0.001)
        patience(lambda: len(frames_in(folder)) == 60)
        if room_beside:
            shutil.rmtree(folder)
            patience(lambda: folder.with_name("flight-2").is_dir())
        else:
            shutil.rmtree(folder.parent)
            folder.parent.touch()
        process.send_signal(signal.SIGINT)
        words = ""
        if not room_beside:
            for line in process.stdout:
                words += line
                if "The recording ended" in line:
                    break
            assert "beside it" in words
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
        words += process.communicate(timeout=20)[0]
    finally:
        process.kill()
    assert process.returncode == 1
    assert "60 of 60 frames" in " ".join(words.split())
    assert f"Recorded {60 if room_beside else 0} frames" in words
    if room_beside:
        assert len(frames_in(folder.with_name("flight-2"))) == 60


def test_a_folder_tells_whether_its_flight_is_finished(
    tmp_path: Path, frames, port, patience
) -> None:
    folder = tmp_path / "flight"
    assert record_state(folder) == "none"
    with Recording(folder, port(socket.SOCK_DGRAM), frames(20)) as running:
        patience((folder / "recorder.json").exists)
        running.send(20)
        patience(lambda: len(frames_in(folder)) == 20)
        assert record_state(folder) == "recording"
        cut_off = (folder / "recorder.json").read_bytes()
    assert record_state(folder) == "finished"
    (folder / "recorder.json").write_bytes(cut_off)
    assert record_state(folder) == "interrupted"
    (folder / "recorder.json").unlink()
    assert record_state(folder) == "finished"
    assert next_free_folder(folder) == tmp_path / "flight-2"
    # An imported flight holds the log of another program.
    imported = tmp_path / "imported"
    prepare_flight_folder(imported)
    assert record_state(imported) == "none"
    log = tmp_path / "00000012.BIN"
    log.write_bytes(b"log")
    FlightFolder(path=imported).store_onboard_log(log)
    assert record_state(imported) == "finished"


def test_the_command_appends_to_a_finished_flight_only_when_asked(
    tmp_path: Path, frames, capsys
) -> None:
    from gsapp.cli.record import record

    source, out = tmp_path / "source", tmp_path / "out"
    writer, framer = RawWriter(source), Framer()
    for index, frame in enumerate(frames(20)):
        writer.append(1_000_000 + index * 1000, framer.feed(frame) + framer.flush_complete())
    writer.close()
    record(str(source), out, speed=1000.0)
    with pytest.raises(FlightError, match="--continue"):
        record(str(source), out, speed=1000.0)
    assert len(frames_in(out)) == 20
    record(str(source), out, speed=1000.0, append=True)
    assert len(frames_in(out)) == 40
    # A recorder that died is continued without being asked, which is said.
    status = (out / "recorder.json").read_text()
    (out / "recorder.json").write_text(status.replace('"stopped"', '"recording"'))
    capsys.readouterr()
    record(str(source), out, speed=1000.0)
    assert "ended unexpectedly" in capsys.readouterr().out
    assert len(frames_in(out)) == 60
