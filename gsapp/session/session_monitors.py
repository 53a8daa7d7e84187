"""The consumers of a session's samples: alarms, missing messages, cues, estimates, landing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.channel_states import ChannelStates
from gsapp.session.cue_monitor import CueMonitor
from gsapp.session.failure_guard import FailureGuard, GuardedConsumer
from gsapp.session.landing_monitor import LandingMonitor
from gsapp.session.limit_monitor import LimitMonitor
from gsapp.session.limits import LimitSet, Severity
from gsapp.session.marks import MarkStore
from gsapp.session.session_flight import SessionOptions, SessionSetting

if TYPE_CHECKING:
    from gsapp.excitation.doublets.verdict import InputVerdict
    from gsapp.flight.info import FlightInfo
    from gsapp.session.consumer_scheduler import Consumer
    from gsapp.session.live_estimation.estimate_monitor import EstimateMonitor

_LIMITS = "limits and missing messages are no longer monitored"
_ESTIMATES = "estimates stopped"
_LANDING = "landing detection stopped"
_FURTHER = "a monitor failed"


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
                text = f"{name} is missing while others arrive: check its sender"
                self._registry.raise_(key, Severity.CAUTION, (tick + 1) * self.TICK, text)
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


class AlarmMonitor:
    """Watches the samples of a flight for alarms: limits and instruments that fall silent.

    Parameters
    ----------
    group : callable
        What carries a channel; see `MessagePresenceMonitor`.
    together : callable
        Whether two channels come in the same blocks; see `LimitMonitor`.
    """

    def __init__(
        self,
        registry: AlarmRegistry,
        limits: LimitSet,
        rate: float,
        group: Callable[[str], str | None],
        together: Callable[[str, str], bool],
    ) -> None:
        self._registry = registry
        self._limits = LimitMonitor(limits, registry, rate, together)
        self._presence = MessagePresenceMonitor(registry, group)

    def feed(self, block: Block) -> None:
        self._limits.feed(block)
        self._presence.feed(block)

    def reload_limits(self, channel_id: str) -> None:
        self._limits.reload_limits(channel_id)

    def process_step(self) -> None:
        self._presence.process_step()

    def reset(self) -> None:
        self._limits.reset()
        self._presence.reset()
        self._registry.reset()


class SessionMonitors:
    """Makes the consumers of a session, and holds them.

    Parameters
    ----------
    info : callable
        The flight card as it is now.

    Attributes
    ----------
    consumers : list of Consumer
        All, in the order in which they are fed. In a live flight none of them may hold up the
        others.
    urgent : list of Consumer
        Those that find what the crew is told at once.
    alarms_ahead : AlarmMonitor or None
        In a replay, over the whole record as it is read.
    """

    def __init__(
        self,
        name: str,
        setting: SessionSetting,
        options: SessionOptions,
        states: ChannelStates,
        marks: MarkStore,
        *,
        live: bool,
        alarms_ahead: AlarmRegistry | None,
        now: Callable[[], float | None],
        info: Callable[[], FlightInfo | None],
        read_events: Callable[[], None],
        on_ground: Callable[[float], bool | None],
    ) -> None:
        self._registry = states.registry
        self._live = live
        self._now = now
        history = states.history

        def alarm_monitor(registry: AlarmRegistry) -> AlarmMonitor:
            return AlarmMonitor(
                registry, states.limits, history.rate, states.message_of, states.share_message
            )

        self.alarms = alarm_monitor(self._registry)
        self.alarms_ahead = None if alarms_ahead is None else alarm_monitor(alarms_ahead)
        self.cues: CueMonitor | None = None
        if options.get("cues", True):
            from gsapp.excitation.cueing import CueGenerator  # the window starts without it

            cueing = CueGenerator(
                setting.aircraft,
                setting.model,
                history.rate,
                cards=setting.cards,
                fence=setting.fence,
                system=options.get("system", "US"),
            )
            self.cues = CueMonitor(cueing, self._registry, marks, read_events, live=live)
        self.estimates: EstimateMonitor | None = None
        workers = options.get("workers")
        if workers is not None and setting.aircraft is not None:
            from gsapp.session.live_estimation import estimate_monitor  # as above

            self.estimates = estimate_monitor.EstimateMonitor(
                setting.aircraft, setting.model, history, info, name, self._verdicts, workers,
                options.get("search_worker"),
            )  # fmt: skip
        self.landing = LandingMonitor(setting.aircraft, history.rate, on_ground)
        self.consumers = self._all(options.get("consumers", ()))
        self.urgent = self.consumers[: 1 if self.cues is None else 2]

    def _all(self, further: Sequence[Consumer]) -> list[Consumer]:
        found = [self._guarded(self.alarms, _LIMITS, Severity.WARNING)]
        if self.cues is not None:
            found.append(self.cues)  # on its own guard, in a replay too
        if self.estimates is not None:
            found.append(self._guarded(self.estimates, _ESTIMATES))
        if self._live:
            found.append(self._guarded(self.landing, _LANDING))
        return [*found, *(self._guarded(one, _FURTHER) for one in further)]

    def _guarded(
        self, consumer: Consumer, what: str, severity: Severity = Severity.CAUTION
    ) -> Consumer:
        if not self._live:
            return consumer
        key = f"failed:{type(consumer).__name__}"
        return GuardedConsumer(
            consumer, FailureGuard(key, what, severity, self._registry, self._now)
        )

    def _verdicts(self) -> Sequence[InputVerdict]:
        return () if self.cues is None else self.cues.cueing.verdicts

    def reload_limits(self, channel_id: str) -> None:
        for monitor in (self.alarms, self.alarms_ahead):
            if monitor is not None:
                monitor.reload_limits(channel_id)

    def finish(self, *, wait: bool) -> None:
        """Judge the very last rows of a flight that is over."""
        if self.cues is not None:
            self.cues.finish()
        if self.estimates is not None:
            self.estimates.finish(wait=wait)
