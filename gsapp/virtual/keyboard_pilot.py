"""A flight to train on: keys move the sticks, and the built-in pilot is there when they do not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gsapp.virtual.flight_plan import FlightPlan
from gsapp.virtual.human_pilot import AircraftHandling, HumanPilot
from gsapp.virtual.mission import (
    RECOVERY_PHASE,
    TRAINEE_PHASE,
    GuidanceCommand,
    Leg,
    Mission,
    MissionStage,
)
from gsapp.virtual.pilot_perception import AircraftState, PilotView
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import KeyboardSticks, KeyPositions, StickPositions, step_toward


class TrainingMission(Mission):
    """The pattern, again and again, until the trainee has had enough.

    The maneuvers of the plan are the trainee's to fly. `airborne` begins on the upwind leg.
    """

    def __init__(self, plan: FlightPlan, random: np.random.Generator, *, airborne: bool) -> None:
        super().__init__(plan, random)
        self._airborne = airborne
        self._in_pattern = False
        self.trainee_flies = False
        self.landing_requested = False

    @property
    def can_hand_over(self) -> bool:
        """Return whether the trainee may take over: in the pattern, not at the ground."""
        return self._in_pattern

    def stages(self) -> MissionStage:
        own = self._from_the_start()
        view = yield next(own)
        while True:
            if self.trainee_flies:
                own.close()
                while self.trainee_flies:
                    view = yield GuidanceCommand(phase=TRAINEE_PHASE, hands_off=True)
                own = self._home()
                view = yield next(own)
                continue
            try:
                intent = own.send(view)
            except StopIteration:
                return
            view = yield intent

    def _from_the_start(self) -> MissionStage:
        if not self._airborne:
            yield from self._engines()
            yield from self._takeoff()
            self._in_pattern = True
            yield from self._turn(self._downwind)
            yield from self._round(self._downwind)
        else:
            self._in_pattern = True
            yield from self._round(self._upwind)

    def _round(self, leg: Leg) -> MissionStage:
        """Fly the pattern from a leg on, until the landing."""
        while not (self.landing_requested and leg is self._downwind):
            yield from self._straight(leg)
            leg = self._upwind if leg is self._downwind else self._downwind
            yield from self._turn(leg)
        self._in_pattern = False
        yield from self._approach()
        yield from self._rollout()

    def _home(self) -> MissionStage:
        """Level the wings, climb or sink to the pattern's height, and join the pattern."""
        view = yield GuidanceCommand(phase=RECOVERY_PHASE, speed=self._plan.pattern.speed)
        while abs(view.bank) > VIRTUAL.steady_bank or abs(view.climb) > VIRTUAL.steady_climb:
            upset = abs(view.bank) > VIRTUAL.upset_bank
            view = yield GuidanceCommand(
                phase=RECOVERY_PHASE,
                path_angle=None if upset else self._level(view),
                speed=self._plan.pattern.speed,
            )
            if (
                abs(view.bank) < VIRTUAL.steady_bank
                and abs(self._plan.pattern.height - view.height) > 15
            ):
                break  # it climbs or sinks because it should
        # The leg that leads back over the field.
        leg = self._downwind if view.along > 0.0 else self._upwind
        while (
            abs(leg.across - view.across) > VIRTUAL.on_line_distance
            or abs(leg.course_error(view)) > 0.3
        ):
            view = yield GuidanceCommand(
                phase="pattern",
                path_angle=self._level(view),
                bank=_joining_bank(leg, view),
                speed=self._plan.pattern.speed,
            )
        yield from self._round(leg)


def _joining_bank(leg: Leg, view: PilotView) -> float:
    """Return the bank that leads onto a leg's line in its direction, from anywhere, rad."""
    aside = (leg.across - view.across) * math.cos(leg.course)
    intercept = math.atan(aside / VIRTUAL.intercept_range)
    intercept = min(max(intercept, -VIRTUAL.max_intercept), VIRTUAL.max_intercept)
    turn = math.remainder(leg.course_error(view) + intercept, 2.0 * math.pi)
    wanted = 1.1 * (turn - 0.35 * view.bank)
    return min(max(wanted, -VIRTUAL.max_joining_bank), VIRTUAL.max_joining_bank)


class KeyboardPilot:
    """The `StickSource` of a training flight.

    The maneuvers of the plan are left to the trainee. `feel` is what the built-in pilot knows of
    the aircraft, `dt` the time between two moves, s; `airborne` flights begin in the pattern.
    """

    def __init__(
        self,
        plan: FlightPlan,
        feel: AircraftHandling,
        random: np.random.Generator,
        dt: float,
        *,
        airborne: bool = False,
    ) -> None:
        self._dt = dt
        self._mission = TrainingMission(plan, random.spawn(1)[0], airborne=airborne)
        self._pilot = HumanPilot(plan, feel, random, dt=dt, mission=self._mission)
        self._keyed = KeyboardSticks(dt)
        self._sticks = StickPositions()
        self._silence = 0.0
        self._blending = False
        self._said = ""

    @property
    def phase(self) -> str:
        return self._pilot.phase

    @property
    def finished(self) -> bool:
        return self._pilot.finished

    @property
    def trainee_flies(self) -> bool:
        return self._mission.trainee_flies

    # What the trainee says ---------------------------------------------------------------

    def take_over(self) -> bool:
        """Give the aircraft to the trainee; return whether that can be now."""
        if not self._mission.can_hand_over:
            return False
        self._silence = 0.0
        if not self._mission.trainee_flies:
            self._mission.trainee_flies = True
            self._mission.landing_requested = False
            self._keyed.reset(self._sticks, self._pilot.trim_sticks)
        return True

    def hand_back(self, why: str = "") -> None:
        """Give the aircraft back to the built-in pilot, who says why if there is a reason."""
        if self._mission.trainee_flies:
            self._mission.trainee_flies = False
            self._blending = True
            self._said = why

    def land(self) -> None:
        self.hand_back()
        self._mission.landing_requested = True

    def set_keys(self, keys: KeyPositions) -> None:
        self._silence = 0.0
        self._keyed.set_keys(keys)

    def step_lever(self, axis: str, by: float) -> None:
        self._silence = 0.0
        self._keyed.step_lever(axis, by)

    def set_key_travel(self, share: float) -> None:
        self._silence = 0.0
        self._keyed.set_key_travel(share)

    def set_rate_switch(self, *, high: bool) -> None:
        self._silence = 0.0
        self._keyed.high_rate = high

    def take_handback_reason(self) -> str:
        """Return, once, why the built-in pilot took the aircraft by itself; empty for nothing."""
        said, self._said = self._said, ""
        return said

    # What becomes of it ------------------------------------------------------------------

    def move(self, situation: AircraftState) -> StickPositions:
        if self._mission.trainee_flies:
            self._silence += self._dt
            if self._silence > VIRTUAL.key_timeout:
                self.hand_back(f"no key for {VIRTUAL.key_timeout:g} s")
            elif situation.height + VIRTUAL.look_ahead * situation.climb_rate < VIRTUAL.min_height:
                self.hand_back("too low")
        own = self._pilot.move(situation)
        if self._mission.trainee_flies:
            self._sticks = self._keyed.move()
        else:
            self._sticks = self._blended(own) if self._blending else own
        return self._sticks

    def _blended(self, own: StickPositions) -> StickPositions:
        """Return the sticks on their way from the trainee's positions to the pilot's own."""
        step, held = VIRTUAL.handover_rate * self._dt, self._sticks
        moved: dict[str, Any] = {
            name: step_toward(getattr(held, name), getattr(own, name), step)
            for name in ("pitch", "roll", "yaw", "throttle")
        }
        self._blending = any(value != getattr(own, name) for name, value in moved.items())
        return replace(own, **moved)
