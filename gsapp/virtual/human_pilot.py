"""The pilot: sees, wants, moves the sticks in closed loops by eye, with gains by feel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gsapp.quantities.constants import DEGREE
from gsapp.virtual.flight_plan import ControlSurface, FlightPlan, PlannedManeuver
from gsapp.virtual.mission import GuidanceCommand, Mission
from gsapp.virtual.pilot_perception import AircraftState, PilotPerception, PilotView, RunwayFrame
from gsapp.virtual.sticks import StickMotionModel, StickPositions


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftHandling:
    """What a pilot has learned of an aircraft in earlier flights, at one airspeed."""

    speed: float  # Airspeed of the numbers below, m/s.
    pitch_rate: float
    roll_rate: float
    """Steady rate for full stick at the high rate, rad/s."""
    low_rate: tuple[float, float, float]
    """Deflection at the low rate as a share of the high one: pitch, roll, yaw."""
    pitch: float  # Attitude in level flight, rad.
    trim: float  # Pitch stick in level flight.
    throttle: float
    throttle_slope: float
    """In level flight; and its change for each m/s more."""
    turn_pull: float  # Pitch stick for each unit of (1/cos(bank) - 1).
    turn_roll: float
    """Roll stick for each unit of sin(bank), against the bank's steepening by itself."""
    turn_yaw: float  # Yaw stick for each unit of sin(bank), for a turn without sideslip.
    flap_travel: float  # Full travel of the flaps, rad.


class PitchController:
    """Keeps the flight path through the attitude, and the attitude through the stick.

    `trim_error` is the stick by which the trim lever is off at the start; `dt` the time between two
    calls, s.
    """

    def __init__(self, feel: AircraftHandling, trim_error: float, dt: float) -> None:
        self._feel = feel
        self._dt = dt
        # 0.9 rad/s: what a delay of half a second, eye to surface, lets a human close calmly.
        self._gain = 0.9 / feel.pitch_rate
        self._hold = feel.trim + trim_error
        self._offset = 0.0
        self._wanted = 0.0
        self._lift = 0.0
        self.mean_stick = self._hold
        """Where the stick was held on average over the last half second."""

    @property
    def trim_stick(self) -> float:
        return self._hold

    def _hang(self, view: PilotView) -> float:
        ratio = self._feel.speed / max(view.speed, 0.7 * self._feel.speed)
        return self._feel.pitch * ratio**2 / math.cos(min(abs(view.bank), 50.0 * DEGREE))

    def stick(self, view: PilotView, intent: GuidanceCommand) -> float:
        if intent.path_angle is not None:
            error = intent.path_angle - view.path
            if not view.on_ground:
                if abs(view.bank) < 20.0 * DEGREE:
                    self._offset += 0.06 * error * self._dt
                self._offset = min(max(self._offset, -3.0 * DEGREE), 3.0 * DEGREE)
            target = self._hang(view) + self._offset + intent.path_angle + intent.path_gain * error
        elif intent.pitch is not None:
            target = intent.pitch
        else:
            return self.mean_stick
        target = min(max(target, -14.0 * DEGREE), 20.0 * DEGREE)
        step = 14.0 * DEGREE * self._dt
        self._wanted += min(max(target - self._wanted, -step), step)
        miss = self._wanted - view.pitch
        # What a turn asks for is not taken along into the straight leg.
        if not view.on_ground and abs(view.bank) < 20.0 * DEGREE:
            self._hold += 0.3 * self._gain * miss * self._dt
            self._hold = min(max(self._hold, -0.5), 0.5)
        # On the wheels the nose comes up late, and then at once: pull until it moves.
        if view.on_ground and miss > 3.0 * DEGREE and view.pitch_rate < 3.0 * DEGREE:
            self._lift = min(self._lift + 0.4 * self._dt, 0.7)
        else:
            self._lift *= 1.0 - self._dt / 0.2
        bank = min(abs(view.bank), 60.0 * DEGREE)
        pull = self._feel.turn_pull * (1.0 / math.cos(bank) - 1.0)
        # Slower air, weaker surfaces: the hand asks for more without thinking about it.
        firmness = min((self._feel.speed / max(view.speed, 0.6 * self._feel.speed)) ** 2, 2.5)
        damping = 0.15 * self._gain * view.pitch_rate
        stick = self._hold + self._lift + firmness * self._gain * miss - damping + pull
        self.mean_stick += self._dt / 0.5 * (stick - self.mean_stick)
        return stick


class RollController:
    """Keeps the bank through the stick, and feeds the rudder that a turn needs."""

    def __init__(
        self, feel: AircraftHandling, coordination: float, trim_error: float, dt: float
    ) -> None:
        self._feel = feel
        self._coordination = coordination
        self._dt = dt
        self._gain = 1.2 / feel.roll_rate
        self._hold = trim_error
        self._wanted = 0.0

    def sticks(self, view: PilotView, intent: GuidanceCommand) -> tuple[float, float]:
        """Return the roll and yaw sticks, towards the pattern positive."""
        step = 45.0 * DEGREE * self._dt
        self._wanted += min(max(intent.bank - self._wanted, -step), step)
        miss = self._wanted - view.bank
        calm = abs(view.bank) < 10.0 * DEGREE and abs(view.roll_rate) < 5.0 * DEGREE
        if calm and abs(self._wanted) < 8.0 * DEGREE and not view.on_ground:
            self._hold += 0.05 * self._gain * miss * self._dt
            self._hold = min(max(self._hold, -0.1), 0.1)
        firmness = min(self._feel.speed / max(view.speed, 0.6 * self._feel.speed), 1.7)
        roll = self._hold + firmness * self._gain * miss
        roll += self._feel.turn_roll * math.sin(view.bank)
        yaw = self._coordination * self._feel.turn_yaw * math.sin(view.bank)
        return roll, yaw

    @property
    def trim_stick(self) -> float:
        return self._hold


class SpeedController:
    """Keeps the airspeed that the pilot believes to see through the throttle."""

    def __init__(self, feel: AircraftHandling, dt: float) -> None:
        self._feel = feel
        self._dt = dt
        self._hold = 0.0
        self._lever = 0.0
        self._before: float | None = None  # A step of the lever.
        self._moving = False

    def throttle(self, view: PilotView, intent: GuidanceCommand) -> float:
        target = self._lever
        if intent.throttle_step:
            self._before = self._lever if self._before is None else self._before
            target = self._before + intent.throttle_step
        else:
            self._before = None
        if intent.throttle is not None:
            target = intent.throttle
        elif intent.speed is not None:
            feel = self._feel
            error = intent.speed - view.speed
            self._hold = min(max(self._hold + 0.004 * error * self._dt, -0.15), 0.15)
            level = feel.throttle + feel.throttle_slope * (intent.speed - feel.speed)
            # Thrust over weight is climb over speed: less of it going down, more going up.
            slope = 0.0 if intent.path_angle is None else 1.8 * intent.path_angle
            turn = 0.12 * (1.0 / math.cos(min(abs(view.bank), 60.0 * DEGREE)) - 1.0)
            target = level + self._hold + 0.035 * error + slope + turn
        miss = min(max(target, 0.0), 1.0) - self._lever
        # A thumb moves the lever now and then, not all the time.
        if abs(miss) > (0.0 if intent.throttle is not None else 0.05):
            self._moving = True
        step = 0.7 * self._dt
        if self._moving:
            self._lever += min(max(miss, -step), step)
            self._moving = abs(miss) > step
        return self._lever


_CENTERED: Mapping[ControlSurface, float] = {"de": 0.0, "da": 0.0, "dr": 0.0}


class HumanPilot:
    """Flies a plan by eye; the `StickSource` of a virtual flight.

    Parameters
    ----------
    feel : AircraftHandling
        What the pilot knows of the aircraft.
    random : numpy.random.Generator
        Everything in which one day differs from the next.
    dt : float
        Time between two moves, s.
    mission : Mission, optional
        What is flown when; the plan from beginning to end by default.
    """

    def __init__(
        self,
        plan: FlightPlan,
        feel: AircraftHandling,
        random: np.random.Generator,
        *,
        dt: float,
        mission: Mission | None = None,
    ) -> None:
        human = plan.human
        eyes, hands, inputs, habits = random.spawn(4)
        self._runway = RunwayFrame(plan.conditions, plan.pattern.side)
        self._eyes = PilotPerception(plan, self._runway, eyes, dt)
        self._mission = Mission(plan, inputs) if mission is None else mission
        self._stages = self._mission.stages()
        self._intent = next(self._stages)
        self._feel = feel
        self._flap_travel = max(feel.flap_travel, 1e-9)
        trim_errors = human.trim_error * habits.standard_normal(3)
        coordination = human.coordination * (1.0 + 0.2 * float(habits.standard_normal()))
        self._pitch = PitchController(feel, float(trim_errors[0]), dt)
        self._roll = RollController(feel, coordination, float(trim_errors[1]), dt)
        self._speed = SpeedController(feel, dt)
        self._yaw_trim = float(trim_errors[2])
        self._hands = {
            name: StickMotionModel(human, hands, dt) for name in ("pitch", "roll", "yaw")
        }
        self._finished = False
        self._released: tuple[float, float, float] | None = None

    @property
    def phase(self) -> str:
        return self._intent.phase

    @property
    def finished(self) -> bool:
        return self._finished

    @property
    def flown_maneuvers(self) -> list[tuple[float, float, PlannedManeuver]]:
        """Return start, end (s) and intention of the maneuvers so far."""
        return self._mission.flown_maneuvers

    @property
    def trim_sticks(self) -> tuple[float, float, float]:
        """Return the sticks that hold level flight: pitch, roll and yaw."""
        return (
            self._pitch.trim_stick,
            self._runway.sign * self._roll.trim_stick,
            (self._runway.sign * self._yaw_trim),
        )

    def move(self, situation: AircraftState) -> StickPositions:
        view = self._eyes.perceive(situation)
        try:
            self._intent = self._stages.send(view)
        except StopIteration:
            self._finished = True
        intent = self._intent
        pitch, roll, yaw = self._wanted(view, intent)
        inputs = _CENTERED
        if intent.stick_input is not None:
            inputs = intent.stick_input.at(intent.stick_time)
        high_rate = intent.stick_input is None or intent.stick_input.high_rate
        scale = (1.0, 1.0, 1.0) if high_rate else self._feel.low_rate
        sign = self._runway.sign
        wanted = zip((pitch, sign * roll, sign * yaw), scale, _CENTERED, strict=True)
        sticks = {
            name: hand.move(stick / share + inputs[surface], resting=intent.hands_off)
            for (name, hand), (stick, share, surface) in zip(
                self._hands.items(), wanted, strict=True
            )
        }
        return StickPositions(
            **sticks,
            throttle=self._speed.throttle(view, intent),
            flap=intent.flap / self._flap_travel,
            high_rate=high_rate,
            brake=intent.brake,
            engines=intent.engines,
        )

    def _wanted(self, view: PilotView, intent: GuidanceCommand) -> tuple[float, float, float]:
        """Return the sticks wanted without any input: pitch, and roll and yaw to the pattern."""
        if intent.hands_off:
            if self._released is None:
                # Let go where the stick is held on average, not where it happens to be.
                self._released = (self._pitch.mean_stick, self._roll.trim_stick, self._yaw_trim)
            return self._released
        self._released = None
        if intent.brake >= 1.0:
            return self._feel.trim, 0.0, 0.0
        pitch = self._pitch.stick(view, intent)
        roll, yaw = self._roll.sticks(view, intent)
        if intent.steer is not None and view.on_ground:
            miss = math.remainder(intent.steer - view.course, 2.0 * math.pi)
            return pitch, 0.3 * roll, min(max(0.6 * miss, -0.3), 0.3)
        return pitch, roll, yaw + self._yaw_trim
