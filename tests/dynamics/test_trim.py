"""Steady flight, and the words for aircraft that cannot fly."""

import math

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import find_suspect_signs, find_unflyable_reasons, trim
from gsapp.foundation import FlightError

FT = 0.3048
DEG = math.pi / 180.0


@pytest.mark.parametrize("speed", [80.0, 95.0, 120.0])
def test_level_flight_at_the_test_speeds(flight_model: FlightModel, speed: float) -> None:
    found = trim(flight_model, V=speed * FT)
    rates = flight_model.rates(found.state, found.inputs)
    assert np.abs(rates[:8]).max() < 1e-7
    assert 2.0 < found.polar.alpha / DEG < 8.0
    assert abs(found.controls["de"]) < 2.0 * DEG
    assert 0.3 < found.controls["throttle"] < 0.95
    assert found.polar.theta == pytest.approx(found.polar.alpha, abs=1e-7)


def test_full_throttle_gives_120_to_140_feet_per_second(flight_model: FlightModel) -> None:
    assert trim(flight_model, V=120.0 * FT).controls["throttle"] < 1.0
    with pytest.raises(FlightError, match="throttle"):
        trim(flight_model, V=141.0 * FT)


def test_climb_needs_power_and_descent_gives_it_back(flight_model: FlightModel) -> None:
    level, up, down = (
        trim(flight_model, V=29.0, climb_angle=angle).controls["throttle"]
        for angle in (0.0, 4.0 * DEG, -4.0 * DEG)
    )
    assert down < level < up
    # Weight times the sine of the angle is what thrust must add.
    found = trim(flight_model, V=29.0, climb_angle=4.0 * DEG)
    earth = -found.polar.theta + found.polar.alpha
    assert earth == pytest.approx(-4.0 * DEG, abs=1e-6)


@pytest.mark.parametrize("bank", [30.0 * DEG, -45.0 * DEG])
def test_coordinated_turn(flight_model: FlightModel, bank: float) -> None:
    found = trim(flight_model, V=31.0, bank=bank)
    rates = flight_model.rates(found.state, found.inputs)
    assert np.abs(rates[:8]).max() < 1e-7
    assert rates[8] == pytest.approx(found.turn_rate)
    assert found.turn_rate == pytest.approx(9.80665 * math.tan(bank) / 31.0, rel=0.05)
    totals = flight_model.evaluate(found.state, found.inputs)
    assert pytest.approx(0.0, abs=1e-6) == totals.loads.Y
    assert found.polar.phi == bank


@pytest.mark.parametrize("bank", [0.0, 30.0 * DEG])
def test_a_flying_wing_is_flown_without_a_rudder(
    aircraft: Aircraft, model: Model, bank: float
) -> None:
    none = dict.fromkeys(("CY_dr", "Cl_dr", "Cn_dr"), 0.0)
    wing = FlightModel(aircraft, model.with_derivatives({**none, "Cn_0": 1e-3}))
    found = trim(wing, V=31.0, bank=bank)
    assert np.abs(wing.rates(found.state, found.inputs)[:8]).max() < 1e-7
    assert found.controls["dr"] == 0.0
    assert abs(found.polar.beta) > 0.2 * DEG
    assert found.polar.phi == bank if bank else found.turn_rate == 0.0


def test_effects_take_part(aircraft: Aircraft, model: Model) -> None:
    uneven = FlightModel(aircraft, model.with_effect("propulsion.Cn.asymmetry"))
    found = trim(uneven, V=29.0)
    assert abs(found.controls["dr"]) > 0.5 * DEG
    assert found.turn_rate == 0.0
    assert np.abs(uneven.rates(found.state, found.inputs)[:8]).max() < 1e-7


def test_states_of_effects_are_settled(aircraft: Aircraft, model: Model) -> None:
    lagged = FlightModel(aircraft, model.with_effect("aero.Cm.memory"))
    found = trim(lagged, V=29.0)
    assert found.state[9] == pytest.approx(found.polar.alpha)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"Cm_de": 1.1}, "Cm_de = 1.1 appears reversed"),
        ({"Cm_de": 0.0}, "Cm_de is zero or missing"),
        ({"CN_alpha": -4.4}, "the wing must lift more"),
        ({"Cl_da": -0.4}, "Cl_da = -0.4 appears reversed"),
        ({"Cn_dr": 0.07}, "rudder trailing edge left"),
        ({"Cn_dr": 0.0}, "Cn_dr is zero or missing"),
        ({"CA_0": 0.2}, "thrust is too small or CA too large"),
        ({"Cm_0": 0.9}, "elevator, beyond its travel"),
    ],
)
def test_what_is_wrong_is_named(
    aircraft: Aircraft, model: Model, change: dict[str, float], says: str
) -> None:
    with pytest.raises(FlightError) as caught:
        trim(FlightModel(aircraft, model.with_derivatives(change)), V=29.0)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_thrust_is_named(aircraft: Aircraft, model: Model) -> None:
    glider = aircraft.model_copy(
        update={"propulsion": aircraft.propulsion.model_copy(update={"max_thrust": 0.0})}
    )
    with pytest.raises(FlightError, match=r"no thrust.*propulsion\.max_thrust"):
        trim(FlightModel(glider, model), V=29.0)


def test_too_slow_is_beyond_the_stall(flight_model: FlightModel) -> None:
    with pytest.raises(FlightError, match="beyond the stall"):
        trim(flight_model, V=50.0 * FT)


def test_all_faults_at_once(aircraft: Aircraft, model: Model) -> None:
    broken = model.with_derivatives({"Cm_de": 1.0, "Cn_dr": 1.0})
    assert len(find_unflyable_reasons(aircraft, broken)) == 2
    assert find_unflyable_reasons(aircraft, model) == []


def test_doubtful_signs(model: Model) -> None:
    assert find_suspect_signs(model) == []
    assert "Cm_alpha" in find_suspect_signs(model.with_derivatives({"Cm_alpha": 0.3}))[0]
