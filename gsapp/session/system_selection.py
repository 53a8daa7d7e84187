"""Which system of a link the crew has chosen to be the flown one."""

from __future__ import annotations

import math
from collections.abc import Callable

from gsapp.decoding.decoder import Decoder
from gsapp.flight.events import Event, event_system, vehicle_event
from gsapp.session.marks import MarkStore


class SystemSelection:
    """The flown system: that of the flight's settings, or what the crew chose in any window."""

    def __init__(self, system: int | None, decoder: Callable[[], Decoder | None]) -> None:
        self._initial = self._chosen = system
        self._decoder = decoder

    @property
    def pending(self) -> int | None:
        """Return the system that the crew has chosen since this session began.

        None where it has not, or chose the one that is decoded: else the flight is to be opened
        again, since all of it is read for the system chosen.
        """
        decoder = self._decoder()
        decoded = self._initial if decoder is None else decoder.system
        return None if self._chosen == decoded else self._chosen

    def select(self, system: int, marks: MarkStore) -> None:
        """Make a system the flown one, of the whole flight, for all windows and replays."""
        decoder, time, stamp = self._decoder(), None, 0
        if decoder is not None and decoder.system not in (None, system):
            stamp = decoder.health.last_stamp or 0
            time = decoder.flight_time_at(stamp)
        marks.write(vehicle_event(system, time=time, stamp_us=stamp))

    def apply_event(self, event: Event) -> None:
        """Take in a choice that this or another window wrote."""
        chosen = event_system(event)
        if chosen is not None:
            self._chosen = chosen
            decoder = self._decoder()
            if decoder is not None and decoder.system == chosen:
                decoder.health.chosen = True  # which of several was in question

    def time_of(self, choice: Event, stamp_us: int) -> float | None:
        """Return the time by the clock of the system chosen; see `MarkStore`."""
        decoder = self._decoder()
        if decoder is None or (decoder.health.last_stamp or 0) < stamp_us:
            return None
        time = decoder.flight_time_at(stamp_us)
        return time if decoder.system == event_system(choice) and time is not None else math.nan
