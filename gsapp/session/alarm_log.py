"""What becomes of alarms in the flight's events file, which all windows of the flight share."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Final

from gsapp.flight.events import Event
from gsapp.foundation import FlightError
from gsapp.session.alarms import Alarm, AlarmBoard
from gsapp.session.marks import MarkBook

ACKNOWLEDGE: Final = "acknowledge"
ALARM: Final = "alarm"

_EQUIPMENT = ("link", "recorder", "disk", "clock", "folder")
_SAME_ALARM_US = 10_000_000


def alarm_events(board: AlarmBoard) -> tuple[Event, ...]:
    """Return every alarm so far as an event at its onset, with its end (s); units are SI."""
    return tuple(
        Event(
            kind=ALARM,
            text=one.sentence(),
            time=one.onset,
            data={
                "alarm": one.key,
                "severity": one.severity.name.lower(),
                "onset": one.onset,
                "end": one.end,
                "acknowledged": one.acknowledged,
            },
        )
        for one in board.episodes
    )


class AlarmLog:
    """Writes acknowledgments and alarms of the equipment, and takes in those of other windows.

    Alarms by limits are not written: every replay finds them in the samples again.

    Parameters
    ----------
    board : AlarmBoard
        The alarms.
    book : MarkBook
        The events file.
    wall_us : callable
        Host time, microseconds since 1970.
    others : callable, optional
        Told of every event that is none of its own.
    """

    def __init__(
        self,
        board: AlarmBoard,
        book: MarkBook,
        wall_us: Callable[[], int],
        others: Callable[[Event], None] = lambda _: None,
    ) -> None:
        self._board = board
        self._others = others
        self._book = book
        self._wall_us = wall_us
        self._logged = 0

    def read(self) -> None:
        """Take in what this and other windows wrote."""
        for event in self._book.poll():
            if event.kind == ACKNOWLEDGE:
                key, raised = event.data.get("alarm"), event.data.get("raised")
                moment = float(raised) if isinstance(raised, (int, float)) else None
                self._board.acknowledge(str(key), moment)
            else:
                self._others(event)

    def acknowledge(self, alarm: Alarm, now: float | None) -> None:
        """Take note of an alarm at flight time `now` (s).

        It is over for the crew even where the disk refuses to remember it.
        """
        self._board.acknowledge(alarm.key, alarm.time)
        self._write(
            Event(
                kind=ACKNOWLEDGE,
                text=alarm.sentence(),
                time=now,
                data={"alarm": alarm.key, "raised": alarm.time},
            )
        )

    def write_equipment(self) -> None:
        """Write alarms that no record of samples can tell again, once for all windows."""
        log = self._board.log_of(_EQUIPMENT)
        fresh, self._logged = log[self._logged :], len(log)
        if not fresh:
            return
        with contextlib.suppress(FlightError):
            self.read()
        stamp = self._wall_us()
        known = {
            event.data.get("alarm")
            for event in self._book.others
            if event.kind == ALARM and abs(event.host_time_us - stamp) < _SAME_ALARM_US
        }
        for onset in fresh:
            if onset.key not in known and not self._write(
                Event(
                    kind=ALARM,
                    text=onset.words,
                    time=onset.time,
                    data={"alarm": onset.key, "severity": onset.severity.name.lower()},
                )
            ):
                return  # a full disk: the alarm itself says so

    def _write(self, event: Event) -> bool:
        """Write an event; return False where the disk refuses."""
        try:
            self._book.write(event)
        except FlightError:
            return False
        return True
