"""Cut, merge, resample, filter, rename and lay on one grid: what is kept, and what not invented."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.flight import load_flight
from gsapp.flight.processing import (
    Interpolation,
    append_records,
    cut_windows,
    drop_channels,
    low_pass,
    merge_records,
    parse_time_window,
    rename_channels,
    resample,
    shift_time,
)
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import combine_on_grid, find_uniform_grid, grid_row_indices
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.quantities import Block
from tests.cli.command_kit import gsapp


def block(rate: float = 100.0, seconds: float = 10.0, start: float = 0.0, **signals) -> Block:
    times = start + np.arange(round(seconds * rate) + 1) / rate
    values = np.column_stack([signal(times) for signal in signals.values()])
    return Block(channels=tuple(signals), times=times, values=values)


def sine(frequency: float):
    return lambda t: 0.1 * np.sin(2 * np.pi * frequency * t)


def test_cut_keeps_exactly_the_windows_and_leaves_a_gap_between() -> None:
    found = cut_windows(block(q=sine(1.0)), [parse_time_window("1:2"), parse_time_window("5:6.5")])
    there = np.isfinite(found["q"])
    assert found.times[there][0] == 1.0
    assert found.times[there][-1] == 6.5
    assert there.sum() == 101 + 151
    assert (~there).sum() == 1
    assert 2.0 < found.times[~there][0] < 5.0


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 90), st.integers(1, 9)), min_size=1, max_size=5))
def test_cut_windows_that_touch_or_overlap_are_one(parts: list[tuple[int, int]]) -> None:
    whole = block(q=sine(0.7))
    windows = [parse_time_window(f"{a / 10}:{(a + b) / 10}") for a, b in parts]
    found = cut_windows(whole, windows)
    there = np.isfinite(found["q"])
    inside = np.zeros(len(whole), dtype=bool)
    for window in windows:
        inside |= (whole.times >= window.start - 1e-9) & (whole.times <= window.stop + 1e-9)
    assert np.array_equal(found.times[there], whole.times[inside])
    assert np.array_equal(found["q"][there], whole["q"][inside])


@pytest.mark.parametrize("text", ["5", "7:3", "a:b", ":", "3:3"])
def test_window_that_is_none_is_refused(text: str) -> None:
    if text == ":":
        assert parse_time_window(text).start == -np.inf
        return
    with pytest.raises(FlightError, match="not a window"):
        parse_time_window(text)


def test_window_outside_the_flight_says_what_the_flight_covers() -> None:
    with pytest.raises(FlightError, match="covers 0 to 10 s"):
        cut_windows(block(q=sine(1.0)), [parse_time_window("20:30")])


def test_filter_shifts_no_phase_and_stops_what_lies_above() -> None:
    for frequency, gain, most in ((1.0, 1.0, 1e-3), (5.0, 0.7071, 2e-3), (20.0, 0.0, 1e-3)):
        found = low_pass(block(seconds=20.0, q=sine(frequency)), 5.0)
        middle = slice(500, 1500)
        expected = gain * sine(frequency)(found.times)
        assert np.max(np.abs(found["q"][middle] - expected[middle])) < 0.1 * most


def test_filter_and_resampling_never_bridge_a_gap() -> None:
    whole = block(q=sine(1.0))
    values = whole.values.copy()
    values[300:350] = np.nan
    values[700] = np.nan
    holed = Block(channels=whole.channels, times=whole.times, values=values)
    for found in (low_pass(holed, 10.0), resample(holed, 50.0)):
        inside = (found.times > 3.0 + 1e-9) & (found.times < 3.49 - 1e-9)
        assert np.isnan(found["q"][inside]).all()
        assert np.isfinite(found["q"][found.times < 2.99]).all()
    assert np.isfinite(resample(holed, 50.0)["q"][350])


def test_decimation_does_not_fold() -> None:
    """30 Hz sampled at 50 without a filter would appear at 20 Hz; with it, nothing does."""
    noisy = block(seconds=20.0, q=lambda t: sine(1.0)(t) + sine(30.0)(t))
    found = resample(noisy, 50.0)
    middle = slice(100, 900)
    assert np.max(np.abs(found["q"][middle] - sine(1.0)(found.times)[middle])) < 2e-3
    folded = resample(noisy, 50.0, corner=0.0)
    assert np.max(np.abs(folded["q"][middle] - sine(1.0)(folded.times)[middle])) > 0.05


def test_resampling_up_and_down_gives_the_signal_back() -> None:
    start = block(rate=20.0, q=sine(0.3), psi=lambda t: (3.0 + 0.8 * t) % (2 * np.pi))
    back = resample(resample(start, 100.0, kind="cubic"), 20.0, corner=0.0)
    assert np.allclose(back.times, start.times)
    assert np.allclose(back["q"], start["q"], atol=1e-9)
    turned = resample(start, 100.0)
    straight = (3.0 + 0.8 * turned.times) % (2 * np.pi)
    assert np.max(np.abs(np.angle(np.exp(1j * (turned["psi"] - straight))))) < 1e-9


@pytest.mark.parametrize("rate", [20.0, 100.0, 250.0])
@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_a_switch_stays_a_switch_at_any_rate(rate: float, kind: Interpolation) -> None:
    thrown = {"rate_switch": lambda t: 1.0 * (t >= 3.0), "gps_satellites": lambda t: t // 0.25}
    found = resample(block(q=sine(1.0), **thrown), rate, kind=kind)
    for name, value in thrown.items():
        before = np.floor(found.times * 100.0 + 1e-6) / 100.0
        assert np.array_equal(found[name], value(before + 1e-9)), name
    smooth = low_pass(block(**thrown), 5.0)
    assert np.array_equal(smooth.values, block(**thrown).values)


@pytest.mark.parametrize(
    ("rate", "corner", "told"),
    [
        (1e6 - 1, None, "would make 6000 million numbers of this flight; choose a lower rate"),
        (20.0, 30.0, "30 Hz passes more than 20 samples per second can represent; choose 8 Hz"),
    ],
)
def test_a_rate_that_fits_neither_memory_nor_filter_is_refused(
    rate: float, corner: float | None, told: str
) -> None:
    times = np.arange(0.0, 6000.0, 0.01)
    block = Block(channels=("q",), times=times, values=np.zeros((times.size, 1)))
    with pytest.raises(FlightError, match=told):
        resample(block, rate, corner=corner)


def test_merge_fills_holes_and_obeys_the_winner() -> None:
    one, two = block(q=lambda t: 0 * t + 0.1), block(q=lambda t: 0 * t + 0.2, alpha=sine(1.0))
    values = one.values.copy()
    values[200:300] = np.nan
    one = Block(channels=one.channels, times=one.times, values=values)
    first = merge_records([one, two], conflict="first")
    assert set(np.unique(first["q"][np.r_[0:200, 300:1001]])) == {0.1}
    assert set(np.unique(first["q"][201:299])) == {0.2}
    last = merge_records([one, two], conflict="last")
    assert set(np.unique(last["q"])) == {0.2}
    both = merge_records([one, two], conflict="both")
    assert both.channels == ("q", "q.2", "alpha")
    assert np.isnan(both["q"][250])


def test_merge_of_two_rates_lies_on_the_quicker_grid() -> None:
    slow = block(rate=20.0, start=0.35, altitude=lambda t: 100.0 + (t - 0.35))
    merged = merge_records([block(q=sine(1.0)), shift_time(slow, -0.35)])
    assert merged.channels == ("q", "altitude")
    assert np.allclose(merged["altitude"], 100.0 + merged.times)


def test_append_puts_a_pause_between() -> None:
    whole = append_records([block(q=sine(1.0)), block(q=sine(1.0), alpha=sine(2.0))], pause=5.0)
    gap = (whole.times > 10.0 + 1e-9) & (whole.times < 15.0 - 1e-9)
    assert np.isnan(whole["q"][gap]).all()
    assert np.isnan(whole["alpha"][whole.times < 12.0]).all()
    assert whole.times[-1] == pytest.approx(25.0)


def test_rename_swaps_and_refuses_what_makes_no_sense() -> None:
    start = block(p=sine(1.0), q=sine(2.0), alpha=sine(3.0))
    swapped = rename_channels(start, {"p": "q", "q": "p"})
    assert np.array_equal(swapped["q"], start["p"])
    with pytest.raises(FlightError, match="same quantity"):
        rename_channels(start, {"alpha": "ax"})
    with pytest.raises(FlightError, match="two channels"):
        rename_channels(start, {"p": "q"})
    with pytest.raises(UnknownNameError):
        rename_channels(start, {"p": "pitchrate"})
    with pytest.raises(UnknownNameError):
        drop_channels(start, ["r"])


def test_commands_do_the_same_from_outside(tmp_path: Path) -> None:
    """Cut, resample and merge over files of three formats, read back."""
    whole = block(q=sine(1.0), alpha=sine(0.5))
    write_block(tmp_path / "a.csv", whole, "csv")
    done = gsapp("cut", tmp_path / "a.csv", "--window", "2:4", "--rename", "q=q.2",
                 "--from-zero", "--out", tmp_path / "b.mat", "--json", "-")  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["samples"], told["t_start"], told["t_end"]) == (201, 0.0, pytest.approx(2.0))
    assert told["rate"] == pytest.approx(100.0)
    assert set(told["channels"]) == {"q.2", "alpha"}
    piece = load_flight(tmp_path / "b.mat").block
    assert "q.2" in piece
    assert piece.times[0] == 0.0
    done = gsapp("resample", tmp_path / "a.csv", "--rate", "25", "--out", tmp_path / "c.csv")
    assert done.returncode == 0, done.stderr
    assert "251 samples of 2 channels" in done.stdout
    assert load_flight(tmp_path / "c.csv").rate == pytest.approx(25.0)
    late = shift_time(whole, 0.4)
    rng = np.random.default_rng(1)
    kick = np.interp(late.times, np.arange(0.4, 11.0, 0.2), rng.standard_normal(53))
    for name, times in (("d.csv", late.times), ("e.csv", late.times - 0.4)):
        moved = Block(channels=("q",), times=times, values=kick[:, None] * 0.1)
        write_block(tmp_path / name, moved, "csv")
    done = gsapp("merge", tmp_path / "e.csv", tmp_path / "d.csv", "--align", "--conflict", "both",
                 "--out", tmp_path / "f.csv")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "-0.400 s" in done.stderr
    merged = load_flight(tmp_path / "f.csv").block
    assert np.nanmax(np.abs(merged["q"] - merged["q.2"])) < 1e-6


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (("cut", "a.csv", "--out", "b.txt"), 2, "does not say the format"),
        (("cut", "a.csv", "--window", "50:60", "--out", "b.csv"), 1, "covers 0 to 10 s"),
        (("cut", "a.csv", "--channels", "qq", "--out", "b.csv"), 1, "no channel 'qq'"),
        (("cut", "a.csv", "--rename", "q=", "--out", "b.csv"), 2, "is not a renaming"),
        (("resample", "a.csv", "--out", "b.csv"), 2, "nothing to do"),
        (("resample", "a.csv", "--rate", "-5", "--out", "b.csv"), 2, "not possible"),
        (("resample", "a.csv", "--low-pass", "80", "--out", "b.csv"), 1, "does not suit"),
        (("merge", "a.csv", "--out", "b.csv"), 2, "two or more"),
        (("merge", "a.csv", "a.csv", "--append", "--align", "--out", "b.csv"), 2, "give one"),
        (("merge", "a.csv", "a.csv", "--shift", "3:1", "--out", "b.csv"), 2, "K from 1 to 2"),
    ],
)
def test_wrong_calls_get_one_sentence_and_write_nothing(
    tmp_path: Path, arguments: tuple[str, ...], code: int, sentence: str
) -> None:
    write_block(tmp_path / "a.csv", block(q=sine(1.0)), "csv")
    placed = [str(tmp_path / one) if one.endswith((".csv", ".txt")) else one for one in arguments]
    done = gsapp(*placed)
    assert done.returncode == code
    assert sentence in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "b.csv").exists()


def piece(name, first, values, rate=100.0):
    times = (first + np.arange(len(values))) / rate
    return Block(channels=(name,), times=times, values=np.array(values, dtype=float)[:, None])


def test_union_lays_channels_side_by_side():
    nan = np.nan
    flight = combine_on_grid(
        [piece("q", 0, [1, 2, 3]), piece("p", 2, [7, 8]), piece("q", 3, [4])], 100.0
    )
    assert flight.channels == ("q", "p")
    assert np.array_equal(flight.times, np.arange(4) / 100.0)
    assert np.array_equal(flight["q"], [1, 2, 3, 4])
    assert np.array_equal(flight["p"], [nan, nan, 7, 8], equal_nan=True)


def test_a_night_between_two_flights_costs_no_memory():
    night = 10 * 3600 * 100
    flight = combine_on_grid([piece("q", 0, [1, 2]), piece("q", night, [3, 4])], 100.0)
    assert len(flight) == 6
    assert np.array_equal(flight["q"], [1, 2, np.nan, np.nan, 3, 4], equal_nan=True)
    assert np.all(np.diff(flight.times) > 0)
    minute = int(FLIGHT_DATA.max_filled_gap * 100)
    assert len(combine_on_grid([piece("q", 0, [1]), piece("q", minute, [2])], 100.0)) == minute + 1


def test_no_samples_is_an_empty_flight():
    assert len(combine_on_grid([], 100.0)) == 0
    flight = combine_on_grid([piece("q", 0, [np.nan]), piece("p", 0, [1.0])], 100.0)
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
