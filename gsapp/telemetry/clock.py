"""The clocks that links and recorder run on. They are handed in, so that tests can turn them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol


class Clock(Protocol):
    """What a source needs to know of time."""

    @property
    def correction_us(self) -> int:
        """Return by how much the stamps are ahead of the computer's clock."""

    def now_us(self) -> int:
        """Return host time, microseconds since 1970 (UTC); every call gives a higher value."""

    def monotonic(self) -> float:
        """Return seconds that never run backwards."""

    def sleep(self, seconds: float) -> None: ...


class HostClock:
    """The computer's clock, kept from running backwards.

    Stamps in one flight must rise: when the computer's clock is set back, they go on from where
    they were, at the right pace. A leap forward is followed. A clock that stands still between
    ticks (on Windows for up to 16 ms) is waited for, lest every stamp push it a little further.
    Every stamp is higher than `after_us` (the last stamp of a flight that is continued); `wall_us`
    is the computer's clock, microseconds since 1970.
    """

    def __init__(
        self, after_us: int = 0, wall_us: Callable[[], int] = lambda: time.time_ns() // 1000
    ) -> None:
        self._last = after_us
        self._wall_us = wall_us
        self._wall = wall_us()
        self._correction = max(after_us - self._wall, 0)
        self._lock = threading.Lock()

    @property
    def correction_us(self) -> int:
        return self._correction

    def now_us(self) -> int:
        with self._lock:
            wall = self._wall_us()
            self._correction += max(self._wall - wall, 0)
            self._wall = wall
            self._last = max(wall + self._correction, self._last + 1)
            return self._last

    def monotonic(self) -> float:
        # The same clock as time.monotonic, but on Windows, where that stands still for 16 ms.
        return time.perf_counter()

    def sleep(self, seconds: float) -> None:
        time.sleep(seconds)
