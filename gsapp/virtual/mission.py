"""From engine start to engine stop: what the pilot wants at each moment.

Each stage is a generator that is sent the pilot's view and yields an intent; it ends when the
stage is done. How an intent becomes sticks is the business of
`gsapp.virtual.human_pilot`.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.quantities.constants import DEGREE, GRAVITY
from gsapp.virtual.flight_plan import FlightPlan, Pattern, PilotLimits, PlannedManeuver, RangeCheck
from gsapp.virtual.pilot_perception import PilotView
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import StickInput

TRAINEE_PHASE: Final = "you have control"
RECOVERY_PHASE: Final = "I have control"
_ANNOUNCEMENTS: Final = {
    "preflight": "Telemetry on, recording",
    "engines running": "Engines running",
    "range check": "Range check",
    "take-off": "Take-off run",
    "climb": "Airborne",
    "pattern": "In the pattern",
    "approach": "Approach",
    "landed": "Landed",
    "engines off": "Engines off",
    "crashed": "Crashed",
    TRAINEE_PHASE: "You have control",
    RECOVERY_PHASE: "I have control",
}
REPEATED_PHASES: Final = (TRAINEE_PHASE, RECOVERY_PHASE)
"""Phases that are announced every time they begin."""


def phase_announcement(phase: str) -> str:
    """Return the status message at the start of a phase; empty for none.

    Maneuvers have none: the ground station finds them.
    """
    return _ANNOUNCEMENTS.get(phase, "")


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidanceCommand:
    """What the pilot wants now."""

    phase: str  # In words, for the crew.
    path_angle: float | None = None  # Flight path angle wanted, rad.
    pitch: float | None = None  # Pitch attitude wanted instead, rad; with neither, the stick stays.
    path_gain: float = 0.25  # How quickly an error of the path is answered with the attitude.
    bank: float = 0.0  # Wanted, rad, towards the pattern.
    speed: float | None = None  # Airspeed wanted, m/s.
    throttle: float | None = None  # Throttle wanted instead; with neither, the throttle stays.
    throttle_step: float = 0.0  # Change of the throttle from where it was before.
    steer: float | None = None  # Course wanted on the ground, rad.
    stick_input: StickInput | None = None  # An input under way, and since when.
    stick_time: float = 0.0  # s since it began.
    hands_off: bool = False  # Hands off: keep what is held.
    flap: float = 0.0  # Wanted, rad.
    brake: float = 0.0  # 0 to 1.
    engines: bool = True  # Running.


MissionStage = Generator[GuidanceCommand, PilotView, None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """A straight leg: its course (0 upwind, pi downwind), its line, and where it ends, m."""

    course: float
    across: float
    end: float

    def distance_past_end(self, view: PilotView) -> float:
        """Return how far the aircraft is beyond the end, m."""
        return (view.along - self.end) * math.cos(self.course)

    def course_error(self, view: PilotView) -> float:
        """Return the turn needed to fly along, rad, positive towards the pattern."""
        return math.remainder(self.course - view.course, 2.0 * math.pi)

    def bank(self, view: PilotView, most: float) -> float:
        """Return the bank that brings the aircraft onto the line, rad."""
        aside = (self.across - view.across) * math.cos(self.course)
        correction = min(max(0.006 * aside, -0.2), 0.2)
        # What the bank now held will still turn before another one is rolled in.
        coming = 0.35 * view.bank
        wanted = 1.1 * (self.course_error(view) + correction - coming)
        return min(max(wanted, -most), most)


def upwind_start(pattern: Pattern) -> tuple[float, float]:
    """Return where the upwind leg begins: along and across the runway, m."""
    return -0.5 * pattern.speed * pattern.leg, VIRTUAL.upwind_leg_across


class Mission:
    """The stages of one plan; how each maneuver turns out is random."""

    def __init__(self, plan: FlightPlan, random: np.random.Generator) -> None:
        self._plan = plan
        self._random = random
        pattern = plan.pattern
        self._radius = pattern.speed**2 / (GRAVITY * math.tan(pattern.bank))
        start, across_start = upwind_start(pattern)
        half = -start
        across = across_start + 2.0 * self._radius
        self._upwind = Leg(course=0.0, across=across_start, end=half)
        self._downwind = Leg(course=math.pi, across=across, end=-half)
        self.flown_maneuvers: list[tuple[float, float, PlannedManeuver]] = []
        """Start and end of each maneuver, s, as it was flown."""

    def stages(self) -> MissionStage:
        yield from self._engines()
        yield from self._takeoff()
        yield from self._pattern()
        yield from self._approach()
        yield from self._rollout()

    # On the ground ---------------------------------------------------------------------

    def _engines(self) -> MissionStage:
        engines, check = self._plan.engines, self._plan.range_check
        pulses = _range_check_inputs(check)
        view = yield GuidanceCommand(phase="preflight", engines=False, brake=1.0, throttle=0.0)
        while view.time < engines.start:
            view = yield GuidanceCommand(phase="preflight", engines=False, brake=1.0, throttle=0.0)
        while (time := view.time - engines.start) < engines.running:
            throttle = 0.0
            for run_up in engines.run_ups:
                if time >= run_up.at:
                    throttle = run_up.throttle
            since = time - check.at
            index = int(since // check.spacing) if since >= 0.0 else -1
            checking = 0 <= index < len(pulses)
            view = yield GuidanceCommand(
                phase="range check" if checking else "engines running",
                throttle=throttle,
                brake=1.0,
                stick_input=pulses[index] if checking else None,
                stick_time=since - check.spacing * index,
            )

    def _takeoff(self) -> MissionStage:
        takeoff = self._plan.takeoff
        view = yield GuidanceCommand(phase="take-off", throttle=takeoff.throttle, steer=0.0)
        while view.on_ground or view.height < 1.0:
            # The eye is late by a few tenths of a second, and so is the aircraft.
            lifting = view.speed > takeoff.speed - 4.0
            view = yield GuidanceCommand(
                phase="take-off",
                throttle=takeoff.throttle,
                pitch=9.0 * DEGREE if lifting else 0.0,
                bank=0.0,
                steer=min(max(-0.02 * view.across, -0.1), 0.1) if view.on_ground else None,
            )
        pattern = self._plan.pattern
        straight = Leg(course=0.0, across=0.0, end=0.8 * self._upwind.end)
        while straight.distance_past_end(view) < 0.0 or view.height < 0.3 * pattern.height:
            view = yield GuidanceCommand(
                phase="climb",
                throttle=takeoff.throttle,
                path_angle=self._climb_path(view),
                bank=straight.bank(view, 15.0 * DEGREE) if view.height > 6.0 else 0.0,
            )

    def _climb_path(self, view: PilotView) -> float:
        missing = self._plan.pattern.height - view.height
        # Too slow to climb steeply: a pilot feels that the aircraft hangs on its propellers.
        slow = self._plan.takeoff.speed + 3.0 - view.speed
        steepest = self._plan.takeoff.climb - 0.03 * max(slow, 0.0)
        return min(steepest, 0.012 * missing)

    # In the pattern --------------------------------------------------------------------

    def _level(self, view: PilotView, height: float | None = None) -> float:
        """Return the path that keeps the height, rad."""
        wanted = self._plan.pattern.height if height is None else height
        # An aircraft that has become slow is not made to climb.
        most = min(max(4.0 - 0.8 * (self._plan.landing.speed + 4.0 - view.speed), 0.0), 4.0)
        climb = min(max(0.11 * (wanted - view.height), -4.0), most)
        return math.atan2(climb, max(view.speed, 15.0))

    def _pattern(self) -> MissionStage:
        left = list(self._plan.maneuvers)
        leg = self._downwind
        for _ in range(VIRTUAL.max_legs):
            yield from self._turn(leg)
            if not left:
                # The approach starts from a downwind leg.
                if leg is self._downwind:
                    return
                yield from self._straight(leg)
            elif (yield from self._maneuver_leg(leg, left[0])):
                left.pop(0)
            leg = self._upwind if leg is self._downwind else self._downwind

    def _turn(self, leg: Leg) -> MissionStage:
        """Turn towards the pattern onto a leg."""
        pattern = self._plan.pattern
        view = yield GuidanceCommand(
            phase="pattern", path_angle=0.0, bank=0.5 * pattern.bank, speed=pattern.speed
        )
        while True:
            left = leg.course_error(view)
            if left < -1.5:
                left += 2.0 * math.pi
            # Rolling out takes as long as rolling in did: half the bank is turned away meanwhile.
            if left < 0.75 * abs(view.bank):
                return
            view = yield GuidanceCommand(
                phase="pattern",
                path_angle=self._level(view),
                bank=self._turning_bank(view, leg, left),
                speed=pattern.speed,
            )

    def _turning_bank(self, view: PilotView, leg: Leg, left: float) -> float:
        """Return the bank whose radius ends on the line of the leg."""
        aside = abs(leg.across - view.across)
        radius = aside / (1.0 - math.cos(left)) if left > 0.6 else self._radius
        radius = max(radius, 1.0)
        bank = math.atan(view.speed**2 / (GRAVITY * radius))
        usual = self._plan.pattern.bank
        return min(max(bank, usual - 10.0 * DEGREE), usual + 4.0 * DEGREE)

    def _straight(self, leg: Leg) -> MissionStage:
        view = yield GuidanceCommand(
            phase="pattern", path_angle=0.0, speed=self._plan.pattern.speed
        )
        while leg.distance_past_end(view) < 0.0:
            view = yield self._along(leg, view, "pattern")

    def _along(
        self,
        leg: Leg,
        view: PilotView,
        phase: str,
        speed: float | None = None,
        flap: float = 0.0,
    ) -> GuidanceCommand:
        return GuidanceCommand(
            phase=phase,
            path_angle=self._level(view),
            bank=leg.bank(view, 15.0 * DEGREE),
            speed=self._plan.pattern.speed if speed is None else speed,
            flap=flap,
        )

    def _maneuver_leg(
        self, leg: Leg, maneuver: PlannedManeuver
    ) -> Generator[GuidanceCommand, PilotView, bool]:
        """Fly a leg with a maneuver; return whether it was flown."""
        speed = self._plan.pattern.speed if maneuver.speed is None else maneuver.speed
        view = yield GuidanceCommand(phase="pattern", path_angle=0.0, speed=speed)
        entered, steady_since = view.time, math.inf
        # What is left of the leg must hold the input and its first answer.
        last_start = -speed * (maneuver.duration + 1.0)
        while True:
            if leg.distance_past_end(view) > last_start:
                while leg.distance_past_end(view) < 0.0:
                    view = yield self._along(leg, view, "pattern", speed, maneuver.flap)
                return False
            # Time runs on a short leg: what is not good enough at first is so in the end.
            patience = 1.0 if view.time - entered < 3.0 else 1.5
            if not (
                _is_steady(view, leg, patience) and self._looks_in_place(view, speed, patience)
            ):
                steady_since = math.inf
            elif math.isinf(steady_since):
                steady_since = view.time
            if view.time - steady_since > 0.8 and view.time - entered > 1.2:
                break
            view = yield self._along(leg, view, "pattern", speed, maneuver.flap)
        stick = StickInput(maneuver, self._plan.human, self._random)
        began = view.time
        number = len(self.flown_maneuvers) + 1
        phase = f"maneuver {number}"
        length = stick.duration + maneuver.quiet * float(self._random.uniform(0.8, 1.2))
        while (time := view.time - began) < length and not _is_upset(view):
            view = yield GuidanceCommand(
                phase=phase,
                stick_input=stick,
                stick_time=time,
                hands_off=True,
                throttle_step=maneuver.throttle_step if time >= stick.duration else 0.0,
                flap=maneuver.flap,
            )
        self.flown_maneuvers.append((began, view.time, maneuver))
        while leg.distance_past_end(view) < 0.0:
            view = yield self._along(leg, view, "pattern", speed)
        return True

    def _looks_in_place(self, view: PilotView, speed: float, patience: float) -> bool:
        return (
            abs(view.height - self._plan.pattern.height) < 10.0 * patience
            and abs(view.speed - speed) < 3.5 * patience
        )

    # Back to the ground ----------------------------------------------------------------

    def _approach(self) -> MissionStage:
        landing = self._plan.landing
        # Long enough a final to come down from a low downwind leg.
        low = min(self._plan.pattern.height, 40.0)
        final_length = 0.75 * low / math.tan(landing.glide)
        downwind = Leg(
            course=math.pi,
            across=2.0 * self._radius * 1.1,
            end=VIRTUAL.aim_point_along - final_length,
        )
        fast = landing.speed + 3.0
        view = yield GuidanceCommand(phase="approach", path_angle=0.0, speed=fast)
        while downwind.distance_past_end(view) < 0.0:
            view = yield GuidanceCommand(
                phase="approach",
                path_angle=max(self._level(view, low), -7.0 * DEGREE),
                bank=downwind.bank(view, 25.0 * DEGREE),
                speed=fast,
                flap=0.5 * landing.flap,
            )
        final = Leg(course=0.0, across=0.0, end=VIRTUAL.aim_point_along)
        while final.course_error(view) > 0.3 or final.course_error(view) < -1.5:
            left = final.course_error(view) % (2.0 * math.pi)
            view = yield GuidanceCommand(
                phase="approach",
                path_angle=self._glide(view, arc=self._radius * left),
                bank=min(self._turning_bank(view, final, left), 42.0 * DEGREE),
                speed=fast,
                flap=0.5 * landing.flap,
            )
        # A flare begins earlier the faster the ground comes up.
        while view.height + 1.2 * view.climb > 2.5:
            view = yield GuidanceCommand(
                phase="final",
                path_angle=self._glide(view, arc=0.0),
                bank=final.bank(view, 20.0 * DEGREE if view.height > 12.0 else 10.0 * DEGREE),
                speed=landing.speed,
                flap=landing.flap,
            )
        while not view.on_ground:
            view = yield self._flare(view, "flare")

    def _flare(self, view: PilotView, phase: str) -> GuidanceCommand:
        """Return the intent to let the aircraft down onto its wheels."""
        final = Leg(course=0.0, across=0.0, end=VIRTUAL.aim_point_along)
        sink = 0.3 + 0.35 * max(view.height, 0.0)
        # An aircraft that has become slow is let down while it still can be.
        sink += 0.15 * max(0.85 * self._plan.landing.speed - view.speed, 0.0)
        return GuidanceCommand(
            phase=phase,
            path_angle=math.atan2(-min(sink, 2.0), max(view.speed, 15.0)),
            path_gain=1.0,
            # Near the ground the wings are kept level before anything else.
            bank=final.bank(view, 4.0 * DEGREE),
            speed=self._plan.landing.speed,
            throttle=0.0 if view.height < 2.0 else None,
            flap=self._plan.landing.flap,
        )

    def _glide(self, view: PilotView, *, arc: float) -> float:
        """Return the path that leads to the aiming point over `arc` more meters of turn."""
        slope = math.tan(self._plan.landing.glide)
        distance = max(VIRTUAL.aim_point_along - view.along, 0.0) + arc
        above = view.height - 2.0 - slope * distance
        path = min(max(-self._plan.landing.glide - 0.012 * above, -11.0 * DEGREE), 1.0 * DEGREE)
        # Speed first, then height.
        slow = max(self._plan.landing.speed - 1.5 - view.speed, 0.0)
        # Close to the ground nobody dives at the runway.
        steepest = 7.0 * DEGREE if view.height < 20.0 else 11.0 * DEGREE
        return max(path - 0.02 * slow, -steepest)

    def _rollout(self) -> MissionStage:
        view = yield GuidanceCommand(phase="landed", throttle=0.0)
        since, pitch = view.time, view.pitch
        while view.time - since < 60.0 and view.ground_speed > 1.0:
            if not view.on_ground and view.height > 0.3:
                # A bounce: once more.
                since, pitch = view.time, view.pitch
                view = yield self._flare(view, "landed")
                continue
            rolled = view.time - since
            settled = rolled > 2.5
            view = yield GuidanceCommand(
                phase="landed",
                throttle=0.0,
                steer=min(max(-0.02 * view.across, -0.1), 0.1),
                # The nose wheel is let down, not dropped.
                pitch=max(pitch - 4.0 * DEGREE * rolled, 0.0),
                brake=0.5 if settled else 0.0,
                flap=self._plan.landing.flap,
            )
        for phase, running, length in (("landed", True, 2.0), ("engines off", False, 3.0)):
            since = view.time
            while view.time - since < length:
                view = yield GuidanceCommand(phase=phase, throttle=0.0, brake=1.0, engines=running)


def _range_check_inputs(check: RangeCheck) -> list[StickInput]:
    """Return the pulses: large, alike, and of no interest to anyone but the receiver."""
    steady = PilotLimits(size_error=0.0, timing_error=0.0, residual=0.0)
    quiet = np.random.default_rng(0)
    return [
        StickInput(
            PlannedManeuver.model_validate(
                {
                    "inputs": (surface,),
                    "shape": check.shape,
                    "stick": (check.stick,),
                    "step": f"{check.duration} s",
                }
            ),
            steady,
            quiet,
        )
        for surface in check.pulses
    ]


def _is_steady(view: PilotView, leg: Leg, patience: float) -> bool:
    return (
        abs(view.bank) < 5.0 * DEGREE * patience
        and abs(view.climb) < 1.5 * patience
        and abs(view.roll_rate) < 5.0 * DEGREE * patience
        and abs(view.pitch_rate) < 4.0 * DEGREE * patience
        and abs(leg.course_error(view)) < 0.2 * patience
    )


def _is_upset(view: PilotView) -> bool:
    return (
        abs(view.bank) > 50.0 * DEGREE
        or abs(view.pitch) > 30.0 * DEGREE
        or abs(view.climb) > 6.0
        or view.height < 18.0
    )
