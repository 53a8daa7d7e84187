"""Late instruments: what they show is made of the past, and right between samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from gsapp.aircraft import load_aircraft
from gsapp.discrepancy.filtering.lateness import looking_back, shown
from gsapp.dynamics.signals import Path, SignalTerm
from gsapp.dynamics.terms import make_term
from gsapp.quantities import FloatArray

DT = 0.02
OMEGA = 9.0
AIRCRAFT = load_aircraft("b777")


def path(**effects: float) -> Path:
    """Return the path of the beta vane with effects, ``delay=0.025``."""
    found = []
    for kind, value in effects.items():
        term = make_term(f"sensor.beta.{kind}", AIRCRAFT)
        assert isinstance(term, SignalTerm)
        found.append((term, (value,)))
    return tuple(found)


def swinging(late: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return a dutch roll's signal and rate, 50 samples a second."""
    times = DT * np.arange(400) - late
    return np.sin(OMEGA * times), OMEGA * np.cos(OMEGA * times)


def response(tau: float) -> FloatArray:
    """Return what a lag makes of it once it has settled."""
    late = np.arctan(OMEGA * tau) / OMEGA
    return swinging(late)[0] / np.hypot(1.0, OMEGA * tau)


@pytest.mark.parametrize("delay", [0.004, 0.0255, 0.09])
def test_a_delay_is_right_between_samples(delay: float) -> None:
    """Straight lines between samples would be off by a hundred times more."""
    found = shown(path(delay=delay), *swinging(), DT)
    assert np.abs(found - swinging(delay)[0])[20:].max() < 1e-5


@pytest.mark.parametrize("tau", [0.004, 0.0255, 0.09])
def test_a_lag_is_right(tau: float) -> None:
    """The response of a first-order lag to a sine, in size and phase."""
    found = shown(path(lag=tau), *swinging(), DT)
    assert np.abs(found - response(tau))[100:].max() < 3e-4


def test_paths_follow_one_another() -> None:
    """A scale after a lag after a delay, in any order."""
    for names in (("delay", "lag", "scale"), ("scale", "lag", "delay"), ("lag", "delay", "scale")):
        values = {"delay": 0.03, "lag": 0.02, "scale": 1.2}
        found = shown(path(**{name: values[name] for name in names}), *swinging(), DT)
        late = 0.03 + np.arctan(OMEGA * 0.02) / OMEGA
        expected = 1.2 * swinging(late)[0] / np.hypot(1.0, OMEGA * 0.02)
        assert np.abs(found - expected)[100:].max() < 1e-3


@pytest.mark.parametrize("effects", [{"delay": 0.03}, {"lag": 0.03}, {"delay": -0.03}])
def test_nothing_of_the_future_is_used(effects: dict[str, float]) -> None:
    """Samples to come may be anything: what is shown now stays, even by an early clock."""
    signal, rate = swinging()
    before = shown(path(**effects), signal, rate, DT)
    signal[200:], rate[200:] = 7.0, -70.0
    after = shown(path(**effects), signal, rate, DT)
    assert np.array_equal(before[:200], after[:200])
    assert not np.allclose(before[200:], after[200:])


def test_an_early_signal_goes_on_as_it_is_going() -> None:
    """Five milliseconds ahead, as a clock's offset is, to two parts in ten thousand."""
    found = shown(path(delay=-0.005), *swinging(), DT)
    assert np.abs(found - swinging(-0.005)[0])[2:].max() < 2e-4


def test_deviations_are_looked_back_at() -> None:
    """A delay shows what the equations had; a lag, their fading mean; nothing late, the present."""
    jacobian = np.array([[[0.0, 1.0], [-4.0, -0.6]]])
    back = looking_back(path(delay=0.03), jacobian)
    assert back is not None
    assert np.abs(back[0] - expm(-0.03 * jacobian[0])).max() < 1e-3
    lag = looking_back(path(lag=0.03), jacobian)
    assert lag is not None
    assert np.abs(lag[0] - np.linalg.inv(np.eye(2) + 0.03 * jacobian[0])).max() < 1e-3
    both = looking_back(path(lag=0.03, scale=1.1, delay=0.03), jacobian)
    assert both is not None
    assert both == pytest.approx(lag @ back)
    assert looking_back(path(scale=1.1), jacobian) is None
