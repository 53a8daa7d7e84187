"""Names of flight modes, and parameters, as autopilots send and log them.

ArduPilot numbers its modes by the kind of vehicle (enumerations of its dialect); PX4 by main and
sub mode in its heartbeats, by navigation state in its logs (PX4, commander_state and
vehicle_status).
"""

from __future__ import annotations

import struct
from typing import Final

from gsapp.decoding.dialect import dialect

PARAM_VALUE_ID: Final = 22
ARDUPILOT, PX4 = 3, 12
_PX4_MAIN = {
    1: "MANUAL", 2: "ALTITUDE", 3: "POSITION", 4: "AUTO", 5: "ACRO", 6: "OFFBOARD",
    7: "STABILIZED", 8: "RATTITUDE",
}  # fmt: skip
_PX4_AUTO = {
    1: "READY", 2: "TAKEOFF", 3: "LOITER", 4: "MISSION", 5: "RETURN", 6: "LAND", 8: "FOLLOW",
    9: "PRECISION_LAND",
}  # fmt: skip
_PX4_STATES = {
    0: "MANUAL", 1: "ALTITUDE", 2: "POSITION", 3: "MISSION", 4: "LOITER", 5: "RETURN", 10: "ACRO",
    12: "DESCEND", 13: "TERMINATION", 14: "OFFBOARD", 15: "STABILIZED", 17: "TAKEOFF", 18: "LAND",
    19: "FOLLOW", 20: "PRECISION_LAND", 21: "ORBIT",
}  # fmt: skip
_COPTERS = {2, 3, 4, 13, 14, 15, 29}
_ROVERS = {10, 11}
_SUBMARINE = 12
_INTEGERS = {1: "<B", 2: "<b", 3: "<H", 4: "<h", 5: "<I", 6: "<i"}


def ardupilot_mode(number: int, vehicle: str) -> str:
    """Return the name of a mode of a ``plane``, ``copter``, ``rover`` or ``sub``."""
    kind = f"{vehicle.upper()}_MODE"
    known = dialect().enums.get(kind, {}).get(number)
    return f"mode {number}" if known is None else str(known.name).removeprefix(f"{kind}_")


def px4_state(number: int) -> str:
    """Return the name of a navigation state, as PX4 logs it."""
    return _PX4_STATES.get(number, f"mode {number}")


def heartbeat_mode(payload: bytes) -> str:
    """Return the mode that a heartbeat names; empty for one of no autopilot known here."""
    custom, vehicle, autopilot = struct.unpack_from("<IBB", payload.ljust(9, b"\0"))
    if autopilot == PX4:
        main, sub = custom >> 16 & 0xFF, custom >> 24
        name = _PX4_MAIN.get(main, f"mode {main}")
        return f"{name} {_PX4_AUTO[sub]}" if main == 4 and sub in _PX4_AUTO else name
    if autopilot != ARDUPILOT:
        return ""
    kind = "copter" if vehicle in _COPTERS else "rover" if vehicle in _ROVERS else "plane"
    return ardupilot_mode(custom, "sub" if vehicle == _SUBMARINE else kind)


def parameter_of(payload: bytes, *, bytewise: bool) -> tuple[str, float]:
    """Return name and value of a PARAM_VALUE; PX4 sends integers `bytewise` in the float."""
    whole = payload.ljust(25, b"\0")
    name = whole[8:24].split(b"\0")[0].decode("ascii", "replace")
    form = _INTEGERS.get(whole[24], "<f") if bytewise else "<f"
    return name, float(struct.unpack_from(form, whole)[0])
