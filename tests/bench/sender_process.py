"""A process of its own that sends telemetry over UDP in real time."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


@contextmanager
def sending(script: str, *arguments: object) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``script send ARGUMENTS`` meanwhile."""
    process = subprocess.Popen(
        [sys.executable, script, "send", *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def send_in_real_time(port: int, timed: Iterable[tuple[float, bytes]]) -> None:
    """Send each datagram at its time, s, from the first one on."""
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    begin = None
    for at, data in timed:
        begin = time.monotonic() - at if begin is None else begin
        time.sleep(max(begin + at - time.monotonic(), 0.0))
        line.sendto(data, ("127.0.0.1", port))
