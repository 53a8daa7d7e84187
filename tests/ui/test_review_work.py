"""The jobs of the review: one after the other, stopped whole, and told to nobody too late."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from pytestqt.qtbot import QtBot

from ui.background_job import JobCanceledError
from ui.job_process.job_runner import JobError
from ui.review.job_queue import JobQueue
from ui.review.review_jobs import RepeatJob


def job(number: int) -> RepeatJob:
    return RepeatJob(catalog=Path("c.sqlite"), number=number)


class Slow:
    """Does a job when it is let go; number 13 fails."""

    def __init__(self) -> None:
        self.done: list[int] = []
        self.go = threading.Event()

    def do(self, asked: Any, tell: Callable[[float | None, str], object]) -> int:
        tell(0.5, "half")
        while not self.go.is_set():
            tell(0.5, "half")
            time.sleep(0.002)
        if asked.number == 13:
            raise JobError("run 13 is not there")
        self.done.append(asked.number)
        return int(asked.number)

    def close(self) -> None:
        self.go.set()


@pytest.fixture
def desk(qtbot: QtBot) -> SimpleNamespace:
    engine, errors = Slow(), []
    work = JobQueue(engine, errors.append)
    ended: list[tuple[str, str]] = []
    work.ended.connect(lambda title, how: ended.append((title, how)))
    return SimpleNamespace(engine=engine, work=work, errors=errors, ended=ended, results=[])


def test_jobs_are_done_in_order_and_one_asked_for_twice_only_once(desk, qtbot):
    for number in (1, 2, 1, 2):
        desk.work.submit(job(number), desk.results.append)
    assert desk.work.title == "Repeating run 1"
    desk.engine.go.set()
    qtbot.waitUntil(lambda: not desk.work.running)
    assert desk.engine.done == [1, 2]
    assert desk.results == [1, 1, 2, 2]
    assert desk.ended == [("Repeating run 1", "done"), ("Repeating run 2", "done")]


def test_a_stop_ends_what_runs_and_what_waits_and_the_next_job_works(desk, qtbot):
    why: list[BaseException] = []
    for number in (1, 2):
        desk.work.submit(job(number), desk.results.append, failed=why.append)
    desk.work.cancel()
    qtbot.waitUntil(lambda: not desk.work.running)
    assert [type(one) for one in why] == [JobCanceledError, JobCanceledError]
    assert (desk.engine.done, desk.results, desk.errors) == ([], [], [])
    desk.engine.go.set()
    desk.work.submit(job(3), desk.results.append)
    qtbot.waitUntil(lambda: desk.results == [3])


def test_an_error_is_told_and_the_next_job_goes_on(desk: SimpleNamespace, qtbot: QtBot) -> None:
    why: list[BaseException] = []
    desk.engine.go.set()
    desk.work.submit(job(13), desk.results.append, failed=why.append)
    desk.work.submit(job(4), desk.results.append)
    qtbot.waitUntil(lambda: desk.results == [4])
    assert ["run 13" in str(one) for one in desk.errors] == [True]
    assert why == desk.errors


def test_nobody_is_told_once_the_window_closed(desk: SimpleNamespace, qtbot: QtBot) -> None:
    why: list[BaseException] = []
    desk.work.submit(job(1), desk.results.append, failed=why.append)
    desk.work.submit(job(2), desk.results.append, failed=why.append)
    desk.work.close()
    qtbot.waitUntil(lambda: not desk.work.running)
    assert (desk.results, why) == ([], [])
