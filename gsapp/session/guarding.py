"""A consumer of a live flight that may fail without holding up anything else."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeVar

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmBoard
from gsapp.session.following import Busy, Consumer
from gsapp.session.limits import Severity

T = TypeVar("T")

log = logging.getLogger(__name__)


class Guarded:
    """Hands samples on to a consumer until that fails; then it says so, and does without.

    Neither the other consumers nor the reading of the record are held up.

    Parameters
    ----------
    consumer : Consumer
        Who watches the samples.
    what : str
        What is missing without it, as a sentence begins.
    severity : Severity
        How bad that is.
    board : AlarmBoard
        Where it is said.
    now : callable
        Flight time, s.
    """

    def __init__(
        self,
        consumer: Consumer,
        what: str,
        severity: Severity,
        board: AlarmBoard,
        now: Callable[[], float | None],
    ) -> None:
        self._consumer = consumer
        self._what = what
        self._severity = severity
        self._board = board
        self._now = now
        self._failed = False
        self._busy = consumer if isinstance(consumer, Busy) else None

    def feed(self, block: Block) -> None:
        """Hand on the next samples of some channels."""
        self._try(lambda: self._consumer.feed(block))

    def settle(self) -> None:
        """Let it judge what is complete, after all blocks of a step."""
        self._try(self._consumer.settle)

    def busy(self, time: float) -> bool:
        """Return whether it has work to do before samples up to a flight time (s) come."""
        busy = self._busy
        return busy is not None and bool(self._try(lambda: busy.busy(time)))

    def reset(self) -> None:
        """Begin anew, as before the first sample."""
        self._failed = False
        self._consumer.reset()

    def _try(self, step: Callable[[], T]) -> T | None:
        if self._failed:
            return None
        try:
            return step()
        except Exception as error:
            log.exception("%s", self._what)
            self._failed = True
            words = (
                f"{self._what}: the program failed ({error!r}); close the flight and attach to it "
                "again"
            )
            self._board.raise_(
                f"failed:{type(self._consumer).__name__}", self._severity, self._now(), words
            )
            return None
