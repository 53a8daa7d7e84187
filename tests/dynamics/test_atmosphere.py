"""Air, wind, turbulence."""

import numpy as np
import pytest
from scipy import signal

from gsapp.dynamics.atmosphere import (
    Atmosphere,
    DrydenTurbulence,
    Wind,
    pressure_altitude,
    pressure_at,
)


@pytest.mark.parametrize(
    ("height", "temperature", "pressure", "density"),
    [
        (0.0, 288.15, 101325.0, 1.2250),
        (1000.0, 281.65, 89874.6, 1.1116),
        (5000.0, 255.65, 54019.9, 0.7361),
    ],
)
def test_standard_day(height: float, temperature: float, pressure: float, density: float) -> None:
    """The published table of the standard atmosphere."""
    air = Atmosphere().at(height)
    assert air.temperature == pytest.approx(temperature)
    assert air.pressure == pytest.approx(pressure, rel=2e-5)
    assert air.density == pytest.approx(density, rel=1e-4)


def test_the_day_at_the_field_counts() -> None:
    day = Atmosphere(ground_altitude=300.0, ground_temperature=308.15, ground_pressure=97000.0)
    air = day.at(300.0)
    assert air.temperature == pytest.approx(308.15)
    assert air.pressure == pytest.approx(97000.0)
    assert air.density == pytest.approx(97000.0 / (287.05287 * 308.15))
    # Hydrostatic above it.
    slope = (day.pressure(410.0) - day.pressure(390.0)) / 20.0
    assert slope == pytest.approx(-9.80665 * day.density(400.0), rel=1e-6)


def test_numbers_and_arrays_agree() -> None:
    heights = np.array([0.0, 120.0, 900.0])
    together = Atmosphere(ground_altitude=100.0).at(heights)
    for k, height in enumerate(heights.tolist()):
        single = Atmosphere(ground_altitude=100.0).at(height)
        assert isinstance(single.density, float)
        assert np.allclose([x[k] for x in together], single, rtol=1e-14)


def test_pressure_altitude_is_the_inverse() -> None:
    heights = np.linspace(-300.0, 8000.0, 20)
    assert np.allclose(pressure_altitude(pressure_at(heights)), heights, atol=1e-8)


def test_wind_grows_with_height() -> None:
    wind = Wind(north=-5.0, east=1.0, shear=0.14)
    assert wind.at(10.0) == pytest.approx((-5.0, 1.0, 0.0))
    assert wind.at(100.0)[0] == pytest.approx(-5.0 * 10**0.14)
    assert Wind(north=-5.0).at(3.0) == (-5.0, 0.0, 0.0)


@pytest.mark.parametrize(("dt", "count"), [(0.01, 60000), (0.5, 60000)])
def test_turbulence_keeps_its_strength_at_every_step(dt: float, count: int) -> None:
    gusts = DrydenTurbulence((1.0, 0.8, 0.5), scale=(10.0, 10.0, 10.0), seed=4).series(
        count, dt, 30.0
    )
    # Samples closer than the time constant L/V are not independent.
    independent = count * min(1.0, dt / (2.0 * 10.0 / 30.0))
    tolerance = 4.0 / np.sqrt(2.0 * independent)
    assert np.allclose(gusts.std(axis=0), (1.0, 0.8, 0.5), rtol=tolerance)


def test_turbulence_has_the_spectrum_of_dryden() -> None:
    V, L, sigma, dt = 30.0, 30.0, 1.0, 0.05
    gusts = DrydenTurbulence(sigma, scale=(L, L, L), seed=1).series(60000, dt, V)
    f, power = signal.welch(gusts, fs=1.0 / dt, nperseg=2048, axis=0)
    w = 2.0 * np.pi * f
    tau = L / V
    longitudinal = 4.0 * sigma**2 * tau / (1.0 + (tau * w) ** 2)
    lateral = 2.0 * sigma**2 * tau * (1.0 + 3.0 * (tau * w) ** 2) / (1.0 + (tau * w) ** 2) ** 2
    band = (f > 0.05) & (f < 2.0)
    for column, expected in ((0, longitudinal), (1, lateral), (2, lateral)):
        ratio = power[band, column] / expected[band]
        assert abs(ratio.mean() - 1.0) < 0.06


def test_turbulence_repeats_with_its_seed() -> None:
    one, two, other = (DrydenTurbulence(1.0, seed=s).series(50, 0.01, 30.0) for s in (7, 7, 8))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
