"""The volts of one instrument, live: at rest, moving, noisy, clipped, absent; the mean at rest."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from calibration.voltage_monitor import VoltageMonitor, VoltageReading, mean_uncertainty
from gsapp.quantities import FloatArray
from gsapp.virtual.bench import VirtualBench
from tests.calibration.potentiometer_kit import rest

STEP = 5.0 / 4096
RATE = 100.0


def converted(volts: FloatArray, noise: float = 0.0015, seed: int = 0) -> FloatArray:
    drawn = np.random.default_rng(seed).normal(0.0, noise, volts.size)
    return np.asarray(np.clip(np.round((volts + drawn) / STEP), 0, 4095) * STEP)


def times_of(volts: FloatArray, rate: float = RATE) -> FloatArray:
    return np.arange(volts.size) / rate


def moved_to_rest(seed: int = 0) -> FloatArray:
    ramp = np.linspace(2.0, 2.4, 100)
    return converted(np.concatenate([np.full(200, 2.0), ramp, np.full(200, 2.4)]), seed=seed)


def watched(volts: FloatArray, rate: float = RATE) -> VoltageReading:
    watch = VoltageMonitor()
    watch.feed(times_of(volts, rate), volts)
    return watch.reading


def test_a_rest_after_a_movement_is_steady_and_its_mean_right() -> None:
    reading = watched(moved_to_rest())
    assert reading.state == "steady"
    assert reading.moved
    assert reading.steady_for == pytest.approx(2.0, abs=0.35)
    assert abs(reading.volts - 2.4) < 4.0 * reading.uncertainty
    assert reading.uncertainty < 0.001
    assert reading.std == pytest.approx(0.0015, rel=0.4)


def test_while_it_moves_it_is_moving() -> None:
    reading = watched(moved_to_rest()[:270])
    assert (reading.state, reading.steady_for) == ("moving", 0.0)


@given(cuts=st.lists(st.integers(1, 499), max_size=12))
@settings(max_examples=6, deadline=None)
def test_cutting_changes_nothing(cuts: list[int]) -> None:
    volts = moved_to_rest()
    whole, pieces = VoltageMonitor(), VoltageMonitor()
    times = times_of(volts)
    supply = 5.0 - 0.001 * times
    whole.feed(times, volts, supply)
    edges = [0, *sorted(set(cuts)), volts.size]
    for low, high in pairwise(edges):
        pieces.feed(times[low:high], volts[low:high], supply[low:high])
    assert pieces.reading == whole.reading


def test_a_point_is_not_taken_twice_from_one_rest() -> None:
    watch = VoltageMonitor()
    volts = moved_to_rest()
    watch.feed(times_of(volts), volts)
    watch.restart()
    more = converted(np.full(200, 2.4), seed=1)
    watch.feed(5.0 + times_of(more), more)
    assert watch.reading.state == "steady"
    assert (watch.reading.moved, watch.reading.steady_for) == (False, 0.0)
    away = moved_to_rest(seed=2)
    watch.feed(7.0 + times_of(away), away)
    assert watch.reading.moved
    assert watch.reading.steady_for > 1.0


@pytest.mark.parametrize(
    ("volts", "state"),
    [
        (np.full(300, np.nan), "absent"),
        (converted(np.full(300, 2.0), noise=0.04), "noisy"),
        (np.where(np.arange(300) % 33 == 5, 1.4, converted(np.full(300, 2.0))), "noisy"),
        (converted(np.full(300, 5.2)), "clipped"),
        (np.zeros(300), "clipped"),
        (converted(np.full(300, 2.0)), "steady"),
    ],
    ids=["no samples", "bad contact", "contact lost at times", "beyond", "open", "quiet"],
)
def test_states(volts: FloatArray, state: str) -> None:
    assert watched(volts).state == state


def test_nothing_is_known_at_first() -> None:
    watch = VoltageMonitor()
    assert watch.reading.state == "absent"
    watch.feed(np.array([0.0, 0.01]), np.array([2.0, 2.0]))
    assert watch.reading.state == "absent"


def test_a_gap_ends_a_rest() -> None:
    volts = moved_to_rest()
    later = converted(np.full(60, 2.4), seed=3)
    watch = VoltageMonitor()
    watch.feed(times_of(volts), volts)
    watch.feed(6.0 + times_of(later), later)
    assert watch.reading.state == "steady"
    assert watch.reading.steady_for < 0.7
    assert watch.reading.time > 6.0


def test_a_clock_that_began_anew_is_followed() -> None:
    volts = moved_to_rest()
    watch = VoltageMonitor()
    for _ in range(2):
        watch.feed(times_of(volts), volts)
    assert watch.reading.state == "steady"
    assert watch.reading.time == pytest.approx(4.9, abs=0.11)


def test_a_slow_radio_is_enough() -> None:
    assert watched(moved_to_rest()[::10], rate=10.0).state == "steady"
    assert watched(moved_to_rest()[:280:10], rate=10.0).state == "moving"


def test_the_supply_is_averaged_over_the_same_window() -> None:
    watch = VoltageMonitor()
    volts = converted(np.full(200, 2.0))
    watch.feed(times_of(volts), volts, np.where(np.arange(200) % 2, 4.9, np.nan))
    assert watch.reading.excitation == pytest.approx(4.9)
    assert watched(volts).excitation is None


def test_a_creeping_surface_is_not_steady() -> None:
    volts = converted(2.0 + 0.02 * np.arange(400) / RATE)
    assert watched(volts).state == "moving"


@pytest.mark.parametrize("color", [0.0, 0.9])
def test_the_uncertainty_of_the_mean_is_honest(color: float) -> None:
    drawn = np.random.default_rng(5).normal(size=(300, 200))
    # After more than a hundred samples the recursion has forgotten where it began.
    noises = lfilter([1.0], [1.0, -color], drawn)[:, -70:]
    means = noises.mean(axis=1)
    stated = [mean_uncertainty(noise - noise.mean(), 1e-6) for noise in noises]
    ratio = np.std(means) / np.sqrt(np.mean(np.square(stated)))
    assert 0.8 < ratio < 1.35


def test_a_rest_on_one_count_is_no_better_than_the_count() -> None:
    assert mean_uncertainty(np.zeros(70), STEP) == pytest.approx(STEP / np.sqrt(12.0))


def test_a_hand_at_the_virtual_aircraft() -> None:
    bench = VirtualBench(4)
    watch = VoltageMonitor()
    bench.step(bench.set_angle("rudder", -13.0))
    watch.restart()
    bench.set_angle("rudder", -10.0)
    reading = rest(bench, "rudder", watch)
    later = bench.step(2.0)["rudder_volts"]
    assert reading.volts == pytest.approx(later.mean(), abs=0.003)


def test_a_short_mean_leaves_out_how_the_rest_began_and_grows() -> None:
    """Judged over less than is averaged, a surface is sooner known to rest.

    It creeps up the last 50 mV. The first mean is free of them, when that of 0.7 s is not; it
    becomes surer as the rest goes on, and from a second on it is that of 0.7 s.
    """
    creep = 2.4 - 0.05 * np.exp(-np.arange(100) / 12.0)
    volts = converted(np.concatenate([np.full(200, 2.0), creep, np.full(200, 2.4)]))
    quick, usual = VoltageMonitor(shortest=0.3), VoltageMonitor()
    times = times_of(volts)
    readings = []
    for at in range(0, times.size, 10):
        for watch in (quick, usual):
            watch.feed(times[at : at + 10], volts[at : at + 10])
        readings.append((quick.reading, usual.reading))
    first, meanwhile = next(pair for pair in readings if pair[0].steady_for >= 0.6)
    assert first.volts == pytest.approx(2.4, abs=0.001)
    assert meanwhile.volts < 2.4 - 0.0015
    late = [pair for pair in readings if pair[0].steady_for >= 1.0]
    assert [one.volts for one, _ in late] == [other.volts for _, other in late]
    assert np.mean([one.uncertainty for one, _ in late]) < 0.8 * first.uncertainty
