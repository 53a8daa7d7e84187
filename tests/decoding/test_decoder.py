"""The decoder: the same rows however the record is cut, and honest about all that goes wrong."""

import math
import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from calibration import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.decoding.channel_map import ChannelMap, load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError
from tests.decoding.decoding_kit import (
    HOST,
    Sender,
    assert_same,
    decode_in_chunks,
    gather,
    write_map,
)

DEG = math.pi / 180.0
FALLBACK_MAP = """
name = "test"
fallback = "0.4 s"
certificates = "b777"
{head}
[[channels]]
id = "q"
source = "DEBUG_FLOAT_ARRAY[daq].data[0]"
unit = "V"
calibration = "q"
[[channels]]
id = "q"
source = "ATTITUDE.pitchspeed"
unit = "rad/s"
priority = 2
kind = "estimated"
[[channels]]
id = "psi"
source = "ATTITUDE.yaw"
unit = "rad"
kind = "estimated"
[[channels]]
id = "dynamic_pressure"
source = "DEBUG_FLOAT_ARRAY[daq].data[1]"
unit = "hPa"
[[channels]]
id = "static_pressure"
source = "SCALED_PRESSURE.press_abs"
unit = "hPa"
[[channels]]
id = "temperature"
source = "SCALED_PRESSURE.temperature"
unit = "degC"
scale = 0.01
[[channels]]
id = "rpm_left"
source = "RAW_RPM[0].frequency"
unit = "rpm"
[[channels]]
id = "elevator_left"
source = "DEBUG_FLOAT_ARRAY[daq].data[2]"
unit = "deg"
[[channels]]
id = "elevator_right"
source = "SERVO_OUTPUT_RAW.servo1_raw"
unit = "deg"
scale = 0.05
offset = -75
"""


def channel_map(folder: Path, text: str = FALLBACK_MAP) -> ChannelMap:
    return load_channel_map(write_map(folder, text.format(head="")))


def troubled_record(seed: int) -> list[RawRecord]:
    """Return records with losses, delays, silence, duplicates, an outlier, a restart, a pause."""
    generator = random.Random(seed)
    send = Sender()
    events: list[tuple[float, Callable[[int], RawRecord]]] = []
    boot = 20.0

    def add(time: float, make: Callable[[int, float], RawRecord]) -> None:
        delay = 0.01 + generator.expovariate(100.0)
        if generator.random() < 0.01:
            delay += 1.5 * generator.random()
        stamp = time
        events.append((time + delay, lambda host: make(host, stamp)))
        if generator.random() < 0.02:
            events.append((time + delay + 0.003, lambda host: make(host, stamp)))

    restart, pause = 10.013, 13.0
    for k in range(1600):
        true = k / 100.0
        if true > pause:
            true += 100.0
        vehicle = true + boot if true < restart else true - restart + 0.05
        silent = 6.0 < true < 8.2 or generator.random() < 0.1
        if not silent:
            stamp = round(vehicle * 1e6) + generator.randrange(300)
            if k == 400:
                stamp += 77_000_000
            volts = [2.5 + math.sin(true), 3.0 + math.cos(3 * true), 10 * math.sin(true)]
            add(true, lambda host, _t, s=stamp, v=volts: send.daq(host, s, v))
        if k % 4 == 0:
            ms = round(vehicle * 1000)
            add(
                true,
                lambda host, t, ms=ms: send(
                    host, "attitude", ms, 0.1, 0.2, math.remainder(t, 2 * math.pi), 0, 0.3 * t, 0
                ),
            )
        if k % 10 == 0:
            ms = round(vehicle * 1000)
            add(
                true,
                lambda host, t, ms=ms: send(
                    host, "scaled_pressure", ms, 1000 - 0.1 * t, 0.0, 2000 + round(10 * t)
                ),
            )
            add(true, lambda host, t: send(host, "raw_rpm", 0, 9000 + 10 * t))
            add(true, lambda host, _t: send(host, "raw_rpm", 1, 100.0))
        if k % 5 == 0:
            us = round(vehicle * 1e6) & 0xFFFFFFFF
            add(
                true,
                lambda host, t, us=us: send(
                    host, "servo_output_raw", us, 0, round(1500 + 100 * math.sin(t)), *[1500] * 7
                ),
            )
    events.sort(key=lambda event: event[0])
    return [make(round(at * 1e6)) for at, make in events]


@pytest.fixture(scope="module")
def troubled(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    chosen = channel_map(tmp_path_factory.mktemp("map"))
    certificates = load_certificates("b777")

    def make() -> Decoder:
        return Decoder(chosen, certificates=certificates)

    @cache
    def whole(seed: int) -> tuple[list[RawRecord], dict[str, tuple[np.ndarray, np.ndarray]]]:
        records = troubled_record(seed)
        return records, decode_in_chunks(make, records, [len(records)])[0]

    return SimpleNamespace(make=make, whole=whole)


@given(
    seed=st.integers(0, 3),
    sizes=st.lists(st.one_of(st.integers(1, 3), st.integers(1, 400)), min_size=1, max_size=20),
)
@settings(max_examples=5, deadline=None)
def test_chunking_changes_nothing(troubled: SimpleNamespace, seed: int, sizes: list[int]) -> None:
    records, expected = troubled.whole(seed)
    found, _ = decode_in_chunks(troubled.make, records, sizes)
    assert_same(found, expected)


def test_the_troubled_record_exercises_everything(troubled: SimpleNamespace) -> None:
    records, expected = troubled.whole(0)
    _, decoder = decode_in_chunks(troubled.make, records, [97])
    assert {"restart", "outlier"} <= {notice.kind for notice in decoder.notices}
    assert decoder.duplicates > 10
    assert decoder.reordered > 0
    assert {"qbar", "V", "Vc", "density", "altitude", "de", "rpm_left", "q_volts"} <= set(expected)
    index, q = expected["q"]
    # While the volts were silent (6 to 8.2 s after the start at 20) the estimate stood in.
    estimate = q[(index > 2650) & (index < 2800)]
    assert np.all(np.isfinite(estimate))
    volts_index, volts = expected["q_volts"]
    assert np.all(np.isnan(volts[(volts_index > 2650) & (volts_index < 2800)]))
    # The pause of 100 s is not filled.
    assert np.max(np.diff(index)) > 6000


def test_rows_come_as_soon_as_the_next_sample() -> None:
    """Each 100 Hz sample of the box hands out its own row at once; slow messages hold nothing."""
    decoder = Decoder(load_channel_map("b777"))
    send = Sender()
    seen = []
    for k in range(100):
        records = [send.daq(10_000 * k + 500, 10_000 * k, [2.5] * 20)]
        if k == 50:
            records.append(send.attitude(10_000 * k + 600, 10 * k, 0.1))
        blocks = decoder.feed(records)
        seen += [(k, block.times.tolist()) for block in blocks if "alpha" in block]
    # The first sample waits for a second one that confirms the clock.
    assert seen[0] == (1, [0.0, 0.01])
    assert seen[1:] == [(k, [k / 100]) for k in range(2, 100)]


def test_the_box_is_read_right() -> None:
    """Volts made from known values by the certificates come back as these values, and derived."""
    certificates = load_certificates("b777")
    truth = {
        "elevator_left": -4 * DEG, "elevator_right": -6 * DEG, "aileron_left": 3 * DEG,
        "aileron_right": 5 * DEG, "rudder": 2 * DEG, "alpha": 5 * DEG, "beta": -3 * DEG,
        "p": 10 * DEG, "q": -20 * DEG, "r": 5 * DEG, "ax": 1.0, "ay": -2.0, "an": 9.80665,
        "static_pressure": 98000.0, "dynamic_pressure": 500.0, "temperature": 293.0,
        "throttle": 0.6, "flap": 10 * DEG,
    }  # fmt: skip
    volts = [float(certificates[name].volts(value)) for name, value in truth.items()]
    volts += [5.0, 2.4]
    decoder = Decoder(load_channel_map("b777"), aircraft=load_aircraft("b777"))
    send = Sender()
    records = [send.daq(10_000 * k, 10_000 * k, volts) for k in range(10)]
    found = gather(decoder.feed(records) + decoder.finish())
    for name, value in truth.items():
        # MAVLink carries the volts in single precision.
        assert found[name][1] == pytest.approx(value, rel=2e-6, abs=2e-6), name
    assert found["battery"][1] == pytest.approx(12.0)
    assert found["excitation"][1] == pytest.approx(5.0)
    assert found["elevator_left_volts"][1] == pytest.approx(volts[0], rel=1e-6)
    rho = 98000.0 / (287.05287 * 293.0)
    expected = {
        "de": -5 * DEG, "da": 4 * DEG, "dr": 2 * DEG, "qbar": 500.0, "density": rho,
        "V": math.sqrt(1000.0 / rho), "Vc": math.sqrt(1000.0 / 1.225),
        "altitude": 288.15 / 0.0065 * (1 - (98000 / 101325) ** (287.05287 * 0.0065 / 9.80665)),
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name][1] == pytest.approx(value, rel=1e-5, abs=1e-5), name
        assert decoder.sources[name].kind == "derived"
        assert decoder.sources[name].calibrated
    assert decoder.sources["alpha"].calibrated
    assert decoder.sources["alpha"].kind == "measured"
    assert not decoder.sources["alpha_volts"].calibrated
    assert decoder.sources["phi"].kind == "estimated"
    assert decoder.sources["rpm_left"].timing == "arrival"
    assert decoder.clipped == {}


def test_calibration_of_the_decoder_is_the_certificates() -> None:
    certificates = load_certificates("b777")
    generator = np.random.default_rng(3)
    rows = generator.uniform(0.0, 5.0, (50, 20)).astype(np.float32).astype(np.float64)
    rows[:, 18] = np.float32(4.7)
    rows[7, 18] = 0.0
    send = Sender()
    records = [send.daq(10_000 * k, 10_000 * k, row.tolist()) for k, row in enumerate(rows)]
    decoder = Decoder(load_channel_map("b777"), certificates=certificates)
    found = gather(decoder.feed(records) + decoder.finish())
    for column, name in enumerate(list(certificates_in_order())):
        expected = certificates[name].evaluate(rows[:, column], rows[:, 18])
        np.testing.assert_array_equal(found[name][1], expected, err_msg=name)
        outside = certificates[name].extrapolated(rows[:, column], rows[:, 18])
        assert decoder.clipped.get(name, 0) == np.count_nonzero(outside), name


def certificates_in_order() -> list[str]:
    chosen = load_channel_map("b777")
    return [entry.channel for entry in chosen.entries if entry.calibration]


def test_without_certificates_there_are_volts_only() -> None:
    decoder = Decoder(load_channel_map("b777"), certificates={})
    assert "alpha_volts" in decoder.channels
    assert not {"alpha", "de", "qbar", "V"} & set(decoder.channels)
    send = Sender()
    found = gather(decoder.feed([send.daq(0, 0, [1.25] * 20), send.daq(9, 10_000, [1.25] * 20)]))
    assert found["alpha_volts"][1].tolist() == [1.25, 1.25]


@settings(max_examples=12)
@given(kept=st.sets(st.sampled_from(sorted(load_certificates("b777")))))
@example(kept={"rudder"})
@example(kept={"dynamic_pressure"})
@example(kept=set())
def test_any_subset_of_certificates_decodes(kept: set[str]) -> None:
    """What is calibrated reads as with all certificates; of the rest only the volts remain."""
    whole = load_certificates("b777")
    generator = np.random.default_rng(5)
    send = Sender()
    records = []
    for k, volts in enumerate(generator.uniform(1.0, 4.0, (12, 20))):
        records.append(send.daq(10_000 * k, 10_000 * k, [*volts[:18], 5.0, 2.4]))
        records.append(send.attitude(10_000 * k + 900, 10 * k, 0.1, 0.2, 0.3))

    def decode(names: set[str], sizes: list[int]) -> Any:
        return decode_in_chunks(
            lambda: Decoder(
                load_channel_map("b777"),
                certificates={name: whole[name] for name in names},
                aircraft=load_aircraft("b777"),
            ),
            records,
            sizes,
        )

    found, decoder = decode(kept, [len(records)])
    every, _ = decode(set(whole), [len(records)])
    assert_same(found, decode(kept, [1])[0])
    assert set(found) <= set(decoder.channels)
    for name in whole:
        assert (name in found) == (name in kept)
        np.testing.assert_array_equal(found[f"{name}_volts"][1], every[f"{name}_volts"][1])
    alone = {"dr": "rudder", "qbar": "dynamic_pressure", **{name: name for name in whole}}
    for name, certificate in alone.items():
        if certificate in kept:
            np.testing.assert_array_equal(found[name][1], every[name][1], err_msg=name)
    for name, source in decoder.counted_sources().items():
        if source.kind == "derived":
            # Every input of a derived channel arrived, so it has rows of its own.
            assert name in found, name


def test_clipped_gyros_are_counted() -> None:
    decoder = Decoder(load_channel_map("b777"), aircraft=load_aircraft("b777"))
    send = Sender()
    volts = [2.5] * 20
    step = 5.0 / 4096
    volts[8], volts[9] = round(4.5 / step) * step, 4.75
    records = [send.daq(10_000 * k, 10_000 * k, volts) for k in range(5)]
    decoder.feed(records)
    assert decoder.clipped["q"] == 5
    assert decoder.clipped["r"] == 5
    assert "p" not in decoder.clipped


def test_a_second_aircraft_is_left_out_and_named() -> None:
    """The map's system counts; without one the first heard. The other is named once."""
    one, two = Sender(system=1), Sender(system=2)
    for chosen, first in (("b777", 1), ("ardupilot-plane", 2)):
        decoder = Decoder(load_channel_map(chosen))
        records = []
        for k in range(20):
            records.append(two.attitude(50_000 * k, 50 * k, 0.2))
            records.append(one.attitude(50_000 * k + 10, 50 * k, 0.1))
        found = gather(decoder.feed(records))
        assert decoder.system == first
        assert np.allclose(found["phi"][1], 0.1 * first)
        others = [notice for notice in decoder.notices if notice.kind == "other-system"]
        assert len(others) == 1
        assert f"system = {3 - first}" in others[0].text


def test_the_first_autopilot_heard_is_flown_not_the_first_sender() -> None:
    gimbal, radio = Sender(system=3, component=154), Sender(system=51, component=68)
    aircraft = Sender(system=7)
    early = [
        record
        for k in range(10)
        for record in (
            radio(50_000 * k, "radio_status", 180, 190, 100, 40, 45, 0, 0),
            gimbal.attitude(50_000 * k, 50 * k, 0.3),
        )
    ]
    beat = aircraft(600_000, "heartbeat", 1, 3, 0, 0, 4, 3)
    late = [aircraft.attitude(700_000 + 50_000 * k, 50 * k, 0.7) for k in range(10)]
    for first in (beat, aircraft.attitude(600_000, 0, 0.7)):
        decoder = Decoder(load_channel_map("ardupilot-plane"))
        decoder.feed(early)
        assert decoder.system is None
        found = gather(decoder.feed([first, *late]) + decoder.finish())
        assert (decoder.system, decoder.health.flown) == (7, (7, 1))
        assert np.allclose(found["phi"][1], 0.7)
        assert [notice.system for notice in decoder.notices] == [3]


def test_without_an_autopilot_the_first_system_that_measures_is_flown() -> None:
    box, other = Sender(system=3, component=191), Sender(system=4, component=191)
    for count in (20, 100):
        decoder = Decoder(load_channel_map("ardupilot-plane"))
        records = [
            record
            for k in range(count)
            for record in (
                box.attitude(50_000 * k, 50 * k, 0.3),
                other.attitude(50_000 * k + 1, 50 * k, 0.4),
            )
        ]
        found = gather(decoder.feed(records) + decoder.finish())
        assert (decoder.system, decoder.health.flown) == (3, (3, 191))
        assert np.allclose(found["phi"][1], 0.3)
        assert found["phi"][0][0] == 0
        assert found["phi"][0][-1] == 5 * (count - 1)


def test_the_system_that_the_crew_chose_goes_before_the_map_and_the_first() -> None:
    one, two = Sender(system=1), Sender(system=2)
    decoder = Decoder(load_channel_map("b777"), system=2)  # the map says 1
    records = []
    for k in range(20):
        records.append(one.attitude(50_000 * k, 50 * k, 0.1))
        records.append(two.attitude(50_000 * k + 10, 50 * k, 0.2))
    found = gather(decoder.feed(records))
    assert decoder.system == 2
    assert np.allclose(found["phi"][1], 0.2)


@pytest.mark.parametrize("system", [250, 255])
def test_a_ground_station_is_never_taken_for_the_aircraft(system: int) -> None:
    ground, aircraft = Sender(system=system, component=190), Sender(system=7)
    decoder = Decoder(load_channel_map("px4"))
    records = []
    for k in range(10):
        records.append(ground(50_000 * k, "manual_control", 7, 900, 0, 0, 0, 0))
        records.append(aircraft.attitude(50_000 * k + 10, 50 * k, 0.1))
    found = gather(decoder.feed(records) + decoder.finish())
    assert decoder.system == 7
    assert "stick_pitch" not in found
    assert decoder.notices == []


def test_a_second_component_is_left_out_and_named() -> None:
    autopilot, gimbal = Sender(component=1), Sender(component=154)
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    records = []
    for k in range(10):
        records.append(autopilot.attitude(50_000 * k, 50 * k, 0.1))
        records.append(gimbal.attitude(50_000 * k + 10, 50 * k + 1, 0.9))
    found = gather(decoder.feed(records))
    assert np.allclose(found["phi"][1], 0.1)
    assert [notice.component for notice in decoder.notices] == [154]


def test_unknown_messages_are_counted_and_named() -> None:
    """A message outside the dialect is counted by id and named once; nothing else is hurt."""
    body = bytes([4, 0, 0, 0, 1, 1]) + (54_321).to_bytes(3, "little") + b"abcd"
    stranger = RawRecord(HOST, "frame", b"\xfd" + body + b"\0\0")
    decoder = Decoder(load_channel_map("b777"))
    assert decoder.feed([stranger] * 3) == []
    assert decoder.unknown == {54_321: 3}
    assert [notice.kind for notice in decoder.notices] == ["unknown-message"]
    assert "54321" in decoder.notices[0].text
    assert decoder.notices[0].time is None  # no clock was heard yet
    assert decoder.health.unknown == 3


def test_mavlink_1_and_2_mixed() -> None:
    send = Sender()
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    records = [
        send(10_000 * k, "attitude", 10 * k, 0.01 * k, 0, 0.02 * k, 0, 0, 0, v1=k % 2 == 0)
        for k in range(20)
    ]
    found = gather(decoder.feed(records))
    np.testing.assert_allclose(found["phi"][1], 0.01 * np.arange(20), rtol=1e-6)
    np.testing.assert_allclose(found["psi"][1], 0.02 * np.arange(20), rtol=1e-6)


def test_system_time_lays_two_ways_of_counting_together() -> None:
    """A box dates its samples and counts its attitude from boot; another aircraft is not asked.

    Placed by arrival, the samples would be late by what the link takes longer for them.
    """
    box, other = Sender(), Sender(system=2)
    decoder = Decoder(load_channel_map("b777"))
    switched_on = HOST - 7_000_000_000
    records = []
    for k in range(100):
        boot = 40_000 + 10 * k
        records.append(box.attitude(10_000 * k, boot, 0.0))
        if k == 0:
            for send, off in ((box, 0), (other, 30_000)):
                unix = switched_on + 1000 * boot + off
                records.append(send(10_000 * k, "system_time", unix, boot))
        else:
            dated = switched_on + 1000 * boot
            records.append(box.daq(10_000 * k + 8_000, dated, [0.01 * k] * 20))
    found = gather(decoder.feed(records) + decoder.finish())
    assert (found["alpha"][0][0], found["alpha"][0][-1]) == (4_001, 4_099)
    assert "other-clock" not in [notice.kind for notice in decoder.notices]


def test_status_texts() -> None:
    send = Sender()
    decoder = Decoder(load_channel_map("b777"))
    decoder.feed(
        [
            send.daq(0, 5_000_000, [0.0] * 20),
            send.daq(10_000, 5_010_000, [0.0] * 20),
            send(20_000, "statustext", 4, b"Engine out"),
            send(30_000, "statustext", 6, b"x" * 50, 7, 0),
            send(31_000, "statustext", 6, b"yz", 7, 1),
        ]
    )
    assert [(m.text, m.severity) for m in decoder.messages] == [
        ("Engine out", 4),
        ("x" * 50 + "yz", 6),
    ]
    assert decoder.messages[0].time == pytest.approx(5.02)


def test_a_text_that_lost_pieces_is_told_as_torn() -> None:
    send = Sender()
    decoder = Decoder(load_channel_map("b777"))

    def said(*records: Any) -> list[str]:
        before = len(decoder.messages)
        decoder.feed(records)
        return [message.text for message in decoder.messages[before:]]

    def piece(at: int, words: bytes, number: int, place: int) -> Any:
        return send(at, "statustext", 4, words, number, place)

    a, b, c = b"a" * 50, b"b" * 50, b"c" * 50
    assert said(piece(0, a, 1, 0), piece(1_000, b, 1, 1)) == []
    # The vehicle has restarted meanwhile, and counts anew.
    assert said(piece(2_000, b"Battery failsafe", 1, 0)) == [
        "a" * 50 + "b" * 50 + "…",
        "Battery failsafe",
    ]
    assert said(piece(3_000, a, 9, 0), piece(4_000, b"end", 9, 2)) == ["a" * 50 + "…end"]
    assert said(piece(5_000, b, 5, 1), send(4_000_000, "heartbeat", 1, 3, 81, 0, 4, 3)) == []
    assert said(send(5_100_000, "heartbeat", 1, 3, 81, 0, 4, 3)) == ["…" + "b" * 50 + "…"]
    assert said(piece(6_000_000, c, 6, 0), piece(6_000_001, c, 6, 0)) == []  # by two ways
    decoder.finish()
    assert decoder.messages[-1].text == "c" * 50 + "…"


def test_lines_of_text(tmp_path: Path) -> None:
    """Comma-separated lines with their own time: units, blanks, damaged lines, calibration."""
    text = """
name = "text box"
certificates = "b777"
[text]
columns = ["time [s]", "alpha [deg]", "", "throttle [%]"]
[[channels]]
id = "q"
source = "line[4]"
unit = "V"
calibration = "q"
"""
    decoder = Decoder(load_channel_map(write_map(tmp_path, text)))
    lines = ["time,alpha,note,throttle,q"]
    lines += [f"{k / 100:.2f},{k},9,{k / 2},{2.5 + k / 45}" for k in range(10)]
    lines[3] = "0.02,2,a word in a column that nothing takes,1,2.5"
    lines[5] = "0.04,4,9,,2.5"
    lines[7] = "0.06,gar#bage"
    records = [RawRecord(HOST + 10_000 * k, "line", line.encode()) for k, line in enumerate(lines)]
    found = gather(decoder.feed(records))
    assert found["alpha"][1] == pytest.approx(DEG * np.arange(10))
    assert found["q"][1][3] == pytest.approx(3 * DEG, abs=1e-9)
    assert np.isnan(found["throttle"][1][4])
    assert found["throttle"][1][8] == pytest.approx(0.04)
    assert decoder.bad_lines == 2
    assert [notice.kind for notice in decoder.notices] == ["bad-line"]
    assert ["2 of 11 lines" in one for one in decoder.remarks] == [True]


def test_lines_that_the_map_says_nothing_of_are_told_once() -> None:
    decoder = Decoder(load_channel_map("b777"))
    records = [RawRecord(HOST + 10_000 * k, "line", b"0.1,2,3") for k in range(5)]
    assert decoder.feed(records) == []
    (notice,) = decoder.notices
    assert "'B777 box'" in notice.text
    assert "'0.1,2,3'" in notice.text
    assert ["5 of 5 lines" in one for one in decoder.remarks] == [True]


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("20,1_000", "does not hold 2 numbers"),
        ("20,\u0661\u0662", "does not hold 2 numbers"),
        ("20,inf", "does not hold 2 numbers"),
        ("1_000,1", "does not hold 2 numbers"),
        ("-20,1", "its time is missing, negative or too great"),
        (",1", "its time is missing, negative or too great"),
        ("1e300,1", "its time is missing, negative or too great"),
    ],
)
def test_what_only_resembles_a_number_is_left_out_of_lines(
    tmp_path: Path, line: str, why: str
) -> None:
    text = 'name = "t"\n[text]\ncolumns = ["time [ms]", "alpha [deg]"]\n'
    decoder = Decoder(load_channel_map(write_map(tmp_path, text)))
    lines = ["0,1", "10,2", line, "30,", " 40 , 5 "]
    records = [RawRecord(HOST + 10_000 * k, "line", each.encode()) for k, each in enumerate(lines)]
    found = gather([*decoder.feed(records), *decoder.finish()])
    assert np.nanmax(found["alpha"][1]) == pytest.approx(5 * DEG)
    assert (decoder.lines, decoder.bad_lines) == (4, 1)
    assert why in decoder.notices[0].text


def test_lines_without_time_are_timed_by_arrival(tmp_path: Path) -> None:
    text = 'name = "t"\n[text]\ncolumns = ["alpha [deg]"]\n'
    decoder = Decoder(load_channel_map(write_map(tmp_path, text)))
    records = [RawRecord(HOST + 10_000 * k, "line", str(k).encode()) for k in range(5)]
    found = gather(decoder.feed(records) + decoder.finish())
    assert found["alpha"][0].tolist() == [0, 1, 2, 3, 4]
    assert decoder.sources["alpha"].timing == "arrival"
    assert [notice.kind for notice in decoder.notices] == ["no-clock"]


def test_arrival_times_follow_the_quickest_message() -> None:
    """RAW_RPM has no stamp: it is placed where a stamped message arriving with it would be."""
    decoder = Decoder(load_channel_map("b777"))
    send = Sender()
    records = []
    for k in range(500):
        delay = 3000 + (k * 7919) % 20_000
        records.append(send.daq(10_000 * k + delay, 10_000 * k, [2.5] * 20))
        if k % 10 == 0:
            records.append(send(10_000 * k + 3000, "raw_rpm", 0, 9000.0 + k))
    records.sort(key=lambda record: record.stamp_us)
    index, rpm = gather(decoder.feed(records))["rpm_left"]
    truth = 9000.0 + index
    late = index > 300
    np.testing.assert_allclose(rpm[late] * 30 / math.pi, truth[late], atol=0.2)


def test_a_map_for_files_is_refused() -> None:
    with pytest.raises(FlightError, match="ardupilot-plane"):
        Decoder(load_channel_map("px4-log"))


def test_residue_and_nothing() -> None:
    decoder = Decoder(load_channel_map("b777"))
    assert decoder.feed([]) == []
    assert decoder.feed([RawRecord(HOST, "residue", b"\xfd\x01garbage")]) == []
    assert decoder.health.residue_bytes == 9
    assert decoder.finish() == []


def test_invalid_readings_are_missing() -> None:
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    send = Sender()
    records = []
    for k in range(5):
        us = 10_000 * k
        records.append(send(us, "sensor_airflow_angles", us, 5.0, int(k != 2), 3.0, 1))
        pulses = [1500, 0 if k == 1 else 1600, 1500, 1500, *[0] * 14]
        records.append(send(us, "rc_channels", 10 * k, 4, *pulses, 255))
        records.append(send.attitude(us, 10 * k, math.nan if k == 3 else 0.5))
    found = gather(decoder.feed(records) + decoder.finish())
    assert np.isnan(found["alpha"][1]).tolist() == [False, False, True, False, False]
    assert found["beta"][1] == pytest.approx(3 * DEG)
    assert np.isnan(found["stick_pitch"][1]).tolist() == [False, True, False, False, False]
    assert np.isnan(found["phi"][1]).tolist() == [False, False, False, True, False]
    assert np.isnan(found["rc_rssi"][1]).all()


def test_sources_count_what_arrived_not_the_rows_of_the_grid() -> None:
    decoder = Decoder(load_channel_map("b777"))
    send = Sender()
    times = [400 * k for k in range(9)] + [400 * 8 + 2000]
    records = [send.attitude(1000 * time, time, 0.1) for time in times]
    blocks = decoder.feed(records) + decoder.finish()
    counted = decoder.counted_sources()["phi"]
    assert sum(len(block) for block in blocks if "phi" in block) == 521
    assert (counted.samples, counted.rate, counted.gaps) == (10, 2.5, 1)


@pytest.mark.parametrize("often", [1, 200])
def test_mixed_surfaces_are_taken_apart(tmp_path: Path, often: int) -> None:
    """Left 1600 us, right 1700 us: both go down by 3 deg and apart by 1 deg; 0 us is no pulse."""
    both = '["SERVO_OUTPUT_RAW.servo2_raw", "SERVO_OUTPUT_RAW.servo4_raw"]'
    text = f"""
name = "V-tail"
[[channels]]
id = "de_command"
source = {both}
convert = "mixed.mean"
unit = "deg"
scale = 0.02
offset = -30.0
missing = [0]
[[channels]]
id = "dr_command"
source = {both}
convert = "mixed.half_difference"
unit = "deg"
scale = 0.02
missing = [0]
"""
    send = Sender()
    pulses = [(1500, 1500), (1600, 1700), (0, 1700), (1500, 1400)] * often
    records = [
        send(
            round(1e6 + 1e4 * k),
            "servo_output_raw",
            10_000 * (k + 100),
            0,
            0,
            two,
            0,
            four,
            *[0] * 4,
        )
        for k, (two, four) in enumerate(pulses)
    ]
    decoder = Decoder(load_channel_map(write_map(tmp_path, text)), rate=100.0)
    blocks = [*decoder.feed(records), *decoder.finish()]

    def degrees(name: str) -> list[float]:
        found = np.concatenate([block[name] for block in blocks if name in block.channels])
        return [float(one) for one in np.degrees(found[np.isfinite(found)])]

    assert degrees("de_command")[:2] == pytest.approx([0.0, 3.0], abs=1e-9)
    assert degrees("dr_command")[:2] == pytest.approx([0.0, -1.0], abs=1e-9)
    assert degrees("de_command")[-1] == pytest.approx(-1.0, abs=1e-9)
    assert max(map(abs, degrees("dr_command"))) == pytest.approx(1.0, abs=1e-9)
