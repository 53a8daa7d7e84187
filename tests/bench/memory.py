"""(e) Memory over simulated hours of a flight at the full rate of the aircraft's box.

The frames of a virtual flight in the air, with maneuvers, are sent again and again, with stamps,
sequence numbers and checksums that go on, down the whole road: framed and written as the recorder
does it, read back from the growing files, decoded, kept, watched for alarms and cues, estimated by
FTR and maximum likelihood, and painted by strip charts. All of it happens in this process, as fast
as it goes, but for the fits, which have their own, as beside a window. Time is simulated; nothing
knows the difference. MINUTES of it follow as an argument (60).

What counts is the memory that belongs to no file. The samples of a flight lie in a temporary
file, of which the system keeps in memory what it has room for.
"""

import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fastcrc import crc16

from gsapp.decoding.dialect import time_fields, wire_formats
from gsapp.flight.raw_files import RawTail, RawWriter
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.recorder import Recorder
from gsapp.telemetry.sources import Chunk, LinkSource

FLIGHT = 200.0  # s of flight that repeat
START_US = 1_700_000_000_000_000
TOLD = (1, 5, 10, 20, 30, 40, 50, 60)  # minutes
LOOK = 0.2  # simulated seconds between two looks of the session
_SYSTEM_TIME = 2


@dataclass(slots=True)
class SimulatedTime:
    seconds: float = 0.0
    correction_us: int = 0

    def now_us(self) -> int:
        return START_US + round(1e6 * self.seconds)

    def monotonic(self) -> float:
        return self.seconds

    def sleep(self, seconds: float) -> None:
        """Never wait."""


class SilentSource(LinkSource):
    """A link of which nothing is read: what comes is handed to the recorder."""

    def open(self) -> None: ...

    def read(self, _timeout: float) -> list[Chunk]:
        return []

    def write(self, data: bytes) -> None: ...

    def close(self) -> None: ...


def endless(flight: Path) -> Iterator[tuple[float, bytes]]:
    """Yield host time (s) and frame of a flight that never ends, made from a short one."""
    records = [record for record in RawTail(flight).poll() if record.kind == "frame"]
    begin = records[0].stamp_us
    length = 1 + (records[-1].stamp_us - begin) // 1_000_000  # whole seconds
    times, wire = time_fields(), wire_formats()
    prepared = []
    for record in records:
        data = bytearray(record.data)
        number = int.from_bytes(data[7:10], "little")
        body = 10 + data[1]
        stamp = times.get(number)
        places = []
        if stamp is not None:
            places.append((10 + stamp.offset, stamp.size, 1_000_000 // stamp.microseconds))
        if number == _SYSTEM_TIME:
            places.append((18, 4, 1000))
        # What ends in zeros was sent without them; a stamp is never cut.
        missing = max((place + size for place, size, _ in places), default=body) - body
        if missing > 0:
            data[body:body] = bytes(missing)
            body += missing
            data[1] += missing
        prepared.append(
            ((record.stamp_us - begin) / 1e6, data, body, wire[number].crc_extra, places)
        )
    sequence = round_number = 0
    while True:
        passed = round_number * length
        for at, data, body, extra, places in prepared:
            if round_number:
                for place, size, per_second in places:
                    value = int.from_bytes(data[place : place + size], "little")
                    value = (value + length * per_second) % (1 << 8 * size)  # some turn over
                    data[place : place + size] = value.to_bytes(size, "little")
            data[4] = sequence
            sequence = (sequence + 1) % 256
            checksum = crc16.mcrf4xx(bytes(data[1:body]) + extra)
            data[body : body + 2] = checksum.to_bytes(2, "little")
            yield at + passed, bytes(data)
        round_number += 1


def anonymous_memory(process: int | str = "self") -> float | None:
    status = Path(f"/proc/{process}/status")
    if not status.exists():
        return None
    for line in status.read_text(encoding="ascii").splitlines():
        if line.startswith("RssAnon:"):
            return int(line.split()[1]) / 1024.0
    return None


def children_memory() -> float:
    """Return the memory of the largest process that this one began, MB."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text(encoding="ascii")
    return max((anonymous_memory(int(one)) or 0.0 for one in children.split()), default=0.0)


@dataclass(slots=True)
class Road:
    """Recorder, session and charts of one flight."""

    flight: Path
    folder: Path
    clock: SimulatedTime = field(default_factory=SimulatedTime)
    messages: int = 0

    def run(self, minutes: int, each_minute: Callable[[int, object], None]) -> None:
        """Let so many minutes of flight happen."""
        from PySide6.QtWidgets import QApplication

        from gsapp.session import Session
        from gsapp.session.live_estimation.fit_workers import ProcessFitWorker
        from ui.flight.chart_selection import OVERVIEW_LAYOUT, create_shipped_layout
        from ui.strips.strip_chart import StripChart

        application = QApplication.instance() or QApplication([])
        source = SilentSource(parse_link("udpin:127.0.0.1:14550"), clock=self.clock)
        source.connected = True
        recorder = Recorder(source, RawWriter(self.folder), clock=self.clock)
        stream = endless(self.flight)
        self._send(recorder, stream, LOOK)
        session = Session.follow(
            self.folder,
            channel_map="b777",
            aircraft="b777",
            clock=self.clock.monotonic,
            wall_us=self.clock.now_us,
            workers=ProcessFitWorker(),
        )
        chart = StripChart(timed=False)
        chart.resize(1280, 800)
        chart.set_layout(create_shipped_layout(OVERVIEW_LAYOUT, tuple(session.sources)))
        chart.show()
        chart.set_history(session.history)
        looks = round(1.0 / LOOK)
        for second in range(60 * minutes):
            for look in range(looks):
                self._send(recorder, stream, second + (look + 1) * LOOK)
                session.update()
                session.estimates.fits.wait()
            recorder.status("recording")
            session.snapshot()
            session.messages()
            chart.set_now(session.now)
            chart.advance()
            application.processEvents()
            if second % 60 == 59:
                each_minute(second // 60 + 1, session)
        recorder.finish()
        chart.close()
        chart.deleteLater()
        application.processEvents()
        session.close()

    def _send(self, recorder: Recorder, stream: Iterator[tuple[float, bytes]], until: float):
        while self.clock.seconds < until:
            at, frame = next(stream)
            self.clock.seconds = at
            self.messages += 1
            recorder.write_chunks([Chunk(self.clock.now_us(), frame)])


def main(*options: str) -> dict[int, float]:
    """Print the memory as the flight goes on; return it by minute, MB."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from tests.bench import estimates_live

    minutes = next((int(one) for one in options if one.isdigit()), 0)
    minutes = minutes or (5 if "--quick" in options else 60)
    found: dict[int, float] = {}
    with tempfile.TemporaryDirectory() as scratch:
        flight = Path(scratch) / "flight"
        flight.mkdir()
        seconds = estimates_live.fly(flight / "raw.tlog", FLIGHT)
        print(f"    a virtual flight to begin with: {seconds:.0f} s", flush=True)
        road = Road(flight, Path(scratch) / "hour")
        started = time.monotonic()

        def tell(minute: int, session) -> None:
            if minute not in (*TOLD, minutes) and minute % 30:
                return
            gc.collect()
            used = anonymous_memory()
            if used is None:
                print("    this system does not tell; nothing measured")
                return
            found[minute] = used
            rows = round(60 * minute * session.history.rate)
            print(
                f"    after {minute:3} min {used:7.1f} MB   {road.messages:9,} messages, "
                f"{len(session.history.channels)} channels of {rows:,} samples, "
                f"{len(session.estimates.result.results)} fits in {children_memory():.0f} MB, "
                f"{len(list(Path('/proc/self/fd').iterdir()))} handles",
                flush=True,
            )

        road.run(minutes, tell)
        passed = time.monotonic() - started
    if found:
        first = min(minute for minute in found if minute >= min(10, minutes))
        last = max(found)
        if last > first:
            grown = found[last] - found[first]
            print(f"    growth from minute {first} to {last}: {grown:+.1f} MB")
    print(
        f"    {minutes} min of flight in {passed:.0f} s: {road.messages / passed:,.0f} messages/s "
        "through all of it in one process"
    )
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
