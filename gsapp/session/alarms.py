"""Alarms: raised by limits and by failing equipment, latched, acknowledged, newest first.

Limits are watched sample by sample, and what comes out depends on the samples only: not on how
they were cut into blocks, and not on when they arrived. An alarm stays until somebody has
acknowledged it *and* its cause is gone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.quantities import Block, FloatArray, channel, from_si
from gsapp.session.limits import LimitRule, LimitSet, Severity


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """One alarm as it stands.

    Attributes
    ----------
    key : str
        What it is about: ``alpha:high``, ``link``, ``recorder``, ``disk`` ...
    severity : Severity
        The worst since it was raised or acknowledged.
    current : Severity
        As of now; NORMAL once the cause is gone.
    time : float or None
        Flight time at which it was raised (or grew worse), s.
    words : str
        What it means, or the whole sentence for alarms without a value.
    rule : LimitRule or None
        The limit, for alarms with a value.
    value : float or None
        The farthest value since it was raised, SI.
    acknowledged : bool
        Whether somebody has said so since it was raised or grew worse.
    count : int
        How many times it was raised since it last left the list.
    """

    key: str
    severity: Severity
    current: Severity
    time: float | None
    words: str
    rule: LimitRule | None = None
    value: float | None = None
    acknowledged: bool = False
    count: int = 1

    @property
    def active(self) -> bool:
        """Return whether the cause is still there."""
        return self.current > Severity.NORMAL

    def sentence(self, system: str = "SI") -> str:
        """Return what a field engineer says, with units of the system ``"SI"`` or ``"US"``."""
        if self.rule is None or self.value is None:
            return self.words
        spec = channel(self.rule.channel)
        unit = spec.display_unit(system)
        limit = self.rule.warning if self.severity is Severity.WARNING else self.rule.caution
        if limit is None:
            limit = self.rule.caution if self.rule.warning is None else self.rule.warning
        shown = _number(self.value, unit, spec.quantity, spec.decimals(unit))
        bound = _number(limit or 0.0, unit, spec.quantity, spec.decimals(unit))
        beyond = "above" if self.rule.side == "high" else "below"
        words = self.rule.words(self.severity)
        tail = f", {words}" if words else ""
        return f"{spec.title} {shown}, {beyond} {bound}{tail}"


def _number(value: float, unit: str, quantity: str, decimals: int) -> str:
    text = f"{from_si(value, unit, quantity):.{decimals}f}"
    return f"{text} {unit}".strip()


@dataclass(frozen=True, slots=True, kw_only=True)
class Onset:
    """An alarm at the moment it was raised, for the log and the time axis."""

    key: str
    severity: Severity
    time: float | None
    words: str


class AlarmBoard:
    """The alarms that stand, whoever raised them.

    Attributes
    ----------
    revision : int
        Grows with every change.
    """

    def __init__(self) -> None:
        self._log: list[Onset] = []
        self.revision = 0
        self._alarms: dict[str, Alarm] = {}
        self._acknowledged: set[tuple[str, float | None]] = set()

    @property
    def standing(self) -> tuple[Alarm, ...]:
        """Return the alarms that stand, newest first, the worse before the lesser."""
        return tuple(
            sorted(
                self._alarms.values(),
                key=lambda alarm: (
                    -math.inf if alarm.time is None else -alarm.time,
                    -alarm.severity,
                    alarm.key,
                ),
            )
        )

    @property
    def log(self) -> tuple[Onset, ...]:
        """Return every alarm raised so far, by time; those without a flight time first."""
        return tuple(
            sorted(
                self._log,
                key=lambda onset: (-math.inf if onset.time is None else onset.time, onset.key),
            )
        )

    def log_of(self, keys: Collection[str]) -> tuple[Onset, ...]:
        """Return the alarms of some keys, in the order in which they were raised."""
        return tuple(onset for onset in self._log if onset.key in keys)

    @property
    def waiting(self) -> tuple[Alarm, ...]:
        """Return those that nobody has acknowledged, newest first."""
        return tuple(alarm for alarm in self.standing if not alarm.acknowledged)

    def get(self, key: str) -> Alarm | None:
        """Return the alarm of that key, if it stands."""
        return self._alarms.get(key)

    def severity(self, key: str) -> Severity:
        """Return how bad the cause is at present."""
        alarm = self._alarms.get(key)
        return Severity.NORMAL if alarm is None else alarm.current

    def raise_(
        self,
        key: str,
        severity: Severity,
        time: float | None,
        words: str,
        *,
        rule: LimitRule | None = None,
        value: float | None = None,
    ) -> None:
        """Raise an alarm, or bring one that stands up to date."""
        former = self._alarms.get(key)
        if former is not None and severity <= former.current:
            # Not worse: the same alarm goes on, perhaps milder, perhaps in other words.
            changed = replace(former, current=severity)
            if severity == former.severity:
                changed = replace(changed, words=words)
            if changed != former:
                self._alarms[key] = changed
                self.revision += 1
            if value is not None:
                self.reach(key, value)
            return
        if former is not None and rule is not None and value is not None:
            value = rule.farther(value, former.value)
        self._alarms[key] = Alarm(
            key=key,
            severity=severity if former is None else max(severity, former.severity),
            current=severity,
            time=time,
            words=words,
            rule=rule,
            value=value,
            acknowledged=(key, time) in self._acknowledged,
            count=1 if former is None else former.count + (not former.active),
        )
        self._log.append(Onset(key=key, severity=severity, time=time, words=words))
        self.revision += 1

    def reach(self, key: str, value: float) -> None:
        """Note how far the value of an alarm went that stands; the farthest is kept."""
        former = self._alarms.get(key)
        if former is None or former.rule is None:
            return
        farthest = former.rule.farther(value, former.value)
        if farthest != former.value:
            self._alarms[key] = replace(former, value=farthest)
            self.revision += 1

    def clear(self, key: str) -> None:
        """Say that the cause is gone. The alarm stays until it is acknowledged."""
        former = self._alarms.get(key)
        if former is None or not former.active:
            return
        self.revision += 1
        if former.acknowledged:
            del self._alarms[key]
        else:
            self._alarms[key] = replace(former, current=Severity.NORMAL)

    def acknowledge(self, key: str, time: float | None) -> None:
        """Take note that somebody has seen the alarm raised at that time.

        The time says which one, since acknowledgments come from other windows too, and may be
        read before the alarm itself in a replay.
        """
        self._acknowledged.add((key, time))
        alarm = self._alarms.get(key)
        if alarm is None or alarm.acknowledged or alarm.time != time:
            return
        self.revision += 1
        if alarm.active:
            self._alarms[key] = replace(alarm, acknowledged=True, severity=alarm.current)
        else:
            del self._alarms[key]

    def reset(self) -> None:
        """Begin anew, as before the first sample; acknowledgments are kept."""
        self._alarms.clear()
        self._log.clear()
        self.revision += 1


class _Threshold:
    """One threshold of one side: a latch with hysteresis and a least duration.

    Values and limits are multiplied by `sign`, so that beyond is always above.
    """

    __slots__ = ("back", "on", "peak", "pending_peak", "since", "threshold")

    def __init__(self, threshold: float, hysteresis: float) -> None:
        self.threshold = threshold
        self.back = threshold - hysteresis
        self.on = False
        # Index from which the value has been beyond (when off) or back (when on).
        self.since: int | None = None
        self.pending_peak = -math.inf
        self.peak = -math.inf

    def interrupt(self) -> None:
        """Forget a change under way, at a gap in the samples; the state stays."""
        self.since = None
        self.pending_peak = -math.inf

    def sleep(self) -> None:
        """Return to the state before the first sample."""
        self.interrupt()
        self.on = False
        self.peak = -math.inf

    def quiet(self, lowest: float, highest: float) -> bool:
        """Take in samples between two values, none missing, if they change nothing."""
        if self.on:
            if lowest <= self.back:
                return False
            self.peak = max(self.peak, highest)
        elif highest > self.threshold:
            return False
        self.interrupt()
        return True

    def watch(self, first: int, values: FloatArray, needed: int) -> list[tuple[int, bool, float]]:
        """Take in samples from index `first` on; return the changes as (index, on, peak)."""
        # 0 back, 1 between, 2 beyond, 3 missing
        code = np.full(values.size, 1, dtype=np.int8)
        code[values > self.threshold] = 2
        code[values <= self.back] = 0
        code[np.isnan(values)] = 3
        changes: list[tuple[int, bool, float]] = []
        cuts = np.flatnonzero(np.diff(code)) + 1
        begins = [0, *cuts.tolist()]
        ends = [*cuts.tolist(), values.size]
        for begin, end in zip(begins, ends, strict=True):
            self._run(first, begin, end, int(code[begin]), values, needed, changes)
        return changes

    def _run(
        self,
        first: int,
        begin: int,
        end: int,
        code: int,
        values: FloatArray,
        needed: int,
        changes: list[tuple[int, bool, float]],
    ) -> None:
        if code == 3:
            self.interrupt()
            return
        highest = float(np.max(values[begin:end]))
        if self.on:
            self.peak = max(self.peak, highest)
        if code != (0 if self.on else 2):
            self.interrupt()
            return
        if self.since is None:
            self.since = first + begin
        self.pending_peak = max(self.pending_peak, highest)
        at = self.since + needed - 1
        if at < first + end:
            self.on = not self.on
            if self.on:
                self.peak = self.pending_peak
            changes.append((at, self.on, self.peak))
            self.interrupt()


class _Step(NamedTuple):
    """A change of severity at a sample, and the farthest value until then."""

    place: int
    key: str
    severity: Severity
    value: float


class _Watch:
    """One rule at work on the samples of its channel."""

    def __init__(self, rule: LimitRule, rate: float) -> None:
        self.rule = rule
        self._sign = 1.0 if rule.side == "high" else -1.0
        self._needed = max(1, round(rule.duration * rate))
        limits = ((Severity.CAUTION, rule.caution), (Severity.WARNING, rule.warning))
        self._latches = {
            severity: _Threshold(self._sign * limit, rule.hysteresis)
            for severity, limit in limits
            if limit is not None
        }
        self._told = dict.fromkeys(self._latches, False)
        self._armed = rule.armed_at is None
        self._next: int | None = None

    @property
    def peak(self) -> float:
        """Return the farthest value since the alarm went on, SI."""
        # The lesser threshold is on whenever the other is.
        return self._sign * next(iter(self._latches.values())).peak

    @property
    def on(self) -> bool:
        """Return whether any threshold is on."""
        return any(latch.on for latch in self._latches.values())

    def quiet_between(self) -> tuple[float, float] | None:
        """Return between which values samples change nothing at all; None if any may."""
        if any(latch.on or latch.since is not None for latch in self._latches.values()):
            return None
        low, high = -math.inf, math.inf
        if self._armed:
            high = min(latch.threshold for latch in self._latches.values())
            if self.rule.asleep_at is not None:
                high = min(high, self._sign * self.rule.asleep_at)
        elif self.rule.armed_at is not None:
            low = self._sign * self.rule.armed_at
        return (low, high) if self._sign > 0 else (-high, -low)

    def feed(self, first: int, values: FloatArray) -> list[_Step]:
        """Take in samples from index `first` on; return where the severity changed."""
        if self._next is not None and first != self._next:
            for latch in self._latches.values():
                latch.interrupt()
        self._next = first + values.size
        signed = values if self._sign > 0 else -values
        if self.rule.armed_at is None:
            return self._watch(first, signed)
        found: list[_Step] = []
        for begin, end, armed in self._wakes(signed):
            if armed:
                found += self._watch(first + begin, signed[begin:end])
            elif self._armed:
                found += self._fall_asleep(first + begin)
            self._armed = armed
        return found

    def _watch(self, first: int, signed: FloatArray) -> list[_Step]:
        lowest, highest = float(np.min(signed)), float(np.max(signed))
        changes: list[tuple[int, Severity, bool, float]] = []
        for severity, latch in self._latches.items():
            if math.isnan(lowest) or not latch.quiet(lowest, highest):
                found = latch.watch(first, signed, self._needed)
                changes += [(index, severity, on, peak) for index, on, peak in found]
        steps = []
        for index, severity, on, peak in sorted(changes):
            self._told[severity] = on
            steps.append(_Step(index, self.rule.key, self._severity(), self._sign * peak))
        return steps

    def _fall_asleep(self, index: int) -> list[_Step]:
        was, peak = self._severity(), self.peak
        for severity, latch in self._latches.items():
            latch.sleep()
            self._told[severity] = False
        return [_Step(index, self.rule.key, Severity.NORMAL, peak)] if was else []

    def _severity(self) -> Severity:
        return max((each for each, on in self._told.items() if on), default=Severity.NORMAL)

    def _wakes(self, signed: FloatArray) -> list[tuple[int, int, bool]]:
        """Return stretches (begin, end, armed): armed by safe values, put to sleep by far ones."""
        safe = self._sign * (self.rule.armed_at or 0.0)
        far = math.inf if self.rule.asleep_at is None else self._sign * self.rule.asleep_at
        places = np.flatnonzero((signed < safe) | (signed > far))
        wakes = np.asarray(signed[places] < safe)
        before = np.concatenate((np.array([self._armed]), wakes[:-1]))[: wakes.size]
        turns = places[np.flatnonzero(wakes != before)].tolist()
        stretches = []
        begin, armed = 0, self._armed
        for turn in turns:
            if turn > begin:
                stretches.append((begin, turn, armed))
            begin, armed = turn, not armed
        stretches.append((begin, signed.size, armed))
        return stretches


class _Watched(NamedTuple):
    """The rules of one channel, and its place among all channels."""

    place: int
    watches: list[_Watch]


class LimitMonitor:
    """Watches the samples of all channels against their limits, and raises alarms.

    Parameters
    ----------
    limits : LimitSet
        The rules.
    board : AlarmBoard
        Where the alarms go.
    rate : float
        Of the grid, Hz.
    """

    def __init__(self, limits: LimitSet, board: AlarmBoard, rate: float) -> None:
        self._limits = limits
        self._board = board
        self._rate = rate
        self._channels: dict[str, _Watched] = {}
        self._places: dict[tuple[str, ...], npt.NDArray[np.int64]] = {}
        # Between these nothing happens, by the place of the channel; empty where it might.
        self._lowest = np.empty(0)
        self._highest = np.empty(0)

    def reset(self) -> None:
        """Forget every sample seen. The board is the owner's to reset."""
        self._channels.clear()
        self._places.clear()
        self._lowest = self._highest = np.empty(0)

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels, on consecutive places of the grid."""
        if not len(block):
            return
        first = round(float(block.times[0]) * self._rate)
        places = self._places_of(block.channels)
        # The usual case, all columns at once: nobody near a limit, nothing pending.
        lows = np.fmin.reduce(block.values, axis=0)
        highs = np.fmax.reduce(block.values, axis=0)
        lowest, highest = self._lowest[places], self._highest[places]
        stirred = (lows < lowest) | (highs > highest) | np.isnan(lowest)
        if not stirred.any():
            return
        steps: list[tuple[_Step, LimitRule]] = []
        touched: list[_Watch] = []
        for column in np.flatnonzero(stirred).tolist():
            watched = self._channels[block.channels[column]]
            for watch in watched.watches:
                steps += [(step, watch.rule) for step in watch.feed(first, block.values[:, column])]
                if watch.on:
                    touched.append(watch)
            self._set_quiet(watched)
        for step, rule in sorted(steps, key=lambda pair: pair[0][:2]):
            if step.severity is Severity.NORMAL:
                self._board.reach(step.key, step.value)
                self._board.clear(step.key)
            else:
                self._board.raise_(
                    step.key,
                    step.severity,
                    step.place / self._rate,
                    rule.words(step.severity),
                    rule=rule,
                    value=step.value,
                )
        for watch in touched:
            self._board.reach(watch.rule.key, watch.peak)

    def _places_of(self, channels: tuple[str, ...]) -> npt.NDArray[np.int64]:
        found = self._places.get(channels)
        if found is None:
            for channel_id in channels:
                if channel_id not in self._channels:
                    rules = self._limits.rules(channel_id)
                    watched = _Watched(
                        len(self._channels), [_Watch(rule, self._rate) for rule in rules]
                    )
                    self._channels[channel_id] = watched
                    self._lowest = np.append(self._lowest, 0.0)
                    self._highest = np.append(self._highest, 0.0)
                    self._set_quiet(watched)
            found = np.array([self._channels[name].place for name in channels], dtype=np.int64)
            self._places[channels] = found
        return found

    def _set_quiet(self, watched: _Watched) -> None:
        low, high = -math.inf, math.inf
        for watch in watched.watches:
            quiet = watch.quiet_between()
            # While something is under way even a missing sample matters, and so does any value.
            low, high = (
                (math.nan, math.nan) if quiet is None else (max(low, quiet[0]), min(high, quiet[1]))
            )
            if quiet is None:
                break
        self._lowest[watched.place], self._highest[watched.place] = low, high


class PresenceMonitor:
    """Raises an alarm for a message that stays away while others still come.

    Instruments are watched by the message that carries them: one alarm for a box that falls
    silent, not one for each of its channels.

    Presence is kept in ticks of a quarter of a second of flight time, each judged a second
    late, when all that belongs to it has arrived; so a replay judges as the live flight did.

    Parameters
    ----------
    board : AlarmBoard
        Where the alarms go.
    group : callable
        What carries a channel, from its id; None for a channel that is not watched.
    patience : float
        Seconds of silence after which it counts as lost.
    """

    TICK = 0.25
    _DELAY = 4  # ticks

    def __init__(
        self, board: AlarmBoard, group: Callable[[str], str | None], patience: float = 3.0
    ) -> None:
        self._board = board
        self._group = group
        self._patience = max(1, math.ceil(patience / self.TICK))
        self._members: dict[tuple[str, ...], dict[str, list[int]]] = {}
        self._front: int | None = None
        self._judged: int | None = None
        self._last: dict[str, int] = {}
        self._coming: dict[str, list[npt.NDArray[np.int64]]] = {}

    def reset(self) -> None:
        """Forget every sample seen."""
        self._front = self._judged = None
        self._last.clear()
        self._coming.clear()

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels."""
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

    def settle(self) -> None:
        """Judge the ticks whose time has come; once after all blocks of a step."""
        if self._front is None or self._judged is None:
            return
        last = self._front - self._DELAY
        if last <= self._judged:
            return
        lost: list[tuple[int, str, bool]] = []
        for name, parts in self._coming.items():
            seen = np.unique(np.concatenate(parts)) if parts else np.empty(0, np.int64)
            due = seen[seen <= last]
            self._coming[name] = [seen[seen > last]] if due.size < seen.size else []
            lost += self._silences(name, due, last)
        for tick, name, silent in sorted(lost):
            key = f"{name}:silent"
            if silent:
                words = f"{name} stays away, while others come: check what sends it"
                self._board.raise_(key, Severity.CAUTION, (tick + 1) * self.TICK, words)
            else:
                self._board.clear(key)
        self._judged = last

    def _silences(
        self, name: str, due: npt.NDArray[np.int64], last: int
    ) -> list[tuple[int, str, bool]]:
        """Return where a message stayed away (True) and where it came again (False)."""
        patience = self._patience
        before = self._last.get(name)
        spoken = due if before is None else np.union1d(np.array([before]), due)
        if not spoken.size:
            return []
        found: list[tuple[int, str, bool]] = []
        judged = self._judged if self._judged is not None else last
        for place in np.flatnonzero(np.diff(spoken) > patience).tolist():
            falls = int(spoken[place]) + patience
            if falls > judged:
                found.append((falls, name, True))
            found.append((int(spoken[place + 1]), name, False))
        newest = int(spoken[-1])
        falls = newest + patience
        if judged < falls <= last:
            found.append((falls, name, True))
        self._last[name] = newest
        return found


class AlarmWatch:
    """Watches the samples of a flight for alarms: limits and instruments that fall silent.

    Parameters
    ----------
    board : AlarmBoard
        Where alarms go.
    limits : LimitSet
        The rules.
    rate : float
        Of the grid, Hz.
    group : callable
        What carries a channel; see `PresenceMonitor`.
    """

    def __init__(
        self,
        board: AlarmBoard,
        limits: LimitSet,
        rate: float,
        group: Callable[[str], str | None],
    ) -> None:
        self._board = board
        self._limits = LimitMonitor(limits, board, rate)
        self._presence = PresenceMonitor(board, group)

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels."""
        self._limits.feed(block)
        self._presence.feed(block)

    def settle(self) -> None:
        """Judge what is due, after all blocks of a step."""
        self._presence.settle()

    def reset(self) -> None:
        """Begin anew, as before the first sample."""
        self._limits.reset()
        self._presence.reset()
        self._board.reset()
