"""Hearing when this process is asked to end, and ending in time."""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import signal
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

_TERMINATION_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


@contextmanager
def on_termination_signal(act: Callable[[int], object], *, ctrl_c: bool = True) -> Iterator[None]:
    """Call `act` with the number of every signal that asks this process to end.

    Ctrl-C, ``kill``, a terminal that closes, Ctrl-Break on Windows. Whoever started the process
    under ``nohup`` wants it to outlive the terminal: that signal then stays ignored.

    Parameters
    ----------
    act : callable
        In the main thread, between two steps of Python.
    ctrl_c : bool
        Whether Ctrl-C is heard, too; else it goes on as `KeyboardInterrupt`.
    """
    former = {}
    for name in _TERMINATION_SIGNALS[0 if ctrl_c else 1 :]:
        number = getattr(signal, name, None)
        if number is None or (name == "SIGHUP" and signal.getsignal(number) is signal.SIG_IGN):
            continue
        former[number] = signal.signal(number, lambda heard, _frame: act(heard))
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


@contextmanager
def block_sigint() -> Iterator[None]:
    """Start processes in here that Ctrl-C, which reaches the whole terminal, does not reach.

    They inherit that it is blocked. To ignore it in the process itself comes too late: while it
    still imports, Ctrl-C ends it with a traceback. Does nothing on Windows.
    """
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker

    # Its start would unblock the signal again.
    resource_tracker.ensure_running()
    former = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, former)


@contextmanager
def exit_deadline(seconds: float, log: Path) -> Iterator[None]:
    """End this process some time after the first signal of `on_termination_signal`.

    That holds beyond this context, for threads that Python waits for as it exits. A thread of its
    own hears the signal, since the main thread may be stuck where it hears none.

    Parameters
    ----------
    seconds : float
        From the signal on.
    log : Path
        Gets the traceback of every thread where the time was not enough; the exit code is 1 then.
    """
    heard, wake = os.pipe()
    if sys.platform != "win32":  # where it is neither required nor, in Python 3.11, there
        os.set_blocking(wake, False)
    former = signal.set_wakeup_fd(wake, warn_on_full_buffer=False)

    def watch() -> None:
        if os.read(heard, 1):
            # Never closed: it is written to as the process ends.
            file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            faulthandler.dump_traceback_later(seconds, exit=True, file=file)
        os.close(heard)

    threading.Thread(target=watch, name="ending", daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(former)
        os.close(wake)


def exit_process(code: int) -> NoReturn:
    """End this process in order, but for daemon threads that still work: they just stop.

    As Python takes itself apart it stops such threads where they are; inside a C++ library, such
    as Qt, that aborts the process.
    """
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()
    # Temporary folders; Qt's own functions for the end of Python would destroy it under a thread.
    weakref.finalize._exitfunc()  # type: ignore[attr-defined]
    logging.shutdown()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(code)
