"""Watching for messages that stay away."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.limits import Severity


class MessagePresenceMonitor:
    """Raises an alarm for a message that stays away while others still come.

    Instruments are watched by the message that carries them: one alarm for a box that falls
    silent, not one for each of its channels.

    Presence is kept in ticks of a quarter of a second of flight time, each judged a second
    late, when all that belongs to it has arrived; so a replay judges as the live flight did.
    Ticks in which nothing came at all do not count: a link that was lost is no message's fault.
    A message that comes rarely is given three times as long as it usually takes, so that neither
    one that was lost nor a break of the link makes it one that stays away.

    Parameters
    ----------
    registry : AlarmRegistry
        Where the alarms go.
    group : callable
        What carries a channel, from its id; None for a channel that is not watched.
    patience : float
        Seconds of silence, while others come, after which it counts as lost, at least.
    """

    TICK = 0.25
    _DELAY = 4  # ticks
    _PERIODS = 3
    _MAX_TIMEOUT = 40  # ticks
    _INTERVAL_COUNT = 5  # distances of a message that tell how often it comes

    def __init__(
        self, registry: AlarmRegistry, group: Callable[[str], str | None], patience: float = 3.0
    ) -> None:
        self._registry = registry
        self._group = group
        self._min_timeout = max(1, math.ceil(patience / self.TICK))
        self._members: dict[tuple[str, ...], dict[str, list[int]]] = {}
        self._front: int | None = None
        self._judged: int | None = None  # the last tick
        self._count = 0  # of ticks judged in which anything came
        self._last: dict[str, int] = {}  # of these, the one in which each came last
        self._distances: dict[str, npt.NDArray[np.intp]] = {}  # the newest, in these
        self._coming: dict[str, list[npt.NDArray[np.int64]]] = {}

    def reset(self) -> None:
        self._front = self._judged = None
        self._count = 0
        self._last.clear()
        self._distances.clear()
        self._coming.clear()

    def feed(self, block: Block) -> None:
        if not len(block):
            return
        ticks = np.floor_divide(block.times + 1e-6, self.TICK).astype(np.int64)
        missing: npt.NDArray[np.bool_] = np.isnan(block.values)
        if missing.any():
            present = np.logical_not(missing)
            rows = np.flatnonzero(np.any(present, axis=1))
            if not rows.size:
                return
            newest = int(ticks[rows[-1]])
            for name, members in self._groups(block.channels).items():
                self._note(name, ticks[np.any(present[:, members], axis=1)])
        else:
            newest = int(ticks[-1])
            for name in self._groups(block.channels):
                self._note(name, ticks)
        self._front = newest if self._front is None else max(self._front, newest)
        if self._judged is None:
            self._judged = int(ticks[0]) - 1

    def _groups(self, channels: tuple[str, ...]) -> dict[str, list[int]]:
        """Return the columns of a block by what carries them."""
        found = self._members.get(channels)
        if found is None:
            found = self._members[channels] = {}
            for column, channel_id in enumerate(channels):
                name = self._group(channel_id)
                if name is not None:
                    found.setdefault(name, []).append(column)
        return found

    def _note(self, name: str, ticks: npt.NDArray[np.int64]) -> None:
        if ticks.size:
            self._coming.setdefault(name, []).append(ticks)

    def process_step(self) -> None:
        if self._front is None or self._judged is None:
            return
        last = self._front - self._DELAY
        if last <= self._judged:
            return
        due: dict[str, npt.NDArray[np.int64]] = {}
        for name, parts in self._coming.items():
            seen = np.unique(np.concatenate(parts)) if parts else np.empty(0, np.int64)
            due[name] = seen[seen <= last]
            self._coming[name] = [seen[seen > last]] if due[name].size < seen.size else []
        came = np.unique(np.concatenate([*due.values(), np.empty(0, np.int64)]))
        came = came[came > self._judged]
        lost: list[tuple[int, str, bool]] = []
        for name, ticks in due.items():
            # What is later still counts as of the last tick judged.
            places = np.searchsorted(came, ticks, side="right") - 1 + self._count
            lost += self._find_gaps(name, places, self._count + came.size - 1)
        for place, name, silent in sorted(lost):
            key = f"{name}:silent"
            tick = int(came[place - self._count]) if place >= self._count else self._judged
            if silent:
                words = f"{name} is missing while others arrive: check its sender"
                self._registry.raise_(key, Severity.CAUTION, (tick + 1) * self.TICK, words)
            else:
                self._registry.clear(key, tick * self.TICK)
        self._judged = last
        self._count += came.size

    def _find_gaps(
        self, name: str, places: npt.NDArray[np.intp], last: int
    ) -> list[tuple[int, str, bool]]:
        """Return where a message stayed away (True) and where it came again (False).

        Counted in ticks in which anything came: those where it did, up to the last of all.
        """
        before = self._last.get(name)
        spoken = places if before is None else np.union1d(np.array([before]), places)
        if not spoken.size:
            return []
        found: list[tuple[int, str, bool]] = []
        distances = np.diff(spoken)
        former = self._distances.get(name, distances[:0])
        known = np.concatenate([former, distances])
        for place in np.flatnonzero(distances > self._min_timeout).tolist():
            patience = self._timeout_ticks(known[: former.size + place])
            if distances[place] <= patience:
                continue
            falls = int(spoken[place]) + patience
            if falls >= self._count:
                found.append((falls, name, True))
            found.append((int(spoken[place + 1]), name, False))
        newest = int(spoken[-1])
        falls = newest + self._timeout_ticks(known)
        if self._count <= falls <= last:
            found.append((falls, name, True))
        self._last[name] = newest
        self._distances[name] = known[-self._INTERVAL_COUNT :]
        return found

    def _timeout_ticks(self, distances: npt.NDArray[np.intp]) -> int:
        """Return the ticks of silence after which a message counts as lost.

        Parameters
        ----------
        distances : ndarray of int, shape (n,)
            Ticks from one to the next so far.
        """
        newest = np.sort(distances[-self._INTERVAL_COUNT :])
        usual = int(newest[newest.size // 2]) if newest.size else 0
        return max(self._min_timeout, min(self._PERIODS * usual, self._MAX_TIMEOUT))
