"""Which maneuver decides: cards that tell rival effects apart, or make effects show at all.

Rival effects that explain the flights so far have the sizes with which they do. A card is
simulated and seen through the filter of the fit, with its noise and gusts: free parameters, zero
errors, initial states and the rival's own size take what they can, with what the flights so far
say of them. What is left of an effect, in standard deviations, is the separation that the card
brings (T-optimal design: A. C. Atkinson, V. V. Fedorov, The design of experiments for
discriminating between two rival models, Biometrika 62, 1975).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.discrepancy.effect_selection import CandidateScreening, candidate_columns
from gsapp.discrepancy.held_out_maneuvers import is_held_out
from gsapp.discrepancy.results import DecidingExperiment, DiscrepancyVerdict
from gsapp.discrepancy.search_stages import SearchStage
from gsapp.discrepancy.settings import SEARCH
from gsapp.excitation.information.planned_maneuver import CardExecution, simulate_maneuver
from gsapp.excitation.test_points.perturbation_models import (
    PerturbationModels,
    linearize_level_flight,
)
from gsapp.excitation.test_points.point import TrimCurve, create_point_at
from gsapp.excitation.test_points.target_selection import select_target_input
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card import CardInputKind, CardSurface
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.filter_error_fit import (
    BIAS_PREFIX,
    FilterErrorFit,
    InformationMatrix,
)
from gsapp.identification.filter_error.maneuver_state import SensitivityColumn
from gsapp.identification.filter_error.motion_linearization import (
    Linearization,
    create_maneuver_record,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY
from gsapp.virtual.flight_plan import INPUT_SHAPES

_SURFACES: Final[tuple[CardSurface, ...]] = ("de", "da", "dr")

Separation = Callable[[InformationMatrix], float]
"""Standard deviations that the information of all maneuvers, flown and planned, shows."""


def design_experiment(
    stages: Sequence[SearchStage],
    verdict: DiscrepancyVerdict,
    maneuvers: Sequence[Maneuver],
    fit_with: Callable[[FilterErrorFit, CandidateEffect, CandidateScreening], FilterErrorFit],
) -> DecidingExperiment | None:
    """Return what to fly after a search; None where nothing is open, or no maneuver helps.

    `fit_with` returns a fit with a candidate of its screening added.
    """
    last = stages[-1]
    open_ = next((one for one in stages if one.equivalent_effects), None)
    try:
        if verdict == "not-observable":
            effects = [one for one in last.screening.candidates if one.named]
            return design_visibility(_linearized(last.fit), effects, maneuvers)
        if last.decision.kind == "ambiguous":
            own, *rivals = _rivals(last)
            fit = fit_with(last.fit, own, last.screening)
            gains = [last.gain_of(one.id) for one in (own, *rivals)]
            return design_separation(_linearized(fit), own, rivals, gains, maneuvers)
        if open_ is not None:
            before = stages[stages.index(open_) - 1]
            names = sorted(open_.equivalent_effects, key=lambda name: name != open_.added)
            candidates = before.screening.candidates
            own, *rivals = (candidates[before.screening.index(name)] for name in names)
            gains = [before.gain_of(name) for name in names]
            return design_separation(_linearized(last.fit), own, rivals, gains, maneuvers)
    except FlightError:
        pass  # With a model that cannot be flown nothing is designed; the answer stands.
    return None


def _linearized(fit: FilterErrorFit) -> FilterErrorFit:
    if not fit.is_linearized:
        fit.linearize()
    return fit


def _rivals(stage: SearchStage) -> tuple[CandidateEffect, ...]:
    """Return the effects between which an ambiguous stage cannot decide, the likeliest first."""
    competitors, decision = stage.screening.candidates, stage.decision
    if len(decision.alternatives) > 1:
        return decision.alternatives
    # Its input did not move: it is told from the likeliest whose input did.
    order = np.argsort(-decision.gain)
    moved = [competitors[int(k)] for k in order if competitors[int(k)].excited]
    return (*decision.alternatives, *[one for one in moved if one.named][:1])


def design_separation(
    fit: FilterErrorFit,
    own: CandidateEffect,
    rivals: Sequence[CandidateEffect],
    gains: Sequence[float],
    maneuvers: Sequence[Maneuver],
) -> DecidingExperiment | None:
    """Return the experiment that decides between an effect and its rivals; None if none helps.

    Parameters
    ----------
    fit : FilterErrorFit
        Linearized; it has the effect as a free parameter and its rivals not at all.
    own, rivals : CandidateEffect
    gains : sequence of float
        Of the effect and its rivals so far, in the sum of squares.
    maneuvers : sequence of Maneuver
        All that were flown, those kept out among them.
    """
    parameter = f"{own.id}.{own.parameter}"
    if parameter not in fit.free or not rivals:
        return None
    effects = (own, *rivals)
    names = (parameter, *(one.id for one in rivals))
    nuisance = tuple(name for name in fit.free if name != parameter)
    design = _Design(fit, rivals, maneuvers)

    def shown(information: InformationMatrix) -> FloatArray:
        left = information.projected((*nuisance, *_biases(information)))
        places = left.indices(names)
        return left.matrix[np.ix_(places, places)]

    P = shown(design.past)
    # The sizes at which rivals explain what the effect does.
    share = P[0] / np.maximum(P.diagonal(), np.finfo(float).tiny)
    sizes = share * (fit.values[parameter] - own.neutral)
    weights = np.array([[_pair_weight(one, other) for other in effects] for one in effects])
    # Of what should have told them apart so far, what did counts.
    ahead = np.subtract.outer(gains, gains) - separations(P, sizes) ** 2

    def separation(information: InformationMatrix) -> float:
        expected = weights * (separations(shown(information), sizes) ** 2 + ahead)
        return float(np.sqrt(max(expected[weights > 0.0].min(), 0.0)))

    return design.run(
        separation,
        lambda _: DecidingExperiment(
            purpose="separate",
            effects=tuple(one.id for one in effects),
            titles=tuple(one.title for one in effects),
        ),
    )


def _pair_weight(one: CandidateEffect, other: CandidateEffect) -> float:
    """Return how much of a difference in gain counts; none that need not be told apart."""
    if one is other or not (one.named or other.named):
        return 0.0
    signal, _, kind = one.id.rpartition(".")
    other_signal, _, other_kind = other.id.rpartition(".")
    if signal == other_signal and {kind, other_kind} == {"lag", "delay"}:
        # Full fits of them differ by no more of what columns promise than the search lets count.
        return SEARCH.lag_delay_factor**2
    return 1.0


def separations(P: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return by how much each effect shows beside each other one, shape (n, n), in deviations.

    Parameters
    ----------
    P : ndarray, shape (n, n)
        Information on the effects' sizes, nuisance parameters projected out.
    sizes : ndarray, shape (n,)
        Of the effects, from neutral.
    """
    known = np.maximum(P.diagonal(), np.finfo(float).tiny)
    left = np.maximum(known[:, None] - P**2 / known, 0.0)
    return np.abs(sizes[:, None]) * np.sqrt(left)


def design_visibility(
    fit: FilterErrorFit, effects: Sequence[CandidateEffect], maneuvers: Sequence[Maneuver]
) -> DecidingExperiment | None:
    """Return the experiment in which most effects show at their usual size; None if none helps.

    As many as make a model adequate are enough. The fit, linearized, has none of them.
    """
    design = _Design(fit, effects, maneuvers)
    count = max(1, math.ceil(SEARCH.min_observable_share * len(effects)))

    def sigmas(information: InformationMatrix) -> FloatArray:
        left = information.projected((*fit.free, *_biases(information)))
        known = left.matrix.diagonal()[left.indices(one.id for one in effects)]
        return np.sqrt(np.maximum(known, 0.0)) * [abs(one.plausible_size) for one in effects]

    def describe(information: InformationMatrix) -> DecidingExperiment:
        chosen = [effects[int(k)] for k in np.argsort(-sigmas(information))[:count]]
        return DecidingExperiment(
            purpose="show",
            effects=tuple(one.id for one in chosen),
            titles=tuple(one.title for one in chosen),
        )

    return design.run(lambda information: float(np.sort(sigmas(information))[-count]), describe)


def _biases(information: InformationMatrix) -> tuple[str, ...]:
    return tuple(name for name in information.names if name.startswith(BIAS_PREFIX))


class _Design:
    """Cards, what each of them says, and the search among them."""

    def __init__(
        self,
        fit: FilterErrorFit,
        columns: Sequence[CandidateEffect],
        maneuvers: Sequence[Maneuver],
    ) -> None:
        self._fit = fit
        self._names = tuple(one.id for one in columns)
        self._columns = columns
        self._planner = _CardPlanner(fit, maneuvers)
        self._flown = Counter(one.inputs for one in maneuvers)
        self._informations: dict[TestCard, InformationMatrix | None] = {}
        self._priors: dict[str, tuple[float, float]] = {}
        extra = self._names, self._build_columns
        parts = (fit.information_of(one, extra) for one in fit.maneuvers)
        self.past = fit.sum_information(parts, self._names).with_priors(fit.priors())

    def _build_columns(self, found: Linearization) -> list[SensitivityColumn]:
        return candidate_columns(self._columns, found)

    def run(
        self, separation: Separation, describe: Callable[[InformationMatrix], DecidingExperiment]
    ) -> DecidingExperiment | None:
        """Return the smallest experiment with enough separation, else the best; None if none."""
        now = separation(self.past)
        cards = self._usable(self._planner.first_cards())
        cards.sort(key=lambda card: -separation(self._total([card])))
        # Others are flown like the best of these, smaller and longer.
        for card in cards[: SEARCH.experiment_refined_cards]:
            cards += self._usable(self._planner.variants(card))
        if not cards:
            return None
        chosen = self._smallest(cards, separation)
        total = self._total(chosen)
        reached = separation(total)
        if reached < now + SEARCH.experiment_min_gain:
            return None
        return replace(
            describe(total),
            cards=self._as_flown(chosen),
            separation=reached,
            separation_now=now,
            target=SEARCH.experiment_separation,
        )

    def _smallest(self, cards: Sequence[TestCard], separation: Separation) -> tuple[TestCard, ...]:
        """Return the fewest maneuvers that separate enough, those of lowest amplitude; or most."""
        best: tuple[TestCard, ...] = ()
        mixed: tuple[TestCard, ...] = ()
        for count in range(1, SEARCH.experiment_max_maneuvers + 1):
            trials = [(card,) * count for card in cards]
            trials += [(*mixed, card) for card in cards] if count > 1 else []
            values = {trial: separation(self._total(trial)) for trial in trials}
            # What adds most to the cards chosen so far need not be one of them.
            mixed = max(trials[-len(cards) :], key=lambda trial: values[trial])
            enough = [one for one in trials if values[one] >= SEARCH.experiment_separation]
            if enough:
                return min(enough, key=lambda one: (self._planner.effort(one), -values[one]))
            best = max(trials, key=lambda trial: values[trial])
        return best

    def _as_flown(self, chosen: Sequence[TestCard]) -> tuple[TestCard, ...]:
        """Return cards with the repeats of which as many as chosen take part in the fit."""
        found = []
        flown = self._flown.copy()
        for number, card in enumerate(dict.fromkeys(chosen), start=1):
            left, repeats = chosen.count(card), 0
            while left:
                left -= not is_held_out(flown[card.surfaces])
                flown[card.surfaces] += 1
                repeats += 1
            found.append(card.model_copy(update={"id": f"X{number}", "repeats": repeats}))
        return tuple(found)

    def _usable(self, cards: Iterator[TestCard]) -> list[TestCard]:
        return [card for card in cards if self._information(card) is not None]

    def _total(self, cards: Sequence[TestCard]) -> InformationMatrix:
        """Return the information of the flights so far and of these cards."""
        total = self.past
        for card in cards:
            one = self._information(card)
            if one is not None:
                total = total + one
        return total.with_priors(self._priors)

    def _information(self, card: TestCard) -> InformationMatrix | None:
        """Return what one execution of a card says; None if the aircraft cannot fly it."""
        if card not in self._informations:
            try:
                self._informations[card] = self._simulated(card)
            except FlightError:
                self._informations[card] = None
        return self._informations[card]

    def _simulated(self, card: TestCard) -> InformationMatrix:
        record = create_maneuver_record(self._planner.maneuver(card))
        fit, model = self._fit, self._planner.model
        noise = fit.noise[fit.maneuvers[-1].record.flight]
        planned = FilterErrorFit.create([record], model, fit.free, {record.flight: noise})
        planned.values = dict(fit.values)
        planned.linearize()
        self._priors = {
            name: known for name, known in planned.priors().items() if name not in fit.free
        }
        return planned.information_of(planned.maneuvers[0], (self._names, self._build_columns))


class _CardPlanner:
    """Cards that this aircraft can fly, and the motions that they make."""

    def __init__(self, fit: FilterErrorFit, maneuvers: Sequence[Maneuver]) -> None:
        self.model = fit.revised_model()
        self._aircraft: Aircraft = maneuvers[-1].aircraft
        self._mass = float(np.mean([one.mass for one in maneuvers]))
        records = [one.record for one in fit.maneuvers]
        self._rate = 1.0 / records[-1].dt
        self._channels = frozenset(records[-1].channels)
        self._density = float(np.mean([np.mean(one.motion.input("rho")) for one in records]))
        self._speeds = [float(np.median(one.motion.state("V"))) for one in records]
        self._levers = {
            name for one in records for name in ("throttle", "flap") if name in one.motion.measured
        }
        self._curves: dict[float, TrimCurve] = {}
        self._motions: dict[tuple[float, float], PerturbationModels] = {}

    def effort(self, cards: Sequence[TestCard]) -> tuple[float, float, float]:
        """Return what cards ask for: levers moved, largest share of a travel, time at the stick."""
        levers = sum((card.flap != 0.0) + (card.throttle_step != 0.0) for card in cards)
        shares = [
            size / np.ptp(getattr(self._aircraft.controls, name).travel)
            for card in cards
            for name, size in card.amplitudes.items()
        ]
        return levers, float(max(shares)), sum(card.duration for card in cards)

    def first_cards(self) -> Iterator[TestCard]:
        """Yield large doublets of each surface over the envelope, with flap and throttle."""
        large = SEARCH.experiment_amplitudes[-1]
        for flap in self._flaps():
            for speed in self._speeds_with(flap):
                for surface in _SURFACES:
                    yield from self._card(speed, flap, surface, "doublet", large)
                if flap == 0.0:
                    for step in self._throttle_steps(speed):
                        yield from self._card(speed, flap, "de", "doublet", large, step)

    def variants(self, card: TestCard) -> Iterator[TestCard]:
        """Yield the other amplitudes and shapes of a card."""
        kinds: tuple[CardInputKind, ...] = ("doublet", "3-2-1-1")
        (surface,) = card.surfaces
        for kind in kinds:
            for share in SEARCH.experiment_amplitudes:
                own = self._card(card.speed, card.flap, surface, kind, share, card.throttle_step)
                yield from (one for one in own if one != card)

    def maneuver(self, card: TestCard) -> Maneuver:
        """Return a maneuver as it will be measured if flown as the card asks, but for the noise."""
        steps = len(INPUT_SHAPES[card.kind])
        return simulate_maneuver(
            card,
            CardExecution(
                sizes=dict.fromkeys(card.surfaces, (1.0,) * steps),
                widths=dict.fromkeys(card.surfaces, (1.0,) * steps),
                stagger=1.0,
                speed_error=0.0,
                hands_off=SEARCH.experiment_hands_off,
            ),
            self._motions_at(card.speed, card.flap),
            aircraft=self._aircraft,
            model=self.model,
            mass=self._mass,
            rate=self._rate,
            channels=self._channels,
        )

    def _flaps(self) -> tuple[float, ...]:
        if "flap" not in self._levers:
            return (0.0,)
        most = max(abs(one) for one in self._aircraft.controls.flap.travel)
        return 0.0, SEARCH.experiment_flap_share * most

    def _curve(self, flap: float) -> TrimCurve:
        if flap not in self._curves:
            self._curves[flap] = TrimCurve(
                self._aircraft, self.model, mass=self._mass, rho=self._density, flap=flap
            )
        return self._curves[flap]

    def _speeds_with(self, flap: float) -> list[float]:
        """Return speeds within the envelope and not far from those flown, m/s."""
        limits = self._curve(flap).speed_range
        if limits is None:
            return []
        reach = SEARCH.experiment_speed_reach
        low = max(SEARCH.experiment_stall_margin * limits[0], min(self._speeds) / reach)
        high = min(limits[1], max(self._speeds) * reach)
        if low >= high:
            return []
        # Flaps are for slow flight.
        count = SEARCH.experiment_speeds - (flap != 0.0)
        step = SEARCH.experiment_speed_step
        grid = np.linspace(low, high, SEARCH.experiment_speeds)[:count]
        return [step * round(one) for one in grid / step]

    def _throttle_steps(self, speed: float) -> Iterator[float]:
        level = self._curve(0.0).level_flight_at(speed)
        if level is None or "throttle" not in self._levers:
            return
        low, high = SEARCH.experiment_throttle_range
        thrust = self._aircraft.propulsion.max_thrust
        size = min(SEARCH.experiment_thrust_step * self._mass * GRAVITY / thrust, high - low)
        for step in (size, -size):
            if low <= level.throttle + step <= high:
                yield round(step, 2)

    def _card(
        self,
        speed: float,
        flap: float,
        surface: CardSurface,
        kind: CardInputKind,
        share: float,
        throttle_step: float = 0.0,
    ) -> Iterator[TestCard]:
        """Yield the card whose amplitude is a share of what limits allow, if there is one."""
        try:
            point = create_point_at(speed=speed, curve=self._curve(flap), flap=flap)
        except FlightError:
            return
        wanted = select_target_input(
            (surface,), kind, aircraft=self._aircraft, model=self.model, point=point
        )
        if wanted.source != "model":
            return
        band = wanted.amplitudes[surface]
        step = SEARCH.experiment_amplitude_step
        size = step * max(1, round(max(band.low, share * band.high) / step))
        yield TestCard(
            id="X",
            speed=f"{speed!r} m/s",
            flap=f"{flap!r} rad",
            surfaces=(surface,),
            kind=kind,
            amplitude=f"{size!r} rad",
            width=f"{wanted.width.best:.2f} s",
            throttle_step=throttle_step,
        )

    def _motions_at(self, speed: float, flap: float) -> PerturbationModels:
        if (speed, flap) not in self._motions:
            self._motions[speed, flap] = linearize_level_flight(
                self._aircraft, self.model, speed=speed, density=self._density,
                mass=self._mass, flap=flap,
            )  # fmt: skip
        return self._motions[speed, flap]
