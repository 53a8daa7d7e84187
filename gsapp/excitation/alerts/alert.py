"""Alerts: what was found in one frame, what stands now and since when, and their words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Final

from gsapp.excitation.settings import ALERTS
from gsapp.quantities import channel, from_si


class AlertLevel(IntEnum):
    """How urgent something is."""

    CAUTION = 1
    WARNING = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """One thing that stands."""

    key: str
    """What it is about: ``nose``, ``alpha``, ``gyro.q``, ``stall``, ``fence``, ``clip.r`` ..."""
    level: AlertLevel
    since: float = math.nan
    """Flight time, s; NaN of what was found in one frame."""
    text: str
    """A sentence to be read, with what to do."""
    spoken_text: str
    """A few words to be heard: "nose sensors lost: land"."""
    channels: tuple[str, ...] = ()
    """Channels that are not to be trusted while it stands."""


def warning(key: str, text: str, spoken_text: str, channels: tuple[str, ...] = ()) -> Alert:
    """Return a warning; see `Alert`."""
    level = AlertLevel.WARNING
    return Alert(key=key, level=level, text=text, spoken_text=spoken_text, channels=channels)


def caution(key: str, text: str, spoken_text: str, channels: tuple[str, ...] = ()) -> Alert:
    """Return a caution; see `Alert`."""
    level = AlertLevel.CAUTION
    return Alert(key=key, level=level, text=text, spoken_text=spoken_text, channels=channels)


INSTRUMENT_TITLES: Final[Mapping[str, str]] = {
    "alpha": "alpha vane",
    "beta": "beta vane",
    "V": "airspeed",
    "p": "roll gyro",
    "q": "pitch gyro",
    "r": "yaw gyro",
    "ax": "longitudinal accelerometer",
    "ay": "lateral accelerometer",
    "an": "normal accelerometer",
}


def format_amount(name: str, value: float, system: str) -> str:
    """Return a value (SI) in whole units of its channel, ``US`` or ``SI``: "400 ft"."""
    spec = channel(name)
    unit = spec.display_unit(system)
    return f"{from_si(value, unit, spec.quantity):.0f} {unit}"


_FIRST: Final = (
    "stall", "nose", "airspeed", "alpha", "beta", "gyro", "motion", "fence", "clip",
    "battery", "fuel", "time", "radio",
)  # fmt: skip
"""Among equally urgent ones these come first, in this order."""


@dataclass(slots=True)
class _Entry:
    danger: Alert
    seen: dict[AlertLevel, float]


class ActiveAlerts:
    """Keeps what was found until it has not been found for a while."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        self._entries: dict[str, _Entry] = {}
        self._log: list[Alert] = []
        self._sorted: tuple[Alert, ...] = ()

    @property
    def alerts(self) -> tuple[Alert, ...]:
        return self._sorted

    @property
    def log(self) -> tuple[Alert, ...]:
        return tuple(self._log)

    def update(self, time: float, findings: Iterable[Alert]) -> None:
        """Take in what was found until `time` (s); what was not found for long is over."""
        changed = False
        for found in findings:
            entry = self._entries.get(found.key)
            if entry is None or found.level > entry.danger.level:
                danger = replace(found, since=time)
                seen = {} if entry is None else entry.seen
                entry = self._entries[found.key] = _Entry(danger, seen)
                self._log.append(danger)
                changed = True
            entry.seen[found.level] = time
            if found.level < entry.danger.level and self._past(
                time, entry.seen[entry.danger.level]
            ):
                entry.danger = replace(found, since=entry.danger.since)
                changed = True
        over = [
            key
            for key, entry in self._entries.items()
            if self._past(time, max(entry.seen.values()))
        ]
        for key in over:
            del self._entries[key]
        if changed or over:
            self._sorted = tuple(
                sorted((entry.danger for entry in self._entries.values()), key=_order)
            )

    @staticmethod
    def _past(time: float, seen: float) -> bool:
        return time - seen > ALERTS.hold_time


def _order(danger: Alert) -> tuple[int, int, float, str]:
    kind = danger.key.partition(".")[0]
    place = _FIRST.index(kind) if kind in _FIRST else len(_FIRST)
    return -int(danger.level), place, danger.since, danger.key
