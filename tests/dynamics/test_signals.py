"""Paths of signals, and effects of instruments beyond one path: boxes, swapped, misplaced."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.actuators import reconstruct_deflection, simulate_control_path
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.sensors import (
    OUTPUTS,
    OutputModel,
    accelerations_at,
    accelerations_at_cg,
    alpha_vane,
    beta_vane,
    flow_at_cg,
    velocity_at,
)
from gsapp.dynamics.signal_terms import (
    INSTRUMENT_BOXES,
    SENSOR_CHANNELS,
    SWAPPABLE_PAIRS,
    PathResponse,
    PathTerms,
    SignalPath,
    SignalTerm,
    SwappedChannels,
    channels_of_target,
    invert_path,
    path_response,
)
from gsapp.dynamics.terms import POSITIONED_INSTRUMENTS, create_term, effect_ids
from gsapp.foundation import FlightError

B777 = load_aircraft("b777")
DT = 0.01
KINDS = [name for name in effect_ids() if name.startswith(("control.elevator.", "sensor.q."))]
TIMES = np.arange(400) * DT
WAVE = 0.2 * np.sin(4.0 * TIMES) * np.exp(-0.1 * TIMES) + 0.02


def signal_term(name: str) -> SignalTerm:
    term = create_term(name, B777)
    assert isinstance(term, SignalTerm)
    return term


def defaults(term: SignalTerm) -> tuple[float, ...]:
    return tuple(term.defaults.values())


@pytest.mark.parametrize("name", KINDS)
def test_steps_give_what_the_whole_history_gives(name: str) -> None:
    term = signal_term(name)
    path = SignalPath(((term, defaults(term)),), DT)
    stepped = [path.step(x) for x in WAVE.tolist()]
    assert np.allclose(stepped, term.respond(WAVE, DT, defaults(term)).values, atol=1e-14)


@pytest.mark.parametrize("name", KINDS)
def test_continuous_and_sampled_form_agree_on_slow_signals(name: str) -> None:
    term = signal_term(name)
    values = defaults(term)
    sampled = term.respond(WAVE, DT, values).values

    def at(time: float) -> float:
        return float(np.interp(time, TIMES, WAVE))

    if term.states:
        rest = term.steady_state((at(0.0),), values)
        solution = solve_ivp(
            lambda t, s: term.rates((at(t),), s, values), (0.0, TIMES[-1]), rest,
            t_eval=TIMES, max_step=2e-3, rtol=1e-7, atol=1e-9,
        )  # fmt: skip
        continuous = np.array([
            term.value((x,), s, values) for x, s in zip(WAVE, solution.y.T, strict=True)
        ])  # fmt: skip
    else:
        continuous = np.array([term.value((x,), (), values) for x in WAVE])
    edge = name.rpartition(".")[2] in ("backlash", "rate")
    error = np.abs(continuous - sampled)[20:].max()
    assert error < (0.012 if edge else 1.5e-3)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("factor", [1.0, 1.37])
def test_derivatives_by_the_parameters(name: str, factor: float) -> None:
    term = signal_term(name)
    values = tuple(factor * x for x in defaults(term))
    # Off the samples, so that a step of the delay does not cross one.
    values = tuple(x + 0.0031 if name.endswith("delay") else x for x in values)
    response = term.respond(WAVE, DT, values)
    for column in range(len(values)):
        h = 1e-7
        up = tuple(x + h * (k == column) for k, x in enumerate(values))
        down = tuple(x - h * (k == column) for k, x in enumerate(values))
        numeric = (term.respond(WAVE, DT, up).values - term.respond(WAVE, DT, down).values) / (
            2 * h
        )
        wrong = np.abs(response.parameters[:, column] - numeric) > 1e-5
        # At the very sample at which an edge is met, either side is right.
        assert wrong.sum() <= (3 if term.states else 0)


@given(st.integers(0, 2**31), st.sampled_from(KINDS))
@settings(deadline=None, max_examples=40)
def test_tangent_carries_changes_of_the_signal(seed: int, name: str) -> None:
    term = signal_term(name)
    random = np.random.default_rng(seed)
    signal = np.cumsum(0.03 * random.standard_normal(80))
    change = random.standard_normal((80, 2))
    response = term.respond(signal, DT, defaults(term))
    h = 1e-8
    for column in range(2):
        up = term.respond(signal + h * change[:, column], DT, defaults(term)).values
        down = term.respond(signal - h * change[:, column], DT, defaults(term)).values
        assert np.allclose(response.tangent(change)[:, column], (up - down) / (2 * h), atol=1e-5)


def test_lag_is_exact_for_a_ramp() -> None:
    """After a ramp began, output = slope (t - tau (1 - exp(-t/tau)))."""
    term = signal_term("control.elevator.lag")
    tau = 0.08
    found = term.respond(TIMES * 1.0, DT, (tau,)).values
    assert np.allclose(found, TIMES - tau * (1.0 - np.exp(-TIMES / tau)), atol=1e-13)


def test_backlash_shows_its_whole_width_between_up_and_down() -> None:
    term = signal_term("control.elevator.backlash")
    there = np.linspace(0.0, 0.3, 100)
    back = there[::-1]
    found = term.respond(np.concatenate([there, back]), DT, (0.04,)).values
    middle_up, middle_down = found[50], found[149]
    assert there[50] - middle_up == pytest.approx(0.02)
    assert middle_down - back[49] == pytest.approx(0.02)


def test_delay_of_part_of_a_sample() -> None:
    term = signal_term("sensor.q.delay")
    found = term.respond(TIMES, DT, (0.025,)).values
    assert np.allclose(found[5:], TIMES[5:] - 0.025)
    assert np.all(found[:2] == 0.0)


def test_several_terms_in_a_row() -> None:
    path = tuple(
        (signal_term(name), values)
        for name, values in (
            ("control.elevator.delay", (0.0231,)),
            ("control.elevator.lag", (0.05,)),
            ("control.elevator.backlash", (0.02,)),
        )
    )
    whole = path_response(path, WAVE, DT)
    stepping = SignalPath(path, DT)
    assert np.allclose(whole.values, [stepping.step(x) for x in WAVE.tolist()], atol=1e-14)
    assert whole.parameters.shape == (400, 3)
    for column in range(3):
        h = 1e-7
        up, down = (
            tuple((t, (v[0] + s * h * (k == column),)) for k, (t, v) in enumerate(path))
            for s in (1, -1)
        )
        numeric = (path_response(up, WAVE, DT).values - path_response(down, WAVE, DT).values) / (
            2 * h
        )
        assert (np.abs(whole.parameters[:, column] - numeric) > 1e-4).sum() <= 3


@pytest.mark.parametrize("name", ["control.elevator.lag", "sensor.q.lag"])
def test_lag_of_zero_still_has_its_derivative(name: str) -> None:
    term = signal_term(name)
    at_zero = term.respond(WAVE, DT, (0.0,))
    assert np.array_equal(at_zero.values, WAVE)
    small = 1e-4
    numeric = (term.respond(WAVE, DT, (small,)).values - WAVE) / small
    assert np.allclose(at_zero.parameters[2:-1, 0], numeric[2:-1], atol=0.05)


LONG_TIMES = np.arange(1000) * DT
HANDS = 0.02 * np.sin(2.0 * LONG_TIMES) * np.exp(-0.2 * LONG_TIMES)
WIDTH = 0.001


def path(effect: str, value: float) -> PathTerms:
    term = create_term(effect, load_aircraft("b777"))
    assert isinstance(term, SignalTerm)
    return ((term, (value,)),)


def test_noise_as_large_as_the_play_does_not_turn_it_over() -> None:
    play = path("control.elevator.backlash", WIDTH)
    ((term, values),) = play
    true = term.respond(HANDS, DT, values).values - HANDS
    record = HANDS + WIDTH * np.random.default_rng(0).standard_normal(HANDS.size)
    found = simulate_control_path(play, record, DT).values - record
    plain = term.respond(record, DT, values).values - record
    assert np.std(found - true) < WIDTH / 3.0
    assert np.std(plain - true) > WIDTH / 2.0


def test_without_noise_it_is_the_play_itself() -> None:
    play = path("control.elevator.backlash", WIDTH)
    ((term, values),) = play
    expected = term.respond(HANDS, DT, values).values
    assert np.mean(np.abs(simulate_control_path(play, HANDS, DT).values - expected)) < 0.05 * WIDTH


def test_the_tangent_is_the_change_of_the_answer() -> None:
    play = path("control.elevator.backlash", WIDTH)
    change = 1e-9 * np.cos(3.0 * LONG_TIMES)
    here = simulate_control_path(play, HANDS, DT)
    there = simulate_control_path(play, HANDS + change, DT).values
    assert here.tangent(change[:, None])[:, 0] == pytest.approx(there - here.values, abs=1e-12)


def test_other_paths_are_walked_as_they_are() -> None:
    lag = path("control.elevator.lag", 0.08)
    ((term, values),) = lag
    expected = term.respond(HANDS, DT, values)
    found = simulate_control_path(lag, HANDS, DT)
    assert np.array_equal(found.values, expected.values)
    assert np.array_equal(found.parameters, expected.parameters)


BASE = load_model("b777")
BETWEEN = slice(20, -20)
UNDONE = ("scale", "bias", "delay", "lag", "reversed")
ON_SURFACE = [name for name in effect_ids() if name.startswith("sensor.de.")]
RANDOM = np.random.default_rng(4)
STATE = tuple(np.array([30.0, 32.0]) + 0.0 if k == 0 else 0.2 * RANDOM.standard_normal(2)
              for k in range(9))  # fmt: skip
INPUTS = (0.02, -0.03, 0.05, 0.1, 0.5, 0.1, 1.2, 21.0)


# --- undone -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", UNDONE)
def test_what_a_sensor_did_to_a_surface_can_be_undone(kind: str) -> None:
    term = signal_term(f"sensor.de.{kind}")
    shown = term.respond(WAVE, DT, defaults(term)).values
    back = term.invert(shown, DT, defaults(term)).values
    assert np.abs(shown - WAVE)[BETWEEN].max() > 5e-3
    assert np.abs(back - WAVE)[BETWEEN].max() < 3e-4


@pytest.mark.parametrize("name", ON_SURFACE)
def test_derivatives_of_what_is_undone(name: str) -> None:
    term = signal_term(name)
    # Off the samples, so that a step of the delay does not cross one.
    values = tuple(x + 0.0031 if name.endswith("delay") else x for x in defaults(term))
    found = term.invert(WAVE, DT, values)
    h = 1e-7
    for column in range(len(values)):
        up, down = (tuple(x + s * h * (k == column) for k, x in enumerate(values)) for s in (1, -1))
        numeric = (term.invert(WAVE, DT, up).values - term.invert(WAVE, DT, down).values) / (2 * h)
        assert np.allclose(found.parameters[:, column], numeric, atol=1e-5)
    change = np.random.default_rng(2).standard_normal((WAVE.size, 2))
    for column in range(2):
        up, down = (term.invert(WAVE + s * h * change[:, column], DT, values) for s in (1, -1))
        numeric = (up.values - down.values) / (2 * h)
        assert np.allclose(found.tangent(change)[:, column], numeric, atol=1e-5)


def test_several_terms_are_undone_last_first() -> None:
    path = (
        (signal_term("sensor.de.delay"), (0.0231,)),
        (signal_term("sensor.de.bias"), (0.01,)),
        (signal_term("sensor.de.scale"), (1.2,)),
    )
    shown = path_response(path, WAVE, DT).values
    found = invert_path(path, shown, DT)
    assert np.abs(found.values - WAVE)[BETWEEN].max() < 1e-4
    h = 1e-7
    for column in range(3):
        up, down = (
            tuple((t, (v[0] + s * h * (k == column),)) for k, (t, v) in enumerate(path))
            for s in (1, -1)
        )
        numeric = (invert_path(up, shown, DT).values - invert_path(down, shown, DT).values) / (
            2 * h
        )
        assert np.allclose(found.parameters[:, column], numeric, atol=1e-5)
    change = np.random.default_rng(3).standard_normal((WAVE.size, 1))
    numeric = (
        invert_path(path, shown + h * change[:, 0], DT).values
        - invert_path(path, shown - h * change[:, 0], DT).values
    ) / (2 * h)
    assert np.allclose(found.tangent(change)[:, 0], numeric, atol=1e-5)


def test_a_control_is_driven_by_its_record() -> None:
    """Recorded late and too large, moved through a lag: values and all derivatives."""

    def driven(values: tuple[float, float, float], signal: np.ndarray) -> PathResponse:
        shown = (
            (signal_term("sensor.surfaces.delay"), values[:1]),
            (signal_term("sensor.de.scale"), values[1:2]),
        )
        return reconstruct_deflection(
            shown, ((signal_term("control.elevator.lag"), values[2:]),), signal, DT
        )

    true = (0.0231, 1.2, 0.06)
    servo = signal_term("control.elevator.lag")
    recorded = 1.2 * signal_term("sensor.surfaces.delay").respond(WAVE, DT, true[:1]).values
    found = driven(true, recorded)
    acted = servo.respond(WAVE, DT, true[2:]).values
    assert np.abs(found.values - acted)[BETWEEN].max() < 2e-4
    h = 1e-7
    for column in range(3):
        up, down = (tuple(x + s * h * (k == column) for k, x in enumerate(true)) for s in (1, -1))
        numeric = (driven(up, recorded).values - driven(down, recorded).values) / (2 * h)
        assert np.allclose(found.parameters[:, column], numeric, atol=1e-5)
    change = np.random.default_rng(6).standard_normal((WAVE.size, 1))
    numeric = (
        driven(true, recorded + h * change[:, 0]).values
        - driven(true, recorded - h * change[:, 0]).values
    ) / (2 * h)
    assert np.allclose(found.tangent(change)[:, 0], numeric, atol=1e-5)


def test_nothing_undone_is_the_signal_itself() -> None:
    found = invert_path((), WAVE, DT)
    assert np.array_equal(found.values, WAVE)
    assert found.parameters.shape == (WAVE.size, 0)


def test_what_was_cut_off_stays_cut_off() -> None:
    term = signal_term("sensor.de.clipping")
    shown = term.respond(WAVE, DT, (0.05,)).values
    assert np.array_equal(term.invert(shown, DT, (0.05,)).values, shown)


def test_a_scale_of_zero_has_lost_the_signal() -> None:
    term = signal_term("sensor.de.scale")
    assert np.array_equal(term.invert(WAVE, DT, (0.0,)).values, WAVE)


# --- early and late -----------------------------------------------------------------------------


def test_a_box_can_be_early_in_a_record_but_not_in_the_air() -> None:
    term = signal_term("sensor.airdata.delay")
    early = term.respond(WAVE, DT, (-0.025,))
    expected = np.interp(TIMES + 0.025, TIMES, WAVE)
    assert np.allclose(early.values[:-4], expected[:-4], atol=1e-12)
    assert np.all(early.parameters[-2:] == 0.0)
    with pytest.raises(FlightError, match="must not be negative"):
        term.initial_memory(0.0, DT, (-0.025,))


@pytest.mark.parametrize("box", INSTRUMENT_BOXES)
def test_a_box_stands_with_every_channel_and_has_one_parameter(box: str) -> None:
    model = FlightModel(B777, BASE.with_effect(f"sensor.{box}.delay", {"delay": 0.03}))
    assert set(model.sensor_terms) == set(INSTRUMENT_BOXES[box]) == set(channels_of_target(box))
    assert {terms[0][0].id for terms in model.sensor_terms.values()} == {f"sensor.{box}.delay"}
    assert {terms[0][1] for terms in model.sensor_terms.values()} == {(0.03,)}


def test_boxes_hold_every_channel_once() -> None:
    inside = [name for channels in INSTRUMENT_BOXES.values() for name in channels]
    assert sorted(inside) == sorted(SENSOR_CHANNELS)


# --- swapped ------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", SWAPPABLE_PAIRS)
def test_swapped_channels_carry_each_others_signal(pair: tuple[str, str]) -> None:
    one, other = pair
    plain = OutputModel(FlightModel(B777, BASE), OUTPUTS)
    swapped = OutputModel(
        FlightModel(B777, BASE.with_effect(f"sensor.{one}_{other}.swapped")), OUTPUTS
    )
    a, b = OUTPUTS.index(one), OUTPUTS.index(other)
    order = [b if k == a else a if k == b else k for k in range(len(OUTPUTS))]
    values = np.array(np.broadcast_arrays(*plain.values(STATE, INPUTS)))
    found = np.array(np.broadcast_arrays(*swapped.values(STATE, INPUTS)))
    assert np.array_equal(found, values[order])
    _, slopes, _ = plain.jacobian(STATE, INPUTS)
    _, turned, _ = swapped.jacobian(STATE, INPUTS)
    assert np.array_equal(turned, slopes[:, order])
    alone = OutputModel(swapped.model, (one,))
    assert np.array_equal(np.array(alone.values(STATE, INPUTS)[0]), values[b])


def test_a_swap_is_no_path_of_a_signal() -> None:
    model = FlightModel(B777, BASE.with_effect("sensor.p_r.swapped"))
    assert model.swapped_channels == (("p", "r"),)
    assert not model.sensor_terms
    term = create_term("sensor.p_r.swapped", B777)
    assert isinstance(term, SwappedChannels)
    assert term.value((1.0, 2.0), (), ()) == 2.0


# --- misplaced ----------------------------------------------------------------------------------

PLACES = [
    name
    for name in effect_ids()
    if name.split(".")[1] in POSITIONED_INSTRUMENTS and name.startswith("sensor.")
]


@pytest.mark.parametrize("name", PLACES)
def test_a_misplaced_instrument_shows_what_it_would_show_there(name: str) -> None:
    _, instrument, axis = name.split(".")
    model = FlightModel(B777, BASE.with_effect(name, {axis: 0.2}).with_effect("mass.cg.x"))
    old = getattr(B777.sensors, instrument)
    position = tuple(
        p + 0.2 * (k == axis) for p, k in zip(old.position, "xyz", strict=True)
    )  # fmt: skip
    moved = B777.model_copy(
        update={
            "sensors": B777.sensors.model_copy(
                update={instrument: old.model_copy(update={"position": position})}
            )
        }
    )
    truth = FlightModel(moved, BASE.with_effect("mass.cg.x"))
    found = np.array(np.broadcast_arrays(*OutputModel(model, OUTPUTS).values(STATE, INPUTS)))
    expected = np.array(np.broadcast_arrays(*OutputModel(truth, OUTPUTS).values(STATE, INPUTS)))
    assert np.allclose(found, expected, rtol=1e-13, atol=1e-13)
    plain = np.array(
        np.broadcast_arrays(*OutputModel(FlightModel(B777, BASE), OUTPUTS).values(STATE, INPUTS))
    )
    assert np.abs(found - plain).max() > 1e-3


@pytest.mark.parametrize("name", PLACES)
def test_derivatives_by_the_place(name: str) -> None:
    axis = name.rpartition(".")[2]
    model = FlightModel(B777, BASE.with_effect(name).with_effect("mass.cg.z"))
    outputs = OutputModel(model, OUTPUTS)
    parameter = f"{name}.{axis}"
    _, slopes, differential = outputs.jacobian(STATE, INPUTS, free=(parameter,))
    h = 1e-6
    index = model.parameter_names.index(parameter)

    def shown(by: float) -> np.ndarray:
        values = [x + by * (k == index) for k, x in enumerate(model.defaults)]
        return np.array(np.broadcast_arrays(*outputs.values(STATE, INPUTS, values))).T

    numeric = (shown(h) - shown(-h)) / (2 * h)
    assert np.allclose(slopes[:, :, -1], numeric, atol=1e-7)
    # Where an instrument sits does not move the aircraft.
    assert np.all(differential.rates[:, :, -1] == 0.0)


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
