"""The cues of the open flight: read for the page, and the crew's choice of a card."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from gsapp.flight.cards import CardSet
from ui.display_limits import DISPLAY
from ui.flight_controller import FlightController

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief


class FlightCues:
    """What the pilot's page knows of the open flight."""

    def __init__(
        self, controller: FlightController, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._controller = controller
        self._clock = clock
        self._seen: float | None = None
        self._data_clock = clock()

    @property
    def is_open(self) -> bool:
        return self._controller.is_open

    def snapshot(self) -> CueSnapshot | None:
        """Return the cues; None without a flight, or where it gives none."""
        session = self._controller.session
        return None if session is None else session.cues

    def monitored_fraction(self) -> float:
        """Return how much of the flight so far the cues have seen, 0 to 1; else they are past."""
        session = self._controller.session
        return 1.0 if session is None else session.monitored_fraction

    def seconds_without_data(self) -> float | None:
        """Return for how many seconds nothing came of a live flight; None while it comes."""
        now, newest = self._clock(), self._controller.time
        if newest != self._seen:
            self._seen, self._data_clock = newest, now
        live = self._controller.is_open and not self._controller.is_replay
        passed = now - self._data_clock
        return passed if live and newest is not None and passed > DISPLAY.max_cue_age else None

    def spoken_cues(self) -> Sequence[Announcement]:
        """Return what is to be heard, all of the flight so far."""
        session = self._controller.session
        return () if session is None else session.crew_cues.spoken

    @property
    def cards(self) -> CardSet | None:
        session = self._controller.session
        return None if session is None else session.crew_cues.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far; None without a flight, or where it gives no cues."""
        session = self._controller.session
        return None if session is None else session.crew_cues.debrief()

    def set_units(self, units: str) -> None:
        if self._controller.session is not None:
            self._controller.session.crew_cues.set_units(units)

    def select_card(self, card_id: str) -> None:
        """Have a card flown until it is done; an empty one lets the program choose."""
        if self._controller.session is not None:
            self._controller.session.crew_cues.select_card(card_id)
