"""Changes over time: few false ones, the true ones found and dated; each over many seeds."""

import math

import numpy as np
import pytest

from gsapp.identification.fleet.change_detection import detect_change

YEARS, FLIGHTS, AT = 3.0, 30, 1.3
NOISE = math.hypot(0.02, 0.01)
"""Standard deviation of a flight: its bound, and what flights scatter beyond it."""


def series(seed, size=0.0, kind="step", flights=FLIGHTS, heavy=False):
    random = np.random.default_rng([5, seed])
    times = np.sort(random.uniform(0.0, YEARS, flights))
    stds = 0.02 * random.uniform(0.6, 1.6, flights)
    drawn = (
        random.standard_t(3, flights) / math.sqrt(3) if heavy else random.standard_normal(flights)
    )
    values = -0.4 + np.hypot(stds, 0.01) * drawn
    course = times > AT if kind == "step" else np.maximum(times - AT, 0.0)
    return times, values + size * course, stds


def test_false_changes_are_as_rare_as_promised() -> None:
    """5 % of series that do not change, for outliers and few flights, too."""
    for options in ({}, {"heavy": True}, {"flights": 10}):
        found = [detect_change(*series(seed, **options)).kind for seed in range(400)]
        # 400 draws of 5 % give 34 at most with a chance of 0.999.
        assert sum(kind != "none" for kind in found) <= 34, options


def test_of_many_series_together_hardly_any_is_false() -> None:
    """20 series that are searched together: 5 % of such fleets have a false change."""
    false = 0
    for fleet in range(40):
        found = [detect_change(*series(1000 + 20 * fleet + k), series=20) for k in range(20)]
        false += any(one.kind != "none" for one in found)
    assert false <= 7


@pytest.mark.parametrize(
    ("kind", "size", "power"),
    [("step", 2.0 * NOISE, 0.9), ("step", 4.0 * NOISE, 0.99), ("drift", 4.0 * NOISE / 1.7, 0.9)],
)
def test_a_change_is_found_and_dated(kind: str, size: float, power: float) -> None:
    found = [detect_change(*series(3000 + seed, size, kind)) for seed in range(150)]
    dated = [one for one in found if one.time is not None]
    assert len(dated) >= power * len(found)
    # 95 % of the intervals; 150 draws give 134 at least with a chance of 0.999.
    assert sum(one.earliest <= AT <= one.latest for one in dated) >= 0.89 * len(dated)
    named = [one for one in dated if one.kind in ("step", "drift")]
    wrong = [one for one in named if one.kind != kind]
    assert len(wrong) <= 0.1 * len(dated)
    errors = [(one.size - size) / one.size_std for one in named if one.kind == kind]
    assert math.sqrt(np.mean(np.square(errors))) < 1.6


def test_a_large_step_is_dated_between_two_flights() -> None:
    times, values, stds = series(1, 20.0 * NOISE)
    found = detect_change(times, values, stds)
    place = int(np.searchsorted(times, AT))
    assert found.kind == "step"
    assert (found.earliest, found.latest) == (times[place - 1], times[place])
    assert found.before == pytest.approx(-0.4, abs=0.02)
    assert found.now == pytest.approx(-0.4 + 20.0 * NOISE, abs=0.02)


def test_a_wide_bound_is_no_change() -> None:
    """A flight that is off by what its bound allows says nothing."""
    times, values, stds = series(2)
    values[-3:] += 0.5
    stds[-3:] = 0.6
    assert detect_change(times, values, stds).kind == "none"


def test_few_flights_are_unknown() -> None:
    times, values, stds = series(3, 20.0 * NOISE)
    found = detect_change(times[:7], values[:7], stds[:7])
    assert (found.kind, found.time, found.p_value) == ("unknown", None, None)


def test_the_same_series_gives_the_same_answer() -> None:
    one, other = (detect_change(*series(4, 2.0 * NOISE)) for _ in range(2))
    assert one == other
