"""Columns against pymavlink's own decoder, for every message of the dialect."""

import random
import subprocess
import sys

import numpy as np
import pytest

from gsapp.decoding.dialect import dialect
from gsapp.decoding.messages import decode_columns, message_id, message_layout, message_name
from gsapp.foundation import UnknownNameError

IDS = sorted(dialect().mavlink_map)


def as_pymavlink(value: object, *, text: bool) -> object:
    if isinstance(value, bytes):
        return value
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if not text and isinstance(value, np.generic) else value


@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
def test_every_message_decodes_as_pymavlink_does() -> None:
    """Random payloads of all messages, whole and truncated: every field equals pymavlink's."""
    generator = random.Random(5)
    mavlink = dialect().MAVLink(None)
    checked = 0
    for number in IDS:
        kind = dialect().mavlink_map[number]
        layout = message_layout(number)
        size = kind.unpacker.size
        assert layout.dtype.itemsize == size, layout.name
        payloads = [generator.randbytes(size) for _ in range(4)]
        # As MAVLink 2 sends it: zeros at the end are not there.
        payloads.append(payloads[0][: size // 2])
        payloads.append(payloads[1][:1])
        columns = decode_columns(number, payloads)
        for row, payload in enumerate(payloads):
            frame = frame_of(number, payload, kind.crc_extra)
            message = mavlink.decode(bytearray(frame))
            assert message.get_type() == layout.name
            for field, kind_name in zip(kind.fieldnames, kind.fieldtypes, strict=True):
                expected = getattr(message, f"_{field}_raw", None)
                if expected is None:
                    expected = getattr(message, field)
                found = columns[field][row]
                if kind_name == "char":
                    compare_text(found, expected, field)
                else:
                    np.testing.assert_array_equal(
                        np.asarray(found, dtype=np.float64).ravel(),
                        np.asarray(expected, dtype=np.float64).ravel(),
                        err_msg=f"{layout.name}.{field}",
                    )
                checked += 1
    assert checked > 6 * 350


def compare_text(found: object, expected: object, field: str) -> None:
    raw = expected if isinstance(expected, bytes) else None
    if raw is None:
        text = bytes(found).split(b"\0")[0].decode("utf-8", "replace")  # type: ignore[arg-type]
        assert text == str(expected).split("\0")[0], field
    else:
        assert bytes(found) == raw.rstrip(b"\0"), field  # type: ignore[arg-type]


def frame_of(number: int, payload: bytes, extra: int) -> bytes:
    body = bytes([len(payload), 0, 0, 7, 1, 1]) + number.to_bytes(3, "little") + payload
    crc = dialect().x25crc(bytearray(body) + bytearray([extra])).crc
    return b"\xfd" + body + crc.to_bytes(2, "little")


def test_names_and_ids() -> None:
    assert message_id("DEBUG_FLOAT_ARRAY") == 350
    assert message_name(350) == "DEBUG_FLOAT_ARRAY"
    assert message_name(16_000_000) == "UNKNOWN_16000000"
    with pytest.raises(UnknownNameError, match="ATTITUDE"):
        message_id("ATITUDE")
    with pytest.raises(UnknownNameError, match="another dialect"):
        decode_columns(16_000_000, [b""])


def test_stamps_are_found() -> None:
    attitude = message_layout(message_id("ATTITUDE")).stamp
    assert (attitude.field, attitude.size, attitude.scale) == ("time_boot_ms", 4, 1000)
    daq = message_layout(350).stamp
    assert (daq.field, daq.size, daq.scale) == ("time_usec", 8, 1)
    system_time = message_layout(message_id("SYSTEM_TIME")).stamp
    assert system_time.field == "time_boot_ms"
    airflow = message_layout(message_id("SENSOR_AIRFLOW_ANGLES")).stamp
    assert airflow.field == "timestamp"
    assert message_layout(message_id("VFR_HUD")).stamp is None


def test_no_payload_at_all() -> None:
    assert decode_columns(30, []).size == 0
    assert decode_columns(30, [b""])["roll"].tolist() == [0.0]


def test_importing_is_cheap() -> None:
    code = "import sys, gsapp.decoding.messages; print('pymavlink' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
