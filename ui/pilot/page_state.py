"""What the page shows: cues, the card looked at, a verdict put away, calm. No Qt."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.test_points.point import TargetInput
from gsapp.flight.cards import CardSet, TestCard
from ui.display_limits import DISPLAY
from ui.pilot.cue_display import CueDisplay, Gauge
from ui.pilot.cue_display_builder import CueDisplayInput, build_cue_display

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief
    from gsapp.session import Session


class FlightCues:
    """What the pilot's page knows of the open flight.

    `session`: returns the flight; None where none is open.
    """

    def __init__(
        self, session: Callable[[], Session | None], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._get_session = session
        self._clock = clock
        self._seen: float | None = None
        self._data_clock = clock()

    @property
    def is_open(self) -> bool:
        return self._get_session() is not None

    def snapshot(self) -> CueSnapshot | None:
        """Return the cues; None without a flight, or where it gives none."""
        session = self._get_session()
        return None if session is None else session.cues

    def monitored_fraction(self) -> float:
        """Return how much of the flight so far the cues have seen, 0 to 1; else they are past."""
        session = self._get_session()
        return 1.0 if session is None else session.monitored_fraction

    def seconds_without_data(self) -> float | None:
        """Return for how many seconds nothing came of a live flight; None while it comes."""
        session = self._get_session()
        now, newest = self._clock(), None if session is None else session.now
        if newest != self._seen:
            self._seen, self._data_clock = newest, now
        live = session is not None and session.replay_feed is None
        passed = now - self._data_clock
        return passed if live and newest is not None and passed > DISPLAY.max_cue_age else None

    def spoken_cues(self) -> Sequence[Announcement]:
        session = self._get_session()
        return () if session is None else session.crew_cues.spoken

    @property
    def cards(self) -> CardSet | None:
        session = self._get_session()
        return None if session is None else session.crew_cues.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far; None without a flight, or where it gives no cues."""
        session = self._get_session()
        return None if session is None else session.crew_cues.debrief()

    def set_units(self, units: str) -> None:
        if (session := self._get_session()) is not None:
            session.crew_cues.set_units(units)

    def select_card(self, card_id: str) -> None:
        """Have a card flown until it is done; an empty one lets the program choose."""
        if (session := self._get_session()) is not None:
            session.crew_cues.select_card(card_id)


class CardBrowser:
    """The card that the crew is looking at, which need not be the one to be flown."""

    def __init__(self) -> None:
        self._id = ""

    def reset(self) -> None:
        self._id = ""

    def browsed_card(self, cards: CardSet | None) -> TestCard | None:
        return None if cards is None or not self._id else cards.card(self._id)

    def step(self, cards: CardSet | None, cues: CueSnapshot | None, steps: int) -> None:
        """Look at a card farther on, around the end; from that which is to be flown first."""
        if cards is None:
            return
        ids = [card.id for card in cards.cards]
        flown = cues.card.card.id if cues is not None and cues.card is not None else ""
        here = self._id or flown
        place = ids.index(here) + steps if here in ids else min(steps - 1, 0)
        self._id = ids[place % len(ids)]
        if self._id == flown:
            self._id = ""

    def selected_card_id(self, cues: CueSnapshot | None) -> str:
        if self._id:
            return self._id
        return cues.card.card.id if cues is not None and cues.card is not None else ""


def find_last_flown_card(cues: CueSnapshot | None, cards: CardSet | None) -> str:
    """Return the id of the card that the latest maneuver was flown for; empty for none."""
    flown = cues.verdict.card if cues is not None and cues.verdict is not None else ""
    return flown if cards is not None and cards.card(flown) is not None else ""


class DisplayRateLimiter:
    """Lets another state through at once, and the words beside it when they have stood.

    Bars move all the time; numbers and sentences do not.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._shown: CueDisplay | None = None
        self._changed = 0.0

    def reset(self) -> None:
        """Let everything through next time: the crew did something and looks for its answer."""
        self._shown = None

    def limit(self, sheet: CueDisplay) -> CueDisplay:
        shown, now = self._shown, self._clock()
        if (
            shown is None
            or _unlimited_part(sheet) != _unlimited_part(shown)
            or now - self._changed >= DISPLAY.min_text_time
        ):
            if shown is None or _text_part(sheet) != _text_part(shown):
                self._changed = now
            self._shown = sheet
        else:
            self._shown = replace(
                shown,
                ring=sheet.ring,
                count=sheet.count,
                gauges=tuple(map(_with_new_marker, shown.gauges, sheet.gauges)),
            )
        return self._shown


def _with_new_marker(shown: Gauge, new: Gauge) -> Gauge:
    return replace(shown, marker=new.marker)


def _unlimited_part(sheet: CueDisplay) -> tuple[object, ...]:
    """Return what is never held back: the state, what its gauges are of, a gauge that went."""
    return (sheet.status_text, sheet.sign, sheet.tone, tuple(one.title for one in sheet.gauges))


def _text_part(sheet: CueDisplay) -> tuple[object, ...]:
    """Return everything that is read, without what moves."""
    numbers = tuple((one.number, one.target_text) for one in sheet.gauges)
    return (sheet.status_text, sheet.hints, numbers, sheet.leg_time_text, sheet.card, sheet.footer)


class PilotPageState:
    """What the crew did to the page, and what follows from it."""

    def __init__(self, cues: FlightCues, clock: Callable[[], float] = time.monotonic) -> None:
        self._cues = cues
        self._clock = clock
        self._choosing = CardBrowser()
        self.snapshot: CueSnapshot | None = None
        self.restart()

    def restart(self) -> None:
        self._choosing.reset()
        self._dismissed = ""
        self._calm = DisplayRateLimiter(self._clock)
        self.snapshot = None

    def update(self) -> CueSnapshot | None:
        self.snapshot = self._cues.snapshot()
        return self.snapshot

    def build_display(self, units: str) -> CueDisplay:
        reading = CueDisplayInput(
            cues=self.snapshot,
            units=units,
            is_flight_open=self._cues.is_open,
            seconds_without_data=self._cues.seconds_without_data(),
            monitored_fraction=self._cues.monitored_fraction(),
            dismissed_verdict_id=self._dismissed,
            browsed_card=self._choosing.browsed_card(self._cues.cards),
            target_input=self._target_input(),
        )
        return self._calm.limit(build_cue_display(reading))

    def _target_input(self) -> TargetInput | None:
        standing = self.shown_verdict_id
        debrief = self._cues.debrief() if standing else None
        maneuvers = () if debrief is None else debrief.maneuvers
        return next((one.target_input for one in maneuvers if one.verdict.id == standing), None)

    # Cards

    @property
    def is_browsing(self) -> bool:
        return self._choosing.browsed_card(self._cues.cards) is not None

    def step_card(self, steps: int) -> None:
        self._calm.reset()
        self._choosing.step(self._cues.cards, self.update(), steps)

    def select_browsed_card(self) -> None:
        self._choose(self._choosing.selected_card_id(self.update()))

    def repeat_last_card(self) -> None:
        card = find_last_flown_card(self.update(), self._cues.cards)
        if card:
            self._choose(card)

    def clear_card_selection(self) -> None:
        self._choose("")

    def _choose(self, card_id: str) -> None:
        self._calm.reset()
        self._choosing.reset()
        self._cues.select_card(card_id)

    # The verdict

    @property
    def shown_verdict_id(self) -> str:
        verdict = None if self.snapshot is None else self.snapshot.fresh_verdict
        return verdict.id if verdict is not None and verdict.id != self._dismissed else ""

    def dismiss_verdict(self) -> None:
        """Put the verdict away; it stays in the debrief."""
        self.update()
        self._dismissed = self.shown_verdict_id or self._dismissed
