"""The cues of a flight being watched: fed with its samples, raised as alarms, kept as events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueEvent, CueSnapshot
from gsapp.flight.cards import CardSet
from gsapp.flight.events import Event
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import FlightError
from gsapp.quantities import Block, channel
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.failure_guard import FailureGuard
from gsapp.session.file_worker import FileWorker
from gsapp.session.flight_metadata import FlightMetadata
from gsapp.session.limits import Severity
from gsapp.session.marks import MarkStore
from gsapp.session.monitor_settings import MONITORS

if TYPE_CHECKING:
    from gsapp.excitation.cueing import CueGenerator
    from gsapp.excitation.debrief import Debrief

VERDICT_EVENT: Final = "verdict"
CARD_SELECTION_EVENT: Final = "card-choice"
_SEVERITY: Final = {"caution": Severity.CAUTION, "warning": Severity.WARNING}
_EQUIPMENT: Final = {
    "link": "telemetry lost",
    "recorder": "recorder trouble",
    "disk": "disk nearly full",
}
"""Alarms of the equipment that stand beside the dangers of flight, and how they are said."""


class CueMonitor:
    """Carries a session's samples to its cues, and what they say to the bar and the record.

    Dangers become alarms, so that the bar shows them, and trouble with the equipment stands among
    the dangers. Verdicts and the crew's choice of a card are written to the flight's events while
    it happens, once for all windows: the record then holds what the crew was told. A replay finds
    the verdicts in the samples again and writes nothing.

    Parameters
    ----------
    read : callable
        Takes in what all windows wrote to `mark_store`.

    Attributes
    ----------
    spoken : list of Announcement
        All that is to be heard so far; `reset` alone takes something away.
    """

    def __init__(
        self,
        cueing: CueGenerator,
        registry: AlarmRegistry,
        mark_store: MarkStore,
        read: Callable[[], None],
        *,
        live: bool,
    ) -> None:
        self.cueing = cueing
        self.spoken: list[Announcement] = []
        # A fault in a cue must stop neither charts nor alarms.
        self._guard = FailureGuard(
            "cues",
            "cues stopped",
            Severity.CAUTION,
            registry,
            lambda: cueing.snapshot().time,
        )
        self._registry = registry
        self._mark_store = mark_store
        self._read_events = read
        self._live = live
        self._chosen: set[tuple[float, str]] = set()
        self._equipment_alerts: tuple[Alert, ...] = ()
        self._event_count = self._spoken_count = 0

    # --- the consumer of a feed -----------------------------------------------------------------

    def feed(self, block: Block) -> None:
        self._guard.attempt(lambda: self.cueing.feed(block))

    def process_step(self) -> None:
        self._guard.attempt(lambda: self._run_step(self.cueing.process_step))

    def has_pending_work(self, time: float) -> bool:
        return bool(self._guard.attempt(lambda: self.cueing.has_pending_work(time)))

    def finish(self) -> None:
        """Judge the very last rows: nothing more comes."""
        self._guard.attempt(lambda: self._run_step(self.cueing.finish))

    def reset(self) -> None:
        self._guard.reset()
        self.cueing.reset()
        self.spoken.clear()
        self._event_count = self._spoken_count = 0

    # --- what it tells --------------------------------------------------------------------------

    def snapshot(self, uncalibrated: Sequence[str] = (), beyond: Sequence[str] = ()) -> CueSnapshot:
        """Return what is to be told now.

        Parameters
        ----------
        beyond : sequence of str
            Channels that read beyond what their instruments were calibrated for.
        """
        cues = self.cueing.snapshot()
        failure = self._guard.failure
        if failure:
            cues = replace(cues, trim=None, input_in_progress=None, guidance="")
        doubts = [failure] if failure else []
        if uncalibrated:
            doubts.append(f"not calibrated, ignored: {_titles(uncalibrated)}")
        if beyond:
            doubts.append(f"outside calibration, less certain: {_titles(beyond)}")
        dangers = sorted((*cues.alerts, *self._equipment_alerts), key=lambda one: -one.level)
        return replace(cues, alerts=tuple(dangers), limitations=(*doubts, *cues.limitations))

    def check_equipment(self) -> None:
        """Take note of trouble with link, recorder and disk, and say what is new."""
        known = {trouble.key for trouble in self._equipment_alerts}
        self._equipment_alerts = tuple(
            trouble for key in _EQUIPMENT if (trouble := self._equipment_alert(key)) is not None
        )
        cues = self.cueing.snapshot()
        for trouble in self._equipment_alerts:
            if trouble.key not in known:
                warning = trouble.level is AlertLevel.WARNING
                text = "" if cues.input_in_progress is not None else trouble.spoken_text
                self.spoken.append(
                    Announcement(
                        time=trouble.since if cues.time is None else cues.time,
                        text=text,
                        priority="warning" if warning else "prompt",
                        tone="warning" if warning else "caution",
                    )
                )

    def _equipment_alert(self, key: str) -> Alert | None:
        alarm = self._registry.get(key)
        if alarm is None or not alarm.active:
            return None
        warning = alarm.current is Severity.WARNING
        return Alert(
            key=key,
            level=AlertLevel.WARNING if warning else AlertLevel.CAUTION,
            since=alarm.time or 0.0,
            text=alarm.message,
            spoken_text=_EQUIPMENT[key],
        )

    # --- what the crew does ---------------------------------------------------------------------

    def select_card(self, card_id: str) -> None:
        """Let the crew's choice count from now on, and keep it with a live flight.

        Raises
        ------
        UnknownNameError
            If there is no such card.
        FlightError
            If the event cannot be written; the choice counts in this window.
        """
        time = self.cueing.select_card(card_id)
        self._chosen.add((time, card_id))
        if self._live:
            text = f"the crew flies card {card_id}" if card_id else "automatic card selection"
            self._mark_store.write(
                Event(kind=CARD_SELECTION_EVENT, text=text, time=time, data={"card": card_id})
            )

    def apply_event(self, event: Event) -> None:
        """Take in a choice that this or another window wrote."""
        card_id, time = event.data.get("card"), event.time
        if event.kind != CARD_SELECTION_EVENT or not isinstance(card_id, str) or time is None:
            return
        cards = self.cueing.cards
        known = not card_id or (cards is not None and cards.card(card_id) is not None)
        if known and (time, card_id) not in self._chosen:
            self._chosen.add((time, card_id))
            self.cueing.select_card(card_id, at=time)

    # --- what becomes of it ---------------------------------------------------------------------

    def _run_step(self, step: Callable[[], None]) -> None:
        """Do a step of the cues, and take up what they said in it."""
        step()
        events, spoken = self.cueing.log, self.cueing.announcements
        fresh, self._event_count = events[self._event_count :], len(events)
        self.spoken += spoken[self._spoken_count :]
        self._spoken_count = len(spoken)
        for event in fresh:
            if event.kind == "danger":
                self._alarm(event)
            elif event.kind == "verdict" and self._live:
                self._write(event)

    def _alarm(self, event: CueEvent) -> None:
        key = f"danger:{event.data['key']}"
        if event.state == "over":
            self._registry.clear(key, event.time)
        else:
            text = str(event.data["sentence"])
            self._registry.raise_(key, _SEVERITY[event.state], event.time, text)

    def _write(self, event: CueEvent) -> None:
        """Write a verdict that no window wrote before."""
        try:
            self._read_events()
        except FlightError:
            return  # as for a disk that refuses, below
        began = float(event.data["t_input"])
        for other in self._mark_store.other_events:
            known = other.data.get("t_input")
            same = isinstance(known, (int, float)) and abs(known - began) < MONITORS.same_input_time
            if other.kind == VERDICT_EVENT and same:
                return
        data = {**event.data, "result": event.state}
        try:
            self._mark_store.write(
                Event(kind=VERDICT_EVENT, text=event.text, time=event.time, data=data)
            )
        except FlightError:
            return  # a full disk: its own alarm says so, and the verdict stands on the page


def _titles(channels: Sequence[str]) -> str:
    return ", ".join(channel(name).title for name in channels)


class CrewCues:
    """Cues of a session; empty where the options switch them off."""

    def __init__(
        self,
        monitor: CueMonitor | None,
        metadata: FlightMetadata,
        folder: FlightFolder | None,
        worker: FileWorker | None,
    ) -> None:
        self._monitor = monitor
        self._metadata = metadata
        self._folder = folder
        self._worker = worker

    def snapshot(self) -> CueSnapshot | None:
        """Return what the crew is to be told now; None where cues are switched off."""
        if self._monitor is None:
            return None
        return self._monitor.snapshot(
            self._metadata.uncalibrated, self._metadata.out_of_calibrated_range
        )

    @property
    def spoken(self) -> Sequence[Announcement]:
        """Return all that is to be heard so far; it shrinks only when a replay goes back."""
        return () if self._monitor is None else self._monitor.spoken

    @property
    def cards(self) -> CardSet | None:
        return None if self._monitor is None else self._monitor.cueing.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far, and the score by card; None without cues."""
        if self._monitor is None:
            return None
        from gsapp.excitation.debrief import create_debrief

        return create_debrief(self._metadata.name, self._monitor.cueing)

    def select_card(self, card_id: str) -> None:
        """Let a test card be the next until it is flown; an empty id lets the program pick.

        A live flight keeps the choice among its events, so that a replay tells the same.

        Raises
        ------
        UnknownNameError
            If there is no such card.
        FlightError
            If it cannot be written.
        """
        if self._monitor is not None:
            self._monitor.select_card(card_id)

    def set_units(self, system: str) -> None:
        """Give cues in these units, ``US`` or ``SI``, from now on."""
        if self._monitor is not None:
            self._monitor.cueing.use_units(system)

    def set_cards(self, cards: CardSet) -> None:
        """Take other test cards; a live flight without any keeps them in its folder.

        Raises
        ------
        FlightError
            If they cannot be written; they count in this window.
        """
        if self._monitor is None:
            return
        self._monitor.cueing.use_cards(cards)
        folder = self._folder
        if folder is None:
            return

        def store() -> None:
            if not folder.cards_file.exists():
                folder.store_cards(cards)

        if self._worker is None:
            store()
        else:
            self._worker.run_job(store)
