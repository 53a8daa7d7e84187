"""Tasks in other processes: executors by address, and tasks that outlive a worker that dies."""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, Final, Self, TypeVar

from gsapp.foundation.errors import GroundStationError
from gsapp.foundation.process_control import block_sigint, initialize_worker

Task = TypeVar("Task")
Result = TypeVar("Result")

_MAX_LOSSES: Final = 2
"""Workers that a task may lose while it runs alone, as it does after it lost one in company."""

_WORKER_PATIENCE: Final = 60.0
"""Seconds in which the first worker of a scheduler must be there."""


class WorkerLostError(GroundStationError):
    """A task failed because the process that ran it ended, twice."""

    def __init__(self, text: str = "") -> None:
        super().__init__(
            text or "its worker process ended unexpectedly, twice; check the memory of the computer"
        )


class SpawnedProcessPool(ProcessPoolExecutor):
    """Processes that Ctrl+C does not reach, and that end at once with `end` or with this process.

    Parameters
    ----------
    count : int
        Processes at most.
    niceness : int
        Steps by which they yield to other processes.
    """

    def __init__(self, count: int, niceness: int = 0) -> None:
        # A fork would copy a process full of threads and windows.
        context = multiprocessing.get_context("spawn")
        self._wanted = context.Pipe(duplex=False)
        super().__init__(
            count,
            mp_context=context,
            initializer=initialize_worker,
            initargs=(self._wanted[0], niceness),
        )

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with block_sigint():  # a process begins with a task
            return super().submit(fn, *args, **kwargs)

    def end(self) -> None:
        """End the processes; what runs is dropped.

        `shutdown` would finish it first, and Python waits for it when it exits.
        """
        self.shutdown(wait=False, cancel_futures=True)
        for end in self._wanted:
            end.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenedExecutor:
    """An executor, and what its interface does not tell."""

    executor: Executor
    slots: int  # Tasks that run at the same time.
    end: Callable[[], object]  # Ends it at once; what runs is dropped.
    loss_errors: tuple[type[Exception], ...] = (BrokenExecutor,)
    """Raised for a task whose worker died."""


def _open_local(address: str) -> OpenedExecutor:
    count = _count(address or str(os.cpu_count() or 1))
    pool = SpawnedProcessPool(count)
    return OpenedExecutor(executor=pool, slots=count, end=pool.end)


def _open_dask(address: str) -> OpenedExecutor:
    try:
        import dask
        from distributed import Client, LocalCluster
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise GroundStationError(
            "Dask is not installed; install it with 'python3 packaging/bootstrap.py setup dask' in "
            "the folder of the clone, or with 'pip install gsapp-ground-station[dask]'"
        ) from error
    place, _, number = address.partition(":")
    # A task is tried again here, alone: the scheduler cannot tell which one ended the worker.
    with block_sigint(), dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        try:
            if place == "local":
                cluster = LocalCluster(
                    n_workers=_count(number or str(os.cpu_count() or 1)),
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs="CRITICAL",
                )
                client = Client(cluster)
            else:
                cluster = None
                client = Client(f"tcp://{address}")
                client.wait_for_workers(1, timeout=_WORKER_PATIENCE)
        except (OSError, ValueError) as error:
            raise GroundStationError(
                f"no Dask scheduler with workers answers at {address} ({error}); start one with "
                "'dask scheduler', and workers with 'dask worker'"
            ) from error

    def end() -> None:
        executor.shutdown(wait=False)
        client.close()
        if cluster is not None:
            cluster.close()

    executor = client.get_executor(pure=False)
    return OpenedExecutor(
        executor=executor,
        slots=max(1, sum(client.nthreads().values())),
        end=end,
        loss_errors=(BrokenExecutor, KilledWorker),
    )


EXECUTORS: Final[dict[str, Callable[[str], OpenedExecutor]]] = {
    "local": _open_local,
    "dask": _open_dask,
}
"""By the first word of an address, what opens it: another kind of cluster is another entry."""


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise GroundStationError(f"'{text}' is no number of processes; write local:4")
    return int(text)


def _parse(address: str) -> tuple[Callable[[str], OpenedExecutor], str]:
    kind, _, rest = address.partition(":")
    opener = EXECUTORS.get(kind)
    if opener is None or (kind == "dask" and not rest.removeprefix("//")):
        raise GroundStationError(
            f"'{address}' names no place to run on; use local, local:4, dask://HOST:8786 or "
            "dask://local:4"
        )
    return opener, rest.removeprefix("//")


@dataclass(slots=True)
class _Run:
    """The tasks of one `WorkerPool.map`."""

    waiting: Iterator[tuple[int, Any]]
    running: dict[Future[Any], tuple[int, Any]] = field(default_factory=dict)
    suspects: deque[tuple[int, Any]] = field(default_factory=deque)  # To be tried alone.
    losses: dict[int, int] = field(default_factory=dict)  # While they ran alone.
    done: dict[int, Future[Any] | WorkerLostError] = field(default_factory=dict)


class WorkerPool:
    """Workers of an executor, opened with the first task and again when they broke.

    Parameters
    ----------
    address : str
        ``local``, ``local:N``, ``dask://HOST:PORT`` or ``dask://local:N``.

    Raises
    ------
    GroundStationError
        If it names no kind of executor.
    """

    def __init__(self, address: str) -> None:
        self._open, self._address = _parse(address)
        self._opened: OpenedExecutor | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the workers; what runs is dropped."""
        opened, self._opened = self._opened, None
        if opened is not None:
            opened.end()

    def map(
        self, function: Callable[[Task], Result], tasks: Iterable[Task]
    ) -> Iterator[Result | WorkerLostError]:
        """Yield what a function gives for each task, in the order of the tasks.

        A task whose worker dies is tried again; where it ends two workers by itself, an error
        is yielded in place of its result. Tasks are taken from `tasks` as workers become free.
        What the function raises is raised in its turn, and drops the tasks that run.

        Parameters
        ----------
        function : callable
            Picklable, as tasks and results are.

        Raises
        ------
        GroundStationError
            If there are no workers.
        """
        run = _Run(iter(enumerate(tasks)))
        following, is_finished = 0, False
        try:
            while self._submit(function, run):
                self._collect(run)
                while following in run.done:
                    found = run.done.pop(following)
                    following += 1
                    yield found if isinstance(found, WorkerLostError) else found.result()
            is_finished = True
        finally:
            if not is_finished:
                self.close()

    def _submit(self, function: Callable[[Any], Any], run: _Run) -> bool:
        """Hand out what workers are free for; return whether anything runs."""
        if self._opened is None:
            self._opened = self._open(self._address)
        # One more than run, so that no worker waits for this process.
        limit = 1 if run.suspects else self._opened.slots + 1
        while len(run.running) < limit:
            task = run.suspects.popleft() if run.suspects else next(run.waiting, None)
            if task is None:
                break
            try:
                future = self._opened.executor.submit(function, task[1])
            except BrokenExecutor:
                run.waiting = chain((task,), run.waiting)
                if run.running:
                    break  # they tell it, too
                self.close()
                self._opened = self._open(self._address)
                continue
            run.running[future] = task
            limit = 1 if task[0] in run.losses else limit
        return bool(run.running)

    def _collect(self, run: _Run) -> None:
        """Wait for a task, and take what is done."""
        opened = self._opened
        assert opened is not None  # noqa: S101
        done, _ = wait(run.running, return_when=FIRST_COMPLETED)
        if any(isinstance(_exception(one), BrokenExecutor) for one in done):
            done, _ = wait(run.running)
            self.close()
        for future in done:
            index, task = run.running.pop(future)
            if not isinstance(_exception(future), opened.loss_errors):
                run.done[index] = future
                continue
            # The first was lost in company, and another task may have ended it.
            run.losses[index] = run.losses.get(index, -1) + 1
            if run.losses[index] < _MAX_LOSSES:
                run.suspects.append((index, task))
            else:
                run.done[index] = WorkerLostError()


def _exception(future: Future[Any]) -> BaseException | None:
    try:
        return future.exception()
    except CancelledError as error:
        raise GroundStationError("the connection to the workers was lost; run it again") from error


def map_tasks(
    pool: WorkerPool | None, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[Result | WorkerLostError]:
    """Yield what a function gives for each task, in their order: with a pool, or one by one here.

    See `WorkerPool.map`.
    """
    return map(function, tasks) if pool is None else pool.map(function, tasks)
