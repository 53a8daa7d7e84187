"""Opening flights from raw files and logs: values, cache, summary, import and export."""

import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from calibration import load_certificates
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.cli._usage_errors import CommandUsageError
from gsapp.cli.flight_files import export, import_
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight import load_flight
from gsapp.flight.events import Event
from gsapp.flight.flight import Flight
from gsapp.flight.flight_import import import_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.summary import channel_statistics, summarize_flight
from gsapp.foundation import FileProblemsError, FlightError, GroundStationError, UnknownNameError
from gsapp.quantities import Block

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as dialect

from tests.flight.box_kit import START_US, box_tlog

ALFA = "alfa_carbonz_engine_failure.tlog"
F16 = "f16_rc_px4.ulg"


@pytest.fixture
def box_folder(tmp_path):
    folder = FlightFolder.create(tmp_path / "flight", FlightInfo(name="Box test"))
    folder.tlog_file.write_bytes(box_tlog(lost={100, 101, 102, 103}))
    folder.store_channel_map(MAPS.find("b777"))
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    return folder


def test_folder_is_decoded_calibrated_and_summed_up(box_folder):
    """Volts become the rates they stand for, at the vehicle's times; lost frames are a gap."""
    box_folder.events.append(Event(kind="mark", text="doublet", time=11.5))
    flight = load_flight(box_folder.path)
    block = flight.block
    assert flight.name == "Box test"
    assert flight.rate == pytest.approx(100.0)
    assert block.times[0] == pytest.approx(10.0)
    there = ~np.isnan(block["q"])
    # DEBUG_FLOAT_ARRAY holds 32-bit floats.
    np.testing.assert_allclose(block["q"][there], 0.2 * np.sin(block.times[there]), atol=1e-5)
    np.testing.assert_allclose(block["alpha"][there], np.deg2rad(3.0), atol=1e-6)
    assert (~there).sum() == 4
    assert flight.sources["q"].calibrated
    assert flight.frames.good == 298
    assert flight.frames.lost == 4
    assert [event.text for event in flight.events] == ["recorder ready", "doublet"]

    summary = summarize_flight(flight)
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert set(summary) == {
        "duration", "channels", "calibration", "onboard", "frames", "events", "cues", "maneuvers",
    }  # fmt: skip
    q = summary["channels"]["q"]
    assert set(q) == {
        "count", "rate", "min", "max", "mean", "gaps", "source", "measured", "calibrated",
    }  # fmt: skip
    assert (q["count"], q["gaps"], q["measured"]) == (296, 1, True)
    assert q["rate"] == pytest.approx(100.0)
    assert q["mean"] == pytest.approx(np.nanmean(block["q"]))
    assert summary["duration"] == pytest.approx(2.99)
    assert summary["frames"] == {
        "good": 298, "damaged": 0, "unknown": 0, "lost": 4, "lines": 0, "bad_lines": 0,
    }  # fmt: skip
    assert summary["channels"]["de"]["measured"] is False


def test_cache_gives_the_same_flight_and_is_never_trusted(box_folder, monkeypatch):
    """A cached flight is equal; damage, another file, map or setting builds it anew."""
    first = load_flight(box_folder.path)
    cached = next(box_folder.cache_folder.glob("*.npz"))

    def forbidden(*_, **__):
        raise AssertionError("decoded again")

    with monkeypatch.context() as patch:
        patch.setattr("gsapp.flight.read_settings.Decoder", forbidden)
        second = load_flight(box_folder.path)
        with pytest.raises(AssertionError, match="decoded again"):
            load_flight(box_folder.path, rate=50)
        box_folder.tlog_file.write_bytes(box_tlog(lost={100}))
        with pytest.raises(AssertionError, match="decoded again"):
            load_flight(box_folder.path)
        box_folder.tlog_file.write_bytes(box_tlog(lost={100, 101, 102, 103}))
        load_flight(box_folder.path)
        text = box_folder.channel_map_file.read_text()
        box_folder.channel_map_file.write_text(text.replace("priority = 1", "priority = 2") + "\n")
    assert np.array_equal(first.block.values, second.block.values, equal_nan=True)
    assert first.block.channels == second.block.channels
    assert first.sources == second.sources
    assert first.events == second.events
    assert first.frames == second.frames
    for damage in (b"", b"PK\x03\x04" + bytes(50), cached.read_bytes()[:-300]):
        cached.write_bytes(damage)
        again = load_flight(box_folder.path)
        assert np.array_equal(first.block.values, again.block.values, equal_nan=True)
    content = bytearray(cached.read_bytes())
    content[len(content) // 2] ^= 0xFF
    cached.write_bytes(content)
    again = load_flight(box_folder.path)
    assert np.array_equal(first.block.values, again.block.values, equal_nan=True)


_CODE = """
import sys
from pathlib import Path

import gsapp.flight.flight_loader
from gsapp.flight import cache

counted = set()
read = Path.read_bytes
Path.read_bytes = lambda path: counted.add(path) or read(path)
cache._code_hash()
used = {name: module.__file__ for name, module in sys.modules.items()
        if name.partition(".")[0] in ("gsapp", "calibration") and module.__file__}
assert len(counted) > 50
print(*(name for name, file in used.items() if Path(file) not in counted))
"""


def test_a_cache_does_not_outlive_the_code_that_made_it():
    ran = subprocess.run([sys.executable, "-c", _CODE], capture_output=True, text=True, check=True)
    left_out = {".".join(name.split(".")[:2]) for name in ran.stdout.split()}
    assert left_out <= {"gsapp", "gsapp.foundation", "gsapp.aircraft"}


def test_no_cache_where_nothing_may_be_written(box_folder):
    box_folder.cache_folder.write_text("a file in the way")
    assert load_flight(box_folder.path).block.times.size == 300


def test_growing_and_empty_folders(tmp_path):
    folder = FlightFolder.create(tmp_path / "f")
    flight = load_flight(folder.path)
    assert len(flight.block) == 0
    assert summarize_flight(flight)["duration"] == 0.0
    whole = box_tlog(1.0)
    folder.tlog_file.write_bytes(whole[:-20])
    folder.store_channel_map(MAPS.find("b777"))
    flight = load_flight(folder.path)
    assert len(flight.block) == 99
    assert any("incomplete" in remark for remark in flight.remarks)


def test_a_pause_of_a_day_costs_no_memory(tmp_path):
    path = tmp_path / "two.tlog"
    second = box_tlog(1.0, start_s=86_400.0)
    shifted = bytearray()
    place = 0
    while place < len(second):
        (stamp,) = struct.unpack_from(">Q", second, place)
        length = 12 + second[place + 9]
        shifted += struct.pack(">Q", stamp + 86_390_000_000)
        shifted += second[place + 8 : place + 8 + length]
        place += 8 + length
    path.write_bytes(box_tlog(1.0) + bytes(shifted))
    flight = load_flight(path)
    assert len(flight.block) < 1000
    assert flight.duration == pytest.approx(86_390.99)
    assert (~np.isnan(flight.block["q"])).sum() >= 195


def test_text_lines_and_the_rate_of_the_folder(tmp_path):
    info = FlightInfo.model_validate({"grid_rate": "50 Hz"})
    folder = FlightFolder.create(tmp_path / "f", info)
    (tmp_path / "map.toml").write_text(
        'name = "lines"\n[text]\ncolumns = ["time [ms]", "alpha [deg]", "", "q [deg/s]"]\n'
    )
    folder.store_channel_map(tmp_path / "map.toml")
    lines = [f"{START_US + k * 20_000}\t{k * 20},{k},7,{2 * k}" for k in range(100)]
    lines[40] = f"{START_US + 40 * 20_000}\tgarbled"
    (folder.path / "raw.txt").write_text("\n".join(lines) + "\n")
    flight = load_flight(folder.path)
    assert flight.rate == pytest.approx(50.0)
    np.testing.assert_allclose(flight.block["q"], 2 * flight.block["alpha"])
    np.testing.assert_allclose(flight.block["alpha"], np.deg2rad(flight.block.times * 50))
    assert any("garbled" in event.text for event in flight.events)
    assert load_flight(folder.path, rate=25).rate == pytest.approx(25.0)


def test_map_is_guessed_or_asked_for(tmp_path):
    path = tmp_path / "box.tlog"
    path.write_bytes(box_tlog(1.0))
    assert "q" in load_flight(path).block
    sender = dialect.MAVLink(None, srcSystem=1)
    frame = sender.heartbeat_encode(0, 0, 0, 0, 0).pack(sender)
    path.write_bytes(struct.pack(">Q", START_US) + frame)
    with pytest.raises(FlightError, match=r"--map.*ardupilot-plane"):
        load_flight(path)
    with pytest.raises(UnknownNameError, match="did you mean 'b777'"):
        load_flight(path, channel_map="b77")
    with pytest.raises(FlightError, match="ardupilot-log"):
        load_flight(path, channel_map="ardupilot-log")


def test_damage_in_a_tlog_is_told(tmp_path):
    data = bytearray(box_tlog(1.0))
    data[5000:5040] = bytes(40)
    path = tmp_path / "d.tlog"
    path.write_bytes(data)
    flight = load_flight(path, channel_map="b777")
    assert flight.frames.damaged == 1
    assert any("skipped" in remark for remark in flight.remarks)
    assert 90 < (~np.isnan(flight.block["q"])).sum() <= 100


def test_real_flight_agrees_with_pymavlink(shared_data):
    flight = load_flight(shared_data / ALFA)
    assert flight.frames.good == 26183
    log = mavutil.mavlink_connection(str(shared_data / ALFA))
    times, rolls = [], []
    while (message := log.recv_match(type="ATTITUDE")) is not None:
        if message.get_srcComponent() == 1 or not times:
            times.append(message.time_boot_ms * 1e-3)
            rolls.append(message.roll)
    index = np.rint((np.array(times) - flight.block.times[0]) * 100).astype(int)
    inside = (index >= 0) & (index < len(flight.block))
    on_grid = np.abs(np.array(times) * 100 - np.rint(np.array(times) * 100)) < 1e-6
    chosen = inside & on_grid
    assert chosen.sum() > 20
    np.testing.assert_allclose(
        flight.block["phi"][index[chosen]], np.array(rolls)[chosen], atol=1e-7
    )
    summary = summarize_flight(flight)
    assert summary["channels"]["Vc"]["min"] == pytest.approx(9.7, abs=0.15)
    assert summary["duration"] == pytest.approx(132.3, abs=0.5)


def test_real_px4_log_agrees_with_pyulog(shared_data):
    """sensor_combined of the F-16 log, 200 Hz, is that of pyulog, interpolated."""
    pyulog = pytest.importorskip("pyulog")
    flight = load_flight(shared_data / F16, rate=200)
    data = pyulog.ULog(str(shared_data / F16), ["sensor_combined"]).data_list[0].data
    times = data["timestamp"] * 1e-6
    there = (flight.block.times >= times[0]) & (flight.block.times <= times[-1])
    there &= ~np.isnan(flight.block["q"])
    expected = np.interp(flight.block.times[there], times, data["gyro_rad[1]"])
    np.testing.assert_allclose(flight.block["q"][there], expected, atol=1e-9)
    # What arrived, not the rows of the grid.
    arrived = 1.0 / float(np.median(np.diff(times)))
    assert summarize_flight(flight)["channels"]["q"]["rate"] == pytest.approx(arrived, rel=1e-3)
    assert any("Takeoff detected" in event.text for event in flight.events)


@pytest.mark.parametrize("cut", [0.99, 0.5, 0.02])
def test_torn_px4_log_opens_as_far_as_it_is_good(tmp_path, shared_data, cut):
    data = (shared_data / F16).read_bytes()
    path = tmp_path / "t.ulg"
    path.write_bytes(data[: int(len(data) * cut)])
    try:
        flight = load_flight(path)
    except GroundStationError as error:
        assert cut < 0.1, error  # noqa: PT017
    else:
        assert flight.duration == pytest.approx(60.0 * cut, rel=0.25)


def test_files_that_are_no_ulog(tmp_path):
    path = tmp_path / "x.ulg"
    path.write_bytes(b"hello")
    with pytest.raises(FlightError, match="PX4"):
        load_flight(path)
    path.write_bytes(b"ULog\x01\x12\x35" + b"\xff" * 300)
    with pytest.raises(GroundStationError, match=r"x\.ulg"):
        load_flight(path)


def wandering(time):
    return np.sin(time * (1.0 + 0.05 * time)) + 0.5 * np.sin(2.3 * time)


@pytest.mark.parametrize("clock_s", [0.0, 37.0])
def test_onboard_log_replaces_the_live_record(tmp_path, clock_s):
    folder = FlightFolder.create(tmp_path / "f")
    folder.store_channel_map(MAPS.find("b777"))
    folder.tlog_file.write_bytes(box_tlog(20.0, every=5, motion=wandering, lost={500, 505, 510}))
    thin = load_flight(folder.path)
    log = tmp_path / "onboard.tlog"
    log.write_bytes(box_tlog(15.0, start_s=12.0, motion=wandering, clock_s=clock_s))
    folder.store_onboard_log(log)
    flight = load_flight(folder.path)

    def error(each, start, stop):
        part = each.block.between(start, stop)
        return np.nanmax(np.abs(part["q"] - 0.2 * wandering(part.times)))

    assert flight.block.times[0] == thin.block.times[0]
    # The live record is 20 Hz, so between its samples it is off; the log is not.
    assert error(thin, 13.0, 26.0) > 5e-4
    assert error(flight, 13.0, 26.0) < 1e-5
    assert not np.isnan(flight.block.between(13.0, 26.0)["q"]).any()
    assert np.isnan(thin.block["q"]).any()
    assert (~np.isnan(flight.block.between(10.0, 11.9)["q"])).all()
    assert flight.sources["q"].source.startswith("on-board log: ")
    assert any("clock differs by -37.000 s" in remark for remark in flight.remarks) == bool(clock_s)
    assert flight.onboard.in_place
    assert flight.onboard.clock.offset == pytest.approx(-clock_s, abs=1e-3)


def test_onboard_log_of_another_flight_is_left_out(tmp_path):
    """A log that moves otherwise, or cannot be read, does not replace anything, and is told."""
    folder = FlightFolder.create(tmp_path / "f")
    folder.store_channel_map(MAPS.find("b777"))
    folder.tlog_file.write_bytes(box_tlog(20.0, every=5, motion=wandering))
    live = load_flight(folder.path)
    other = np.random.default_rng(1).normal(size=3000)
    log = tmp_path / "onboard.tlog"
    log.write_bytes(box_tlog(15.0, motion=lambda time: other[int(time * 100)]))
    folder.store_onboard_log(log)
    flight = load_flight(folder.path)
    assert any("aligned" in remark for remark in flight.remarks)
    assert np.array_equal(flight.block.values, live.block.values, equal_nan=True)
    log = tmp_path / "1.bin"
    log.write_bytes(b"no log at all" * 30)
    folder.store_onboard_log(log)
    flight = load_flight(folder.path)
    assert any("not used" in remark and "1.bin" in remark for remark in flight.remarks)
    assert np.array_equal(flight.block.values, live.block.values, equal_nan=True)


# --- import and export ----------------------------------------------------------------------


def test_import_of_a_tlog_keeps_every_byte(tmp_path, capsys):
    source = tmp_path / "box.tlog"
    source.write_bytes(box_tlog())
    import_(files=[source], out=tmp_path / "flights" / "one")
    assert "written to" in capsys.readouterr().out
    folder = FlightFolder.open(tmp_path / "flights" / "one")
    assert folder.tlog_file.read_bytes() == source.read_bytes()
    info = folder.info()
    assert (info.source, info.date.timestamp()) == ("box.tlog", START_US / 1e6)
    assert len(folder.certificate_files()) == len(load_certificates("b777"))
    source_flight, flight = load_flight(source), load_flight(folder.path)
    assert np.array_equal(source_flight.block.values, flight.block.values, equal_nan=True)
    assert [path.name for path in folder.path.parent.iterdir()] == ["one"]


def test_import_of_a_table_can_be_read_with_another_map(tmp_path):
    source = tmp_path / "log.csv"
    source.write_text("t,gx,gy\n" + "".join(f"{k / 50},{k},{2 * k}\n" for k in range(100)))
    for name in ("gx", "gy"):
        (tmp_path / f"{name}.toml").write_text(
            f'name = "{name}"\nformat = "table"\n[[channels]]\nid = "q"\nsource = "{name}"\n'
            'unit = "deg/s"\n'
        )
    import_flight(source, tmp_path / "one", channel_map=tmp_path / "gx.toml")
    folder = FlightFolder.open(tmp_path / "one")
    assert folder.onboard_log().read_bytes() == source.read_bytes()
    assert folder.info().date is None
    source.unlink()
    flight = load_flight(folder.path, rate=50)
    np.testing.assert_allclose(flight.block["q"], np.deg2rad(np.arange(100)))
    other = load_flight(folder.path, rate=50, channel_map=tmp_path / "gy.toml")
    np.testing.assert_allclose(other.block["q"], np.deg2rad(2 * np.arange(100)))
    assert np.array_equal(load_flight(folder.path, rate=50).block["q"], flight.block["q"])


def test_import_of_a_flight_csv_and_of_no_log(tmp_path):
    csv = tmp_path / "f.csv"
    csv.write_text("time [s],q [deg/s]\n0,1\n0.01,2\n0.02,3\n")
    flight = import_flight(csv, tmp_path / "csv")
    again = load_flight(tmp_path / "csv")
    assert np.array_equal(flight.block.values, again.block.values)
    assert again.sources["q"].source == "column q [deg/s]"
    (tmp_path / "x.bin").write_bytes(b"nothing of the kind" * 9)
    with pytest.raises(FlightError, match="not an ArduPilot"):
        import_flight(tmp_path / "x.bin", tmp_path / "bin")
    assert not (tmp_path / "bin").exists()


@pytest.mark.parametrize("taken", ["file", "folder"])
def test_import_never_writes_over_anything(tmp_path, taken):
    source = tmp_path / "f.csv"
    source.write_text("time [s],q [deg/s]\n0,1\n0.01,2\n")
    out = tmp_path / "out"
    if taken == "file":
        out.write_text("mine")
    else:
        out.mkdir()
        (out / "mine").write_text("mine")
    with pytest.raises(FlightError, match="is taken"):
        import_flight(source, out)
    with pytest.raises(FlightError, match="is a folder"):
        import_flight(tmp_path, tmp_path / "new")
    source.write_text("time [s],q [furlong]\n0,1\n")
    with pytest.raises(FileProblemsError, match="furlong"):
        import_flight(source, tmp_path / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["f.csv", "out"]


@pytest.mark.parametrize("to", ["csv", "mat", "parquet"])
def test_export_of_a_folder(box_folder, tmp_path, to, capsys):
    out = tmp_path / f"out.{to}"
    export(flight=box_folder.path, to=to, out=out, units="base")
    assert "written to" in capsys.readouterr().out
    flight, back = load_flight(box_folder.path), load_flight(out)
    assert set(back.block.channels) == set(flight.block.channels)
    assert np.array_equal(back.block.times, flight.block.times)
    for name in flight.block.channels:
        assert np.array_equal(back.block[name], flight.block[name], equal_nan=True), name


def test_import_and_export_write_their_results_for_programs(box_folder, tmp_path, capsys):
    table = tmp_path / "f.csv"
    export(flight=box_folder.path, to="csv", out=table, json=Path("-"))
    written = json.loads(capsys.readouterr().out)
    assert (written["file"], written["format"]) == (str(table), "csv")
    assert written["units"]["time"] == "s"
    assert written["units"]["alpha"] == "deg"
    flight = load_flight(box_folder.path)
    assert written["rows"] == len(flight.block)
    assert {name: written[name] for name in summarize_flight(flight)} == summarize_flight(flight)
    import_(files=[table], out=tmp_path / "new", json=tmp_path / "import.json")
    assert "written to" in capsys.readouterr().out
    imported = json.loads((tmp_path / "import.json").read_text(encoding="utf-8"))
    assert imported["flight"] == str(tmp_path / "new")
    assert imported["channels"]["alpha"]["count"] == int(
        np.count_nonzero(~np.isnan(flight.block["alpha"]))
    )


def test_export_refuses_before_it_reads(tmp_path, box_folder):
    with pytest.raises(CommandUsageError, match="csv, mat, parquet"):
        export(flight=tmp_path / "none", to="xlsx", out=tmp_path / "x")
    with pytest.raises(CommandUsageError, match="us, si, base"):
        export(flight=tmp_path / "none", to="csv", out=tmp_path / "x", units="uk")
    empty = FlightFolder.create(tmp_path / "empty")
    with pytest.raises(FlightError, match="no samples"):
        export(flight=empty.path, to="csv", out=tmp_path / "x")
    with pytest.raises(FlightError, match="is a folder"):
        export(flight=box_folder.path, to="csv", out=tmp_path)
    assert not (tmp_path / "x").exists()


def test_statistics_of_one_channel():
    times = np.arange(1000) / 100
    slow = np.full(1000, np.nan)
    slow[::20] = 1.0
    numbers = channel_statistics(times, slow)
    assert (numbers["count"], numbers["gaps"]) == (50, 0)
    assert numbers["rate"] == pytest.approx(5.0)
    slow[400:500] = np.nan
    assert channel_statistics(times, slow)["gaps"] == 1
    nothing = channel_statistics(times, np.full(1000, np.nan))
    assert (nothing["count"], nothing["rate"], nothing["min"]) == (0, None, None)


@pytest.mark.parametrize("south", [False, True])
def test_the_mean_of_a_heading_lies_where_it_was_flown(south: bool):
    times = np.arange(900) / 100
    swing = np.radians(40.0) * np.sin(times) + np.radians(3.0)
    flown = swing + np.pi if south else swing
    heading = (flown + np.pi) % (2.0 * np.pi) - np.pi
    block = Block(channels=("psi", "q"), times=times, values=np.column_stack([heading, heading]))
    flight = Flight(name="turn", path=Path("turn.csv"), block=block, sources={})
    channels = summarize_flight(flight)["channels"]
    mean = swing.mean() - np.pi if south else swing.mean()
    assert channels["psi"]["mean"] == pytest.approx(mean, abs=1e-12)
    assert channels["q"]["mean"] == pytest.approx(heading.mean())
