"""The rules at work: each judges its item from samples and from what else is known."""

from __future__ import annotations

import math
from datetime import timedelta
from functools import singledispatch
from typing import Generic, TypeVar

import numpy as np

from gsapp.flight.info import FlightInfo
from gsapp.quantities import Block, FloatArray, channel
from gsapp.session.channel_states import ChannelState
from gsapp.session.checklist.evaluation import (
    NO_FLIGHT,
    ChecklistContext,
    RuleEvaluator,
    RuleResult,
    channel_name_text,
    check_missing_channels,
    format_channel_value,
    format_list,
    require_live_equipment,
)
from gsapp.session.checklist.items import (
    CalibrationRule,
    ChecklistRule,
    DiskSpaceRule,
    EngineSpeedRule,
    FlightCardRule,
    LinkRule,
    RangeRule,
    RecorderRule,
    SensorActivityRule,
    SurfacePulseRule,
    SurfaceResponseRule,
)
from gsapp.session.checklist.motion_evaluators import (
    EngineSpeedEvaluator,
    SurfacePulseEvaluator,
    SurfaceResponseEvaluator,
)
from gsapp.session.limits import Severity

RuleT = TypeVar("RuleT")


def create_evaluator(rule: ChecklistRule) -> RuleEvaluator:
    """Return what judges a rule."""
    return _create_evaluator(rule)


@singledispatch
def _create_evaluator(rule: object) -> RuleEvaluator:
    raise TypeError(f"no judge for {type(rule).__name__}")


_create_evaluator.register(SurfaceResponseRule)(SurfaceResponseEvaluator)
_create_evaluator.register(EngineSpeedRule)(EngineSpeedEvaluator)
_create_evaluator.register(SurfacePulseRule)(SurfacePulseEvaluator)


class _SnapshotEvaluator(Generic[RuleT]):
    """Needs no samples."""

    def __init__(self, rule: RuleT) -> None:
        self._rule = rule

    def feed(self, block: Block) -> None:
        """Pass the samples over."""


@_create_evaluator.register(LinkRule)
class LinkEvaluator(_SnapshotEvaluator[LinkRule]):
    """See `gsapp.session.checklist.items.LinkRule`."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        there = require_live_equipment(facts)
        if isinstance(there, RuleResult):
            return there
        link, rule = there.link, self._rule
        if link.age is None:
            return RuleResult(state="open", why=f"no data yet (link: {link.state})")
        if link.age > rule.age:
            return RuleResult(
                state="red", why=f"nothing for {link.age:.0f} s: check radio and telemetry unit"
            )
        lost = f"{100.0 * link.loss:.1f} % of the frames lost, {link.rate:.0f} messages per second"
        if link.loss > rule.loss_red:
            return RuleResult(state="red", why=f"{lost}: move the antenna or change the channel")
        return RuleResult(state="amber" if link.loss > rule.loss else "green", why=lost)


@_create_evaluator.register(RecorderRule)
class RecorderEvaluator(_SnapshotEvaluator[RecorderRule]):
    """See `gsapp.session.checklist.items.RecorderRule`."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        there = require_live_equipment(facts)
        if isinstance(there, RuleResult):
            return there
        recorder = there.recorder
        written = f"{recorder.received_bytes / 1e6:.2f} MB written"
        if recorder.pid is None:
            return RuleResult(state="red", why=f"no recorder runs ({recorder.state}): start it")
        if recorder.severity is not Severity.NORMAL:
            return RuleResult(
                state="red" if recorder.severity is Severity.WARNING else "amber",
                why="; ".join(recorder.remarks) or recorder.state,
            )
        if not recorder.growing and not recorder.byte_rate > 0.0:
            return RuleResult(state="red", why=f"{written}, not growing: check the link")
        return RuleResult(
            state="green", why=f"{written}, growing {recorder.byte_rate / 1e3:.1f} kB/s"
        )


@_create_evaluator.register(DiskSpaceRule)
class DiskSpaceEvaluator(_SnapshotEvaluator[DiskSpaceRule]):
    """See `gsapp.session.checklist.items.DiskSpaceRule`."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        there = require_live_equipment(facts)
        if isinstance(there, RuleResult):
            return there
        disk, rule = there.disk, self._rule
        if disk.free_bytes is None:
            return RuleResult(state="amber", why="free disk space unknown")
        free = disk.free_bytes / 1e9
        lasts = math.inf if disk.seconds_left is None else disk.seconds_left
        why = f"{free:.1f} GB free"
        if math.isfinite(lasts):
            why += f", for {lasts / 3600.0:.1f} h" if lasts < 360e3 else ", for days"
        if lasts < rule.time_red:
            return RuleResult(state="red", why=f"{why}: delete something before the flight")
        enough = lasts >= rule.time and free >= rule.gigabytes
        return RuleResult(state="green" if enough else "amber", why=why)


@_create_evaluator.register(CalibrationRule)
class CalibrationEvaluator(_SnapshotEvaluator[CalibrationRule]):
    """See `gsapp.session.checklist.items.CalibrationRule`."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        if facts.calibration is None:
            return NO_FLIGHT
        age = self._rule.age
        status = facts.calibration.evaluate(
            self._rule.channels, None if age is None else timedelta(seconds=age)
        )
        if status.state == "caution":
            why = f"{status.detail}: calibrate again, or check three points and tick"
            return RuleResult(state="amber", why=why, allows_manual_tick=True)
        if status.state == "unknown":
            return RuleResult(
                state="amber", why=f"{status.detail}: check and tick", allows_manual_tick=True
            )
        return RuleResult(state="green" if status.state == "good" else "red", why=status.detail)


@_create_evaluator.register(FlightCardRule)
class FlightCardEvaluator(_SnapshotEvaluator[FlightCardRule]):
    """See `gsapp.session.checklist.items.FlightCardRule`."""

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        card = facts.card
        if card is None:
            return RuleResult(state="open", why="no flight card yet")
        if facts.card_issues:
            return RuleResult(state="amber", why=facts.card_issues[0])
        empty = [name for name in self._rule.fields if not is_card_field_filled(card, name)]
        if empty:
            words = [name.replace("_", " ").replace(".", ": ") for name in empty]
            return RuleResult(state="open", why=f"not filled in: {format_list(words)}")
        return RuleResult(state="green", why="filled in")


def is_card_field_filled(card: FlightInfo, field: str) -> bool:
    """Return whether a key path of the card holds anything."""
    value: object = card
    for part in field.split("."):
        value = value.get(part) if isinstance(value, dict) else getattr(value, part, None)
    return value is not None and value != "" and value != {} and value != ()


@_create_evaluator.register(RangeRule)
class RangeEvaluator:
    """See `gsapp.session.checklist.items.RangeRule`."""

    def __init__(self, rule: RangeRule) -> None:
        self._rule = rule
        self._last: tuple[float, float] | None = None
        self._inside_since: float | None = None

    def feed(self, block: Block) -> None:
        if self._rule.channel not in block:
            return
        values = block[self._rule.channel]
        there = np.flatnonzero(np.isfinite(values))
        if not there.size:
            return
        times, values = block.times[there], values[there]
        _, low, high, _ = self._rule.bounds
        outside = np.flatnonzero((values < low) | (values > high))
        if outside.size:
            after = int(outside[-1]) + 1
            self._inside_since = float(times[after]) if after < times.size else None
        elif self._inside_since is None:
            self._inside_since = float(times[0])
        self._last = (float(times[-1]), float(values[-1]))

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        rule = self._rule
        missing = check_missing_channels((rule.channel,), facts)
        if missing is not None:
            return missing
        if self._last is None:
            return RuleResult(state="open", why=f"no {channel_name_text(rule.channel)} yet")
        time, value = self._last
        low_red, low, high, high_red = rule.bounds
        here = self._shown(value)
        if not low_red <= value <= high_red or not low <= value <= high:
            red = value < low_red or value > high_red
            side = (
                f"below {self._shown(low_red if red else low)}"
                if value < low
                else f"above {self._shown(high_red if red else high)}"
            )
            return RuleResult(state="red" if red else "amber", why=f"{here}, {side}")
        held = 0.0 if self._inside_since is None else time - self._inside_since
        if held < rule.duration:
            return RuleResult(state="open", why=f"{here}, within for {held:.1f} s so far")
        return RuleResult(state="green", why=here)

    def _shown(self, value: float) -> str:
        given = self._rule.low if self._rule.low is not None else self._rule.high
        unit = str(given).strip().lstrip("+-0123456789.eE ")
        return format_channel_value(value, self._rule.channel, unit)


@_create_evaluator.register(SensorActivityRule)
class SensorActivityEvaluator:
    """See `gsapp.session.checklist.items.SensorActivityRule`."""

    def __init__(self, rule: SensorActivityRule) -> None:
        self._rule = rule
        self._value: dict[str, float] = {}
        self._changed: dict[str, float] = {}
        self._first: dict[str, float] = {}
        self._now: dict[str, float] = {}

    def feed(self, block: Block) -> None:
        for name in self._rule.channels:
            if name not in block:
                continue
            values = block[name]
            there = np.flatnonzero(np.isfinite(values))
            if there.size:
                self._update_value(name, block.times[there], values[there])

    def _update_value(self, name: str, times: FloatArray, values: FloatArray) -> None:
        before = self._value.get(name, math.nan)
        changes = np.flatnonzero(np.diff(values, prepend=before) != 0.0)
        self._first.setdefault(name, float(times[0]))
        if changes.size:
            self._changed[name] = float(times[changes[-1]])
        self._value[name] = float(values[-1])
        self._now[name] = float(times[-1])

    def evaluate(self, facts: ChecklistContext) -> RuleResult:
        rule = self._rule
        missing = check_missing_channels(rule.channels, facts)
        if missing is not None:
            return missing
        wrong = [
            text
            for name in rule.channels
            if (text := self._wrong(name, facts.states.get(name))) is not None
        ]
        if wrong:
            return RuleResult(state="red", why=format_list(wrong))
        waiting = [name for name in rule.channels if self._seen(name) < rule.duration]
        if waiting:
            return RuleResult(
                state="open",
                why=f"watching {format_list([channel_name_text(one) for one in waiting])}",
            )
        return RuleResult(state="green", why=f"{len(rule.channels)} channels live")

    def _seen(self, name: str) -> float:
        return self._now[name] - self._first[name] if name in self._now else 0.0

    def _wrong(self, name: str, state: ChannelState | None) -> str | None:
        if state is not None and state.clipped:
            return f"{channel_name_text(name)} at the end of its range"
        if name not in self._value:
            return None
        low, high = channel(name).limits
        value = self._value[name]
        if not low <= value <= high:
            reading = format_channel_value(value, name)
            return f"{channel_name_text(name)} reads {reading}, implausible"
        still = self._now[name] - self._changed.get(name, self._first[name])
        if self._rule.moving and still >= self._rule.duration:
            return f"{channel_name_text(name)} stuck at {format_channel_value(value, name)}"
        return None
