"""The equations of motion: against each other, the source's mended form, and JSBSim."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gsapp.dynamics.equations import (
    POLAR_STATES,
    Loads,
    PolarState,
    RigidBody,
    angular_accelerations,
    attitude_rates,
    body_from_polar,
    body_rates,
    body_to_earth_matrix,
    euler_from_quaternion,
    polar_jacobian,
    polar_rates,
    quaternion_from_euler,
    quaternion_rates,
)
from gsapp.quantities.constants import GRAVITY

B777 = RigidBody(mass=21.16, ixx=7.05, iyy=8.60, izz=9.45, ixz=0.38)

angles = st.floats(-1.0, 1.0)
speeds = st.floats(10.0, 60.0)
rates = st.floats(-2.0, 2.0)
forces = st.floats(-300.0, 300.0)
moments = st.floats(-60.0, 60.0)
states = st.builds(
    PolarState, speeds, angles, angles, rates, rates, rates, angles, angles, st.floats(-3.0, 3.0)
)
loads = st.builds(Loads, forces, forces, forces, moments, moments, moments)


def loads_at(time: float) -> Loads:
    s = math.sin(2.0 * time)
    return Loads(60 + 20 * s, 15 * s, -210 + 40 * s, 1.5 * s, 0.8 * math.cos(3 * time), -s)


def test_polar_form_agrees_with_an_integration_of_u_v_w() -> None:
    start = PolarState(30.0, 0.08, 0.05, 0.3, -0.1, 0.2, 0.4, 0.1, 0.5)

    def polar(time: float, x: np.ndarray) -> list[float]:
        return [float(v) for v in polar_rates(PolarState(*x.tolist()), loads_at(time), B777)]

    def body(time: float, x: np.ndarray) -> list[float]:
        u, v, w, p, q, r, e0, e1, e2, e3 = x.tolist()
        load = loads_at(time)
        matrix = body_to_earth_matrix((e0, e1, e2, e3))
        gravity = tuple(GRAVITY * part for part in matrix[6:])
        return [
            *body_rates((u, v, w), (p, q, r), load[:3], gravity, B777.mass),
            *angular_accelerations(p, q, r, *load[3:], B777),
            *quaternion_rates((e0, e1, e2, e3), p, q, r),
        ]

    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    one = solve_ivp(polar, (0.0, 3.0), start, **exact).y[:, -1]
    begin = [*body_from_polar(*start[:3]), *start[3:6], *quaternion_from_euler(*start[6:])]
    two = solve_ivp(body, (0.0, 3.0), begin, **exact).y[:, -1]
    u, v, w = two[:3].tolist()
    V, alpha, beta = math.hypot(u, v, w), math.atan2(w, u), math.atan2(v, math.hypot(u, w))
    attitude = two[6:] / np.linalg.norm(two[6:])
    phi, theta, psi = euler_from_quaternion(tuple(attitude.tolist()))
    turn = round((one[8] - psi) / (2 * math.pi)) * 2 * math.pi
    assert np.abs(one - [V, alpha, beta, *two[3:6], phi, theta, psi + turn]).max() < 1e-10


@given(states, loads)
@settings(deadline=None, max_examples=50)
def test_flow_rates_are_the_mended_equations_of_the_source(state: PolarState, load: Loads) -> None:
    """(4.1.15)-(4.1.17) with thrust, written out as in the notes."""
    V, a, b, p, q, r, phi, th, _ = state
    m, g, S, qbar, thrust = B777.mass, GRAVITY, 1.05, 500.0, 50.0
    CA, CY, CN = -(load.X - thrust) / (qbar * S), load.Y / (qbar * S), -load.Z / (qbar * S)
    sin, cos, tan = math.sin, math.cos, math.tan
    CL, CD = CN * cos(a) - CA * sin(a), CA * cos(a) + CN * sin(a)
    CDw, CYw = CD * cos(b) - CY * sin(b), CY * cos(b) + CD * sin(b)
    V_dot = (
        -qbar * S / m * CDw
        + g * (cos(phi) * cos(th) * sin(a) * cos(b) + sin(phi) * cos(th) * sin(b)
               - sin(th) * cos(a) * cos(b))
        + thrust / m * cos(a) * cos(b)
    )  # fmt: skip
    alpha_dot = (
        q - tan(b) * (p * cos(a) + r * sin(a)) - qbar * S / (m * V * cos(b)) * CL
        + g / (V * cos(b)) * (cos(th) * cos(phi) * cos(a) + sin(th) * sin(a))
        - thrust * sin(a) / (m * V * cos(b))
    )  # fmt: skip
    beta_dot = (
        p * sin(a) - r * cos(a) + qbar * S / (m * V) * CYw + g / V * cos(b) * cos(th) * sin(phi)
        - sin(b) / V * (g * cos(th) * cos(phi) * sin(a) - g * sin(th) * cos(a)
                        + thrust / m * cos(a))
    )  # fmt: skip
    found = polar_rates(state, load, B777)
    assert found[:3] == pytest.approx((V_dot, alpha_dot, beta_dot), rel=1e-10, abs=1e-10)


@given(st.lists(st.tuples(states, loads), min_size=3, max_size=3))
@settings(deadline=None, max_examples=30)
def test_arrays_give_what_single_numbers_give(cases: list[tuple[PolarState, Loads]]) -> None:
    state = PolarState(*np.array([case[0] for case in cases]).T)
    load = Loads(*np.array([case[1] for case in cases]).T)
    together = np.array(polar_rates(state, load, B777)).T
    single = np.array([polar_rates(*case, B777) for case in cases])
    assert np.allclose(together, single, rtol=1e-12, atol=1e-12)


@given(states, loads)
@settings(deadline=None, max_examples=50)
def test_jacobian_is_that_of_complex_steps(state: PolarState, load: Loads) -> None:
    exact = polar_jacobian(state, load, B777)
    step = 1e-30j
    scale = 1e-9 * (1.0 + max(abs(x) for x in load))

    def column(state: PolarState, load: Loads, body: RigidBody) -> np.ndarray:
        rates = polar_rates(state, load, body)
        return np.array([np.imag(np.asarray(rate)[()]) for rate in rates]) / 1e-30

    complex_state = PolarState(*(np.asarray(x, dtype=complex) for x in state))
    for index, name in enumerate(POLAR_STATES):
        moved = complex_state._replace(**{name: getattr(complex_state, name) + step})
        assert np.allclose(exact.states[0, :, index], column(moved, load, B777), atol=scale)
    for index, name in enumerate(Loads._fields):
        pushed = load._replace(**{name: getattr(load, name) + step})
        found = column(complex_state, pushed, B777)
        assert np.allclose(exact.loads[0, :, index], found, atol=scale)
    for index, name in enumerate(("mass", "ixx", "iyy", "izz", "ixz")):
        values = {key: getattr(B777, key) for key in ("mass", "ixx", "iyy", "izz", "ixz")}
        heavier = RigidBody(**{**values, name: values[name] + step})
        found = column(complex_state, load, heavier)
        assert np.allclose(exact.body[0, :, index], found, atol=scale)


def test_attitude_survives_a_vertical_climb() -> None:
    attitude = np.array(quaternion_from_euler(0.1, 1.4, 0.3))
    found = solve_ivp(
        lambda _, e: quaternion_rates(tuple(e.tolist()), 0.0, 1.0, 0.0),
        (0.0, 2 * math.pi), attitude, rtol=1e-12, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    # A whole loop: the same attitude, the other sign of the quaternion.
    assert np.allclose(found, -attitude, atol=1e-9)


def test_attitude_rates_agree_with_the_quaternion() -> None:
    phi, theta, psi, p, q, r = 0.3, 0.2, 1.0, 0.4, -0.3, 0.2
    e = np.array(quaternion_from_euler(phi, theta, psi))
    d = np.array(quaternion_rates(tuple(e.tolist()), p, q, r))
    h = 1e-6
    ahead, behind = (euler_from_quaternion(tuple((e + s * h * d).tolist())) for s in (1, -1))
    numeric = (np.array(ahead) - np.array(behind)) / (2 * h)
    assert np.allclose(numeric, attitude_rates(p, q, r, phi, theta), atol=1e-8)
