"""What a map leaves out: raw channels, samples at their own times, modes and parameters."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from pymavlink import DFReader
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.settings import DECODING
from gsapp.flight import load_flight
from gsapp.flight.flight_import import import_flight
from gsapp.flight.raw_fields import list_raw_fields, load_raw_field
from gsapp.flight.readers.ulog import read_ulog
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError, UnknownNameError
from tests.flight.test_dataflash import BinWriter

MAP = """
name = "raw"
format = "{format}"
raw = [{raw}]
[[channels]]
id = "q"
source = "{q}"
unit = "rad/s"
"""


def make_map(tmp_path, kind, q, *raw):
    path = tmp_path / "map.toml"
    path.write_text(MAP.format(format=kind, q=q, raw=", ".join(f'"{one}"' for one in raw)))
    return path


@pytest.fixture(scope="module")
def bin_file(tmp_path_factory):
    """Return a log of messages at three rates, with modes and parameters."""
    log = BinWriter()
    log.define("IMU", "QBff", "TimeUS,I,GyrY,T")
    log.define("CTUN", "Qcc", "TimeUS,NavRoll,ThO")
    log.define("PARM", "QNf", "TimeUS,Name,Value")
    log.define("MODE", "QMB", "TimeUS,Mode,ModeNum")
    log.define("MSG", "QZ", "TimeUS,Message")
    log.describe({"#": "instance"}, {}, [("IMU", "-#--", "----")])
    log.write("MSG", 900_000, b"ArduPlane V4.5.7")
    for name, value in (("KFF_RDDRMIX", 0.5), ("ARSPD_RATIO", 2.0)):
        log.write("PARM", 950_000, name.encode(), value)
    log.write("MODE", 960_000, 0, 0)
    for k in range(100):
        for instance in (0, 1):
            log.write("IMU", 1_000_000 + 2_500 * k + instance, instance, k * 0.01, instance + k)
        if k % 7 == 0:
            log.write("CTUN", 1_000_300 + 2_500 * k, 100 * k, -50)
    log.write("MODE", 1_100_000, 5, 5)
    log.write("PARM", 1_150_000, b"ARSPD_RATIO", 2.25)
    path = tmp_path_factory.mktemp("raw") / "flight.bin"
    path.write_bytes(bytes(log.data))
    return path


def test_samples_at_their_own_times_are_those_of_pymavlink(tmp_path, bin_file):
    chosen = make_map(tmp_path, "ardupilot-log", "IMU[0].GyrY")
    block = load_flight(bin_file, channel_map=chosen, raw=["*"], native=True).block
    theirs: dict[str, list[tuple[float, float]]] = {}
    reader = DFReader.DFReader_binary(str(bin_file))
    while (message := reader.recv_msg()) is not None:
        number = f"[{message.I}]" if message.get_type() == "IMU" else ""
        for field in ("GyrY", "T", "NavRoll", "ThO"):
            if field in message.get_fieldnames():
                name = f"{message.get_type()}{number}.{field}"
                pair = (message.TimeUS * 1e-6, getattr(message, field))
                theirs.setdefault(name, []).append(pair)
    reader.close()
    assert {"IMU[0].T", "IMU[1].T", "CTUN.NavRoll", "CTUN.ThO"} <= set(theirs)
    for name, pairs in theirs.items():
        held = ~np.isnan(block[name])
        np.testing.assert_allclose(block.times[held], [time for time, _ in pairs], atol=1e-9)
        np.testing.assert_allclose(block[name][held], [value for _, value in pairs], rtol=1e-6)
    assert np.array_equal(block["q"], block["IMU[0].GyrY"], equal_nan=True)


def test_samples_that_do_not_fit_into_memory_are_refused(bin_file, monkeypatch):
    limited = replace(DECODING, max_native_numbers=1_000)
    monkeypatch.setattr("gsapp.decoding.pipeline.DECODING", limited)
    with pytest.raises(FlightError, match="take fewer raw channels"):
        load_flight(bin_file, raw=["*"], native=True)


def test_raw_channels_lie_on_the_grid_beside_the_others_and_are_held(tmp_path, bin_file):
    """Of fields nobody knows whether there is anything between two samples."""
    chosen = make_map(tmp_path, "ardupilot-log", "IMU[0].GyrY", "CTUN.NavRoll")
    flight = load_flight(bin_file, channel_map=chosen)
    assert set(flight.block.channels) == {"q", "CTUN.NavRoll"}
    raw = flight.block["CTUN.NavRoll"]
    assert set(np.unique(raw[~np.isnan(raw)])) <= {float(k) for k in range(0, 100, 7)}
    assert flight.sources["CTUN.NavRoll"].samples == 15


def test_a_pattern_that_fits_nothing_is_told(tmp_path, bin_file):
    chosen = make_map(tmp_path, "ardupilot-log", "IMU[0].GyrY", "CTUM.NavRoll")
    remarks = load_flight(bin_file, channel_map=chosen).remarks
    assert any("'CTUM.NavRoll'; did you mean 'CTUN.NavRoll'" in one for one in remarks)
    with pytest.raises(UnknownNameError, match=r"'VIBRATIO\.\*'.*did you mean 'VIBRATION'"):
        load_flight(tlog(tmp_path), channel_map="ardupilot-plane", raw=["VIBRATIO.*"])


@pytest.mark.parametrize("to", ["csv", "mat", "parquet"])
def test_native_samples_are_written_and_read_back(tmp_path, bin_file, to):
    if to == "parquet":
        pytest.importorskip("pyarrow")
    chosen = make_map(tmp_path, "ardupilot-log", "IMU[0].GyrY", "IMU.T")
    block = load_flight(bin_file, channel_map=chosen, native=True).block
    back = load_flight(write_block(tmp_path / f"f.{to}", block, to, "base"), native=True).block
    assert set(back.channels) == {"q", "IMU[0].T", "IMU[1].T"}
    assert np.array_equal(back.times, block.times)
    for name in block.channels:
        assert np.array_equal(back[name], block[name], equal_nan=True)
    gridded = load_flight(tmp_path / f"f.{to}")
    assert gridded.rate == pytest.approx(400.0)
    assert np.count_nonzero(~np.isnan(gridded.block["q"])) == 100


def test_modes_and_parameters_of_an_ardupilot_log_are_events(bin_file, tmp_path):
    chosen = make_map(tmp_path, "ardupilot-log", "IMU[0].GyrY")
    import_flight(bin_file, tmp_path / "folder", channel_map=chosen)
    for _ in ("decoded", "from the cache"):
        events = {one.kind: one for one in load_flight(tmp_path / "folder").events}
        assert events["mode"].text == "Flight mode FLY_BY_WIRE_A"
        assert events["mode"].time == pytest.approx(1.1)
        assert dict(events["parameters"].data) == {"KFF_RDDRMIX": 0.5, "ARSPD_RATIO": 2.0}
        assert dict(events["parameter"].data) == {"name": "ARSPD_RATIO", "value": 2.25}


def tlog(tmp_path):
    """Return a MAVLink log: attitude and vibration, a mode, a parameter that changes."""
    link, data = mavlink.MAVLink(None, srcSystem=1, srcComponent=1), bytearray()

    def send(stamp, message):
        nonlocal data
        data += struct.pack(">Q", 1_700_000_000_000_000 + stamp) + message.pack(link)

    for k in range(60):
        stamp = 20_000 * k
        if k % 20 == 0:
            mode = 10 if k < 40 else 11
            send(stamp, mavlink.MAVLink_heartbeat_message(1, 3, 81, mode, 4, 3))
        boot = 5_000 + stamp // 1000
        send(stamp, mavlink.MAVLink_attitude_message(boot, 0.1, 0.0, 0.0, 0.0, k * 0.01, 0.0))
        if k % 3 == 0:
            usec = 5_000_000 + stamp
            send(stamp, mavlink.MAVLink_vibration_message(usec, float(k), 0, 0, k, 0, 0))
        if k in (5, 50):
            send(stamp, mavlink.MAVLink_param_value_message(b"TRIM_ARSPD_CM", float(k), 9, 1, 0))
    path = tmp_path / "flight.tlog"
    path.write_bytes(bytes(data))
    return path


def test_fields_modes_and_parameters_of_a_mavlink_record(tmp_path):
    chosen = make_map(tmp_path, "mavlink", "ATTITUDE.pitchspeed")
    path = tlog(tmp_path)
    flight = load_flight(path, channel_map=chosen, raw=["VIBRATION.*", "*.roll"], native=True)
    block = flight.block
    held = ~np.isnan(block["VIBRATION.vibration_x"])
    assert block["VIBRATION.vibration_x"][held].tolist() == [3.0 * k for k in range(20)]
    np.testing.assert_allclose(block.times[held], 5.0 + 0.06 * np.arange(20), atol=1e-6)
    assert np.count_nonzero(~np.isnan(block["ATTITUDE.roll"])) == 60
    modes = [event.text for event in flight.events if event.kind == "mode"]
    assert modes == ["Flight mode AUTO", "Flight mode RTL"]
    (first,) = [event for event in flight.events if event.kind == "parameters"]
    (changed,) = [event for event in flight.events if event.kind == "parameter"]
    assert dict(first.data) == {"TRIM_ARSPD_CM": 5.0}
    assert changed.data["value"] == 50.0
    gridded = load_flight(path, channel_map=chosen, raw=["VIBRATION.clipping_0"])
    assert "VIBRATION.clipping_0" in gridded.block.channels


def test_a_map_names_raw_fields_for_the_live_link_too(tmp_path):
    chosen = load_channel_map(make_map(tmp_path, "mavlink", "ATTITUDE.pitchspeed", "VIBRATION.*"))
    flight = load_flight(tlog(tmp_path), channel_map=chosen)
    assert sum(name.startswith("VIBRATION.") for name in flight.block.channels) == 6


def test_modes_and_parameters_of_a_px4_log(shared_data):
    log = read_ulog(shared_data / "f16_rc_px4.ulg")
    kinds = {event.kind: event for event in log.events}
    assert kinds["mode"].text == "Flight mode MANUAL"
    assert kinds["parameters"].data["FW_AIRSPD_TRIM"] > 0.0


def test_every_number_of_a_log_is_listed_and_read_at_its_own_times(bin_file, tmp_path):
    log_map = make_map(tmp_path, "ardupilot-log", "IMU.GyrY")
    folder = import_flight(bin_file, tmp_path / "flight", channel_map=log_map).path
    for path in (folder, bin_file):
        names = list_raw_fields(path)
        assert {"IMU[1].T", "CTUN.NavRoll", "CTUN.ThO"} <= set(names)
        assert not [name for name in names if name.endswith("TimeUS")]
    times, values = load_raw_field(folder, "CTUN.NavRoll")
    assert times[:2] == pytest.approx([1.0003, 1.0178])
    assert values[:2] == pytest.approx([0.0, 7.0])
    with pytest.raises(FlightError, match=r"CTUN\.Roll"):
        load_raw_field(folder, "CTUN.Roll")


def test_a_table_has_no_fields_of_messages(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text("time [s],q [deg/s]\n0,1\n0.1,2\n")
    assert list_raw_fields(path) == ()
