"""The checklist of a session, or before any is open: its ticks and the start kept as events."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from gsapp.aircraft import Aircraft
from gsapp.flight.events import Event, EventLog
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import check_flight_info
from gsapp.foundation import GroundStationError, UnknownNameError
from gsapp.quantities import Block, convert_text_units
from gsapp.session.checklist.evaluation import (
    STATUS_ORDER,
    ChecklistContext,
    EvaluatedItem,
    RuleEvaluator,
)
from gsapp.session.checklist.items import ChecklistFile, ChecklistItem
from gsapp.session.checklist.rule_evaluators import create_evaluator
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.session import Session

TICK_EVENT: Final = "checklist-tick"
UNTICK_EVENT: Final = "checklist-untick"
RESTART_EVENT: Final = "checklist-restart"
FLIGHT_START_EVENT: Final = "flight-start"


class Checklist:
    """The state of one checklist."""

    def __init__(self, file: ChecklistFile) -> None:
        self.file = file
        self._items = {item.id: item for item in file.items}
        self.ticks: dict[str, str] = {}  # by whom; empty where nobody gave a name
        self._judges: dict[str, RuleEvaluator] = {}
        self.restart()

    @property
    def required_channels(self) -> tuple[str, ...]:
        """Return the channels whose samples the rules need."""
        names = (
            name
            for item in self.file.items
            if item.rule is not None
            for name in item.rule.required_channels
        )
        return tuple(dict.fromkeys(names))

    def restart(self) -> None:
        """Begin anew: no tick stands and no sample was seen."""
        self.ticks.clear()
        self._judges = {
            item.id: create_evaluator(item.rule)
            for item in self.file.items
            if item.rule is not None
        }

    def feed(self, block: Block) -> None:
        if len(block):
            for judge in self._judges.values():
                judge.feed(block)

    def tick(self, item_id: str, who: str = "") -> None:
        """Say by hand that an item is done.

        Raises
        ------
        UnknownNameError
            If there is no such item.
        """
        self.ticks[self._item(item_id).id] = who

    def untick(self, item_id: str) -> None:
        """Take a tick back.

        Raises
        ------
        UnknownNameError
            If there is no such item.
        """
        self.ticks.pop(self._item(item_id).id, None)

    def apply_event(self, event: Event) -> None:
        """Take in a tick that was written; a list that was edited since may lack the item."""
        name = str(event.data.get("item", ""))
        with contextlib.suppress(UnknownNameError):
            if event.kind == TICK_EVENT:
                self.tick(name, str(event.data.get("who", "")))
            elif event.kind == UNTICK_EVENT:
                self.untick(name)
        if event.kind == RESTART_EVENT:
            self.restart()

    def evaluate(self, facts: ChecklistContext) -> tuple[EvaluatedItem, ...]:
        """Return all items: red first, then amber, open, green; each in the order of the list."""
        found = [self._state(item, facts) for item in self.file.items]
        return tuple(sorted(found, key=lambda one: STATUS_ORDER.index(one.state)))

    def _item(self, item_id: str) -> ChecklistItem:
        try:
            return self._items[item_id]
        except KeyError:
            raise UnknownNameError(
                f"the checklist has no item '{item_id}'; it has {', '.join(self._items)}"
            ) from None

    def _state(self, item: ChecklistItem, facts: ChecklistContext) -> EvaluatedItem:
        tick = self.ticks.get(item.id)
        text = f"ticked by {tick}" if tick else "ticked"
        if item.rule is None:
            return EvaluatedItem(
                id=item.id,
                text=item.words,
                checked_by="hand",
                state="open" if tick is None else "green",
                why="tick when done" if tick is None else text,
                can_tick=True,
            )
        judgment = self._judges[item.id].evaluate(facts)
        why = convert_text_units(judgment.why, facts.system)
        by_hand = judgment.allows_manual_tick and tick is not None
        return EvaluatedItem(
            id=item.id,
            text=item.words,
            checked_by="hand" if by_hand else "telemetry",
            state="green" if by_hand else judgment.state,
            why=f"{text}; {why}" if by_hand else why,
            can_tick=judgment.allows_manual_tick,
        )


class SessionChecklist:
    """Goes through a checklist with a session.

    Several windows may: all follow the events of the flight. Once the flight was started what was
    seen of sticks, surfaces and engines stands; equipment is still looked at.

    Parameters
    ----------
    card : callable, optional
        Gives the flight card as it stands; by default it is read from the flight folder.
    """

    def __init__(
        self,
        session: Session,
        file: ChecklistFile,
        *,
        card: Callable[[], FlightInfo | None] | None = None,
        system: str = "US",
    ) -> None:
        self.session = session
        self.system = system
        self.checklist = Checklist(file)
        self._card = card or self._card_of_folder
        self._next: int | None = None
        self._read = 0
        self._start: Event | None = None

    @property
    def start_event(self) -> Event | None:
        """Return how the flight was started, by this or another window; None before."""
        return self._start

    def update(self) -> tuple[EvaluatedItem, ...]:
        """Take in what came, and return how the items stand; called a few times a second."""
        self._follow_events()
        self._take_in()
        return self.checklist.evaluate(self.context())

    def context(self) -> ChecklistContext:
        """Return what the rules go by now, beside the samples."""
        session = self.session
        card = self._card()
        carried = [
            name
            for name in self.checklist.required_channels
            if name in session.sources or session.history.has(name)
        ]
        return ChecklistContext(
            snapshot=session.snapshot(),
            states=session.states(carried),
            card=card,
            system=self.system,
            calibration=session.calibration_in_force,
            card_issues=()
            if card is None
            else tuple(
                doubt.text
                for doubt in check_flight_info(card, session.aircraft, system=self.system)
            ),
        )

    def tick(self, item_id: str, who: str = "") -> None:
        """Say by hand that an item is done, and keep it with the flight.

        Raises
        ------
        UnknownNameError
            If there is no such item.
        FlightError
            If the event cannot be written.
        """
        self.checklist.tick(item_id, who)
        self._write(TICK_EVENT, self._item_text(item_id), {"item": item_id, "who": who})

    def untick(self, item_id: str) -> None:
        """Take a tick back; see `tick` for the errors."""
        self.checklist.untick(item_id)
        self._write(UNTICK_EVENT, self._item_text(item_id), {"item": item_id})

    def restart(self) -> None:
        """Begin anew, for the next flight of the day with the same recorder."""
        self._write(RESTART_EVENT, "checklist reset", {})
        self._follow_events()

    def start(self, who: str = "") -> Event:
        """Record that the flight is started, and with what not green.

        Returns
        -------
        Event
            Its text says it in words; `data` lists what was red, amber and open.

        Raises
        ------
        FlightError
            If the event cannot be written.
        """
        # What is recorded is what holds now, not at the last look.
        while self._take_in():
            pass
        items = self.update()
        lists = {
            state: [item.id for item in items if item.state == state]
            for state in ("red", "amber", "open", "green")
        }
        unsettled = [item for item in items if item.state != "green"]
        text = "flight started, checklist all green"
        if unsettled:
            text = "flight started with open items: " + "; ".join(
                f"{item.text} ({item.state}: {item.why})" for item in unsettled
            )
        event = self._write(FLIGHT_START_EVENT, text, {"who": who, **lists})
        self._start = event
        return event

    # Inside

    def _card_of_folder(self) -> FlightInfo | None:
        path = self.session.path
        if not path.is_dir():
            return None
        try:
            return FlightFolder(path=path).info()
        except GroundStationError:
            # Its mistakes are told where the card is shown.
            return None

    def _item_text(self, item_id: str) -> str:
        return next(item.words for item in self.checklist.file.items if item.id == item_id)

    def _write(self, kind: str, text: str, data: Mapping[str, Any]) -> Event:
        event = Event(kind=kind, text=text, time=self.session.now, data=data)
        self.session.mark_store.write(event)
        return event

    def _follow_events(self) -> None:
        """Take in what this and other windows, or the same one before a restart, have said."""
        self.session.mark_store.poll()
        others = self.session.mark_store.other_events
        fresh, self._read = others[self._read :], len(others)
        for event in fresh:
            self.checklist.apply_event(event)
            if event.kind == FLIGHT_START_EVENT:
                self._start = event
            elif event.kind == RESTART_EVENT:
                self._next = None if event.time is None else self._index(event.time)
                self._start = None

    def _take_in(self) -> bool:
        """Feed the rules with samples that came since; return whether there were any."""
        history = self.session.history
        end = history.end
        if end is None:
            return False
        names = [name for name in self.checklist.required_channels if history.has(name)]
        stop = self._index(end - MONITORS.sample_delay)
        if self._start is not None and self._start.time is not None:
            stop = min(stop, self._index(self._start.time))
        if self._next is None:
            self._next = self._first(names, stop)
        last = min(stop, self._next + self._index(MONITORS.max_samples_time))
        if not names or last <= self._next:
            return False
        self.checklist.feed(history.rows(self._next, last, names))
        self._next = last
        return True

    def _first(self, names: Sequence[str], stop: int) -> int:
        spans = [self.session.history.span(name) for name in names]
        return min((span[0] for span in spans if span is not None), default=stop)

    def _index(self, time: float) -> int:
        return self.session.history.index(time)


class PendingChecklist:
    """Goes through what hands and the flight card can tell; telemetry is still to come.

    Parameters
    ----------
    card : callable
        Gives the card of the next flight as it stands.
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
        self._append(Event(kind=RESTART_EVENT, text="checklist reset"))

    def _write(self, kind: str, item_id: str, who: str) -> None:
        text = next(
            (item.words for item in self.checklist.file.items if item.id == item_id), item_id
        )
        self._append(Event(kind=kind, text=text, data={"item": item_id, "who": who}))

    def _append(self, event: Event) -> None:
        with contextlib.suppress(OSError):
            # What hinders is said when the event is written.
            self._log.path.parent.mkdir(parents=True, exist_ok=True)
        self._log.append(event)
        self._apply_events()

    def _apply_events(self) -> None:
        """Take in what was ticked before, by this or another window."""
        for event in self._log.poll():
            self.checklist.apply_event(event)
