"""Readers built on C libraries, in a process of their own with limits of time and memory.

A damaged file may crash or hang such a library, or make it claim more memory than there is. The
process reads the file, and sends plain numbers and texts; its death becomes a `FlightError`.

Run as a program, with the name of a reader, a file and the limit in bytes, it is that process. What
it writes is a sequence of parts of 8 bytes of length and the bytes: pickled reports, and behind the
last the arrays one by one.
"""

from __future__ import annotations

import contextlib
import io
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Final, cast

from gsapp.flight.read_limits import LIMIT_VARIABLE, MEGABYTE, read_limit
from gsapp.flight.settings import READER_PROCESS
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.process_control import module_command

_NO_WINDOW: int = getattr(subprocess, "CREATE_NO_WINDOW", 0)
"""Windows would show a console for every file."""
_LENGTH = struct.Struct("<Q")
_READERS: Final = {
    "mat": ("gsapp.flight.readers.mat_file", "read_mat_content"),
    "parquet": ("gsapp.flight.readers.parquet_file", "read_parquet_content"),
}
_PLAIN = frozenset(
    {
        ("numpy", "dtype"),
        ("numpy", "ndarray"),
        ("numpy._core.numeric", "_frombuffer"),
        ("numpy.core.numeric", "_frombuffer"),
        ("numpy._core.multiarray", "_reconstruct"),
        ("numpy.core.multiarray", "_reconstruct"),
        ("numpy._core.multiarray", "scalar"),
        ("numpy.core.multiarray", "scalar"),
    }
)
"""What a report may be built of."""

ProgressCallback = Callable[[float | None], object]
"""Receives the share of a file that is read, in its process; None: unknown."""
ReadingCallback = Callable[[float | None, str], object]
"""Receives the share done (None: unknown) and what is read; may raise to stop it."""
_observer: ContextVar[ReadingCallback | None] = ContextVar("reading", default=None)


@contextlib.contextmanager
def observe_reading(callback: ReadingCallback) -> Iterator[None]:
    """Report to `callback` how far files are that this thread reads in processes in here."""
    token = _observer.set(callback)
    try:
        yield
    finally:
        _observer.reset(token)


def read_in_process(reader: str, path: Path, remedy: str) -> Any:
    """Read a file with a reader (``mat`` or ``parquet``) in a process of its own.

    `remedy` says what to do with a damaged file. Raise `FlightError` if the reader refuses the
    file, dies, hangs or needs too much memory; what the callback of `observe_reading` raises stops
    it.
    """
    size = path.stat().st_size
    limit = read_limit(size)
    process = subprocess.Popen(
        module_command(__name__, reader, str(path.absolute()), str(limit)),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        creationflags=_NO_WINDOW,
        # Arrow's own pool takes address space in advance.
        env={**os.environ, "ARROW_DEFAULT_MEMORY_POOL": "system"},
    )
    stream = cast(IO[bytes], process.stdout)
    parts: queue.SimpleQueue[Any] = queue.SimpleQueue()
    thread = threading.Thread(
        target=_receive, args=(stream, limit, parts), name="reading", daemon=True
    )
    thread.start()
    try:
        kind, value = _await_result(path, parts, _quiet_timeout(size, limit))
    finally:
        process.kill()
        process.wait()
        thread.join()
        stream.close()
    if kind == "done":
        return value
    if kind == "refused":
        raise FlightError(value.replace(str(path.absolute()), str(path)))
    if kind == "memory":
        raise FlightError(
            f"{path} of {size / MEGABYTE:.1f} MB takes more memory than numbers of "
            f"{limit // MEGABYTE} MB; {remedy}, or raise the environment variable {LIMIT_VARIABLE}"
        )
    if kind == "quiet":
        raise FlightError(
            f"{path} is damaged: its reader was stopped after {value:.0f} s without progress; "
            f"{remedy}"
        )
    what = value if kind == "failed" else _death(process.returncode)
    raise FlightError(f"{path} is damaged ({what}); {remedy}")


def _quiet_timeout(size: int, limit: int) -> float:
    """Return how long a reader may be without a report, s; longer where the limit was raised."""
    seconds = READER_PROCESS.quiet_timeout + size / READER_PROCESS.slow_disk_rate
    return seconds * max(limit / (READER_PROCESS.limit_mb * MEGABYTE), 1.0)


def _death(code: int) -> str:
    """Return how a process ended, in words."""
    with contextlib.suppress(ValueError):
        return f"its reader crashed with {signal.Signals(-code).name}"
    return f"its reader ended with code {code}"


def _await_result(path: Path, parts: queue.SimpleQueue[Any], quiet: float) -> tuple[str, Any]:
    """Return the last report: its kind, and a result or a reason."""
    observer = _observer.get()
    share: float | None = None
    allowed = READER_PROCESS.start_timeout
    deadline = time.monotonic() + allowed
    while True:
        if observer is not None:
            observer(share, f"reading {path.name}")
        try:
            kind, value = parts.get(timeout=READER_PROCESS.poll_interval)
        except queue.Empty:
            if time.monotonic() > deadline:
                return "quiet", allowed
            continue
        if kind != "progress":
            return kind, value
        share, allowed = value, quiet
        deadline = time.monotonic() + allowed


def _receive(stream: IO[bytes], limit: int, parts: queue.SimpleQueue[Any]) -> None:
    """Hand on what the process reports, until it ends."""
    try:
        while True:
            kind, value, buffers = _unpickle(_part(stream, limit), [])
            if kind == "done":
                arrays = [_part(stream, limit) for _ in range(buffers)]
                value = _unpickle(value, arrays)
            parts.put((kind, value))
    except (EOFError, ValueError, MemoryError, pickle.UnpicklingError) as error:
        parts.put(("memory" if isinstance(error, MemoryError) else "dead", ""))


def _part(stream: IO[bytes], limit: int) -> bytearray:
    (length,) = _LENGTH.unpack(_exactly(stream, bytearray(_LENGTH.size)))
    if length > 2 * limit + MEGABYTE:
        raise ValueError
    return _exactly(stream, bytearray(length))


def _exactly(stream: IO[bytes], target: bytearray) -> bytearray:
    view = memoryview(target)
    while view:
        count = stream.readinto(view)  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        view = view[count:]
    return target


class _PlainUnpickler(pickle.Unpickler):
    """Builds numbers, texts and arrays, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) not in _PLAIN:
            raise pickle.UnpicklingError(f"{module}.{name}")
        return super().find_class(module, name)


def _unpickle(data: bytes | bytearray, buffers: list[bytearray]) -> Any:
    return _PlainUnpickler(io.BytesIO(data), buffers=buffers).load()


# The process


def _send(stream: IO[bytes], kind: str, value: object) -> None:
    buffers: list[pickle.PickleBuffer] = []
    if kind == "done":
        value = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    report = pickle.dumps((kind, value, len(buffers)), protocol=5)
    for part in (memoryview(report), *(one.raw() for one in buffers)):
        stream.write(_LENGTH.pack(part.nbytes))
        stream.write(part)
    stream.flush()


def _limit_process(memory: int, seconds: float) -> None:
    """Let the system end this process where it takes too much; Windows and macOS limit no memory.

    Its own clock ends it also where nobody waits for it any more.
    """
    if sys.platform == "win32":
        return
    import resource

    for kind, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_DATA, memory),
        (resource.RLIMIT_CPU, int(seconds)),
    ):
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(kind, (most, most))


class _Progress:
    """Reports how far the reader is, not for every small thing it does."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._next = 0.0

    def __call__(self, share: float | None) -> None:
        if time.monotonic() >= self._next:
            _send(self._stream, "progress", share)
            self._next = time.monotonic() + READER_PROCESS.poll_interval


def main(reader: str, name: str, limit: int) -> None:
    """Read a file and write its content to standard output."""
    path = Path(name)
    # What a library prints must not get between the reports.
    stream = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    _limit_process(
        READER_PROCESS.memory_ratio * limit + READER_PROCESS.memory_base_mb * MEGABYTE,
        READER_PROCESS.cpu_time * max(limit / (READER_PROCESS.limit_mb * MEGABYTE), 1.0),
    )
    module, function = _READERS[reader]
    try:
        read = getattr(import_module(module), function)
        _send(stream, "progress", 0.0)
        content = read(path, limit, _Progress(stream))
        _send(stream, "done", content)
    except GroundStationError as error:
        _send(stream, "refused", str(error))
    except MemoryError:
        _send(stream, "memory", "")
    except Exception as error:  # a damaged file makes a library raise whatever it meets
        first = str(error).strip().splitlines()[:1]
        _send(stream, "failed", ": ".join([type(error).__name__, *first]))
    stream.close()
    # Nothing that a library does as it ends counts.
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
