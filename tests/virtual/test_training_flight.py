"""Training: keys move the sticks of the virtual aircraft, and the built-in pilot stands behind."""

import io
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.foundation import FlightError
from gsapp.session import Session
from gsapp.telemetry.recorder_control import start_recorder
from gsapp.virtual.airframe import TRUTH_CHANNELS
from gsapp.virtual.downlink.aircraft_process import TrainingProcess, find_free_udp_port
from gsapp.virtual.downlink.commanded_downlinks import (
    StdinConsole,
    TrainingDownlink,
    execute_training_command,
)
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.flight_plan import load_flight_plan
from gsapp.virtual.keyboard_pilot import KeyboardPilot
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import KeyboardSticks, KeyPositions, StickPositions
from gsapp.virtual.virtual_flight import FlightSegment, FlightSimulation

DT = 0.01
PATIENCE = 30.0


class Trainee:
    """A flight begun in the pattern, with someone at the keys."""

    def __init__(self, seed: int = 5000, gusts: float = 0.3) -> None:
        made: list[KeyboardPilot] = []

        def make(plan, feel, random, dt):  # type: ignore[no-untyped-def]
            made.append(KeyboardPilot(plan, feel, random, dt, airborne=True))
            return made[0]

        self.flight = FlightSimulation(
            load_flight_plan("default"),
            aircraft=load_aircraft("b777"),
            seed=seed,
            turbulence=gusts,
            hands=make,
            airborne=True,
        )
        self.pilot = made[0]
        self.flown: list[FlightSegment] = []

    def fly(self, seconds: float, keys: KeyPositions | None = None) -> None:
        for _ in range(round(seconds / 0.05)):
            if keys is not None:
                self.pilot.set_keys(keys)
            self.flown.append(self.flight.advance(5))

    def true(self, name: str) -> np.ndarray:
        rows = np.concatenate([stretch.truth for stretch in self.flown])
        return rows[:, TRUTH_CHANNELS.index(name)]


def test_keys_fly_a_doublet_of_the_chosen_size() -> None:
    trainee = Trainee()
    trainee.fly(0.5)
    before = trainee.true("stick_pitch")[-1]
    assert trainee.pilot.take_over()
    trainee.pilot.set_key_travel(0.5)
    trainee.fly(0.5, KeyPositions())
    trim = trainee.true("stick_pitch")[-1]
    trainee.fly(0.4, KeyPositions(pitch=1.0))
    trainee.fly(0.4, KeyPositions(pitch=-1.0))
    trainee.fly(1.0, KeyPositions())
    sticks = trainee.true("stick_pitch")
    assert trim == pytest.approx(before, abs=0.1)
    assert sticks.max() == pytest.approx(trim + 0.5, abs=0.01)
    assert sticks.min() == pytest.approx(trim - 0.5, abs=0.01)
    assert sticks[-1] == pytest.approx(trim, abs=1e-9)
    full = load_aircraft("b777").controls.de.full_stick_high
    swing = np.ptp(trainee.true("de"))
    assert swing == pytest.approx(abs(full), rel=0.15)


def test_the_built_in_pilot_takes_a_silent_aircraft_home() -> None:
    trainee = Trainee(seed=5001, gusts=0.6)
    trainee.fly(1.0)
    trainee.pilot.take_over()
    trainee.fly(0.6, KeyPositions(roll=1.0))
    held = trainee.true("height")[-1]
    trainee.fly(VIRTUAL.key_timeout + 0.2)
    assert not trainee.pilot.trainee_flies
    assert "no key" in trainee.pilot.take_handback_reason()
    trainee.fly(9.0)
    assert not trainee.flight.crashed
    heights = trainee.true("height")
    assert heights.min() > 0.5 * held
    assert abs(heights[-1] - 79.0) < 20.0
    assert np.degrees(np.abs(trainee.true("phi")[-1])) < 60.0


def test_the_ground_is_not_reached() -> None:
    trainee = Trainee(seed=5002)
    trainee.fly(0.5)
    trainee.pilot.take_over()
    trainee.pilot.set_key_travel(0.4)
    trainee.fly(4.0, KeyPositions(pitch=-1.0))
    assert not trainee.pilot.trainee_flies
    trainee.fly(3.0)
    assert not trainee.flight.crashed
    assert trainee.true("height").min() > 3.0


def test_same_keys_same_flight() -> None:
    ends = []
    for _ in range(2):
        trainee = Trainee(seed=5003, gusts=0.6)
        trainee.fly(0.5)
        trainee.pilot.take_over()
        trainee.fly(1.0, KeyPositions(roll=-1.0, throttle=0.8))
        ends.append(trainee.flown[-1].volts)
    np.testing.assert_array_equal(*ends)


@given(
    pushes=st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 3), min_size=1, max_size=20),
    size=st.floats(0.05, 1.0),
)
def test_sticks_stay_between_their_stops_and_never_jump(
    pushes: list[tuple[float, float, float]], size: float
) -> None:
    sticks = KeyboardSticks(DT)
    sticks.reset(StickPositions(pitch=0.1, throttle=0.5), (0.1, 0.0, 0.0))
    sticks.set_key_travel(size)
    last = sticks.move()
    for pitch, roll, yaw in pushes:
        sticks.set_keys(KeyPositions(pitch=pitch, roll=roll, yaw=yaw, throttle=abs(pitch)))
        for _ in range(5):
            now = sticks.move()
            for axis in ("pitch", "roll", "yaw", "throttle"):
                assert abs(getattr(now, axis)) <= 1.0
                assert abs(getattr(now, axis) - getattr(last, axis)) <= 0.081
            last = now


@pytest.mark.parametrize(
    "line", ["fly", "sticks 1 0", "sticks nan 0 0", "size 2", "click flap 1", "rate middle"]
)
def test_a_line_that_is_not_understood_says_so_and_moves_nothing(line: str) -> None:
    trainee = Trainee()
    with pytest.raises(FlightError):
        execute_training_command(trainee.pilot, line)
    assert not trainee.pilot.trainee_flies


def test_the_end_of_the_lines_ends_the_flight() -> None:
    """Without anybody who could say something, the aircraft does not fly on for minutes."""
    made: list[KeyboardPilot] = []

    def make(plan, feel, random, dt):  # type: ignore[no-untyped-def]
        made.append(KeyboardPilot(plan, feel, random, dt, airborne=True))
        return made[0]

    said: list[str] = []
    downlink = FlightSettings(airborne=True).create_downlink(0, make)
    control = StdinConsole(io.StringIO("take\nsize 0.5\nnonsense\n"), said.append)
    stream = TrainingDownlink(downlink, made[0], control)
    deadline = time.monotonic() + PATIENCE
    while not stream.finished:
        assert time.monotonic() < deadline
        list(stream.advance(4))
    assert said[0] == "you have control"
    assert "50 %" in said[1]
    assert "is unknown" in said[2]


@pytest.mark.long
def test_a_trainee_over_a_real_link_is_in_the_record(tmp_path: Path) -> None:
    """A process, a link, a recorder: within five seconds keys fly a doublet that is recorded."""
    folder = tmp_path / "flight"
    port = find_free_udp_port()
    link = f"udpin:127.0.0.1:{port}"
    prepare_flight_folder(
        folder, aircraft="b777", channel_map="b777", source=link, notes="Training."
    )
    recorder = start_recorder(link, folder)
    aircraft = TrainingProcess(folder, port, seed=5004, turbulence=0.0)
    session = Session.follow(folder)
    try:
        started = time.monotonic()
        _until(session, lambda: session.history.has("elevator_left"))
        assert time.monotonic() - started < 15.0  # 5 s on a machine with nothing else to do
        assert aircraft.take_over()
        assert aircraft.set_stick_size(0.4)
        for pitch, seconds in ((0.0, 0.6), (1.0, 0.4), (-1.0, 0.4), (0.0, 1.0)):
            until = time.monotonic() + seconds
            while time.monotonic() < until:
                assert aircraft.send_sticks(pitch, 0.0, 0.0)
                time.sleep(0.02)
        flown = session.now or 0.0
        _until(session, lambda: (session.now or 0.0) > flown + 0.5)
        assert aircraft.is_running()
        aircraft.hand_over()
    finally:
        aircraft.stop()
        recorder.stop()
    # Twice 40 % of 20 deg.
    assert _swing(session) == pytest.approx(np.radians(16.0), rel=0.2)


def _until(session: Session, true) -> None:  # type: ignore[no-untyped-def]
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < deadline
        session.update()
        time.sleep(0.02)


def _swing(session: Session) -> float:
    flight = session.flight()
    if "elevator_left" not in flight.block:
        return 0.0
    return float(np.ptp(flight.block["elevator_left"][np.isfinite(flight.block["elevator_left"])]))
