"""Processes: their end, their priority, a computer that stays awake, and detached ones."""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, NoReturn

_TERMINATION_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


@contextmanager
def on_termination_signal(act: Callable[[int], object], *, ctrl_c: bool = True) -> Iterator[None]:
    """Call `act` with the number of every signal that asks this process to end.

    Ctrl-C, ``kill``, a terminal that closes, Ctrl-Break on Windows. Whoever started the process
    under ``nohup`` wants it to outlive the terminal: that signal then stays ignored. It is called
    in the main thread, between two steps of Python. Without `ctrl_c`, Ctrl-C goes on as
    `KeyboardInterrupt`.
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


def initialize_worker(wanted: Connection, niceness: int = 0) -> None:
    """Make a worker process leave Ctrl+C to its parent, and yield to other processes.

    Parameters
    ----------
    wanted : Connection
        The process ends at once when the other end is closed, or its parent was killed.
    niceness : int
        See `lower_priority`.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if niceness:
        lower_priority(niceness)
    threading.Thread(target=_end_when_closed, args=(wanted,), name="wanted", daemon=True).start()


def _end_when_closed(wanted: Connection) -> None:
    with contextlib.suppress(EOFError, OSError):
        wanted.recv_bytes()
    os._exit(1)


@contextmanager
def exit_deadline(seconds: float, log: Path) -> Iterator[None]:
    """End this process some seconds after the first signal of `on_termination_signal`.

    That holds beyond this context, for threads that Python waits for as it exits. A thread of its
    own hears the signal, since the main thread may be stuck where it hears none. The log gets the
    traceback of every thread where the time was not enough; the exit code is 1 then.
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


def return_free_memory() -> None:
    """Give back to the system what the C library holds of memory that was freed.

    Between arrays that stay, those that went leave gaps, which a long flight adds up. Does nothing
    but under Linux with the GNU C library.
    """
    if sys.platform == "linux":
        import ctypes

        with contextlib.suppress(AttributeError):
            ctypes.CDLL(None).malloc_trim(0)


_BELOW_NORMAL = 0x4000  # BELOW_NORMAL_PRIORITY_CLASS


def lower_priority(steps: int) -> None:
    """Let this process yield to others of the user, by 1 to 19 steps; Windows knows but one.

    Where that is refused, nothing happens.
    """
    if sys.platform == "win32":
        import ctypes

        kernel = ctypes.WinDLL("kernel32")
        # Else the handle, which is -1, would lose half of its bits.
        kernel.GetCurrentProcess.restype = ctypes.c_void_p
        kernel.SetPriorityClass.argtypes = (ctypes.c_void_p, ctypes.c_uint32)
        kernel.SetPriorityClass(kernel.GetCurrentProcess(), _BELOW_NORMAL)
    else:
        with contextlib.suppress(OSError):
            os.nice(steps)


# SetThreadExecutionState
_CONTINUOUS, _SYSTEM, _DISPLAY = 0x80000000, 0x1, 0x2

_INHIBITORS = ("systemd-inhibit", "elogind-inhibit")
_PATIENCE = 2.0
"""Seconds that the program beside may take to end."""


@contextlib.contextmanager
def inhibit_sleep(why: str, *, screen: bool = False) -> Iterator[None]:
    """Ask the system not to fall asleep by itself; it may refuse, and then nothing happens.

    However this process ends, nothing stays behind. What the user does, closing the lid for one,
    counts as before. The system tells the user why, where it can: ``recording 2026-05-12-a``. With
    `screen` the screen is to stay lit, too; only the desktop can do that on Linux.
    """
    if sys.platform == "win32":
        _set_execution_state(_CONTINUOUS | _SYSTEM | (_DISPLAY if screen else 0))
        try:
            yield
        finally:
            _set_execution_state(_CONTINUOUS)
        return
    with _run_alongside(_inhibitor_command(why, screen=screen)):
        yield


def _inhibitor_command(why: str, *, screen: bool) -> Sequence[str]:
    """Return the program that keeps this computer awake while it runs; empty for none."""
    if sys.platform == "darwin":
        # Ends with this process.
        return ("/usr/bin/caffeinate", "-d" if screen else "-i", "-w", str(os.getpid()))
    for name in _INHIBITORS:
        if (program := shutil.which(name)) is not None:
            who = ("--what=sleep:idle", "--mode=block", "--who=Ground station", f"--why={why}")
            # It ends with what it runs, and that when nobody can write to it any more.
            return (program, *who, "cat")
    return ()


@contextlib.contextmanager
def _run_alongside(command: Sequence[str]) -> Iterator[None]:
    """Run a program for as long as this lasts."""
    program = None
    if command:
        with contextlib.suppress(OSError):
            program = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is not meant for it
            )
    try:
        yield
    finally:
        if program is not None:
            _stop_program(program)


def _stop_program(program: subprocess.Popen[bytes]) -> None:
    if program.stdin is not None:
        with contextlib.suppress(OSError):
            program.stdin.close()
    with contextlib.suppress(OSError):
        program.terminate()
    with contextlib.suppress(subprocess.TimeoutExpired):
        program.wait(_PATIENCE)


def _set_execution_state(state: int) -> None:
    """Tell Windows what this thread needs; it forgets it when the thread ends."""
    if sys.platform == "win32":
        import ctypes

        tell = ctypes.WinDLL("kernel32").SetThreadExecutionState
        tell.argtypes = (ctypes.c_uint32,)
        tell(state)


def module_command(module: str, *arguments: str) -> list[str]:
    """Return the command line that runs a module of the program in a process of its own.

    Nothing is imported from the folder where it runs. The program of a standalone build
    (`packaging/standalone.py`) understands the same options as Python.
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def start_detached_process(
    command: Sequence[str],
    words: IO[bytes],
    *,
    folder: Path | None = None,
    listens: bool = False,
) -> subprocess.Popen[bytes]:
    """Start a process that no Ctrl-C and no closed terminal of this one reaches.

    Its complaints go to `words`, a Python's as UTF-8; what it prints is dropped. With `listens` it
    hears what is written to it. Raise OSError if it cannot be started.
    """
    flags = 0
    if sys.platform == "win32":
        # A console that nobody sees. Without any, Windows opens one on the screen for the Python
        # behind the launcher of a virtual environment, and closing that would end it.
        flags = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
    return subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, "PYTHONUTF8": "1"},
        stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=words,
        bufsize=0,
        creationflags=flags,
        start_new_session=sys.platform != "win32",
    )
