"""Where fits and searches run: in a process beside a live flight, at once without a window."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from typing import Any, Protocol

from gsapp.foundation.process_control import block_sigint


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
        self._pool: ProcessPoolExecutor | None = None
        self._pipe: tuple[Connection, Connection] | None = None

    def submit(self, request: Any) -> Future[Any]:
        from gsapp.session.live_estimation.maneuver_fits import run_fit_request

        work = run_fit_request if self._work is None else self._work
        with block_sigint():  # the process begins with the first fit
            try:
                return self._running().submit(work, request)
            except BrokenProcessPool:
                self.close()
                return self._running().submit(work, request)

    def _running(self) -> ProcessPoolExecutor:
        from gsapp.session.live_estimation.maneuver_fits import initialize_fit_worker

        if self._pool is None:
            # A fork would copy a process full of threads and windows.
            context = multiprocessing.get_context("spawn")
            self._pipe = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(
                1, mp_context=context, initializer=initialize_fit_worker, initargs=self._pipe[:1]
            )
        return self._pool

    def close(self) -> None:
        """End the process at once; a fit that runs is dropped.

        A pool alone would finish that fit first, and Python waits for it when it exits.
        """
        pool, self._pool = self._pool, None
        pipe, self._pipe = self._pipe, None
        if pool is not None:
            pool.shutdown(wait=False, cancel_futures=True)
        if pipe is not None:
            for end in pipe:
                end.close()
