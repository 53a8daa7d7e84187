"""Residuals judged (whiteness, turbulence, quality of fit), and errors against their bounds."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gsapp.identification.maximum_likelihood import MLSettings, fit
from gsapp.identification.statistics import (
    TurbulenceDetection,
    detect_turbulence,
    evaluate_whiteness,
    response_fit,
)
from gsapp.quantities import FloatArray
from tests.identification.virtual_maneuvers import AXES, every_tenth_sample, fly


def colored(random: np.random.Generator, count: int, color: float) -> FloatArray:
    found: FloatArray = lfilter([1.0], [1.0, -color], random.standard_normal(count + 300))[300:]
    return found


# --- whiteness ----------------------------------------------------------------------------------


@pytest.mark.parametrize("share_missing", [0.0, 0.2])
def test_white_residuals_pass(share_missing: float) -> None:
    random = np.random.default_rng(3)
    v = random.standard_normal((500, 300))
    v[random.random(v.shape) < share_missing] = np.nan
    found = evaluate_whiteness(v)
    assert sum(not one.white for one in found) <= 2
    assert np.mean([one.p_value < 0.1 for one in found]) == pytest.approx(0.1, abs=0.05)
    assert np.mean([one.inflation for one in found]) == pytest.approx(1.0, abs=0.05)


def test_colored_residuals_are_told_and_measured() -> None:
    """AR(0.9): the density at zero is (1 + 0.9)/(1 - 0.9) = 19 times that of white noise."""
    random = np.random.default_rng(4)
    v = np.column_stack([colored(random, 4000, 0.9), random.standard_normal(4000)])
    one, other = evaluate_whiteness(v, [slice(0, 1500), slice(1500, 4000)], dt=0.01)
    assert (one.white, other.white) == (False, True)
    assert one.inflation == pytest.approx(19.0, rel=0.3)
    # Integral of the AR(1) density from 0 to 2 Hz of 50: 2/pi atan(19 tan(pi 0.02)).
    share = 2.0 / np.pi * np.arctan(19.0 * np.tan(np.pi * 0.02))
    assert one.low_frequency_share == pytest.approx(share, abs=0.08)
    assert other.low_frequency_share == pytest.approx(other.white_share, abs=0.02)
    assert other.white_share == pytest.approx(0.04)


def test_residuals_of_nothing_say_nothing() -> None:
    v = np.zeros((60, 3))
    v[:, 0] = np.nan
    v[19:, 1] = np.nan
    v[:19, 1] = 1.0
    assert [one.p_value for one in evaluate_whiteness(v)] == [1.0, 1.0, 1.0]


# --- turbulence ---------------------------------------------------------------------------------


def judged(seed: int, kind: str, *, gust: float = 0.0, color: float = 0.0) -> TurbulenceDetection:
    virtual = fly(seed, kind, gust=gust, color=color)
    part = fit([virtual.maneuver], MLSettings(axis=AXES[kind])).parts[0]
    residuals = dict(zip(part.responses, part.residuals.T, strict=True))
    sensors = virtual.maneuver.aircraft.sensors
    (found,) = detect_turbulence(
        residuals,
        dt=virtual.maneuver.dt,
        V=float(virtual.motion["V"].mean()),
        alpha=float(virtual.motion["alpha"].mean()),
        arms=(sensors.alpha_vane.position[0], sensors.beta_vane.position[0]),
        segments=part.segments,
    )
    return found


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_gusts_are_found_and_calm_air_is_left_alone(kind: str) -> None:
    for seed in range(300, 304):
        gusty = judged(seed, kind, gust=0.6)
        assert gusty.detected
        assert gusty.warning
        assert 0.05 < gusty.gust_std < 0.6
        calm = judged(seed, kind, color=0.9 if seed % 2 else 0.0)
        assert not calm.detected
        assert not calm.warning
        assert not calm.warning


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_gusts_are_found_at_ten_samples_a_second(kind: str) -> None:
    """Noise is folded into the band, so that a few are missed."""
    detected = dict.fromkeys((0.0, 0.6), 0)
    for seed in range(310, 318):
        for gust in detected:
            slow = every_tenth_sample(fly(seed, kind, gust=gust).maneuver)
            solution = fit([slow], MLSettings(axis=AXES[kind]))
            detected[gust] += bool(solution.estimate.gusty_maneuvers)
    assert detected[0.0] <= 1
    assert detected[0.6] >= 6


def synthetic(random: np.random.Generator, seconds: float = 10.0) -> dict[str, FloatArray]:
    count = round(seconds * 100)
    return {
        name: size * colored(random, count, 0.9)
        for name, size in (("alpha", 2e-3), ("q", 1e-2), ("an", 5e-2))
    }


def test_a_bad_vane_is_no_gust() -> None:
    random = np.random.default_rng(6)
    for name, size in (("alpha", 10.0), ("an", 10.0), ("q", 10.0)):
        for _ in range(50):
            residuals = synthetic(random)
            residuals[name] = residuals[name] * size
            (found,) = detect_turbulence(residuals, dt=0.01, V=30.0)
            assert not found.detected


def test_motion_that_obeys_kinematics_is_no_gust() -> None:
    """Wrong computed motion moves vane, gyro and accelerometer together, and is no gust.

    The same lift with the air, not the body, moving is one.
    """
    random = np.random.default_rng(7)
    V, lift, dt = 30.0, 150.0, 0.01
    for _ in range(30):
        wave = 0.02 * colored(random, 1000, 0.97)
        quiet = {name: 0.1 * x for name, x in synthetic(random).items()}
        an = lift * wave
        # alpha' = q - an/V
        body = {
            "alpha": wave + quiet["alpha"],
            "q": np.gradient(wave, dt) + an / V + quiet["q"],
            "an": an + quiet["an"],
        }
        air = {**quiet, "alpha": wave + quiet["alpha"], "an": an + quiet["an"]}
        assert not detect_turbulence(body, dt=dt, V=V)[0].detected
        assert detect_turbulence(air, dt=dt, V=V)[0].detected
        faint = {name: 0.01 * x for name, x in air.items()}
        assert not detect_turbulence(faint, dt=dt, V=V)[0].detected  # It rounds to 0.0 m/s.


def test_turbulence_needs_three_instruments_and_time() -> None:
    residuals = synthetic(np.random.default_rng(1))
    assert (
        detect_turbulence({k: x for k, x in residuals.items() if k != "q"}, dt=0.01, V=30.0) == ()
    )
    parts = [slice(0, 200), slice(300, 500)]
    assert detect_turbulence(residuals, dt=0.01, V=30.0, segments=parts) == ()
    residuals["an"][:] = np.nan
    assert detect_turbulence(residuals, dt=0.01, V=30.0) == ()
    assert detect_turbulence({}, dt=0.01, V=30.0) == ()


# --- quality of fit -----------------------------------------------------------------------------


def test_quality_of_fit_by_hand() -> None:
    """Four samples, one missing: numbers worked out by hand."""
    measured = np.array([0.0, 2.0, np.nan, 4.0])
    computed = np.array([0.0, 1.0, 9.0, 3.0])
    found = response_fit(measured, computed)
    rms = np.sqrt(2.0 / 3.0)
    assert found.samples == 3
    assert found.rms == pytest.approx(rms)
    assert found.rms_over_range_pct == pytest.approx(100.0 * rms / 4.0)
    assert found.r2 == pytest.approx(1.0 - 2.0 / 8.0)
    assert found.theil == pytest.approx(rms / (np.sqrt(20.0 / 3.0) + np.sqrt(10.0 / 3.0)))


def test_quality_of_fit_without_samples_or_range() -> None:
    nothing = response_fit(np.full(3, np.nan), np.zeros(3))
    assert nothing.samples == 0
    assert np.isnan([nothing.rms, nothing.r2, nothing.theil, nothing.rms_over_range_pct]).all()
    constant = response_fit(np.zeros(3), np.zeros(3))
    assert (constant.rms, constant.theil) == (0.0, 0.0)
    assert np.isnan([constant.r2, constant.rms_over_range_pct]).all()


COUNT = 20


@pytest.mark.long
@pytest.mark.parametrize(("kind", "color"), [("lon", 0.9), ("lat", 0.0)])
def test_errors_are_as_large_as_the_bounds(kind: str, color: float) -> None:
    """Of all derivatives together within 0.8 to 1.3; each within what 20 maneuvers can show."""
    honest: dict[str, list[float]] = {}
    plain: dict[str, list[float]] = {}
    for seed in range(300, 300 + COUNT):
        virtual = fly(seed, kind, color=color)
        estimate = fit([virtual.maneuver], MLSettings(axis=AXES[kind])).estimate
        assert estimate.converged
        for name, true in virtual.truth.items():
            one = estimate.derivatives[name]
            assert one.status == "estimated"
            error = (one.value or 0.0) - true
            honest.setdefault(name, []).append(error / (one.std or 0.0))
            plain.setdefault(name, []).append(error / (one.cramer_rao or 0.0))
    rms = {name: float(np.sqrt(np.mean(np.square(x)))) for name, x in honest.items()}
    together = float(np.sqrt(np.mean(np.square(list(honest.values())))))
    assert 0.8 < together < 1.3
    # The rms of 20 normal numbers scatters by 0.16.
    assert all(0.5 < value < 1.7 for value in rms.values()), rms
    if color:
        # Uncorrected bounds are three times too small, and more.
        assert np.sqrt(np.mean(np.square(list(plain.values())))) > 2.5
