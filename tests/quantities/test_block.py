"""Blocks hold what they were given, unchangeable, with channels from the vocabulary."""

import copy
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from gsapp.foundation import UnknownNameError
from gsapp.quantities import Block, base_id, channel, join_blocks
from gsapp.quantities.stored_block import StoredBlock, block_in_file


def block() -> Block:
    return Block(
        channels=("alpha", "q", "q.2"),
        times=np.arange(5) * 0.01,
        values=np.arange(15.0).reshape(5, 3),
    )


def test_columns_are_found_by_id() -> None:
    assert block()["q.2"].tolist() == [2, 5, 8, 11, 14]
    assert block().select(["q", "alpha"]).values[1].tolist() == [4, 3]


def test_time_windows_include_the_start_and_exclude_the_end() -> None:
    assert block().between(0.01, 0.03).times.tolist() == [0.01, 0.02]


def test_blocks_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        block().values[0, 0] = 1.0


def test_blocks_copy_what_they_are_given() -> None:
    times = np.arange(2.0)
    made = Block(channels=("p",), times=times, values=np.zeros((2, 1)))
    times[0] = 9.0
    assert made.times[0] == 0.0


@pytest.mark.parametrize(
    ("channels", "shape"), [(("p", "p"), (2, 2)), (("p",), (2, 2)), (("p", "q"), (3, 2))]
)
def test_shapes_and_names_must_fit(channels: tuple[str, ...], shape: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match=r"needs times|listed twice"):
        Block(channels=channels, times=np.arange(2.0), values=np.zeros(shape))


def test_a_trusted_block_is_the_same_without_a_copy() -> None:
    times, values = np.arange(3.0), np.arange(6.0).reshape(3, 2)
    trusted = Block.unchecked(("p", "q"), times, values)
    checked = Block(channels=("p", "q"), times=times, values=values)
    assert trusted.times is times
    assert trusted.values is values
    assert trusted.channels == checked.channels
    np.testing.assert_array_equal(trusted["q"], checked["q"])
    np.testing.assert_array_equal(trusted.between(1.0, 2.0).values, [[2.0, 3.0]])
    with pytest.raises(ValueError, match="read-only"):
        values[0, 0] = 9.0


def test_unknown_channels_fail_with_the_nearest_known() -> None:
    with pytest.raises(UnknownNameError, match="'alpha"):
        Block(channels=("alfa",), times=np.zeros(1), values=np.zeros((1, 1)))
    with pytest.raises(UnknownNameError, match="it has alpha, q"):
        block()["beta"]


def test_joining_keeps_the_order() -> None:
    joined = Block.concatenate([block().between(0, 0.02), block().between(0.02, 1)])
    np.testing.assert_array_equal(joined.values, block().values)


def test_blocks_that_follow_each_other_become_one() -> None:
    """Per set of channels, in order of arrival; what steps back in time begins another block."""
    whole = block()
    other = Block(channels=("V",), times=[0.005, 0.025], values=[[30.0], [31.0]])
    early, late = whole.between(0, 0.02), whole.between(0.02, 1)
    nothing = whole.between(1, 2)
    first, second = join_blocks(
        [early, other.between(0, 0.01), nothing, late, other.between(0.01, 1)]
    )
    assert (first.channels, second.channels) == (whole.channels, other.channels)
    np.testing.assert_array_equal(first.times, whole.times)
    np.testing.assert_array_equal(first.values, whole.values)
    np.testing.assert_array_equal(second.times, other.times)
    again = join_blocks([early, late, early])
    assert [len(one) for one in again] == [5, 2]
    assert join_blocks([early]) == [early]
    assert join_blocks([]) == []


def test_redundant_sensors_share_the_quantity() -> None:
    assert base_id("q.3") == "q"
    assert channel("q.3").unit == "rad/s"
    assert channel("q.3").symbol == "q 3"


def test_a_block_in_a_file_gives_the_same_samples() -> None:
    random = np.random.default_rng(1)
    blocks = [
        Block(channels=("V", "p"), times=np.arange(float(n)), values=random.normal(size=(n, 2)))
        for n in (5, 1, 7)
    ]
    with tempfile.TemporaryFile(buffering=0) as file:
        stored = [StoredBlock(block, file) for block in blocks]
        for found, block in [*zip(stored, blocks, strict=True)][::-1]:
            assert (found.channels, len(found)) == (block.channels, len(block))
            again = [found, found.in_memory(), copy.copy(found), found.select(("V", "p"))]
            for one in again:
                assert np.array_equal(one.times, block.times)
                assert np.array_equal(one.values, block.values)
                assert np.array_equal(one["p"], block["p"])
            assert [type(one) for one in again] == [StoredBlock, Block, Block, Block]
            with pytest.raises(UnknownNameError):
                found["q"]
            for start, stop in ((1.0, 4.0), (-1.0, 99.0), (2.5, 2.6)):
                part, right = found.between(start, stop), block.between(start, stop)
                assert np.array_equal(part.times, right.times)
                assert np.array_equal(part.values, right.values)
                # Sums and products of a matrix depend on its order in the last bit.
                assert part.values.flags.c_contiguous == right.values.flags.c_contiguous


def test_threads_read_blocks_of_one_file() -> None:
    """Each reads its own samples, whoever else moves in the file."""
    with tempfile.TemporaryFile(buffering=0) as file:
        blocks = [
            StoredBlock(
                Block(
                    channels=("V",), times=np.arange(2000.0), values=np.full((2000, 1), float(k))
                ),
                file,
            )
            for k in range(4)
        ]

        def is_own(k: int) -> bool:
            return all(bool((blocks[k]["V"] == k).all()) for _ in range(300))

        with ThreadPoolExecutor(4) as threads:
            assert all(threads.map(is_own, range(4)))


def test_a_block_stays_in_memory_where_no_file_can_be_made(monkeypatch) -> None:
    block = Block(channels=("V",), times=np.arange(3.0), values=np.ones((3, 1)))
    assert isinstance(block_in_file(block), StoredBlock)
    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: open("/absent/file"))  # noqa: SIM115, PTH123
    assert block_in_file(block) is block
