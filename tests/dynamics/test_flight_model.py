"""Model and aircraft put together: exact Jacobians with every effect at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.arithmetic import Dual
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.sensors import OUTPUTS, OutputModel
from gsapp.dynamics.terms import TARGETS, Monomial, Parameter, create_term, effect_ids
from gsapp.foundation import FlightError, UnknownNameError


def with_every_effect() -> FlightModel:
    model = load_model("b777")
    aircraft = load_aircraft("b777")
    for name in effect_ids():
        if create_term(name, aircraft).target in TARGETS or name == "sensor.p_r.swapped":
            model = model.with_effect(name)
    return FlightModel(aircraft, model)


FULL = with_every_effect()
N_STATES = len(FULL.state_names)


def point(seed: int, count: int) -> list[np.ndarray]:
    random = np.random.default_rng(seed)

    def near(mean: float, spread: float) -> np.ndarray:
        return mean + spread * random.standard_normal(count)

    state = [near(32.0, 3.0), *(near(0.05, 0.12) for _ in range(N_STATES - 1))]
    inputs = [
        *(near(0.0, 0.15) for _ in range(4)), near(0.5, 0.1), near(0.0, 0.1), near(1.15, 0.05),
        near(21.0, 0.3),
    ]  # fmt: skip
    return [*state, *inputs, *(np.full(count, x) for x in FULL.defaults)]


def split(x: list) -> tuple[list, list, list]:
    cut = N_STATES + len(MODEL_INPUTS)
    return x[:N_STATES], x[N_STATES:cut], x[cut:]


@given(st.integers(0, 2**31))
@settings(deadline=None, max_examples=2)
def test_jacobians_equal_differences(seed: int) -> None:
    x = point(seed, 3)
    outputs = OutputModel(FULL, OUTPUTS)
    values, slopes, differential = outputs.jacobian(*split(x))
    assert np.allclose(values, np.stack(outputs.values(*split(x)), axis=-1), rtol=1e-13, atol=1e-13)

    def everything(x: list) -> np.ndarray:
        rates, totals = FULL.rates(*split(x)), FULL.evaluate(*split(x))
        parts = [*rates, *outputs.values(*split(x)), *totals.loads, *totals.coefficients.values()]
        return np.array(np.broadcast_arrays(*parts)).T

    exact = np.concatenate(
        [differential.rates, slopes, differential.loads, differential.coefficients], axis=1
    )
    for column in range(len(x)):
        h = 2e-6 * max(1.0, float(np.abs(x[column]).max()))
        up, down = list(x), list(x)
        up[column], down[column] = x[column] + h, x[column] - h
        numeric = (everything(up) - everything(down)) / (2 * h)
        error = np.abs(exact[:, :, column] - numeric) / (1.0 + np.abs(numeric))
        # Stall terms have a corner of the second derivative at the ends of the linear range.
        assert error.max() < 2e-5


def test_derivatives_by_chosen_parameters_only() -> None:
    x = point(5, 3)
    outputs = OutputModel(FULL, ("alpha", "an", "q"))
    _, whole, one = outputs.jacobian(*split(x))
    free = ("Cm_q", "mass.cg.x.x", "CN_alpha")
    _, part, two = outputs.jacobian(*split(x), free=free)
    first = N_STATES + len(MODEL_INPUTS)
    columns = [*range(first), *(first + FULL.parameter_names.index(name) for name in free)]
    assert np.allclose(part, whole[:, :, columns], rtol=1e-13, atol=1e-13)
    assert np.allclose(two.rates, one.rates[:, :, columns], rtol=1e-13, atol=1e-13)
    assert [block.shape[-1] for block in two.split(two.rates)] == [N_STATES, len(MODEL_INPUTS), 3]
    with pytest.raises(UnknownNameError, match="Cm_alfa"):
        FULL.differentiate(*split(x), free=("Cm_alfa",))


def test_single_numbers_give_what_arrays_give() -> None:
    x = point(11, 4)
    together = np.array(np.broadcast_arrays(*FULL.rates(*split(x))))
    for k in range(4):
        single = FULL.rates(*split([float(column[k]) for column in x]))
        assert all(isinstance(rate, float) for rate in single)
        assert np.allclose(together[:, k], single, rtol=1e-12, atol=1e-12)


def test_cg_effect_moves_the_moments(aircraft: Aircraft, model: Model) -> None:
    """A CG further forward by x adds -x Z... = x qS C_N nose down, and turns C_Y into yaw."""
    ahead = FlightModel(aircraft, model.with_effect("mass.cg.x", {"x": 0.03}))
    here = FlightModel(aircraft, model)
    state = (30.0, 0.08, 0.05, 0.1, 0.1, 0.1, 0.0, 0.1, 0.0)
    inputs = (0.02, 0.0, 0.1, 0.0, 0.4, 0.0, 1.2, 21.0)
    a, b = ahead.evaluate(state, inputs).loads, here.evaluate(state, inputs).loads
    assert a[:3] == b[:3]
    assert pytest.approx(0.03 * b.Z) == a.M - b.M
    assert pytest.approx(-0.03 * b.Y) == a.N - b.N
    assert b.Z < 0.0


def test_engines_act_at_their_places(flight_model: FlightModel, aircraft: Aircraft) -> None:
    state = (30.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.05, 0.0)

    def loads(throttle: float, difference: float):
        inputs = (0.0, 0.0, 0.0, 0.0, throttle, difference, 1.225, 21.0)
        return flight_model.evaluate(state, inputs)

    idle, even, uneven = loads(0.0, 0.0), loads(0.5, 0.0), loads(0.5, 0.2)
    height = aircraft.propulsion.position[0][2]
    assert pytest.approx(height * even.thrust) == even.loads.M - idle.loads.M
    left = uneven.thrust * 0.7 / 0.5 / 2.0
    right = uneven.thrust * 0.3 / 0.5 / 2.0
    y = aircraft.propulsion.position[1][1]
    assert pytest.approx(y * (left - right)) == uneven.loads.N - even.loads.N
    assert uneven.thrust == pytest.approx(even.thrust)


def test_throttle_effect_is_strong_at_low_speed(aircraft: Aircraft, model: Model) -> None:
    changed = FlightModel(aircraft, model.with_effect("propulsion.Cm.throttle", {"arm": 0.05}))
    plain = FlightModel(aircraft, model)

    def share(V: float) -> float:
        state = (V, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.05, 0.0)
        inputs = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.225, 21.0)
        extra = changed.evaluate(state, inputs).loads.M - plain.evaluate(state, inputs).loads.M
        return extra / (0.5 * 1.225 * V * V)

    assert share(20.0) > 3.0 * share(40.0) > 0.0


def test_alpha_dot_effect_uses_the_true_rate(aircraft: Aircraft, model: Model) -> None:
    changed = FlightModel(aircraft, model.with_effect("aero.Cm.alphadot", {"Cm_alphadot": -8.0}))
    state = (30.0, 0.1, 0.03, 0.1, 0.3, 0.1, 0.2, 0.1, 0.0)
    inputs = (0.02, 0.0, 0.1, 0.0, 0.4, 0.0, 1.2, 21.0)
    rates = changed.rates(state, inputs)
    plain = FlightModel(aircraft, model).evaluate(state, inputs).coefficients["Cm"]
    found = changed.evaluate(state, inputs).coefficients["Cm"] - plain
    assert found == pytest.approx(-8.0 * rates[1] * changed.chord / 60.0)


def test_a_force_may_not_read_what_it_decides(aircraft: Aircraft, model: Model) -> None:
    loop = Monomial(
        id="aero.CN.alphadot", title="x", equation="x = 1", target="CN",
        reads=("alpha_dot_hat",), powers=(1,),
        parameters=(
            Parameter(name="k", unit="", default=1.0, bounds=(-9.0, 9.0), description="size"),
        ),
    )  # fmt: skip
    with pytest.raises(FlightError, match=r"aero\.CN\.memory"):
        FlightModel(aircraft, model, extra=[loop])


def test_unknown_output_is_refused(flight_model: FlightModel) -> None:
    with pytest.raises(UnknownNameError, match="flap"):
        OutputModel(flight_model, ["alpha", "flap"])


def test_resting_states_do_not_move(aircraft: Aircraft, model: Model) -> None:
    lagged = FlightModel(aircraft, model.with_effect("aero.Cm.memory"))
    state = (30.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0)
    inputs = (0.0, 0.0, 0.0, 0.0, 0.4, 0.0, 1.2, 21.0)
    settled = lagged.steady_states(state, inputs)
    assert settled == (0.1,)
    assert lagged.rates((*state, *settled), inputs)[9] == 0.0


@given(st.floats(-2.0, 2.0), st.floats(0.2, 2.0))
@settings(deadline=None, max_examples=30)
def test_numbers_with_derivatives(a: float, b: float) -> None:
    """The chain rule of `Dual`, against differences of the same formula."""

    def formula(x, y, m):
        return (
            m.atan2(x * y - 1.0, 2.0 / y) + m.sqrt(y) * m.sin(x) - (3.0 - x) * m.cos(-y) / (1 + y)
        )

    x = Dual(np.array([a]), np.array([[1.0, 0.0]]))
    y = Dual(np.array([b]), np.array([[0.0, 1.0]]))
    found = formula(x, y, Dual)
    h = 1e-6
    numeric = [
        (formula(a + h, b, np) - formula(a - h, b, np)) / (2 * h),
        (formula(a, b + h, np) - formula(a, b - h, np)) / (2 * h),
    ]
    assert found.value[0] == pytest.approx(formula(a, b, np))
    assert np.allclose(found.derivative[0], numeric, rtol=1e-6, atol=1e-6)


def test_asymmetry_is_a_share_of_the_thrust(aircraft: Aircraft, model: Model) -> None:
    term = create_term("propulsion.Cn.asymmetry", aircraft)
    y = aircraft.propulsion.position[1][1]
    assert term.value((100.0,), (), (0.2,)) == pytest.approx(0.2 * y * 100.0)


def test_states_of_terms_settle_where_their_rates_vanish() -> None:
    """Also of a term that reads the thrust, which is known only once it is summed."""
    model = FlightModel(
        load_aircraft("b777"),
        load_model("b777").with_effect("propulsion.thrust.lag").with_effect("aero.Cm.memory"),
    )
    state = (30.0, 0.08, 0.0, 0.0, 0.1, 0.0, 0.0, 0.05, 0.0)
    inputs = (0.0, 0.0, 0.0, 0.0, 0.6, 0.0, 1.2, 21.0)
    rest = model.steady_states(state, inputs)
    totals = model.evaluate((*state, *rest), inputs)
    assert totals.term_rates == (0.0, 0.0)
    assert rest[0] == pytest.approx(totals.thrust)
    assert totals.thrust > 20.0
