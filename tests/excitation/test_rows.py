"""Rows do not depend on how samples were cut, wait little, and begin anew after a pause."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.excitation.flight_rows import FlightRows, FlightRowStream, rows_from_block
from gsapp.excitation.settings import CUES
from gsapp.quantities import Block

RATE = 100.0


def _block(channels: tuple[str, ...], start: int, stop: int, seed: int = 0) -> Block:
    index = np.arange(start, stop)
    values = np.sin(0.01 * index[:, np.newaxis] * (1.0 + np.arange(len(channels))) + seed)
    return Block(channels=channels, times=index / RATE, values=values)


def _joined(parts: list[FlightRows]) -> np.ndarray:
    return np.concatenate([part.values for part in parts])


@given(cuts=st.lists(st.integers(1, 399), max_size=12), late=st.integers(0, 20))
def test_cutting_changes_nothing(cuts: list[int], late: int) -> None:
    motion, flow, place = ("p", "q", "r"), ("alpha", "beta"), ("height", "battery")
    edges = sorted({0, *cuts, 400})
    stream = FlightRowStream(RATE)
    found: list[FlightRows] = []
    for start, stop in itertools.pairwise(edges):
        found += stream.feed(_block(motion, start, stop))
        if start > late:
            found += stream.feed(_block(flow, max(start - late, 0), stop - late))
        elif stop > late:
            found += stream.feed(_block(flow, 0, stop - late))
        found += stream.feed(_block(place, start, stop))
        found += stream.take_complete_rows()
    found += stream.feed(_block(flow, 400 - late, 400))
    found += stream.finish()
    assert [part.first_index for part in found] == list(
        np.cumsum([0, *(len(part) for part in found[:-1])])
    )
    whole = FlightRowStream(RATE)
    for channels in (motion, flow, place):
        assert not list(whole.feed(_block(channels, 0, 400)))
    (once,) = whole.finish()
    np.testing.assert_array_equal(_joined(found), once.values)


def test_rows_without_a_channel_are_those_of_a_block_without_it() -> None:
    names = ("p", "q", "alpha", "battery", "de")
    rows = rows_from_block(_block(names, 0, 100), RATE)
    before = rows.values.copy()
    fewer = rows.mask_channels(("alpha", "battery", "unheard of"))
    kept = tuple(name for name in names if name not in ("alpha", "battery"))
    block = _block(names, 0, 100)
    np.testing.assert_array_equal(fewer.values, rows_from_block(block.select(kept), RATE).values)
    np.testing.assert_array_equal(rows.values, before)


def test_slow_channels_are_read_late_and_quick_ones_at_once() -> None:
    rows = rows_from_block(
        Block(
            channels=("q", "height"),
            times=np.arange(300) / RATE,
            values=np.column_stack((np.arange(300.0), np.arange(300.0))),
        ),
        RATE,
    )
    np.testing.assert_array_equal(rows["q"], np.arange(300.0))
    lag = round(CUES.slow_channel_delay * RATE)
    assert np.isnan(rows["height"][:lag]).all()
    np.testing.assert_array_equal(rows["height"][lag:], np.arange(300.0 - lag))


def test_a_silent_channel_holds_nothing_up_for_long() -> None:
    """Vanes that fall silent cost the others `CUES.max_channel_wait` at most."""
    stream = FlightRowStream(RATE)
    last = 0
    for start in range(0, 1000, 10):
        list(stream.feed(_block(("p", "q", "r"), start, start + 10)))
        if start < 300:
            list(stream.feed(_block(("alpha",), start, start + 10)))
        for part in stream.take_complete_rows():
            last = part.first_index + len(part)
            if part.first_index > 300:
                assert np.isnan(part["alpha"]).all()
        assert start + 10 - last <= CUES.max_channel_wait * RATE + stream.tick
    assert 1000 - last < stream.tick


def test_a_long_pause_begins_a_new_stretch() -> None:
    stream = FlightRowStream(RATE)
    first = [*stream.feed(_block(("q",), 0, 203)), *stream.take_complete_rows()]
    assert first[0].starts_segment
    assert len(first[0]) == 200
    after = list(stream.feed(_block(("q",), 2000, 2040)))
    assert [len(part) for part in after] == [3]
    (fresh,) = stream.take_complete_rows()
    assert fresh.starts_segment
    assert fresh.first_index == 2000
    assert fresh.times[0] == pytest.approx(20.0)


def test_stand_ins_are_those_of_the_detection() -> None:
    rows = rows_from_block(
        Block(
            channels=("elevator_left", "elevator_right"),
            times=np.arange(20) / RATE,
            values=np.column_stack((np.zeros(20), np.full(20, 0.2))),
        ),
        RATE,
    )
    np.testing.assert_allclose(rows["de"], 0.1)
    assert rows.slice_rows(5, 10).first_index == 5
    assert not rows.slice_rows(5, 10).starts_segment
    with pytest.raises(KeyError):
        rows["no such"]
