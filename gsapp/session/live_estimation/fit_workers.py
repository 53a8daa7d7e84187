"""Where fits and searches run: in a process beside a live flight, at once without a window."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Final, Protocol

from gsapp.foundation.executors import SpawnedProcessPool

_NICENESS: Final = 10
"""By how much a worker stands back behind the stream and the window."""


class FitWorker(Protocol):
    """Takes requests and gives replies, in any order and at any time.

    Those of `maneuver_fits.run_fit_request`, or of what it was made with.
    """

    def submit(self, request: Any) -> Future[Any]:
        """Begin a fit."""
        ...

    def close(self) -> None:
        """Give back what is held; fits that run are dropped."""
        ...


class InlineFitWorker:
    """Fits where it is asked: for replays without a window; `work` as `ProcessFitWorker`."""

    def __init__(self, work: Callable[[Any], Any] | None = None) -> None:
        self._work = work

    def submit(self, request: Any) -> Future[Any]:
        from gsapp.session.live_estimation.maneuver_fits import run_fit_request

        work = run_fit_request if self._work is None else self._work
        done: Future[Any] = Future()
        try:
            done.set_result(work(request))
        except Exception as error:  # as an executor does: whoever asks is told
            done.set_exception(error)
        return done

    def close(self) -> None:
        """Hold nothing."""


class ProcessFitWorker:
    """Fits in one process of their own, begun with the first; begun anew should it die.

    Parameters
    ----------
    work : callable, optional
        What is run there, in place of a fit; picklable.
    """

    def __init__(self, work: Callable[[Any], Any] | None = None) -> None:
        self._work = work
        self._pool: SpawnedProcessPool | None = None

    def submit(self, request: Any) -> Future[Any]:
        from gsapp.session.live_estimation.maneuver_fits import run_fit_request

        work = run_fit_request if self._work is None else self._work
        try:
            return self._running().submit(work, request)
        except BrokenProcessPool:
            self.close()
            return self._running().submit(work, request)

    def _running(self) -> SpawnedProcessPool:
        if self._pool is None:
            self._pool = SpawnedProcessPool(1, _NICENESS)
        return self._pool

    def close(self) -> None:
        """End the process at once; a fit that runs is dropped."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.end()
