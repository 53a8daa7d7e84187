"""Faults of instruments on the virtual aircraft, each named while one surface is moved by hand."""

import numpy as np
import pytest

from calibration.instrument_faults import find_faults
from gsapp.quantities import FloatArray
from tests.calibration.potentiometer_kit import fault_trial, named_right

STEP = 5.0 / 4096


@pytest.mark.parametrize("kind", ["", "dead", "noisy", "clipped", "swapped", "reversed"])
def test_faults_are_named_right(kind: str) -> None:
    for seed in range(2):
        trial = fault_trial(seed, kind)
        assert named_right(trial), (trial.moved, trial.other, trial.faults)


def move(start: float, end: float, noise: float = 0.001, seed: int = 0) -> FloatArray:
    way = np.concatenate([np.full(100, start), np.linspace(start, end, 100), np.full(100, end)])
    return way + np.random.default_rng(seed).normal(0.0, noise, way.size)


def test_each_sentence_says_what_was_seen_and_what_to_do() -> None:
    still, moving = move(2.5, 2.5), move(2.5, 3.0)
    cases = {
        "dead": ({"rudder": still}, {}),
        "swapped": ({"rudder": still, "alpha": moving}, {}),
        "noisy": ({"rudder": move(2.5, 3.0, noise=0.05)}, {}),
        "clipped": ({"rudder": np.clip(move(4.5, 5.3), 0.0, 4095 * STEP)}, {}),
        "reversed": ({"rudder": moving}, {"sense": -1, "slope_sign": 1}),
    }
    for kind, (volts, more) in cases.items():
        (fault,) = find_faults("rudder", volts, **more)
        assert fault.kind == kind
        assert "Rudder surface" in fault.sentence
        assert "; " in fault.sentence
    assert find_faults("rudder", cases["swapped"][0])[0].swapped_with == "alpha"


def test_without_a_movement_only_what_shows_at_rest_is_told() -> None:
    still = move(2.5, 2.5)
    assert not find_faults("rudder", {"rudder": still, "alpha": move(2.0, 3.0)}, movement=False)
    (noisy,) = find_faults("rudder", {"rudder": move(2.5, 2.5, noise=0.05)}, movement=False)
    assert noisy.kind == "noisy"
    (clipped,) = find_faults("rudder", {"rudder": np.full(200, 4095 * STEP)}, movement=False)
    assert clipped.kind == "clipped"


def test_a_neighbor_that_shakes_along_is_not_swapped() -> None:
    volts = {"rudder": move(2.5, 3.0), "alpha": move(2.0, 2.1), "beta": move(2.0, 2.9)}
    assert not find_faults("rudder", volts)


def test_missing_samples_are_no_fault_of_their_own() -> None:
    volts = move(2.5, 3.0)
    volts[np.random.default_rng(1).random(volts.size) < 0.33] = np.nan
    assert not find_faults("rudder", {"rudder": volts}, sense=1, slope_sign=1)
    (dead,) = find_faults("rudder", {"rudder": np.full(300, np.nan)})
    assert dead.kind == "dead"
