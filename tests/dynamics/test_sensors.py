"""What instruments see where they sit."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import (
    OutputModel,
    accelerations_at,
    accelerations_at_cg,
    alpha_vane,
    beta_vane,
    flow_at_cg,
    velocity_at,
)

B777 = load_aircraft("b777")
small = st.floats(-0.4, 0.4)
rate = st.floats(-1.5, 1.5)


def test_accelerometer_reads_the_motion_of_its_place() -> None:
    position = np.array([0.5, -0.2, 0.1])
    rates, spin = np.array([0.4, -0.3, 0.6]), np.array([1.0, 2.0, -1.5])
    at_cg = np.array([2.0, -1.0, -9.0])
    there = at_cg + np.cross(spin, position) + np.cross(rates, np.cross(rates, position))
    ax, ay, an = accelerations_at(
        tuple(position), (at_cg[0], at_cg[1], -at_cg[2]), tuple(rates), tuple(spin)
    )
    assert np.allclose((ax, ay, -an), there)
    back = accelerations_at_cg(tuple(position), (ax, ay, an), tuple(rates), tuple(spin))
    assert np.allclose(back, (2.0, -1.0, 9.0))


def test_velocity_of_a_place() -> None:
    position, rates, flow = (1.0, 0.2, -0.3), (0.3, 0.5, -0.2), (30.0, 1.0, 2.0)
    assert np.allclose(
        velocity_at(position, flow, rates), np.array(flow) + np.cross(rates, position)
    )


def test_vane_ahead_of_the_cg_sees_less_alpha_when_pitching_up() -> None:
    """About alpha - q x/V (notes, section 7)."""
    flow = (30.0, 0.0, 2.0)
    still = alpha_vane(flow)
    moving = alpha_vane(velocity_at((1.0, 0.0, 0.0), flow, (0.0, 0.6, 0.0)))
    assert moving - still == pytest.approx(-0.6 / 30.0, rel=2e-2)


@given(small, small)
@settings(deadline=None, max_examples=30)
def test_both_kinds_of_beta_vane(alpha: float, beta: float) -> None:
    V = 30.0
    flow = (V * math.cos(alpha) * math.cos(beta), V * math.sin(beta),
            V * math.sin(alpha) * math.cos(beta))  # fmt: skip
    assert beta_vane(flow, "swivel") == pytest.approx(beta, abs=1e-12)
    flank = beta_vane(flow, "fixed")
    assert math.tan(flank) * math.cos(alpha) == pytest.approx(math.tan(beta), abs=1e-12)


@pytest.mark.parametrize("kind", ["fixed", "swivel"])
@given(st.floats(15.0, 50.0), small, small, rate, rate, rate)
@settings(deadline=None, max_examples=50)
def test_flow_at_the_cg_is_found_again(
    kind: str, V: float, alpha: float, beta: float, p: float, q: float, r: float
) -> None:
    fin = B777.sensors.beta_vane.model_copy(update={"kind": kind, "upwash": 1.1})
    aircraft = B777.model_copy(
        update={"sensors": B777.sensors.model_copy(update={"beta_vane": fin})}
    )
    model = OutputModel(FlightModel(aircraft, Model(name="none")), ("V", "alpha", "beta"))
    state = (V, alpha, beta, p, q, r, 0.0, 0.0, 0.0)
    shown = model.values(state, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.2, 21.0))
    close = 1e-11 if kind == "fixed" else 1e-7
    assert flow_at_cg(aircraft, *shown, (p, q, r)) == pytest.approx((V, alpha, beta), abs=close)
    many = flow_at_cg(aircraft, *(np.full(3, one) for one in shown), (p, q, r))
    assert np.allclose(np.stack(many, axis=1), (V, alpha, beta), rtol=0.0, atol=close)


def test_flow_slower_than_the_rates_alone_stays_a_number() -> None:
    shown = (0.0, 0.1, 0.0)
    assert np.isfinite(flow_at_cg(B777, *shown, (1.0, 1.0, 1.0))).all()
    assert np.isfinite(flow_at_cg(B777, *(np.full(2, x) for x in shown), (1.0, 1.0, 1.0))).all()


def test_predicted_accelerations_at_the_cg(aircraft: Aircraft, model: Model) -> None:
    """a_x = (T - qS C_A)/m, a_y = qS C_Y/m, a_n = qS C_N/m for an accelerometer at the CG."""
    bare = aircraft.model_copy(update={"sensors": type(aircraft.sensors)()})
    built = FlightModel(bare, model)
    state = (29.0, 0.09, 0.05, 0.2, 0.1, -0.1, 0.1, 0.05, 0.0)
    inputs = (0.02, 0.05, -0.04, 0.0, 0.6, 0.0, 1.1, 20.5)
    found = OutputModel(built, ("ax", "ay", "an", "alpha", "V")).values(state, inputs)
    totals = built.evaluate(state, inputs)
    qS = 0.5 * 1.1 * 29.0**2 * bare.geometry.wing_area
    c = totals.coefficients
    expected = ((totals.thrust - qS * c["CA"]) / 20.5, qS * c["CY"] / 20.5, qS * c["CN"] / 20.5)
    assert found[:3] == pytest.approx(expected)
    assert found[3:] == pytest.approx((0.09, 29.0))


def test_cg_effect_moves_the_instruments(aircraft: Aircraft, model: Model) -> None:
    moved = FlightModel(aircraft, model.with_effect("mass.cg.x", {"x": 0.05}))
    state = (29.0, 0.09, 0.0, 0.0, 0.5, 0.0, 0.0, 0.05, 0.0)
    inputs = (0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.2, 21.0)
    one = OutputModel(FlightModel(aircraft, model), ("alpha",)).values(state, inputs)[0]
    two = OutputModel(moved, ("alpha",)).values(state, inputs)[0]
    assert two - one == pytest.approx(0.5 * 0.05 / 29.0, rel=0.05)
