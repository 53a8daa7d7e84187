"""Late instruments: what they show is made of the past, and right between samples."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.signal_terms import PathTerms, SignalTerm, apply_lag
from gsapp.dynamics.terms import create_term
from gsapp.identification.filter_error.instrument_output import (
    delay_sensitivity,
    instrument_output,
    lead_matrix,
    visible_shares,
)
from gsapp.identification.filter_error.kalman import SteadyStateFilter, create_filter
from gsapp.quantities import FloatArray
from tests.discrepancy.core_kit import TOY_CHANNELS, TOY_NOISE, Toy

DT = 0.02
OMEGA = 9.0
AIRCRAFT = load_aircraft("b777")


def path(**effects: float) -> PathTerms:
    found = []
    for kind, value in effects.items():
        term = create_term(f"sensor.beta.{kind}", AIRCRAFT)
        assert isinstance(term, SignalTerm)
        found.append((term, (value,)))
    return tuple(found)


def swinging(late: float = 0.0) -> tuple[FloatArray, FloatArray]:
    times = DT * np.arange(400) - late
    return np.sin(OMEGA * times), OMEGA * np.cos(OMEGA * times)


def response(tau: float) -> FloatArray:
    late = np.arctan(OMEGA * tau) / OMEGA
    return swinging(late)[0] / np.hypot(1.0, OMEGA * tau)


@pytest.mark.parametrize("delay", [0.004, 0.0255, 0.09])
def test_a_delay_is_right_between_samples(delay: float) -> None:
    """Straight lines between samples would be off by a hundred times more."""
    found = instrument_output(path(delay=delay), *swinging(), DT)
    assert np.abs(found - swinging(delay)[0])[20:].max() < 1e-5


@pytest.mark.parametrize("tau", [0.004, 0.0255, 0.09])
def test_a_lag_is_right(tau: float) -> None:
    found = instrument_output(path(lag=tau), *swinging(), DT)
    assert np.abs(found - response(tau))[100:].max() < 3e-4


def test_paths_follow_one_another() -> None:
    for names in (("delay", "lag", "scale"), ("scale", "lag", "delay"), ("lag", "delay", "scale")):
        values = {"delay": 0.03, "lag": 0.02, "scale": 1.2}
        found = instrument_output(path(**{name: values[name] for name in names}), *swinging(), DT)
        late = 0.03 + np.arctan(OMEGA * 0.02) / OMEGA
        expected = 1.2 * swinging(late)[0] / np.hypot(1.0, OMEGA * 0.02)
        assert np.abs(found - expected)[100:].max() < 1e-3


@pytest.mark.parametrize("effects", [{"delay": 0.03}, {"lag": 0.03}, {"delay": -0.03}])
def test_nothing_of_the_future_is_used(effects: dict[str, float]) -> None:
    signal, rate = swinging()
    before = instrument_output(path(**effects), signal, rate, DT)
    signal[200:], rate[200:] = 7.0, -70.0
    after = instrument_output(path(**effects), signal, rate, DT)
    assert np.array_equal(before[:200], after[:200])
    assert not np.allclose(before[200:], after[200:])


def test_an_early_signal_goes_on_as_it_is_going() -> None:
    found = instrument_output(path(delay=-0.005), *swinging(), DT)
    assert np.abs(found - swinging(-0.005)[0])[2:].max() < 2e-4


def test_an_early_deviation_goes_on_as_the_equations_do() -> None:
    """Early by the clock of a box: what the equations make of it; late or right, as it is."""
    jacobian = np.array([[[0.0, 1.0], [-4.0, -0.6]]])
    ahead = lead_matrix(path(delay=-0.01, scale=1.1), jacobian)
    assert np.abs(ahead[0] - expm(0.01 * jacobian[0])).max() < 1e-4
    assert lead_matrix(path(delay=0.01), jacobian) is None
    assert lead_matrix(path(scale=1.1), jacobian) is None


def test_an_early_instrument_shows_part_of_what_comes_before_the_next_sample() -> None:
    assert visible_shares(path(delay=-0.012), DT, 2) == pytest.approx((0.0, 0.6, 1.0, 1.0))
    assert visible_shares(path(scale=1.1), DT, 2) == pytest.approx((0.0, 0.0, 1.0, 1.0))


def test_slopes_by_lateness_are_those_of_smooth_signals() -> None:
    signal, rate = swinging()
    values = {"scale": 1.2, "delay": 0.031, "lag": 0.02}
    found = delay_sensitivity(path(**values), signal, rate, DT)
    assert set(found) == {"sensor.beta.delay.delay", "sensor.beta.lag.tau"}
    for name, kind in (("sensor.beta.delay.delay", "delay"), ("sensor.beta.lag.tau", "lag")):
        more, less = (
            instrument_output(path(**{**values, kind: values[kind] + by}), signal, rate, DT)
            for by in (1e-4, -1e-4)
        )
        slope = (more - less) / 2e-4
        assert np.abs(found[name] - slope)[100:].max() < 0.02 * np.abs(slope[100:]).max(), name


# --- readings that are still to be shown ---------------------------------------------------------

FINER = 10
"""Steps of the truth in one sample."""


def late_toy(late: PathTerms, n: int, seed: int) -> tuple[Toy, np.ndarray]:
    noise = replace(TOY_NOISE, gust_intensities=(0.05, 2.0, 0.2))
    toy = Toy(noise, n=n, seed=seed)
    fine = Toy(noise, n=FINER * n, seed=seed, dt=toy.dt / FINER)
    beta = fine.states[:, 2]
    for term, (value,) in late:
        if term.id.endswith("delay"):
            times = fine.dt * np.arange(beta.size)
            beta = np.interp(times - value, times, beta)
        else:
            beta = apply_lag(beta, value, fine.dt)
    shows = fine.states @ toy.slopes.T
    shows[:, 2] = beta
    return toy, shows[::FINER] + toy.errors


def filtered(toy: Toy, record: FloatArray, late: PathTerms) -> tuple[SteadyStateFilter, FloatArray]:
    linearization = replace(toy.linearization(record), paths={TOY_CHANNELS.index("beta"): late})
    own = create_filter(linearization, toy.noise, toy.motion())
    z, b, _ = own.residual(np.zeros(len(TOY_CHANNELS)))
    found, _ = own.innovations(z[:, :, None], b[:, :, None])
    return own, (own.whitener @ found)[20:, :, 0]


@pytest.mark.parametrize(
    "late", [{"delay": 0.02}, {"delay": 0.0235}, {"lag": 0.02}, {"lag": 0.01, "delay": 0.012}]
)
def test_a_filter_that_knows_of_a_late_vane_leaves_noise(late: dict[str, float]) -> None:
    """In gusts: white innovations of the predicted size; a vane in time would not give them."""
    toy, record = late_toy(path(**late), 12000, 7)
    own, white = filtered(toy, record, path(**late))
    n = len(white)
    assert np.abs(white.T @ white / n - np.eye(7)).max() < 4.5 * np.sqrt(2.0 / n) + 0.02
    for lag in range(1, 5):
        assert np.abs(white[lag:].T @ white[:-lag] / n).max() < 4.5 / np.sqrt(n) + 0.02, lag
    blind, poor = filtered(toy, record, ())
    assert np.sum(poor**2) + blind.log_determinant > np.sum(white**2) + own.log_determinant + 200.0


def test_gusts_tell_how_late_a_vane_is() -> None:
    for kind, truth in (("delay", 0.0235), ("lag", 0.02)):
        toy, record = late_toy(path(**{kind: truth}), 6000, 8)
        costs = []
        for by in (-0.01, 0.0, 0.01):
            own, white = filtered(toy, record, path(**{kind: truth + by}))
            costs.append(float(np.sum(white**2)) + own.log_determinant)
        assert costs[1] < min(costs[0], costs[2]) - 5.0, kind
