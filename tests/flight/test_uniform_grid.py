"""One uniform grid from blocks and from columns, without filling pauses with memory."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import combine_on_grid, find_uniform_grid, grid_row_indices
from gsapp.quantities import Block


def block(name, first, values, rate=100.0):
    times = (first + np.arange(len(values))) / rate
    return Block(channels=(name,), times=times, values=np.array(values, dtype=float)[:, None])


def test_union_lays_channels_side_by_side():
    nan = np.nan
    flight = combine_on_grid(
        [block("q", 0, [1, 2, 3]), block("p", 2, [7, 8]), block("q", 3, [4])], 100.0
    )
    assert flight.channels == ("q", "p")
    assert np.array_equal(flight.times, np.arange(4) / 100.0)
    assert np.array_equal(flight["q"], [1, 2, 3, 4])
    assert np.array_equal(flight["p"], [nan, nan, 7, 8], equal_nan=True)


def test_a_night_between_two_flights_costs_no_memory():
    night = 10 * 3600 * 100
    flight = combine_on_grid([block("q", 0, [1, 2]), block("q", night, [3, 4])], 100.0)
    assert len(flight) == 6
    assert np.array_equal(flight["q"], [1, 2, np.nan, np.nan, 3, 4], equal_nan=True)
    assert np.all(np.diff(flight.times) > 0)
    minute = int(FLIGHT_DATA.max_filled_gap * 100)
    assert len(combine_on_grid([block("q", 0, [1]), block("q", minute, [2])], 100.0)) == minute + 1


def test_no_samples_is_an_empty_flight():
    assert len(combine_on_grid([], 100.0)) == 0
    flight = combine_on_grid([block("q", 0, [np.nan]), block("p", 0, [1.0])], 100.0)
    assert flight.channels == ("p",)


@settings(max_examples=40, deadline=None)
@given(
    present=st.lists(st.integers(-(10**7), 10**7), max_size=20), rate=st.sampled_from([1.0, 10.0])
)
def test_rows_hold_every_sample_and_no_long_gap(present, rate):
    rows = grid_row_indices(np.array(present, dtype=np.int64), rate)
    assert set(present) <= set(rows.tolist())
    assert np.all(np.diff(rows) >= 1)
    assert rows.size <= len(set(present)) * (FLIGHT_DATA.max_filled_gap * rate + 2)
    if present:
        assert (rows[0], rows[-1]) == (min(present), max(present))


@settings(max_examples=40, deadline=None)
@given(
    rate=st.sampled_from([10.0, 50.0, 60.0, 100.0, 400.0]),
    start=st.floats(0, 1e4),
    lost=st.sets(st.integers(1, 198), max_size=40),
    digits=st.sampled_from([4, 6, None]),
)
def test_rounded_and_missing_rows_are_still_even(rate, start, lost, digits):
    index = np.array([k for k in range(200) if k not in lost])
    times = start + index / rate
    if digits is not None:
        times = np.round(times, digits)
    found = find_uniform_grid(times)
    assert found is not None
    grid, rows = found
    assert np.array_equal(rows, index)
    tolerance = 1e-9 if digits is None else 0.51 * 10.0**-digits
    np.testing.assert_allclose(grid[rows], times, rtol=0, atol=tolerance + 1e-9)
    np.testing.assert_allclose(np.diff(grid), 1.0 / rate, rtol=0, atol=3e-4)


def test_exact_times_are_kept_bit_for_bit():
    times = np.arange(500) * 0.01 + 12.34
    grid, rows = find_uniform_grid(times)
    assert np.array_equal(grid[rows], times)


def test_uneven_times_are_told():
    rng = np.random.default_rng(3)
    times = np.arange(500) * 0.01 + rng.uniform(-3e-3, 3e-3, 500)
    assert find_uniform_grid(times) is None
