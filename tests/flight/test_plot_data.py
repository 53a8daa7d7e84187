"""Power density by Parseval's theorem, tracks by closed courses and known distances."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.flight.plot_data import TRACK_CHANNELS, ground_track, power_density
from gsapp.quantities import CHANNELS

RATE = 100.0


def test_the_power_of_a_sine_lies_at_its_frequency() -> None:
    times = np.arange(0.0, 60.0, 1.0 / RATE)
    frequencies, density = power_density(3.0 + 2.0 * np.sin(2.0 * np.pi * 7.0 * times), RATE)
    step = frequencies[1] - frequencies[0]
    assert frequencies[np.argmax(density)] == pytest.approx(7.0, abs=step)
    assert float(np.sum(density) * step) == pytest.approx(2.0, rel=0.02)  # amplitude² / 2
    assert frequencies[-1] == pytest.approx(RATE / 2.0)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10.0))
def test_the_power_of_noise_is_its_variance(seed: int, sigma: float) -> None:
    noise = np.random.default_rng(seed).normal(0.0, sigma, 6000)
    frequencies, density = power_density(noise, RATE)
    power = float(np.sum(density) * (frequencies[1] - frequencies[0]))
    assert power == pytest.approx(sigma**2, rel=0.15)


def test_a_spectrum_is_of_the_longest_stretch_without_a_gap() -> None:
    values = np.full(1000, np.nan)
    values[10:200] = 1.0e6 * np.random.default_rng(1).normal(size=190)
    values[300:900] = np.random.default_rng(2).normal(size=600)
    alone = power_density(values[300:900], RATE)
    for found, expected in zip(power_density(values, RATE), alone, strict=True):
        np.testing.assert_array_equal(found, expected)
    assert power_density(values[:15], RATE)[0].size == 0
    assert power_density(np.full(50, np.nan), RATE)[0].size == 0


def test_dead_reckoning_around_a_circle_comes_back() -> None:
    turn = np.arange(0.0, 60.0, 1.0 / RATE) * 2.0 * np.pi / 60.0
    found = ground_track({"V": np.full(turn.size, 30.0), "psi": turn}, RATE)
    assert found is not None
    assert found.source == "airspeed"
    assert math.hypot(found.north[-1], found.east[-1]) < 1.0
    # The diameter of a circle of 1800 m.
    assert np.max(found.east) == pytest.approx(1800.0 / np.pi, rel=0.001)


def test_position_goes_before_speed_and_crosses_the_date_line() -> None:
    longitude = np.radians(np.array([179.99, np.nan, -179.99]))
    latitude = np.radians(np.array([60.0, np.nan, 60.01]))
    speed = np.full(3, 30.0)
    found = ground_track(
        {"latitude": latitude, "longitude": longitude, "ground_speed": speed, "track": speed}, RATE
    )
    assert found is not None
    assert found.source == "position"
    # A minute of latitude is a nautical mile; of longitude half of one here.
    assert found.north[-1] == pytest.approx(0.6 * 1852.0, rel=0.005)
    assert found.east[-1] == pytest.approx(0.5 * 1.2 * 1852.0, rel=0.005)
    assert np.isnan(found.north[1])


def test_channels_without_samples_do_not_count() -> None:
    nothing = np.full(3, np.nan)
    samples = {"north": nothing, "east": nothing, "ground_speed": np.ones(3), "track": np.zeros(3)}
    found = ground_track(samples, 1.0)
    assert found is not None
    assert found.source == "ground speed"
    assert found.north.tolist() == [1.0, 2.0, 3.0]
    assert ground_track({"north": nothing, "east": nothing}, 1.0) is None
    assert ground_track({"V": np.ones(3)}, 1.0) is None


def test_a_gap_is_flown_as_it_began() -> None:
    speed = np.array([np.nan, 10.0, np.nan, 10.0])
    found = ground_track({"V": speed, "psi": np.zeros(4)}, 1.0)
    assert found is not None
    assert found.north.tolist() == [0.0, 10.0, 20.0, 30.0]


def test_tracks_are_of_known_channels() -> None:
    for choices in TRACK_CHANNELS.values():
        for first, second in choices:
            assert first in CHANNELS
            assert second in CHANNELS
