"""Proves that accelerometers to one side are found, where the residuals say it and only there."""

import numpy as np
import pytest

from gsapp.identification.accelerometer_position import find_lateral_offset
from gsapp.identification.compatibility import InstrumentError, correct_instruments
from gsapp.identification.compatibility.instrument_error import ACCELEROMETER
from gsapp.identification.maneuver import Maneuver
from tests.identification.virtual_maneuvers import edited, fly, without

BESIDE = 0.25
"""m."""


def displaced(maneuver: Maneuver, beside: float) -> Maneuver:
    """Return a maneuver whose aircraft file puts the accelerometers so far left, m."""
    error = InstrumentError(
        channel=ACCELEROMETER, kind="position", value=-beside, std=0.0, position=(0.0, 0.0, 0.0)
    )
    return correct_instruments(maneuver, [error])


@pytest.fixture(scope="module")
def flown() -> list[Maneuver]:
    return [fly(seed, "lat").maneuver for seed in (501, 502, 503)]


@pytest.mark.parametrize("beside", [BESIDE, -BESIDE])
def test_the_side_and_the_distance_are_found_and_then_nothing_is_left(
    flown: list[Maneuver], beside: float
) -> None:
    wrong = [displaced(one, beside) for one in flown]
    (found,) = find_lateral_offset(wrong)
    assert (found.channel, found.kind) == (ACCELEROMETER, "position")
    assert found.value == pytest.approx(beside, abs=3.0 * found.std)
    assert found.std < 0.1 * BESIDE
    at = flown[0].aircraft.sensors.accelerometer.position[1]
    assert found.file_entry == ("y", pytest.approx(at, abs=3.0 * found.std))
    assert find_lateral_offset([correct_instruments(one, [found]) for one in wrong]) == ()


def test_instruments_in_good_order_are_not_accused() -> None:
    for seed in range(510, 513):
        for kind, gust in (("lat", 0.0), ("lat", 1.0), ("lon", 0.0)):
            assert find_lateral_offset([fly(seed, kind, gust=gust).maneuver]) == ()


def test_one_channel_alone_is_no_proof(flown: list[Maneuver]) -> None:
    def lifted(maneuver: Maneuver) -> Maneuver:
        # A normal force that follows the roll acceleration, and nothing in the other channels.
        p_dot = np.gradient(maneuver.samples("p"), maneuver.dt)
        return edited(maneuver, an=lambda shown: shown - BESIDE * p_dot)

    assert find_lateral_offset([lifted(one) for one in flown]) == ()
    unmeasured = [without(displaced(one, BESIDE), "ax", "ay") for one in flown]
    assert find_lateral_offset(unmeasured) == ()
