"""One flight as a stream of bytes: the live link, the log kept on board, and both as files."""

from __future__ import annotations

import contextlib
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from gsapp.quantities import Block
from gsapp.virtual.dirt import Dirt
from gsapp.virtual.downlink.downlink_transmitter import TransmitProgress
from gsapp.virtual.downlink.onboard_log import OnboardLog
from gsapp.virtual.downlink.onboard_messages import (
    TICK_RATE,
    FrameScheduler,
    Message,
    OnboardSample,
    Packet,
    telemetry_layout,
)
from gsapp.virtual.mission import REPEATED_PHASES, phase_announcement
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.virtual_flight import FlightSegment, FlightSimulation, truth_block


class FlightDownlink:
    """Packs a flight of 100 samples a second as it goes on.

    Parameters
    ----------
    thin : bool
        Send what a 57,600-baud radio carries, and keep the full record on board.
    attitude, position : bool
        Whether the board knows them.
    unix_us : int
        Time of day at which the box is switched on, microseconds since 1970.
    """

    def __init__(
        self,
        flight: FlightSimulation,
        *,
        thin: bool,
        attitude: bool,
        position: bool,
        unix_us: int,
    ) -> None:
        self._flight = flight
        self._unix_us = unix_us
        self._live = FrameScheduler(
            telemetry_layout(thin=thin, attitude_sent=attitude, position_sent=position)
        )
        self._kept: FrameScheduler | None = None
        if thin:
            self._kept = FrameScheduler(
                telemetry_layout(thin=False, attitude_sent=attitude, position_sent=position)
            )
        self._announced: set[str] = set()
        self._phase = ""
        self._flown: list[Block] = []
        self._clock_random = np.random.default_rng((flight.dirt.seed, 0xC1))
        self._waiting: list[bytes] = []  # Frames for the next burst.
        self._stopped = False

    @property
    def finished(self) -> bool:
        return self._stopped or self._flight.finished

    @property
    def crashed(self) -> bool:
        return self._flight.crashed

    @property
    def dirt(self) -> Dirt:
        return self._flight.dirt

    def stop(self) -> None:
        """End the flight where it is, as if the box had been switched off."""
        self._stopped = True

    def truth(self) -> Block:
        """Return the true motion until now, in the channels of `TRUTH_CHANNELS`."""
        return Block.concatenate(self._flown)

    def pack_reply(self, message: Message) -> bytes:
        return self._live.pack(message)

    def advance(self, ticks: int) -> Iterator[Packet]:
        stretch = self._flight.advance(ticks)
        if len(stretch):
            self._flown.append(truth_block([stretch]))
        for index, row in enumerate(stretch.onboard.tolist()):
            yield self._packet(stretch, index, dict(zip(stretch.onboard_names, row, strict=True)))

    def _packet(self, stretch: FlightSegment, index: int, values: Mapping[str, float]) -> Packet:
        number = stretch.first_index + index
        tick = OnboardSample(
            number=number,
            volts=stretch.volts[index],
            values=values,
            unix_us=self._unix_us + number * (1_000_000 // TICK_RATE),
            stamp_us=self._wrong_stamp(number),
        )
        live = self._live.frames(tick)
        kept = self._kept.frames(tick) if self._kept else []
        phase = stretch.phases[index]
        if phase not in self._announced or (phase in REPEATED_PHASES and phase != self._phase):
            self._announced.add(phase)
            text = phase_announcement(phase)
            if text:
                live.append(self._live.pack_text(text))
                if self._kept:
                    kept.append(self._kept.pack_text(text))
        self._phase = phase
        return Packet(
            time=number / TICK_RATE,
            stamp_us=tick.unix_us,
            live_frames=self._in_bursts(number, live),
            onboard_frames=tuple(kept),
            phase=phase,
        )

    def _wrong_stamp(self, number: int) -> int | None:
        """Return the time that dirt makes the box write, microseconds; None for the right one."""
        dirt = self.dirt
        if not (dirt.unstamped_share or dirt.stamp_jitter):
            return None
        if self._clock_random.random() < dirt.unstamped_share:
            return 0
        off = dirt.stamp_jitter * float(self._clock_random.standard_normal())
        # A box reads its clock in order, however late.
        off = min(max(off, -0.4 / TICK_RATE), 0.4 / TICK_RATE)
        return max(round(1e6 * (number / TICK_RATE + off)), 0)

    def _in_bursts(self, number: int, frames: list[bytes]) -> tuple[bytes, ...]:
        """Return the frames to send now: all, or those of the last while where bursts are due."""
        ticks = round(self.dirt.burst_interval * TICK_RATE)
        if ticks == 0:
            return tuple(frames)
        self._waiting += frames
        if number % ticks:
            return ()
        due, self._waiting = tuple(self._waiting), []
        return due


_TICKS_AT_ONCE = 200


def cut_to_maneuvers(packets: Iterable[Packet], dirt: Dirt) -> Iterator[Packet]:
    """Yield the packets that a record cut to its maneuvers holds; all where it is not cut."""
    if not dirt.tail:
        yield from packets
        return
    before: deque[Packet] = deque(maxlen=max(round(dirt.lead * TICK_RATE), 1))
    last = -math.inf
    for packet in packets:
        if packet.phase.startswith("maneuver"):
            last = packet.time
        if packet.time - last > dirt.tail:
            before.append(packet)
            continue
        yield from before
        before.clear()
        yield packet


def write_record(
    downlink: FlightDownlink,
    tlog: Path,
    kept: Path | None,
    *,
    seed: int,
    progress: Callable[[TransmitProgress], None] = lambda _: None,
) -> None:
    """Fly as fast as it goes and write what the ground and the box would have kept.

    The frames in `tlog` have the time at which they would have arrived: a link takes some
    milliseconds, now and then more, by the seed, and frames never overtake each other. The on-board
    log, if any, goes to `kept`. `progress` is told every few seconds of flight.
    """

    def fly() -> Iterator[Packet]:
        while not downlink.finished:
            yield from (packets := list(downlink.advance(_TICKS_AT_ONCE)))
            reached = packets[-1]
            progress(TransmitProgress(time=reached.time, phase=reached.phase, sent_bytes=sent))

    random = np.random.default_rng([seed, 0x11])
    last = 0
    sent = 0
    with contextlib.ExitStack() as stack:
        ground = OnboardLog(tlog)
        stack.callback(ground.close)
        onboard = None
        if kept is not None:
            onboard = OnboardLog(kept)
            stack.callback(onboard.close)
        for packet in cut_to_maneuvers(fly(), downlink.dirt):
            delay = VIRTUAL.travel_time_us + float(random.exponential(VIRTUAL.jitter_us))
            last = max(last + 1, packet.stamp_us + round(delay))
            ground.append(last, packet.live_frames)
            sent += sum(map(len, packet.live_frames))
            if onboard is not None:
                onboard.append(packet.stamp_us, packet.onboard_frames)
