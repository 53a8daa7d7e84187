"""Which card is to be flown now, what it asks for, and which verdicts count for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.model import Model
from gsapp.excitation.cues import CardSelectionReason, NextCard
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows, concatenate_rows
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.capture import TestPointCapture, guidance_text
from gsapp.excitation.test_points.point import (
    TargetInput,
    TestPoint,
    TestPointError,
    TrimCurve,
    create_point_at,
    create_test_point,
)
from gsapp.excitation.test_points.stick_text import format_sticks
from gsapp.excitation.test_points.target_selection import select_target_input
from gsapp.flight.cards import CardProgress, CardSet, CardSetProgress, TestCard, match_cards
from gsapp.flight.cards.card import STEP_COUNTS
from gsapp.flight.maneuvers import DetectedManeuver
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.quantities import SURFACE_NAMES, channel, from_si


def format_card(card: TestCard, system: str) -> str:
    """Return what is flown and where: "aileron and rudder doublet at 100 ft/s".

    Flap and throttle are named where the card asks for them.
    """
    spec = channel("V")
    unit = spec.display_unit(system)
    surfaces = " and ".join(SURFACE_NAMES[name] for name in card.surfaces)
    speed = from_si(card.speed, unit, spec.quantity)
    text = f"{surfaces} {card.kind} at {speed:.0f} {unit}"
    if card.flap:
        text += f", flap {from_si(card.flap, 'deg', 'angle'):.0f} deg"
    if card.throttle_step:
        text += f", then throttle {100.0 * card.throttle_step:+.0f} %"
    return text


def format_stick_input(stick: Mapping[str, str]) -> str:
    """Return how the sticks move: "half stick, then two thirds rudder, low rate"."""
    told = list(stick.values())
    tails = {text.partition(", ")[2] for text in told}
    if len(told) > 1 and len(tails) == 1 and (tail := tails.pop()):
        told = [text.partition(", ")[0] for text in told]
        return f"{', then '.join(told)}, {tail}"
    return ", then ".join(told)


def input_duration(wanted: TargetInput | None) -> float:
    """Return how long an input takes from GO to the end of its hands-off interval, s."""
    if wanted is None:
        return 0.0
    moving = STEP_COUNTS.get(wanted.kind, 1) * wanted.width.best * len(wanted.surfaces)
    return CUES.reaction_time + moving + wanted.hands_off


def maneuver_from_verdict(verdict: InputVerdict) -> DetectedManeuver:
    """Return what was judged as a maneuver that cards can be matched with.

    Only a good one is fit: cards ask for repeats that are worth having.
    """
    main = next(iter(verdict.amplitudes), None)
    return DetectedManeuver(
        id=verdict.id,
        t_start=verdict.t_start,
        t_end=verdict.t_end,
        inputs=verdict.surfaces,
        kind=verdict.kind,
        amplitude=None if main is None else verdict.amplitudes[main],
        grade="A" if verdict.result == "good" else "D",
        reasons=tuple(finding.words for finding in verdict.findings),
        V=verdict.V,
        alpha=verdict.alpha,
        t_input=verdict.t_input,
        t_input_end=verdict.t_input_end,
        amplitudes=verdict.amplitudes,
    )


def evaluate_cards(cards: CardSet, verdicts: Sequence[InputVerdict]) -> CardSetProgress:
    """Return how the cards stand after these verdicts."""
    return match_cards(cards, [maneuver_from_verdict(verdict) for verdict in verdicts])


def assign_card(verdict: InputVerdict, flown: CardSetProgress) -> InputVerdict:
    """Return a verdict with the card that it was flown for, and whether it counts."""
    for progress in flown.cards:
        for attempt in progress.attempts:
            if attempt.maneuver.id == verdict.id:
                return replace(verdict, card=progress.card.id, counts=attempt.is_counted)
    return replace(verdict, card="", counts=False)


class CardTargets:
    """Finds and remembers wants; the same question costs nothing the second time."""

    def __init__(self, aircraft: Aircraft | None, model: Model | None, system: str) -> None:
        self._aircraft = aircraft
        self._model = model
        self._system = system
        self.restart()

    def restart(self) -> None:
        self._density = SEA_LEVEL_DENSITY
        self._steady: list[tuple[float, float]] = []
        self._estimates: Mapping[str, LiveEstimate] = {}
        self._noise: Mapping[str, float] = {}
        self._forget()

    def _forget(self) -> None:
        self._curves: dict[float, TrimCurve] = {}  # of the day, by flap
        self._shifted: dict[float, TrimCurve] = {}  # those with alpha as it was measured
        self._points: dict[str, tuple[TestPoint | None, str]] = {}
        self._wanted: dict[tuple[object, ...], TargetInput] = {}

    def use_units(self, system: str) -> None:
        """Say what is wrong with a card in these units, ``US`` or ``SI``, from now on."""
        self._system = system
        self._points.clear()

    def set_density(self, density: float) -> None:
        """Take the air of the day, kg/m^3."""
        self._density = density
        self._forget()

    def set_noise(self, noise: Mapping[str, float]) -> None:
        """Take the noise of the day, by channel, SI: what an input must stand out of."""
        self._noise = noise
        self._wanted.clear()

    def set_estimates(self, estimates: Mapping[str, LiveEstimate]) -> None:
        self._estimates = estimates
        self._wanted.clear()

    def update_trim_alpha(self, verdict: InputVerdict) -> None:
        """Learn where the vane stands in trimmed flight, from an input that began in trim."""
        off = any(finding.result == "not-trimmed" for finding in verdict.findings)
        if verdict.V is None or verdict.alpha is None or off:
            return
        self._steady.append((verdict.V, verdict.alpha))
        self._shifted.clear()
        self._points.clear()

    def point(self, card: TestCard) -> tuple[TestPoint | None, str]:
        """Return the test point of a card; None, and why, where it cannot be flown."""
        found = self._points.get(card.id)
        if found is None:
            try:
                curve = self._curve(card.flap)
                found = create_test_point(card, curve, system=self._system), ""
            except TestPointError as error:
                found = None, f"card {card.id}: {error}"
            self._points[card.id] = found
        return found

    def target_input(self, card: TestCard) -> TargetInput:
        """Return what a card wants, within what the aircraft and its sensors allow."""
        found = self._wanted.get((card.id,))
        if found is None:
            found = self._wanted[(card.id,)] = select_target_input(
                card.surfaces,
                card.kind,
                aircraft=self._aircraft,
                model=self._model,
                point=self.point(card)[0],
                card=card,
                noise=self._noise,
                estimates=self._estimates,
            )
        return found

    def target_without_card(
        self, surfaces: tuple[str, ...], kind: str, V: float | None
    ) -> TargetInput:
        """Return what is wanted of an input that no card asks for, at an airspeed (m/s)."""
        near = None if V is None else round(V / CUES.same_speed)
        key = (surfaces, kind, near)
        found = self._wanted.get(key)
        if found is None:
            speed = None if near is None else near * CUES.same_speed
            found = self._wanted[key] = select_target_input(
                surfaces,
                kind,
                aircraft=self._aircraft,
                model=self._model,
                point=self.point_without_card(speed),
                noise=self._noise,
                estimates=self._estimates,
            )
        return found

    def point_without_card(self, speed: float | None) -> TestPoint | None:
        """Return level flight at an airspeed (m/s); None where there is none."""
        if speed is None:
            return None
        try:
            return create_point_at(speed=speed, curve=self._curve(0.0), system=self._system)
        except TestPointError:
            return None

    def _curve(self, flap: float) -> TrimCurve | None:
        if self._aircraft is None or self._model is None:
            return None
        if flap not in self._curves:
            made = TrimCurve(self._aircraft, self._model, rho=self._density, flap=flap)
            self._curves[flap] = made
        if flap not in self._shifted:
            self._shifted[flap] = self._curves[flap].with_measured_alpha(self._steady)
        return self._shifted[flap]


class CardSelector:
    """Keeps the cards of a flight, and picks the one to be flown now.

    The crew's choice comes first, then the card whose point the aircraft is holding, then the one
    that gains most, then the first on the list.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        model: Model | None,
        cards: CardSet | None,
        system: str = "US",
    ) -> None:
        self._aircraft = aircraft
        self._system = system
        self._points = CardTargets(aircraft, model, system)
        self._capture = TestPointCapture()
        self.cards = cards
        self.restart()

    def use_cards(self, cards: CardSet | None) -> None:
        """Take other cards; what was flown so far is to be told again."""
        self.cards = cards
        self.restart()

    def use_units(self, system: str) -> None:
        """Take other units for the words, ``US`` or ``SI``, from the next look on."""
        self._system = system
        self._changes += 1
        self._points.use_units(system)

    def restart(self) -> None:
        self.card_progress: CardSetProgress | None = None
        self.next_card: NextCard | None = None
        self._points.restart()
        self._capture.restart()
        self._waiting: list[FlightRows] = []
        self._air: list[float] = []
        self._aimed = False  # whether there is a point to be captured
        self._chosen = ""
        self._rate_switch: float | None = None
        self._settled: tuple[object, ...] = ()
        self._looked_at: tuple[object, ...] = (self,) * 5
        self._changes = 0
        self.update_progress(())

    # --- what happens ---------------------------------------------------------------------------

    def process_rows(self, rows: FlightRows) -> None:
        """Take in the rows of a tick; they are looked at twice a second of flight time."""
        if rows.starts_segment:
            self._waiting.clear()
        self._waiting.append(rows)
        if len(self._waiting) < CUES.selection_interval:
            return
        rows = concatenate_rows(self._waiting)
        self._waiting.clear()
        if self._aimed:
            self._capture.process_rows(rows)
        self._breathe(rows)
        switch = rows["rate_switch"]
        switch = switch[np.isfinite(switch)]
        if switch.size:
            self._rate_switch = float(switch[-1])

    def select_card(self, card_id: str) -> None:
        """Let the crew's choice count until that card is done; an empty one ends it."""
        self._chosen = card_id

    def update_progress(self, verdicts: Sequence[InputVerdict]) -> None:
        """Take in all verdicts given so far."""
        self._changes += 1
        if verdicts:
            self._points.update_trim_alpha(verdicts[-1])
        if self.cards is not None:
            self.card_progress = evaluate_cards(self.cards, verdicts)
            points = [self._points.point(one.card)[0] for one in self._open()]
            aims = [point for point in points if point is not None]
            self._aimed = bool(aims)
            self._capture.set_points(aims)

    def set_estimates(self, estimates: Mapping[str, LiveEstimate]) -> None:
        self._changes += 1
        self._points.set_estimates(estimates)

    def set_noise(self, noise: Mapping[str, float]) -> None:
        """Let wanted inputs follow from the noise of the day, by channel, SI."""
        self._changes += 1
        self._points.set_noise(noise)

    def _breathe(self, rows: FlightRows) -> None:
        if len(self._air) >= CUES.density_samples:
            return
        density = rows["density"]
        self._air += density[np.isfinite(density)].tolist()
        if len(self._air) >= CUES.density_samples:
            self._changes += 1
            self._points.set_density(float(np.mean(self._air)))

    # --- which card -----------------------------------------------------------------------------

    def update_selection(self, outlook: Outlook | None, *, stay: bool = False) -> bool:
        """Settle which card is to be flown; return whether that or what it asks for changed.

        While that is still being worked out (`stay`) the card stays unless it is done.
        """
        # By what follows nothing else can come out than last time, at nearly every tick.
        asked = (outlook, stay, self._chosen, self._capture.captured, self._changes)
        if all(one is other for one, other in zip(asked, self._looked_at, strict=True)):
            return False
        self._looked_at = asked
        card, why = self._stay() if stay else self._pick(outlook)
        settled = (card and card.id, why, self._changes)
        if settled == self._settled:
            return False
        self._settled = settled
        self.next_card = None if card is None else self._asked(card, why)
        return True

    def _stay(self) -> tuple[TestCard | None, CardSelectionReason]:
        now = self.next_card
        open_ids = {one.card.id for one in self._open()}
        if now is None or now.card.id not in open_ids or self._chosen in open_ids:
            return (None, "next on the list") if now is None else self._pick(None)
        return now.card, now.reason

    def _pick(self, outlook: Outlook | None) -> tuple[TestCard | None, CardSelectionReason]:
        open_ones = {one.card.id: one.card for one in self._open()}
        if self._chosen in open_ones:
            return open_ones[self._chosen], "chosen"
        self._chosen = ""
        flyable = [card for card in open_ones.values() if self._points.point(card)[0] is not None]
        preferred, why = self._preferred(flyable, outlook)
        held = self._held(flyable)
        if held and preferred not in held:
            # The best of those that can be flown where the aircraft is.
            best, _ = self._preferred(held, outlook)
            return best, "captured"
        if preferred is None and open_ones:
            return next(iter(open_ones.values())), "next on the list"
        return preferred, why

    def _held(self, cards: Sequence[TestCard]) -> list[TestCard]:
        captured = self._capture.captured
        point = None if self.cards is None or captured is None else self.cards.card(captured.card)
        if point is None:
            return []
        return [card for card in cards if abs(card.speed - point.speed) <= card.tolerance.speed]

    def _preferred(
        self, cards: Sequence[TestCard], outlook: Outlook | None
    ) -> tuple[TestCard | None, CardSelectionReason]:
        known = {card.id: card for card in cards}
        ranked = [] if outlook is None or outlook.best_forecast is None else list(outlook.forecasts)
        for prospect in ranked:
            if prospect.card in known:
                return known[prospect.card], "most to gain"
        return (cards[0] if cards else None), "next on the list"

    def _open(self) -> list[CardProgress]:
        return (
            []
            if self.card_progress is None
            else [one for one in self.card_progress.cards if one.remaining_count]
        )

    def _asked(self, card: TestCard, why: CardSelectionReason) -> NextCard:
        point, problem = self._points.point(card)
        wanted = self._points.target_input(card)
        best = {name: band.best for name, band in wanted.amplitudes.items()}
        stick = format_sticks(self._aircraft, best, rate_switch=self._rate_switch)
        progress = next((one for one in self._open() if one.card.id == card.id), None)
        return NextCard(
            card=card,
            good_repeats=0 if progress is None else progress.good_count,
            point=point,
            target_input=wanted,
            stick_text=stick,
            text=f"{format_card(card, self._system)}, {format_stick_input(stick)}",
            reason=why,
            problem=problem,
        )

    # --- what is wanted -------------------------------------------------------------------------

    def target_for(self, surfaces: Sequence[str], kind: str, V: float | None) -> TargetInput | None:
        """Return what is wanted of an input that was not expected, at an airspeed (m/s).

        An open card that asks for such an input there says so, else the model.
        """
        for one in self._open():
            card = one.card
            near = V is None or abs(V - card.speed) <= card.tolerance.speed
            if set(card.surfaces) == set(surfaces) and card.kind == kind and near:
                return self._points.target_input(card)
        return self._points.target_without_card(tuple(surfaces), kind, V)

    def target_of(self, verdict: InputVerdict) -> TargetInput | None:
        """Return what was wanted of an input that was judged."""
        card = None if self.cards is None else self.cards.card(verdict.card)
        if card is not None:
            return self._points.target_input(card)
        return self._points.target_without_card(verdict.surfaces, verdict.kind, verdict.V)

    def point_of(self, verdict: InputVerdict) -> TestPoint | None:
        """Return the test point of an input that was judged; None where no card asks for it."""
        card = None if self.cards is None else self.cards.card(verdict.card)
        return None if card is None else self._points.point(card)[0]

    def guidance_text(self, speed: float | None, alpha: float | None) -> str:
        """Return short advice towards the test point; empty where there is nothing to say."""
        point = None if self.next_card is None else self.next_card.point
        return guidance_text(point, speed=speed, alpha=alpha, system=self._system)
