"""The box itself: numbers its frames, decides which are due, and what leaves it at one tick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gsapp.virtual.downlink.onboard_messages import (
    Message,
    MessageSlot,
    OnboardSample,
    dialect,
    status_text,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Packet:
    """What leaves the box at one tick."""

    time: float  # s since the box was switched on.
    stamp_us: int  # The box's time of day, microseconds since 1970.
    live_frames: tuple[bytes, ...]  # Frames for the link.
    onboard_frames: tuple[bytes, ...]  # Frames for the on-board log; empty where there is none.
    phase: str  # What the pilot is doing.


class FramePacker:
    """Packs messages into MAVLink 2 frames with a sequence number of their own."""

    def __init__(self) -> None:
        self._mavlink = dialect.MAVLink(None, srcSystem=1, srcComponent=1)

    def pack(self, message: Message) -> bytes:
        """Return the frame of a message; the sequence number goes on by one."""
        frame = bytes(message.pack(self._mavlink))
        self._mavlink.seq = (self._mavlink.seq + 1) % 256
        return frame


class FrameScheduler:
    """Turns ticks into the frames of one link.

    Two boxes with different layouts make the live link and the on-board log of one flight.
    """

    def __init__(self, slots: Sequence[MessageSlot]) -> None:
        self._slots = tuple(slots)
        self._packer = FramePacker()

    def frames(self, tick: OnboardSample) -> list[bytes]:
        """Return the frames due at this tick, in the order in which they are sent."""
        return [
            self._packer.pack(slot.pack(tick))
            for slot in self._slots
            if tick.number % slot.every == slot.offset
        ]

    def pack_text(self, text: str) -> bytes:
        return self._packer.pack(status_text(text))

    def pack(self, message: Message) -> bytes:
        return self._packer.pack(message)
