"""Bounds to come are those that maximum likelihood reports; slices and cuts change nothing."""

import pickle
from collections.abc import Generator
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.excitation.doublets.verdict import InputVerdict, VerdictResult
from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.information.card_forecasts import (
    ForecastRequest,
    UnfinishedCard,
    describe_forecast,
    forecast_cards,
)
from gsapp.excitation.information.flight_knowledge import (
    ESTIMATION_AXES,
    FlightKnowledge,
    ManeuverData,
    learn_from_maneuver,
)
from gsapp.excitation.information.information_matrix import CombinedInformation
from gsapp.excitation.information.information_tracker import InformationTracker
from gsapp.excitation.information.outlook import BoundReduction
from gsapp.excitation.information.planned_maneuver import (
    ErrorDistribution,
    PilotErrorModel,
    draw_executions,
    simulate_maneuver,
)
from gsapp.excitation.information.predicted_bounds import (
    assumed_noise,
    compute_sensitivities,
    fit_filter_error,
    fit_maximum_likelihood,
    information_from_fit,
    noise_from_residuals,
    predict_in_gusts,
    predict_information,
)
from gsapp.excitation.information.remaining_time import RemainingTimeEstimator
from gsapp.excitation.settings import INFORMATION
from gsapp.excitation.test_points.perturbation_models import linearize_level_flight
from gsapp.flight.cards import CardSet, TestCard, load_cards
from gsapp.identification.axes import AXIS_RESPONSES, axis_derivatives
from gsapp.identification.filter_error.estimator import estimate as filter_error
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import AXES as AXIS_OF
from tests.identification.virtual_maneuvers import Virtual, fly

Result = TypeVar("Result")
RATE = 100.0
MODEL = load_model("b777")


@lru_cache(maxsize=1)
def _aircraft() -> Aircraft:
    return load_aircraft("b777")


@lru_cache(maxsize=8)
def _flown(seed: int, kind: str) -> Virtual:
    return fly(seed, kind)


def _verdict(
    virtual: Virtual, *, start: float = 0.0, result: VerdictResult = "good"
) -> InputVerdict:
    return InputVerdict(
        id="M1",
        given_at=start + 11.0,
        t_start=start + virtual.maneuver.t_start,
        t_input=start + 1.0,
        t_input_end=start + 3.0,
        t_end=start + virtual.maneuver.t_end,
        surfaces=virtual.maneuver.inputs,
        kind="doublet",
        amplitudes=dict.fromkeys(virtual.maneuver.inputs, 0.08),
        halves={},
        symmetry={},
        left_over={},
        cross={},
        V=30.0,
        alpha=None,
        result=result,
        findings=(),
        advice="",
    )


def _rows(virtual: Virtual, without: str = "") -> FlightRows:
    block = virtual.maneuver.block
    kept = [name for name in block.channels if name != without]
    return rows_from_block(block.select(kept), RATE)


def _all_of(steps: Generator[None, None, Result]) -> Result:
    while True:
        try:
            next(steps)
        except StopIteration as done:
            found: Result = done.value
            return found


def _cards(*ids: str) -> CardSet:
    cards = load_cards("b777")
    return cards.model_copy(update={"cards": tuple(c for c in cards.cards if c.id in ids)})


@pytest.mark.parametrize("kind", ["lon", "lat"])
@pytest.mark.parametrize("color", [0.0, 0.9])
def test_expected_bounds_are_those_reported(kind: str, color: float) -> None:
    """At known parameters, for the input as flown and in the noise there is: within 25 %."""
    ratios: list[float] = []
    for seed in (5300, 5301):
        virtual, axis = fly(seed, kind, color=color), AXIS_OF[kind]
        known = MODEL.with_derivatives(virtual.truth)
        noise = noise_from_residuals(fit_maximum_likelihood(virtual.maneuver, axis, MODEL), RATE)
        found = predict_information(virtual.maneuver, axis, known, noise).stds
        told = estimate([virtual.maneuver], MLSettings(axis=axis))
        ratios += [
            found[name] / one.std
            for name, one in told.derivatives.items()
            if one.std is not None and name in found
        ]
    assert len(ratios) >= 20
    assert np.mean(np.abs(np.array(ratios) - 1.0) < 0.25) >= 0.95


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_gusts_expected_bounds_are_those_of_filter_error(kind: str) -> None:
    """With its noise, and before it for a maneuver alike in gusts of its own."""
    virtual, axis = fly(5303, kind, gust=0.6), AXIS_OF[kind]
    known = MODEL.with_derivatives(virtual.truth)
    fitted = _all_of(fit_filter_error(virtual.maneuver, axis, MODEL))
    (noise,) = fitted.noise.values()
    calm = fly(5303, kind).maneuver
    for steps in (
        predict_in_gusts(virtual.maneuver, axis, known, noise),
        predict_in_gusts(calm, axis, known, noise, seed=1),
    ):
        found = _all_of(steps).stds
        ratios = np.array(
            [
                found[name] / one.std
                for name, one in fitted.estimate.derivatives.items()
                if one.std is not None
            ]
        )
        assert np.mean(np.abs(ratios - 1.0) < 0.25) >= 0.9, ratios


def test_a_maneuver_in_gusts_counts_as_filter_error_sees_it() -> None:
    virtual = fly(5303, "lon", gust=0.6)
    known = FlightKnowledge(initial_model=MODEL, rate=RATE, mass=_aircraft().mass.mass)
    data = ManeuverData(
        verdict=_verdict(virtual),
        rows=_rows(virtual),
        card=None,
        mass=virtual.maneuver.mass,
        ftr_estimates={},
    )
    known = _all_of(learn_from_maneuver(known, data, _aircraft()))
    told = filter_error([virtual.maneuver], MLSettings(axis="lon")).derivatives
    assert set(known.gusts) == {"lon"}
    for name, (_, std) in known.estimates().items():
        assert std == pytest.approx(told[name].std, rel=0.1)
        assert known.predicted_bounds[name] == pytest.approx(std, rel=0.6)


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_the_noise_of_a_maneuver_is_heard_in_it_without_a_fit(kind: str) -> None:
    virtual, axis = _flown(5302, kind), AXIS_OF[kind]
    heard = compute_sensitivities(virtual.maneuver, axis, MODEL).estimate_noise()
    left = noise_from_residuals(fit_maximum_likelihood(virtual.maneuver, axis, MODEL), RATE)
    assert heard.responses == left.responses
    np.testing.assert_allclose(np.sqrt(heard.variances / left.variances), 1.0, atol=0.1)


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_what_a_maneuver_brought_is_what_maximum_likelihood_reports(kind: str) -> None:
    virtual, axis = _flown(5302, kind), AXIS_OF[kind]
    found = information_from_fit(fit_maximum_likelihood(virtual.maneuver, axis, MODEL)).stds
    told = estimate([virtual.maneuver], MLSettings(axis=axis)).derivatives
    for name, std in found.items():
        assert std == pytest.approx(told[name].std, rel=0.01)


def test_a_larger_input_brings_smaller_bounds() -> None:
    """Twice the amplitude halves the bounds of derivatives, as noise does not grow with it."""
    card = load_cards("b777").cards[1]
    exactly = replace(
        PilotErrorModel(),
        size=ErrorDistribution(mean=0.0, std=0.0),
        width=ErrorDistribution(mean=0.0, std=0.0),
    )
    (execution,) = draw_executions(card, exactly, 1)
    noise = assumed_noise(_aircraft(), AXIS_RESPONSES["lat"], RATE)
    found = []
    for factor in (0.25, 0.5):
        smaller = card.model_copy(
            update={"amplitude": {n: factor * a for n, a in card.amplitudes.items()}}
        )
        maneuver = simulate_maneuver(
            smaller,
            execution,
            linearize_level_flight(_aircraft(), MODEL, speed=card.speed),
            aircraft=_aircraft(),
            model=MODEL,
            mass=_aircraft().mass.mass,
            rate=RATE,
            channels=AXIS_RESPONSES["both"],
        )
        for name, asked in smaller.amplitudes.items():
            moved = maneuver.block[name] - maneuver.block[name][0]
            assert 0.5 * np.ptp(moved) == pytest.approx(asked * np.mean(execution.sizes[name]))
        found.append(predict_information(maneuver, "lat", MODEL, noise).stds)
    for name in ("Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r", "Cn_dr", "CY_beta"):
        assert found[0][name] / found[1][name] == pytest.approx(2.0, rel=0.1)


def test_slices_change_nothing_and_an_outlook_comes_when_it_is_due() -> None:
    virtual, cards = _flown(5302, "lat"), _cards("E1", "R1")
    verdict, rows = _verdict(virtual), _rows(virtual)
    found = []
    for sliced in (True, False):
        book = InformationTracker(_aircraft(), MODEL, RATE)
        book.add_maneuver(verdict, rows, card=cards.cards[0])
        if sliced:
            assert book.run_slice(0.0)
            while book.run_slice(1e-4):
                pass
        early = book.outlook(verdict.given_at + 0.5, cards)
        assert all(bound.std is None for bound in early.bounds)
        assert early.best_forecast is None
        found.append(book.outlook(verdict.given_at + 0.5 + INFORMATION.forecast_delay, cards))
    assert found[0] == found[1]
    outlook = found[0]
    reached = {bound.name for bound in outlook.bounds if bound.std is not None}
    assert reached == set(_lateral())
    # Nothing is known of pitch yet: that is where most is to be gained.
    assert outlook.best_forecast.card == "E1"
    assert outlook.best_forecast.repeats == 3
    for prospect in outlook.forecasts:
        for gain in prospect.reductions:
            assert gain.low <= gain.bound_after <= gain.high
            assert gain.bound_before is None or gain.high <= gain.bound_before * 1.001


def _lateral() -> tuple[str, ...]:
    return tuple(
        f"{one}_{what}"
        for one in ("CY", "Cl", "Cn")
        for what in ("0", "beta", "p", "r", "da", "dr")
    )


def test_bounds_add_up_like_one_joint_fit() -> None:
    book = InformationTracker(_aircraft(), MODEL, RATE)
    flown = [fly(seed, "lat", model=MODEL) for seed in (5302, 5303)]
    for virtual in flown:
        book.add_maneuver(_verdict(virtual), _rows(virtual))
    book.outlook(100.0)
    told = estimate([one.maneuver for one in flown], MLSettings(axis="lat")).derivatives
    for bound in book.bounds():
        if bound.name in told:
            assert bound.std == pytest.approx(told[bound.name].std, rel=0.25)


def test_invalid_maneuvers_and_lost_channels() -> None:
    virtual = _flown(5302, "lat")
    for result, without, expected_to_bring in (
        ("invalid", "", False),
        ("too-small", "beta", True),
        ("good", "phi", True),
    ):
        book = InformationTracker(_aircraft(), MODEL, RATE)
        book.add_maneuver(_verdict(virtual, result=result), _rows(virtual, without))  # type: ignore[arg-type]
        outlook = book.outlook(100.0, _cards("R1"))
        seen = [bound.name for bound in outlook.bounds if bound.std is not None]
        assert bool(seen) == expected_to_bring
    empty = InformationTracker(_aircraft(), MODEL, RATE)
    gone = _rows(virtual)
    gone = FlightRows(first_index=0, times=gone.times, values=np.full_like(gone.values, np.nan))
    empty.add_maneuver(_verdict(virtual), gone)
    outlook = empty.outlook(100.0)
    assert all(bound.std is None for bound in outlook.bounds)
    assert any("M1 gave no information" in remark for remark in outlook.remarks)


def test_nothing_is_worth_flying_without_time_or_once_all_is_reached() -> None:
    landed = InformationTracker(
        _aircraft(),
        MODEL,
        RATE,
        longest=INFORMATION.landing_reserve + 0.5 * INFORMATION.default_maneuver_interval,
    )
    content = InformationTracker(
        _aircraft(), MODEL, RATE, wanted=dict.fromkeys(axis_derivatives("both"), 100.0)
    )
    for book in (landed, content):
        book.outlook(0.0, _cards("A1"))
        outlook = book.outlook(INFORMATION.forecast_delay, _cards("A1"))
        assert outlook.best_forecast is None
    assert outlook.forecasts


def test_without_a_model_only_time_is_told() -> None:
    virtual = _flown(5302, "lat")
    book = InformationTracker(_aircraft(), None, RATE)
    book.add_maneuver(_verdict(virtual), _rows(virtual))
    outlook = book.outlook(20.0, _cards("R1"))
    assert outlook.bounds == ()
    assert outlook.best_forecast is None
    assert outlook.time_left == pytest.approx(
        INFORMATION.default_flight_duration - INFORMATION.landing_reserve
    )
    nothing = InformationTracker(None, None, RATE).outlook(0.0)
    assert nothing.time_left is None
    assert any("no aircraft file" in remark for remark in nothing.remarks)


def test_a_request_goes_to_another_process_and_back() -> None:
    """Prospects depend on nothing but their request, and a card that cannot be flown is named."""
    cards = _cards("A1").cards
    slow = cards[0].model_copy(update={"id": "A9", "speed": 12.0})
    aircraft = _aircraft()
    request = ForecastRequest(
        aircraft=aircraft,
        model=MODEL,
        cards=(UnfinishedCard(card=cards[0], missing=2), UnfinishedCard(card=slow, missing=1)),
        totals={axis: CombinedInformation.empty(axis) for axis in ESTIMATION_AXES},
        noise={
            axis: assumed_noise(aircraft, AXIS_RESPONSES[axis], RATE) for axis in ESTIMATION_AXES
        },
        gusts={},
        pilot_errors=PilotErrorModel(),
        channels=frozenset(AXIS_RESPONSES["both"]),
        rate=RATE,
        mass=aircraft.mass.mass,
        density=1.2,
        target_bounds={},
        maneuver_interval=INFORMATION.default_maneuver_interval,
    )
    reply = forecast_cards(pickle.loads(pickle.dumps(request)))  # noqa: S301 - our own
    assert pickle.loads(pickle.dumps(reply)) == forecast_cards(request)  # noqa: S301
    (one, two) = reply.by_card["A1"]
    assert (one.repeats, two.repeats) == (1, 2)
    assert two.seconds == pytest.approx(2.0 * one.seconds)
    after = [{gain.name: gain.bound_after for gain in each.reductions} for each in (one, two)]
    assert all(after[1][name] < bound for name, bound in after[0].items())
    assert "A9 cannot be evaluated" in reply.remarks[0]


def test_words_of_a_prospect() -> None:
    card = TestCard(
        id="C1",
        speed="105 ft/s",
        surfaces=("dr", "da"),
        amplitude="6 deg",
        width="0.5 s",
        repeats=4,
    )
    value = abs(MODEL.derivative("Cn_r"))
    gain = BoundReduction(
        name="Cn_r", bound_before=0.35 * value, bound_after=0.15 * value, low=0.1, high=0.2
    )
    text = describe_forecast(card, 2, (gain,), MODEL, {})
    assert text == "two more rudder-aileron doublets at 105 ft/s: Cn_r from 35 % to 15 %"
    unknown = replace(gain, bound_before=None)
    text = describe_forecast(card, 1, (unknown,), MODEL, {}, "SI")
    assert text == "one more rudder-aileron doublet at 32 m/s: Cn_r to 15 %"
    assert "Cn_r" not in describe_forecast(card, 1, (gain,), MODEL, {"Cn_r": 0.4 * value})


def test_noise_of_a_long_flight_is_that_of_its_newest_stretches() -> None:
    """However many maneuvers there were, what is kept of their noise does not grow."""
    known = FlightKnowledge(initial_model=MODEL, rate=RATE, mass=_aircraft().mass.mass)
    usual = assumed_noise(_aircraft(), AXIS_RESPONSES["lon"], RATE)
    limit = INFORMATION.max_noise_stretches
    for level in (1.0, *[4.0] * limit):
        heard = replace(usual, autocovariance=level * usual.autocovariance, duration=4.0)
        known = known.with_noise("lon", heard)
    assert len(known.measured_noise["lon"]) == limit
    pooled = known.noise("lon", _aircraft())
    np.testing.assert_allclose(pooled.variances, 4.0 * usual.variances)


def test_a_channel_in_doubt_is_as_good_as_missing() -> None:
    virtual = _flown(5302, "lat")
    learned = []
    for rows in (_rows(virtual).mask_channels(("beta",)), _rows(virtual, without="beta")):
        known = FlightKnowledge(initial_model=MODEL, rate=RATE, mass=_aircraft().mass.mass)
        lesson = ManeuverData(
            verdict=_verdict(virtual), rows=rows, card=None, mass=known.mass, ftr_estimates={}
        )
        learned.append(_all_of(learn_from_maneuver(known, lesson, _aircraft())))
    doubted, missing = learned
    assert "beta" not in doubted.channels
    assert doubted.estimates() == missing.estimates()
    assert doubted.maneuvers == 1


# --- time left ----------------------------------------------------------------------------------


def _flight_rows(speed: np.ndarray, throttle: float) -> FlightRows:
    times = np.arange(speed.size) / 10.0
    values = np.column_stack((speed, np.full(speed.size, throttle), np.full(speed.size, 0.01)))
    return rows_from_block(Block(channels=("V", "throttle", "q"), times=times, values=values), 10.0)


@settings(max_examples=20, deadline=None)
@given(cuts=st.lists(st.integers(1, 1199), max_size=8), throttle=st.floats(0.2, 1.0))
def test_cutting_changes_no_budget(cuts: list[int], throttle: float) -> None:
    rows = _flight_rows(np.where(np.arange(1200) < 300, 0.0, 30.0), throttle)
    whole, pieces = (RemainingTimeEstimator(_aircraft(), 10.0) for _ in range(2))
    whole.process_rows(rows)
    for start, stop in pairwise(sorted({0, *cuts, 1200})):
        pieces.process_rows(rows.slice_rows(start, stop))
    assert whole.time_left(120.0) == pieces.time_left(120.0)
    assert whole.mass == pieces.mass


def test_time_left_by_clock_and_by_fuel() -> None:
    speed = np.where(np.arange(2000) < 300, 0.0, 30.0)
    aircraft = _aircraft()
    thrifty, thirsty = (RemainingTimeEstimator(aircraft, 10.0) for _ in range(2))
    thrifty.process_rows(_flight_rows(speed, 0.3))
    thirsty.process_rows(_flight_rows(speed, 1.0))
    by_clock = thrifty.time_left(200.0)
    assert by_clock == pytest.approx(
        INFORMATION.default_flight_duration - INFORMATION.landing_reserve - 170.0, abs=2.0
    )
    fuel = aircraft.mass
    by_fuel = (
        fuel.fuel - 200.0 * fuel.fuel_flow_full
    ) / fuel.fuel_flow_full - INFORMATION.landing_reserve
    assert thirsty.time_left(200.0) == pytest.approx(min(by_fuel, by_clock or 0.0), abs=3.0)
    assert thrifty.maneuvers_left(200.0) == int(
        (by_clock or 0.0) // INFORMATION.default_maneuver_interval
    )
    for begun in (100.0, 120.0, 140.0):
        thrifty.add_maneuver(begun)
    assert thrifty.maneuver_interval == pytest.approx(
        (INFORMATION.default_maneuver_interval + 40.0) / 3.0
    )
    thrifty.process_rows(_flight_rows(np.zeros(100), 0.0).slice_rows(0, 0))
    assert thrifty.time_left(200.0) == by_clock
