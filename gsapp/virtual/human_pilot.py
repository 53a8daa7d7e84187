"""The pilot: sees, wants, moves the sticks."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from gsapp.virtual.flight_plan import ControlSurface, FlightPlan, PlannedManeuver
from gsapp.virtual.mission import GuidanceCommand, Mission
from gsapp.virtual.pilot_controllers import (
    AircraftHandling,
    PitchController,
    RollController,
    SpeedController,
)
from gsapp.virtual.pilot_perception import (
    AircraftState,
    PilotPerception,
    PilotView,
    RunwayFrame,
)
from gsapp.virtual.stick_motion import StickMotionModel, StickPositions

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
        return StickPositions(
            pitch=self._hands["pitch"].move(
                pitch / scale[0] + inputs["de"], resting=intent.hands_off
            ),
            roll=self._hands["roll"].move(
                sign * roll / scale[1] + inputs["da"], resting=intent.hands_off
            ),
            yaw=self._hands["yaw"].move(
                sign * yaw / scale[2] + inputs["dr"], resting=intent.hands_off
            ),
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
