"""The trim cue, live: whether the aircraft is level, steady and at its test point.

Rows become ticks of 0.05 s, ticks the motion of the last second (`senses`), and that is held
against the stated tolerances (`judging`, `tolerances`). Fixed rules then say what to do, and
`states` keeps them from flickering.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from gsapp.aircraft import Aircraft
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import CUES, TRIM
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.motion_estimator import MotionEstimator
from gsapp.excitation.trim.tick_means import TickMeans
from gsapp.excitation.trim.trim_cue import (
    ATTITUDE_SOURCE,
    DEFAULT_TOLERANCES,
    MeanMotion,
    TrimCue,
    TrimDeviation,
    TrimState,
    TrimTolerances,
    average_motion,
    evaluate_trim,
    list_sources,
    list_unmeasured,
)


class StateHysteresis:
    """Keeps the state until another one has been wanted for long enough."""

    def __init__(self, state: TrimState, time: float) -> None:
        self.state: TrimState = state
        self.since = time
        self._wish: TrimState = state
        self._wished_since = time

    def step(self, time: float, wanted: TrimState, *, lost: bool) -> None:
        """Go on to a time. Once lost, GO does not stand."""
        if wanted != self._wish:
            self._wish, self._wished_since = wanted, time
        if wanted == self.state:
            return
        at_once = self.state == "go" and lost
        doubt = 0.0 if wanted in ("hold", "go") else TRIM.change_delay
        stood = time - self.since >= TRIM.min_dwell_time - TRIM.time_tolerance
        sure = time - self._wished_since >= doubt - TRIM.time_tolerance
        if at_once or (stood and sure):
            self.state, self.since = wanted, time


class TrimMonitor:
    """Follows a flight and says whether an input may begin.

    At 1 g the airspeed fixes the angle of attack. So alpha is judged only where it is measured. The
    vane's reading is put back to the center of gravity for upwash, pitch and roll rate; what its
    calibration leaves is far within the tolerance of a test point. Without an aircraft, alpha is
    taken as its vane shows it, and an airspeed of 12 m/s is flight.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        tolerances: TrimTolerances = DEFAULT_TOLERANCES,
    ) -> None:
        self._aircraft = aircraft
        self._tolerances = tolerances
        self._tick = max(1, round(CUES.tick * rate))
        self._dt = self._tick / rate
        self._point: TestPoint | None = None
        self._needed = 0.0
        self._means = TickMeans(self._tick, self._dt)
        self.restart()

    def restart(self) -> None:
        """Forget the flight; the test point stays."""
        self._senses = MotionEstimator(self._aircraft, self._dt, self._tolerances)
        self._held_until = -math.inf
        self._begin()

    def _begin(self) -> None:
        """Forget what does not lead up to the next row."""
        self._means.restart()
        self._senses.restart()
        self._keeper: StateHysteresis | None = None
        self._steady = 0.0
        self._rough = self._gusty = False
        self._calm_for = 0.0
        self._motions: deque[MeanMotion] = deque(
            maxlen=2 * round(self._tolerances.averaging_time / self._dt) + 1
        )
        self.cue: TrimCue | None = None

    # What others know -----------------------------------------------------------------

    def set_test_point(self, point: TestPoint | None) -> None:
        """Judge against a test point from now on; None judges steadiness alone, at any speed."""
        self._point = point

    def inhibit_go(self, until: float) -> None:
        """Give no GO before this flight time, s: an input is under way."""
        self._held_until = until

    def require_leg_time(self, seconds: float) -> None:
        """Give no GO unless so many seconds from GO to the end of hands off fit before the turn.

        Three seconds (`TRIM.min_leg_time_left`) are the least; they are not added, or no input
        would fit into a leg of ten.
        """
        self._needed = seconds

    def set_invalid_channels(self, channels: tuple[str, ...]) -> None:
        """Read these channels as missing from now on; an empty tuple trusts all again."""
        self._means.invalid_channels = frozenset(channels)

    # Rows -----------------------------------------------------------------------------

    def process_rows(self, rows: FlightRows) -> None:
        """Judge at the end of each whole tick of these rows."""
        if rows.starts_segment:
            self._begin()
        ticks, stuck = self._means.average_rows(rows)
        times = rows.times[self._tick - 1 :: self._tick].tolist()
        for time, names, _ in zip(times, stuck, self._senses.process_ticks(ticks), strict=True):
            self._judge(time, names)

    def _judge(self, time: float, stuck: tuple[str, ...]) -> None:
        senses, point = self._senses, self._point
        motion, airborne = senses.motion, senses.airborne
        self._motions.append(motion)
        off = (
            evaluate_trim(
                motion, self._tolerances, point, attitude=senses.bank_sources == ATTITUDE_SOURCE
            )
            if airborne
            else ()
        )
        wanted = self._wanted(time, off, airborne=airborne)
        if self._keeper is None:
            self._keeper = StateHysteresis(wanted, time)
        else:
            self._keeper.step(time, wanted, lost=self._lost(off, wanted))
        state = self._keeper.state
        blind = state == "blind"
        leg, told_by = senses.leg, senses.leg.source if airborne else ""
        self.cue = TrimCue(
            time=time,
            state=state,
            since=self._keeper.since,
            deviations=() if blind else self._with_unrest(off) if airborne else (),
            judged_by=()
            if blind
            else list_sources(
                motion,
                point,
                wings=senses.bank_sources,
                leg=told_by,
            ),
            limitations=list_unmeasured(
                motion,
                point,
                calm=not math.isnan(senses.unrest.tolerance_ratio),
                leg=told_by,
                stuck=stuck if airborne else (),
            ),
            gust_strength=senses.unrest.gust_strength
            if airborne and self._undisturbed(time)
            else None,
            leg_time_left=leg.time_left if airborne else None,
            progress=min(self._steady / TRIM.steady_time, 1.0) if state in ("hold", "go") else 0.0,
        )

    # Rules ----------------------------------------------------------------------------

    def _wanted(self, time: float, off: Sequence[TrimDeviation], *, airborne: bool) -> TrimState:
        """Return what the state would be if it were new."""
        if all(math.isnan(rate) for rate in self._senses.fast_rates):
            self._steady = 0.0
            return "blind"
        if self._senses.on_ground:
            self._steady = 0.0
            return "ground"
        # After a gap it takes a second until the means tell anything.
        if not airborne or all(math.isnan(rate) for rate in self._senses.motion[:3]):
            self._steady = 0.0
            return "fly"
        state = None if self._keeper is None else self._keeper.state
        worst = off[0].tolerance_ratio if off else 0.0
        self._look_at_the_air(time)
        self._steady = self._steady + self._dt if worst <= 1.0 and not self._rough else 0.0
        held_off = time < self._held_until
        # Whoever makes an input already has no use for a leg that holds another one.
        if self._senses.leg.is_turning or (self._too_short(state) and not held_off):
            return "turn"
        trimmed = worst <= (TRIM.leave_ratio if state in ("hold", "go") else 1.0)
        # Gusts come and go: what three seconds together say does not.
        near = trimmed or (
            self._roughness() > TRIM.gusty_share
            and self._off_on_average() <= (TRIM.lost_ratio if state in ("hold", "gusty") else 1.0)
        )
        if not near:
            return "fly"
        if self._gusty:
            return "gusty"
        if not trimmed or self._rough or held_off:
            return "hold"
        sure = self._steady >= TRIM.steady_time and worst <= TRIM.enter_ratio
        return "go" if sure or state == "go" else "hold"

    def _roughness(self) -> float:
        share = self._senses.unrest.tolerance_ratio
        return 0.0 if math.isnan(share) else share

    def _too_short(self, state: TrimState | None) -> bool:
        left = self._senses.leg.time_left
        if left is None:
            return False
        least = max(TRIM.min_leg_time_left, self._needed)
        return left < least + self._senses.leg.time_uncertainty + (
            TRIM.leg_growth if state == "turn" else 0.0
        )

    def _off_on_average(self) -> float:
        """Return the share of the worst quantity over three seconds."""
        second = (len(self._motions) - 1) // 2
        three = average_motion([self._motions[place] for place in (0, second, 2 * second)])
        off = evaluate_trim(
            three,
            self._tolerances,
            self._point,
            attitude=self._senses.bank_sources == ATTITUDE_SOURCE,
        )
        return off[0].tolerance_ratio if off else 0.0

    def _look_at_the_air(self, time: float) -> None:
        roughness = self._roughness()
        self._rough = roughness > (TRIM.calm_share if self._rough else 1.0)
        self._calm_for = self._calm_for + self._dt if roughness < TRIM.calm_share else 0.0
        if self._rough and self._senses.unrest.is_lasting:
            self._gusty = self._gusty or self._undisturbed(time)
        elif self._calm_for >= TRIM.calm_time:
            self._gusty = False

    def _undisturbed(self, time: float) -> bool:
        return time > self._held_until + TRIM.window_count

    def _lost(self, off: Sequence[TrimDeviation], wanted: TrimState) -> bool:
        """Return whether GO must end at once."""
        if wanted in ("blind", "turn") or (off and off[0].tolerance_ratio > TRIM.lost_ratio):
            return True
        limits = self._tolerances
        rates = (limits.roll_rate, limits.pitch_rate, limits.yaw_rate)
        return any(
            abs(rate) > TRIM.lost_rate_ratio * limit
            for rate, limit in zip(self._senses.fast_rates, rates, strict=True)
        )

    def _with_unrest(self, off: tuple[TrimDeviation, ...]) -> tuple[TrimDeviation, ...]:
        """Add the unrest, in its place by size."""
        unrest = self._senses.unrest
        if math.isnan(unrest.tolerance_ratio):
            return off
        restless = TrimDeviation(
            quantity="unrest",
            amount=unrest.gust_strength or 0.0,
            tolerance_ratio=unrest.tolerance_ratio,
            channel=unrest.worst_channel,
        )
        return tuple(sorted((*off, restless), key=lambda one: -one.tolerance_ratio))
