"""Proves that noise and lateness of vanes are found from the innovations themselves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from gsapp.discrepancy.search_stages import fit_baseline
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.signal_terms import PathTerms, SignalTerm, apply_lag
from gsapp.dynamics.terms import create_term
from gsapp.identification.filter_error.filter_error_fit import (
    BIAS_PRIOR_STD,
    FilterErrorFit,
    ManeuverState,
    bias_name,
)
from gsapp.identification.filter_error.instrument_output import (
    delay_sensitivity,
    instrument_output,
    lead_matrix,
    visible_shares,
)
from gsapp.identification.filter_error.kalman import SteadyStateFilter, create_filter
from gsapp.identification.filter_error.motion_linearization import create_maneuver_record
from gsapp.identification.filter_error.noise_model import NoiseModel, initial_noise
from gsapp.identification.filter_error.noise_tuning import tune_noise
from gsapp.quantities import FloatArray
from tests.discrepancy.core_kit import (
    AIRCRAFT,
    NOISE,
    TOY_CHANNELS,
    TOY_NOISE,
    TRUTH,
    Toy,
    maneuver,
    with_channel,
)


def toy_fit(toys: list[Toy], noise: NoiseModel) -> FilterErrorFit:
    model = FlightModel(AIRCRAFT, TRUTH)
    fit = FilterErrorFit(model=TRUTH, free=(), values={}, biases={}, noise={"toy": noise})
    for toy in toys:
        linearization = toy.linearization()
        fit.biases = {bias_name("toy", name): 0.0 for name in linearization.record.channels}
        fit.maneuvers.append(
            ManeuverState(
                record=linearization.record,
                flight_model=model,
                motion=toy.motion(),
                filter=create_filter(linearization, noise, toy.motion()),
            )
        )
    return fit


@pytest.mark.parametrize(("share", "gusts", "moments"), [(0.3, 10.0, 0.1), (3.0, 0.1, 10.0)])
def test_noise_of_a_linear_system_is_recovered(share: float, gusts: float, moments: float) -> None:
    """From noise believed far too small or large: within 10 %, gusts and moments within 25 %.

    The toys know no aircraft: truth is exact, and so is the answer but for chance.
    """
    toys = [Toy(TOY_NOISE, seed=seed, n=3000) for seed in range(4)]
    wrong = NoiseModel(
        variances={name: one * share for name, one in TOY_NOISE.variances.items()},
        gust_intensities=tuple(one * gusts for one in TOY_NOISE.gust_intensities),  # type: ignore[arg-type]
        moment_intensity=TOY_NOISE.moment_intensity * moments,
    )
    fit = toy_fit(toys, wrong)
    tune_noise(fit, rounds=20)
    found = fit.noise["toy"]
    for name, variance in TOY_NOISE.variances.items():
        assert np.sqrt(found.variances[name] / variance) == pytest.approx(1.0, abs=0.1), name
    for name, one, true in zip(
        "uvw", found.gust_intensities, TOY_NOISE.gust_intensities, strict=True
    ):
        assert one / true == pytest.approx(1.0, abs=0.25), name
    assert found.moment_intensity / TOY_NOISE.moment_intensity == pytest.approx(1.0, abs=0.25)
    # Filtered with it, innovations are as large as believed.
    one = fit.maneuvers[0]
    found = fit.residual_innovations(one)[10:, :, None]
    white = (one.filter.whitener[10:] @ found)[:, :, 0]
    assert np.mean(white**2) == pytest.approx(1.0, abs=0.05)


def test_turbulence_that_is_not_there_goes() -> None:
    still = TOY_NOISE
    for name in ("gust.u", "gust.v", "gust.w"):
        still = still.with_value(name, 1e-8)
    believed = still
    for name in ("gust.u", "gust.v", "gust.w"):
        believed = believed.with_value(name, 0.01)
    fit = toy_fit([Toy(still, seed=seed, n=2000) for seed in range(2)], believed)
    tune_noise(fit, rounds=12)
    assert max(fit.noise["toy"].gust_rms(30.0).values()) < 0.03
    assert fit.noise["toy"].moment_intensity == pytest.approx(still.moment_intensity, rel=0.25)


def test_first_guess_is_right_where_samples_are_independent() -> None:
    records = [create_maneuver_record(maneuver(seed, dt=0.01)) for seed in (1, 2)]
    found = initial_noise(records)
    for name, size in NOISE.items():
        assert np.sqrt(found.variances[name]) == pytest.approx(size, rel=0.25), name


@pytest.fixture(scope="module")
def fitted() -> dict[str, FilterErrorFit]:
    fits = {}
    for name, gust in (("still", 0.0), ("gusts", 0.5)):
        flown = [maneuver(seed, gust=gust, flight=name) for seed in range(1, 6)]
        records = [create_maneuver_record(one) for one in flown]
        fits[name] = fit_baseline(records, TRUTH, lambda _: None)
    return fits


@pytest.mark.long
def test_instrument_noise_is_recovered_from_maneuvers(fitted: dict[str, FilterErrorFit]) -> None:
    for name, fit in fitted.items():
        for channel, size in NOISE.items():
            found = np.sqrt(fit.noise[name].variances[channel])
            bound = 0.7 if (name, channel) == ("gusts", "an") else 0.2
            assert found == pytest.approx(size, rel=bound), (name, channel)


def test_gusts_are_recovered_from_maneuvers(fitted: dict[str, FilterErrorFit]) -> None:
    found = fitted["gusts"].noise["gusts"].gust_rms(30.0)
    assert 0.5 / 1.6 < found["w"] < 0.5 * 1.6
    assert max(fitted["still"].noise["still"].gust_rms(30.0).values()) < 0.05


def test_derivatives_are_true_within_their_bounds(fitted: dict[str, FilterErrorFit]) -> None:
    """Errors over standard deviations: mean square about 1, none beyond four and a half."""
    for name, fit in fitted.items():
        information = fit.information().with_priors(fit.priors())
        names = (*fit.free, *fit.bias_names())
        _, covariance = information.solution(names)
        stds = np.sqrt(covariance.diagonal())[: len(fit.free)]
        # Levels stand for zero errors of vanes, too, which the prior leaves open.
        kept = [k for k, one in enumerate(fit.free) if not one.endswith("_0")]
        true = np.array([TRUTH.derivative(one) for one in fit.free])
        found = np.array([fit.values[one] for one in fit.free])
        errors = ((found - true) / stds)[kept]
        assert np.abs(errors).max() < 4.5, name
        assert 0.3 < np.mean(errors**2) < 2.5, name


@pytest.mark.long
def test_zero_errors_belong_to_flights() -> None:
    flown = []
    for seed in range(1, 7):
        one = maneuver(seed, flight="good" if seed % 2 else "off", duration=8.0)
        if one.flight == "off":
            one = with_channel(one, "beta", one.samples("beta") + np.radians(0.5))
        flown.append(one)
    fit = FilterErrorFit.create([create_maneuver_record(one) for one in flown], TRUTH, ())
    for _ in range(3):
        fit.linearize()
        tune_noise(fit, rounds=3)
        fit.apply_step(fit.information())
    apart = fit.biases[bias_name("off", "beta")] - fit.biases[bias_name("good", "beta")]
    assert apart == pytest.approx(np.radians(0.5), abs=np.radians(0.06))
    # Its prior is relative to where it stands: one cannot creep away pass by pass.
    name = bias_name("off", "beta")
    assert fit.priors()[name] == (-fit.biases[name], BIAS_PRIOR_STD["beta"])


DT = 0.02
OMEGA = 9.0


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
