"""The clocks that links and recorder run on. They are handed in, so that tests can turn them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol


class Clock(Protocol):
    """What a source needs to know of time."""

    def now_us(self) -> int:
        """Return host time, microseconds since 1970 (UTC); every call gives a higher value."""

    def monotonic(self) -> float:
        """Return seconds that never run backwards."""

    def sleep(self, seconds: float) -> None:
        """Wait."""


class HostClock:
    """The computer's clock, kept from running backwards.

    Stamps in one flight must rise: when the computer's clock is set back, they go on from where
    they were, at the right pace. A leap forward is followed.

    Parameters
    ----------
    after_us : int
        Every stamp is higher than this one (the last stamp of a flight that is continued).
    wall_us : callable
        The computer's clock, microseconds since 1970.
    """

    def __init__(
        self, after_us: int = 0, wall_us: Callable[[], int] = lambda: time.time_ns() // 1000
    ) -> None:
        self._last = after_us
        self._correction = 0
        self._wall_us = wall_us
        self._lock = threading.Lock()

    @property
    def correction_us(self) -> int:
        """Return by how much the stamps are ahead of the computer's clock."""
        return self._correction

    def now_us(self) -> int:
        """Return host time, microseconds since 1970 (UTC); every call gives a higher value."""
        with self._lock:
            stamp = self._wall_us() + self._correction
            if stamp <= self._last:
                self._correction += self._last + 1 - stamp
                stamp = self._last + 1
            self._last = stamp
            return stamp

    def monotonic(self) -> float:
        """Return seconds that never run backwards."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)
