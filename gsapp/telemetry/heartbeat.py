"""The ground station's sign of life, without which many aircraft do not begin to talk."""

from __future__ import annotations

from gsapp.decoding.dialect import dialect

GROUND_SYSTEM = 255
GROUND_COMPONENT = 190


class GroundHeartbeat:
    """Pack HEARTBEAT messages of a ground station, with their own sequence."""

    def __init__(self) -> None:
        self._dialect = dialect()
        self._packer = self._dialect.MAVLink(
            None, srcSystem=GROUND_SYSTEM, srcComponent=GROUND_COMPONENT
        )

    def frame(self) -> bytes:
        names = self._dialect
        message = names.MAVLink_heartbeat_message(
            names.MAV_TYPE_GCS, names.MAV_AUTOPILOT_INVALID, 0, 0, names.MAV_STATE_ACTIVE, 3
        )
        frame = bytes(message.pack(self._packer))
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame
