"""What stands now, and since when: findings of successive frames become dangers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

from gsapp.excitation.dangers.danger import Danger, Urgency

HOLD: Final = 2.0
"""Seconds for which a danger stands after it was found last: nothing flickers."""

_FIRST: Final = (
    "stall", "nose", "airspeed", "alpha", "beta", "gyro", "motion", "fence", "clip",
    "battery", "fuel", "time", "radio",
)  # fmt: skip
"""Among equally urgent ones these come first, in this order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing found wrong in one frame; see `Danger`."""

    key: str
    urgency: Urgency
    words: str
    spoken: str
    channels: tuple[str, ...] = ()


@dataclass(slots=True)
class _Entry:
    danger: Danger
    seen: dict[Urgency, float]


class Standing:
    """Keeps what was found until it has not been found for a while."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._entries: dict[str, _Entry] = {}
        self._log: list[Danger] = []
        self._sorted: tuple[Danger, ...] = ()

    @property
    def now(self) -> tuple[Danger, ...]:
        """Return what stands, the most urgent first."""
        return self._sorted

    @property
    def log(self) -> tuple[Danger, ...]:
        """Return each danger as it arose or grew worse, in order of time."""
        return tuple(self._log)

    def note(self, time: float, findings: Iterable[Finding]) -> None:
        """Take in what was found until `time` (s); what was not found for long is over."""
        changed = False
        for found in findings:
            entry = self._entries.get(found.key)
            if entry is None or found.urgency > entry.danger.urgency:
                danger = Danger(
                    key=found.key,
                    urgency=found.urgency,
                    since=time,
                    words=found.words,
                    spoken=found.spoken,
                    channels=found.channels,
                )
                seen = {} if entry is None else entry.seen
                entry = self._entries[found.key] = _Entry(danger, seen)
                self._log.append(danger)
                changed = True
            entry.seen[found.urgency] = time
            if found.urgency < entry.danger.urgency and self._past(
                time, entry.seen[entry.danger.urgency]
            ):
                entry.danger = replace(
                    entry.danger,
                    urgency=found.urgency,
                    words=found.words,
                    spoken=found.spoken,
                    channels=found.channels,
                )
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
        return time - seen > HOLD


def _order(danger: Danger) -> tuple[int, int, float, str]:
    kind = danger.key.partition(".")[0]
    place = _FIRST.index(kind) if kind in _FIRST else len(_FIRST)
    return -int(danger.urgency), place, danger.since, danger.key
