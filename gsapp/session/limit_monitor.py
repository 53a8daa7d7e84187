"""Watching samples against limits.

What comes out depends on the samples only: not on how they were cut into blocks, and not on when
they arrived.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.quantities import Block, FloatArray
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.limits import LimitRule, LimitSet, Severity
from gsapp.session.monitor_settings import MONITORS

# Whether the aircraft is about to touch down, as far as its speed and its altitude tell.
# Every landing ends below the stall speed. An alarm for it, one second before the wheels touch,
# teaches the crew to ignore it; so limits that mean nothing near the ground wait there.

SPEED_CHANNEL, ALTITUDE_CHANNEL = "Vc", "altitude"


class GroundProximityMonitor:
    """Tells which samples were taken near the ground from which the aircraft took off.

    What comes out depends on the samples only, not on how they were cut into blocks.

    Parameters
    ----------
    flown_at : float
        Calibrated airspeed at which it certainly flies, m/s; the altitude of the ground is
        settled then, and once for the flight: a pitot that is blocked in flight lands nowhere.
    slow_at : float
        Calibrated airspeed below which it certainly does not fly, m/s.
    """

    def __init__(self, flown_at: float, slow_at: float, rate: float) -> None:
        self._flown_at = flown_at
        self._slow_at = slow_at
        self._longest = round(MONITORS.ground_altitude_time * rate)
        self._least = round(MONITORS.min_ground_time * rate)
        self._window = max(round(MONITORS.near_ground_window * rate), 1)
        self._altitudes: FloatArray = np.empty(0)
        self._ground: float | None = None
        self._flown = False
        self._last = np.zeros(self._window - 1, dtype=bool)
        self._next: int | None = None

    def feed(self, first: int, block: Block) -> npt.NDArray[np.bool_]:
        """Return for each sample, shape (n,), whether it is near the ground.

        Parameters
        ----------
        first : int
            Index of the first sample on the grid.
        """
        speed, altitude = block[SPEED_CHANNEL], block[ALTITUDE_CHANNEL]
        if not self._flown:
            self._update_ground_altitude(speed, altitude)
        if self._ground is None:
            return np.zeros(len(block), dtype=bool)
        if first != self._next:
            self._last[:] = False
        self._next = first + len(block)
        line = np.concatenate(
            (self._last, np.abs(altitude - self._ground) < MONITORS.near_ground_height)
        )
        self._last = line[line.size - self._last.size :]
        counts = np.concatenate(((0,), np.cumsum(line)))
        return (counts[self._window :] - counts[: -self._window]) * 2 > self._window

    def _update_ground_altitude(self, speed: FloatArray, altitude: FloatArray) -> None:
        flown = np.flatnonzero(speed > self._flown_at)
        end = int(flown[0]) if flown.size else speed.size
        standing = altitude[:end][(speed[:end] < self._slow_at) & ~np.isnan(altitude[:end])]
        self._altitudes = np.concatenate((self._altitudes, standing))[-self._longest :]
        if flown.size:
            self._flown = True
            if self._altitudes.size >= self._least:
                self._ground = float(np.median(self._altitudes))


class _Threshold:
    """One threshold of one side: a latch with hysteresis and a least duration.

    Values and limits come multiplied by the sign of the side, so that beyond is always above.
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

    def reset(self) -> None:
        self.interrupt()
        self.on = False
        self.peak = -math.inf

    def is_unchanged_within(self, lowest: float, highest: float) -> bool:
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


class _SeverityChange(NamedTuple):
    """A change of severity at a sample, and the farthest value until then."""

    place: int
    key: str
    severity: Severity
    value: float


class _RuleMonitor:
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
        self._reported = dict.fromkeys(self._latches, False)
        self._armed = rule.armed_at is None
        self._next: int | None = None

    @property
    def peak(self) -> float:
        """Return the farthest value since the alarm went on, SI."""
        # The lesser threshold is on whenever the other is.
        return self._sign * next(iter(self._latches.values())).peak

    @property
    def on(self) -> bool:
        return any(latch.on for latch in self._latches.values())

    def quiet_range(self) -> tuple[float, float] | None:
        """Return between which values samples change nothing at all; None if any may."""
        if any(latch.on or latch.since is not None for latch in self._latches.values()):
            return None
        low, high = -math.inf, math.inf
        if self._armed:
            high = min(latch.threshold for latch in self._latches.values())
            if self.rule.disarmed_at is not None:
                high = min(high, self._sign * self.rule.disarmed_at)
        elif self.rule.armed_at is not None:
            low = self._sign * self.rule.armed_at
        return (low, high) if self._sign > 0 else (-high, -low)

    def feed(
        self, first: int, values: FloatArray, grounded: npt.NDArray[np.bool_] | None = None
    ) -> list[_SeverityChange]:
        """Take in samples from index `first` on; return where the severity changed.

        `grounded`, shape (n,), says which samples do not count since they are near the ground.
        """
        if self._next is not None and first != self._next:
            for latch in self._latches.values():
                latch.interrupt()
        self._next = first + values.size
        signed = values if self._sign > 0 else -values
        if self.rule.armed_at is None:
            return self._monitor(first, signed)
        found: list[_SeverityChange] = []
        for begin, end, armed in self._armed_segments(signed):
            if armed:
                found += self._monitor_airborne(first, begin, end, signed, grounded)
            elif self._armed:
                found += self._disarm(first + begin)
            self._armed = armed
        return found

    def _monitor_airborne(
        self,
        first: int,
        begin: int,
        end: int,
        signed: FloatArray,
        grounded: npt.NDArray[np.bool_] | None,
    ) -> list[_SeverityChange]:
        if grounded is None or not self.rule.airborne_only:
            return self._monitor(first + begin, signed[begin:end])
        found: list[_SeverityChange] = []
        edges = np.flatnonzero(np.diff(grounded[begin:end])) + begin + 1
        for start, stop in pairwise((begin, *edges.tolist(), end)):
            if grounded[start]:
                found += self._disarm(first + start)
            else:
                found += self._monitor(first + start, signed[start:stop])
        return found

    def _monitor(self, first: int, signed: FloatArray) -> list[_SeverityChange]:
        lowest, highest = float(np.min(signed)), float(np.max(signed))
        changes: list[tuple[int, Severity, bool, float]] = []
        for severity, latch in self._latches.items():
            if math.isnan(lowest) or not latch.is_unchanged_within(lowest, highest):
                found = latch.watch(first, signed, self._needed)
                changes += [(index, severity, on, peak) for index, on, peak in found]
        steps = []
        for index, severity, on, peak in sorted(changes):
            self._reported[severity] = on
            steps.append(_SeverityChange(index, self.rule.key, self._severity(), self._sign * peak))
        return steps

    def _disarm(self, index: int) -> list[_SeverityChange]:
        was, peak = self._severity(), self.peak
        for severity, latch in self._latches.items():
            latch.reset()
            self._reported[severity] = False
        return [_SeverityChange(index, self.rule.key, Severity.NORMAL, peak)] if was else []

    def _severity(self) -> Severity:
        return max((each for each, on in self._reported.items() if on), default=Severity.NORMAL)

    def _armed_segments(self, signed: FloatArray) -> list[tuple[int, int, bool]]:
        """Return stretches (begin, end, armed): armed by safe values, put to sleep by far ones."""
        safe = self._sign * (self.rule.armed_at or 0.0)
        far = math.inf if self.rule.disarmed_at is None else self._sign * self.rule.disarmed_at
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


class _ChannelMonitors(NamedTuple):
    """The rules of one channel, and its place among all channels."""

    place: int
    watches: list[_RuleMonitor]


class LimitMonitor:
    """Watches the samples of all channels against their limits, and raises alarms.

    Parameters
    ----------
    together : callable
        Whether two channels always come in the same blocks, live as in a replay; limits that
        wait near the ground need that of speed and altitude.
    """

    def __init__(
        self,
        limits: LimitSet,
        registry: AlarmRegistry,
        rate: float,
        together: Callable[[str, str], bool] = lambda _one, _other: True,
    ) -> None:
        self._limits = limits
        self._together = together
        self._ground: GroundProximityMonitor | None = None
        self._registry = registry
        self._rate = rate
        self._channels: dict[str, _ChannelMonitors] = {}
        self._places: dict[tuple[str, ...], npt.NDArray[np.int64]] = {}
        # Between these nothing happens, by the place of the channel; empty where it might.
        self._lowest = np.empty(0)
        self._highest = np.empty(0)

    def reset(self) -> None:
        self._ground = None
        self._channels.clear()
        self._places.clear()
        self._lowest = self._highest = np.empty(0)

    def reload_limits(self, channel_id: str) -> None:
        """Go on with other rules for a channel; its samples so far do not count for them."""
        watched = self._channels.get(channel_id)
        if watched is None:
            return
        for watch in watched.watches:
            self._registry.clear(watch.rule.key)
        watched.watches[:] = self._create_rule_monitors(channel_id)
        self._set_quiet(watched)

    def _create_rule_monitors(self, channel_id: str) -> list[_RuleMonitor]:
        return [_RuleMonitor(rule, self._rate) for rule in self._limits.rules(channel_id)]

    def feed(self, block: Block) -> None:
        if not len(block):
            return
        first = round(float(block.times[0]) * self._rate)
        places = self._places_of(block.channels)
        grounded = self._near_ground(first, block)
        # The usual case, all columns at once: nobody near a limit, nothing pending.
        lows = np.fmin.reduce(block.values, axis=0)
        highs = np.fmax.reduce(block.values, axis=0)
        lowest, highest = self._lowest[places], self._highest[places]
        stirred = (lows < lowest) | (highs > highest) | np.isnan(lowest)
        if not stirred.any():
            return
        steps: list[tuple[_SeverityChange, LimitRule]] = []
        touched: list[_RuleMonitor] = []
        for column in np.flatnonzero(stirred).tolist():
            watched = self._channels[block.channels[column]]
            for watch in watched.watches:
                changes = watch.feed(first, block.values[:, column], grounded)
                steps += [(step, watch.rule) for step in changes]
                if watch.on:
                    touched.append(watch)
            self._set_quiet(watched)
        for step, rule in sorted(steps, key=lambda pair: pair[0][:2]):
            if step.severity is Severity.NORMAL:
                self._registry.update_peak(step.key, step.value)
                self._registry.clear(step.key, step.place / self._rate)
            else:
                self._registry.raise_(
                    step.key,
                    step.severity,
                    step.place / self._rate,
                    rule.describe(step.severity),
                    rule=rule,
                    value=step.value,
                )
        for watch in touched:
            self._registry.update_peak(watch.rule.key, watch.peak)

    def _near_ground(self, first: int, block: Block) -> npt.NDArray[np.bool_] | None:
        """Return which samples are near the ground; None where that cannot be told."""
        if SPEED_CHANNEL not in block.channels or ALTITUDE_CHANNEL not in block.channels:
            return None
        if self._ground is None:
            rule = next(
                (rule for rule in self._limits.rules(SPEED_CHANNEL) if rule.airborne_only), None
            )
            if rule is None or rule.armed_at is None or rule.disarmed_at is None:
                return None
            if not self._together(SPEED_CHANNEL, ALTITUDE_CHANNEL):
                return None
            self._ground = GroundProximityMonitor(rule.armed_at, rule.disarmed_at, self._rate)
        return self._ground.feed(first, block)

    def _places_of(self, channels: tuple[str, ...]) -> npt.NDArray[np.int64]:
        found = self._places.get(channels)
        if found is None:
            for channel_id in channels:
                if channel_id not in self._channels:
                    watched = _ChannelMonitors(
                        len(self._channels), self._create_rule_monitors(channel_id)
                    )
                    self._channels[channel_id] = watched
                    self._lowest = np.append(self._lowest, 0.0)
                    self._highest = np.append(self._highest, 0.0)
                    self._set_quiet(watched)
            found = np.array([self._channels[name].place for name in channels], dtype=np.int64)
            self._places[channels] = found
        return found

    def _set_quiet(self, watched: _ChannelMonitors) -> None:
        low, high = -math.inf, math.inf
        for watch in watched.watches:
            quiet = watch.quiet_range()
            # While something is under way even a missing sample matters, and so does any value.
            low, high = (
                (math.nan, math.nan) if quiet is None else (max(low, quiet[0]), min(high, quiet[1]))
            )
            if quiet is None:
                break
        self._lowest[watched.place], self._highest[watched.place] = low, high
