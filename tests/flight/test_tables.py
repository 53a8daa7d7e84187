"""MATLAB and Parquet, our own and those of strangers, and strangers' CSV by a channel map."""

import os
import sys

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight import load_flight
from gsapp.flight.flight_import import import_flights
from gsapp.flight.readers.tables import read_mat_columns, read_table
from gsapp.flight.writers import write_block
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError
from gsapp.quantities import Block

MAP = """
name = "other logger"
format = "table"
{head}
[[channels]]
id = "q"
source = "{q}"
unit = "deg/s"

[[channels]]
id = "V"
source = "{v}"
unit = "kt"
scale = 0.1
missing = [-999.0]
"""


def make_map(tmp_path, head="", q="Pitch Rate (deg/s)", v="Speed"):
    path = tmp_path / "map.toml"
    path.write_text(MAP.format(head=head, q=q, v=v))
    return path


def sample_block(rows=50):
    rng = np.random.default_rng(5)
    values = rng.normal(size=(rows, 4))
    values[rng.random(values.shape) < 0.1] = np.nan
    return Block(
        channels=("alpha", "q", "q.2", "temperature"), times=np.arange(rows) / 50.0, values=values
    )


@pytest.mark.parametrize("to", ["csv", "mat", "parquet"])
@pytest.mark.parametrize("units", ["us", "si", "base"])
def test_export_is_read_back(tmp_path, to, units):
    block = sample_block()
    back = load_flight(write_block(tmp_path / f"f.{to}", block, to, units))
    assert set(back.block.channels) == set(block.channels)
    assert np.array_equal(back.block.times, block.times)
    for name in block.channels:
        np.testing.assert_allclose(back.block[name], block[name], rtol=2e-14, atol=1e-12)
        if units == "base":
            assert np.array_equal(back.block[name], block[name], equal_nan=True)
    assert back.rate == pytest.approx(50.0)
    assert back.sources["q"].kind == "measured"


class EnoughError(Exception):
    """Nobody wants the file any more."""


@pytest.mark.parametrize("to", ["csv", "mat", "parquet"])
def test_writing_says_how_far_it_is_and_can_be_ended(tmp_path, monkeypatch, to):
    for name in ("_ROWS_AT_ONCE", "_GROUP_ROWS"):
        monkeypatch.setattr(f"gsapp.flight.writers.{name}", 20)
    block, path, shares = sample_block(), tmp_path / f"f.{to}", []
    write_block(path, block, to, "si", shares.append)
    assert len(shares) >= 3
    assert shares == sorted(shares)
    assert shares[0] < 0.5
    assert shares[-1] == 1.0
    np.testing.assert_allclose(load_flight(path).block["q"], block["q"], rtol=2e-14)

    def end(share):
        if share > 0.5:
            raise EnoughError

    with pytest.raises(EnoughError):
        write_block(tmp_path / f"g.{to}", block, to, "si", end)
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_mat_for_matlab(tmp_path):
    block = sample_block()
    content = loadmat(write_block(tmp_path / "f.mat", block, "mat", "us"))
    assert content["q_2"].shape == (50, 1)
    assert str(content["units"]["alpha"][0, 0][0]) == "deg"
    np.testing.assert_allclose(content["alpha"][:, 0], np.rad2deg(block["alpha"]))


def test_a_mat_too_long_for_matlab_is_refused_before_it_is_written(tmp_path, monkeypatch):
    """A variable of version 5 holds 2 GB: past that savemat would fail after minutes."""
    block, path = sample_block(rows=50), tmp_path / "f.mat"
    monkeypatch.setattr("gsapp.flight.writers._MOST_BYTES", 50 * 8 - 1)
    with pytest.raises(FlightError, match="50 samples"):
        write_block(path, block, "mat")
    assert not path.exists()
    monkeypatch.setattr("gsapp.flight.writers._MOST_BYTES", 50 * 8)
    assert write_block(path, block, "mat").exists()


def test_parquet_for_others(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    block = sample_block()
    table = parquet.read_table(write_block(tmp_path / "f.parquet", block, "parquet", "si"))
    assert table.schema.field("temperature").metadata[b"unit"] == b"degC"
    assert table.column("alpha").null_count == int(np.isnan(block["alpha"]).sum())


def test_unknown_format_and_units(tmp_path):
    with pytest.raises(UnknownNameError, match="csv, mat, parquet"):
        write_block(tmp_path / "f.xls", sample_block(), "xls")
    with pytest.raises(UnknownNameError, match="us, si, base"):
        write_block(tmp_path / "f.csv", sample_block(), "csv", "imperial")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["h5py", "pyarrow"])
def test_extras_that_are_not_installed(tmp_path, monkeypatch, name):
    # Also for the process that reads.
    (tmp_path / f"{name}.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.setitem(sys.modules, name, None)
    if name == "h5py":
        head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512)
        (tmp_path / "g.mat").write_bytes(head + b"\x89HDF\r\n\x1a\n")
        with pytest.raises(FlightError, match=r"version 7\.3.*pip install .*mat73.*-v7"):
            load_flight(tmp_path / "g.mat")
    else:
        with pytest.raises(FlightError, match=r"pip install .*parquet"):
            write_block(tmp_path / "f.parquet", sample_block(), "parquet")
        (tmp_path / "g.parquet").write_bytes(b"PAR1")
        with pytest.raises(FlightError, match=r"pip install .*parquet"):
            load_flight(tmp_path / "g.parquet")


def test_strangers_csv(tmp_path):
    lines = ["Mode,T (ms),Pitch Rate (deg/s),Speed"]
    lines += [f"AUTO,{k * 20},{k},{-999 if k == 4 else 400 + k}" for k in range(10)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    flight = load_flight(
        path, channel_map=make_map(tmp_path, 'time = "T (ms)"\ntime_unit = "ms"'), rate=50
    )
    assert flight.block.channels == ("q", "V")
    np.testing.assert_allclose(flight.block.times, np.arange(10) * 0.02)
    np.testing.assert_allclose(flight.block["q"], np.deg2rad(np.arange(10.0)))
    knots = (400 + np.arange(10)) * 0.1
    # One sample is missing: within 2.5 periods, so it is bridged.
    np.testing.assert_allclose(flight.block["V"], knots * 0.514444444, rtol=1e-6)
    assert "Pitch Rate" in flight.sources["q"].source


def test_strangers_csv_finds_its_clock(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Time [ms],Pitch Rate (deg/s),Speed\n0,1,2\n10,2,3\n20,3,4\n20,9,9\n10,8,8\n")
    log = read_table(path, load_channel_map(make_map(tmp_path)))
    table = log.table("table", "")
    assert table.times.tolist() == [0.0, 0.01, 0.02]
    assert "2 rows" in log.remarks[0]


@pytest.mark.parametrize(
    ("head", "q", "told"),
    [
        ("", "Pitch Rat (deg/s)", r"did you mean 'Pitch Rate \(deg/s\)'"),
        ("", "xyz", "it has: Mode, T, Pitch Rate"),
        ('time = "clock"', "Pitch Rate (deg/s)", "clock: is no column"),
        ("", "Mode", "'AUTO' is not a number"),
    ],
)
def test_strangers_csv_mistakes(tmp_path, head, q, told):
    path = tmp_path / "log.csv"
    path.write_text("Mode,T,Pitch Rate (deg/s),Speed\nAUTO,0,1,2\nAUTO,1,2,3\n")
    with pytest.raises(FileProblemsError, match=told):
        load_flight(path, channel_map=make_map(tmp_path, head, q))


def test_a_wrong_clock_hides_no_wrong_columns(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Mode,T,Pitch Rate (deg/s),Speed\nAUTO,0,1,2\nAUTO,1,2,3\n")
    with pytest.raises(FileProblemsError) as caught:
        load_flight(path, channel_map=make_map(tmp_path, 'time = "clock"', "Pitch Rat (deg/s)"))
    assert {one.where for one in caught.value.problems} >= {"clock", "Pitch Rat (deg/s)"}


def test_strangers_mat(tmp_path):
    path = tmp_path / "log.mat"
    clock = np.arange(100) * 0.01
    savemat(
        path,
        {
            "gyro": {"time": clock, "rates": np.column_stack([clock, 2 * clock, 3 * clock])},
            "t": np.arange(10) * 0.1,
            "Speed": np.arange(10.0),
        },
    )
    text = MAP.format(head="", q="gyro.rates[1]", v="Speed")
    text = text.replace('unit = "deg/s"', 'unit = "deg/s"\ntime = "gyro.time"')
    (tmp_path / "map.toml").write_text(text)
    flight = load_flight(path, channel_map=tmp_path / "map.toml")
    np.testing.assert_allclose(flight.block["q"], np.deg2rad(2 * flight.block.times), atol=1e-12)
    present = ~np.isnan(flight.block["V"])
    np.testing.assert_allclose(
        flight.block["V"][present], 10 * flight.block.times[present] * 0.0514444444, atol=1e-6
    )
    assert present.sum() == 91


def test_mat_without_map_says_what_it_holds(tmp_path):
    path = tmp_path / "log.mat"
    savemat(path, {"gyro_q": np.arange(5.0), "tt": np.arange(5.0)})
    with pytest.raises(FlightError, match=r"--map.*gyro_q, tt"):
        load_flight(path)


def write_mat_73(path, content):
    """Write variables as MATLAB's save('-v7.3') does."""
    h5py = pytest.importorskip("h5py")

    def put(group, name, value):
        if isinstance(value, dict):
            made = group.create_group(name)
            made.attrs["MATLAB_class"] = np.bytes_("struct")
            for key, one in value.items():
                put(made, key, one)
            return
        if isinstance(value, list):  # an array of structures
            made = group.create_group(name)
            made.attrs["MATLAB_class"] = np.bytes_("struct")
            refs = group.file.require_group("#refs#")
            for key in value[0]:
                held = []
                for one in value:
                    put(refs, f"r{len(refs)}", one[key])
                    held.append(refs[f"r{len(refs) - 1}"].ref)
                made.create_dataset(key, data=np.array([held], dtype=h5py.ref_dtype))
            return
        kind, array = "double", np.atleast_2d(value)
        if isinstance(value, str):
            kind, array = "char", np.array([[ord(letter) for letter in value]], dtype=np.uint16)
        elif array.shape[0] == 1:
            array = array.T
        group.create_dataset(name, data=array.T).attrs["MATLAB_class"] = np.bytes_(kind)

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            put(file, name, value)
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    return path


def test_mat_of_version_73_is_read_as_older_ones(tmp_path):
    """Vectors, matrices, structures and arrays of structures, by the same map and without one."""
    clock = np.arange(60) * 0.02
    content = {
        "gyro": {"time": clock, "rates": np.column_stack([clock, 2 * clock, 3 * clock])},
        "imu": [{"t": clock, "v": clock + 1, "of": "left"}, {"t": clock, "v": -clock, "of": "r"}],
        "Speed": clock * 7,
        "note": "a text",
        "one": 5.0,
    }
    savemat(tmp_path / "old.mat", content)
    old, old_units = read_mat_columns(tmp_path / "old.mat")
    new, new_units = read_mat_columns(write_mat_73(tmp_path / "new.mat", content))
    assert {"gyro.rates", "imu[1].v", "Speed", "one"} <= set(old)
    assert set(new) == set(old)
    assert all(np.array_equal(new[name], old[name]) for name in old)
    assert new_units == old_units == {}
    own = {"time": clock, "q_2": clock, "units": {"time": "s", "q_2": "deg/s"}}
    flight = load_flight(write_mat_73(tmp_path / "own.mat", own))
    np.testing.assert_allclose(flight.block["q.2"], np.deg2rad(clock))


def test_damage_to_mat_files(tmp_path):
    path = tmp_path / "new.mat"
    good = write_block(tmp_path / "good.mat", sample_block(), "mat").read_bytes()
    for cut in (0, 5, 100, 130, 200, 700, len(good) // 2, len(good) - 3):
        path.write_bytes(good[:cut])
        with pytest.raises((FlightError, FileProblemsError), match=r"new\.mat"):
            load_flight(path)
    whole = write_mat_73(path, {"q": np.arange(500.0)}).read_bytes()
    for cut in (520, 600, len(whole) // 2):
        path.write_bytes(whole[:cut])
        with pytest.raises(FlightError, match=r"new\.mat is damaged"):
            load_flight(path)


def test_parquet_damage(tmp_path):
    pytest.importorskip("pyarrow")
    path = write_block(tmp_path / "f.parquet", sample_block(), "parquet")
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(FlightError, match=r"f\.parquet"):
        load_flight(path)


def test_uneven_columns_are_laid_on_a_grid(tmp_path):
    rng = np.random.default_rng(2)
    times = np.arange(400) * 0.01 + rng.uniform(-2e-3, 2e-3, 400)
    path = tmp_path / "f.csv"
    rows = [f"{t!r},{3 * t!r}" for t in times.tolist()]
    path.write_text("time [s],q [rad/s]\n" + "\n".join(rows) + "\n")
    flight = load_flight(path)
    assert flight.rate == pytest.approx(100.0)
    assert "uneven" in flight.remarks[0]
    # Times count in whole microseconds.
    np.testing.assert_allclose(flight.block["q"], 3 * flight.block.times, atol=3e-6)


def test_rows_missing_from_a_csv_are_missing_samples(tmp_path):
    path = tmp_path / "f.csv"
    path.write_text("time [s],q [rad/s],r [rad/s]\n0.00,1,\n0.01,2,5\n0.05,6,6\n0.06,7,7\n")
    flight = load_flight(path)
    assert len(flight.block) == 7
    assert np.isnan(flight.block["q"]).tolist() == [False, False, True, True, True, False, False]
    assert np.isnan(flight.block["r"]).tolist() == [True, False, True, True, True, False, False]


def test_a_rate_resamples(tmp_path):
    path = tmp_path / "f.csv"
    rows = "".join(f"{k * 0.01},{k}\n" for k in range(101))
    path.write_text("time [s],q [rad/s]\n" + rows)
    flight = load_flight(path, rate=25)
    np.testing.assert_allclose(flight.block.times, np.arange(26) / 25)
    np.testing.assert_allclose(flight.block["q"], np.arange(26) * 4.0)
    with pytest.raises(FlightError, match="grid rate of"):
        load_flight(path, rate=-1)


def test_what_is_no_flight(tmp_path):
    with pytest.raises(FlightError, match="no flight"):
        load_flight(tmp_path / "none.csv")
    (tmp_path / "a.pdf").write_text("x")
    with pytest.raises(FlightError, match="unknown file ending"):
        load_flight(tmp_path / "a.pdf")


def test_time_may_be_a_column_of_an_array_and_channels_members_of_many_structures(tmp_path):
    """As MATLAB users keep logs: ``log(:, 1)`` is time, ``imu(2).q`` the second gyro."""
    times = np.arange(0.0, 2.0, 0.01)
    imu = np.zeros(2, dtype=[("q", "O")])
    imu[0], imu[1] = (times * 0.0,), (times * 3.0,)
    log = np.column_stack([times * 1e3, times * 10.0])
    savemat(tmp_path / "x.mat", {"log": log, "imu": imu, "across": log.T})
    stated = 'time = "log[0]"\ntime_unit = "ms"'
    path = make_map(tmp_path, stated, q="imu[1].q", v="log[1]")
    flight = load_flight(tmp_path / "x.mat", channel_map=path)
    np.testing.assert_allclose(flight.block["q"], np.deg2rad(3.0 * times), atol=1e-9)
    for head, q, told in (
        (stated, "across[1]", "shape (2, 200).* transpose it"),
        ('time = "log[7]"', "imu[0].q", "name the column of time"),
    ):
        path = make_map(tmp_path, head, q=q, v="log[1]")
        with pytest.raises(FileProblemsError, match=told.replace("(2, 200)", r"\(2, 200\)")):
            load_flight(tmp_path / "x.mat", channel_map=path)


@pytest.mark.parametrize("mapped", [False, True])
def test_time_counted_in_days_is_no_flight_of_a_million_samples_a_second(tmp_path, mapped):
    head = "time,Pitch Rate (deg/s),Speed" if mapped else "time [s],q [deg/s],V [kt]"
    rows = (f"{46154.4 + k * 0.01 / 86400:.10f},{k},80" for k in range(100))
    path = tmp_path / "excel.csv"
    path.write_text("\n".join((head, *rows)))
    with pytest.raises(FileProblemsError, match=r"1\.2e-07 s"):
        load_flight(path, channel_map=make_map(tmp_path) if mapped else None)


def segments(clock):
    """Return three maneuvers of one flight in structures, one in an array, and what is none."""
    return {
        "el_1": {"time": clock, "q": 2 * clock, "extra": clock + 5, "imu": {"V": clock + 1}},
        "runs": [
            {"time": clock + 7, "q": 3 * clock, "imu": {"V": clock + 2}},
            {"time": clock, "q": 4 * clock, "imu": {"V": clock + 3}},
        ],
        "setup": {"q": 1.0, "note": "trim"},
    }


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_several_structures_of_a_mat_are_several_flights(tmp_path, version):
    """One import and one map; each folder is read by itself and keeps what the map leaves out."""
    path, clock = tmp_path / "day.mat", np.arange(50) * 0.02
    write = savemat if version == "5" else write_mat_73
    write(path, segments(clock))
    chosen = make_map(tmp_path, q="q", v="imu.V")
    with pytest.raises(FlightError, match=r"3 flights: el_1, runs\[0\], runs\[1\].*gsapp import"):
        load_flight(path, channel_map=chosen)
    flights, remarks = import_flights(path, tmp_path / "day", channel_map=chosen)
    assert [flight.name for flight in flights] == ["el_1", "runs_0", "runs_1"]
    for flight, slope in zip(flights, (2, 3, 4), strict=True):
        again = load_flight(tmp_path / "day" / flight.name)
        start = again.block.times[0]
        np.testing.assert_allclose(
            np.rad2deg(again.block["q"]), slope * (again.block.times - start), atol=1e-9
        )
    assert "'setup' was skipped: it has no imu.V" in remarks
    kept, _ = read_mat_columns(tmp_path / "day" / "el_1" / "el_1.mat")
    assert np.array_equal(kept["extra"], clock + 5)
    with pytest.raises(FlightError, match="is taken"):
        import_flights(path, tmp_path / "day", channel_map=chosen)


def test_several_matrices_of_a_mat_are_several_flights(tmp_path):
    """Where a map names columns by place; a file of one matrix is one flight."""
    clock = np.arange(50) * 0.02
    run = np.column_stack([clock, 2 * clock, clock + 1])
    chosen = make_map(tmp_path, 'time = "column[0]"', q="column[1]", v="column[2]")
    savemat(tmp_path / "two.mat", {"a": run, "b": run * 2, "gains": np.eye(2), "n": 3.0})
    flights, remarks = import_flights(tmp_path / "two.mat", tmp_path / "two", channel_map=chosen)
    assert [flight.name for flight in flights] == ["a", "b"]
    assert remarks == ()
    assert flights[1].duration == pytest.approx(2 * 0.98)
    savemat(tmp_path / "one.mat", {"whatever": run})
    assert import_flights(tmp_path / "one.mat", tmp_path / "x", channel_map=chosen) == ((), ())
    flight = load_flight(tmp_path / "one.mat", channel_map=chosen, rate=50)
    np.testing.assert_allclose(np.rad2deg(flight.block["q"]), 2 * clock)


def test_a_part_that_cannot_be_read_is_left_out_and_named(tmp_path):
    content = segments(np.arange(50) * 0.02)
    content["runs"][1]["q"] = np.arange(7.0)
    savemat(tmp_path / "day.mat", content)
    chosen = make_map(tmp_path, q="q", v="imu.V")
    flights, remarks = import_flights(tmp_path / "day.mat", tmp_path / "day", channel_map=chosen)
    assert [flight.name for flight in flights] == ["el_1", "runs_0"]
    assert any("'runs[1]' was skipped" in each and "shape (7,)" in each for each in remarks)
    assert sorted(one.name for one in (tmp_path / "day").iterdir()) == ["el_1", "runs_0"]
    bad = {name: {"time": np.arange(9.0), "q": np.arange(5.0)} for name in ("a", "b")}
    savemat(tmp_path / "bad.mat", bad)
    chosen = make_map(tmp_path, q="q", v="q")
    with pytest.raises(FlightError, match="no flight that can be read"):
        import_flights(tmp_path / "bad.mat", tmp_path / "bad", channel_map=chosen)
    assert not (tmp_path / "bad").exists()


def test_a_structure_that_lacks_a_column_says_which(tmp_path):
    path = tmp_path / "day.mat"
    savemat(path, {"el_1": {"time": np.arange(9.0), "q": np.arange(9.0)}})
    with pytest.raises(FileProblemsError, match=r"imu\.V: is no column of this file"):
        load_flight(path, channel_map=make_map(tmp_path, q="q", v="imu.V"))


@pytest.mark.parametrize(("row", "stamp"), [(0, -1e6), (3, 0.0), (50, 1e6), (50, 0.9), (99, 1e6)])
def test_one_time_that_cannot_be_is_set_aside_and_counted(tmp_path, row, stamp):
    """The other rows keep their moments, and the flight its length."""
    times = 0.1 * np.arange(100)
    stated = times.copy()
    stated[row] = stamp
    path = tmp_path / "f.csv"
    lines = [f"{time:.2f},{k}" for k, time in enumerate(stated)]
    path.write_text("\n".join(["time [s],q [deg/s]", *lines]))
    flight = load_flight(path)
    assert flight.duration == pytest.approx(9.9, abs=0.11)
    assert flight.remarks == ("skipped for impossible times: 1 row of f.csv",)
    there = ~np.isnan(flight.block["q"])
    kept = np.rad2deg(flight.block["q"][there])
    assert kept == pytest.approx(np.delete(np.arange(100.0), row))
    assert flight.block.times[there] == pytest.approx(np.delete(times, row))
