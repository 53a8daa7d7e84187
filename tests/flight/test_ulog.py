"""PX4's log as its public format describes it, written byte by byte."""

import struct
from pathlib import Path

import numpy as np
import pytest

from gsapp.flight import load_flight
from gsapp.flight.readers.ulog import read_ulog

ROWS = 200


def message(kind: str, payload: bytes) -> bytes:
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def short_log(*, dropouts: int = 0, instances: int = 1, start: int = 1_000_000) -> bytes:
    """Return a log of two seconds with gyros, and attitude in every tenth row."""
    log = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)
    log += message(
        "F",
        b"sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
        b"float[3] accelerometer_m_s2;uint8_t[4] _padding0;",
    )
    log += message("F", b"vehicle_attitude:uint64_t timestamp;float[4] q;")
    text = b"char[3] sys_name"
    log += message("I", bytes([len(text)]) + text + b"PX4")
    for instance in range(instances):
        log += message("A", struct.pack("<BH", instance, 2 * instance) + b"sensor_combined")
        log += message("A", struct.pack("<BH", instance, 2 * instance + 1) + b"vehicle_attitude")
    for row in range(ROWS):
        stamp = start + 10_000 * row
        for instance in range(instances):
            motion = struct.pack("<Q3fI3f", stamp, 0.0, 0.01 * row + instance, 0, 1, 0, 0, -9.8)
            log += message("D", struct.pack("<H", 2 * instance) + motion)
            if row % 10 == 0:
                attitude = struct.pack("<Q4f", stamp, 1, 0, 0, 0)
                log += message("D", struct.pack("<H", 2 * instance + 1) + attitude)
        if row == ROWS // 2:
            log += message("O", struct.pack("<H", 120)) * dropouts
    return log


def written(folder: Path, log: bytes) -> Path:
    path = folder / "x.ulg"
    path.write_bytes(log)
    return path


def test_the_first_of_several_instances_counts(tmp_path: Path) -> None:
    flight = load_flight(written(tmp_path, short_log(instances=3)))
    assert flight.block["q"] == pytest.approx(0.01 * np.arange(ROWS), abs=1e-6)
    assert flight.remarks == ()


@pytest.mark.parametrize("cut", [1, 2, 3, 20, 30])
def test_a_torn_end_is_told(tmp_path: Path, cut: int) -> None:
    flight = load_flight(written(tmp_path, short_log()[:-cut]))
    assert ["incomplete" in one for one in flight.remarks] == [True]
    assert flight.block["q"] == pytest.approx(0.01 * np.arange(ROWS - 1), abs=1e-6)


@pytest.mark.parametrize(("count", "often"), [(1, "once, 0.1 s"), (3, "3 times, 0.4 s")])
def test_dropouts_are_told(tmp_path: Path, count: int, often: str) -> None:
    flight = load_flight(written(tmp_path, short_log(dropouts=count)))
    assert [often in one for one in flight.remarks] == [True]


@pytest.mark.parametrize("stamp", [0, 5_000, 1_710_773_350_000_000])
def test_a_topic_of_one_impossible_time_does_not_lengthen_the_flight(
    tmp_path: Path, stamp: int
) -> None:
    """Neither where the clock counts from 1970 nor where it counts from switching on."""
    start = 1_000_000 if stamp > 10**12 else 1_710_773_350_000_000
    log = short_log(start=start)
    at = log.rindex(message("D", struct.pack("<H", 1))[2:])
    pressure = b"vehicle_air_data:uint64_t timestamp;float baro_pressure_pa;"
    odd = message("F", pressure)
    odd += message("A", struct.pack("<BH", 0, 9) + b"vehicle_air_data")
    odd += message("D", struct.pack("<HQf", 9, stamp, 1e5))
    flight = load_flight(written(tmp_path, log[: at - 2] + odd + log[at - 2 :]))
    assert flight.duration == pytest.approx(0.01 * (ROWS - 1))
    assert "static_pressure" not in flight.block
    (remark,) = flight.remarks
    assert remark.endswith("1 sample of vehicle_air_data[0]")


def test_formats_inside_formats_and_texts_are_those_of_pyulog(tmp_path: Path) -> None:
    pyulog = pytest.importorskip("pyulog")
    log = short_log(instances=2)
    first = log.index(message("A", struct.pack("<BH", 0, 0) + b"sensor_combined"))
    log, rest = log[:first], log[first:]
    log += message("F", b"esc_report:uint32_t esc_rpm;float[2] volts;uint8_t[4] _padding0;")
    log += message("F", b"esc_status:uint64_t timestamp;esc_report[2] esc;uint8_t count;")
    log += message("A", struct.pack("<BH", 0, 11) + b"esc_status")
    log += rest
    for k in range(5):
        body = struct.pack("<HQ", 11, 2_500_000 + 1000 * k)
        body += struct.pack("<I2f4x", 100 + k, 1, 2) + struct.pack("<I2f4x", 200 + k, 3, 4)
        log += message("D", body + bytes([k]))
    log += message("L", struct.pack("<BQ", 6, 2_504_000) + "späte Landung".encode())
    path = written(tmp_path, log)
    ours = read_ulog(path)
    assert [(event.time, event.text) for event in ours.events] == [(2.504, "späte Landung")]
    met = set()
    for topic in pyulog.ULog(str(path)).data_list:
        table = ours.tables[topic.name, str(topic.multi_id)]
        np.testing.assert_array_equal(table.times, topic.data["timestamp"] * 1e-6)
        for name, values in topic.data.items():
            whole, _, index = name.rstrip("]").rpartition("[")
            if name != "timestamp" and "_padding" not in name:
                single = name in table.fields
                mine = table.fields[name] if single else table.fields[whole][:, int(index)]
                np.testing.assert_array_equal(mine, values)
                met.add(name)
    assert {"gyro_rad[2]", "q[3]", "esc[1].esc_rpm", "esc[0].volts[1]", "count"} <= met


def test_damage_and_a_time_that_cannot_be_cost_their_samples_and_are_told(tmp_path: Path) -> None:
    """One sample of gyros stamped an hour late; later on the length of another is overwritten.

    What follows that cannot be found again, and is more than the last message.
    """
    log = bytearray(short_log())
    rows = [k for k in range(len(log)) if log[k : k + 5] == b"\x26\x00D\x00\x00"]
    assert len(rows) == ROWS
    log[rows[50] + 5 : rows[50] + 13] = struct.pack("<Q", 3_600_000_000)
    flight = load_flight(written(tmp_path, bytes(log)))
    text = "skipped for impossible or repeated times: 1 sample of sensor_combined[0]"
    assert flight.remarks == (text,)
    assert flight.block["q"] == pytest.approx(0.01 * np.arange(ROWS), abs=1e-6)
    log[rows[150] : rows[150] + 3] = b"\xff\xff\xff"
    damaged = load_flight(written(tmp_path, bytes(log)))
    assert len(damaged.remarks) == 2
    assert text in damaged.remarks
    assert damaged.block["q"][:150] == pytest.approx(0.01 * np.arange(150), abs=1e-6)


def test_a_topic_that_was_never_published_does_not_begin_the_flight(tmp_path: Path) -> None:
    log = bytearray(short_log(start=1_710_773_350_000_000))
    rows = [k for k in range(len(log)) if log[k : k + 5] == b"\x1a\x00D\x01\x00"]
    assert len(rows) == ROWS // 10
    for row in rows:
        struct.pack_into("<Q", log, row + 5, 0)
    flight = load_flight(written(tmp_path, bytes(log)))
    assert flight.block["q"] == pytest.approx(0.01 * np.arange(ROWS), abs=1e-6)
    (remark,) = flight.remarks
    assert "vehicle_attitude[0]" in remark


FORMATS = {
    "an array of gigabytes": (b"uint64_t timestamp;float[999999999] a;",),
    "a size of thousands of digits": (b"uint64_t timestamp;float[" + b"9" * 5000 + b"] a;",),
    "more than a message holds": (b"uint64_t timestamp;y[65535] a;", b"y:float a;float b;"),
    "itself inside": (b"uint64_t timestamp;x[65535] a;x[65535] b;x[9] c;float d;",),
    "nothing but itself": (b"x[65535] a;" + b"".join(b"x c%d;" % k for k in range(500)),),
    "the name of the head": (b"uint64_t timestamp;float _head;",),
}


@pytest.mark.parametrize("formats", FORMATS.values(), ids=FORMATS)
def test_formats_that_no_message_has_are_passed_over(
    tmp_path: Path, formats: tuple[bytes, ...]
) -> None:
    log = short_log() + message("F", b"x:" + formats[0])
    log += b"".join(message("F", one) for one in formats[1:])
    log += message("A", struct.pack("<BH", 0, 9) + b"x")
    log += message("D", struct.pack("<HQf", 9, 1_500_000, 1.0)) * 3
    read = read_ulog(written(tmp_path, log))
    assert set(read.messages) == {"sensor_combined", "vehicle_attitude"}


@pytest.mark.parametrize("count", ["", "[1]", "[8]"])
@pytest.mark.parametrize("kind", ["char", "uint8_t", "float", "double", "bool"])
@pytest.mark.parametrize(
    "field", ["timestamp", "nav_state", "vehicle_type", "is_rotary_wing", "is_vtol"]
)
def test_a_field_of_another_type_costs_no_more_than_itself(
    tmp_path: Path, field: str, kind: str, count: str
) -> None:
    """Of the topic that tells the flight mode and what flies; all of it NaN as a float."""
    clock = "" if field == "timestamp" else "uint64_t timestamp;"
    log = short_log()[:-60] + message("F", f"vehicle_status:{clock}{kind}{count} {field};".encode())
    log += message("A", struct.pack("<BH", 0, 9) + b"vehicle_status")
    size = int(count.strip("[]") or 1) * {"float": 4, "double": 8}.get(kind, 1)
    for k in range(20):
        stamp = struct.pack("<Q", 1_000_000 + 50_000 * k) if clock else b""
        log += message("D", struct.pack("<H", 9) + stamp + b"\xff" * size)
    flight = load_flight(written(tmp_path, log))
    assert flight.block["q"][0] == pytest.approx(0.0, abs=1e-6)
