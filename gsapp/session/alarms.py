"""Alarms: raised by limits and by failing equipment, latched, acknowledged, newest first.

An alarm stays until somebody has acknowledged it *and* its cause is gone.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

from gsapp.quantities import channel, from_si
from gsapp.session.limits import LimitRule, Severity


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """One alarm as it stands."""

    key: str
    """What it is about: ``alpha:high``, ``link``, ``recorder``, ``disk`` ..."""
    severity: Severity
    """The worst since it was raised or acknowledged."""
    current: Severity
    """As of now; NORMAL once the cause is gone."""
    time: float | None
    """Flight time at which it was raised (or grew worse), s."""
    message: str
    """What it means, or the whole sentence for alarms without a value."""
    rule: LimitRule | None = None
    value: float | None = None
    """The farthest value since it was raised, SI."""
    acknowledged: bool = False
    """Whether somebody has said so since it was raised or grew worse."""
    count: int = 1
    """How many times it was raised since it last left the list."""

    @property
    def active(self) -> bool:
        return self.current > Severity.NORMAL

    def message_text(self, system: str = "SI") -> str:
        """Return what a field engineer says, with units of the system ``"SI"`` or ``"US"``."""
        return _alarm_text(self, system)


def _alarm_text(alarm: Alarm | AlarmEpisode, system: str) -> str:
    rule, value = alarm.rule, alarm.value
    if rule is None or value is None:
        return alarm.message
    spec = channel(rule.channel)
    unit = spec.display_unit(system)
    shown, bound = (
        f"{from_si(number, unit, spec.quantity):.{spec.decimals(unit)}f} {unit}".strip()
        for number in (value, _limit(rule, alarm.severity) or 0.0)
    )
    beyond = "above" if rule.side == "high" else "below"
    meaning = rule.describe(alarm.severity)
    tail = f", {meaning}" if meaning else ""
    return f"{spec.title} {shown}, {beyond} {bound}{tail}"


def _limit(rule: LimitRule, severity: Severity) -> float | None:
    limit = rule.warning if severity is Severity.WARNING else rule.caution
    if limit is None:
        limit = rule.caution if rule.warning is None else rule.warning
    return limit


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmOnset:
    """An alarm at the moment it was raised, for the log and the time axis."""

    key: str
    severity: Severity
    time: float | None
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmAcknowledgment:
    """Who has seen an alarm, and when."""

    raised: float | None
    """Flight time at which the alarm was raised, s; tells which one is meant."""
    by: str = ""
    """Who, and how: ``crew, key K``; empty where it was not written."""
    time: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmEpisode:
    """An alarm from when its cause came to when it was gone."""

    key: str
    severity: Severity
    onset: float | None
    """Flight time at which it was raised, s."""
    end: float | None = None
    """Flight time at which the cause was gone, s; None while it stays, or if nobody knows."""
    message: str
    rule: LimitRule | None = None
    value: float | None = None
    raised: float | None
    """Flight time at which it was raised or last grew worse, s."""
    acknowledgment: AlarmAcknowledgment | None = None
    """Of the alarm since then; None while nobody has seen it."""
    is_over: bool = False
    """Whether the cause is gone, even if nobody knows since when."""

    @property
    def acknowledged(self) -> bool:
        """Return whether somebody has seen it since it was raised or last grew worse."""
        return self.acknowledgment is not None

    @property
    def limit(self) -> float | None:
        """Return the limit that was passed, SI; None for alarms without a value."""
        return None if self.rule is None else _limit(self.rule, self.severity)

    @property
    def meaning(self) -> str:
        """Return what it means, without the value; the whole sentence where there is no value."""
        return self.message if self.rule is None else self.rule.describe(self.severity)

    def message_text(self, system: str = "SI") -> str:
        """Return what a field engineer says, with units of the system ``"SI"`` or ``"US"``."""
        return _alarm_text(self, system)


def order_by_time(time: float | None, key: str) -> tuple[float, str]:
    """Return what sorts alarms by flight time; those without one come first."""
    return (-math.inf if time is None else time, key)


class AlarmRegistry:
    """The alarms that stand, whoever raised them, and all that were raised so far."""

    def __init__(self) -> None:
        self.revision = 0
        self._log: list[AlarmOnset] = []
        self._episodes: list[AlarmEpisode] = []
        # Place in the list of the episode that goes on, by key.
        self._active_indices: dict[str, int] = {}
        self._alarms: dict[str, Alarm] = {}
        self._acknowledged: dict[str, list[AlarmAcknowledgment]] = {}

    @property
    def current_alarms(self) -> tuple[Alarm, ...]:
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
    def onsets(self) -> tuple[AlarmOnset, ...]:
        """Return every alarm raised so far, by time; those without a flight time first."""
        return tuple(
            sorted(
                self._log, key=lambda one: (-math.inf if one.time is None else one.time, one.key)
            )
        )

    @property
    def episodes(self) -> tuple[AlarmEpisode, ...]:
        """Return every alarm so far from onset to end, by onset; those without one first."""
        told = (
            replace(one, acknowledgment=self.acknowledgment(one.key, one.raised))
            for one in self._episodes
        )
        return tuple(sorted(told, key=lambda one: order_by_time(one.onset, one.key)))

    def acknowledgment(self, key: str, raised: float | None) -> AlarmAcknowledgment | None:
        """Return who has seen the alarm of a key that was raised at a flight time (s).

        An alarm stays until it is seen, so that one which came back is seen together with what
        it was before.
        """
        for one in self._acknowledged.get(key, ()):
            if one.raised == raised or (
                one.raised is not None and raised is not None and one.raised >= raised
            ):
                return one
        return None

    def onsets_of(self, keys: Collection[str]) -> tuple[AlarmOnset, ...]:
        """Return the alarms of some keys, in the order in which they were raised."""
        return tuple(onset for onset in self._log if onset.key in keys)

    @property
    def unacknowledged(self) -> tuple[Alarm, ...]:
        return tuple(alarm for alarm in self.current_alarms if not alarm.acknowledged)

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
        text: str,
        *,
        rule: LimitRule | None = None,
        value: float | None = None,
    ) -> None:
        """Raise an alarm, or bring one that stands up to date."""
        self.revision += 1
        former = self._alarms.get(key)
        if former is not None and severity <= former.current:
            # Not worse: the same alarm goes on, perhaps milder, perhaps in other words.
            changed = replace(former, current=severity)
            if severity == former.severity:
                changed = replace(changed, message=text)
            self._alarms[key] = changed
            if value is not None:
                self.update_peak(key, value)
            return
        if former is not None and rule is not None and value is not None:
            value = rule.worse_value(value, former.value)
        self._alarms[key] = Alarm(
            key=key,
            severity=severity if former is None else max(severity, former.severity),
            current=severity,
            time=time,
            message=text,
            rule=rule,
            value=value,
            acknowledged=self._is_acknowledged(key, time),
            count=1 if former is None else former.count + (not former.active),
        )
        self._log.append(AlarmOnset(key=key, severity=severity, time=time, message=text))
        self._update_episode(key, severity, time, text, rule, value)

    def _update_episode(
        self,
        key: str,
        severity: Severity,
        time: float | None,
        text: str,
        rule: LimitRule | None,
        value: float | None,
    ) -> None:
        """Begin an episode, or let the one that goes on grow worse."""
        place = self._active_indices.get(key)
        if place is None:
            self._active_indices[key] = len(self._episodes)
            self._episodes.append(
                AlarmEpisode(
                    key=key, severity=severity, onset=time, message=text, rule=rule, value=value,
                    raised=time,
                )
            )  # fmt: skip
            return
        former = replace(self._episodes[place], raised=time)
        if severity > former.severity:
            former = replace(former, severity=severity, message=text, rule=rule)
        self._episodes[place] = former
        self._update_worst_value(key, value)

    def _update_worst_value(self, key: str, value: float | None) -> None:
        place = self._active_indices.get(key)
        former = None if place is None else self._episodes[place]
        if place is None or former is None or former.rule is None or value is None:
            return
        farthest = former.rule.worse_value(value, former.value)
        if farthest != former.value:
            self._episodes[place] = replace(former, value=farthest)

    def update_peak(self, key: str, value: float) -> None:
        """Note how far the value of an alarm went that stands; the farthest is kept."""
        former = self._alarms.get(key)
        if former is None or former.rule is None:
            return
        self.revision += 1
        self._update_worst_value(key, value)
        self._alarms[key] = replace(former, value=former.rule.worse_value(value, former.value))

    def clear(self, key: str, time: float | None = None) -> None:
        """Say that the cause is gone since a flight time (s); acknowledgment ends the alarm."""
        former = self._alarms.get(key)
        if former is None or not former.active:
            return
        self.revision += 1
        place = self._active_indices.pop(key)
        self._episodes[place] = replace(self._episodes[place], end=time, is_over=True)
        if former.acknowledged:
            del self._alarms[key]
        else:
            self._alarms[key] = replace(former, current=Severity.NORMAL)

    def dismiss(self, key: str) -> None:
        """Remove an alarm whose cause is gone without acknowledgment; the log keeps it."""
        alarm = self._alarms.get(key)
        if alarm is not None and not alarm.active:
            del self._alarms[key]
            self.revision += 1

    def acknowledge(
        self, key: str, raised: float | None, by: str = "", time: float | None = None
    ) -> None:
        """Take note that somebody has seen the alarm raised at a flight time (s).

        That time says which one, since acknowledgments come from other windows too, and may be
        read before the alarm itself in a replay.
        """
        if not self._is_acknowledged(key, raised):
            self.revision += 1
            known = self._acknowledged.setdefault(key, [])
            known.append(AlarmAcknowledgment(raised=raised, by=by, time=time))
            known.sort(key=lambda one: -math.inf if one.raised is None else one.raised)
        alarm = self._alarms.get(key)
        if alarm is None or alarm.acknowledged or alarm.time != raised:
            return
        if alarm.active:
            self._alarms[key] = replace(alarm, acknowledged=True, severity=alarm.current)
        else:
            del self._alarms[key]

    def _is_acknowledged(self, key: str, raised: float | None) -> bool:
        return any(one.raised == raised for one in self._acknowledged.get(key, ()))

    def end_all(self, time: float | None) -> None:
        """Let every alarm end with its flight at a time (s); the log keeps them."""
        for key in tuple(self._alarms):
            self.clear(key, time)
        self._alarms.clear()
        self.revision += 1

    def reset(self) -> None:
        self.revision += 1
        self._alarms.clear()
        self._log.clear()
        self._episodes.clear()
        self._active_indices.clear()
