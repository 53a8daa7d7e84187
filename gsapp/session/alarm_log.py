"""The log of a flight's alarms, the same in all its windows and in its replay."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from gsapp.flight.events import Event
from gsapp.foundation import FlightError
from gsapp.session.alarms import Alarm, AlarmEpisode, AlarmRegistry, order_by_time
from gsapp.session.limits import Severity
from gsapp.session.marks import MarkStore
from gsapp.session.monitor_settings import MONITORS

ACKNOWLEDGE: Final = "acknowledge"
ALARM: Final = "alarm"
ALARM_ENDED: Final = "alarm-ended"

_EQUIPMENT = ("link", "recorder", "disk", "clock", "folder", "aircraft")


def alarm_events(registry: AlarmRegistry) -> tuple[Event, ...]:
    """Return every alarm so far as an event at its onset, with its end (s); units are SI."""
    return tuple(
        Event(
            kind=ALARM,
            text=one.message_text(),
            time=one.onset,
            data={
                "alarm": one.key,
                "severity": one.severity.name.lower(),
                "onset": one.onset,
                "end": one.end,
                "value": one.value,
                "limit": one.limit,
                "acknowledged": one.acknowledged,
                "acknowledged_by": None if one.acknowledgment is None else one.acknowledgment.by,
            },
        )
        for one in registry.episodes
    )


class AlarmLog:
    """All alarms of a flight: computed from the samples, or read from the events file.

    Alarms by limits are not written: every replay finds them in the samples again. Alarms of the
    equipment, which no sample tells, and all acknowledgments are written, once for all windows.

    Parameters
    ----------
    ahead : AlarmRegistry, optional
        In a replay, the alarms of the whole flight.
    """

    def __init__(
        self,
        registry: AlarmRegistry,
        mark_store: MarkStore,
        wall_us: Callable[[], int],
        others: Callable[[Event], None] = lambda _: None,
        ahead: AlarmRegistry | None = None,
    ) -> None:
        self._registry = registry
        self._registries = (registry,) if ahead is None else (registry, ahead)
        self._others = others
        self._mark_store = mark_store
        self._wall_us = wall_us
        self._read = 0  # events of the store
        self._logged = 0  # onsets of the registry
        self._active: set[str] = set()  # equipment, at the last look
        self._recorded: list[AlarmEpisode] = []
        self._active_indices: dict[str, int] = {}  # index in the list of recorded ones, by key

    @property
    def revision(self) -> int:
        """Return a number that changes whenever `episodes` does."""
        return sum(registry.revision for registry in self._registries) + self._read + self._logged

    @property
    def episodes(self) -> tuple[AlarmEpisode, ...]:
        """Return every alarm of the flight by onset; those without a flight time first.

        In a replay that is the whole flight, whatever the playhead.
        """
        found = {
            (one.key, one.onset): one
            for registry in self._registries
            for one in registry.episodes
            if one.key not in _EQUIPMENT
        }
        recorded = (
            replace(
                one,
                acknowledgment=self._registry.acknowledgment(one.key, one.raised),
                is_over=one.is_over or self._registry.severity(one.key) is Severity.NORMAL,
            )
            for one in self._recorded
        )
        every = (*found.values(), *recorded)
        return tuple(sorted(every, key=lambda one: order_by_time(one.onset, one.key)))

    def read(self, *, refreshed: bool = False) -> None:
        """Take in what this and other windows wrote.

        Parameters
        ----------
        refreshed : bool
            Whether what others wrote in this moment counts, too.
        """
        if refreshed:
            self._mark_store.refresh()
        self._mark_store.poll()
        # From the store's own list: whoever makes a mark takes in events, too.
        events = self._mark_store.other_events
        fresh, self._read = events[self._read :], len(events)
        for event in fresh:
            if event.kind == ACKNOWLEDGE:
                self._apply_acknowledgment(event)
            else:
                if event.kind in (ALARM, ALARM_ENDED):
                    self._apply_equipment_alarm(event)
                self._others(event)

    def acknowledge(self, alarm: Alarm, now: float | None, by: str = "crew") -> None:
        """Take note of an alarm at flight time `now` (s).

        It is over for the crew even where the disk refuses to remember it.
        """
        for registry in self._registries:
            registry.acknowledge(alarm.key, alarm.time, by, now)
        self._write(
            Event(
                kind=ACKNOWLEDGE,
                text=alarm.message_text(),
                time=now,
                data={"alarm": alarm.key, "raised": alarm.time, "by": by},
            )
        )

    def acknowledge_next(self, key: str | None, now: float | None, by: str) -> bool:
        """Take note of an alarm, by default of the newest that waits; return if there was one."""
        waiting = self._registry.unacknowledged
        alarm = next(iter(waiting), None) if key is None else self._registry.get(key)
        if alarm is None or alarm.acknowledged:
            return False
        self.acknowledge(alarm, now, by)
        return True

    def write_equipment(self, now: float | None) -> None:
        """Write alarms that no record of samples can tell again, once for all windows.

        Parameters
        ----------
        now : float or None
            Flight time, s: when those ended that are over since the last call.
        """
        log = self._registry.onsets_of(_EQUIPMENT)
        fresh, self._logged = log[self._logged :], len(log)
        active = {key for key in _EQUIPMENT if self._registry.severity(key) > Severity.NORMAL}
        # What came and went within one look is over, too.
        over = ({onset.key for onset in fresh} | self._active) - active
        self._active = active
        if not fresh and not over:
            return
        with contextlib.suppress(FlightError):
            self.read(refreshed=True)
        for onset in fresh:
            data = {"alarm": onset.key, "severity": onset.severity.name.lower()}
            self._write_once(Event(kind=ALARM, text=onset.message, time=onset.time, data=data))
        for key in sorted(over):
            self._write_once(Event(kind=ALARM_ENDED, time=now, data={"alarm": key}))

    def _write_once(self, event: Event) -> None:
        """Write an event about the equipment that no window wrote before."""
        stamp = self._wall_us()
        key = event.data["alarm"]
        known = any(
            other.kind == event.kind
            and other.data.get("alarm") == key
            and abs(other.host_time_us - stamp) < 1e6 * MONITORS.same_alarm_time
            for other in self._mark_store.other_events
        )
        if not known and not self._write(event):
            self._apply_equipment_alarm(event)  # a full disk: the alarm itself says so

    def _apply_equipment_alarm(self, event: Event) -> None:
        """Take in that an alarm of the equipment was raised, grew worse or ended."""
        key = event.data.get("alarm")
        if not isinstance(key, str):
            return
        place = self._active_indices.get(key)
        if event.kind == ALARM_ENDED:
            if place is not None:
                self._recorded[place] = replace(self._recorded[place], end=event.time, is_over=True)
                del self._active_indices[key]
            return
        warning = event.data.get("severity") == Severity.WARNING.name.lower()
        severity = Severity.WARNING if warning else Severity.CAUTION
        if place is not None and severity > self._recorded[place].severity:
            self._recorded[place] = replace(
                self._recorded[place], severity=severity, message=event.text, raised=event.time
            )
            return
        if place is not None:
            # Nobody saw it end: no window was open.
            self._recorded[place] = replace(self._recorded[place], is_over=True)
        self._active_indices[key] = len(self._recorded)
        self._recorded.append(
            AlarmEpisode(
                key=key, severity=severity, onset=event.time, message=event.text, raised=event.time
            )
        )

    def _apply_acknowledgment(self, event: Event) -> None:
        key, raised, by = (event.data.get(name) for name in ("alarm", "raised", "by"))
        if not isinstance(key, str):
            return
        moments = [float(raised) if isinstance(raised, (int, float)) else None]
        if key in _EQUIPMENT:
            # Each window notices trouble with the equipment at a time of its own.
            alarm = self._registry.get(key)
            seen = [one.raised for one in self._recorded if one.key == key]
            moments += [
                time
                for time in (*seen, None if alarm is None else alarm.time)
                if _is_close_in_time(time, moments[0])
            ]
        for registry in self._registries:
            for moment in moments:
                registry.acknowledge(key, moment, by if isinstance(by, str) else "", event.time)

    def _write(self, event: Event) -> bool:
        """Write an event; return False where the disk refuses."""
        try:
            self._mark_store.write(event)
        except FlightError:
            return False
        return True


def _is_close_in_time(one: float | None, other: float | None) -> bool:
    return one is not None and other is not None and abs(one - other) < MONITORS.same_alarm_time
