"""Other users of the same computer: what they can read, hold and plant."""

import fcntl
import json
import os
import socket
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import platformdirs
import pytest

from gsapp.flight.events import Event, EventLog, events_path
from gsapp.flight.file_names import LOCK_FILE, STATUS_FILE
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.foundation import file_lock
from gsapp.foundation.file_lock import FileLock, lock_holder
from gsapp.telemetry.recorder_control import find_recorders, start_recorder
from gsapp.telemetry.recorder_status import (
    RUNTIME_VARIABLE,
    read_status,
    runtime_folder,
    runtime_folder_note,
)
from tests.telemetry.conftest import free_port, wait_until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="users and modes of POSIX")

NOBODY = 65534
needs_root = pytest.mark.skipif(
    sys.platform == "win32" or os.getuid() != 0, reason="only root can be another user"
)


@pytest.fixture
def umask() -> Iterator[Callable[[int], None]]:
    former = os.umask(0o022)
    yield lambda mask: os.umask(mask) and None
    os.umask(former)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a private folder in which the state of programs is kept."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path


def open_to_group(folder: Path) -> None:
    folder.chmod(0o770)


def give_away(folder: Path) -> None:
    os.chown(folder, NOBODY, NOBODY)


@pytest.mark.parametrize(
    "spoil", [open_to_group, pytest.param(give_away, marks=needs_root)], ids=["group", "owner"]
)
def test_a_foreign_runtime_folder_is_not_used_and_the_recording_says_so(
    spoil: Callable[[Path], None], home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It records all the same, and every window finds it."""
    usual = home / "runtime"
    (usual / "recorders").mkdir(parents=True, mode=0o700)
    monkeypatch.setenv(RUNTIME_VARIABLE, str(usual))
    assert runtime_folder() == usual / "recorders"
    assert runtime_folder_note() == ""
    spoil(usual)
    other = Path(platformdirs.user_state_dir("gsapp", appauthor=False)) / "recorders"
    assert runtime_folder() == other
    assert other.is_relative_to(home)
    flight = home / "flight"
    recorder = start_recorder(f"udpin:127.0.0.1:{free_port(socket.SOCK_DGRAM)}", flight)
    status = wait_until(recorder.status)
    assert [str(usual / "recorders") in note for note in status.notes] == [True]
    assert recorder in find_recorders()
    recorder.stop()
    assert list((usual / "recorders").iterdir()) == []
    assert not any(other.glob("*.json"))


@needs_root
def test_a_note_that_another_user_planted_is_no_recorder(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = home / "runtime" / "recorders"
    usual.mkdir(parents=True, mode=0o700)
    monkeypatch.setenv(RUNTIME_VARIABLE, str(usual.parent))
    note = {"pid": 1, "link": "virtual", "folder": "/", "state": "recording", "started_us": 0}
    (usual / "planted.json").write_text(json.dumps({**note, "updated_us": 0}))
    give_away(usual)
    assert find_recorders() == []
    assert (usual / "planted.json").exists()  # nor is it touched


@pytest.mark.parametrize(("mask", "file", "folder"), [
    (0o022, 0o640, 0o750), (0o002, 0o660, 0o770), (0o077, 0o600, 0o700), (0o000, 0o660, 0o770),
])  # fmt: skip
def test_a_flight_is_for_user_and_group(
    mask: int, file: int, folder: int, umask: Callable[[int], None], tmp_path: Path,
    own_runtime: Path,
) -> None:  # fmt: skip
    """Nobody else enters its folder, and what is recorded is closed to them by itself."""
    umask(mask)
    port, flight = free_port(socket.SOCK_DGRAM), tmp_path / "flight"
    prepare_flight_folder(flight, aircraft="b777", channel_map="b777", source="udpin")
    recorder = start_recorder(f"udpin:127.0.0.1:{port}", flight)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"no frame at all", ("127.0.0.1", port))
    wait_until(lambda: (status := recorder.status()) is not None and status.residue_bytes)
    EventLog(events_path(flight)).append(Event(kind="mark", text="a mark"))
    recorder.stop()
    assert stat.S_IMODE(flight.stat().st_mode) == folder
    for name in ("residue.bin", "events.jsonl", STATUS_FILE, "recorder.log"):
        assert stat.S_IMODE((flight / name).stat().st_mode) == file, name
    # A lock is only for those who may write it.
    lock = stat.S_IMODE((flight / LOCK_FILE).stat().st_mode)
    assert lock == (0o660 if folder == 0o770 else 0o600)


def can_nobody_hold(path: Path) -> bool:
    """Return whether another user can take the lock of a file that it opens for reading."""
    child = os.fork()
    if child == 0:
        try:
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
            fcntl.flock(os.open(path, os.O_RDONLY), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os._exit(1)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@needs_root
def test_a_user_who_can_only_read_cannot_hold_the_lock_of_a_flight() -> None:
    """Not even a lock file that an earlier version left readable, in a folder for everyone."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        path = Path(folder) / LOCK_FILE
        path.write_text("1")
        path.chmod(0o644)
        assert can_nobody_hold(path)
        lock = FileLock(path)
        assert lock.acquire()
        lock.release()
        assert not can_nobody_hold(path)
        assert lock.acquire(patience=0.0)
        assert lock_holder(path) == os.getpid()
        lock.release()


def test_marks_are_written_though_a_reader_holds_the_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lock on the open file is all that a reader needs; waiting for it would lose the mark."""
    monkeypatch.setattr(file_lock, "_PATIENCE", 0.2)
    log = EventLog(tmp_path / "events.jsonl")
    log.append(Event(kind="mark", text="before"))
    reader = os.open(tmp_path / "events.jsonl", os.O_RDONLY)
    fcntl.flock(reader, fcntl.LOCK_EX)
    begun = time.monotonic()
    log.append(Event(kind="mark", text="meanwhile"))
    os.close(reader)
    assert time.monotonic() - begun < 5.0
    assert len((tmp_path / "events.jsonl").read_text().splitlines()) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_recorder_listens_on_its_link_alone(tmp_path: Path, own_runtime: Path) -> None:
    """No socket of the file system, and no port beside that of the link."""
    port = free_port(socket.SOCK_STREAM)
    recorder = start_recorder(f"tcpin:127.0.0.1:{port}", tmp_path / "flight")
    links = [str(one.readlink()) for one in Path(f"/proc/{recorder.pid}/fd").iterdir()]
    inodes = {link[8:-1] for link in links if link.startswith("socket:")}
    listening = [
        line.split()[1]
        for kind in ("tcp", "tcp6", "udp", "udp6")
        for line in Path(f"/proc/{recorder.pid}/net/{kind}").read_text().splitlines()[1:]
        if line.split()[9] in inodes
    ]
    assert listening == [f"0100007F:{port:04X}"]
    named = [
        line
        for line in Path("/proc/net/unix").read_text().splitlines()[1:]
        if line.split()[6] in inodes and len(line.split()) > 7
    ]
    assert named == []
    folders = (tmp_path, own_runtime)
    assert not any(one.is_socket() for folder in folders for one in folder.rglob("*"))
    assert read_status(tmp_path / "flight" / STATUS_FILE) is not None
    recorder.stop()
