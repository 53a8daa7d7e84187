"""Proves that play in a linkage follows hands, not the noise of the record."""

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.signal_terms import PathTerms, SignalTerm
from gsapp.dynamics.terms import create_term

DT = 0.01
TIMES = np.arange(1000) * DT
HANDS = 0.02 * np.sin(2.0 * TIMES) * np.exp(-0.2 * TIMES)
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
    change = 1e-9 * np.cos(3.0 * TIMES)
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
