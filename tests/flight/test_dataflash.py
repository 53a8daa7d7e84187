"""ArduPilot's .bin logs: decoded as pymavlink's reader does, and past damage where it is not."""

import contextlib
import random
import struct

import numpy as np
import pytest
from pymavlink import DFReader

from gsapp.flight import load_flight
from gsapp.flight.readers.dataflash import read_dataflash
from gsapp.foundation import FlightError

SIZES = {
    "a": "32h", "b": "b", "B": "B", "g": "e", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f",
    "d": "d", "n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i",
    "M": "B", "q": "q", "Q": "Q",
}  # fmt: skip


class BinWriter:
    """Writes .bin logs as the vehicle does: FMT first, then records."""

    def __init__(self):
        self.data = bytearray()
        self.types = {}
        self.define("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", kind=128)

    def define(self, name, letters, columns, kind=None):
        kind = kind or 129 + len(self.types)
        form = "<" + "".join(SIZES[letter] for letter in letters)
        self.types[name] = (kind, form)
        length = struct.calcsize(form) + 3
        self.write("FMT", kind, length, name.encode(), letters.encode(), columns.encode())
        return kind

    def write(self, name, *values):
        kind, form = self.types[name]
        self.data += b"\xa3\x95" + bytes([kind]) + struct.pack(form, *values)
        return self

    def describe(self, units, factors, rows):
        self.define("UNIT", "QbZ", "TimeUS,Id,Label")
        self.define("MULT", "Qbd", "TimeUS,Id,Mult")
        self.define("FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
        for letter, label in units.items():
            self.write("UNIT", 0, ord(letter), label.encode())
        for letter, factor in factors.items():
            self.write("MULT", 0, ord(letter), factor)
        for name, unit_ids, factor_ids in rows:
            self.write("FMTU", 0, self.types[name][0], unit_ids.encode(), factor_ids.encode())


def flight_log(count=200, seed=1):
    """Return the bytes of a small flight and the offsets where each record begins."""
    rng = random.Random(seed)
    log = BinWriter()
    log.define("IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    log.define("ATT", "QccC", "TimeUS,Roll,Pitch,Yaw")
    log.define("BARO", "Qfef", "TimeUS,Press,Alt,Temp")
    log.define("POS", "QLLe", "TimeUS,Lat,Lng,Alt")
    log.define("MSG", "QZ", "TimeUS,Message")
    log.describe(
        {"s": "s", "E": "rad/s", "o": "m/s/s", "d": "deg", "h": "degheading", "P": "Pa", "m": "m",
         "O": "degC", "D": "deglatitude", "U": "deglongitude", "#": "instance"},
        {"F": 1e-6, "0": 1.0, "B": 1e-2, "G": 1e-7, "-": 0.0, "?": 1.0},
        [("IMU", "s#EEEooo", "F-000000"), ("ATT", "sddh", "FBBB"), ("BARO", "sPmO", "F0B0"),
         ("POS", "sDUm", "FGGB")],
    )  # fmt: skip
    log.write("MSG", 1_000_000, b"ArduPlane V4.5.7")
    starts = []
    for k in range(count):
        stamp = 1_000_000 + k * 10_000
        for instance in (0, 1):
            starts.append(len(log.data))
            log.write("IMU", stamp, instance, *(rng.uniform(-5, 5) for _ in range(6)))
        starts.append(len(log.data))
        log.write("ATT", stamp, rng.randint(-9000, 9000), rng.randint(-4000, 4000), 35900)
        if k % 10 == 0:
            log.write("BARO", stamp, rng.uniform(9e4, 1e5), rng.randint(0, 40000), 20.5)
            log.write("POS", stamp, 473977418, 85455938, 48800)
    return bytes(log.data), starts


@pytest.fixture
def decoded(tmp_path):
    """Read these bytes as a log."""

    def read(data):
        path = tmp_path / "read.bin"
        path.write_bytes(data)
        return read_dataflash(path)

    return read


@pytest.fixture
def bin_file(tmp_path):
    path = tmp_path / "00000042.BIN"
    path.write_bytes(flight_log()[0])
    return path


def test_every_value_is_that_of_pymavlink(bin_file):
    log = read_dataflash(bin_file)
    assert log.remarks == ()
    theirs = DFReader.DFReader_binary(str(bin_file))
    met: dict[tuple[str, str], int] = {}
    while (message := theirs.recv_msg()) is not None:
        name = message.get_type()
        if name not in {"IMU", "ATT", "BARO", "POS"}:
            continue
        key = (name, str(message.I) if name == "IMU" else "")
        row = met.get(key, 0)
        met[key] = row + 1
        table = log.tables[key]
        assert table.times[row] == pytest.approx(message.TimeUS * 1e-6, abs=1e-9)
        for field in message.get_fieldnames():
            if field != "TimeUS":
                assert table.fields[field][row] == pytest.approx(getattr(message, field)), field
    assert met == {key: table.times.size for key, table in log.tables.items() if key in met}
    assert met["IMU", "1"] == 200
    theirs.close()


OLD_GPS = "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T"
WEEK_MS = 220_000_000


def old_log(seconds=60, fixed_after=10):
    """Return a log as ArduPilot 3.1 writes it: GPS with the time of week, texts without a time."""
    log = BinWriter()
    log.define("MSG", "Z", "Message")
    log.define("IMU", "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    log.define("GPS", "BIHBcLLeeEefI", OLD_GPS)
    log.define("STRT", "IB", "TimeMS,I")
    log.write("MSG", b"ArduPlane V3.1.2")
    for k in range(seconds * 50):
        now = 70_000 + 20 * k
        log.write("IMU", now, 0.01, 0.02, 0.03, 0.1, 0.2, -9.8)
        if k % 10 == 0:
            fix = k >= 50 * fixed_after
            place = (428_528_940, -26_456_880) if fix else (374_000_000, -1_220_800_000)
            week = (WEEK_MS + 20 * k, 1821) if fix else (0, 0)
            log.write("GPS", 3 if fix else 1, *week, 9 if fix else 0, 120, *place, 0, 0, 1500, 0, 0,
                      now + 3)  # fmt: skip
        if k == 25 * seconds:
            log.write("MSG", b"half time")
            log.write("STRT", 3_999_999_999, 1)
    return bytes(log.data)


def test_gps_stamped_with_the_time_of_week_is_timed_by_its_order(tmp_path):
    """The flight lasts what it lasted, and every position is within one record of its moment."""
    path = tmp_path / "old.bin"
    path.write_bytes(old_log())
    flight = load_flight(path)
    assert flight.duration == pytest.approx(60.0, abs=0.05)
    assert [event.time for event in flight.events] == pytest.approx([70.0, 100.0], abs=0.02)
    assert [remark for remark in flight.remarks if "GPS" in remark] == [
        "GPS has no stamp of the vehicle's clock: timed by its order in the log"
    ]
    assert flight.sources["ground_speed"].timing == "arrival"
    assert flight.sources["p"].timing == "vehicle"
    # Ten seconds without a fix, the receiver's factory in place of its own.
    latitude = np.rad2deg(flight.block["latitude"])
    assert np.nanmin(latitude) == pytest.approx(42.852894)
    assert flight.block.times[~np.isnan(latitude)].min() == pytest.approx(80.0, abs=0.05)
    assert flight.sources["latitude"].samples == 250
    assert flight.sources["latitude"].rate == pytest.approx(5.0, rel=0.01)
    assert np.nanmin(flight.block["gps_satellites"]) == 0.0
    assert np.nanmax(flight.block["gps_hdop"]) == pytest.approx(1.2)
    log = read_dataflash(path)
    gps = log.tables["GPS", ""]
    assert gps.times == pytest.approx(gps.fields["T"] / 1000.0, abs=0.02)
    assert log.tables["STRT", ""].times.size == 0
    assert "1 sample of STRT" in log.tables["STRT", ""].remark


@pytest.mark.parametrize(
    ("text", "said"),
    [("ArduPlane V4.5.7", ""), ("ArduCopter V3.3", "copter"), ("APM:Copter V3.3-dev", "copter")],
)
def test_a_map_for_airplanes_on_another_vehicle_is_told(tmp_path, text, said):
    log = BinWriter()
    log.define("MSG", "QZ", "TimeUS,Message")
    log.define("IMU", "Qfff", "TimeUS,GyrX,GyrY,GyrZ")
    log.define("RCOU", "QHHH", "TimeUS,C1,C2,C4")
    log.write("MSG", 1_000_000, text.encode())
    for k in range(50):
        log.write("IMU", 1_000_000 + 20_000 * k, 0.1, 0.2, 0.3)
        log.write("RCOU", 1_000_000 + 20_000 * k, 1500, 1500, 1500)
    path = tmp_path / "x.bin"
    path.write_bytes(log.data)
    found = [one for one in load_flight(path).remarks if "no control surfaces" in one]
    assert len(found) == bool(said)
    assert not said or (f"a record of a {said}," in found[0] and "de_command" in found[0])


def test_units_and_multipliers_of_the_log(bin_file):
    log = read_dataflash(bin_file)
    assert log.tables["IMU", "0"].units["GyrX"] == "rad/s"
    assert log.tables["IMU", "0"].units["AccX"] == "m/s^2"
    assert log.tables["ATT", ""].units["Yaw"] == "deg"
    assert log.tables["ATT", ""].fields["Yaw"][0] == pytest.approx(359.0)
    assert log.tables["POS", ""].fields["Lat"][0] == pytest.approx(47.3977418)


def test_multipliers_stored_in_single_precision_are_the_numbers_meant(decoded):
    """As ArduPilot on the aircraft writes them; a latitude would be off by centimeters."""
    log = BinWriter()
    log.define("POS", "QLL", "TimeUS,Lat,Lng")
    log.describe({"D": "deglatitude"}, {"G": float(np.float32(1e-7)), "F": 1e-6},
                 [("POS", "sDD", "FGG")])  # fmt: skip
    log.write("POS", 5, 473977418, -1228410850)
    fields = decoded(log.data).tables["POS", ""].fields
    assert fields["Lat"][0] == pytest.approx(47.3977418, abs=1e-12)
    assert fields["Lng"][0] == pytest.approx(-122.841085, abs=1e-12)


def test_multiplier_of_a_plain_integer_is_applied(decoded):
    log = BinWriter()
    log.define("VOLT", "Qhf", "TimeUS,V,Cap")
    log.describe({"v": "V"}, {"B": 1e-2, "-": 0.0, "F": 1e-6}, [("VOLT", "svv", "FB-")])
    log.write("VOLT", 5, 1260, 3.5)
    table = decoded(log.data).tables["VOLT", ""]
    assert table.fields["V"][0] == pytest.approx(12.6)
    assert table.fields["Cap"][0] == pytest.approx(3.5)


def test_old_logs_without_units(decoded):
    """Before FMTU the letters alone scale, TimeMS counts, and the second IMU is IMU2."""
    log = BinWriter()
    log.define("IMU", "Ifc", "TimeMS,GyrX,Tmp")
    log.define("IMU2", "Ifc", "TimeMS,GyrX,Tmp")
    for k in range(3):
        log.write("IMU", 1000 + k, 0.5, 2150)
        log.write("IMU2", 1000 + k, 0.7, 2150)
    read = decoded(log.data)
    assert read.table("IMU", "0").fields["Tmp"][0] == pytest.approx(21.5)
    assert read.table("IMU", "1").fields["GyrX"][0] == pytest.approx(0.7)
    assert read.table("IMU", "").times.tolist() == pytest.approx([1.0, 1.001, 1.002])
    assert read.table("IMU", "2") is None


def test_array_fields_and_messages(decoded):
    log = BinWriter()
    log.define("ISBD", "Qa", "TimeUS,x")
    log.define("MSG", "QZ", "TimeUS,Message")
    log.write("ISBD", 7, *range(32))
    log.write("MSG", 2_500_000, b"Throttle armed")
    read = decoded(log.data)
    assert read.tables["ISBD", ""].fields["x"].tolist() == [list(map(float, range(32)))]
    assert [(event.time, event.text) for event in read.events] == [(2.5, "Throttle armed")]


@pytest.mark.parametrize(
    "kind", ["garbage", "lost bytes", "truncated record", "headers in garbage"]
)
def test_damage_costs_only_the_records_it_hits(decoded, kind):
    """Of 600 records, 60 places are damaged; every record not touched itself is decoded."""
    whole, starts = flight_log()
    rng = random.Random(7)
    data = bytearray(whole)
    touched = set()
    for index in sorted(rng.sample(range(5, len(starts) - 1), 60), reverse=True):
        start, after = starts[index], starts[index + 1]
        if kind == "garbage":
            data[after:after] = rng.randbytes(rng.randint(1, 40))
        elif kind == "headers in garbage":
            data[after:after] = b"\xa3\x95" + rng.randbytes(9) + b"\xa3\x95\x81"
        else:
            cut = rng.randint(start + 4, start + 14)
            end = cut + 3 if kind == "lost bytes" else min(after, start + 17)
            del data[cut:end]
            touched.add(index)
    damaged, good = decoded(data), decoded(whole)
    assert any("damaged" in remark for remark in damaged.remarks)
    names = [("IMU", "0"), ("IMU", "1"), ("ATT", "")]
    for place, key in enumerate(names):
        lost = sum(1 for index in touched if index % 3 == place)
        ours, theirs = damaged.tables[key], good.tables[key]
        assert set(ours.times) <= set(theirs.times)
        assert ours.times.size == theirs.times.size - lost
        keep = np.isin(theirs.times, ours.times)
        for field, values in theirs.fields.items():
            assert np.array_equal(ours.fields[field], values[keep])


@pytest.mark.parametrize("kind", [0x80, 0xFF], ids=["known", "unknown"])
def test_numbers_that_look_like_a_header_cost_no_record(decoded, kind):
    """Of a known type where another record follows at once; of none with garbage behind, too."""
    log = BinWriter()
    log.define("RAW", "QII", "TimeUS,A,B")
    look = int.from_bytes(b"\xa3\x95" + bytes((kind, 1)), "little")
    for k in range(20):
        log.write("RAW", 1_000_000 + 10_000 * k, look, k)
        if kind == 0xFF:
            log.data += b"garbage"
    table = decoded(log.data).tables["RAW", ""]
    assert table.fields["A"].tolist() == [look] * 20
    assert table.fields["B"].tolist() == list(range(20))


def test_a_torn_end_is_told(decoded):
    whole, _ = flight_log()
    log = decoded(whole[:-7])
    assert "incomplete" in log.remarks[0]
    assert log.tables["ATT", ""].times.size == 199
    assert log.tables["IMU", "1"].times.size == 200


def test_a_flipped_time_stamp_is_left_out(decoded):
    whole, starts = flight_log()
    data = bytearray(whole)
    for index in (9, 300, 599 - 2):  # records of ATT and IMU, the last few included
        data[starts[index] + 3 + 6] ^= 0x10
    data[starts[150] + 3 + 2] ^= 0x20
    log = decoded(data)
    total = sum(log.tables[key].times.size for key in (("IMU", "0"), ("IMU", "1"), ("ATT", "")))
    assert total == 600 - 4
    for table in log.tables.values():
        assert np.all(np.diff(table.times) > 0)
        assert table.times.max() < 10.0
    assert log.tables["IMU", "0"].remark.endswith("4 samples of IMU[0]")
    assert log.tables["ATT", ""].remark == ""


@pytest.mark.parametrize("content", [b"", b"hello, this is text\n" * 20, bytes(500)])
def test_files_that_are_no_log(tmp_path, content):
    path = tmp_path / "x.bin"
    path.write_bytes(content)
    with pytest.raises(FlightError, match=r"x\.bin"):
        read_dataflash(path)
    with pytest.raises(FlightError, match="cannot be read"):
        read_dataflash(tmp_path / "none.bin")


def test_random_damage_never_crashes(tmp_path):
    whole, _ = flight_log(count=20)
    path = tmp_path / "r.bin"
    for seed in range(60):
        rng = random.Random(seed)
        data = bytearray(whole)
        for _ in range(rng.randint(1, 30)):
            place = rng.randrange(len(data) - 8)
            if rng.random() < 0.5:
                data[place : place + 4] = rng.randbytes(4)
            else:
                del data[place : place + rng.randint(1, 6)]
        path.write_bytes(data)
        with contextlib.suppress(FlightError):
            for table in read_dataflash(path).tables.values():
                assert np.all(np.diff(table.times) > 0)


def test_log_becomes_a_flight(bin_file):
    flight = load_flight(bin_file)
    table = read_dataflash(bin_file).tables["IMU", "0"]
    assert flight.rate == pytest.approx(100.0)
    np.testing.assert_allclose(flight.block["q"], table.fields["GyrY"])
    np.testing.assert_allclose(flight.block["an"], -table.fields["AccZ"])
    assert "q.2" in flight.block
    assert flight.sources["an"].source == "IMU[0].AccZ"
    assert flight.block["phi"].max() < np.pi
    assert any("ArduPlane" in event.text for event in flight.events)


def test_the_unit_of_the_log_is_believed(bin_file, tmp_path):
    path = tmp_path / "map.toml"
    path.write_text(
        'name = "mine"\nformat = "ardupilot-log"\n[[channels]]\nid = "q"\n'
        'source = "IMU[1].GyrY"\nunit = "deg/s"\n'
    )
    flight = load_flight(bin_file, channel_map=path)
    table = read_dataflash(bin_file).tables["IMU", "1"]
    np.testing.assert_allclose(flight.block["q"], table.fields["GyrY"])
    assert any("the unit of the log is used" in remark for remark in flight.remarks)
    path.write_text(path.read_text().replace("IMU[1].GyrY", "XYZ.Q"))
    with pytest.raises(FlightError, match=r"--map.*ATT, BARO, IMU"):
        load_flight(bin_file, channel_map=path)


def as_text(path):
    """Return a .bin log as the lines that ground stations make of it, read by pymavlink."""
    reader, lines = DFReader.DFReader_binary(str(path)), ["APM:Plane", "FMT, 128, 89, FMT, BBnNZ, "]
    while (message := reader.recv_msg()) is not None:
        values = []
        for column, letter in zip(message.fmt.columns, message.fmt.format, strict=True):
            value = message._elements[message.fmt.columns.index(column)]
            if letter in "cCeEL":
                value = f"{value * {'L': 1e-7}.get(letter, 1e-2):.7f}"
            values.append(value.split(b"\0")[0].decode() if isinstance(value, bytes) else value)
        lines.append(", ".join(map(str, (message.get_type(), *values))))
    reader.close()
    return "\r\n".join(lines) + "\r\n"


@pytest.fixture(scope="module")
def text_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("text") / "00000042.BIN"
    path.write_bytes(flight_log()[0])
    return as_text(path)


def test_a_log_as_text_holds_what_the_binary_holds(tmp_path, text_log, bin_file):
    path = tmp_path / "42.log"
    path.write_text(text_log)
    ours, theirs = read_dataflash(path), read_dataflash(bin_file)
    assert set(ours.tables) == set(theirs.tables)
    assert ours.events == theirs.events
    for key, table in theirs.tables.items():
        assert np.array_equal(ours.tables[key].times, table.times)
        assert ours.tables[key].units == table.units
        for name, values in table.fields.items():
            np.testing.assert_allclose(ours.tables[key].fields[name], values, rtol=1e-12)
    flight = load_flight(path)
    assert flight.block.channels == load_flight(bin_file).block.channels


def test_damaged_lines_of_a_text_log_are_counted(tmp_path, text_log):
    lines = text_log.splitlines()
    places = [index for index, line in enumerate(lines) if line.startswith("ATT")]
    lines[places[3]] = "ATT, 1030000, 1.5"
    lines[places[5]] = lines[places[5]].replace(", ", ", x", 2)
    lines[places[7]] = "\x01\x02 garbage"
    path = tmp_path / "42.log"
    path.write_text("\n".join(lines))
    log = read_dataflash(path)
    assert log.tables["ATT", ""].times.size == 197
    assert "3 lines" in log.remarks[0]


def test_text_logs_name_modes_and_say_what_they_are_not(tmp_path):
    """Some converters write the name of a mode for its number; other .log files are refused."""
    path = tmp_path / "1.log"
    path.write_text(
        "FMT, 1, 20, MODE, QMB, TimeUS,Mode,ModeNum\nFMT, 2, 20, MSG, QZ, TimeUS,Message\n"
        "MODE, 1000000, FBWA, 5\nMODE, 2000000, AUTO, 10\nMSG, 2500000, lost, and found\n"
    )
    log = read_dataflash(path)
    assert log.tables["MODE", ""].fields["ModeNum"].tolist() == [5.0, 10.0]
    texts = [event.text for event in log.events]
    assert texts == ["lost, and found", "Flight mode FBWA", "Flight mode AUTO"]
    path.write_text("12:00:01 started\n12:00:02 stopped\n")
    with pytest.raises(FlightError, match="not an ArduPilot log"):
        load_flight(path)


def test_a_format_that_describes_formats_otherwise_is_passed_over(tmp_path):
    log = flight_log(count=20)[0]
    odd = struct.pack("<3sBB4s16s64s", b"\xa3\x95\x80", 128, 40, b"FMT", b"BBn", b"a,b,c")
    path = tmp_path / "x.bin"
    path.write_bytes(log[:89] + odd + log[89:])
    assert "IMU" in read_dataflash(path).messages


def test_a_column_may_be_called_as_the_header_is_here(tmp_path):
    log = flight_log(count=20)[0]
    odd = struct.pack("<3sBB4s16s64s", b"\xa3\x95\x80", 99, 12, b"ODD", b"Qb", b"TimeUS,_header")
    path = tmp_path / "x.bin"
    path.write_bytes(log + odd + (b"\xa3\x95\x63" + bytes(9)) * 3)
    assert "ODD" not in read_dataflash(path).messages


def test_one_long_text_costs_no_memory_for_all_others(tmp_path):
    """Each text of a column takes as many bytes as the longest."""
    head = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
    head += "FMT, 50, 75, MSG, QZ, TimeUS,Message\n"
    lines = [f"MSG, {1000 * k}, text" for k in range(20_000)]
    lines[5] = "MSG, 5000, " + "x" * 10_000_000
    path = tmp_path / "x.log"
    path.write_text(head + "\n".join(lines) + "\n")
    texts = [event.text for event in read_dataflash(path).events if event.kind == "status"]
    assert len(texts) == 20_000
    assert max(map(len, texts)) == 256


ODD_FORMATS = {
    "a value of a parameter as text": ("PARM", "QNff", "QNnf"),
    "a stamp as text": ("IMU", "QBffffff", "ZBffffff"),
    "an array for a text": ("MSG", "QZ", "Qa"),
    "a letter that none knows": ("ATT", "QccC", "?ccC"),
}


@pytest.mark.parametrize(("name", "good", "odd"), ODD_FORMATS.values(), ids=ODD_FORMATS)
@pytest.mark.parametrize("as_lines", [False, True])
def test_a_damaged_letter_of_a_format_costs_that_message_alone(tmp_path, name, good, odd, as_lines):
    writer = BinWriter()
    writer.types |= {f"T{kind}": (kind, "<B") for kind in range(129, 170)}
    writer.define("PARM", "QNff", "TimeUS,Name,Value,Default")
    writer.write("PARM", 1_000_000, b"X_Y", 1.0, 2.0)
    path = tmp_path / "x.bin"
    path.write_bytes(flight_log(count=20)[0] + bytes(writer.data))
    if as_lines:
        log = as_text(path).replace(f"{name}, {good},", f"{name}, {odd},", 1).encode()
    else:
        made = name.encode().ljust(4, b"\0") + good.encode()
        log = path.read_bytes().replace(made, name.encode().ljust(4, b"\0") + odd.encode(), 1)
    assert log != path.read_bytes()
    path.write_bytes(log)
    read = read_dataflash(path)
    for table in read.tables.values():
        assert all(values.size >= 0 for values in table.fields.values())
    assert "BARO" in read.messages


@pytest.mark.parametrize("number", ["nan", "inf", "1e400", "", "9" * 400])
@pytest.mark.parametrize("line", ["IMU, 1050000, ", "MODE, 1000000, "])
def test_a_number_of_a_text_log_that_is_none_costs_its_line(tmp_path, line, number):
    path = tmp_path / "x.bin"
    path.write_bytes(flight_log(count=20)[0])
    text = as_text(path) + "FMT, 170, 12, MODE, QM, TimeUS,Mode\r\nMODE, 1000000, 5\r\n"
    assert line in text
    path.write_text(text.replace(line + "0", line + number, 1).replace(line + "5", line + number))
    read = read_dataflash(path)
    assert sum(table.times.size for key, table in read.tables.items() if key[0] == "IMU") >= 39


def test_a_column_without_a_name_costs_that_message_alone(tmp_path):
    path = tmp_path / "x.bin"
    path.write_bytes(flight_log(count=20)[0])
    text = as_text(path)
    broken = text.replace("TimeUS,Roll,Pitch", "TimeUS,,Pitch", 1)
    assert broken != text
    path.write_text(broken)
    read = read_dataflash(path)
    assert "BARO" in read.messages
    assert "ATT" not in read.messages
