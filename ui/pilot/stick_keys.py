"""Keys as sticks: which are pressed, and where that pushes. No Qt widgets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import Qt

from ui.translation import QT_TR_NOOP

_STICK_KEYS: Final[Mapping[Qt.Key, tuple[str, float]]] = {
    Qt.Key.Key_Down: ("pitch", 1.0),
    Qt.Key.Key_Up: ("pitch", -1.0),
    Qt.Key.Key_Right: ("roll", 1.0),
    Qt.Key.Key_Left: ("roll", -1.0),
    Qt.Key.Key_D: ("yaw", 1.0),
    Qt.Key.Key_A: ("yaw", -1.0),
}
"""Sticks: while a key is down. The stick is pulled with Down, as it is towards oneself."""
_LEVER_KEYS: Final[Mapping[Qt.Key, tuple[str, float]]] = {
    Qt.Key.Key_W: ("throttle", 0.04),
    Qt.Key.Key_S: ("throttle", -0.04),
}
"""The throttle lever moves by so much of its travel at each press, and stays."""
_TRIM_STEP: Final = 0.02
"""Share of a trim lever's travel at each press of a stick's key with Ctrl."""
_TRAVEL_KEYS: Final[Mapping[Qt.Key, float]] = {
    Qt.Key.Key_1: 0.25,
    Qt.Key.Key_2: 1.0 / 3.0,
    Qt.Key.Key_3: 0.5,
    Qt.Key.Key_4: 2.0 / 3.0,
    Qt.Key.Key_5: 1.0,
}
"""How far a key pushes its stick, as the words of the cues go: quarter, third, half ..."""
STICK_TRAVEL_TEXTS: Final[Mapping[float, str]] = {
    0.25: QT_TR_NOOP("quarter stick"),
    1.0 / 3.0: QT_TR_NOOP("third of stick"),
    0.5: QT_TR_NOOP("half stick"),
    2.0 / 3.0: QT_TR_NOOP("two thirds"),
    1.0: QT_TR_NOOP("full stick"),
}
_RATE_KEYS: Final[Mapping[Qt.Key, bool]] = {Qt.Key.Key_9: False, Qt.Key.Key_0: True}
"""Position of the rate switch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StickPosition:
    """Where the keys push, -1 to 1; pulled, right, right are positive."""

    pitch: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LeverStep:
    """A lever to be moved by a share of its travel."""

    axis: str
    step: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StickTravel:
    """How far keys push from now on, as a share of full stick."""

    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RateSwitch:
    """Position of the rate switch."""

    high: bool


StickAction = LeverStep | StickTravel | RateSwitch
"""What a press does once, beside pushing a stick."""


class StickKeys:
    """The keys that are down.

    Two keys of one stick that are down together push it the way of the later one, as a thumb goes
    from one side to the other.
    """

    def __init__(self) -> None:
        self._down: list[Qt.Key] = []

    @staticmethod
    def is_stick_key(key: Qt.Key) -> bool:
        return key in _STICK_KEYS or key in _LEVER_KEYS or key in _TRAVEL_KEYS or key in _RATE_KEYS

    def press(self, key: Qt.Key, *, trim: bool, again: bool) -> StickAction | None:
        """Take a key that went down; return what it does once.

        Parameters
        ----------
        trim : bool
            Whether Ctrl is down, which makes the key of a stick one of its trim lever.
        """
        if key in _STICK_KEYS:
            axis, way = _STICK_KEYS[key]
            if trim:
                return LeverStep(axis=axis, step=way * _TRIM_STEP)
            if not again:
                self.release(key)
                self._down.append(key)
            return None
        if key in _LEVER_KEYS:
            axis, by = _LEVER_KEYS[key]
            return LeverStep(axis=axis, step=by)
        if key in _TRAVEL_KEYS and not again:
            return StickTravel(share=_TRAVEL_KEYS[key])
        if key in _RATE_KEYS and not again:
            return RateSwitch(high=_RATE_KEYS[key])
        return None

    def release(self, key: Qt.Key) -> None:
        if key in self._down:
            self._down.remove(key)

    def release_all(self) -> None:
        """Take all hands off the sticks, as when the window is left."""
        self._down.clear()

    @property
    def position(self) -> StickPosition:
        axes = dict(_STICK_KEYS[key] for key in self._down)
        return StickPosition(**axes)
