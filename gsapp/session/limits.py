"""Which values call for attention: limits of the aircraft, of the instruments, and the crew's own.

A limit has a side, a caution and a warning. Bands for the charts and alarms come from the same
rules.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from gsapp.aircraft import Aircraft
from gsapp.foundation import StrictModel, UnknownNameError, read_toml
from gsapp.foundation.files import ShippedFiles
from gsapp.quantities import base_id, channel, parse_quantity
from gsapp.session.monitor_settings import MONITORS

LimitSide = Literal["low", "high"]

LIMIT_TABLES = ShippedFiles(folder=Path(__file__).parent / "files", kind="limits")


class Severity(IntEnum):
    """How urgent something is."""

    NORMAL = 0
    CAUTION = 1
    WARNING = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitRule:
    """One side of one channel."""

    channel: str
    side: LimitSide
    caution: float | None = None
    warning: float | None = None
    """SI; beyond it the alarm is raised."""
    hysteresis: float = 0.0
    """How far a value must come back before the alarm ends, SI."""
    duration: float = MONITORS.min_limit_time
    """How long a value must stay beyond, or back, s."""
    caution_text: str = ""
    warning_text: str = ""
    armed_at: float | None = None
    """The rule sleeps until a value was on the safe side of this, SI ..."""
    disarmed_at: float | None = None
    """... and again once a value is beyond this: an aircraft on the ground is below its stall
    speed."""
    airborne_only: bool = False
    """Whether it waits near the ground from which the aircraft took off; see
    `gsapp.session.limit_monitor`."""

    @property
    def key(self) -> str:
        return f"{self.channel}:{self.side}"

    def describe(self, severity: Severity) -> str:
        """Return what it means to be that far beyond."""
        return self.warning_text if severity is Severity.WARNING else self.caution_text

    def worse_value(self, one: float, other: float | None) -> float:
        """Return the value that lies farther beyond the limit."""
        if other is None:
            return one
        return max(one, other) if self.side == "high" else min(one, other)


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitBands:
    """The limits of one channel as a chart draws them, SI; None where there is none."""

    warning_low: float | None = None
    caution_low: float | None = None
    caution_high: float | None = None
    warning_high: float | None = None


class LimitEntry(StrictModel):
    """One channel in a limit table; values with units, such as ``"11.1 V"``.

    With ``off`` the channel has no limits at all, not even those of the aircraft.
    """

    channel: str
    low_warning: str | float | None = None
    low_caution: str | float | None = None
    high_caution: str | float | None = None
    high_warning: str | float | None = None
    hysteresis: str | float | None = None
    duration: str = f"{MONITORS.min_limit_time} s"
    words: str = ""
    off: bool = False

    @model_validator(mode="after")
    def _must_make_sense(self) -> LimitEntry:
        try:
            channel(self.channel)
        except UnknownNameError as error:
            # pydantic passes ValueError on, with the key path.
            raise ValueError(str(error)) from error
        values = [
            self.value(name)
            for name in ("low_warning", "low_caution", "high_caution", "high_warning")
        ]
        given = [value for value in values if value is not None]
        if self.off and given:
            raise ValueError("limits are given and switched off; remove off = true or the limits")
        if not given and not self.off:
            raise ValueError("no limit is given; write low_caution, high_warning, ...")
        if any(one >= other for one, other in pairwise(given)):
            raise ValueError(
                "limits must grow from low_warning over low_caution and high_caution to "
                "high_warning; put them in order"
            )
        self.value("hysteresis")
        if parse_quantity(self.duration, "time") < 0.0:
            raise ValueError('a duration is not negative; write for example "0.5 s"')
        return self

    def value(self, name: str) -> float | None:
        """Return one of the values in SI."""
        text: str | float | None = getattr(self, name)
        if text is None:
            return None
        value = parse_quantity(text, channel(self.channel).quantity)
        if name == "hysteresis":
            # A difference: degrees Celsius have an offset that must not count.
            key = channel(self.channel).quantity
            unit = str(text).strip().lstrip("+-0123456789.eE ")
            value -= parse_quantity(f"0 {unit}", key) if unit else 0.0
        return value

    def rules(self) -> tuple[LimitRule, ...]:
        """Return the rules for the sides that have a limit."""
        found = []
        sides: tuple[LimitSide, LimitSide] = ("low", "high")
        for side in sides:
            caution, warning = self.value(f"{side}_caution"), self.value(f"{side}_warning")
            if caution is None and warning is None and not self.off:
                continue
            hysteresis = self.value("hysteresis")
            found.append(
                LimitRule(
                    channel=self.channel,
                    side=side,
                    caution=caution,
                    warning=warning,
                    hysteresis=_default_hysteresis(self.channel)
                    if hysteresis is None
                    else abs(hysteresis),
                    duration=parse_quantity(self.duration, "time"),
                    caution_text=self.words,
                    warning_text=self.words,
                )
            )
        return tuple(found)


class LimitTable(StrictModel):
    """A limits file: ``[[limits]]`` with a channel, its limits, hysteresis and duration."""

    limits: tuple[LimitEntry, ...] = Field(default_factory=tuple)

    def rules(self) -> tuple[LimitRule, ...]:
        """Return the rules of all entries."""
        return tuple(rule for entry in self.limits for rule in entry.rules())


def load_limits(name_or_path: Path | str) -> LimitTable:
    """Read a limits file by path, or a shipped one by name.

    Raises
    ------
    UnknownNameError
        If there is neither.
    FileProblemsError
        If it holds mistakes; all are named.
    """
    return read_toml(LIMIT_TABLES.find(name_or_path), LimitTable)


def _default_hysteresis(channel_id: str, limit: float = 0.0) -> float:
    return max(3.0 * channel(channel_id).precision, 0.02 * abs(limit))


def _rule(
    channel_id: str,
    side: LimitSide,
    caution: float | None,
    warning: float | None,
    words: tuple[str, str],
    *,
    duration: float = MONITORS.min_limit_time,
    armed_at: float | None = None,
    asleep_at: float | None = None,
    airborne_only: bool = False,
) -> LimitRule:
    reference = warning if caution is None else caution
    return LimitRule(
        channel=channel_id,
        side=side,
        caution=caution,
        warning=warning,
        hysteresis=_default_hysteresis(channel_id, reference or 0.0),
        duration=duration,
        caution_text=words[0],
        warning_text=words[1],
        armed_at=armed_at,
        disarmed_at=asleep_at,
        airborne_only=airborne_only,
    )


def aircraft_rules(aircraft: Aircraft) -> tuple[LimitRule, ...]:
    """Return the rules that follow from an aircraft file: flight limits and surface travel."""
    limits = aircraft.limits
    linear_low, linear_high = limits.alpha_linear
    out = "outside the linear range"
    load_low, load_high = limits.load_factor
    rules = [
        _rule("alpha", "high", linear_high, limits.alpha_stall, (out, "stall")),
        _rule("alpha", "low", linear_low, None, (out, "")),
        _rule("beta", "high", limits.beta_linear, None, (out, "")),
        _rule("beta", "low", -limits.beta_linear, None, (out, "")),
        _rule("an", "high", 0.9 * load_high, load_high, ("near the g limit", "beyond the g limit")),
        _rule("an", "low", 0.9 * load_low, load_low, ("near the g limit", "beyond the g limit")),
        _rule("phi", "high", limits.bank, None, ("steep bank", "")),
        _rule("phi", "low", -limits.bank, None, ("steep bank", "")),
    ]
    if limits.stall_speed > 0.0:
        rules.append(
            _rule(
                "Vc",
                "low",
                1.1 * limits.stall_speed,
                limits.stall_speed,
                ("near stall speed", "below stall speed"),
                duration=0.3,
                armed_at=1.25 * limits.stall_speed,
                asleep_at=0.6 * limits.stall_speed,
                airborne_only=True,
            )
        )
    if limits.maximum_speed < 1e8:
        fast = limits.maximum_speed
        rules.append(
            _rule("Vc", "high", 0.95 * fast, fast, ("near maximum speed", "too fast"), duration=0.3)
        )
    for name in ("de", "da", "dr", "flap"):
        low, high = getattr(aircraft.controls, name).travel
        # The stops themselves are reached every day; beyond them the potentiometer slipped.
        slack = 0.1 * (high - low)
        beyond = "beyond its travel: check its potentiometer"
        rules.append(_rule(name, "high", high + slack, None, (beyond, ""), duration=0.5))
        rules.append(_rule(name, "low", low - slack, None, (beyond, ""), duration=0.5))
    return tuple(rules)


def instrument_rules(channel_id: str) -> tuple[LimitRule, ...]:
    """Return the rules for values that no instrument of that kind can truly read."""
    low, high = channel(channel_id).limits
    # Noise about the end of a range, such as an airspeed of a little less than nothing, is none.
    slack = 0.02 * (high - low)
    low, high = low - slack, high + slack
    words = ("not plausible: check the instrument", "")
    return (
        _rule(channel_id, "low", low, None, words, duration=0.5),
        _rule(channel_id, "high", high, None, words, duration=0.5),
    )


def _with_limits(rules: Sequence[LimitRule]) -> dict[str, LimitRule]:
    """Return rules by key, the last one of each, without those that hold no limit."""
    found = {rule.key: rule for rule in rules}
    return {
        key: rule
        for key, rule in found.items()
        if rule.caution is not None or rule.warning is not None
    }


def _user_rule(
    former: LimitRule | None,
    channel_id: str,
    side: LimitSide,
    caution: float | None,
    warning: float | None,
) -> LimitRule:
    if former is None:
        return _rule(channel_id, side, caution, warning, ("", ""))
    armed, asleep = former.armed_at, former.disarmed_at
    ends = [value for value in (caution, warning) if value is not None]
    # A rule that sleeps wakes on the safe side of its limits, and sleeps beyond them.
    if ends and armed is not None and asleep is not None and side == "low":
        armed, asleep = max(armed, 1.1 * max(ends)), min(asleep, 0.9 * min(ends))
    return replace(former, caution=caution, warning=warning, armed_at=armed, disarmed_at=asleep)


class LimitSet:
    """The rules in force: the crew's own before the aircraft's before the instruments'.

    Parameters
    ----------
    own : sequence of LimitRule
        From a limits file; each replaces the other rules of its channel and side, and takes them
        away where it holds no limit.
    """

    def __init__(self, aircraft: Aircraft | None = None, own: Sequence[LimitRule] = ()) -> None:
        rules = [*(aircraft_rules(aircraft) if aircraft is not None else ()), *own]
        self._given = _with_limits(rules)
        self._typed: dict[str, dict[str, LimitRule]] = {}
        self.revision = 0
        self._ranges = instrument_range_ends(aircraft) if aircraft is not None else {}

    def rules(self, channel_id: str) -> tuple[LimitRule, ...]:
        """Return the rules of a channel, low side first.

        A redundant sensor keeps the limits of its quantity, but only the instrument's.
        """
        given = self._typed.get(channel_id, self._given)
        return tuple(given.get(rule.key, rule) for rule in instrument_rules(channel_id))

    def set_user_limits(self, channel_id: str, bands: LimitBands | None) -> None:
        """Let limits typed by the crew take the place of all others of a channel; None ends that.

        A side keeps the words, the patience and the sleep of the rule that it had before.
        """
        self._typed.pop(channel_id, None)
        self.revision += 1
        if bands is None:
            return
        sides: tuple[LimitSide, LimitSide] = ("low", "high")
        rules = [
            _user_rule(
                self._given.get(f"{channel_id}:{side}"),
                channel_id,
                side,
                *(
                    (bands.caution_low, bands.warning_low)
                    if side == "low"
                    else (bands.caution_high, bands.warning_high)
                ),
            )
            for side in sides
        ]
        self._typed[channel_id] = _with_limits(rules)

    def has_user_limits(self, channel_id: str) -> bool:
        """Return whether typed limits count for a channel."""
        return channel_id in self._typed

    def bands(self, channel_id: str) -> LimitBands:
        """Return what a chart draws; not the limits of plausibility, which nobody flies by."""
        given = self._typed.get(channel_id, self._given)
        low, high = given.get(f"{channel_id}:low"), given.get(f"{channel_id}:high")
        return LimitBands(
            warning_low=low.warning if low else None,
            caution_low=low.caution if low else None,
            caution_high=high.caution if high else None,
            warning_high=high.warning if high else None,
        )

    def is_clipped(self, channel_id: str, value: float) -> bool:
        """Return whether a value (SI) stands at the end of its instrument's range."""
        ends = self._ranges.get(base_id(channel_id))
        if ends is None:
            return False
        low, high = ends
        slack = 0.002 * (high - low if math.isfinite(low) else high)
        return value <= low + slack or value >= high - slack


def instrument_range_ends(aircraft: Aircraft) -> Mapping[str, tuple[float, float]]:
    """Return the ends of the instruments' ranges by channel, SI."""
    sensors = aircraft.sensors
    return {
        **{name: one.range for name, one in sensors.by_channel.items()},
        "static_pressure": sensors.air_data.static_range,
        # A differential pressure of nothing is a standstill and no stop.
        "dynamic_pressure": (-math.inf, sensors.air_data.range[1]),
    }
