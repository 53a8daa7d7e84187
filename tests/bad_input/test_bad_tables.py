"""Damaged tables of C libraries, tables that unpack to gigabytes, readers that die or hang."""

import re
import struct
import sys
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from gsapp.flight import load_flight
from gsapp.flight.read_limits import check_grid_size
from gsapp.flight.readers import reader_process
from gsapp.flight.readers.reader_process import observe_reading, read_in_process
from gsapp.flight.readers.tables import read_mat_columns, read_parquet_columns
from gsapp.flight.settings import READER_PROCESS
from gsapp.foundation import GroundStationError
from tests.bad_input.bad_input_kit import (
    Box,
    is_running,
    refused,
    use_endless_reader,
    use_reader,
)

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs limits of memory")


class EnoughError(Exception):
    """Nobody wants the file any more."""


@pytest.fixture
def mat(tmp_path: Path) -> Path:
    path = tmp_path / "f.mat"
    times = np.arange(200) / 50.0
    content = {"time": times[:, None], "q": np.sin(times)[:, None]}
    savemat(path, {**content, "units": {"time": "s", "q": "rad/s"}})
    return path


CRASHES = (
    {1000: 144, 301: 255, 662: 16},
    {328: 137},
    {751: 0, 568: 144, 871: 14},
    {716: 12},
    {754: 64, 145: 8},
    {703: 8, 656: 9},
)
"""Bytes by place that make SciPy 1.17 end the process with a segmentation fault."""


@pytest.mark.parametrize("changes", CRASHES, ids=str)
def test_a_damaged_mat_ends_no_program(tmp_path: Path, changes: dict[int, int]) -> None:
    times, cells = np.arange(12) / 50.0, np.empty(3, object)
    cells[:] = ["ab", np.arange(3.0), {"x": 1.0}]
    content = {"time": times[:, None], "q": np.sin(times)[:, None]}
    content |= {"units": {"time": "s", "q": "rad/s"}, "c": cells, "n": "text"}
    path = tmp_path / "f.mat"
    savemat(path, content)
    data = bytearray(path.read_bytes())
    for place, byte in changes.items():
        data[place] = byte
    path.write_bytes(data)
    with pytest.raises(GroundStationError, match="is damaged"):
        load_flight(path)


def compressed(name: bytes, rows: int, columns: int = 1) -> bytes:
    """Return an element of zeros, written as bytes, as MATLAB writes small whole numbers."""
    padded = name.ljust(-(-len(name) // 8) * 8, b"\0")
    size = rows * columns
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, rows, columns)
    head += struct.pack("<II", 1, len(name)) + padded + struct.pack("<II", 2, size)
    packer = zlib.compressobj(9)
    parts = [packer.compress(struct.pack("<II", 14, len(head) + -(-size // 8) * 8) + head)]
    zeros = bytes(1 << 20)
    left = -(-size // 8) * 8
    while left:
        step = min(left, len(zeros))
        parts.append(packer.compress(zeros[:step]))
        left -= step
    parts.append(packer.flush())
    data = b"".join(parts)
    return struct.pack("<II", 15, len(data)) + data


def mat_head() -> bytes:
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"


def test_a_small_mat_that_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.mat"
    path.write_bytes(mat_head() + b"".join(compressed(b"a%d" % k, 1 << 28) for k in range(2)))
    assert path.stat().st_size < 1 << 20
    words = ("bomb.mat", "2,048 MB", "GSAPP_READ_LIMIT_MB")
    refused(("export", "bomb.mat", "--to", "csv", "--out", "x.csv"), *words, cwd=tmp_path)


def test_the_limit_can_be_raised_and_lowered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "f.mat"
    path.write_bytes(mat_head() + compressed(b"q", 1 << 18))
    monkeypatch.setenv("GSAPP_READ_LIMIT_MB", "1")
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB to 2"):
        read_mat_columns(path)
    monkeypatch.setenv("GSAPP_READ_LIMIT_MB", "2")
    assert read_mat_columns(path)[0]["q"].shape == (1 << 18,)


def test_a_mat_that_claims_a_huge_array_is_refused(mat: Path) -> None:
    data = bytearray(mat.read_bytes())
    place = data.index(struct.pack("<ii", 200, 1))
    data[place : place + 8] = struct.pack("<ii", 1 << 30, 64)
    mat.write_bytes(data)
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB"):
        load_flight(mat)


def test_a_small_parquet_that_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    rows = 1 << 20
    zeros = pyarrow.array(np.zeros(rows))
    table = pyarrow.table({f"c{k}": zeros for k in range(16)})
    path = tmp_path / "bomb.parquet"
    with parquet.ParquetWriter(path, table.schema) as writer:
        for _ in range(16):
            writer.write_table(table)
    assert path.stat().st_size < 2 << 20
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB"):
        read_parquet_columns(path)


def test_a_small_hdf5_that_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "bomb.mat"
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512)
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("q", shape=(1 << 28,), dtype="f8", chunks=True, compression="gzip")
    path.write_bytes(head + path.read_bytes()[512:])
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB"):
        read_mat_columns(path)


def test_a_parquet_whose_names_are_no_text(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    path = tmp_path / "f.parquet"
    parquet.write_table(pyarrow.table({"time": [0.0, 1.0], "qqqq": [0.0, 1.0]}), path)
    path.write_bytes(path.read_bytes().replace(b"qqqq", b"q\xff\xfeq"))
    words = ("f.parquet", "write it again")
    refused(("export", "f.parquet", "--to", "csv", "--out", "x.csv"), *words, cwd=tmp_path)


# Times that cannot be true

TIMES = {
    "pairs of samples, a pause apart": [40.0 * (k // 2) + 1e-5 * (k % 2) for k in range(2000)],
    "one of 1e9 s among three": [0.0, 0.01, 1e9],
    "one of 1e300 s": [0.0, 1e300],
    "microseconds of the year 2026, as seconds": [1.77e15 + 1e4 * k for k in range(50)],
}


@pytest.mark.parametrize("times", TIMES.values(), ids=TIMES)
def test_times_that_would_fill_the_memory_are_refused(tmp_path: Path, times: list[float]) -> None:
    path = tmp_path / "f.csv"
    path.write_text("time [s],q [deg/s]\n" + "".join(f"{time!r},1\n" for time in times))
    with pytest.raises(GroundStationError, match=re.escape(str(path))):
        load_flight(path)


def test_a_log_whose_stamps_lie_far_apart_is_refused(tmp_path: Path) -> None:
    """It takes as many rows as 10 hours of samples do in each of its columns."""
    times = 59.0 * np.arange(20_000)
    path, channel_map = tmp_path / "log.csv", tmp_path / "map.toml"
    path.write_text("t,aoa\n" + "".join(f"{time},1\n" for time in times.tolist()))
    channel_map.write_text(
        'name = "mine"\nformat = "table"\ntime = "t"\ntime_unit = "s"\n'
        '[[channels]]\nid = "alpha"\nsource = "aoa"\nunit = "deg"\n'
    )
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB"):
        load_flight(path, channel_map=channel_map)


def test_telemetry_whose_frames_come_a_minute_apart_is_refused(tmp_path: Path) -> None:
    """On the grid 600 of them take 1.3 GB; a few are read."""
    path, box = tmp_path / "far.tlog", Box()
    stamps = [59_000_000 * k for k in range(600)]
    record = [struct.pack(">Q", 1_700_000_000_000_000 + at) + box.array(at) for at in stamps]
    path.write_bytes(b"".join(record))
    with pytest.raises(GroundStationError, match="GSAPP_READ_LIMIT_MB"):
        load_flight(path)
    # So many numbers of a flight of hours are no damage.
    check_grid_size(path, 1e8, 100.0, records=100_000)
    path.write_bytes(b"".join(record[:10]))
    assert load_flight(path).block.times[-1] == pytest.approx(9 * 59.0)


LONG = {
    "a quotation mark that is not closed": 'a;"b' + "x" * 300_000 + '";c\n0;1;2\n',
    "a name of a megabyte": "time [s],b" + "x" * 1_000_000 + "\n0,1\n",
    "many names that no channel has": ",".join(f"x{k} [deg]" for k in range(100_000)) + "\n0\n",
    "a cell of a megabyte": 'time [s],q [deg/s]\n0,"' + "1\n" * 300_000,
}


@pytest.mark.parametrize("text", LONG.values(), ids=LONG)
def test_a_table_of_long_cells_or_many_columns_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "f.csv"
    path.write_text(text)
    with pytest.raises(GroundStationError, match=re.escape(str(path))):
        load_flight(path)


# What becomes of a process that dies, hangs or takes too much


@POSIX
def test_a_reader_that_crashes_is_named(
    mat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_reader(monkeypatch, tmp_path, "os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(GroundStationError) as caught:
        read_in_process("mat", mat, "save it again")
    for word in (str(mat), "SIGSEGV", "save it again"):
        assert word in str(caught.value)


def test_a_reader_that_hangs_is_ended(
    mat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_reader(monkeypatch, tmp_path, "time.sleep(600)")
    quick = replace(READER_PROCESS, quiet_timeout=0.3)
    monkeypatch.setattr(reader_process, "READER_PROCESS", quick)
    with pytest.raises(GroundStationError, match="without progress"):
        read_in_process("mat", mat, "save it again")


@LINUX
def test_a_reader_that_takes_too_much_memory_is_refused(
    mat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_reader(monkeypatch, tmp_path, "return bytes(1 << 40)")
    with pytest.raises(GroundStationError, match="memory"):
        read_in_process("mat", mat, "save it again")


def test_what_a_process_sends_is_never_code(
    mat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_reader(monkeypatch, tmp_path, "return os.getcwd")
    with pytest.raises(GroundStationError, match="damaged"):
        read_in_process("mat", mat, "save it again")


def test_reading_can_be_canceled_and_says_how_far_it_is(
    mat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    note = use_endless_reader(monkeypatch, tmp_path)

    def tell(share: float | None, doing: str) -> None:
        assert mat.name in doing
        if share == 0.5:
            raise EnoughError

    with observe_reading(tell), pytest.raises(EnoughError):
        read_in_process("mat", mat, "save it again")
    assert not is_running(int(note.read_text()))
