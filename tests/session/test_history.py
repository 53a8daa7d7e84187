"""The history of a flight against a plain search, and the memory that it takes."""

import errno
import os
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from gsapp.foundation import UnknownNameError
from gsapp.quantities import Block
from gsapp.session import spill_pool
from gsapp.session.sample_history import SampleHistory

RATE = 100.0


def block(first: int, values: dict[str, np.ndarray], rate: float = RATE) -> Block:
    count = len(next(iter(values.values())))
    return Block(
        channels=tuple(values),
        times=np.arange(first, first + count) / rate,
        values=np.column_stack(list(values.values())),
    )


def brute(
    samples: dict[int, float], first_bin: int, last_bin: int, size: int
) -> tuple[np.ndarray, np.ndarray]:
    low = np.full(last_bin - first_bin, np.nan)
    high = low.copy()
    for index, value in samples.items():
        place = index // size - first_bin
        if 0 <= place < low.size and not np.isnan(value):
            low[place] = np.fmin(low[place], value)
            high[place] = np.fmax(high[place], value)
    return low, high


def noise(seed: int, count: int, missing: float) -> np.ndarray:
    generator = np.random.default_rng(seed)
    values = generator.normal(size=count) + (seed % 3 - 1.0) * np.arange(count)
    values[generator.random(count) < missing] = np.nan
    return values


pieces = st.lists(
    st.tuples(
        st.integers(-300, 9000),  # step from the end of the piece before
        st.integers(1, 6000),  # samples
        st.sampled_from([0.0, 0.3, 1.0]),  # share missing
    ),
    min_size=1,
    max_size=6,
)


@example(  # edges that cut through cells of two levels
    start=-1000, pieces=[(0, 6000, 0.0)] * 3, size=1500, share=0.0, count=12, seed=0, horizon=None
)
@example(  # the latest number is overwritten by nothing, others beside it by numbers
    start=0,
    pieces=[(0, 100, 0.0), (-10, 10, 0.3)],
    size=7,
    share=0.0,
    count=9,
    seed=0,
    horizon=None,
)
@settings(deadline=None, max_examples=50)
@given(
    start=st.integers(-70_000, 70_000),
    pieces=pieces,
    size=st.one_of(
        st.integers(1, 1200),
        st.integers(1024, 9000),  # whose edges cut through cells of several levels
        st.sampled_from([16, 256, 544, 600, 4096, 70_000]),
    ),
    share=st.floats(-0.2, 1.0),  # of the flight before the first bin
    count=st.integers(1, 120),
    seed=st.integers(0, 1000),
    horizon=st.none() | st.integers(-2000, 40_000),
)
def test_extremes_samples_and_last_are_those_of_a_plain_search(
    start: int,
    pieces: list[tuple[int, int, float]],
    size: int,
    share: float,
    count: int,
    seed: int,
    horizon: int | None,
) -> None:
    """Any pieces (gaps, overlaps, all missing), any bins, with and without a horizon."""
    history = SampleHistory(["q"], RATE)
    truth: dict[int, float] = {}
    at = start
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number, (step, length, missing) in enumerate(pieces):
            at += step
            values = noise(seed + number, length, missing)
            history.append(block(at, {"q": values}))
            truth.update(zip(range(at, at + length), values.tolist(), strict=True))
            at += length
            # Looking in between must not disturb what comes later.
            history.extremes("q", at // size - 200, at // size, size)
        end = max(truth)
        seen = truth
        if horizon is not None:
            limit = start + horizon
            history.horizon = limit / RATE
            seen = {index: value for index, value in truth.items() if index <= limit}
            end = min(end, limit)
        first_bin = int(min(truth) + share * (max(truth) - min(truth))) // size
        low, high = history.extremes("q", first_bin, first_bin + count, size)
        one = history.extremes("q", first_bin, first_bin + 1, size)
        got = history.samples("q", min(truth) - 5, max(truth) + 5)
        last = history.last("q")
    expected = brute(seen, first_bin, first_bin + count, size)
    np.testing.assert_array_equal(low, expected[0])
    np.testing.assert_array_equal(high, expected[1])
    np.testing.assert_array_equal([one[0][0], one[1][0]], [expected[0][0], expected[1][0]])
    wanted = [seen.get(index, np.nan) for index in range(min(truth) - 5, max(truth) + 5)]
    np.testing.assert_array_equal(got, wanted)
    numbers = [index for index, value in seen.items() if not np.isnan(value)]
    assert last == ((max(numbers) / RATE, seen[max(numbers)]) if numbers else None)
    assert history.end == end / RATE
    history.close()


def test_channels_arrive_apart_and_each_keeps_its_own_end() -> None:
    history = SampleHistory(["p", "q"], RATE)
    assert history.start is history.end is None
    history.append(block(200, {"p": np.array([1.0, 2.0, 3.0])}))
    history.append(block(201, {"q": np.array([5.0, np.nan]), "battery": np.array([12.0, 12.1])}))
    assert history.channels == ("p", "q", "battery")
    assert history.last("p") == (2.02, 3.0)
    assert history.last("q") == (2.01, 5.0)
    assert history.span("q") == (201, 203)
    assert (history.start, history.end) == (2.0, 2.02)
    both = history.block(("p", "q"), 2.0, 2.03)
    np.testing.assert_array_equal(both.values, [[1, np.nan], [2, 5], [3, np.nan]])
    with pytest.raises(UnknownNameError, match="no channel 'alpha'"):
        history.last("alpha")


def test_a_slow_or_uneven_series_goes_to_the_nearest_places() -> None:
    history = SampleHistory(["battery"], RATE)
    times = np.array([0.0, 0.104, 0.5, np.inf, 7.0, np.nan])
    values = np.array([[1.0], [2.0], [3.0], [9.0], [4.0], [9.0]])
    history.append(Block(channels=("battery",), times=times, values=values))
    got = history.samples("battery", 0, 701)
    assert np.flatnonzero(~np.isnan(got)).tolist() == [0, 10, 50, 700]
    assert history.last("battery") == (7.0, 4.0)
    low, high = history.extremes("battery", 0, 8, 100)
    np.testing.assert_array_equal(low, [1, *[np.nan] * 6, 4])
    np.testing.assert_array_equal(high, [3, *[np.nan] * 6, 4])


def test_a_clock_that_jumps_by_years_takes_no_room() -> None:
    history = SampleHistory(["q"], RATE)
    years = 50 * 365 * 86400
    history.append(block(0, {"q": np.arange(10.0)}))
    history.append(block(int(years * RATE), {"q": np.arange(10.0)}))
    jump = np.concatenate([np.arange(3) / RATE, years / 2 + np.arange(3) / RATE])
    history.append(Block(channels=("q",), times=jump, values=np.ones((6, 1))))
    assert history._pool.values.nbytes <= 16 * 2**20
    bin_size = int(years * RATE) // 1000
    low, high = history.extremes("q", 0, 1001, bin_size)
    assert np.flatnonzero(~np.isnan(low)).tolist() == [0, 500, 1000]
    assert (low[0], high[0]) == (1.0, 9.0)
    assert history.last("q") == (years + 0.09, 9.0)
    history.horizon = years - 1.0
    assert history.last("q") == (years / 2 + 0.02, 1.0)


def test_the_revision_tells_when_a_picture_is_void() -> None:
    history = SampleHistory(["q"], RATE)
    history.append(block(0, {"q": np.zeros(50)}))
    history.append(block(50, {"q": np.zeros(50)}))
    assert history.revision == 0
    history.append(block(90, {"q": np.full(20, np.nan)}))
    assert history.revision == 1
    assert history.last("q") == (0.89, 0.0)
    history.horizon = 0.5
    assert history.revision == 2
    assert history.end == 0.5
    history.horizon = 0.6
    assert history.revision == 2


def test_an_hour_of_forty_channels_leaves_memory_flat() -> None:
    """An hour at 100 Hz takes 115 MB, all of it in the file and none of it in the process."""
    names = [f"{name}{tail}" for name in "pqr" for tail in ("", *(f".{n}" for n in range(2, 10)))]
    names += ["alpha", "beta", "ax", "ay", "an", "de", "da", "dr", "V", "qbar", "phi", "theta"]
    names.append("psi")
    assert len(names) == 40
    history = SampleHistory(names, RATE)
    rows = 7200
    values = np.random.default_rng(1).normal(size=(rows, 40))
    resident = _anonymous_memory()
    tracemalloc.start()
    try:
        for part in range(50):
            times = np.arange(part * rows, (part + 1) * rows) / RATE
            history.append(Block(channels=tuple(names), times=times, values=values))
            if part == 4:
                before = tracemalloc.get_traced_memory()[0]
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert history.on_disk
    assert history._pool.values.nbytes > 115e6
    assert after - before < 2e6
    if resident is not None:
        assert _anonymous_memory() - resident < 25e6
    low, high = history.extremes("psi", 0, 100, 3600)
    assert np.all(low == values[:, -1].reshape(-1, 3600).min(axis=1)[[0, 1] * 50])
    assert np.all(high == values[:, -1].reshape(-1, 3600).max(axis=1)[[0, 1] * 50])
    history.release_memory()
    np.testing.assert_array_equal(history.samples("psi", 7200, 14400), values[:, -1])
    history.close()


def _anonymous_memory() -> float | None:
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return None
    return next((1024.0 * int(x.split()[1]) for x in lines if x.startswith("RssAnon")), None)


def test_a_full_disk_moves_the_history_into_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    history = SampleHistory(["q"], RATE)
    values = np.random.default_rng(2).normal(size=900_000)
    history.append(block(0, {"q": values}))
    assert history.on_disk

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(spill_pool, "extend_file", full)
    history.append(block(900_000, {"q": values}))
    history.append(block(1_800_000, {"q": values}))
    assert not history.on_disk
    np.testing.assert_array_equal(
        history.samples("q", 0, 2_700_000), np.concatenate([values, values, values])
    )
    low, _ = history.extremes("q", 0, 3, 900_000)
    np.testing.assert_array_equal(low, [values.min()] * 3)


def test_a_file_system_that_cannot_set_room_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EOPNOTSUPP, "not supported")

    monkeypatch.setattr(os, "posix_fallocate", refuse, raising=False)
    history = SampleHistory(["q"], RATE)
    values = np.random.default_rng(2).normal(size=1_500_000)
    history.append(block(0, {"q": values}))
    assert history.on_disk
    np.testing.assert_array_equal(history.samples("q", 0, values.size), values)


def test_the_work_follows_the_bins_and_not_the_samples() -> None:
    """Numbers read per bin stay bounded however many samples a bin holds."""
    history = SampleHistory(["q"], 1000.0)
    history.append(block(0, {"q": np.random.default_rng(3).normal(size=2_000_000)}, 1000.0))
    track = history._tracks["q"]
    read: list[int] = []

    class Counting:
        def __init__(self, array: object) -> None:
            self.array = array

        def __getattr__(self, name: str) -> object:
            return getattr(self.array, name)

        def read(self, first: int, last: int, plane: int = 0) -> np.ndarray:
            read.append(last - first)
            return self.array.read(first, last, plane)

        def groups(self, starts: np.ndarray, plane: int = 0) -> np.ndarray:
            read.append(16 * starts.size)
            return self.array.groups(starts, plane)

    history.extremes("q", 0, 10, 100_000)
    track.raw = Counting(track.raw)
    track.levels = [Counting(level) for level in track.levels]
    for bin_size in (65, 600, 997, 1024, 4093, 4096, 19_997):
        read.clear()
        history.extremes("q", 0, 100, bin_size)
        assert sum(read) < 100 * 240, bin_size


def test_a_channel_of_which_no_number_came_is_not_filled() -> None:
    history = SampleHistory(("alpha", "q"), RATE)
    missing = np.full(4, np.nan)
    history.append(block(0, {"alpha": missing, "q": np.array([np.nan, np.nan, 1.0, np.nan])}))
    assert history.channels == ("alpha", "q")
    assert history.channels_with_data == ("q",)
    history.horizon = 0.0
    assert history.channels_with_data == ("q",)
    history.append(block(0, {"q": missing}))
    assert history.channels_with_data == ()
    history.close()
