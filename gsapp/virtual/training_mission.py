"""A training flight: the built-in pilot flies the pattern whenever the trainee does not."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from gsapp.quantities.constants import DEGREE
from gsapp.virtual.flight_plan import FlightPlan
from gsapp.virtual.handover_phases import RECOVERY_PHASE, TRAINEE_PHASE
from gsapp.virtual.mission import GuidanceCommand, Leg, Mission, MissionStage
from gsapp.virtual.pilot_perception import PilotView

_UPSET: Final = 55.0 * DEGREE
"""Beyond this bank the wings come first, and the pitch stick stays."""
_STEADY_BANK: Final = 15.0 * DEGREE
_STEADY_CLIMB: Final = 3.0
"""m/s."""
_STEEPEST_INTERCEPT: Final = 75.0 * DEGREE
_INTERCEPT_RANGE: Final = 60.0
"""From so far beside a leg's line, m, it is flown to at 45 deg."""
_ON_LINE: Final = 20.0
"""m."""
_JOINING_BANK: Final = 35.0 * DEGREE


class TrainingMission(Mission):
    """The pattern, again and again, until the trainee has had enough.

    Parameters
    ----------
    plan : FlightPlan
        Field, pattern and landing; its maneuvers are the trainee's to fly.
    airborne : bool
        Begin on the upwind leg of the pattern.
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
        while abs(view.bank) > _STEADY_BANK or abs(view.climb) > _STEADY_CLIMB:
            upset = abs(view.bank) > _UPSET
            view = yield GuidanceCommand(
                phase=RECOVERY_PHASE,
                path_angle=None if upset else self._level(view),
                speed=self._plan.pattern.speed,
            )
            if abs(view.bank) < _STEADY_BANK and abs(self._plan.pattern.height - view.height) > 15:
                break  # it climbs or sinks because it should
        # The leg that leads back over the field.
        leg = self._downwind if view.along > 0.0 else self._upwind
        while abs(leg.across - view.across) > _ON_LINE or abs(leg.course_error(view)) > 0.3:
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
    intercept = math.atan(aside / _INTERCEPT_RANGE)
    intercept = min(max(intercept, -_STEEPEST_INTERCEPT), _STEEPEST_INTERCEPT)
    turn = math.remainder(leg.course_error(view) + intercept, 2.0 * math.pi)
    wanted = 1.1 * (turn - 0.35 * view.bank)
    return min(max(wanted, -_JOINING_BANK), _JOINING_BANK)
