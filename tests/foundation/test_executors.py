"""Tasks in other processes: order, errors, workers that are killed, Ctrl+C."""

import copy
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from gsapp.foundation import FileProblem, FileProblemsError, FlightError, GroundStationError
from gsapp.foundation.executors import WorkerLostError, WorkerPool, map_tasks

KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


@pytest.fixture(params=["local:2", "dask://local:2"])
def pool(request: pytest.FixtureRequest) -> Iterator[WorkerPool]:
    if request.param.startswith("dask"):
        pytest.importorskip("distributed", reason="Dask is not installed (extra dask)")
    with WorkerPool(request.param) as opened:
        yield opened


def square(number: int) -> tuple[int, int]:
    time.sleep(0.02 * (number % 3))
    return number**2, os.getpid()


def refuse(number: int) -> int:
    if number > 1:
        raise FlightError(f"flight {number}")
    return number


def die(folder: Path, deadly: dict[int, int], number: int) -> int:
    """End the own process with some tasks, as often as told."""
    marks = [folder / f"{number}.{time}" for time in range(deadly.get(number, 0))]
    for mark in marks:
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), KILL)
    return 10 * number


def test_results_come_in_order_from_other_processes(pool: WorkerPool) -> None:
    found = list(pool.map(square, range(9)))
    assert [value for value, _ in found] == [number**2 for number in range(9)]
    processes = {process for _, process in found}
    assert os.getpid() not in processes
    assert len(processes) == 2
    assert [value for value, _ in pool.map(square, range(3))] == [0, 1, 4]


def test_the_first_error_in_order_is_raised(pool: WorkerPool) -> None:
    found = pool.map(refuse, range(6))
    assert [next(found), next(found)] == [0, 1]
    with pytest.raises(FlightError, match="flight 2"):
        next(found)


def test_a_killed_worker_costs_a_retry(pool: WorkerPool, tmp_path: Path) -> None:
    work = partial(die, tmp_path, {3: 1, 5: 1})
    assert list(pool.map(work, range(8))) == [10 * number for number in range(8)]
    assert len(list(tmp_path.iterdir())) == 2


def test_a_task_that_ends_two_workers_fails_and_no_other(pool: WorkerPool, tmp_path: Path) -> None:
    found = list(pool.map(partial(die, tmp_path, {2: 9}), range(6)))
    assert isinstance(found[2], WorkerLostError)
    assert [one for one in found if not isinstance(one, WorkerLostError)] == [0, 10, 30, 40, 50]
    assert len(list(tmp_path.iterdir())) == 3  # the first beside other tasks


def test_tasks_are_taken_as_workers_become_free(pool: WorkerPool) -> None:
    taken = []

    def numbers() -> Iterator[int]:
        for number in range(50):
            taken.append(number)
            yield number

    found = pool.map(square, numbers())
    next(found)
    found.close()
    assert len(taken) < 10


def test_without_a_pool_tasks_run_here() -> None:
    assert {process for _, process in map_tasks(None, square, range(3))} == {os.getpid()}


@pytest.mark.parametrize("address", ["", "foo", "dask", "dask://", "ssh://x:1"])
def test_an_address_of_no_executor_is_refused(address: str) -> None:
    with pytest.raises(GroundStationError):
        WorkerPool(address)


@pytest.mark.parametrize("address", ["local:0", "local:x"])
def test_no_number_of_processes(address: str) -> None:
    with pytest.raises(GroundStationError), WorkerPool(address) as pool:
        list(pool.map(square, [1]))


def test_no_scheduler_where_it_should_be() -> None:
    pytest.importorskip("distributed", reason="Dask is not installed (extra dask)")
    import dask

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1 s"}),
        pytest.raises(GroundStationError),
        WorkerPool("dask://127.0.0.1:9") as pool,
    ):
        list(pool.map(square, [1]))


def test_an_error_of_a_file_crosses_processes() -> None:
    error = FileProblemsError("a.toml", [FileProblem(where="mass", what="missing")])
    again = copy.copy(error)
    assert (str(again), again.path, again.problems) == (str(error), error.path, error.problems)


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl+C of another process: POSIX only")
def test_an_interrupt_ends_the_workers() -> None:
    code = (
        "import os, signal, time\n"
        "from gsapp.foundation.executors import WorkerPool\n"
        "if __name__ == '__main__':\n"
        "    # A shell that runs the tests in its background lets them ignore Ctrl+C.\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    with WorkerPool('local:2') as pool:\n"
        "        print(next(pool.map(os.getpgid, [0, 0])), flush=True)\n"
        "        list(pool.map(time.sleep, [600.0, 600.0]))\n"
    )
    command = [sys.executable, "-c", code]
    child = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    )
    assert int(child.stdout.readline()) == child.pid
    time.sleep(1.0)
    os.killpg(child.pid, signal.SIGINT)  # as a terminal does
    # Both pipes close when the workers, which hold them, too, have ended.
    _, words = child.communicate(timeout=60.0)
    assert child.returncode == -signal.SIGINT
    assert words.count(b"Traceback") == 1
    assert b"KeyboardInterrupt" in words
