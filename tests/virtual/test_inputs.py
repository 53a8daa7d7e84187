"""Single inputs of the virtual aircraft are what their plans say, and the same for a seed."""

import numpy as np
import pytest

from gsapp.quantities.constants import DEGREE
from tests.virtual.input_plan import Meddling
from tests.virtual.inputs import fly_input


@pytest.mark.long
def test_same_seed_same_flight_and_what_is_given_is_flown() -> None:
    one, again = (fly_input(5001, surfaces=("de",), turbulence=0.4) for _ in range(2))
    np.testing.assert_array_equal(one.measured.values, again.measured.values)
    np.testing.assert_array_equal(one.truth.values, again.truth.values)
    low, high = np.searchsorted(one.truth.times, (one.t_input, one.t_let_go))
    moved = np.ptp(one.truth["de"][low:high]) / 2.0
    assert moved > 0.5 * abs(one.plan.amplitudes["de"])
    assert one.calm.times[0] == pytest.approx(one.t_input, abs=0.011)
    assert np.abs(one.calm.values[0] - one.truth.values[low]).max() < 10.0


def test_without_gusts_the_calm_flight_is_the_flight() -> None:
    still = fly_input(5002, turbulence=0.0)
    low = int(np.searchsorted(still.truth.times, still.calm.times[0]))
    np.testing.assert_array_equal(still.calm["q"], still.truth["q"][low : low + len(still.calm)])
    gusty = fly_input(5002, turbulence=1.0)
    low = int(np.searchsorted(gusty.truth.times, gusty.calm.times[0]))
    apart = np.abs(gusty.calm["p"] - gusty.truth["p"][low : low + len(gusty.calm)])
    assert apart[0] == 0.0
    assert apart.max() > 1.0 * DEGREE


def test_hands_off_means_that_no_surface_moves_but_those_of_the_plan() -> None:
    flown = fly_input(
        5003,
        surfaces=("dr",),
        amplitudes={"dr": 8.0 * DEGREE},
        left_over=0.0,
        meddling=(Meddling(surface="da", size=3.0 * DEGREE, at=2.2, length=0.5),),
        hands_off=4.0,
        turbulence=0.0,
        roll_rate=0.0,
        pitch_rate=0.0,
    )
    truth = flown.truth
    low, high = np.searchsorted(truth.times, (flown.t_let_go + 0.6, flown.t_hand))
    assert np.ptp(truth["de"][low:high]) < 0.2 * DEGREE
    assert np.ptp(truth["dr"][low:high]) < 0.5 * DEGREE
    whole = slice(int(np.searchsorted(truth.times, flown.t_input)), high)
    assert np.ptp(truth["da"][whole]) == pytest.approx(3.0 * DEGREE, rel=0.25)
