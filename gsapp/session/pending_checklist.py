"""The checklist before any flight is open: its ticks wait and go into the flight's events."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.flight.events import Event, EventLog
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import check_flight_info
from gsapp.foundation import UnknownNameError
from gsapp.session.checklist import Checklist, ChecklistContext, ChecklistFile, EvaluatedItem
from gsapp.session.checklist.session_checklist import RESTART_EVENT, TICK_EVENT, UNTICK_EVENT

_RESTARTED: Final = "checklist reset"


class PendingChecklist:
    """Goes through what hands and the flight card can tell; telemetry is still to come.

    Parameters
    ----------
    log : EventLog
        Where ticks are kept until there is a flight.
    card : callable
        Gives the card of the next flight as it stands.

    Attributes
    ----------
    system : {"US", "SI"}
        Units of the sentences.
    """

    def __init__(
        self,
        log: EventLog,
        file: ChecklistFile,
        *,
        card: Callable[[], FlightInfo | None],
        aircraft: Aircraft | None = None,
    ) -> None:
        self.checklist = Checklist(file)
        self.system = "US"
        self._log = log
        self._card = card
        self._aircraft = aircraft

    def update(self) -> tuple[EvaluatedItem, ...]:
        """Return how the items stand, red first."""
        self._apply_events()
        card = self._card()
        doubts = () if card is None else check_flight_info(card, self._aircraft, system=self.system)
        facts = ChecklistContext(
            card=card, card_issues=tuple(doubt.text for doubt in doubts), system=self.system
        )
        return self.checklist.evaluate(facts)

    def tick(self, item_id: str, who: str = "") -> None:
        """Say by hand that an item is done.

        Raises
        ------
        FlightError
            If it cannot be written.
        """
        self._write(TICK_EVENT, item_id, who)

    def untick(self, item_id: str) -> None:
        """Take a tick back; see `tick` for the errors."""
        self._write(UNTICK_EVENT, item_id, "")

    def restart(self) -> None:
        """Begin anew."""
        self._append(Event(kind=RESTART_EVENT, text=_RESTARTED))

    def _write(self, kind: str, item_id: str, who: str) -> None:
        words = next(
            (item.words for item in self.checklist.file.items if item.id == item_id), item_id
        )
        self._append(Event(kind=kind, text=words, data={"item": item_id, "who": who}))

    def _append(self, event: Event) -> None:
        with contextlib.suppress(OSError):
            # What hinders is said when the event is written.
            self._log.path.parent.mkdir(parents=True, exist_ok=True)
        self._log.append(event)
        self._apply_events()

    def _apply_events(self) -> None:
        """Take in what was ticked before, by this or another window."""
        for event in self._log.poll():
            name = str(event.data.get("item", ""))
            # A list that was edited since may lack the item.
            with contextlib.suppress(UnknownNameError):
                if event.kind == TICK_EVENT:
                    self.checklist.tick(name, str(event.data.get("who", "")))
                elif event.kind == UNTICK_EVENT:
                    self.checklist.untick(name)
                elif event.kind == RESTART_EVENT:
                    self.checklist.restart()
