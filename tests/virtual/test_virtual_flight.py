"""Flights and single inputs: as planned, in the air, the same for a seed; plans with mistakes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.flight.cards import CardSet
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError
from gsapp.quantities.constants import DEGREE
from gsapp.virtual.flight_plan import (
    INPUT_SHAPES,
    FlightPlan,
    PilotLimits,
    PlannedManeuver,
    load_flight_plan,
    with_cards,
)
from gsapp.virtual.sticks import StickInput
from gsapp.virtual.virtual_flight import FlightSimulation, VirtualFlight, simulate_flight
from tests.virtual.input_plan import Meddling
from tests.virtual.inputs import fly_input

if TYPE_CHECKING:
    from collections.abc import Sequence

FT = 0.3048
DEG = math.pi / 180.0


def _under_way(**changes: object) -> FlightSimulation:
    settings: dict[str, object] = {"aircraft": load_aircraft("b777"), "seed": 3, **changes}
    return FlightSimulation(load_flight_plan("short"), **settings)  # type: ignore[arg-type]


def test_a_flight_has_its_phases_in_order(short_flight: VirtualFlight) -> None:
    order = []
    for phase, _ in short_flight.phases:
        name = "maneuver" if phase.startswith("maneuver") else phase
        if name not in order:
            order.append(name)
    assert order == [
        "preflight", "engines running", "range check", "take-off", "climb", "pattern", "maneuver",
        "approach", "final", "flare", "landed", "engines off",
    ]  # fmt: skip
    assert not short_flight.crashed


def test_it_is_flown_as_the_aircraft_was(short_flight: VirtualFlight) -> None:
    """Lift-off near 73 ft/s, pattern at 80-120 ft/s, height bounded, gentle touch-down."""
    truth = short_flight.truth
    airborne = np.flatnonzero(truth["height"] > 0.15)
    lift_off, touch_down = airborne[0], airborne[-1]
    assert 68.0 < truth["V"][lift_off] / FT < 82.0
    pattern = truth.between(short_flight.phase("maneuver 1")[0], short_flight.phase("approach")[0])
    assert pattern["V"].min() / FT > 75.0
    assert pattern["V"].max() / FT < 130.0
    assert pattern["height"].min() > 20.0
    assert pattern["height"].max() < 80.0
    assert np.abs(truth["phi"]).max() < 70.0 * DEG
    assert truth["climb_rate"][touch_down - 2] > -3.0
    assert abs(truth["V"][-1]) < 0.5
    assert truth["rpm_left"][-1] < 0.2 * truth["rpm_left"].max()


def test_turns_are_coordinated(short_flight: VirtualFlight) -> None:
    truth = short_flight.truth
    flying = truth.between(short_flight.phase("pattern")[0], short_flight.phase("approach")[0])
    turning = (np.abs(flying["phi"]) > 30 * DEG) & (np.abs(flying["p"]) < 8 * DEG)
    assert turning.sum() > 200
    assert np.abs(flying["beta"][turning]).mean() < 2.5 * DEG
    load = np.mean(flying["an"][turning] * np.cos(flying["phi"][turning])) / 9.80665
    assert load == pytest.approx(1.0, abs=0.2)


def test_maneuvers_are_flown_as_planned_from_nearly_straight_flight(
    short_flight: VirtualFlight,
) -> None:
    plan = load_flight_plan("short")
    assert [m.inputs for m in short_flight.maneuvers] == [m.inputs for m in plan.maneuvers]
    for maneuver in short_flight.maneuvers:
        during = short_flight.truth.between(maneuver.t_start, maneuver.t_end)
        before = short_flight.truth.between(maneuver.t_start - 0.3, maneuver.t_start)
        assert np.abs(before["phi"]).max() < 20 * DEG
        for surface in maneuver.inputs:
            rest = np.median(before[surface])
            assert (during[surface] - rest).max() > 2.5 * DEG
            assert (during[surface] - rest).min() < -2.5 * DEG


def test_fuel_burns_off(short_flight: VirtualFlight) -> None:
    truth, mass = short_flight.truth, load_aircraft("b777").mass
    burned = truth["mass"][0] - truth["mass"][-1]
    assert burned == pytest.approx(truth["fuel"][0] - truth["fuel"][-1])
    running = np.sum(truth["rpm_left"] > 500.0) * 0.01
    assert mass.fuel_flow_idle * running * 0.9 < burned < mass.fuel_flow_full * running


def test_one_seed_is_one_flight_however_it_is_cut() -> None:
    whole = _under_way().advance(600)
    other = _under_way(seed=4).advance(600)
    pieces: list[FlightSimulation] = [_under_way()]
    parts = [pieces[0].advance(count) for count in (1, 2, 7, 190, 400)]
    for name in ("truth", "volts", "onboard"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(joined, getattr(whole, name)), name
    assert not np.array_equal(whole.volts, other.volts)


@pytest.mark.long
def test_a_gusty_day_ends_well_too() -> None:
    flight = simulate_flight("short", seed=11, turbulence=1.0)
    assert not flight.crashed
    assert flight.phases[-1][0] == "engines off"
    assert len(flight.maneuvers) == 2


def test_a_hidden_effect_changes_what_it_is_about_and_nothing_else() -> None:
    plain = _under_way().advance(2000)
    scaled = _under_way(hide=("sensor.alpha.scale:scale=1.5",)).advance(2000)
    assert np.array_equal(plain.truth, scaled.truth)
    vane = 5
    assert np.abs(plain.volts[:, vane] - scaled.volts[:, vane]).max() > 0.05
    others = [column for column in range(20) if column != vane]
    assert np.array_equal(plain.volts[:, others], scaled.volts[:, others])
    bent = _under_way(hide=("aero.Cm.alpha2:Cm_alpha2=-2.0",)).advance(2000)
    assert not np.array_equal(plain.truth, bent.truth)


@pytest.mark.parametrize(
    ("hide", "error", "words"),
    [
        ("aero.Cm.alfa2", UnknownNameError, "alpha2"),
        ("aero.Cm.alpha2:size=3", UnknownNameError, "size"),
        ("aero.Cm.alpha2:Cm_alpha2=much", FlightError, "PARAM=VALUE"),
    ],
)
def test_a_wrong_effect_gets_one_sentence(hide: str, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        _under_way(hide=(hide,))


@pytest.mark.parametrize(
    ("derivatives", "words"),
    [
        ({"CN_alpha": 0.0, "CN_0": 0.0}, "CN_alpha is zero"),
        ({"Cl_da": -0.4}, "Cl_da = -0.4 appears reversed"),
    ],
)
def test_an_unflyable_aircraft_is_not_flown(derivatives: dict[str, float], words: str) -> None:
    model = load_model("b777").with_derivatives(derivatives)
    with pytest.raises(FlightError, match=words):
        _under_way(model=model)


class _Still:
    """Hands that do nothing for a second."""

    phase = "waiting"

    def __init__(self) -> None:
        self.count = 0

    @property
    def finished(self) -> bool:
        return self.count >= 100

    def move(self, _: object) -> object:
        from gsapp.virtual.sticks import StickPositions

        self.count += 1
        return StickPositions(brake=1.0, roll=0.5)


def test_other_hands_can_take_the_sticks() -> None:
    flight = _under_way(hands=lambda *_: _Still())
    stretch = flight.advance(1000)
    assert len(stretch) == 100
    assert flight.finished
    phases: Sequence[str] = stretch.phases
    assert set(phases) == {"waiting"}
    assert stretch.onboard[-1][stretch.onboard_names.index("servo_aileron")] == pytest.approx(0.4)


def test_the_default_plan_is_a_flight_of_the_crew() -> None:
    plan = load_flight_plan("default")
    assert plan.engines.running == 80.0
    throttles = {run_up.throttle for run_up in plan.engines.run_ups}
    assert {0.0, 0.5, 1.0} <= throttles
    assert 1 <= len(plan.range_check.pulses) <= 2
    assert 9 <= len(plan.maneuvers) <= 13
    flown = {maneuver.inputs for maneuver in plan.maneuvers}
    assert {("de",), ("da",), ("dr",), ("da", "dr")} <= flown
    assert plan.pattern.leg == 10.0


def test_every_mistake_in_a_plan_is_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(
        'name = "x"\n[pattern]\nheight = "260 kg"\nhight = 3\n'
        '[[maneuvers]]\ninputs = ["da", "dr"]\nstick = [0.3]\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        load_flight_plan(path)
    text = str(caught.value)
    assert "pattern.height" in text
    assert "hight" in text
    assert "'height'" in text
    assert "maneuvers[0]" in text
    assert "2 inputs and 1 sizes" in text


def test_an_unknown_plan_names_the_shipped_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"default.*short"):
        load_flight_plan("defualt")


def _input(maneuver: PlannedManeuver, seed: int) -> StickInput:
    return StickInput(maneuver, FlightPlan().human, np.random.default_rng(seed))


def test_inputs_vary_as_a_hand_does_and_repeat_with_the_seed() -> None:
    maneuver = PlannedManeuver.model_validate({"inputs": ["de"], "stick": [0.3], "step": "0.4 s"})
    one, again, other = _input(maneuver, 1), _input(maneuver, 1), _input(maneuver, 2)
    times = np.arange(0.0, 2.0, 0.01)
    sticks = [[stick.at(time)["de"] for time in times] for stick in (one, again, other)]
    assert sticks[0] == sticks[1]
    assert sticks[0] != sticks[2]
    assert max(sticks[0]) > 0.15
    assert min(sticks[0]) < -0.15
    assert abs(sticks[0][-1]) < 0.06, "the stick comes back, nearly"
    assert one.duration != other.duration


def test_a_perfect_hand_flies_the_shape_exactly() -> None:
    perfect = PilotLimits(size_error=0.0, timing_error=0.0, residual=0.0)
    maneuver = PlannedManeuver.model_validate(
        {"inputs": ["dr"], "shape": "3-2-1-1", "stick": [0.2], "step": "0.3 s"}
    )
    stick = StickInput(maneuver, perfect, np.random.default_rng(0))
    middles = [stick.at(0.3 * number + 0.15)["dr"] for number in range(8)]
    assert middles == pytest.approx([0.2 * unit for unit in INPUT_SHAPES["3-2-1-1"]] + [0.0])
    assert stick.duration == pytest.approx(2.1)


def test_test_cards_take_the_place_of_the_maneuvers_of_a_plan() -> None:
    plan, aircraft = load_flight_plan("six"), load_aircraft("b777")
    content: dict[str, list[dict[str, object]]] = {
        "cards": [
            {"id": "E", "speed": "24 m/s", "surfaces": ["de"], "amplitude": "5 deg",
             "width": "0.5 s", "repeats": 2, "flap": "10 deg", "throttle_step": 0.2},
            {"id": "C", "speed": "30 m/s", "surfaces": ["da", "dr"],
             "amplitude": {"da": "4 deg", "dr": "30 deg"}, "width": "0.4 s", "kind": "3-2-1-1"},
        ]
    }  # fmt: skip
    flown = with_cards(plan, CardSet.model_validate(content), aircraft)
    first, second, last = flown.maneuvers
    assert first == second
    full = abs(aircraft.controls.de.full_stick_high)
    assert first.stick == pytest.approx((5.0 * DEGREE / full,))
    assert (first.speed, first.flap, first.throttle_step) == (
        24.0,
        pytest.approx(10.0 * DEGREE),
        0.2,
    )
    # No stick gives more than its all; the rudder begins as the aileron returns.
    assert last.stick[1] == 1.0
    assert last.stagger == pytest.approx(7 * 0.4)
    assert flown.pattern.leg > last.duration
    pulled = {"cards": [{**content["cards"][0], "kind": "sweep"}]}
    with pytest.raises(FlightError, match="card E: the virtual pilot flies doublet"):
        with_cards(plan, CardSet.model_validate(pulled), aircraft)


@pytest.mark.long
def test_same_seed_same_flight_and_what_is_given_is_flown() -> None:
    one, again = (fly_input(5001, surfaces=("de",), turbulence=0.4) for _ in range(2))
    np.testing.assert_array_equal(one.measured.values, again.measured.values)
    np.testing.assert_array_equal(one.truth.values, again.truth.values)
    low, high = np.searchsorted(one.truth.times, (one.t_input, one.t_let_go))
    moved = np.ptp(one.truth["de"][low:high]) / 2.0
    assert moved > 0.5 * abs(one.plan.amplitudes["de"])
    assert one.calm.times[0] == pytest.approx(one.t_input, abs=0.011)
    assert np.abs(one.calm.values[0] - one.truth.values[low]).max() < 10.0


@pytest.mark.long
def test_without_gusts_the_calm_flight_is_the_flight() -> None:
    still = fly_input(5002, turbulence=0.0)
    low = int(np.searchsorted(still.truth.times, still.calm.times[0]))
    np.testing.assert_array_equal(still.calm["q"], still.truth["q"][low : low + len(still.calm)])
    gusty = fly_input(5002, turbulence=1.0)
    low = int(np.searchsorted(gusty.truth.times, gusty.calm.times[0]))
    apart = np.abs(gusty.calm["p"] - gusty.truth["p"][low : low + len(gusty.calm)])
    assert apart[0] == 0.0
    assert apart.max() > 1.0 * DEGREE


def test_hands_off_means_that_no_surface_moves_but_those_of_the_plan() -> None:
    flown = fly_input(
        5003,
        surfaces=("dr",),
        amplitudes={"dr": 8.0 * DEGREE},
        left_over=0.0,
        meddling=(Meddling(surface="da", size=3.0 * DEGREE, at=2.2, length=0.5),),
        hands_off=4.0,
        turbulence=0.0,
        roll_rate=0.0,
        pitch_rate=0.0,
    )
    truth = flown.truth
    low, high = np.searchsorted(truth.times, (flown.t_let_go + 0.6, flown.t_hand))
    assert np.ptp(truth["de"][low:high]) < 0.2 * DEGREE
    assert np.ptp(truth["dr"][low:high]) < 0.5 * DEGREE
    whole = slice(int(np.searchsorted(truth.times, flown.t_input)), high)
    assert np.ptp(truth["da"][whole]) == pytest.approx(3.0 * DEGREE, rel=0.25)
