"""Single inputs flown by a virtual aircraft: a straight leg, trim or not, an input, hands off.

One of them is 15 to 30 seconds of flight and takes a third of a second to fly, where a whole
flight takes minutes. The aircraft is already in the air near a test point, with an error of bank,
speed and path that a scripted pilot corrects. Then come the input, as a human makes it, the time
in which the sticks are left alone, or not, and the recovery. What the pilot meant is in
`InputPlan`; what really happened is in `FlownInput.truth`.

::

    flown = fly_input(7)                                # everything drawn from the seed
    flown = fly_input(7, surfaces=("de",), turbulence=0.0)
    rows = rows_of(flown.measured, 100.0)
"""

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from calibration.certificate_toml import load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.trim import trim
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from gsapp.virtual.airframe import (
    INSTRUMENT_INPUT_CHANNELS,
    ONBOARD_CHANNELS,
    TRUTH_CHANNELS,
    Airframe,
)
from gsapp.virtual.flight_plan import INPUT_SHAPES, FlightPlan, PilotLimits
from gsapp.virtual.human_pilot import AircraftHandling
from gsapp.virtual.instruments import AnalogDigitalConverter, Instruments
from gsapp.virtual.sticks import StickMotionModel, StickPositions
from gsapp.virtual.virtual_flight import combine_surfaces, compute_handling
from tests.virtual.input_plan import SURFACES, InputPlan, around_one, draw

RATE = 100.0
HEIGHT = 80.0
_DT = 1.0 / RATE
_PAUSE = 12.0
"""Between what was recorded on the ground and the flight, s."""
_RECOVERY = 3.0
_COMES_TO_REST = 0.25
"""Time constant with which corrections end, s."""
_ERRING = (-1.9, -1.3, -0.1, 0.7)
"""Seconds from the beginning of an input at which a wrong rate is flown: grows, stands, fades."""
_UPSET = 50.0 * DEGREE
"""Bank or nose angle at which a pilot takes over whatever was agreed on."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlownInput:
    """An input as it was flown."""

    plan: InputPlan
    aircraft: Aircraft  # With the noise of the day.
    truth: Block  # `gsapp.virtual.airframe.TRUTH_CHANNELS`, at the CG, 100 Hz.
    measured: Block
    """What the ground makes of the converter's volts, with combined surfaces; attitude and position
    where the aircraft has them."""
    ground: Block | None  # Measured before the flight.
    t_input: float  # When the first stick begins to move, s.
    t_let_go: float  # When the last stick is let go, s.
    t_hand: float  # When the pilot's hands are on the sticks again, s.
    calm: Block
    """The truth from `t_input` to `t_hand` if the gusts had stayed what they were at `t_input`:
    same state then, same sticks since."""


def fly_input(seed: int, **draws: object) -> FlownInput:
    surfaces = draws.get("surfaces", ())
    assert isinstance(surfaces, tuple)
    plan = replace(draw(seed, surfaces), **draws)
    return InputFlight(plan, np.random.default_rng((seed, 7))).fly()


def noisy(aircraft: Aircraft, factor: float) -> Aircraft:
    sensors = aircraft.sensors
    keys = {
        "alpha_vane": ("noise",),
        "beta_vane": ("noise",),
        "accelerometer": ("noise",),
        "gyro": ("noise", "vibration"),
        "air_data": ("noise", "static_noise"),
        "surfaces": ("noise",),
    }
    changed = {}
    for name, fields in keys.items():
        one = getattr(sensors, name)
        changed[name] = one.model_copy(update={key: factor * getattr(one, key) for key in fields})
    return aircraft.model_copy(update={"sensors": sensors.model_copy(update=changed)})


@lru_cache(maxsize=1)
def _base() -> tuple[Aircraft, FlightModel]:
    aircraft = load_aircraft("b777")
    return aircraft, FlightModel(aircraft, load_model("b777"))


@lru_cache(maxsize=1)
def _converter() -> AnalogDigitalConverter:
    return AnalogDigitalConverter(load_certificates("b777"))


@lru_cache(maxsize=16)
def _feel(speed: float, density: float) -> AircraftHandling:
    return compute_handling(_base()[1], speed, density)


class InputFlight:
    """One flight of one plan.

    Attributes
    ----------
    plan : InputPlan
        What the pilot means to do; may be another until the flight begins.
    aircraft : Aircraft
        With the noise of the day.
    """

    def __init__(self, plan: InputPlan, random: np.random.Generator) -> None:
        self.plan = plan
        self._random = random
        self.aircraft = noisy(_base()[0], plan.noise)
        pilot, air, instruments, place = random.spawn(4)
        self._frame = Airframe(
            FlightPlan(),
            self.aircraft,
            _base()[1].model,
            turbulence=plan.turbulence,
            random=air,
            dt=_DT,
        )
        self._instruments = Instruments(self.aircraft, instruments, _DT)
        self._place = place
        self._feel = _feel(plan.speed, self._frame.density(HEIGHT))
        human = PilotLimits()
        self._hands = [StickMotionModel(human, pilot, _DT) for _ in range(3)]
        controls = self.aircraft.controls
        self._full = {
            "de": controls.de.full_stick_high,
            "da": controls.da.full_stick_high,
            "dr": controls.dr.full_stick_high,
        }
        self._edges = {name: _edges(plan, place, pilot) for place, name in enumerate(plan.surfaces)}
        self._usual = [self._feel.trim, 0.0, 0.0]
        self._rest = list(self._usual)
        self._lever = 0.0
        self._tables: tuple[list[tuple[float, ...]], ...] = ([], [], [])

    # --- the sticks -----------------------------------------------------------------------------

    def _corrected(self, bank: float, speed: float) -> list[float]:
        """Return the sticks of a pilot who flies level at a bank and a speed."""
        now, feel = self._frame.aircraft_state(), self._feel
        path = math.asin(max(-1.0, min(1.0, now.climb_rate / max(now.airspeed, 1.0))))
        ratio = (feel.speed / max(now.airspeed, 0.7 * feel.speed)) ** 2
        nose = feel.pitch * ratio / math.cos(min(abs(now.phi), 0.9)) - 0.6 * path
        nose += 0.002 * (HEIGHT - now.height)
        pitch = feel.trim + 0.9 / feel.pitch_rate * (nose - now.theta)
        pitch += feel.turn_pull * (1.0 / math.cos(min(abs(now.phi), 0.9)) - 1.0)
        pitch -= 0.15 / feel.pitch_rate * now.q
        roll = 1.4 / feel.roll_rate * (bank - now.phi) - 0.15 / feel.roll_rate * now.p
        yaw = 0.8 * feel.turn_yaw * math.sin(now.phi)
        level = feel.throttle + feel.throttle_slope * (speed - feel.speed)
        self._lever += 0.05 * (
            min(max(level + 0.05 * (speed - now.airspeed), 0.0), 1.0) - self._lever
        )
        return [pitch, roll, yaw]

    def beside(self, time: float) -> tuple[float, float, float]:  # noqa: ARG002
        return 0.0, 0.0, 0.0

    def _input(self, time: float) -> list[float]:
        added = []
        for name in SURFACES:
            value = _at(self._edges[name], time) if name in self._edges else 0.0
            for one in self.plan.meddling:
                if one.surface == name and one.at <= time < one.at + one.length:
                    value += one.size
            added.append(value / self._full[name])
        return added

    # --- the flight -----------------------------------------------------------------------------

    def fly(self) -> FlownInput:
        """Fly it all."""
        plan = self.plan
        ground = self._stand() if plan.ground > 0.0 else None
        offset = plan.ground + _PAUSE if plan.ground > 0.0 else 0.0
        self._take_off()
        begin = plan.approach + plan.still
        let_go = begin + max(edges[0][-1] for edges in self._edges.values())
        hand = let_go + plan.hands_off
        flown: list[StickPositions] = []
        clone: Airframe | None = None
        while len(flown) < round((hand + _RECOVERY) * RATE):
            time = len(flown) * _DT
            if let_go < time < hand and self._upset():
                hand = time
            if len(flown) == round(begin * RATE) and plan.turbulence > 0.0:
                clone = self._becalmed()
            sticks = self._sticks(time, begin, hand)
            self._note()
            self._frame.advance(sticks)
            flown.append(sticks)
        times = offset + np.arange(len(flown)) * _DT
        truth = Block(channels=TRUTH_CHANNELS, times=times, values=np.array(self._tables[0]))
        low, high = round(begin * RATE), round(hand * RATE)
        return FlownInput(
            plan=plan,
            aircraft=self.aircraft,
            truth=truth,
            measured=self._measured(times),
            ground=ground,
            t_input=offset + begin,
            t_let_go=offset + let_go,
            t_hand=offset + hand,
            calm=_calm(clone, flown[low:high], truth, low),
        )

    def _sticks(self, time: float, begin: float, hand: float) -> StickPositions:
        """Return the sticks: corrected, held with the errors meant, moved, or let go."""
        plan, feel = self.plan, self._feel
        corrects = time < plan.approach or time >= hand
        if corrects:
            off = time >= hand
            lean, fast, nose = self.beside(time)
            wanted = self._corrected(
                (0.0 if off else plan.bank) + lean,
                plan.speed + (0.0 if off else plan.speed_off) + fast,
            )
            wanted[0] += nose
            self._usual = [
                usual + _DT / 0.5 * (want - usual)
                for usual, want in zip(self._usual, wanted, strict=True)
            ]
            self._rest = list(wanted)
        else:
            # The hand comes to rest, it does not jump.
            self._rest = [
                rest + _DT / _COMES_TO_REST * (usual - rest)
                for rest, usual in zip(self._rest, self._usual, strict=True)
            ]
            wanted = list(self._rest)
            erring = _swell(time - begin)
            wanted[0] += erring * plan.pitch_rate / feel.pitch_rate
            wanted[1] += erring * plan.roll_rate / feel.roll_rate
            if time >= begin:
                added = self._input(time - begin)
                wanted = [want + add for want, add in zip(wanted, added, strict=True)]
        pitch, roll, yaw = (
            one.move(want, resting=not corrects)
            for one, want in zip(self._hands, wanted, strict=True)
        )
        return StickPositions(pitch=pitch, roll=roll, yaw=yaw, throttle=self._lever, engines=True)

    def _upset(self) -> bool:
        now = self._frame.aircraft_state()
        return max(abs(now.phi), abs(now.theta)) > _UPSET

    def _take_off(self) -> None:
        """Put the aircraft into the air, near the test point."""
        plan = self.plan
        bank, path, fast, p, q, r = plan.start
        speed = plan.speed + plan.speed_off + fast
        level = trim(_base()[1], V=speed, rho=self._frame.density(HEIGHT))
        now = level.controls
        self._lever = now["throttle"]
        simulator = self._frame.simulator
        self._frame.advance(StickPositions(engines=True))
        commands = replace(
            simulator.commands,
            de=now["de"],
            da=now["da"],
            dr=now["dr"],
            throttle=now["throttle"],
            engines=True,
            brake=0.0,
        )
        simulator.start_in_air(
            V=speed,
            alpha=level.polar.alpha,
            rates=(p, q, r),
            attitude=(bank, level.polar.theta + path, 0.0),
            height=HEIGHT,
            commands=commands,
        )
        self._hands_start(now)
        self._frame.advance(
            StickPositions(pitch=now["de"] / self._full["de"], throttle=self._lever, engines=True)
        )

    def _hands_start(self, now: Mapping[str, float]) -> None:
        for hand, name in zip(self._hands, SURFACES, strict=True):
            for _ in range(60):
                hand.move(now[name] / self._full[name])

    def _stand(self) -> Block:
        for step in range(round((self.plan.ground + 1.0) * RATE)):
            if step >= RATE:
                self._note()
            self._frame.advance(StickPositions(throttle=0.15, brake=1.0, engines=True))
        times = np.arange(len(self._tables[0])) * _DT
        block = self._measured(times)
        self._tables = ([], [], [])
        return block

    def _note(self) -> None:
        for table, row in zip(
            self._tables,
            (self._frame.truth(), self._frame.instrument_inputs(), self._frame.onboard_values()),
            strict=True,
        ):
            table.append(row)

    def _becalmed(self) -> Airframe:
        simulator = self._frame.simulator
        kept = (simulator.model, simulator.aircraft, simulator.atmosphere, self.aircraft)
        memo = {id(one): one for one in kept}
        other = copy.deepcopy(self._frame, memo)
        other.simulator.turbulence = _Steady(simulator.turbulence.gust)  # type: ignore[assignment]
        return other

    def _measured(self, times: np.ndarray) -> Block:
        """Return what the ground makes of what was noted."""
        columns = np.array(self._tables[1]).T
        exposed = dict(zip(INSTRUMENT_INPUT_CHANNELS, columns, strict=True))
        speeds = np.column_stack([exposed["rpm_left"], exposed["rpm_right"]])
        converter = _converter()
        volts = converter.volts(self._instruments.read(exposed, speeds))
        block = combine_surfaces(converter.convert_to_block(times, volts))
        names, values = list(block.channels), [block.values]
        board = dict(zip(ONBOARD_CHANNELS, np.array(self._tables[2]).T, strict=True))
        truth = dict(zip(TRUTH_CHANNELS, np.array(self._tables[0]).T, strict=True))
        noise = self._place.standard_normal((times.size, 6))
        if self.plan.attitude:
            names += ["phi", "theta", "psi"]
            values.append(
                np.column_stack([board[name] for name in ("phi", "theta", "psi")])
                + 0.3 * DEGREE * noise[:, :3]
            )
        if self.plan.position:
            names += ["north", "east", "height"]
            drift = self._place.standard_normal(3)
            values.append(
                np.column_stack([truth[name] for name in ("north", "east", "height")])
                + drift
                + 0.1 * noise[:, 3:]
            )
        return Block(channels=tuple(names), times=times, values=np.column_stack(values))


class _Steady:
    rotation = (0.0, 0.0, 0.0)

    def __init__(self, gust: tuple[float, float, float]) -> None:
        self.gust = gust

    def advance(self, dt: float, V: float) -> tuple[float, float, float]:  # noqa: ARG002
        return self.gust


def _calm(clone: Airframe | None, sticks: list[StickPositions], truth: Block, low: int) -> Block:
    times = truth.times[low : low + len(sticks)]
    if clone is None:
        values = np.array(truth.values[low : low + len(sticks)])
        return Block(channels=TRUTH_CHANNELS, times=times, values=values)
    rows = []
    for one in sticks:
        rows.append(clone.truth())
        clone.advance(one)
    return Block(channels=TRUTH_CHANNELS, times=times, values=np.array(rows))


def _swell(time: float) -> float:
    grows, stands, fades, ends = _ERRING
    share = min((time - grows) / (stands - grows), (ends - time) / (ends - fades))
    return 0.5 - 0.5 * math.cos(math.pi * min(max(share, 0.0), 1.0))


Edges = tuple[tuple[float, ...], tuple[float, ...]]


def _edges(plan: InputPlan, place: int, random: np.random.Generator) -> Edges:
    size = plan.amplitudes[plan.surfaces[place]]
    time = place * plan.stagger
    units = INPUT_SHAPES[plan.kind]
    times, values = [time], []
    for index, unit in enumerate(units):
        values.append(size * unit * around_one(0.05, random))
        share = plan.balance if index < len(units) / 2 else 1.0 / plan.balance
        time += plan.width * math.sqrt(share) * around_one(0.04, random)
        times.append(time)
    values.append(plan.left_over * size * units[-1])
    assert all(b > a for a, b in pairwise(times))
    return tuple(times), tuple(values)


def _at(edges: Edges, time: float) -> float:
    times, values = edges
    index = sum(time >= start for start in times) - 1
    return values[index] if index >= 0 else 0.0
