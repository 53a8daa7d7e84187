"""Decoding by numbers, by matrices and by pymavlink, of made and of real flights: the same bits."""

import math
import random
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from calibration import Certificate, load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.channel_map import ChannelMap, FieldRef, MapEntry, load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.derived_channels import DERIVATIONS
from gsapp.decoding.dialect import dialect
from gsapp.decoding.grid import Grid, GridRows, RowBatch
from gsapp.decoding.gridder import Gridder
from gsapp.decoding.message_stream import linear_factors
from gsapp.decoding.messages import (
    decode_columns,
    message_id,
    message_layout,
    message_name,
    number_reader,
)
from gsapp.decoding.pipeline import Pipeline
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import UnknownNameError
from gsapp.quantities import CHANNELS, Block, channel, to_si
from tests.decoding.decoding_kit import HOST, assert_same, decode_in_chunks, gather

MAPS = ("b777", "b777-thin", "ardupilot-plane", "px4")
SPECIAL = (0.0, -0.0, 1.0, -1.0, math.pi, -math.pi, math.nan, 1e-320, -1e-320, 1e300, -1e300)
NUMBERS = st.one_of(st.sampled_from(SPECIAL), st.floats(-1e6, 1e6), st.floats(0.0, 5.0))


def same(one: np.ndarray, two: np.ndarray) -> bool:
    return one.shape == two.shape and one.tobytes() == two.tobytes()


def test_numbers_of_every_message_are_read_alike() -> None:
    """Random payloads of all messages, whole and truncated: struct and NumPy read the same."""
    generator = random.Random(2)
    checked = 0
    for number in sorted(dialect().mavlink_map):
        layout = message_layout(number)
        wanted: list[tuple[str, int | None]] = []
        for field in layout.fields:
            if not layout.is_text(field):
                length = layout.length(field)
                wanted += [(field, index) for index in range(length)] if length else [(field, None)]
        generator.shuffle(wanted)
        wanted = [*wanted[:60], *wanted[:2]]
        if not wanted:
            continue
        read = number_reader(number, wanted)
        size = layout.dtype.itemsize
        payloads = [generator.randbytes(size) for _ in range(3)]
        payloads += [payloads[0][: size // 2], b"", payloads[1] + b"newer"]
        columns = decode_columns(number, payloads)
        for row, payload in enumerate(payloads):
            expected = [
                float(columns[field][row] if index is None else columns[field][row, index])
                for field, index in wanted
            ]
            np.testing.assert_array_equal(read(payload), expected, err_msg=layout.name)
            checked += 1
    assert checked > 6 * 300


def test_text_is_no_number() -> None:
    with pytest.raises(ValueError, match=r"STATUSTEXT\.text is text"):
        number_reader(message_id("STATUSTEXT"), [("text", None)])


@cache
def parts(name: str) -> tuple[ChannelMap, dict[str, Certificate], Aircraft]:
    return load_channel_map(name), load_certificates("b777"), load_aircraft("b777")


def payload_of(layout_id: int, generator: random.Random) -> bytes:
    """Return a payload with plausible, special and random fields side by side."""
    row = np.zeros(1, dtype=message_layout(layout_id).dtype)
    for field in message_layout(layout_id).fields:
        kind = row[field]
        if kind.dtype.kind == "f":
            flat = [
                generator.choice((generator.uniform(0.0, 5.0), generator.choice(SPECIAL), 5.0))
                for _ in range(kind.size)
            ]
            with np.errstate(over="ignore"):
                row[field] = np.array(flat).reshape(kind.shape)
        elif kind.dtype.kind in "iu":
            limits = np.iinfo(kind.dtype)
            choices = (0, 1, 255, 1500, 65535, -1, generator.randint(limits.min, limits.max))
            flat_int = [
                min(max(generator.choice(choices), limits.min), limits.max)
                for _ in range(kind.size)
            ]
            row[field] = np.array(flat_int, dtype=kind.dtype).reshape(kind.shape)
    return row.tobytes()


@pytest.mark.filterwarnings("ignore:invalid value|overflow|divide by zero")
@pytest.mark.parametrize("name", MAPS)
@given(seed=st.integers(0, 2**32))
@settings(max_examples=10, deadline=None)
def test_streams_convert_alike(name: str, seed: int) -> None:
    generator = random.Random(seed)
    chosen, certificates, aircraft = parts(name)
    pipelines = [
        Pipeline(
            chosen,
            certificates=certificates,
            aircraft=aircraft,
            rate=100.0,
            vehicle_time=lambda _: True,
        )
        for _ in range(2)
    ]
    for few, many in zip(pipelines[0].streams, pipelines[1].streams, strict=True):
        number = message_id(few.message)
        payloads = [payload_of(number, generator) for _ in range(4)]
        read = number_reader(number, [(ref.field, ref.index) for ref in few.wanted])
        values, complete = few.convert_scalars([read(payload) for payload in payloads])
        one = np.array(values)
        assert complete <= (not np.isnan(one).any())
        two = many.convert(decode_columns(number, payloads), len(payloads))
        assert same(one, two), few.message
    assert pipelines[0].clipped == pipelines[1].clipped


def test_a_raw_number_becomes_si_as_its_unit_says() -> None:
    for spec in CHANNELS.values():
        for unit in spec.allowed_units:
            entry = MapEntry(
                channel=spec.id, source="x", message="m", inputs=(FieldRef(field="x"),),
                unit=unit, scale=0.01, offset=-3.0,
            )  # fmt: skip
            factor, shift = linear_factors(entry)
            expected = to_si(4711.0 * 0.01 - 3.0, unit, spec.quantity)
            assert 4711.0 * factor + shift == pytest.approx(expected, rel=1e-12), (spec.id, unit)


def laid(rows: Iterable[GridRows]) -> list[tuple[int, bytes, bytes | None]]:
    return [
        (each.first, each.values.tobytes(), None if each.silent is None else each.silent.tobytes())
        for each in rows
    ]


@given(
    samples=st.lists(
        st.tuples(
            st.one_of(st.integers(-3_000, 60_000), st.sampled_from((10_000, 350_000, 90_000_000))),
            st.tuples(NUMBERS, NUMBERS, NUMBERS),
        ),
        min_size=1,
        max_size=20,
    ),
    turned=st.booleans(),
)
@example(  # a product that vanishes beside a negative zero
    samples=[(1_000, (0.0, -0.0, 0.0)), (30_000, (0.0, -5e-324, 0.0))], turned=True
)
@settings(max_examples=50, deadline=None)
def test_rows_are_laid_alike(
    samples: list[tuple[int, tuple[float, float, float]]], turned: bool
) -> None:
    gridders = [
        Gridder(
            Grid(100.0),
            circular=np.array([False, turned, False]),
            stepwise=np.array([False, False, True]),
        )
        for _ in range(2)
    ]
    times = np.cumsum([step for step, _ in samples]).tolist()
    values = [list(numbers) for _, numbers in samples]
    for start in range(0, len(times), 3):
        part = slice(start, start + 3)
        sheet = RowBatch()
        few = gridders[0].feed_few(times[part], times[part], values[part], sheet)
        sheet.compute_rows()
        many = gridders[1].feed(times[part], times[part], np.array(values[part]))
        assert laid(few) == laid(many)
    assert gridders[0].missing == gridders[1].missing
    assert gridders[0].gaps == gridders[1].gaps


@given(
    seed=st.integers(0, 2**32),
    rate=st.sampled_from((100.0, 12.5, 33.3)),
    start=st.sampled_from((0, 1_234_567, 1_710_773_350_000_001)),
    cut=st.integers(0, 400),
)
@settings(max_examples=12, deadline=None)
def test_many_samples_at_once_give_the_rows_of_one_by_one(
    seed: int, rate: float, start: int, cut: int
) -> None:
    """Steps as of a real link: even, with jitter, gaps, pauses, repeated and late samples."""
    generator = random.Random(seed)
    usual = generator.choice((2_500, 5_000, 20_000, 170_000))
    steps = [
        generator.choice((usual, usual, usual, usual + generator.randint(-999, 999)))
        if generator.random() < 0.9
        else generator.choice((0, -usual, 3 * usual, 3_000_000, 70_000_000))
        for _ in range(400)
    ]
    times = (start + np.cumsum(steps)).tolist()
    nows = [time + generator.choice((0, 0, 400_000, 5_000_000)) for time in times]
    values = np.array([[generator.uniform(-3.0, 3.0) for _ in range(3)] for _ in times])
    flags = np.array([False, True, False]), np.array([False, False, True])
    one, many = (Gridder(Grid(rate), circular=flags[0], stepwise=flags[1]) for _ in range(2))
    found: list[list[GridRows]] = [[], []]
    for place in range(len(times)):
        part = slice(place, place + 1)
        found[0] += one.feed(times[part], nows[part], values[part])
    for part in (slice(0, cut), slice(cut, None)):
        if times[part]:
            found[1] += many.feed(times[part], nows[part], values[part])
    table = [
        [
            (rows.first + k, row.tobytes(), rows.silent is not None and bool(rows.silent[k]))
            for rows in each
            for k, row in enumerate(rows.values)
        ]
        for each in found
    ]
    assert table[0] == table[1]
    for name in ("gaps", "samples", "duplicates", "reordered", "missing", "last", "first", "begin"):
        assert getattr(one, name) == getattr(many, name), name
    assert (one.period, one.rate) == (many.period, many.rate)


def table_map(names: Sequence[str]) -> ChannelMap:
    entries = [
        MapEntry(
            channel=name,
            source=name,
            message="slow" if name == names[-1] else "quick",
            inputs=(FieldRef(field=name),),
            unit=channel(name).unit,
        )
        for name in names
    ]
    return ChannelMap(name="t", entries=tuple(entries), format="table")


def of_channels(blocks: Iterable[Block]) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for block in blocks:
        for name in block.channels:
            column = np.column_stack((block.times, block[name])).tobytes()
            found[name] = found.get(name, b"") + column
    return found


@pytest.mark.filterwarnings("ignore:invalid value|overflow|divide by zero")
@pytest.mark.parametrize(
    "names",
    [
        ("dynamic_pressure", "static_pressure", "temperature"),
        ("static_pressure", "dynamic_pressure"),
        ("V", "temperature", "static_pressure"),
        ("V", "static_pressure"),
        ("Vc", "static_pressure"),
        ("elevator_left", "aileron_left", "aileron_right", "rudder", "elevator_right"),
    ],
)
@given(rows=st.lists(st.lists(NUMBERS, min_size=5, max_size=5), min_size=2, max_size=24))
@example(rows=[[50.0, 1e-320, 300.0, 1.0, 1.0]] * 3)  # air so thin that its density is zero
@settings(max_examples=15, deadline=None)
def test_channels_are_derived_alike(names: tuple[str, ...], rows: list[list[float]]) -> None:
    """All derivations, from impossible pressures and temperatures as well."""
    results = []
    for few in (True, False):
        pipeline = Pipeline(
            table_map(names),
            certificates={},
            aircraft=None,
            rate=100.0,
            vehicle_time=lambda _: True,
        )
        blocks: list[Block] = []
        for start in range(0, len(rows), 3):
            part = rows[start : start + 3]
            times = [10_000 * (start + k) for k in range(len(part))]
            for stream in (1, 0):
                wanted = [ref.field for ref in pipeline.streams[stream].wanted]
                columns = {
                    name: np.array([row[names.index(name)] for row in part]) for name in wanted
                }
                if few:
                    numbers = [
                        [float(columns[name][k]) for name in wanted] for k in range(len(part))
                    ]
                    pipeline.push_few(stream, times, times, numbers)
                else:
                    pipeline.push(stream, times, times, columns)
            blocks += pipeline.pull(0, times[-1])
        blocks += pipeline.pull(0, 10_000 * len(rows), final=True)
        results.append(of_channels(blocks))
    assert results[0] == results[1]
    derived = {each.output for each in DERIVATIONS}
    assert derived & set(results[0]), "nothing was derived"


@pytest.mark.filterwarnings("ignore:invalid value|overflow|divide by zero")
@pytest.mark.parametrize("name", MAPS)
def test_every_shipped_map_decodes_alike_in_any_pieces(name: str) -> None:
    """All messages of a map at 100 to 5 Hz: one by one, as a window polls, and as a file."""
    chosen = load_channel_map(name)
    generator = random.Random(7)
    packer = dialect().MAVLink(None, srcSystem=1, srcComponent=1)
    records = []
    for tick in range(250):
        for order, message in enumerate(chosen.messages):
            if tick % (1, 2, 5, 20)[order % 4]:
                continue
            number = message_id(message)
            kind = dialect().mavlink_map[number]
            layout = message_layout(number)
            row = np.frombuffer(payload_of(number, generator), dtype=layout.dtype).copy()
            if layout.stamp is not None:
                micros = 5_000_000 + tick * 10_000 + generator.randrange(300)
                row[layout.stamp.field] = micros // layout.stamp.scale
            for entry in chosen.entries:
                if entry.message == message and entry.selector is not None:
                    text = layout.is_text(entry.selector.field)
                    value = entry.selector.value
                    row[entry.selector.field] = value.encode() if text else int(value)
                    break
            message_class = kind(*[as_field(row[field][0]) for field in kind.fieldnames])
            data = bytes(message_class.pack(packer))
            packer.seq = (packer.seq + 1) % 256
            records.append(RawRecord(HOST + tick * 10_000 + order, "frame", data))

    def make() -> Decoder:
        return Decoder(replace(chosen, system=1, component=1), aircraft=parts(name)[2])

    whole, first = decode_in_chunks(make, records, [len(records)])
    assert len(whole) > len(chosen.channels) // 3
    for sizes in ([1], [2, 3], [10], [40, 1]):
        found, decoder = decode_in_chunks(make, records, sizes)
        assert_same(whole, found)
        assert decoder.clipped == first.clipped
        assert decoder.counted_sources() == first.counted_sources()


def as_field(value: object) -> object:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


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


G = 9.80665


@pytest.fixture
def records(shared_data: Path) -> list[RawRecord]:
    path = shared_data / "alfa_carbonz_engine_failure.tlog"
    if not path.is_file():
        pytest.skip(f"{path.name} is not in {shared_data}")
    data, found, place = path.read_bytes(), [], 0
    while place < len(data):
        stamp = int.from_bytes(data[place : place + 8], "big")
        magic, length = data[place + 8], data[place + 9]
        size = length + 8 if magic == 0xFE else length + 12 + 13 * (data[place + 10] & 1)
        found.append(RawRecord(stamp, "frame", data[place + 8 : place + 8 + size]))
        place += 8 + size
    return found


def test_every_frame_and_the_airspeed(records: list[RawRecord]) -> None:
    """26,183 frames, airspeed 9.7 to 20 m/s, 132 s, and the engine cut at +116.3 s."""
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    found = gather(decoder.feed(records) + decoder.finish())
    assert len(records) == 26_183
    assert decoder.health.good == 26_183
    assert decoder.notices == []
    # SYS_STATUS, which carries no stamp, came before the first that does, 916.989 s.
    assert min(index[0] for index, _ in found.values()) == 91_698
    Vc = found["Vc"][1]
    assert np.nanmin(Vc) == pytest.approx(9.7, abs=0.1)
    assert np.nanmax(Vc) == pytest.approx(20.0, abs=0.1)
    index, throttle = found["throttle"]
    assert index[-1] - index[0] == pytest.approx(13_230, abs=30)
    after = throttle[index > (916.97 + 118.0) * 100]
    # Idle is a pulse of 1100 us.
    assert np.nanmax(after) == pytest.approx(0.1)
    assert np.nanmean(throttle) > 0.2


def test_it_is_consistent_with_itself(records: list[RawRecord]) -> None:
    """Signs and units: a_n about 1 g, gyro and attitude filter agree, pitch rate turns pitch."""
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    found = gather(decoder.feed(records) + decoder.finish())
    assert 0.9 * G < np.nanmean(found["an"][1]) < 1.6 * G
    assert np.nanmean(found["an.2"][1]) == pytest.approx(np.nanmean(found["an"][1]), rel=0.05)

    def common(*names: str) -> list[np.ndarray]:
        first = max(found[name][0][0] for name in names)
        last = min(found[name][0][-1] for name in names)
        rows = []
        for name in names:
            index, values = found[name]
            rows.append(values[np.searchsorted(index, first) : np.searchsorted(index, last)])
        good = np.all(np.isfinite(rows), axis=0)
        return [values[good] for values in rows]

    q, q2 = common("q", "q.2")
    assert np.corrcoef(q, q2)[0, 1] > 0.99
    V, Vc, rho = common("V", "Vc", "density")
    np.testing.assert_allclose(V, Vc * np.sqrt(1.225 / rho), rtol=2e-3)
    assert decoder.sources["V"].kind == "derived"
    assert decoder.sources["phi"].kind == "estimated"
    # From the 10 Hz pressure: field elevation some 340 m, flown 30 to 60 m above it.
    altitude, height = common("altitude", "height")
    assert np.corrcoef(altitude, height)[0, 1] > 0.95


def test_it_may_be_cut_anywhere(records: list[RawRecord]) -> None:
    def make() -> Decoder:
        return Decoder(load_channel_map("ardupilot-plane"))

    some = records[:6000]
    whole, _ = decode_in_chunks(make, some, [6000])
    pieces, _ = decode_in_chunks(make, some, [1, 7, 50, 333])
    assert_same(whole, pieces)
