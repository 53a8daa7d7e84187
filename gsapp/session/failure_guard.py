"""Parts of a flight that may fail without holding up anything else."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeVar

from gsapp.foundation import GroundStationError
from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.consumer_scheduler import Consumer, SlowConsumer
from gsapp.session.limits import Severity
from gsapp.session.monitor_settings import MONITORS

T = TypeVar("T")


log = logging.getLogger(__name__)


class FailureGuard:
    """Does steps until one fails; then it raises an alarm, and does no more of them.

    Parameters
    ----------
    what : str
        What is missing then, as a sentence begins.

    Attributes
    ----------
    failure : str
        Why nothing is done any more, in words; empty while all is well.
    """

    def __init__(
        self,
        key: str,
        what: str,
        severity: Severity,
        registry: AlarmRegistry,
        now: Callable[[], float | None],
    ) -> None:
        self.failure = ""
        self._key = key
        self._what = what
        self._severity = severity
        self._registry = registry
        self._now = now

    def attempt(self, step: Callable[[], T]) -> T | None:
        """Do a step and return what it returns; None if it fails, or one before did."""
        if self.failure:
            return None
        try:
            return step()
        except Exception as error:
            log.exception("%s", self._what)
            self.failure = (
                f"{self._what}: the program failed ({error!r}); close the flight and open it again"
            )
            self._registry.raise_(self._key, self._severity, self._now(), self.failure)
            return None

    def reset(self) -> None:
        self.failure = ""


class RetriedSteps:
    """Does steps of a live flight; one that fails is tried again after a while."""

    def __init__(self) -> None:
        self.failures: dict[str, str] = {}
        self._next_attempt: dict[str, float] = {}

    def attempt(self, name: str, step: Callable[[], None], now: float) -> None:
        """Do a step at clock time `now` (s), unless it failed a moment ago."""
        if now < self._next_attempt.get(name, now):
            return
        try:
            step()
        except Exception as error:
            self._next_attempt[name] = now + MONITORS.consumer_retry
            text = str(error)
            if not isinstance(error, GroundStationError):
                text = f"internal error ({error!r}); the log has more"
            if text != self.failures.get(name):
                self.failures[name] = text
                log.error("a live flight cannot be followed", exc_info=error)
        else:
            self.failures.pop(name, None)


class GuardedConsumer:
    """Hands samples on to a consumer until that fails; then it says so, and does without.

    Neither the other consumers nor the reading of the record are held up.
    """

    def __init__(self, consumer: Consumer, guard: FailureGuard) -> None:
        self._consumer = consumer
        self._guard = guard
        self._busy = consumer if isinstance(consumer, SlowConsumer) else None

    def feed(self, block: Block) -> None:
        self._guard.attempt(lambda: self._consumer.feed(block))

    def process_step(self) -> None:
        self._guard.attempt(self._consumer.process_step)

    def has_pending_work(self, time: float) -> bool:
        busy = self._busy
        return busy is not None and bool(self._guard.attempt(lambda: busy.has_pending_work(time)))

    def reset(self) -> None:
        self._guard.reset()
        self._consumer.reset()
