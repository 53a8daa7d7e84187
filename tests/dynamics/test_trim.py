"""Steady flight, its linearization, and the words for aircraft that cannot fly."""

import math

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.linearization import (
    compute_modes,
    linearize,
    linearize_lateral,
    linearize_longitudinal,
)
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import OutputModel
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


RHO = 1.225

PUBLISHED_LON = np.array(
    [[-3.8349, 0, 1.0333, 0], [-6.3432, 0, 0, -32.2], [-8.8331, 0, -4.5214, 0], [0, 0, 1, 0]]
)
PUBLISHED_LAT = np.array(
    [[0.8157, -0.0701, -1.0893, 0.3050], [-82.3277, -11.5602, 5.0121, 0],
     [19.9477, -1.4447, -2.6382, 0], [0, 1, -0.0069, 0]]
)  # fmt: skip
LEAST_SQUARES_LON = np.array([[-0.9895, 0.1755], [-2.7477, -9.1748]])
LEAST_SQUARES_LAT = np.array(
    [[3.0547, 0.3796, -0.9095], [-59.7582, -8.7077, 5.5280], [11.6, -3.6886, -9.0277]]
)


def test_modes_follow_from_the_derivatives(flight_model: FlightModel) -> None:
    """Textbook formulas from the derivatives alone, without the linearization."""
    V = 30.0
    found = trim(flight_model, V=V)
    d = flight_model.model.derivative
    geometry, mass = flight_model.aircraft.geometry, flight_model.aircraft.mass
    S, c, b = geometry.wing_area, geometry.chord, geometry.span
    qS = 0.5 * RHO * V * V * S
    alpha = found.polar.alpha
    totals = flight_model.evaluate(found.state, found.inputs)
    CN, CA, T = totals.coefficients["CN"], totals.coefficients["CA"], totals.thrust
    ca, sa = math.cos(alpha), math.sin(alpha)

    # Longitudinal: V, alpha, q, theta in level flight, term by term.
    m, g = mass.mass, 9.80665
    X, Z = totals.loads.X, totals.loads.Z
    T_V = -T / (flight_model.aircraft.propulsion.zero_thrust_speed - V)
    height = flight_model.aircraft.propulsion.position[0][2]
    X_V, Z_V = T_V - 2 * qS * CA / V, -2 * qS * CN / V
    X_a, Z_a = -qS * d("CA_alpha"), -qS * d("CN_alpha")
    X_q, Z_q = (-qS * d(f"{name}_q") * c / (2 * V) for name in ("CA", "CN"))
    M_V = (2 * qS * c * totals.coefficients["Cm"] / V + height * T_V) / mass.iyy
    M_a, M_q = qS * c * d("Cm_alpha") / mass.iyy, qS * c * d("Cm_q") * c / (2 * V) / mass.iyy
    lon = np.array([
        [(ca * X_V + sa * Z_V) / m, (ca * Z - sa * X + ca * X_a + sa * Z_a) / m + g,
         (ca * X_q + sa * Z_q) / m, -g],
        [(ca * Z_V - sa * X_V) / (m * V) - (ca * Z - sa * X) / (m * V * V) - g / V**2,
         (ca * Z_a - sa * X_a - sa * Z - ca * X) / (m * V), 1 + (ca * Z_q - sa * X_q) / (m * V), 0],
        [M_V, M_a, M_q, 0],
        [0, 0, 1, 0],
    ])  # fmt: skip
    wanted = {mode.name: mode.pole for mode in compute_modes(lon, ("V", "alpha", "q", "theta"))}
    found_poles = {
        mode.name: mode.pole for mode in linearize_longitudinal(flight_model, found).modes()
    }
    assert set(found_poles) == {"short period", "phugoid"}
    for name, pole in wanted.items():
        assert found_poles[name] == pytest.approx(pole, rel=1e-6, abs=1e-9), name
    # And the textbook's short period: two equations at constant speed.
    frequency = math.sqrt(lon[1, 1] * M_q - M_a * lon[1, 2])
    short = found_poles["short period"]
    assert abs(short) == pytest.approx(frequency, rel=0.02)
    assert -short.real == pytest.approx(-0.5 * (lon[1, 1] + M_q), rel=0.02)

    # Dutch roll, roll and spiral: the quartic of beta, p, r, phi from the derivatives.
    G = mass.ixx * mass.izz - mass.ixz**2
    arms = {"beta": 1.0, "p": b / (2 * V), "r": b / (2 * V)}
    A = np.zeros((4, 4))
    for k, name in enumerate(("beta", "p", "r")):
        roll, yaw = (qS * b * arms[name] * d(f"{x}_{name}") for x in ("Cl", "Cn"))
        A[1, k] = (mass.izz * roll + mass.ixz * yaw) / G
        A[2, k] = (mass.ixz * roll + mass.ixx * yaw) / G
        A[0, k] = qS * arms[name] * d(f"CY_{name}") / (mass.mass * V)
    # Side force, and what drag, thrust and gravity add along the tilted axes.
    A[0, 0] += (qS * (CA * ca + CN * sa) - T * ca) / (mass.mass * V)
    A[0, 0] -= 9.80665 / V * (math.cos(found.polar.theta) * sa - math.sin(found.polar.theta) * ca)
    A[0, 1] += sa
    A[0, 2] -= ca
    A[0, 3] = 9.80665 * math.cos(found.polar.theta) / V
    A[3, 1], A[3, 2] = 1.0, math.tan(found.polar.theta)
    expected = {mode.name: mode.pole for mode in compute_modes(A, ("beta", "p", "r", "phi"))}
    numeric = {mode.name: mode.pole for mode in linearize_lateral(flight_model, found).modes()}
    assert set(numeric) == {"roll", "dutch roll", "spiral"}
    for name, pole in expected.items():
        assert numeric[name] == pytest.approx(pole, rel=1e-6, abs=1e-9), name


def test_published_longitudinal_matrix(flight_model: FlightModel) -> None:
    A = linearize_longitudinal(flight_model, trim(flight_model, V=93.24 * FT)).A
    for row, column in ((0, 0), (2, 0), (2, 2)):
        assert A[row, column] == pytest.approx(PUBLISHED_LON[row, column], rel=5e-3)
    # The source's Z_q has the wrong sign (notes, section 5): ours lies as far on the other side.
    assert 1.0 - A[0, 2] == pytest.approx(PUBLISHED_LON[0, 2] - 1.0, rel=0.05)
    B = linearize_longitudinal(flight_model, trim(flight_model, V=93.24 * FT)).B
    assert B[0, 0] == pytest.approx(-0.3279, rel=0.01)
    assert B[2, 0] == pytest.approx(-28.7463, rel=0.01)


def test_published_lateral_matrix(flight_model: FlightModel) -> None:
    found = linearize_lateral(flight_model, trim(flight_model, V=105.58 * FT))
    assert np.allclose(found.A[1:3, :3], PUBLISHED_LAT[1:3, :3], rtol=3e-3)
    assert np.allclose(found.B[1], [102.0631, 2.5918], rtol=3e-3)
    assert np.allclose(found.B[2], [5.5099, -12.6008], rtol=3e-3)


def test_published_modes_and_how_far_ours_agree(flight_model: FlightModel) -> None:
    lon = {m.name: m for m in compute_modes(PUBLISHED_LON, ("alpha", "V", "q", "theta"))}
    assert lon["short period"].pole == pytest.approx(-4.178 + 3.002j, abs=2e-3)
    lat = {m.name: m for m in compute_modes(PUBLISHED_LAT, ("beta", "p", "r", "phi"))}
    assert lat["roll"].pole.real == pytest.approx(-12.36, abs=0.01)
    assert lat["dutch roll"].pole == pytest.approx(-0.462 + 5.399j, abs=2e-3)
    assert lat["spiral"].pole.real == pytest.approx(-0.101, abs=2e-3)

    ours = {
        m.name: m
        for m in linearize_longitudinal(flight_model, trim(flight_model, V=93.24 * FT)).modes()
    }
    assert ours["short period"].frequency == pytest.approx(lon["short period"].frequency, rel=0.02)
    assert ours["short period"].damping == pytest.approx(lon["short period"].damping, rel=0.03)
    theirs = lat
    ours = {
        m.name: m
        for m in linearize_lateral(flight_model, trim(flight_model, V=105.58 * FT)).modes()
    }
    assert ours["roll"].pole.real == pytest.approx(theirs["roll"].pole.real, rel=0.07)
    assert ours["dutch roll"].frequency == pytest.approx(theirs["dutch roll"].frequency, rel=0.08)
    # The source's positive C_Y_beta takes damping away from its Dutch roll.
    assert ours["dutch roll"].damping > 2.5 * theirs["dutch roll"].damping


def test_least_squares_modes_are_named() -> None:
    fast, slow = compute_modes(LEAST_SQUARES_LON, ("alpha", "q"))
    assert (fast.name, slow.name) == ("short period, fast", "short period, slow")
    assert (fast.pole.real, slow.pole.real) == pytest.approx((-9.116, -1.049), abs=2e-3)
    found = {mode.name: mode.pole for mode in compute_modes(LEAST_SQUARES_LAT, ("beta", "p", "r"))}
    assert found["roll"].real == pytest.approx(-7.016, abs=2e-3)
    assert found["dutch roll"] == pytest.approx(-3.833 + 3.098j, abs=2e-3)


def test_numbers_of_a_mode() -> None:
    (mode,) = compute_modes(np.array([[0.0, 1.0], [-25.0, -2.0]]), ("a", "b"))
    assert mode.name == "pair"
    assert mode.frequency == pytest.approx(5.0)
    assert mode.damping == pytest.approx(0.2)
    assert mode.time_constant == pytest.approx(1.0)
    assert mode.period == pytest.approx(2 * math.pi / math.sqrt(24.0))
    growing, zero = compute_modes(np.diag([0.5, 0.0]), ("a", "b"))
    assert growing.damping == -1.0
    assert growing.time_constant == pytest.approx(-2.0)
    assert math.isnan(zero.damping)
    assert math.isinf(zero.time_constant)


def test_outputs_of_the_linear_model(flight_model: FlightModel) -> None:
    found = trim(flight_model, V=29.0)
    linear = linearize(flight_model, found, outputs=("alpha", "an", "ax", "q"))
    outputs = OutputModel(flight_model, linear.outputs)
    before = np.array(outputs.values(found.state, found.inputs))
    dx = np.zeros(9)
    dx[[0, 1, 4]] = 0.01, 0.001, 0.002
    du = np.zeros(8)
    du[0] = 0.001
    after = np.array(outputs.values(np.add(found.state, dx).tolist(),
                                    np.add(found.inputs, du).tolist()))  # fmt: skip
    assert np.allclose(linear.C @ dx + linear.D @ du, after - before, rtol=5e-3, atol=1e-5)
