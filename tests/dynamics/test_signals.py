"""Paths of signals: sampled against continuous, steps against histories, play in linkages."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.signal_terms import PathTerms, SignalPath, SignalTerm, path_response
from gsapp.dynamics.terms import create_term, effect_ids

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
