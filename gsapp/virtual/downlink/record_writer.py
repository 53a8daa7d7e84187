"""A virtual flight written as a recorder would have written it, without waiting."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gsapp.virtual.downlink.downlink_transmitter import TransmitProgress
from gsapp.virtual.downlink.flight_downlink import FlightDownlink
from gsapp.virtual.downlink.onboard_log import OnboardLog
from gsapp.virtual.settings import VIRTUAL

_TICKS_AT_ONCE = 200


def write_record(
    downlink: FlightDownlink,
    tlog: Path,
    kept: Path | None,
    *,
    seed: int,
    progress: Callable[[TransmitProgress], None] = lambda _: None,
) -> None:
    """Fly as fast as it goes and write what the ground and the box would have kept.

    Parameters
    ----------
    downlink : FlightDownlink
        The flight.
    tlog : Path
        Frames with the time at which they would have arrived: a link takes some milliseconds,
        now and then more, and frames never overtake each other.
    kept : Path or None
        Where the on-board log goes.
    seed : int
        Of the link's delays.
    progress : callable
        Told every few seconds of flight.
    """
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
        while not downlink.finished:
            for packet in downlink.advance(_TICKS_AT_ONCE):
                delay = VIRTUAL.travel_time_us + float(random.exponential(VIRTUAL.jitter_us))
                last = max(last + 1, packet.stamp_us + round(delay))
                ground.append(last, packet.live_frames)
                sent += sum(map(len, packet.live_frames))
                if onboard is not None:
                    onboard.append(packet.stamp_us, packet.onboard_frames)
            progress(TransmitProgress(time=packet.time, phase=packet.phase, sent_bytes=sent))
