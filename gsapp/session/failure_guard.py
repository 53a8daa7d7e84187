"""Parts of a flight that may fail without holding up anything else."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeVar

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.consumer_scheduler import Consumer, SlowConsumer
from gsapp.session.limits import Severity

T = TypeVar("T")

log = logging.getLogger(__name__)


class FailureGuard:
    """Does steps until one fails; then it raises an alarm, and does no more of them.

    Parameters
    ----------
    key : str
        Of the alarm.
    what : str
        What is missing then, as a sentence begins.
    severity : Severity
        How bad that is.
    board : AlarmRegistry
        Where it is said.
    now : callable
        Flight time, s.

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
        board: AlarmRegistry,
        now: Callable[[], float | None],
    ) -> None:
        self.failure = ""
        self._key = key
        self._what = what
        self._severity = severity
        self._board = board
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
            self._board.raise_(self._key, self._severity, self._now(), self.failure)
            return None

    def reset(self) -> None:
        """Begin anew: the next step is done again."""
        self.failure = ""


class GuardedConsumer:
    """Hands samples on to a consumer until that fails; then it says so, and does without.

    Neither the other consumers nor the reading of the record are held up.

    Parameters
    ----------
    consumer : Consumer
        Who watches the samples.
    guard : FailureGuard
        Of this consumer alone.
    """

    def __init__(self, consumer: Consumer, guard: FailureGuard) -> None:
        self._consumer = consumer
        self._guard = guard
        self._busy = consumer if isinstance(consumer, SlowConsumer) else None

    def feed(self, block: Block) -> None:
        """Hand on the next samples of some channels."""
        self._guard.attempt(lambda: self._consumer.feed(block))

    def process_step(self) -> None:
        """Let it judge what is complete, after all blocks of a step."""
        self._guard.attempt(self._consumer.process_step)

    def has_pending_work(self, time: float) -> bool:
        """Return whether it has work to do before samples up to a flight time (s) come."""
        busy = self._busy
        return busy is not None and bool(self._guard.attempt(lambda: busy.has_pending_work(time)))

    def reset(self) -> None:
        """Begin anew, as before the first sample."""
        self._guard.reset()
        self._consumer.reset()
