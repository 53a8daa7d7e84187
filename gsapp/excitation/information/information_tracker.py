"""What the flight has learned, and what it should fly next."""

from __future__ import annotations

import time as clock
from collections import deque
from collections.abc import Mapping

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows, concatenate_rows
from gsapp.excitation.information.card_forecasts import (
    ForecastRequest,
    ForecastResult,
    ForecastSteps,
    UnfinishedCard,
    forecast_cards_stepwise,
)
from gsapp.excitation.information.flight_knowledge import (
    ESTIMATION_AXES,
    FlightKnowledge,
    KnowledgeUpdate,
    ManeuverData,
    learn_from_maneuver,
    learn_noise,
)
from gsapp.excitation.information.outlook import CardForecast, DerivativeBound, Outlook
from gsapp.excitation.information.remaining_time import RemainingTimeEstimator
from gsapp.excitation.settings import INFORMATION
from gsapp.flight.cards import CardSet, CardSetProgress, TestCard
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.ftr.estimates import LiveEstimate


class InitialSegmentCollector:
    """Waits for so many seconds of flight, and gives their rows once."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._parts: deque[FlightRows] = deque()
        self._given = False

    def process_rows(self, rows: FlightRows, took_off: float | None) -> FlightRows | None:
        """Take in the next rows; give the stretch as soon as all of it is there."""
        if self._given or not len(rows):
            return None
        if rows.starts_segment:
            self._parts.clear()
        self._parts.append(rows)
        newest = float(rows.times[-1])
        if took_off is None:
            while self._parts[0].times[-1] < newest - INFORMATION.ground_retention:
                self._parts.popleft()
            return None
        start = took_off + INFORMATION.climb_exclusion_time
        if newest < start + self._seconds:
            return None
        heard = concatenate_rows(self._parts)
        inside = np.flatnonzero((heard.times >= start) & (heard.times <= start + self._seconds))
        self._given = True
        self._parts.clear()
        return heard.slice_rows(int(inside[0]), int(inside[-1]) + 1) if inside.size > 1 else None


class InformationTracker:
    """Keeps the bounds reached in one flight, and looks ahead.

    What was flown is worked on in steps of some ten milliseconds: call `run_slice` between ticks.
    Without aircraft or model bounds cannot be told; time left may. What has reached the bound
    wanted, per radian, does not count any more.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        model: Model | None,
        rate: float = 100.0,
        *,
        wanted: Mapping[str, float] | None = None,
        longest: float = INFORMATION.default_flight_duration,
        system: str = "US",
    ) -> None:
        self._aircraft, self._model = aircraft, model
        self._rate = rate
        self._every = max(1, round(DETECTION.frame_duration * rate))
        self._wanted = dict(wanted or {})
        self._system = system
        self.remaining_time = RemainingTimeEstimator(aircraft, rate, longest=longest)
        self.restart()

    def restart(self) -> None:
        self.remaining_time.restart()
        self._held: list[FlightRows] = []
        self._lessons: deque[ManeuverData | FlightRows] = deque()
        self._first_air = InitialSegmentCollector(INFORMATION.first_noise_time)
        self._learning: KnowledgeUpdate | None = None
        self._answering: ForecastSteps | None = None
        self._estimates: Mapping[str, LiveEstimate] = {}
        self._knowledge: FlightKnowledge | None = None
        if self._aircraft is not None and self._model is not None:
            self._knowledge = FlightKnowledge(
                initial_model=self._model, rate=self._rate, mass=self._aircraft.mass.mass
            )
        self._cards: tuple[UnfinishedCard, ...] = ()
        self._stale = False
        self._due: float | None = None
        self._looked_at = 0.0
        self._reply = ForecastResult(by_card={})
        self._shown = self._reply
        self._bounds = self._bounds_now()
        self._remarks: tuple[str, ...] = ()

    def use_units(self, system: str) -> None:
        """Take other units for the words, ``US`` or ``SI``; what is shown is worded anew."""
        self._system = system
        if self._shown.by_card:
            self._ask(self._looked_at)

    # --- what comes in --------------------------------------------------------------------------

    def process_rows(self, rows: FlightRows) -> None:
        """Take in the next rows: they count time and fuel, and the first in the air the noise.

        Both are in no hurry: they are looked at twice a second.
        """
        if rows.starts_segment and self._held:
            self._count(concatenate_rows(self._held))
            self._held = []
        self._held.append(rows)
        end = rows.first_index + len(rows)
        if end % self._every == 0 or end - self._held[0].first_index >= self._every:
            held, self._held = concatenate_rows(self._held), []
            self._count(held)

    def _count(self, rows: FlightRows) -> None:
        self.remaining_time.process_rows(rows)
        heard = self._first_air.process_rows(rows, self.remaining_time.takeoff_time)
        if heard is not None and self._knowledge is not None:
            self._lessons.append(heard)
            self._ask(float(heard.times[-1]))

    def set_estimates(self, estimates: Mapping[str, LiveEstimate]) -> None:
        """Take note of what the flight's own FTR has earned; it counts from the next maneuver."""
        self._estimates = dict(estimates)

    def add_maneuver(
        self,
        verdict: InputVerdict,
        rows: FlightRows | None,
        card: TestCard | None = None,
    ) -> None:
        """Take in a maneuver, invalid ones bring nothing, and the card that it was flown for.

        The rows begin `INFORMATION.noise_time` before it, as far as there are.
        """
        self.remaining_time.add_maneuver(verdict.t_input)
        if rows is None or self._knowledge is None:
            return
        self._lessons.append(
            ManeuverData(
                verdict=verdict,
                rows=rows,
                card=card,
                mass=self.remaining_time.mass or self._knowledge.mass,
                ftr_estimates=self._estimates,
            )
        )
        self._ask(verdict.given_at)

    # --- work -----------------------------------------------------------------------------------

    def run_slice(self, budget_seconds: float) -> bool:
        """Work for about so long (s); return whether something is left to do."""
        until = clock.perf_counter() + budget_seconds
        while self._advance():
            if clock.perf_counter() >= until:
                return True
        return False

    def has_pending_work(self, time: float) -> bool:
        due = self._due is not None and time >= self._due
        begun = self._learning is not None or self._answering is not None
        return due and (begun or bool(self._lessons) or self._stale)

    def _ask(self, time: float) -> None:
        self._stale = True
        due = time + INFORMATION.forecast_delay
        self._due = due if self._due is None else min(self._due, due)

    def _advance(self) -> bool:
        """Do one step; return whether there is another one to do."""
        if self._learning is None and self._lessons:
            self._learning = self._begun(self._lessons.popleft())
        if self._learning is not None:
            try:
                next(self._learning)
            except StopIteration as done:
                self._knowledge, self._learning = done.value, None
                self._stale = True
            return True
        if self._stale:
            request = self._request()
            self._answering = None if request is None else forecast_cards_stepwise(request)
            self._stale = False
        if self._answering is None:
            return False
        try:
            next(self._answering)
        except StopIteration as done:
            self._reply, self._answering = done.value, None
        return True

    def _begun(self, lesson: ManeuverData | FlightRows) -> KnowledgeUpdate:
        assert self._knowledge is not None  # noqa: S101 - without it there are no lessons
        assert self._aircraft is not None  # noqa: S101
        if isinstance(lesson, FlightRows):
            return learn_noise(self._knowledge, lesson, self._aircraft)
        return learn_from_maneuver(self._knowledge, lesson, self._aircraft)

    def _request(self) -> ForecastRequest | None:
        knowledge, aircraft = self._knowledge, self._aircraft
        if knowledge is None or aircraft is None:
            return None
        return ForecastRequest(
            aircraft=aircraft,
            model=knowledge.updated_model(aircraft),
            cards=self._cards,
            totals=knowledge.totals,
            noise={axis: knowledge.noise(axis, aircraft) for axis in ESTIMATION_AXES},
            gusts=knowledge.gusts,
            pilot_errors=knowledge.pilot_errors,
            channels=knowledge.channels,
            rate=knowledge.rate,
            mass=knowledge.mass,
            density=knowledge.density,
            target_bounds=self._wanted,
            maneuver_interval=self.remaining_time.maneuver_interval,
            system=self._system,
        )

    # --- what it says ---------------------------------------------------------------------------

    def bounds(self) -> tuple[DerivativeBound, ...]:
        """Return every derivative with the bound reached, as last shown by `outlook`."""
        return self._bounds

    def outlook(self, time: float, cards: CardSetProgress | CardSet | None = None) -> Outlook:
        """Return what is known, and what comes next, at a flight time, cards as they stand."""
        self._looked_at = time
        missing = _unfinished_cards(cards)
        if missing != self._cards:
            self._cards = missing
            self._ask(time)
        if self._due is not None and time >= self._due:
            while self._advance():
                pass
            self._due = None
            self._show()
        left = self.remaining_time.maneuvers_left(time)
        prospects = self._fitting(left)
        worthwhile = bool(prospects) and prospects[0].score > 0.0
        return Outlook(
            time=time,
            bounds=self._bounds,
            best_forecast=prospects[0] if worthwhile else None,
            forecasts=prospects,
            time_left=self.remaining_time.time_left(time),
            maneuvers_left=left,
            remarks=(*self._remarks, *self.remaining_time.remarks),
        )

    def _fitting(self, left: int | None) -> tuple[CardForecast, ...]:
        if left == 0:
            return ()
        return tuple(
            repeats[min(len(repeats), left or len(repeats)) - 1]
            for repeats in self._shown.by_card.values()
        )

    def _show(self) -> None:
        self._shown = self._reply
        self._bounds = self._bounds_now()
        knowledge = self._knowledge
        learned = () if knowledge is None else knowledge.remarks
        self._remarks = (*self._shown.remarks, *learned)

    def _bounds_now(self) -> tuple[DerivativeBound, ...]:
        knowledge, aircraft = self._knowledge, self._aircraft
        if knowledge is None or aircraft is None:
            return ()
        model, found = knowledge.updated_model(aircraft), knowledge.estimates()
        return tuple(
            DerivativeBound(
                name=name,
                value=model.derivative(name),
                std=found[name][1] if name in found else None,
                target=self._wanted.get(name),
            )
            for name in axis_derivatives("both")
        )


def _unfinished_cards(cards: CardSetProgress | CardSet | None) -> tuple[UnfinishedCard, ...]:
    """Return the cards with repeats missing."""
    if cards is None:
        return ()
    if isinstance(cards, CardSet):
        return tuple(UnfinishedCard(card=card, missing=card.repeats) for card in cards.cards)
    return tuple(
        UnfinishedCard(card=one.card, missing=one.remaining_count)
        for one in cards.cards
        if one.remaining_count
    )
