"""Dirt of virtual flights: drawn as documented, and at work where it should be."""

import json

import numpy as np
import pytest

from gsapp.aircraft import Accuracy, Aircraft, load_aircraft
from gsapp.decoding.dialect import dialect
from gsapp.foundation import FlightError
from gsapp.quantities.constants import GRAVITY
from gsapp.virtual.dirt import DIRT_KINDS, Dirt, StructuralMode, draw_dirt
from gsapp.virtual.downlink.flight_downlink import cut_to_maneuvers
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.downlink.onboard_messages import Packet
from gsapp.virtual.instruments import StructuralVibration
from gsapp.virtual.virtual_flight import truth_block

SEEDS = range(200)


@pytest.fixture(scope="module")
def aircraft() -> Aircraft:
    return load_aircraft("b777")


def test_a_kind_alone_is_the_same_as_in_company(aircraft: Aircraft) -> None:
    """What one kind does can only be found so."""
    every = draw_dirt(("all",), 3, aircraft)
    assert every.kinds == tuple(DIRT_KINDS)
    for kind in DIRT_KINDS:
        alone = draw_dirt((kind,), 3, aircraft).as_dict()
        drawn = {name: value for name, value in alone.items() if value != Dirt().as_dict()[name]}
        del drawn["kinds"], drawn["seed"]
        assert drawn, f"{kind} draws nothing"
        assert drawn == {name: every.as_dict()[name] for name in drawn}
    assert every.as_dict() != draw_dirt(("all",), 4, aircraft).as_dict()


def test_sizes_are_those_documented(aircraft: Aircraft) -> None:
    drawn = [draw_dirt(("all",), seed, aircraft) for seed in SEEDS]
    offsets = np.array([[*one.positions.values()] for one in drawn])
    assert 0.045 < np.abs(offsets).max() <= 0.05
    lags = [lag for one in drawn for lag in one.lags.values()]
    assert 0.01 <= min(lags) < 0.012 < 0.038 < max(lags) <= 0.04
    masses = [one.mass_factor for one in drawn]
    assert 0.95 <= min(masses) < 0.955 < 1.045 < max(masses) <= 1.05
    assert all(len(one.lags) == 3 for one in drawn)


def test_an_unknown_kind_is_answered_with_the_nearest(aircraft: Aircraft) -> None:
    with pytest.raises(FlightError, match="lags"):
        draw_dirt(("lag",), 0, aircraft)
    with pytest.raises(FlightError, match="mass"):
        FlightSettings(dirt="mas")


def test_the_aircraft_that_flies_is_not_that_of_its_file(aircraft: Aircraft) -> None:
    dirt = draw_dirt(("positions", "upwash", "mass", "accelerometers"), 5, aircraft)
    actual = dirt.apply_to(aircraft)
    vane, file = actual.sensors.alpha_vane, aircraft.sensors.alpha_vane
    assert np.subtract(vane.position, file.position) == pytest.approx(dirt.positions["alpha_vane"])
    assert vane.upwash == dirt.upwash["alpha_vane"]
    assert actual.mass.mass == aircraft.mass.mass * dirt.mass_factor
    assert np.subtract(
        actual.sensors.accelerometer.bias, aircraft.sensors.accelerometer.bias
    ) == pytest.approx(tuple(dirt.offsets.values()))
    assert Dirt().apply_to(aircraft) == aircraft


def test_the_accuracy_stated_is_that_of_what_is_drawn(aircraft: Aircraft) -> None:
    """The root mean square of each deviation is within a third of what the file then says."""
    drawn = [draw_dirt(("all",), seed, aircraft) for seed in SEEDS]
    stated = Accuracy(**drawn[0].accuracy)
    found = {
        "mass": [one.mass_factor - 1.0 for one in drawn],
        "position": [off for one in drawn for place in one.positions.values() for off in place],
        # Of twelve channels three are late.
        "delay": [lag for one in drawn for lag in (*one.lags.values(), *[0.0] * 9)],
        "upwash": [one.upwash["alpha_vane"] - 1.0 for one in drawn],
        "accelerometer_bias": [off for one in drawn for off in one.offsets.values()],
    }
    for name, values in found.items():
        rms = float(np.sqrt(np.mean(np.square(values))))
        assert rms == pytest.approx(getattr(stated, name), rel=0.33), name
    exact = Accuracy(**draw_dirt(("gusts",), 1, aircraft).accuracy)
    assert not any(exact.model_dump().values())


def test_a_flexible_structure_rings_at_its_frequency() -> None:
    dt, frequency = 0.001, 10.0
    mode = StructuralMode(
        channel="an", frequency=frequency, damping=0.03, participation=0.3, buffet=0.0
    )
    step = np.repeat((GRAVITY, 2.0 * GRAVITY), 1000)
    extra = StructuralVibration(mode, dt, np.random.default_rng(1))(step) - step
    assert np.abs(extra[:1000]).max() < 1e-9, "a steady load bends, but does not shake"
    ringing = extra[1000:]
    assert ringing.max() == pytest.approx(0.3 * GRAVITY, rel=0.05)
    crossings = np.flatnonzero(np.diff(np.sign(ringing[:500])))
    assert np.diff(crossings).mean() * dt == pytest.approx(0.5 / frequency, rel=0.02)
    shaken = StructuralMode(
        channel="an", frequency=frequency, damping=0.03, participation=1e-3, buffet=0.2
    )
    still = np.zeros(60000)
    found = StructuralVibration(shaken, 0.01, np.random.default_rng(2))(still)
    assert found.std() == pytest.approx(0.2, rel=0.15)


@pytest.fixture(scope="module")
def packets() -> list[Packet]:
    settings = FlightSettings(plan="short", seed=1, dirt="all")
    return list(settings.create_downlink(0).advance(1000))


def test_messages_come_in_bursts_and_some_without_a_stamp(packets: list[Packet]) -> None:
    sending = [index for index, one in enumerate(packets) if one.live_frames]
    assert set(np.diff(sending)) == {25}
    box = dialect().MAVLink(None)
    frames = b"".join(frame for one in packets for frame in one.live_frames)
    stamps = np.array(
        [
            message.time_usec
            for message in box.parse_buffer(frames)
            if message.get_type() == "DEBUG_FLOAT_ARRAY"
        ]
    )
    assert 1 <= np.sum(stamps[1:] == 0) <= 15
    steps = np.diff(stamps[stamps > 0])
    assert steps.min() > 0, "the clock of the box never goes back"
    jitter = draw_dirt(("clock",), 1, load_aircraft("b777")).stamp_jitter
    assert np.std(steps[steps < 19_000]) == pytest.approx(np.sqrt(2.0) * 1e6 * jitter, rel=0.15)


def test_a_cut_record_holds_the_maneuvers_with_their_margins() -> None:
    phases = ["pattern"] * 100 + ["maneuver 1"] * 50 + ["pattern"] * 100 + ["maneuver 2"] * 20
    stream = [
        Packet(time=0.01 * k, stamp_us=k, live_frames=(), onboard_frames=(), phase=phase)
        for k, phase in enumerate(phases)
    ]
    dirt = Dirt(lead=0.2, tail=0.295)
    assert [one.stamp_us for one in cut_to_maneuvers(stream, dirt)] == [
        *range(80, 179),
        *range(230, 270),
    ]
    assert len([*cut_to_maneuvers(stream, Dirt())]) == len(stream)


def test_a_dirty_flight_has_its_true_mass_and_its_throttle_moves(aircraft: Aircraft) -> None:
    flight = FlightSettings(plan="short", seed=1, dirt="mass,throttle").create_flight()
    truth = truth_block([flight.advance(5)])
    assert truth["mass"][0] == pytest.approx(aircraft.mass.mass * flight.dirt.mass_factor)
    assert truth["throttle"][0] == 0.0, "moves belong to the pattern, not to the runway"
    first = flight.dirt.throttle[0]
    assert flight.dirt.throttle_offset(first.start - 0.01) == 0.0
    assert flight.dirt.throttle_offset(0.5 * (first.start + first.end)) == first.size


def test_what_was_drawn_can_be_written_as_json(aircraft: Aircraft) -> None:
    drawn = draw_dirt(("all",), 7, aircraft).as_dict()
    assert json.loads(json.dumps(drawn))["lags"] == drawn["lags"]
