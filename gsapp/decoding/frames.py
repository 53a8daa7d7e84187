"""What comes out of a framer: whole frames, and the bytes between them."""

from __future__ import annotations

from typing import NamedTuple


class MavlinkFrame(NamedTuple):
    """One whole MAVLink frame, checked as far as its id is known."""

    offset: int  # Position of its first byte in the stream since the link was opened.
    data: bytes  # The frame from magic byte to checksum (and signature, if signed).
    version: int  # 1 or 2.
    sequence: int
    system: int
    component: int
    message_id: int
    """From the header."""
    known: bool  # Whether the id is in the dialect, so that the checksum could be verified.

    @property
    def payload(self) -> bytes:
        """Return the payload as sent; MAVLink 2 cuts trailing zero bytes."""
        start = 10 if self.version == 2 else 6
        return self.data[start : start + self.data[1]]


class Residue(NamedTuple):
    """Bytes that belong to no whole frame."""

    offset: int  # Position of the first byte in the stream.
    data: bytes
