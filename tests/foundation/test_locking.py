"""Locks, as this system has them and as Windows does."""

import errno
import importlib.util
import os
import sys
import threading
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import gsapp.foundation.file_lock
from gsapp.foundation import FlightError

if sys.platform == "win32":
    pytest.skip("stands for Windows elsewhere", allow_module_level=True)
import fcntl


def _locking(descriptor: int, mode: int, _count: int) -> None:
    modes = {1: fcntl.LOCK_UN, 2: fcntl.LOCK_EX | fcntl.LOCK_NB}
    assert os.lseek(descriptor, 0, os.SEEK_CUR) == 1 << 30
    fcntl.flock(descriptor, modes[mode])


@pytest.fixture(params=["here", "as on Windows"])
def locking(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    if request.param == "here":
        return gsapp.foundation.file_lock
    with monkeypatch.context() as windows:
        windows.setattr(sys, "platform", "win32")
        msvcrt = SimpleNamespace(LK_UNLCK=1, LK_NBLCK=2, locking=_locking)
        windows.setitem(sys.modules, "msvcrt", msvcrt)
        spec = importlib.util.spec_from_file_location(
            "locking_as_on_windows", gsapp.foundation.file_lock.__file__
        )
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def test_one_holds_a_lock_and_its_file_tells_who(locking: ModuleType, tmp_path: Path) -> None:
    path = tmp_path / "lock"
    first, second = locking.FileLock(path), locking.FileLock(path)
    assert locking.lock_holder(path) is None
    assert first.acquire()
    assert not second.acquire(patience=0.05)
    assert locking.lock_holder(path) == os.getpid()
    first.release()
    assert locking.lock_holder(path) is None
    assert second.acquire(patience=0.0)
    second.release()


def test_where_there_are_no_locks_nobody_is_said_to_hold_one(
    locking: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "lock"
    path.write_text("4242")

    def refuse(_descriptor: int, _mode: int) -> None:
        raise OSError(errno.ENOTSUP, "Operation not supported")

    monkeypatch.setattr(fcntl, "flock", refuse)
    assert locking.lock_holder(path) is None
    with pytest.raises(FlightError, match="do not support locks"):
        locking.FileLock(path).acquire()


def test_a_disk_that_fills_up_under_a_lock_does_not_keep_it(
    locking: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock = locking.FileLock(tmp_path / "lock")

    def full(_descriptor: int, _data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr(os, "write", full)
        with pytest.raises(OSError, match="No space"):
            lock.acquire()
    assert locking.lock_holder(tmp_path / "lock") is None
    assert lock.acquire(patience=0.0)
    lock.release()


def test_who_looks_is_not_taken_for_a_holder(
    locking: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "lock"
    path.write_text("4711")
    other = os.open(path, os.O_RDWR)
    assert locking._lock(other, shared=True)
    monkeypatch.setattr(time, "sleep", lambda _: locking._unlock(other))
    assert locking.lock_holder(path) is None
    os.close(other)


def test_who_waits_for_a_file_gets_it_soon_after_it_is_let_go(
    locking: ModuleType, tmp_path: Path
) -> None:
    path = tmp_path / "events.jsonl"
    path.touch()
    let_go: list[float] = []

    def hold() -> None:
        descriptor = os.open(path, os.O_RDWR)
        with locking.exclusive_lock(descriptor):
            holds.set()
            time.sleep(0.1)
            let_go.append(time.monotonic())
        os.close(descriptor)

    holds = threading.Event()
    thread = threading.Thread(target=hold)
    thread.start()
    assert holds.wait(5.0)
    descriptor = os.open(path, os.O_RDWR)
    with locking.exclusive_lock(descriptor):
        assert let_go
        assert time.monotonic() - let_go[0] < 0.5
    os.close(descriptor)
    thread.join()
