"""The virtual aircraft as a link: flown by a process of its own, so that nothing waits for it."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import sys
import tempfile
import time
from multiprocessing.process import BaseProcess
from pathlib import Path

from gsapp.foundation import GroundStationError, LinkError
from gsapp.foundation.process_control import block_sigint
from gsapp.telemetry.clock import Clock, HostClock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.sources.link_source import Chunk, LinkSource
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.settings import VIRTUAL

if sys.platform == "win32":
    from multiprocessing.connection import PipeConnection as PipeEnd
else:
    from multiprocessing.connection import Connection as PipeEnd

_MOST_AT_ONCE = 256


class VirtualSource(LinkSource):
    """Fly the virtual aircraft and receive what its box sends, `speed` times real time.

    The default plan is flown where no settings are given.
    """

    def __init__(
        self,
        address: LinkAddress,
        *,
        clock: Clock,
        settings: FlightSettings | None = None,
        speed: float = 1.0,
    ) -> None:
        super().__init__(address, clock=clock)
        if not speed > 0.0:
            raise LinkError(f"{address}: a speed of {speed} is not possible; use a speed above 0")
        self._settings = settings or FlightSettings()
        self._speed = speed
        self._process: BaseProcess | None = None
        self._connection: PipeEnd | None = None

    def open(self) -> None:
        if self._process is not None or self.finished:
            return
        try:
            # Mistakes in plan or aircraft are told here, not in the other process.
            self._settings.check()
        except GroundStationError as error:
            self.state = str(error)
            self.finished = True
            raise LinkError(str(error)) from error
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(
            target=_fly,
            args=(theirs, self._settings, self._speed),
            name="virtual aircraft",
            daemon=True,
        )
        with block_sigint():
            process.start()
        theirs.close()
        self._process, self._connection = process, ours
        self.connected = True
        self.state = f"{self.address}: flying the plan '{self._settings.plan}'"

    def read(self, timeout: float) -> list[Chunk]:
        with contextlib.suppress(LinkError):
            self.open()
        if self._connection is None:
            self.clock.sleep(timeout)
            return []
        chunks: list[Chunk] = []
        try:
            while len(chunks) < _MOST_AT_ONCE and self._connection.poll(
                0.0 if chunks else max(timeout, 0.0)
            ):
                data = self._connection.recv_bytes()
                chunks.append(Chunk(self.clock.now_us(), data))
            # On Windows the pipe of a process that dies before it took its end does not break.
            if not chunks and not self._flies() and not self._connection.poll():
                self._end()
        except (EOFError, OSError):
            self._end()
        return chunks

    def _flies(self) -> bool:
        return self._process is not None and self._process.is_alive()

    def write(self, data: bytes) -> None:
        if self._connection is not None:
            with contextlib.suppress(OSError, ValueError):
                self._connection.send_bytes(data)

    def close(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._process is not None:
            self._process.terminate()
            self._process.join(2.0)
            self._process = None
        self.finished = True
        self.connected = False
        self.state = f"{self.address}: closed"

    def _end(self) -> None:
        process = self._process
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        failed = False
        if process is not None:
            process.join(2.0)
            failed = process.exitcode not in (0, None)
            self._process = None
        self.finished = True
        self.connected = False
        end = "the simulation failed; see the messages above" if failed else "the flight is over"
        self.state = f"{self.address}: {end}"


class _PipeLink:
    """The transmitter's line to the process that reads."""

    def __init__(self, connection: PipeEnd) -> None:
        self._connection = connection

    def send(self, data: bytes) -> None:
        self._connection.send_bytes(data)

    def receive(self, timeout: float) -> bytes:
        return self._connection.recv_bytes() if self._connection.poll(timeout) else b""


def _fly(connection: PipeEnd, settings: FlightSettings, speed: float) -> None:
    """Fly and send until the flight, or the one who reads, has gone."""
    from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

    # Ctrl-C is meant for the one who reads; when that ends, the pipe does. Windows blocks nothing.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with tempfile.TemporaryDirectory(prefix="virtual-aircraft-") as folder:
        started = time.time_ns() // 1000
        log, server = settings.create_onboard_log(Path(folder) / "onboard.tlog", started)
        transmitter = DownlinkTransmitter(
            settings.create_downlink(started),
            _PipeLink(connection),
            clock=HostClock(),
            speed=speed,
            thin=settings.thin,
            log=log,
            server=server,
        )
        with contextlib.suppress(EOFError, OSError):
            transmitter.transmit()
            if server is not None:
                transmitter.serve_log_requests(VIRTUAL.linger_time)
        if log is not None:
            log.close()
