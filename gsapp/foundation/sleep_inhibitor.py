"""Keeping the computer from falling asleep over something that must go on."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence

# SetThreadExecutionState
_CONTINUOUS, _SYSTEM, _DISPLAY = 0x80000000, 0x1, 0x2

_INHIBITORS = ("systemd-inhibit", "elogind-inhibit")
_PATIENCE = 2.0
"""Seconds that the program beside may take to end."""


@contextlib.contextmanager
def inhibit_sleep(why: str, *, screen: bool = False) -> Iterator[None]:
    """Ask the system not to fall asleep by itself; it may refuse, and then nothing happens.

    However this process ends, nothing stays behind. What the user does, closing the lid for one,
    counts as before.

    Parameters
    ----------
    why : str
        What the system tells the user, where it can: ``recording 2026-05-12-a``.
    screen : bool
        Whether the screen is to stay lit, too. Only the desktop can do that on Linux.
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
