"""The thread that reads a flight's files: what it knows once the whole program stood still."""

import threading
import time

from gsapp.session.file_worker import FileWorker
from gsapp.session.monitor_settings import MONITORS


def test_what_was_read_before_a_standstill_is_outdated_until_it_is_read_again(monkeypatch) -> None:
    ahead, real = 0.0, time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: real() + ahead)
    worker, may_read, reads = FileWorker(), threading.Event(), []
    may_read.set()

    def read() -> None:
        may_read.wait(10.0)
        reads.append(time.monotonic())

    worker.repeat(read)
    worker.start()
    while len(reads) < 2:
        time.sleep(0.001)
    assert not worker.check_update_gap()
    assert not worker.check_update_gap()
    may_read.clear()
    time.sleep(0.05)
    ahead = MONITORS.max_update_gap + 0.1
    assert worker.check_update_gap()
    assert worker.seconds_waiting < MONITORS.disk_timeout
    before = len(reads)
    may_read.set()
    while worker.check_update_gap():
        time.sleep(0.001)
    assert len(reads) > before
    worker.close()


def test_updates_that_are_rare_do_not_outdate_what_is_read_meanwhile() -> None:
    worker, reads = FileWorker(), []
    worker.repeat(lambda: reads.append(1))
    worker.start()
    worker.check_update_gap()
    time.sleep(MONITORS.max_update_gap + 0.1)
    assert len(reads) > 20
    assert not worker.check_update_gap()
    worker.close()


def test_a_disk_that_hangs_after_a_standstill_is_known_to_hang(monkeypatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    worker = FileWorker()
    assert not worker.check_update_gap()
    now += MONITORS.max_update_gap + 0.1
    assert worker.check_update_gap()
    for _ in range(3):  # no standstill, but a disk that does not answer
        worker.check_update_gap()
        now += MONITORS.max_update_gap - 0.1
    assert not worker.check_update_gap()
    assert worker.seconds_waiting > MONITORS.disk_timeout
