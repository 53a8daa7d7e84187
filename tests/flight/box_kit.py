"""What the flight tests share: a record as the box of the B777 sends it."""

import os
import struct

import numpy as np

from calibration import load_certificates

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import all as dialect

START_US = 1_760_000_000_000_000
Q_PLACE, ALPHA_PLACE = 8, 5


def box_tlog(seconds=3.0, *, start_s=10.0, lost=(), every=1, motion=np.sin, clock_s=0.0):
    """Return a .tlog as the B777 box sends it: q = 0.2 motion(t) rad/s, alpha = 3 deg."""
    certificates = load_certificates("b777")
    sender = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    data = bytearray()

    def put(message, stamp_us):
        frame = message.pack(sender)
        sender.seq = (sender.seq + 1) % 256
        data.extend(struct.pack(">Q", START_US + stamp_us) + frame)

    put(
        sender.heartbeat_encode(
            dialect.MAV_TYPE_FIXED_WING, dialect.MAV_AUTOPILOT_GENERIC, 0, 0, 0
        ),
        0,
    )
    for k in range(0, round(seconds * 100), every):
        time = start_s + k / 100
        volts = [2.5] * 20 + [0.0] * 38
        volts[Q_PLACE] = float(certificates["q"].volts(0.2 * motion(time)))
        volts[ALPHA_PLACE] = float(certificates["alpha"].volts(np.deg2rad(3.0)))
        message = sender.debug_float_array_encode(round((time + clock_s) * 1e6), b"daq", 0, volts)
        if k in lost:
            message.pack(sender)
            sender.seq = (sender.seq + 1) % 256
            continue
        put(message, k * 10_000)
        if k == 50:
            put(sender.statustext_encode(dialect.MAV_SEVERITY_INFO, b"recorder ready"), k * 10_000)
    return bytes(data)
