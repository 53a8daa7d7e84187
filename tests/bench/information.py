"""Bounds expected against bounds reported, the band before a maneuver, and what it all costs.

A hundred virtual maneuvers (seeds 0 to 99) in ten flights of ten, card after card. Aircraft and
instruments are those of the virtual aircraft; each flight has its own noise and air, and half of
the flights no attitude. The model that the book begins with is wrong by up to 15 % in every
derivative; whatever it knows better it learned from the maneuvers before. What maximum likelihood
reports is what `gsapp estimate` reports: a campaign of that one maneuver, the honest bound.

Conditions: ``white`` is calm air and instruments as they are: their own noise white, engine
vibration folded into the gyros; ``colored`` adds noise of a first-order recursion (0.9 at 100 Hz)
to all responses; ``gusts`` is air of 0.1 to 0.8 m/s.

As flown: the bound expected for the input as it was then flown; within 25 % of the reported one is
asked for. *Booked* is what the book shows seconds after the maneuver: expected where a few rounds
from the values known before lead. *One step*: at the values known before, with the noise that one
step from them leaves over, as the book hears it before any fit. *In its air*: the same with the
noise of the fit. What was heard before a maneuver does not tell: engine vibration that folds to
near zero, and the gust that happens to come, are never twice the same.

Band: 80 % band of the bound by one maneuver, before it, from the card; the pilot's errors (12 % in
size and width) are drawn by the bench and not known to the book. It should hold in 80 %.

Reached: bounds that the book shows against those of one joint fit of all maneuvers so far.
"""

import sys
import time
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model, load_model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.information.card_forecasts import (
    ForecastRequest,
    UnfinishedCard,
    forecast_cards,
)
from gsapp.excitation.information.flight_knowledge import (
    ESTIMATION_AXES,
    FlightKnowledge,
    ManeuverData,
    axes_of,
    learn_from_maneuver,
    learn_noise,
    maneuver_from_rows,
)
from gsapp.excitation.information.information_matrix import CombinedInformation
from gsapp.excitation.information.information_tracker import InformationTracker
from gsapp.excitation.information.predicted_bounds import (
    fit_filter_error,
    fit_maximum_likelihood,
    information_from_fit,
    predict_in_gusts,
    predict_information,
)
from gsapp.excitation.settings import INFORMATION
from gsapp.flight.cards import CardSet, TestCard, load_cards
from gsapp.identification import maximum_likelihood as likelihood
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import MLSettings
from gsapp.identification.results import Estimate
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, FOOT, GRAVITY
from tests.virtual.inputs import FlownInput, fly_input

Result = TypeVar("Result")
PER_FLIGHT = 10
WITHIN = 0.25
OFF = 0.15
"""Share by which each derivative of the first model may be wrong."""
COLOR = 0.9
EXTRA = {
    "alpha": 0.1 * DEGREE,
    "beta": 0.1 * DEGREE,
    **dict.fromkeys("pqr", 1.0 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.005 * GRAVITY),
}
"""Standard deviation of the colored noise that is added."""
GUSTS = (0.1, 0.8)
ORDER = ("C1", "E1", "C1", "R1", "E2", "A1", "C1", "E1", "R1", "C1")
LAP = 40.0
CONDITIONS = (
    ("white", 100.0), ("colored", 100.0), ("white", 50.0), ("gusts", 100.0), ("gusts", 50.0),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """One maneuver as the book gets it."""

    card: TestCard
    verdict: InputVerdict
    rows: FlightRows
    aircraft: Aircraft
    rate: float

    @property
    def approach(self) -> FlightRows:
        return self.rows.slice_rows(0, int(np.searchsorted(self.rows.times, self.verdict.t_start)))

    def maneuver(self) -> Maneuver:
        verdict = self.verdict
        return maneuver_from_rows(
            self.rows,
            self.aircraft,
            verdict.t_start,
            verdict.t_end,
            id=verdict.id,
            inputs=verdict.surfaces,
            mass=self.aircraft.mass.mass,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outcome:
    maneuver: str
    name: str
    reported: float
    foreseen: float
    in_its_air: float
    booked: float
    low: float
    middle: float
    high: float


def flight(first: int, condition: str, rate: float, count: int = PER_FLIGHT) -> Iterator[Case]:
    cards = load_cards("b777")
    for number in range(count):
        yield _case(first, number, condition, rate, cards)


def _case(first: int, number: int, condition: str, rate: float, cards: CardSet) -> Case:
    day = np.random.default_rng((first, 61))
    noise, gust, attitude = day.uniform(0.7, 1.5), day.uniform(*GUSTS), day.random() < 0.5
    card = cards.card(ORDER[number])
    seed = first + number
    flown = _flown(seed, card.id, noise, gust if condition == "gusts" else 0.0, bool(attitude))
    measured = flown.measured
    if condition == "colored":
        measured = _colored(measured, seed, noise)
    step = round(100.0 / rate)
    offset = number * LAP
    block = Block(
        channels=measured.channels,
        times=measured.times[::step] + offset,
        values=measured.values[::step],
    )
    return Case(
        card=card,
        verdict=verdict_of(flown, f"M{number + 1}", offset),
        rows=rows_from_block(block, rate),
        aircraft=flown.aircraft,
        rate=rate,
    )


@lru_cache(maxsize=2 * PER_FLIGHT)
def _flown(seed: int, card_id: str, noise: float, gust: float, attitude: bool) -> FlownInput:
    card = load_cards("b777").card(card_id)
    random = np.random.default_rng((seed, 62))
    size, width, speed = random.standard_normal(3)
    side = 1.0 if random.random() < 0.5 else -1.0
    return fly_input(
        seed,
        surfaces=card.surfaces,
        kind=card.kind,
        speed=card.speed,
        amplitudes={
            name: side
            * (1.0 if index == 0 else -1.0)
            * asked
            * float(np.exp(0.12 * size + 0.05 * random.standard_normal()))
            for index, (name, asked) in enumerate(card.amplitudes.items())
        },
        width=card.width * float(np.exp(0.12 * width)),
        stagger=card.duration * float(np.exp(0.1 * random.standard_normal())),
        bank=1.5 * DEGREE * float(random.standard_normal()),
        speed_off=3.0 * FOOT * float(speed),
        roll_rate=0.0,
        pitch_rate=0.0,
        meddling=(),
        hands_off=float(random.uniform(4.5, 6.0)),
        left_over=0.03 * float(random.standard_normal()),
        turbulence=gust,
        noise=noise,
        attitude=attitude,
    )


def _colored(measured: Block, seed: int, factor: float) -> Block:
    random = np.random.default_rng((seed, 64))
    values = measured.values.copy()
    for name, std in EXTRA.items():
        error = random.standard_normal(len(measured) + 100)
        slow = lfilter([np.sqrt(1.0 - COLOR**2)], [1.0, -COLOR], error)[100:]
        values[:, measured.channels.index(name)] += factor * std * slow
    return Block(channels=measured.channels, times=measured.times, values=values)


def verdict_of(flown: FlownInput, name: str, offset: float) -> InputVerdict:
    """Return what a judge who knows the truth says of an input."""
    inside = (flown.truth.times >= flown.t_input) & (flown.truth.times <= flown.t_let_go + 0.3)
    return InputVerdict(
        id=name,
        given_at=flown.t_hand + 0.5 + offset,
        t_start=flown.t_input - 1.0 + offset,
        t_input=flown.t_input + offset,
        t_input_end=flown.t_let_go + offset,
        t_end=flown.t_hand + offset,
        surfaces=flown.plan.surfaces,
        kind=flown.plan.kind,
        amplitudes={
            one: 0.5 * float(np.ptp(flown.truth[one][inside])) for one in flown.plan.surfaces
        },
        halves=dict.fromkeys(flown.plan.surfaces, (flown.plan.width, flown.plan.width)),
        symmetry={},
        left_over={},
        cross={},
        V=float(flown.truth["V"][inside][0]),
        alpha=None,
        result="good",
        findings=(),
        advice="good",
        card="",
        counts=True,
    )


def wrong_model(first: int) -> Model:
    random = np.random.default_rng((first, 63))
    base = load_model("b777")
    return base.with_derivatives(
        {
            name: value * (1.0 + OFF * float(random.uniform(-1.0, 1.0)))
            for name, value in base.derivatives.items()
        }
    )


def reported(maneuver: Maneuver) -> dict[str, float]:
    (result,) = run_campaign([maneuver], CampaignSettings()).results
    return {} if result.estimate is None else _stds(result.estimate)


def _stds(estimate: Estimate) -> dict[str, float]:
    return {
        name: one.std
        for name, one in estimate.derivatives.items()
        if one.status == "estimated" and one.std is not None
    }


def follow(cases: Sequence[Case], model: Model) -> Iterator[Outcome]:
    """Let the book follow a flight; give what it expected and what was reported."""
    aircraft = cases[0].aircraft
    first = FlightKnowledge(initial_model=model, rate=cases[0].rate, mass=aircraft.mass.mass)
    # The book hears the first air of a flight; here that is the first approach.
    known = _all_of(learn_noise(first, cases[0].approach, aircraft))
    for case in cases:
        band = _band(known, case, aircraft)
        before, known = known, _all_of(learn_from_maneuver(known, _lesson(case), aircraft))
        maneuver = case.maneuver()
        model, own, booked = before.updated_model(aircraft), {}, {}
        for axis in axes_of(case.verdict.surfaces):
            if axis in known.gusts:
                steps = predict_in_gusts(maneuver, axis, model, known.gusts[axis])
                fit = _all_of(fit_filter_error(maneuver, axis, model))
                own.update(_all_of(steps).stds)
            else:
                noise = known.measured_noise[axis][-1]
                own.update(predict_information(maneuver, axis, model, noise).stds)
                fit = fit_maximum_likelihood(maneuver, axis, model)
            booked.update(information_from_fit(fit).stds)
        for name, std in reported(maneuver).items():
            if name in band and name in known.predicted_bounds and name in own and name in booked:
                low, middle, high = band[name]
                yield Outcome(
                    maneuver=case.verdict.id,
                    name=name,
                    reported=std,
                    foreseen=known.predicted_bounds[name],
                    in_its_air=own[name],
                    booked=booked[name],
                    low=low,
                    middle=middle,
                    high=high,
                )


def _all_of(steps: Generator[None, None, Result]) -> Result:
    while True:
        try:
            next(steps)
        except StopIteration as done:
            found: Result = done.value
            return found


def _lesson(case: Case) -> ManeuverData:
    return ManeuverData(
        verdict=case.verdict,
        rows=case.rows,
        card=case.card,
        mass=case.aircraft.mass.mass,
        ftr_estimates={},
    )


def _band(
    known: FlightKnowledge, case: Case, aircraft: Aircraft
) -> dict[str, tuple[float, float, float]]:
    request = ForecastRequest(
        aircraft=aircraft,
        model=known.updated_model(aircraft),
        cards=(UnfinishedCard(card=case.card, missing=1),),
        totals={axis: CombinedInformation.empty(axis) for axis in ESTIMATION_AXES},
        noise={axis: known.noise(axis, aircraft) for axis in ESTIMATION_AXES},
        gusts=known.gusts,
        pilot_errors=known.pilot_errors,
        channels=known.channels,
        rate=known.rate,
        mass=known.mass,
        density=known.density,
        target_bounds={},
        maneuver_interval=35.0,
    )
    (found,) = forecast_cards(request).by_card.values()
    return {gain.name: (gain.low, gain.bound_after, gain.high) for gain in found[0].reductions}


# --- what is printed ----------------------------------------------------------------------------


def _within(ratios: Sequence[float]) -> float:
    return float(np.mean(np.abs(np.array(ratios) - 1.0) < WITHIN))


def print_condition(condition: str, rate: float, outcomes: Sequence[Outcome]) -> None:
    one_step = [one.foreseen / one.reported for one in outcomes]
    booked = [one.booked / one.reported for one in outcomes]
    during = [one.in_its_air / one.reported for one in outcomes]
    held = [one.low <= one.reported <= one.high for one in outcomes]
    width = float(np.median([one.high / one.low for one in outcomes]))
    print(
        f"{condition:8}{rate:4.0f} Hz: {len(outcomes)} bounds; within 25 %: "
        f"{100.0 * _within(booked):.1f} % as booked after it, "
        f"{100.0 * _within(one_step):.1f} % by one step "
        f"(median {np.median(one_step):.2f}, 10 to 90 %: {np.quantile(one_step, 0.1):.2f} to "
        f"{np.quantile(one_step, 0.9):.2f}), {100.0 * _within(during):.1f} % in its air at the "
        f"values known before; 80 % band before the maneuver holds "
        f"{100.0 * np.mean(held):.1f} %, its ends {width:.1f} times apart"
    )


def print_derivatives(outcomes: Sequence[Outcome]) -> None:
    print(f"{'':10}{'in its air':>22}{'one step':>24}{'band':>8}")
    print(f"{'':10}{'within':>8}{'median':>8}{'10-90 %':>12}{'within':>8}{'10-90 %':>12}")
    for name in dict.fromkeys(one.name for one in outcomes):
        own = [one for one in outcomes if one.name == name]
        during = np.array([one.in_its_air / one.reported for one in own])
        one_step = np.array([one.foreseen / one.reported for one in own])
        held = np.mean([one.low <= one.reported <= one.high for one in own])
        print(
            f"{name:10}{_within(during.tolist()):8.2f}{np.median(during):8.2f}"
            f"{np.quantile(during, 0.1):6.2f}-{np.quantile(during, 0.9):4.2f}"
            f"{_within(one_step.tolist()):9.2f}"
            f"{np.quantile(one_step, 0.1):6.2f}-{np.quantile(one_step, 0.9):4.2f}{held:8.2f}"
        )


def print_reached(cases: Sequence[Case], model: Model) -> None:
    """Print the bounds that the book reached over those of a joint fit of the same maneuvers."""
    book = _followed(cases, model)
    ratios = []
    for axis in ESTIMATION_AXES:
        chosen = [case for case in cases if axes_of(case.verdict.surfaces) == (axis,)]
        joint = likelihood.estimate([case.maneuver() for case in chosen], MLSettings(axis=axis))
        ratios += [
            bound.std / std
            for name, std in _stds(joint).items()
            for bound in book.bounds()
            if bound.name == name and bound.std is not None
        ]
    print(
        f"bounds reached by {len(cases)} maneuvers over those of one joint fit: median "
        f"{np.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}"
    )


def _followed(cases: Sequence[Case], model: Model) -> InformationTracker:
    book = InformationTracker(cases[0].aircraft, model, cases[0].rate)
    for case in cases:
        book.add_maneuver(case.verdict, case.rows, card=case.card)
    book.outlook(cases[-1].verdict.given_at + INFORMATION.forecast_delay)
    return book


def print_cost(cases: Sequence[Case], model: Model) -> None:
    """Print the CPU that a maneuver and an outlook take, and the longest step of either."""
    cards = load_cards("b777")
    steps: list[float] = []
    whole = {}
    for title, asked in (("maneuver", None), ("outlook", cards)):
        took = []
        book = InformationTracker(cases[0].aircraft, model)
        for case in cases:
            book.add_maneuver(case.verdict, case.rows, card=case.card)
            book.outlook(case.verdict.given_at, asked)
            begun = len(steps)
            more = True
            while more:
                started = time.process_time()
                more = book.run_slice(0.0)
                steps.append(time.process_time() - started)
            took.append(sum(steps[begun:]))
            book.outlook(case.verdict.given_at + INFORMATION.forecast_delay, asked)
        whole[title] = float(np.median(took))
    started = time.process_time()
    for _ in range(100):
        book.outlook(case.verdict.given_at + 2.0 * INFORMATION.forecast_delay, cards)
    asking = (time.process_time() - started) / 100.0
    print(
        f"CPU: what a maneuver teaches {1e3 * whole['maneuver']:.0f} ms, prospects of "
        f"{len(cards.cards)} cards {1e3 * (whole['outlook'] - whole['maneuver']):.0f} ms, longest "
        f"step {1e3 * max(steps):.0f} ms (median {1e3 * np.median(steps):.0f} ms), asking for the "
        f"outlook {1e6 * asking:.0f} us"
    )


def main(*arguments: str) -> None:
    """Fly, expect, estimate, compare; ``--quick`` takes two of the ten flights."""
    count = 2 if "--quick" in arguments else 10
    firsts = [PER_FLIGHT * number for number in range(count)]
    outcomes: dict[tuple[str, float], list[Outcome]] = {one: [] for one in CONDITIONS}
    for first in firsts:
        # Flown once for all that is done to the record afterwards.
        for condition, rate in CONDITIONS:
            cases = list(flight(first, condition, rate))
            outcomes[condition, rate] += follow(cases, wrong_model(first))
    for (condition, rate), found in outcomes.items():
        print_condition(condition, rate, found)
    everything = [one for found in outcomes.values() for one in found]
    print_derivatives(everything)
    cases = list(flight(firsts[0], "white", 100.0))
    print_reached(cases, wrong_model(firsts[0]))
    print_cost(cases, wrong_model(firsts[0]))


if __name__ == "__main__":
    main(*sys.argv[1:])
