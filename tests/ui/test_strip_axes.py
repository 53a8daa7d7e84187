"""Columns, round numbers and steady ranges."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.quantities import Block
from gsapp.session.sample_history import SampleHistory
from ui.number_format import clock_text, number_text
from ui.strips.axis_ticks import AutoRange, round_range, step_decimals, time_step, value_ticks
from ui.strips.chart_painter import tick_decimals
from ui.strips.pixel_columns import ColumnScale, column_extremes, select_column_scale
from ui.strips.strip_view import WINDOWS


@given(
    window=st.floats(0.01, 10_000.0),
    width=st.integers(10, 4000),
    rate=st.sampled_from([20.0, 50.0, 100.0, 200.0, 1000.0]),
)
@settings(max_examples=50, deadline=None)
def test_the_columns_hold_exactly_the_window_asked_for(window, width, rate):
    scale = select_column_scale(window, width, rate)
    # To a thousandth of a sample, and windows are whole numbers of samples as a rule.
    assert width * scale.seconds == pytest.approx(window, rel=1e-9, abs=1e-3 / rate)


@given(
    window=st.sampled_from(WINDOWS),
    width=st.integers(10, 4000),
    rate=st.sampled_from([20.0, 50.0, 100.0, 1000.0]),
    first=st.integers(-5, 10**6),
)
@settings(max_examples=100, deadline=None)
def test_columns_share_the_samples_without_a_gap(window, width, rate, first):
    scale = select_column_scale(window, width, rate)
    columns = range(first, first + 40)
    assert [scale.column(scale.time(column)) for column in columns] == list(columns)
    if not scale.holds_samples:
        return
    begins = scale.first_samples(first, first + 41)
    assert np.all(np.diff(begins) > 0)
    for column, begin, end in zip(columns, begins[:-1], begins[1:], strict=True):
        assert scale.column_of(int(begin)) == scale.column_of(int(end) - 1) == column
        # The edges are those of time, to a quarter of a column.
        assert abs(begin / rate - column * scale.seconds) <= max(0.26 * scale.seconds, 1.0 / rate)


@pytest.mark.parametrize(("window", "width"), [(60.0, 641), (600.0, 777), (7200.0, 640)])
def test_columns_have_the_extremes_of_their_samples(window, width):
    generator = np.random.default_rng(5)
    values = np.cumsum(generator.standard_normal(200_000))
    values[5000:9000] = math.nan
    history = SampleHistory(("q",), 100.0)
    history.append(Block(channels=("q",), times=np.arange(values.size) / 100.0,
                         values=values[:, None]))  # fmt: skip
    scale = select_column_scale(window, width, 100.0)
    last = min(scale.column_of(values.size - 1), 300)
    low, high = column_extremes(history, "q", scale, 0, last)
    begins = scale.first_samples(0, last + 1)
    for column in range(last):
        part = values[begins[column] : begins[column + 1]]
        part = part[~np.isnan(part)]
        assert np.isnan(low[column]) == (part.size == 0)
        if part.size:
            assert (low[column], high[column]) == (part.min(), part.max())


def test_a_time_on_the_grid_lies_in_its_own_column():
    for scale in (ColumnScale(rate=100.0), ColumnScale(rate=1000.0, samples=7)):
        for index in (0, 1, 29, 57, 10**6 + 3, 3 * 10**8 + 1, -5):
            assert scale.column(index / scale.rate) == index // scale.samples


@given(
    values=st.lists(st.one_of(st.none(), st.floats(-9.0, 9.0)), min_size=3, max_size=12),
    width=st.integers(13, 400),
)
@settings(max_examples=60, deadline=None)
def test_columns_narrower_than_a_sample_hold_the_line_between_samples(values, width):
    given_values = np.array([math.nan if one is None else one for one in values])
    history = SampleHistory(("q",), 1.0)
    times = np.arange(len(values), dtype=float)
    history.append(Block(channels=("q",), times=times, values=given_values[:, None]))
    scale = select_column_scale(12.0, width, 1.0)
    low, high = column_extremes(history, "q", scale, 0, width)
    padded = np.concatenate([given_values, np.full(20, math.nan)])
    for column in range(width):
        left, right = column * scale.seconds, (column + 1) * scale.seconds
        inside = [k for k in range(13) if left - 1e-12 <= k < right - 1e-9]
        points = [padded[k] for k in inside]
        for at in (left, right):
            k = math.floor(at + 1e-9) if at == left else math.ceil(at - 1e-9) - 1
            share = at - k
            points.append(padded[k] + share * (padded[k + 1] - padded[k]))
        known = [one for one in points if not math.isnan(one)]
        assert np.isnan(low[column]) == (not known)
        if known:
            assert low[column] == pytest.approx(min(known), abs=1e-6)
            assert high[column] == pytest.approx(max(known), abs=1e-6)


def test_a_sample_several_columns_wide_is_joined_by_straight_lines():
    history = SampleHistory(("q",), 100.0)
    values = np.array([0.0, 4.0, math.nan, 2.0, math.nan, 8.0])
    history.append(Block(channels=("q",), times=np.arange(6) / 100.0, values=values[:, None]))
    low, high = column_extremes(history, "q", ColumnScale(rate=100.0, stretch=4), 0, 24)
    assert low[:4] == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert high[:4] == pytest.approx([1.0, 2.0, 3.0, 4.0])
    there = np.flatnonzero(~np.isnan(low)).tolist()
    assert there == [0, 1, 2, 3, 4, 12, 20]
    assert low[[4, 12, 20]] == pytest.approx([4.0, 2.0, 8.0])


@given(
    low=st.floats(-1e4, 1e4),
    span=st.floats(1e-3, 1e5),
    length=st.integers(12, 900),
    scale=st.sampled_from([1.0, 1.25, 2.0, 2.5]),
)
@settings(max_examples=50, deadline=None)
def test_labels_of_a_value_axis_never_touch(low, span, length, scale):
    low, high = round_range(low, low + span)
    apart, pad = 13.5 * scale, 2.0 * scale
    length = length * scale
    ticks = value_ticks(low, high, length, pad, apart)
    assert ticks
    assert all(low - 1e-6 * span <= tick <= high + 1e-6 * span for tick in ticks)
    gain = (length - 2 * pad) / (high - low)
    half = 0.42 * 11 * scale
    places = [min(max(pad + gain * (t - low), half), length - half) for t in ticks]
    assert all(b - a >= 8.0 * scale for a, b in itertools.pairwise(places))


@pytest.mark.parametrize(("low", "high"), [(-2.5, 2.5), (-1.0, 1.0), (12.5, 12.7), (0.9, 1.1)])
def test_a_low_chart_has_a_scale_all_the_same(low, high):
    ticks = value_ticks(low, high, 34.0, 2.0, 13.5)
    assert len(ticks) >= 2
    decimals = tick_decimals(ticks)
    assert [float(f"{tick:.{decimals}f}") for tick in ticks] == pytest.approx(ticks)


def test_numbers_and_times_read_as_they_should():
    assert number_text(-0.04, 1) == "0.0"
    assert number_text(-2.5, 1) == "\N{MINUS SIGN}2.5"
    assert clock_text(247.0) == "04:07"
    assert clock_text(3847.25, decimals=2) == "1:04:07.25"
    assert clock_text(59.999, decimals=1) == "00:59.9"
    assert clock_text(2.34, decimals=2) == "00:02.34"
    assert clock_text(-3.0) == "\N{MINUS SIGN}00:03"
    assert step_decimals(0.25) == 2
    assert step_decimals(20.0) == 0
    assert time_step(60.0, 8) == 10.0
    assert time_step(600.0, 8) == 120.0


def test_a_range_is_steady_and_still_follows():
    steady = AutoRange(1.0)
    assert steady.update(-4.0, 4.0, 0.0)
    first = (steady.low, steady.high)
    assert first[0] <= -4.0
    assert first[1] >= 4.0
    # Values wander below the edge: nothing changes.
    rng = np.random.default_rng(1)
    for step in range(200):
        wobble = rng.uniform(0.8, 1.0)
        assert not steady.update(-4.0 * wobble, 4.0 * wobble, step * 0.1)
    assert steady.update(-4.0, 30.0, 21.0)
    assert steady.high >= 30.0
    # Small again: not at once, but after a few seconds.
    assert not steady.update(-4.0, 4.0, 22.0)
    assert not steady.update(-4.0, 4.0, 25.0)
    assert steady.update(-4.0, 4.0, 26.5)
    assert steady.high <= 10.0
    # A short burst within the patience starts the wait anew.
    assert steady.update(-4.0, 30.0, 27.0)
    assert not steady.update(-4.0, 4.0, 28.0)
    assert not steady.update(-4.0, 25.0, 31.0)
    assert not steady.update(-4.0, 4.0, 32.5)
    assert not steady.update(math.nan, math.nan, 40.0)


def test_noise_of_the_sensor_does_not_fill_a_chart():
    steady = AutoRange(2.0)
    steady.update(5.0, 5.05, 0.0)
    assert steady.high - steady.low >= 2.0


@pytest.mark.parametrize("value", [1013.25, -40.0, 0.0])
def test_a_value_that_stands_still_is_in_the_middle_of_its_chart(value):
    steady = AutoRange(least=2.0)
    steady.update(value, value, now=0.0)
    assert steady.low < value - 0.5 < value + 0.5 < steady.high
    assert steady.high - steady.low <= 4.0


def test_traces_keep_off_the_edges_of_a_range_that_was_just_chosen():
    for high in (9.0, 9.7, 10.0):
        steady = AutoRange(least=0.01)
        steady.update(-high, high, now=0.0)
        assert steady.low <= -1.05 * high
        assert steady.high >= 1.05 * high


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_of_a_range_that_widens_the_end_that_holds_stays(side):
    steady = AutoRange(least=0.1)
    steady.update(-20.0, 20.0, now=0.0)
    before = (steady.low, steady.high)
    low, high = sorted((-side * (before[1] - 0.01), side * (before[1] + 0.01)))
    assert steady.update(low, high, now=0.1)
    kept, moved = (0, 1) if side > 0.0 else (1, 0)
    after = (steady.low, steady.high)
    assert after[kept] == before[kept]
    assert abs(after[moved]) > abs(before[moved])


def test_a_range_without_values_is_left_as_it_was():
    steady = AutoRange(least=0.1)
    steady.update(1.0, 2.0, now=0.0)
    before = (steady.low, steady.high)
    for low, high in ((math.nan, math.nan), (math.nan, 5.0), (-5.0, math.nan)):
        assert not steady.update(low, high, now=1.0)
    assert (steady.low, steady.high) == before
