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
def controller(qtbot: QtBot) -> SimpleNamespace:
    engine, errors = Slow(), []
    work = JobQueue(engine, errors.append)
    ended: list[tuple[str, str]] = []
    work.ended.connect(lambda title, how: ended.append((title, how)))
    return SimpleNamespace(engine=engine, work=work, errors=errors, ended=ended, results=[])


def test_jobs_are_done_in_order_and_one_asked_for_twice_only_once(controller, qtbot):
    for number in (1, 2, 1, 2):
        controller.work.submit(job(number), controller.results.append)
    assert controller.work.title == "Repeating run 1"
    controller.engine.go.set()
    qtbot.waitUntil(lambda: not controller.work.running)
    assert controller.engine.done == [1, 2]
    assert controller.results == [1, 1, 2, 2]
    assert controller.ended == [("Repeating run 1", "done"), ("Repeating run 2", "done")]


def test_a_stop_ends_what_runs_and_what_waits_and_the_next_job_works(controller, qtbot):
    why: list[BaseException] = []
    for number in (1, 2):
        controller.work.submit(job(number), controller.results.append, failed=why.append)
    controller.work.cancel()
    qtbot.waitUntil(lambda: not controller.work.running)
    assert [type(one) for one in why] == [JobCanceledError, JobCanceledError]
    assert (controller.engine.done, controller.results, controller.errors) == ([], [], [])
    controller.engine.go.set()
    controller.work.submit(job(3), controller.results.append)
    qtbot.waitUntil(lambda: controller.results == [3])


def test_an_error_is_told_and_the_next_job_goes_on(
    controller: SimpleNamespace, qtbot: QtBot
) -> None:
    why: list[BaseException] = []
    controller.engine.go.set()
    controller.work.submit(job(13), controller.results.append, failed=why.append)
    controller.work.submit(job(4), controller.results.append)
    qtbot.waitUntil(lambda: controller.results == [4])
    assert ["run 13" in str(one) for one in controller.errors] == [True]
    assert why == controller.errors


def test_nobody_is_told_once_the_window_closed(controller: SimpleNamespace, qtbot: QtBot) -> None:
    why: list[BaseException] = []
    controller.work.submit(job(1), controller.results.append, failed=why.append)
    controller.work.submit(job(2), controller.results.append, failed=why.append)
    controller.work.close()
    qtbot.waitUntil(lambda: not controller.work.running)
    assert (controller.results, why) == ([], [])
