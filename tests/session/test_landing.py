"""The end of a flight is recognized: once, after it, and never in the air."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.flight import Flight, load_flight
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, extract_signals
from gsapp.flight.raw_files.raw_reader import read_tlog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.quantities import Block, FloatArray
from gsapp.session.landing_monitor import LandingMonitor
from gsapp.virtual.virtual_flight import VirtualFlight

RATE = 50.0
GROUND = 380.0


def landings(
    block: Block,
    aircraft: Aircraft | None,
    rate: float,
    on_ground: Callable[[float], bool | None] = lambda _: None,
) -> list[float | None]:
    monitor, said, step = LandingMonitor(aircraft, rate, on_ground), [], round(rate)
    for first in range(0, len(block), step):
        part = slice(first, first + step)
        monitor.feed(
            Block(channels=block.channels, times=block.times[part], values=block.values[part])
        )
        monitor.process_step()
        if monitor.landed_at != (said[-1] if said else None):
            said.append(monitor.landed_at)
    return said


def flown(*legs: tuple[float, float, float], dropped: tuple[float, float] = (0.0, 0.0)) -> Block:
    speed: FloatArray = np.concatenate([np.full(round(s * RATE), v) for s, v, _ in legs])
    height: FloatArray = np.concatenate([np.full(round(s * RATE), h) for s, _, h in legs])
    times = np.arange(speed.size) / RATE
    speed = np.where((times >= dropped[0]) & (times < dropped[1]), 0.0, speed)
    values = np.column_stack([speed, height + GROUND, 0 * speed, 0 * speed])
    return Block(channels=("V", "altitude", "p", "q"), times=times, values=values)


@pytest.mark.parametrize("aircraft", ["b777", None])
def test_the_virtual_aircraft_lands_once(
    flown_short: Callable[[int], VirtualFlight], aircraft: str | None
) -> None:
    flight = flown_short(6)
    measured = flight.measured
    rate = 1.0 / float(np.median(np.diff(measured.times)))
    said = landings(measured, load_aircraft(aircraft) if aircraft else None, rate)
    assert len(said) == 1
    speed = extract_signals(measured)[:, SIGNAL_COLUMNS["V"]]
    fast = measured.times[np.flatnonzero(speed > 12.0)[-1]]
    assert said[0] == pytest.approx(fast, abs=6.0)


def test_a_low_pass_a_touch_and_go_and_a_stall_are_no_landing() -> None:
    up = (20.0, 30.0, 50.0)
    block = flown(
        (10.0, 0.0, 0.0), up, (6.0, 28.0, 1.0), up, (4.0, 16.0, 0.0), up, (3.0, 6.0, 45.0), up
    )
    assert landings(block, load_aircraft("b777"), RATE) == []


def test_a_link_that_brings_channels_apart_lands_once() -> None:
    """Live, every message is a block of its own, and several seconds of one may come at once."""
    whole = flown((10.0, 0.0, 0.0), (20.0, 30.0, 50.0), (12.0, 0.0, 0.0))
    aircraft = load_aircraft("b777")
    monitor, said, step = LandingMonitor(aircraft, RATE), [], round(4.0 * RATE)
    for first in range(0, len(whole), step):
        part = slice(first, first + step)
        for names in (("V", "p", "q"), ("altitude",), ("throttle",), ("battery",)):
            slow = slice(part.start, part.stop, 1 if "V" in names else 10)
            values = np.column_stack([whole[n] if n in whole else whole["p"] for n in names])
            monitor.feed(Block(channels=names, times=whole.times[slow], values=values[slow]))
        monitor.process_step()
        if monitor.landed_at != (said[-1] if said else None):
            said.append(monitor.landed_at)
    assert said == [pytest.approx(30.0, abs=1.0)]


def test_a_blocked_pitot_lands_nowhere() -> None:
    block = flown((10.0, 0.0, 0.0), (90.0, 30.0, 50.0), dropped=(30.0, 90.0))
    assert landings(block, load_aircraft("b777"), RATE) == []


def test_another_take_off_takes_the_landing_back() -> None:
    ground, up = (15.0, 0.0, 0.0), (20.0, 30.0, 50.0)
    said = landings(flown(ground, up, ground, up, ground), load_aircraft("b777"), RATE)
    assert said == [pytest.approx(35.0, abs=3.0), None, pytest.approx(70.0, abs=3.0)]


def reports(*messages: tuple[float, mavlink.MAVLink_message]) -> Callable[[float], bool | None]:
    wire = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    decoder = Decoder(load_channel_map("ardupilot-plane"), certificates={})
    for time, message in messages:
        attitude = mavlink.MAVLink_attitude_message(round(1000 * time), 0, 0, 0, 0, 0, 0)
        decoder.feed(
            [
                RawRecord(round(1e6 * (1e9 + time)), "frame", bytes(one.pack(wire)))
                for one in (attitude, message)
            ]
        )
    return decoder.landed_state.on_ground


def heartbeat(*, armed: bool) -> mavlink.MAVLink_message:
    mode = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    return mavlink.MAVLink_heartbeat_message(1, 3, mode, 0, 4, 3)


def landed_state(name: str) -> mavlink.MAVLink_message:
    state = getattr(mavlink, f"MAV_LANDED_STATE_{name}")
    return mavlink.MAVLink_extended_sys_state_message(0, state)


@pytest.mark.parametrize(
    "messages",
    [
        [(0.0, heartbeat(armed=False)), (2.0, heartbeat(armed=True)),
         (41.0, heartbeat(armed=False))],
        [(0.0, landed_state("ON_GROUND")), (12.0, landed_state("IN_AIR")),
         (41.0, landed_state("ON_GROUND"))],
    ],
    ids=["disarmed", "landed_state"],
)  # fmt: skip
def test_the_autopilot_reports_the_landing(
    messages: list[tuple[float, mavlink.MAVLink_message]],
) -> None:
    block = flown((10.0, 0.0, 0.0), (30.0, 30.0, 50.0), (20.0, 5.0, 0.0))
    values = block.values.copy()
    values[:, 2] = 0.3
    block = replace(block, values=values)
    aircraft = load_aircraft("b777")
    assert landings(block, aircraft, RATE) == []
    assert landings(block, aircraft, RATE, reports(*messages)) == [pytest.approx(41.0, abs=1.1)]
    blind = replace(block, values=np.full_like(block.values, np.nan))
    assert landings(blind, None, RATE, reports(*messages)) == []


def test_an_autopilot_that_disarms_at_flying_speed_has_not_landed() -> None:
    block = flown((10.0, 0.0, 0.0), (60.0, 30.0, 50.0))
    said = reports((0.0, heartbeat(armed=True)), (30.0, heartbeat(armed=False)),
                   (40.0, landed_state("ON_GROUND")))  # fmt: skip
    assert said(50.0)
    assert landings(block, load_aircraft("b777"), RATE, said) == []


def test_standing_before_the_flight_is_no_landing() -> None:
    assert landings(flown((60.0, 0.5, 0.0)), load_aircraft("b777"), RATE) == []


def real_flight(name: str, channel_map: str) -> Flight:
    given = os.environ.get("GSAPP_SHARED_DATA")
    folder = Path(given) if given else Path(__file__).parents[3] / "shared" / "data"
    if not (folder / name).is_file():
        pytest.skip(f"the real flight is not at {folder / name}")
    return load_flight(folder / name, channel_map=channel_map)


def test_a_real_flight_whose_record_ends_in_the_air_does_not_land() -> None:
    flight = real_flight("f16_rc_px4.ulg", "px4-log")
    assert landings(flight.block, None, flight.rate) == []


def test_a_real_flight_lands_when_it_is_put_down_at_its_end() -> None:
    flight = real_flight("alfa_carbonz_engine_failure.tlog", "ardupilot-plane")
    decoder = Decoder(load_channel_map("ardupilot-plane"), certificates={})
    decoder.feed(list(read_tlog(flight.path)))
    assert decoder.landed_state.on_ground(flight.block.times[-1]) is False
    assert landings(flight.block, None, flight.rate, decoder.landed_state.on_ground) == []
    block, count = flight.block, round(20 * flight.rate)
    times = block.times[-1] + np.arange(1, count + 1) / flight.rate
    last = np.tile(block.values[-1], (count, 1))
    for channel in ("V", "Vc", "ground_speed", "p", "q", "r"):
        last[:, block.channels.index(channel)] = 0.0
    altitude = block["altitude"]
    last[:, block.channels.index("altitude")] = altitude[np.isfinite(altitude)][-1]
    stopped = replace(
        block,
        times=np.concatenate([block.times, times]),
        values=np.concatenate([block.values, last]),
    )
    assert landings(stopped, None, flight.rate) == [pytest.approx(times[0], abs=4.0)]
