"""Sending a flight at its own pace, and answering the ground.

One loop serves every link: frames go out when their tick is due, and while it waits for the
next one it listens for requests for the on-board log.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from gsapp.decoding.framing import Framer, MavlinkFrame
from gsapp.telemetry.clock import Clock
from gsapp.virtual.downlink.onboard_log import LogServer, OnboardLog
from gsapp.virtual.downlink.onboard_messages import (
    TICK_RATE,
    Message,
    Packet,
    dialect,
    landed_heartbeat,
)
from gsapp.virtual.settings import VIRTUAL


class TransmitLink(Protocol):
    """The link as the transmitter needs it."""

    def send(self, data: bytes) -> None:
        """Send bytes, or drop them where nobody is there."""

    def receive(self, timeout: float) -> bytes:
        """Return what came, waiting up to `timeout` seconds for it."""


class PacketStream(Protocol):
    """What is sent: a `FlightDownlink`, or another object with its methods."""

    @property
    def finished(self) -> bool:
        """Whether there is nothing more to send."""

    def advance(self, ticks: int) -> Iterator[Packet]:
        """Go on and yield one packet for each tick."""

    def pack_reply(self, message: Message) -> bytes:
        """Return the frame of an answer to the ground."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TransmitProgress:
    """How far the flight has come: time since the box was switched on, s, and what is done."""

    time: float
    phase: str
    sent_bytes: int


class DownlinkTransmitter:
    """Sends one flight over one line.

    Parameters
    ----------
    speed : float
        Times real time; infinite sends as fast as it can.
    thin : bool
        Keep answers within what a 57,600-baud radio carries.
    log, server : OnboardLog and LogServer, or None
        The log kept on board and what hands it out.
    """

    def __init__(
        self,
        stream: PacketStream,
        line: TransmitLink,
        *,
        clock: Clock,
        speed: float = 1.0,
        thin: bool = False,
        log: OnboardLog | None = None,
        server: LogServer | None = None,
    ) -> None:
        self._stream = stream
        self._line = line
        self._clock = clock
        self._speed = speed
        self._rate: float = VIRTUAL.thin_rate if thin else VIRTUAL.full_rate
        self._log = log
        self._server = server
        self._framer = Framer()
        self._decoder = dialect.MAVLink(None)
        self._credit = 0.0
        self.sent_bytes = 0

    def transmit(self, progress: Callable[[TransmitProgress], None] = lambda _: None) -> None:
        """Send the whole flight; `progress` is told every half second of flight."""
        start = self._clock.monotonic()
        # Flown a little ahead of what is sent: a few samples together cost half as much.
        ticks = VIRTUAL.ticks_ahead if self._speed <= 2.0 else VIRTUAL.fast_ticks_ahead
        told = -math.inf
        while not self._stream.finished:
            for packet in self._stream.advance(ticks):
                self._wait_until(start + packet.time / self._speed)
                self._send(packet)
                if packet.time - told >= 0.5:
                    told = packet.time
                    progress(
                        TransmitProgress(
                            time=packet.time, phase=packet.phase, sent_bytes=self.sent_bytes
                        )
                    )
        if self._log is not None:
            self._log.flush()

    def serve_log_requests(self, seconds: float) -> None:
        """Answer the ground after the flight until `seconds` have passed without a request.

        The crew stands beside the aircraft by then, with a cable: answers come at the rate of the
        full link, times the speed of the flight.
        """
        if math.isfinite(self._speed):
            self._rate = VIRTUAL.full_rate * max(self._speed, 1.0)
        end = self._clock.monotonic() + seconds
        sign = self._clock.monotonic()
        while (left := end - self._clock.monotonic()) > 0.0:
            if self._clock.monotonic() >= sign:
                sign += VIRTUAL.heartbeat_interval
                self._line.send(self._stream.pack_reply(landed_heartbeat()))
            if self._hear(self._line.receive(min(left, 1.0 / TICK_RATE))):
                end = self._clock.monotonic() + seconds
            share = self._rate / TICK_RATE
            # What was not asked for in a while does not come all at once later.
            self._credit = min(self._credit + share, 2.0 * share)
            if self._answer():
                end = self._clock.monotonic() + seconds

    def _wait_until(self, due: float) -> None:
        """Let time pass, listening; always listens at least once."""
        while True:
            left = max(due - self._clock.monotonic(), 0.0)
            self._hear(self._line.receive(left))
            if left <= 0.0 or self._clock.monotonic() >= due:
                return

    def _send(self, packet: Packet) -> None:
        data = b"".join(packet.live_frames)
        if data:
            self._line.send(data)
            self.sent_bytes += len(data)
        if self._log is not None:
            self._log.append(packet.stamp_us, packet.onboard_frames)
        self._credit += self._rate / TICK_RATE - len(data)
        self._credit = min(self._credit, VIRTUAL.burst_time * 100.0)
        self._answer()

    def _hear(self, data: bytes) -> bool:
        """Take requests; return whether there was one."""
        if not data or self._server is None:
            return False
        heard = False
        for piece in self._framer.feed(data):
            if isinstance(piece, MavlinkFrame) and piece.known:
                message: Message = self._decoder.decode(bytearray(piece.data))
                heard = self._server.handle_request(message) or heard
        return heard

    def _answer(self) -> bool:
        """Send answers as far as the credit goes; return whether there were any."""
        if self._server is None or self._credit <= 0.0:
            return False
        if self._log is not None:
            self._log.flush()
        answered = False
        for message in self._server.pending_responses(math.ceil(self._credit)):
            frame = self._stream.pack_reply(message)
            self._line.send(frame)
            self.sent_bytes += len(frame)
            self._credit -= len(frame)
            answered = True
        return answered
