"""Derived channels: air data by the book, from what is there, and never over a measurement."""

import gc
import sys
from pathlib import Path

import numpy as np
import pytest

from gsapp.decoding import air_data
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.derived_channels import SlowInput, select_derivations
from gsapp.decoding.settings import DECODING
from tests.decoding.decoding_kit import Sender, assert_same, decode_in_chunks, gather, write_map


def test_air_data_by_the_book() -> None:
    """Standard atmosphere at 5,000 ft and sea level: density, altitude, speeds."""
    pressure, temperature = np.array([84_307.0, 101_325.0]), np.array([278.24, 288.15])
    rho = air_data.density(pressure, temperature)
    np.testing.assert_allclose(rho, [1.0556, 1.2250], rtol=2e-4)
    np.testing.assert_allclose(air_data.standard_density(pressure), rho, rtol=2e-4)
    np.testing.assert_allclose(air_data.altitude(pressure), [1524.0, 0.0], atol=1.0)
    qbar = air_data.dynamic_pressure(np.array([30.0, 30.0]), rho)
    np.testing.assert_allclose(air_data.true_airspeed(qbar, rho), 30.0)
    np.testing.assert_allclose(air_data.calibrated_airspeed(qbar)[1], 30.0, rtol=1e-4)
    np.testing.assert_allclose(
        air_data.sea_level_dynamic_pressure(air_data.calibrated_airspeed(qbar)), qbar
    )


def test_nonsense_gives_nothing_rather_than_a_number() -> None:
    bad = np.array([-100.0, 0.0, np.nan, 1e5])
    assert np.isnan(air_data.density(bad, np.full(4, 290.0))).tolist() == [True, True, True, False]
    assert np.isnan(air_data.density(np.full(4, 1e5), bad)).tolist() == [True, True, True, False]
    assert np.isnan(air_data.altitude(bad)).tolist() == [True, True, True, False]
    speed = air_data.true_airspeed(np.array([-3.0, np.nan]), np.array([1.2, 1.2]))
    assert speed[0] == 0.0
    assert np.isnan(speed[1])
    assert air_data.sea_level_dynamic_pressure(np.array([-2.0]))[0] == -2.45


def outputs(*available: str) -> dict[str, tuple[str, ...]]:
    return {each.output: each.inputs for each in select_derivations(available)}


def test_only_what_is_not_measured_is_derived() -> None:
    everything = ("dynamic_pressure", "static_pressure", "temperature")
    assert set(outputs(*everything)) == {"qbar", "Vc", "V", "density", "altitude"}
    assert "V" not in outputs(*everything, "V")
    assert "qbar" not in outputs(*everything, "qbar")
    assert outputs("elevator_left", "elevator_right", "de") == {}
    assert outputs("elevator_left") == {}


def test_dynamic_pressure_from_either() -> None:
    assert outputs("dynamic_pressure")["qbar"] == ("dynamic_pressure",)
    assert outputs("Vc")["qbar"] == ("Vc",)
    assert outputs("V", "static_pressure")["qbar"] == ("V", "static_pressure")
    # What the vehicle corrected itself goes before the raw pressure.
    assert outputs("Vc", "dynamic_pressure")["qbar"] == ("Vc",)


def test_without_a_thermometer_the_standard_day_is_assumed_and_said() -> None:
    found = {each.output: each for each in select_derivations(["Vc", "static_pressure"])}
    assert "standard day assumed" in found["V"].description
    assert found["qbar"].assumed == ""


TWO_ELEVATORS = """
name = "t"
[[channels]]
id = "elevator_left"
source = "DEBUG_VECT[left].x"
unit = "deg"
[[channels]]
id = "elevator_right"
source = "DEBUG_VECT[right].x"
unit = "deg"
"""


def test_inputs_from_two_messages_meet_row_by_row(tmp_path: Path) -> None:
    decoder = Decoder(load_channel_map(write_map(tmp_path, TWO_ELEVATORS)))
    send = Sender()
    records = []
    for k in range(100):
        records.append(send(10_000 * k, "debug_vect", b"left", 10_000 * k, float(k), 0, 0))
        if k % 5 == 0:
            records.append(send(10_000 * k, "debug_vect", b"right", 10_000 * k, 2.0 * k, 0, 0))
    index, de = gather(decoder.feed(records))["de"]
    assert index.tolist() == list(range(96))
    np.testing.assert_allclose(np.degrees(de), 1.5 * index, atol=1e-9)
    assert decoder.sources["de"].kind == "derived"


def test_a_slow_message_never_holds_back_a_quick_one() -> None:
    """With pressure and temperature once in ten rows V still comes with every row."""
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    send = Sender()
    last = {}
    for k in range(200):
        records = [
            send(10_000 * k, "attitude", 10 * k, 0, 0, 0, 0, 0, 0),
            send(10_000 * k, "vfr_hud", 20.0, 20.0, 0, 0, 0.0, 0.0),
        ]
        if k % 100 == 0:
            records.append(send(10_000 * k, "scaled_pressure", 10 * k, 950.0, 1.0, 2000))
        for block in decoder.feed(records):
            for name in block.channels:
                last[name] = block.times[-1]
    # VFR_HUD is the second source, so it counts from the stated two seconds on.
    # The row of the very moment waits for the next message: the first source may still have it.
    blocks = decoder.feed([send(2_100_000, "attitude", 2100, 0, 0, 0, 0, 0, 0),
                           send(2_100_000, "vfr_hud", 20.0, 20.0, 0, 0, 0.0, 0.0),
                           send(2_101_000, "attitude", 2101, 0, 0, 0, 0, 0, 0)])  # fmt: skip
    found = gather(blocks)
    assert found["V"][0][-1] == 210
    rho = float(air_data.standard_density(np.array([95_000.0]))[0])
    assert found["V"][1][-1] == pytest.approx(20.0 * np.sqrt(1.225 / rho))
    assert decoder.sources["V"].timing == "arrival"


def test_an_input_that_never_comes_costs_no_memory(tmp_path: Path) -> None:
    decoder = Decoder(load_channel_map(write_map(tmp_path, TWO_ELEVATORS)))
    send = Sender()
    kept = []
    for second in range(1800):
        first = 100_000 * (10 * second)
        decoder.feed(
            [
                send(first + 100_000 * k, "debug_vect", b"left", first + 100_000 * k, 1.0, 0, 0)
                for k in range(10)
            ]
        )
        if second % 300 == 299:
            kept.append(memory_of(decoder))
    assert max(kept[1:]) < 1.2 * kept[0]


def memory_of(decoder: Decoder) -> int:
    seen: set[int] = set()
    waiting: list[object] = [decoder]
    total = 0
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen or isinstance(thing, type):
            continue
        seen.add(id(thing))
        total += sys.getsizeof(thing)
        waiting += gc.get_referents(thing) if not callable(thing) else []
    return total


@pytest.mark.parametrize("pause", [130])
def test_how_long_an_input_is_waited_for_depends_on_the_record_alone(
    tmp_path: Path, pause: int
) -> None:
    path = write_map(tmp_path, TWO_ELEVATORS)
    send, records = Sender(), []
    for k in range(2500):
        now = 100_000 * k
        records.append(send(now, "debug_vect", b"left", now, float(k), 0, 0))
        if k >= 10 * pause:
            records.append(send(now + 50_000, "debug_vect", b"right", now - 2_000_000, 1.0, 0, 0))
    whole, _ = decode_in_chunks(lambda: Decoder(load_channel_map(path)), records, [len(records)])
    for sizes in ([1], [7, 400]):
        found, _ = decode_in_chunks(lambda: Decoder(load_channel_map(path)), records, sizes)
        assert_same(whole, found)
    assert whole["de"][0].size > 100


def test_a_slow_sample_counts_from_after_it_came_for_half_a_minute() -> None:
    slow = SlowInput(2)
    # The second of the first source came late, and one was no number.
    slow.push(0, [10, 20, 60], [10, 25, 60], [1.0, 2.0, float("nan")])
    slow.push(1, [5, 70], [5, 70], [-1.0, -2.0])
    told = {5: None, 6: -1.0, 10: -1.0, 11: 1.0, 25: 1.0, 26: 2.0, 60: 2.0, 61: -1.0, 71: -2.0,
            DECODING.max_hold + 60: -2.0, DECODING.max_hold + 70: -2.0,
            DECODING.max_hold + 71: None}  # fmt: skip
    times = np.array(list(told), dtype=np.float64)
    expected = np.array([np.nan if value is None else value for value in told.values()])
    np.testing.assert_array_equal(slow.at(times), expected)
    np.testing.assert_array_equal(slow.at_scalars(times.tolist()), expected)
    for time, value in zip(times, expected, strict=True):
        np.testing.assert_array_equal(slow.at(np.array([time])), [value])


def test_what_is_forgotten_of_a_slow_channel_is_asked_for_no_more() -> None:
    slow, whole = SlowInput(1), SlowInput(1)
    times = list(range(0, 400_000, 1000))
    for kept in (slow, whole):
        kept.push(0, times, times, [float(time) for time in times])
    slow.drop_before(200_500)
    later = np.arange(200_500.0, 400_000.0, 250.0)
    np.testing.assert_array_equal(slow.at(later), whole.at(later))
    assert np.isnan(slow.at(np.array([150_000.0]))).all()
