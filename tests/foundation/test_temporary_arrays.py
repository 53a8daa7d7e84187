"""Large arrays lie in a file without a name, or in memory where none can be had."""

import errno
from pathlib import Path

import numpy as np
import pytest

from gsapp.foundation import temporary_arrays
from gsapp.foundation.temporary_arrays import MIN_FILE_SIZE, create_temporary_array
from gsapp.identification.ftr.estimates import EstimateLog, EstimateSnapshot

ROW = np.dtype([("time", np.float64), ("value", np.float32, (3,))], align=True)
LARGE = 2 * MIN_FILE_SIZE // ROW.itemsize


def file_backed(array: np.ndarray) -> bool:
    """Whether the memory of an array is a map of a file, by the system's own list."""
    address = array.__array_interface__["data"][0]
    for line in Path("/proc/self/maps").read_text().splitlines():
        first, last = (int(one, 16) for one in line.split()[0].split("-"))
        if first <= address < last:
            return int(line.split()[4]) != 0  # The number of the file.
    raise AssertionError("no map holds the array")


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the system tells no maps")
def test_only_large_arrays_lie_in_a_file() -> None:
    assert not file_backed(create_temporary_array(8, ROW))
    large = create_temporary_array(LARGE, ROW)
    large["value"][-1] = (1.0, 2.0, 3.0)
    assert file_backed(large)
    assert large.shape == (LARGE,)
    np.testing.assert_array_equal(large["value"][-1], [1.0, 2.0, 3.0])


def test_a_full_disk_leaves_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(temporary_arrays, "extend_file", full)
    large = create_temporary_array(LARGE, ROW)
    large["time"] = np.arange(LARGE)
    assert large["time"][-1] == LARGE - 1


def test_estimates_of_a_long_flight_read_back_as_given() -> None:
    """Over several growths, a step back in time, and out of a saved state."""
    log = EstimateLog(("Cm_0", "Cm_alpha"))
    rng = np.random.default_rng(4)
    count = 40_000

    def snapshot(rows: slice) -> EstimateSnapshot:
        return EstimateSnapshot(
            values=values[rows], stds=values[rows] + 1.0, plains=values[rows] + 2.0,
            verdicts=verdicts[rows], companions=verdicts[rows], qualities=qualities[rows],
        )  # fmt: skip

    values = rng.normal(size=(count, 2))
    verdicts = rng.integers(-1, 5, (count, 2)).astype(np.int8)
    qualities = rng.normal(size=(count, 2, 4)).astype(np.float32)
    times = 0.1 * np.arange(count)
    for first in range(0, count, 5000):
        log.append(times[first : first + 5000], snapshot(slice(first, first + 5000)))
    log.append(times[30_000:], snapshot(slice(30_000, None)))
    again = EstimateLog(log.names)
    again.restore({name: array.copy() for name, array in log.state().items()})
    for one in (log, again):
        np.testing.assert_array_equal(one.times, times)
        np.testing.assert_array_equal(one.stds, values + 1.0)
        np.testing.assert_array_equal(one.companions, verdicts)
        np.testing.assert_array_equal(one.qualities, qualities)
        assert one.last_time == times[-1]


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the system tells no maps")
def test_stored_objects_share_files() -> None:
    """What is stored equals what was given, cannot be written to, and outlives the store."""
    rng = np.random.default_rng(7)
    given = [(f"maneuver {n}", rng.normal(size=(40, 3)), {"empty": np.empty(0)}) for n in range(50)]
    large = np.arange(temporary_arrays._STORE_STEP // 8 + 1)  # larger than a file of the store
    handles = len(list(Path("/proc/self/fd").iterdir()))
    store = temporary_arrays.MemmapStore()
    kept = [store.store(one) for one in given]
    beside = store.store(large)
    assert len(list(Path("/proc/self/fd").iterdir())) <= handles + 2
    del store
    for (name, values, more), (kept_name, kept_values, kept_more) in zip(given, kept, strict=True):
        assert kept_name == name
        np.testing.assert_array_equal(kept_values, values)
        assert file_backed(kept_values)
        assert not kept_values.flags.writeable
        assert kept_more["empty"].size == more["empty"].size
    np.testing.assert_array_equal(beside, large)
