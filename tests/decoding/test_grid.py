"""Samples laid on the grid, exact where a sample lies; which of several sources gives a row."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.decoding.grid import Grid, GridRows, column_index
from gsapp.decoding.gridder import Gridder, SourceSelector
from gsapp.decoding.settings import DECODING


def gridder(width: int = 1, *, rate: float = 100.0, circular: bool = False, step: bool = False,
            fallback: int = 1_000_000) -> Gridder:  # fmt: skip
    return Gridder(
        Grid(rate),
        circular=np.full(width, circular),
        stepwise=np.full(width, step),
        fallback=fallback,
    )


def feed(target: Gridder, times: list[int], values: list[float]) -> list[GridRows]:
    return target.feed(times, times, np.array(values, dtype=float)[:, None])


def joined(rows: list[GridRows]) -> tuple[list[int], list[float]]:
    index = [row.first + k for row in rows for k in range(len(row.values))]
    return index, [float(v) for row in rows for v in row.values[:, 0]]


def test_a_straight_line_stays_straight() -> None:
    times = [3_000 + 7_919 * k for k in range(50)]
    index, values = joined(feed(gridder(), times, [2.0 * t for t in times]))
    assert index == list(range(1, times[-1] // 10_000 + 1))
    np.testing.assert_allclose(values, [2.0 * 10_000 * k for k in index], rtol=1e-12)


def test_a_row_on_a_sample_is_the_sample() -> None:
    values = [0.1, math.nan, 0.3, 0.7]
    index, found = joined(feed(gridder(), [0, 10_000, 20_000, 30_000], values))
    assert index == [0, 1, 2, 3]
    assert found[0] == 0.1
    assert math.isnan(found[1])
    assert found[2:] == [0.3, 0.7]
    # Between a number and a missing sample nothing is known.
    _, between = joined(feed(gridder(), [0, 15_000, 30_000], [1.0, math.nan, 2.0]))
    assert between[0] == 1.0
    assert math.isnan(between[1])
    assert math.isnan(between[2])
    assert between[3] == 2.0


def test_gaps_of_more_than_two_and_a_half_periods_are_empty() -> None:
    times = [0, 10_000, 20_000, 30_000, 50_000, 60_000, 90_000, 100_000]
    index, values = joined(feed(gridder(), times, [float(t) for t in times]))
    assert index == list(range(11))
    missing = [k for k, value in zip(index, values, strict=True) if math.isnan(value)]
    assert missing == [7, 8]
    assert values[4] == pytest.approx(40_000.0)


def test_a_slow_message_is_bridged_between_its_samples() -> None:
    times = [200_000 * k for k in range(10)]
    _, values = joined(feed(gridder(), times, [float(t) for t in times]))
    np.testing.assert_allclose(values, 10_000.0 * np.arange(181))


def test_the_period_follows_a_change_of_rate() -> None:
    times = [10_000 * k for k in range(20)]
    times += [times[-1] + 100_000 * k for k in range(1, 15)]
    index, values = joined(feed(gridder(), times, [1.0] * len(times)))
    filled = np.isfinite(values)
    assert filled[:20].all()
    assert not filled[20:28].any()
    assert filled[np.array(index) > 80].all()


def test_angles_go_round_the_short_way() -> None:
    a = math.radians(170.0)
    index, values = joined(feed(gridder(circular=True), [0, 40_000], [a, -a]))
    assert index == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(np.degrees(values)[[0, 1, 3, 4]], [170, 175, -175, -170], atol=1e-9)
    assert abs(math.degrees(values[2])) == pytest.approx(180.0)


def test_counts_keep_their_value() -> None:
    _, values = joined(feed(gridder(step=True), [0, 40_000], [7.0, 9.0]))
    assert values == [7.0, 7.0, 7.0, 7.0, 9.0]


def test_duplicates_and_overtaken_samples_are_counted_and_left_out() -> None:
    target = gridder()
    _, values = joined(feed(target, [0, 10_000, 10_000, 5_000, 20_000], [0, 1, 9, 9, 2]))
    assert values == [0.0, 1.0, 2.0]
    assert (target.duplicates, target.reordered) == (1, 1)


def test_hours_of_silence_cost_nothing() -> None:
    day = 86_400_000_000
    rows = feed(gridder(), [0, 10_000, day, day + 10_000], [1.0, 2.0, 3.0, 4.0])
    index, values = joined(rows)
    assert index == [0, 1, 8_640_000, 8_640_001]
    assert values == [1.0, 2.0, 3.0, 4.0]


def test_a_pause_that_is_filled() -> None:
    pause = int(DECODING.max_filled_pause * 1e6)
    index, values = joined(
        feed(gridder(), [0, 10_000, 20_000, 20_000 + pause], [1.0, 2.0, 3.0, 4.0])
    )
    assert index == list(range(2 + 6000 + 1))
    assert np.isnan(values[3:-1]).all()


@pytest.mark.parametrize("rate", [50.0, 12.5, 1000.0, 100.0 / 3.0])
def test_other_rates(rate: float) -> None:
    times = [1_000 * k for k in range(0, 500, 3)]
    target = gridder(rate=rate)
    rows = feed(target, times, [t / 1e6 for t in times])
    grid = Grid(rate)
    for row in rows:
        np.testing.assert_allclose(
            row.values[:, 0], grid.times(row.first, len(row.values)), atol=1e-12
        )


@pytest.mark.parametrize("rate", [0.0, 0.0001, 1e6, math.nan])
def test_impossible_rates_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="rows per second"):
        Grid(rate)


@pytest.mark.parametrize("places", [[], [3], [0, 1, 2], [1, 3, 5], [2, 0], [0, 1, 3], [4, 4]])
def test_columns_are_picked_alike_by_slice_and_by_list(places: list[int]) -> None:
    matrix = np.arange(12.0).reshape(2, 6)
    np.testing.assert_array_equal(
        matrix[:, column_index(places)], matrix[:, np.array(places, dtype=int)]
    )


@given(
    steps=st.lists(st.integers(-3_000, 60_000), min_size=2, max_size=40),
    cuts=st.lists(st.integers(1, 5), min_size=1, max_size=40),
)
@settings(max_examples=50, deadline=None)
def test_pieces_give_the_same_rows(steps: list[int], cuts: list[int]) -> None:
    times = np.cumsum([max(steps[0], 0), *steps[1:]]).tolist()
    values = np.sin(np.arange(len(times)) * 1.7).tolist()
    whole = joined(feed(gridder(), times, values))
    target, rows, start = gridder(), [], 0
    for cut in cuts * len(times):
        if start < len(times):
            rows += feed(target, times[start : start + cut], values[start : start + cut])
            start += cut
    assert np.array_equal(joined(rows)[0], whole[0])
    assert np.array(joined(rows)[1]).tobytes() == np.array(whole[1]).tobytes()


class Pair:
    def __init__(self, fallback: int = 300_000) -> None:
        self.grid = Grid(100.0)
        self.better, self.worse = gridder(fallback=fallback), gridder(fallback=fallback)
        self.merger = SourceSelector(self.grid, (self.better, self.worse), 1, fallback)
        self.now = 0
        self.rows: list[GridRows] = []

    def sample(self, source: int, time: int, value: float) -> None:
        target = (self.better, self.worse)[source]
        rows = target.feed([time], [self.now], np.array([[value]]))
        self.now = max(self.now, time)
        self.merger.push(source, rows)
        self.rows += self.merger.pull(0, self.now)


def test_the_next_source_counts_after_the_stated_silence_only() -> None:
    """0.2 s of silence leave a gap; 0.5 s are filled from the other source; then it is back."""
    pair = Pair()
    for k in range(0, 300, 2):
        t = 10_000 * k
        for row in (k, k + 1):
            if not (50 < row < 70 or 100 <= row < 150):
                pair.sample(0, 10_000 * row, 1.0)
        pair.sample(1, t, 2.0)
    index, values = joined(pair.rows)
    assert index == list(range(index[0], index[-1] + 1))
    found = dict(zip(index, values, strict=True))
    assert found[10] == 1.0
    assert all(math.isnan(found[row]) for row in range(51, 70))
    assert all(found[row] == 2.0 for row in range(100, 149))
    assert all(found[row] == 1.0 for row in range(150, 290))


def test_the_better_source_is_waited_for_at_the_start_no_longer_than_stated() -> None:
    pair = Pair()
    for k in range(0, 100, 2):
        pair.sample(1, 10_000 * k, 2.0)
        if k == 30:
            assert not pair.rows
    index, values = joined(pair.rows)
    assert index[0] == 0
    assert values == [2.0] * len(values)


@pytest.mark.parametrize("asked", [1, 3, 1000])
@pytest.mark.parametrize("begin", [0.0, 2.0])
def test_what_comes_late_does_not_change_what_another_source_filled(
    begin: float, asked: int
) -> None:
    """From 2 to 4 s the better source is kept back, then comes at once, on the way or at first."""
    grid, flags = Grid(100.0), np.zeros(1, dtype=bool)
    better, worse = sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in range(2)]
    merger = SourceSelector(grid, sources, 1, 1_000_000)
    tenths = range(60)
    in_time = [(0, k) for k in tenths if begin == 0.0 and k < 20]
    order = [one for k in tenths[:40] for one in ((0, k), (1, k)) if one[0] or one in in_time]
    order += [(0, k) for k in range(20, 40)]
    order += [(number, k) for k in tenths[40:] for number in (0, 1)]
    now, found = 0, dict[int, float]()
    for count, (number, tenth) in enumerate(order, start=1):
        time = 100_000 * tenth
        merger.push(number, sources[number].feed([time], [now], np.array([[float(number)]])))
        now = max(now, time)
        if count % asked == 0 or count == len(order):
            for rows in merger.pull(0, now, final=count == len(order)):
                found.update(zip(range(rows.first, rows.end), rows.values[:, 0], strict=True))
    assert (better.samples, worse.samples) == (60 - 20 * (begin > 0.0), 60)
    until = 190 if begin == 0.0 else 0
    assert [found[row] for row in range(until)] == [0.0] * until
    assert [found[row] for row in range(200, 390)] == [1.0] * 190
    assert [found[row] for row in range(400, 591)] == [0.0] * 191


def pairs_of(ends: Sequence[float]) -> Iterator[tuple[float, float]]:
    return zip(ends[::2], ends[1::2], strict=True)


def chosen(*told: tuple[float, ...], end: float, every: float) -> dict[int, float]:
    """Return the rows that come of sources which tell their number between pairs of times (s).

    The better first, each ten times a second; who decides is asked every so many seconds.
    """
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in told]
    merger = SourceSelector(grid, sources, 1, 1_000_000)
    found: dict[int, float] = {}

    def ask(now: int, *, final: bool = False) -> None:
        for rows in merger.pull(0, now, final=final):
            assert not set(found) & set(range(rows.first, rows.end)), "told twice"
            found.update(zip(range(rows.first, rows.end), rows.values[:, 0].tolist(), strict=True))

    for tenth in range(round(10 * end)):
        now = 100_000 * tenth
        for index, ends in enumerate(told):
            if any(begin <= tenth / 10 <= until for begin, until in pairs_of(ends)):
                fed = sources[index].feed([now], [now], np.array([[float(index)]]))
                merger.push(index, fed)
        if tenth % round(10 * every) == 0:
            ask(now)
    ask(round(1e6 * end), final=True)
    return found


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_there_are_no_rows_before_the_first_sample(every: float) -> None:
    found = chosen((1.5, 4.0), end=4.0, every=every)
    assert sorted(found) == list(range(150, 391))
    assert set(found.values()) == {0.0}


@pytest.mark.parametrize("every", [0.1, 0.7, 100.0])
def test_a_better_source_that_begins_late_leaves_what_stood_before_it(every: float) -> None:
    found = chosen((3.0, 6.0), (0.0, 6.0), end=6.0, every=every)
    assert [found[row] for row in range(300)] == [1.0] * 300
    assert [found[row] for row in range(300, 591)] == [0.0] * 291


@pytest.mark.parametrize("every", [0.1, 100.0])
def test_a_better_source_that_comes_in_time_has_the_place_from_the_beginning(every: float) -> None:
    """Before its first sample there is nothing; what a worse one told would make a step."""
    found = chosen((0.5, 4.0), (0.0, 4.0), end=4.0, every=every)
    assert sorted(found) == list(range(50, 391))
    assert set(found.values()) == {0.0}


@pytest.mark.parametrize("every", [0.1, 100.0])
def test_a_pause_of_all_sources_is_rows_without_a_number_up_to_a_minute(every: float) -> None:
    for pause, filled in ((10.0, True), (70.0, False)):
        back = 2.0 + pause
        spans = (0.0, 2.0, back, back + 2.0)
        found = chosen(spans, spans, end=back + 2.0, every=every)
        known = {row for row, value in found.items() if value == 0.0}
        first, again = round(100 * back), round(100 * back) + 191
        assert known == {*range(201), *range(first, again)}
        assert (set(range(201, first)) <= set(found)) == filled
        assert set(found) <= set(range(again))


def test_the_rows_of_a_source_that_nobody_asks_are_not_kept() -> None:
    grid = Grid(100.0)
    flags = np.zeros(1, dtype=bool)
    sources = [Gridder(grid, circular=flags, stepwise=flags) for _ in range(2)]
    merger = SourceSelector(grid, sources, 1, 1_000_000)
    most = decided = 0
    for k in range(4_000):
        now = 10_000 * k
        for number, every in ((0, 1), (1, 10)):
            if k % every == 0:
                merger.push(number, sources[number].feed([now], [now], np.array([[float(number)]])))
        decided += sum(len(rows.values) for rows in merger.pull(0, now))
        most = max(most, merger.pending_count)
    assert decided == 4_000
    assert most <= 2
