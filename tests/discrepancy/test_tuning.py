"""Proves that noise is found from the innovations themselves, and that parameters follow."""

import numpy as np
import pytest

from gsapp.discrepancy.search_stages import fit_baseline
from gsapp.dynamics.flight_model import FlightModel
from gsapp.identification.filter_error.filter_error_fit import (
    BIAS_PRIOR_STD,
    FilterErrorFit,
    ManeuverState,
    bias_name,
)
from gsapp.identification.filter_error.kalman import create_filter
from gsapp.identification.filter_error.maneuver_record import create_maneuver_record
from gsapp.identification.filter_error.noise_model import NoiseModel, initial_noise
from gsapp.identification.filter_error.noise_tuning import tune_noise
from tests.discrepancy.core_kit import (
    AIRCRAFT,
    NOISE,
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
