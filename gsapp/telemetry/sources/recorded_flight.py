"""A recorded flight as a source: its raw bytes at the pace at which they came."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from pathlib import Path

from gsapp.flight.raw_files import FRAMES_FILE, LINES_FILE, RAW_FILES, RawTail, read_nonempty_tlog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError, GroundStationError, LinkError
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import Chunk, LinkSource

_MOST_AT_ONCE = 256


class RecordedSource(LinkSource):
    """Play the raw files of a flight folder, or a ``.tlog``.

    A speed of 1 is the pace of the flight; infinite is as fast as it is read. Pauses in the record
    of more than ten seconds are cut to ten.
    """

    def __init__(self, address: LinkAddress, *, clock: Clock, speed: float = 1.0) -> None:
        super().__init__(address, clock=clock)
        if not speed > 0.0:
            raise LinkError(f"{address}: a speed of {speed} is not possible; use a speed above 0")
        self._speed = speed
        self._records: Iterator[RawRecord] | None = None
        self._ahead: deque[RawRecord] = deque(maxlen=1)
        self._due = 0.0
        self._last_stamp: int | None = None

    def open(self) -> None:
        if self._records is not None or self.finished:
            return
        path = Path(self.address.path)
        try:
            self._records = self._open(path)
            if (first := next(self._records, None)) is not None:
                self._ahead.append(first)
        except GroundStationError as error:
            self._records = None
            self.state = str(error)
            raise LinkError(str(error)) from error
        self._due = self.clock.monotonic()
        self.connected = True
        self.state = f"{self.address}: playing"

    def _open(self, path: Path) -> Iterator[RawRecord]:
        if path.is_dir():
            if not any((path / name).exists() for name in RAW_FILES):
                raise FlightError(
                    f"{path} holds no raw record ({', '.join(RAW_FILES)}); choose a flight folder"
                )
            if (path / LINES_FILE).exists() and not (path / FRAMES_FILE).exists():
                self.framing = "text"
            return _all_records(RawTail(path))
        if path.suffix.lower() != ".tlog":
            raise FlightError(
                f"{path} is no raw record; only a flight folder or a .tlog can be played as a link"
            )
        return read_nonempty_tlog(path)

    def read(self, timeout: float) -> list[Chunk]:
        try:
            self.open()
        except LinkError:
            self.clock.sleep(timeout)
            return []
        if self._records is None or self.finished:
            self.clock.sleep(timeout)
            return []
        deadline = self.clock.monotonic() + timeout
        chunks: list[Chunk] = []
        while len(chunks) < _MOST_AT_ONCE:
            if not self._ahead:
                self._end()
                break
            record = self._ahead[0]
            due = self._due_time(record)
            now = self.clock.monotonic()
            if due > now:
                if chunks:
                    break
                self.clock.sleep(min(due, deadline) - now if deadline > now else 0.0)
                if due > deadline:
                    break
            self._due, self._last_stamp = due, record.stamp_us
            self._advance()
            data = record.data + b"\n" if record.kind == "line" else record.data
            chunks.append(Chunk(self.clock.now_us(), data, record.origin.address))
        return chunks

    def _due_time(self, record: RawRecord) -> float:
        if self._last_stamp is None or math.isinf(self._speed):
            return self._due
        pause = (record.stamp_us - self._last_stamp) / 1e6
        return self._due + min(max(pause, 0.0), TELEMETRY.max_replayed_pause) / self._speed

    def _advance(self) -> None:
        self._ahead.clear()
        try:
            if self._records is not None and (record := next(self._records, None)) is not None:
                self._ahead.append(record)
        except GroundStationError as error:
            self._end(str(error))

    def _end(self, why: str = "") -> None:
        if not self.finished:
            self.state = why or f"{self.address}: at its end"
        self.finished = True
        self.connected = False

    def write(self, data: bytes) -> None: ...

    def close(self) -> None:
        self._records = None
        self.finished = True
        self.connected = False
        self.state = f"{self.address}: closed"


def _all_records(tail: RawTail) -> Iterator[RawRecord]:
    while records := tail.poll(4096):
        yield from records
