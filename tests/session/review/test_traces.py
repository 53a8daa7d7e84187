"""Lines to be drawn: no peak is lost, no sample is invented, however few columns there are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.session.review.traces import Traces
from tests.flight.maneuver_kit import flight_of

TIMES = np.arange(4000) / 50.0
SAMPLES = np.sin(TIMES) + np.random.default_rng(3).normal(size=TIMES.size)
SAMPLES[1000:1100] = np.nan
SAMPLES[2500] = 40.0
FLIGHT = flight_of({"q": SAMPLES, "elevator_left": SAMPLES, "V": np.full(4000, np.nan)}, TIMES)
TRACES = Traces(FLIGHT)


def test_what_was_measured_is_offered_with_stand_ins():
    assert TRACES.channels == ("de", "q")


@settings(max_examples=60, deadline=None)
@given(start=st.floats(-5.0, 75.0), length=st.floats(0.5, 90.0), columns=st.integers(1, 900))
def test_a_line_keeps_the_lowest_and_highest_of_what_is_in_sight(start, length, columns):
    times, values = TRACES.line("q", start, start + length, columns)
    assert np.all(np.diff(times) >= 0.0)
    inside = SAMPLES[slice(*np.searchsorted(TIMES, (start, start + length)))]
    if np.isfinite(inside).any():
        assert np.nanmin(values) <= np.nanmin(inside)
        assert np.nanmax(values) >= np.nanmax(inside)
    known = values[np.isfinite(values)]
    assert np.isin(known, SAMPLES).all()
    # Never much more than the screen shows.
    assert values.size <= max(3 * columns, 2 * columns + 6) + 3


def test_a_gap_stays_a_gap():
    for columns in (20, 2000):
        times, values = TRACES.line("q", 19.0, 23.0, columns)
        missing = times[np.isnan(values)]
        assert missing.min() == pytest.approx(20.0, abs=0.25)
        assert missing.max() == pytest.approx(21.98, abs=0.25)
