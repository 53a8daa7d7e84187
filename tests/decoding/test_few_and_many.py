"""The two ways of decoding, number by number and by matrices, against each other: the same bits."""

import math
import random
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

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
from gsapp.decoding.grid import Grid
from gsapp.decoding.grid_rows import GridRows, RowBatch
from gsapp.decoding.gridder import Gridder
from gsapp.decoding.message_stream import linear_factors
from gsapp.decoding.messages import decode_columns, message_id, message_layout, number_reader
from gsapp.decoding.pipeline import Pipeline
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.quantities import CHANNELS, Block, channel, to_si

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
def test_every_shipped_map_decodes_alike_in_any_pieces(cases: SimpleNamespace, name: str) -> None:
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
            records.append(RawRecord(cases.HOST + tick * 10_000 + order, "frame", data))

    def make() -> Decoder:
        return Decoder(replace(chosen, system=1, component=1), aircraft=parts(name)[2])

    whole, first = cases.decode_in_chunks(make, records, [len(records)])
    assert len(whole) > len(chosen.channels) // 3
    for sizes in ([1], [2, 3], [10], [40, 1]):
        found, decoder = cases.decode_in_chunks(make, records, sizes)
        cases.assert_same(whole, found)
        assert decoder.clipped == first.clipped
        assert decoder.counted_sources() == first.counted_sources()


def as_field(value: object) -> object:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
