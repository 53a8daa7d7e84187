"""Rules about what moves: surfaces after their sticks, engines, the pulses of the range check."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from gsapp.quantities import Block
from gsapp.session.checklist.evaluation import (
    ChecklistContext,
    RuleResult,
    channel_name_text,
    check_missing_channels,
    format_channel_value,
    format_list,
)
from gsapp.session.checklist.items import EngineSpeedRule, SurfacePulseRule, SurfaceResponseRule
from gsapp.session.monitor_settings import MONITORS

_NO_STICK_POSITION = 9
_ENDS: Final = {
    "stick_pitch": {+1: "back", -1: "forward"},
    "stick_roll": {+1: "right", -1: "left"},
    "stick_yaw": {+1: "right", -1: "left"},
}
"""Where the pilot holds a stick, by its sign."""
_SIGNS: Final = {+1: "positive", -1: "negative"}


class _HeldMean:
    """Mean of a surface while its stick is held somewhere, once it has settled."""

    __slots__ = ("count", "first", "last", "total")

    def __init__(self, time: float) -> None:
        self.first = time
        self.last = time
        self.total = 0.0
        self.count = 0

    def add(self, time: float, value: float) -> None:
        if time >= self.first + MONITORS.surface_settling_time:
            self.total += value
            self.count += 1
        self.last = time

    @property
    def mean(self) -> float | None:
        """Return the mean; None before it has been held for long enough."""
        settled = self.last - self.first - MONITORS.surface_settling_time
        return self.total / self.count if self.count and settled >= MONITORS.min_mean_time else None


class SurfaceResponseEvaluator:
    """See `gsapp.session.checklist.items.SurfaceResponseRule`.

    The latest stick to either side counts: what was mended is seen by moving the stick again.
    """

    def __init__(self, rule: SurfaceResponseRule) -> None:
        self._rule = rule
        self._middle: float | None = None
        self._reached: dict[int, float] = {}
        self._hold: _HeldMean | None = None
        self._where = _NO_STICK_POSITION

    def feed(self, block: Block) -> None:
        rule = self._rule
        if rule.stick not in block or rule.surface not in block:
            return
        rows = zip(
            block.times.tolist(),
            block[rule.stick].tolist(),
            block[rule.surface].tolist(),
            strict=True,
        )
        for time, stick, surface in rows:
            if math.isfinite(stick) and math.isfinite(surface):
                self._add(time, stick, surface)

    def _add(self, time: float, stick: float, surface: float) -> None:
        where = self._place(stick)
        if where != self._where or self._hold is None:
            self._where, self._hold = where, _HeldMean(time)
        self._hold.add(time, surface)
        mean = self._hold.mean
        if mean is None or where == _NO_STICK_POSITION:
            return
        if where == 0:
            self._middle = mean
        else:
            self._reached[where] = mean

    def _place(self, stick: float) -> int:
        if abs(stick) >= self._rule.stick_reach:
            return 1 if stick > 0.0 else -1
        return 0 if abs(stick) <= MONITORS.stick_center else _NO_STICK_POSITION

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        rule = self._rule
        missing = check_missing_channels((rule.stick, rule.surface), facts)
        if missing is not None:
            return missing
        middle = 0.0 if self._middle is None else self._middle
        gone = {side: rule.sign * (at - middle) for side, at in self._reached.items()}
        stick, surface = channel_name_text(rule.stick), channel_name_text(rule.surface)
        ends = _ENDS.get(rule.stick, _SIGNS)
        for side, moved in gone.items():
            if side * moved < -0.5 * rule.surface_reach:
                return RuleResult(
                    state="red",
                    why=f"{surface} moves in the wrong direction: {self._at(side)} with the "
                    f"{stick} {ends[side]}; reversed in the transmitter, or calibrated with "
                    "the wrong sign",
                )
            if side * moved < rule.surface_reach:
                return RuleResult(
                    state="red",
                    why=f"{surface} hardly moves: {self._at(side)} with the {stick} "
                    f"{ends[side]}, "
                    f"{format_channel_value(rule.surface_reach, rule.surface)} required",
                )
        waiting = [ends[side] for side in (+1, -1) if side not in gone]
        if waiting:
            return RuleResult(
                state="open", why=f"hold the {stick} fully {format_list(waiting)} for half a second"
            )
        return RuleResult(state="green", why=f"{self._at(-1)} to {self._at(+1)}")

    def _at(self, side: int) -> str:
        return format_channel_value(self._reached[side], self._rule.surface)


class EngineSpeedEvaluator:
    """See `gsapp.session.checklist.items.EngineSpeedRule`."""

    def __init__(self, rule: EngineSpeedRule) -> None:
        self._rule = rule
        self._last: tuple[float, ...] | None = None
        self._asked_since = math.nan
        self._within_since = math.nan
        self._time = math.nan
        self._seen: tuple[float, ...] | None = None

    def feed(self, block: Block) -> None:
        rule = self._rule
        if any(name not in block for name in rule.channels):
            return
        speeds = np.column_stack([block[name] for name in rule.channels])
        by_throttle = rule.throttle is not None and "throttle" in block
        throttle = block["throttle"] if by_throttle else np.zeros(len(block))
        there = np.isfinite(speeds).all(axis=1) & np.isfinite(throttle)
        low, high = rule.throttle if by_throttle and rule.throttle else (-math.inf, math.inf)
        asked = np.logical_and(throttle >= low, throttle <= high)
        within = np.all((speeds >= rule.low) & (speeds <= rule.high), axis=1)
        if rule.apart is not None:
            within &= np.ptp(speeds, axis=1) <= rule.apart
        for k in np.flatnonzero(there).tolist():
            self._add(
                float(block.times[k]),
                tuple(speeds[k].tolist()),
                asked=bool(asked[k]),
                within=bool(within[k]),
            )

    def _add(self, time: float, speeds: tuple[float, ...], *, asked: bool, within: bool) -> None:
        self._time, self._last = time, speeds
        if not asked:
            self._asked_since = self._within_since = math.nan
            return
        if math.isnan(self._asked_since):
            self._asked_since = time
        if not within:
            self._within_since = math.nan
            return
        if math.isnan(self._within_since):
            self._within_since = time
        if time - self._within_since >= self._rule.duration:
            self._seen = speeds

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        rule = self._rule
        missing = check_missing_channels(rule.channels, facts)
        if missing is not None:
            return missing
        if self._last is None:
            return RuleResult(state="open", why="no engine speed yet")
        fault = self._fault(self._last)
        if fault is not None and self._counts(facts):
            return RuleResult(state="red", why=fault)
        if self._seen is not None:
            return RuleResult(state="green", why=f"seen: {self._speeds_text(self._seen)}")
        if max(self._last) < MONITORS.stopped_ratio * rule.low:
            return RuleResult(state="open", why="the engines are off")
        wanted = f"{self._text(rule.low)} to {self._text(rule.high)} for {rule.duration:g} s"
        return RuleResult(state="open", why=f"{self._speeds_text(self._last)}; wanted {wanted}")

    def _counts(self, facts: ChecklistContext) -> bool:
        """Return whether the throttle asks for these bounds, and the engines had time to follow."""
        by_throttle = self._rule.throttle is not None and "throttle" in facts.states
        running = (
            self._last is not None and max(self._last) >= MONITORS.stopped_ratio * self._rule.low
        )
        asked = self._time - self._asked_since >= MONITORS.engine_settling_time
        return by_throttle and running and asked

    def _fault(self, speeds: tuple[float, ...]) -> str | None:
        rule = self._rule
        wrong = [
            f"{channel_name_text(name)} {self._text(speed)}, "
            + (
                f"below {self._text(rule.low)}"
                if speed < rule.low
                else f"above {self._text(rule.high)}"
            )
            for name, speed in zip(rule.channels, speeds, strict=True)
            if not rule.low <= speed <= rule.high
        ]
        if wrong:
            return format_list(wrong)
        apart = max(speeds) - min(speeds)
        if rule.apart is not None and apart > rule.apart:
            return (
                f"{self._speeds_text(speeds)}: {self._text(apart)} apart, "
                f"{self._text(rule.apart)} allowed"
            )
        return None

    def _text(self, speed: float) -> str:
        return format_channel_value(speed, self._rule.channels[0])

    def _speeds_text(self, speeds: tuple[float, ...]) -> str:
        pairs = zip(self._rule.channels, speeds, strict=True)
        return format_list(
            [f"{channel_name_text(name)} {self._text(speed)}" for name, speed in pairs]
        )


class _PulseCounter:
    """Counts the pulses of one surface."""

    __slots__ = ("_began", "_longest", "_rest", "_size", "_time", "count", "largest")

    def __init__(self, size: float, longest: float) -> None:
        self._size = size
        self._longest = longest
        self._rest: float | None = None
        self._time = math.nan
        self._began = math.nan
        self.count = 0
        self.largest = 0.0

    def add(self, time: float, value: float) -> None:
        if self._rest is None:
            self._rest, self._time = value, time
            return
        away = abs(value - self._rest)
        if math.isnan(self._began):
            if away >= self._size:
                self._began = time
            elif away < MONITORS.pulse_end_share * self._size:
                share = 1.0 - math.exp(
                    -min(max(time - self._time, 0.0), 1.0) / MONITORS.rest_time_constant
                )
                self._rest += share * (value - self._rest)
        elif away < MONITORS.pulse_end_share * self._size:
            self.count += 1
            self._began = math.nan
        elif time - self._began > self._longest:
            # Not a pulse: the surface stays there, or the trim was moved.
            self._rest, self._began = value, math.nan
        if not math.isnan(self._began):
            self.largest = max(self.largest, away)
        self._time = time


class SurfacePulseEvaluator:
    """See `gsapp.session.checklist.items.SurfacePulseRule`."""

    def __init__(self, rule: SurfacePulseRule) -> None:
        self._rule = rule
        self._watches = {name: _PulseCounter(rule.size, rule.longest) for name in rule.channels}

    def feed(self, block: Block) -> None:
        for name, watch in self._watches.items():
            if name not in block:
                continue
            for time, value in zip(block.times.tolist(), block[name].tolist(), strict=True):
                if math.isfinite(value):
                    watch.add(time, value)

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        rule = self._rule
        carried = [name for name in rule.channels if name in facts.states]
        missing = check_missing_channels(carried or rule.channels, facts)
        if missing is not None:
            return missing
        seen = [
            f"{watch.count} of the {channel_name_text(name)}, up to "
            f"{format_channel_value(watch.largest, name)}"
            for name, watch in self._watches.items()
            if watch.count
        ]
        count = sum(watch.count for watch in self._watches.values())
        if count >= rule.count:
            return RuleResult(state="green", why=f"seen: {'; '.join(seen)}")
        size = format_channel_value(rule.size, rule.channels[0])
        wanted = f"{count} of {rule.count} pulses of {size} detected: ask the pilot for them"
        return RuleResult(state="open", why=wanted)
