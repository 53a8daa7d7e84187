"""Hearing when this process is asked to end."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_ASK_TO_END = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


@contextmanager
def asked_to_end(act: Callable[[int], object], *, ctrl_c: bool = True) -> Iterator[None]:
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
    for name in _ASK_TO_END[0 if ctrl_c else 1 :]:
        number = getattr(signal, name, None)
        if number is None or (name == "SIGHUP" and signal.getsignal(number) is signal.SIG_IGN):
            continue
        former[number] = signal.signal(number, lambda heard, _frame: act(heard))
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
