"""All that is watched for alarms in the samples of a flight."""

from __future__ import annotations

from collections.abc import Callable

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.limit_monitor import LimitMonitor
from gsapp.session.limits import LimitSet
from gsapp.session.message_presence import MessagePresenceMonitor


class AlarmMonitor:
    """Watches the samples of a flight for alarms: limits and instruments that fall silent.

    Parameters
    ----------
    board : AlarmRegistry
        Where alarms go.
    rate : float
        Of the grid, Hz.
    group : callable
        What carries a channel; see `MessagePresenceMonitor`.
    together : callable
        Whether two channels come in the same blocks; see `LimitMonitor`.
    """

    def __init__(
        self,
        board: AlarmRegistry,
        limits: LimitSet,
        rate: float,
        group: Callable[[str], str | None],
        together: Callable[[str, str], bool],
    ) -> None:
        self._board = board
        self._limits = LimitMonitor(limits, board, rate, together)
        self._presence = MessagePresenceMonitor(board, group)

    def feed(self, block: Block) -> None:
        self._limits.feed(block)
        self._presence.feed(block)

    def reload_limits(self, channel_id: str) -> None:
        """Take other limits for a channel."""
        self._limits.reload_limits(channel_id)

    def process_step(self) -> None:
        self._presence.process_step()

    def reset(self) -> None:
        self._limits.reset()
        self._presence.reset()
        self._board.reset()
