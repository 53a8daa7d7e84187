"""A flight over a thin link, and the log of a box whose clock is another, and drifts."""

import struct
from pathlib import Path

from fastcrc import crc16

from gsapp.decoding.dialect import time_fields, wire_formats
from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.downlink.onboard_log import pack_tlog_record

BEGUN_US = 1_760_000_000_000_000


def own_time(frame: bytes, offset: float, drift: float) -> bytes:
    number = frame[7] | frame[8] << 8 | frame[9] << 16
    place = time_fields().get(number)
    if place is None or number == 2:  # SYSTEM_TIME says how the two stand: left out
        return b"" if number == 2 else frame
    payload = bytearray(frame[10:-2].ljust(wire_formats()[number].full_size, b"\0"))
    stop = place.offset + place.size
    seconds = int.from_bytes(payload[place.offset : stop], "little") * place.microseconds * 1e-6
    own = round((seconds - offset) * (1.0 + drift) * 1e6 / place.microseconds)
    payload[place.offset : stop] = max(own, 0).to_bytes(place.size, "little")
    body = bytes(payload).rstrip(b"\0") or b"\0"
    head = bytes((frame[0], len(body))) + frame[2:10]
    checksum = crc16.mcrf4xx(head[1:] + body + wire_formats()[number].crc_extra)
    return head + body + struct.pack("<H", checksum)


def fly_thin(
    path: Path, log: Path, *, seconds: float, offset: float = 0.0, drift: float = 0.0
) -> FlightFolder:
    """Record a virtual flight's first seconds over the thin link, and the log of its box.

    Flight time is ``t + offset - drift * t`` of the log's own, to first order.
    """
    settings = FlightSettings(plan="short", thin=True, seed=3)
    folder = prepare_flight_folder(
        path, aircraft="b777", channel_map="b777-thin", calibration="b777", source="virtual"
    )
    downlink = settings.create_downlink(BEGUN_US)
    with folder.tlog_file.open("wb") as live, log.open("wb") as kept:
        while not downlink.finished:
            for packet in downlink.advance(200):
                for frame in packet.live_frames:
                    live.write(pack_tlog_record(packet.stamp_us + 12_000, frame))
                if packet.time < offset + 0.1:
                    continue  # the box was switched on later
                for frame in packet.onboard_frames:
                    if own := own_time(frame, offset, drift):
                        kept.write(pack_tlog_record(packet.stamp_us, own))
                if packet.time >= seconds:
                    downlink.stop()
    return folder
