"""The thread that reads a flight's files: what it knows once the whole program stood still."""

import threading
import time

from gsapp.session.file_worker import FileWorker
from gsapp.session.monitor_settings import MONITORS


def test_what_was_read_before_a_standstill_is_outdated_until_it_is_read_again() -> None:
    worker, may_read, reads = FileWorker(), threading.Event(), []
    may_read.set()

    def read() -> None:
        may_read.wait(10.0)
        reads.append(time.monotonic())

    worker.repeat(read)
    worker.start()
    while len(reads) < 2:
        time.sleep(0.001)
    assert not worker.is_outdated
    may_read.clear()
    time.sleep(0.05)
    worker.note_standstill()
    assert worker.is_outdated
    assert worker.seconds_waiting < MONITORS.disk_timeout
    before = len(reads)
    may_read.set()
    while worker.is_outdated:
        time.sleep(0.001)
    assert len(reads) >= before + 2
    worker.close()


def test_a_disk_that_hangs_after_a_standstill_is_known_to_hang(monkeypatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    worker = FileWorker()
    worker.note_standstill()
    assert worker.is_outdated
    now += MONITORS.disk_timeout + 0.1
    assert not worker.is_outdated
    assert worker.seconds_waiting > MONITORS.disk_timeout
