"""One flight as a stream of bytes: the live link, and the log kept on board."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gsapp.quantities import Block
from gsapp.virtual.downlink.frame_scheduler import FrameScheduler
from gsapp.virtual.downlink.onboard_messages import (
    TICK_RATE,
    Message,
    OnboardSample,
    telemetry_layout,
)
from gsapp.virtual.downlink.packet import Packet
from gsapp.virtual.downlink.phase_announcements import REPEATED_PHASES, phase_announcement
from gsapp.virtual.virtual_flight import (
    FlightSegment,
    FlightSimulation,
    truth_block,
)


class FlightDownlink:
    """Packs a flight as it goes on.

    Parameters
    ----------
    flight : FlightSimulation
        What is flown; 100 samples a second.
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
        self._stopped = False

    @property
    def finished(self) -> bool:
        return self._stopped or self._flight.finished

    @property
    def crashed(self) -> bool:
        return self._flight.crashed

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
            time=tick.micros * 1e-6,
            stamp_us=tick.unix_us,
            live_frames=tuple(live),
            onboard_frames=tuple(kept),
            phase=phase,
        )
