"""Rest: what passes for it, what does not, and that cutting the samples changes nothing."""

import numpy as np
import pytest

from calibration.rest_detection import RestCriteria, RestMonitor, RestPeriod, RestStatus

STEP = 5.0 / 4096
LIMITS = {
    "q": RestCriteria(std=0.012, mean_spread=0.006),
    "an": RestCriteria(std=0.012, mean_spread=0.003),
}


def record(seconds: float, seed: int = 0) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    random = np.random.default_rng(seed)
    times = 12.34 + np.arange(round(100 * seconds)) / 100.0
    noise = 0.0024 * random.standard_normal((2, times.size))
    volts = {"q": 2.512 + noise[0], "an": 3.031 + noise[1]}
    return times, {name: np.round(v / STEP) * STEP for name, v in volts.items()}


def seen(
    times: np.ndarray, volts: dict[str, np.ndarray], limits: dict[str, RestCriteria] = LIMITS
) -> RestStatus:
    watch = RestMonitor(limits)
    watch.feed(times, volts)
    return watch.status


def rest_of(
    times: np.ndarray, volts: dict[str, np.ndarray], limits: dict[str, RestCriteria] = LIMITS
) -> RestPeriod:
    reading = seen(times, volts, limits)
    assert reading.state == "rested", reading.why
    assert reading.rest is not None
    return reading.rest


def test_the_mean_lies_within_its_uncertainty() -> None:
    inside = []
    for seed in range(40):
        rest = rest_of(*record(6.0, seed))
        assert rest.end - rest.start >= 5.0
        for name, truth in (("q", 2.512), ("an", 3.031)):
            inside.append(abs(rest.volts[name] - truth) < rest.uncertainty[name])
    assert 0.88 < np.mean(inside) < 0.995


@pytest.mark.parametrize("cuts", [(1,), (7, 1, 100), (333,)])
def test_cutting_changes_nothing(cuts: tuple[int, ...]) -> None:
    times, volts = record(9.0)
    volts["q"][200:260] += 0.05
    whole = RestMonitor(LIMITS)
    whole.feed(times, volts)
    pieces = RestMonitor(LIMITS)
    start = number = 0
    while start < times.size:
        stop = start + cuts[number % len(cuts)]
        pieces.feed(times[start:stop], {name: v[start:stop] for name, v in volts.items()})
        start, number = stop, number + 1
    assert pieces.status == whole.status
    assert whole.status.state == "rested"


def test_a_bump_begins_the_rest_anew() -> None:
    times, volts = record(9.0)
    volts["q"][400:420] += 0.1
    watch = RestMonitor(LIMITS)
    watch.feed(times[:430], {name: v[:430] for name, v in volts.items()})
    assert watch.status.state == "moving"
    assert watch.status.why.startswith("q shook by")
    watch.feed(times[430:], {name: v[430:] for name, v in volts.items()})
    reading = watch.status
    assert reading.state == "resting"
    assert reading.rest.start >= 12.34 + 4.2


def test_a_slow_turn_is_no_rest() -> None:
    """A gyro on a table that creeps looks still; the accelerometer that leans tells."""
    times, volts = record(8.0)
    volts["an"] = volts["an"] + 0.001 * (times - times[0])
    reading = seen(times, volts)
    assert reading.state != "rested"
    assert reading.why.startswith("an moved by")


def test_missing_samples_are_no_rest() -> None:
    times, volts = record(8.0)
    watch = RestMonitor(LIMITS)
    watch.feed(times[:300], {name: v[:300] for name, v in volts.items()})
    watch.feed(times[500:], {name: v[500:] for name, v in volts.items()})
    assert watch.status.state == "resting"
    assert "gap" in watch.status.why
    volts["q"][100:] = np.nan
    assert "q gave no samples" in seen(times, volts).why


def test_a_silent_converter_is_not_believed_to_the_microvolt() -> None:
    times, volts = record(6.0)
    volts["q"] = np.full(times.size, 2050 * STEP)
    assert rest_of(times, volts).uncertainty["q"] >= 0.5 * STEP


def test_wandering_beyond_noise_is_no_rest_where_it_matters() -> None:
    times, volts = record(12.0, 3)
    volts["q"] = volts["q"] + 1e-3 * np.sin(2.0 * times)
    assert seen(times, volts).state == "rested"
    strict = {"q": RestCriteria(std=0.012, mean_spread=0.006, noise_factor=6.0), "an": LIMITS["an"]}
    reading = seen(times, volts, strict)
    assert reading.state != "rested"
    assert reading.why.startswith("q moved by")
    assert seen(*record(12.0, 3), strict).state == "rested"
    constant = {"q": np.full(times.size, 2.5), "an": np.full(times.size, 3.0)}
    constant["q"][times > 18.2] += STEP
    assert rest_of(times, constant, strict).end - 12.0 > 11.0, "one step is granted"
