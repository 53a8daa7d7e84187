"""What an autopilot reports of flight and ground: HEARTBEAT and EXTENDED_SYS_STATE."""

from __future__ import annotations

import bisect
from typing import Final

from gsapp.decoding.health import AUTOPILOT_COMPONENT, HEARTBEAT_ID, is_vehicle

EXTENDED_SYS_STATE: Final = 245
STATE_MESSAGES: Final = frozenset(
    number.to_bytes(size, "little")
    for number in (HEARTBEAT_ID, EXTENDED_SYS_STATE)
    for size in (1, 3)
)
"""Ids as they stand in headers: one byte in MAVLink 1, three in MAVLink 2."""

_BASE_MODE, _ARMED = 6, 0x80
_LANDED_STATE, _ON_GROUND = 1, 1


class LandedState:
    """Whether the autopilot reports ground, by flight time.

    It does with MAV_LANDED_STATE_ON_GROUND. One that sends no landed state does once it disarms;
    before it was ever armed nothing is known.
    """

    def __init__(self) -> None:
        self._armed: bool | None = None
        self._landed_state = 0
        self._times: list[float] = []
        self._states: list[bool | None] = []

    def update(self, number: int, component: int, payload: bytes, time: float | None) -> None:
        """Take in a message of the flown system.

        Parameters
        ----------
        number : int
            Message id; others than the two are ignored.
        payload : bytes
            Zero bytes at its end may be missing.
        time : float or None
            Flight time of its arrival, s; None before there is one.
        """
        if number == HEARTBEAT_ID and is_vehicle(component, payload) and len(payload) > _BASE_MODE:
            armed = bool(payload[_BASE_MODE] & _ARMED)
            if armed or self._armed is not None:
                self._armed = armed
        elif number == EXTENDED_SYS_STATE and component == AUTOPILOT_COMPONENT:
            self._landed_state = payload[_LANDED_STATE] if len(payload) > _LANDED_STATE else 0
        state = self._state()
        if time is not None and state != (self._states[-1] if self._states else None):
            self._times.append(time)
            self._states.append(state)

    def _state(self) -> bool | None:
        if self._landed_state:
            return self._landed_state == _ON_GROUND
        return None if self._armed is None else not self._armed

    def on_ground(self, time: float) -> bool | None:
        """Return whether ground was reported last by a flight time, s; None if nothing was."""
        place = bisect.bisect_right(self._times, time)
        return self._states[place - 1] if place else None
