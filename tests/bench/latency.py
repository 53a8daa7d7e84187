"""From the aircraft to the history: how old what a window can draw is.

A sender in its own process speaks MAVLink at 100 Hz over UDP, a recorder in its own process
writes it down, and a session in this one tails the files as a window would. Two ages are taken
after every look of the session:

- since the recorder stamped the bytes: what recording, tailing, decoding and looking cost;
- since the sender sampled: with it the way through UDP, and the wait for the next sample of a
  message, which completes the row before it.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

RATE = 100.0


def send(port: int, seconds: float) -> None:
    """Send volts at 100 Hz, attitude at 50 Hz, stamped with the clock that all processes share."""
    from gsapp.decoding.dialect import dialect

    module = dialect()
    packer = module.MAVLink(None, srcSystem=1, srcComponent=1)
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    volts = [2.5] * 20 + [0.0] * 38
    begin = time.monotonic()
    for k in range(round(seconds * RATE)):
        due = begin + k / RATE
        time.sleep(max(due - time.monotonic(), 0.0))
        now = time.monotonic_ns() // 1000
        messages = [module.MAVLink_debug_float_array_message(now, b"daq", 0, volts)]
        if k % 2 == 0:
            messages.append(module.MAVLink_attitude_message(now // 1000, 0, 0, 0, 0, 0, 0))
        for message in messages:
            line.sendto(bytes(message.pack(packer)), ("127.0.0.1", port))
            packer.seq = (packer.seq + 1) % 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Ages:
    """Ages in ms: of every record when it was in the history, of the newest row at every look."""

    records: np.ndarray
    rows: np.ndarray
    look: np.ndarray

    def sentence(self, name: str) -> str:
        """Return the percentiles."""
        parts = []
        for title, ages in (
            ("arrival to history", self.records),
            ("sampling to history", self.rows),
        ):
            middle, high = np.percentile(ages, (50, 95))
            parts.append(f"{title} median {middle:5.1f}, 95th {high:5.1f}, worst {ages.max():5.1f}")
        cost = np.percentile(self.look, 95)
        return f"{name:22} {'; '.join(parts)} ms; a look takes {cost:.2f} ms (95th)"


def measure(
    seconds: float, period: float, after: Callable[[object], None] = lambda _: None
) -> Ages:
    """Run sender, recorder and session for a while.

    Parameters
    ----------
    seconds : float
        How long to measure.
    period : float
        Between the looks of the session, s.
    after : callable
        Called with the session after each look, such as to paint; its time counts.
    """
    from gsapp.session import Session
    from gsapp.telemetry.recorder_control import start_recorder

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as place:
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(Path(place) / "runtime")
        folder = Path(place) / "flight"
        recorder = start_recorder(f"udpin:127.0.0.1:{port}", folder)
        sender = subprocess.Popen(
            [sys.executable, __file__, "send", str(port), str(seconds + 3.0)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        )
        session = Session.follow(folder, channel_map="b777", aircraft="b777")
        try:
            return _watch(session, seconds, period, after)
        finally:
            sender.kill()
            sender.wait()
            recorder.stop()
            session.close()


def _watch(session, seconds: float, period: float, after: Callable[[object], None]) -> Ages:
    stamps: list[int] = []
    reader = session._reader
    poll = reader._poll

    def listening(limit: int):
        records = poll(limit)
        stamps.extend(record.stamp_us for record in records)
        return records

    reader._poll = listening
    deadline = time.monotonic() + 20.0
    while len(stamps) < 50:
        session.update()
        time.sleep(0.01)
        if time.monotonic() > deadline:
            raise TimeoutError("the sender was not heard")
    records: list[float] = []
    rows: list[float] = []
    look: list[float] = []
    newest = None
    begin = time.monotonic()
    next_look = begin
    while next_look < begin + seconds:
        next_look += period
        time.sleep(max(next_look - time.monotonic(), 0.0))
        stamps.clear()
        start = time.perf_counter()
        session.update()
        after(session)
        look.append(1e3 * (time.perf_counter() - start))
        done_us, now = time.time_ns() // 1000, time.monotonic()
        records += [(done_us - stamp) / 1e3 for stamp in stamps]
        last = session.history.last("q_volts")
        if last is not None and last != newest:
            newest = last
            rows.append(1e3 * (now - last[0]))
    return Ages(records=np.array(records), rows=np.array(rows), look=np.array(look))


def main(*options: str) -> None:
    """Print the ages for a few paces of looking."""
    seconds = 3.0 if "--quick" in options else 10.0
    for period in (0.004, 0.008, 1.0 / 60.0):
        print(measure(seconds, period).sentence(f"a look every {1e3 * period:4.1f} ms"), flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["send"]:
        send(int(sys.argv[2]), float(sys.argv[3]))
    else:
        main(*sys.argv[1:])
