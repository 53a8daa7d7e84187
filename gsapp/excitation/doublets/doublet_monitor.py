"""`DoubletMonitor`: inputs recognized while they happen, hands off, and a verdict on each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.flight_context import FlightContext, SignalHistory, default_aircraft
from gsapp.excitation.doublets.gust_analysis import GustAnalyzer
from gsapp.excitation.doublets.input_measurement import measure_input
from gsapp.excitation.doublets.stick_release import InputCandidate, StickReleaseDetector
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.doublets.verdict_criteria import InputRequest, evaluate_input
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import CUES, DOUBLETS
from gsapp.excitation.test_points.point import TargetInput, TestPoint
from gsapp.excitation.trim.trim_cue import DEFAULT_TOLERANCES, TrimTolerances
from gsapp.flight.cards import TestCard
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.rapid_moves import UNAMBIGUOUS_SHAPES, is_deliberate_input
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS, SURFACES
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

TargetLookup = Callable[[tuple[str, ...], str, float | None], TargetInput | None]
"""What is wanted of these surfaces, in this shape, at this airspeed (m/s)."""


class DoubletMonitor:
    """Watches the surfaces of one flight.

    Without an aircraft usual travels are taken, and no limits are known. A model tells how much of
    an answer the input explains, and how much the air. `wanted_for` gives what is wanted of an
    input that nobody expected.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        *,
        model: Model | None = None,
        wanted_for: TargetLookup | None = None,
        tolerances: TrimTolerances = DEFAULT_TOLERANCES,
        system: str = "US",
    ) -> None:
        self._known_aircraft = aircraft is not None
        self._aircraft = aircraft or default_aircraft()
        self._rate = rate
        self._tick = max(round(CUES.tick * rate), 1)
        self._wanted_for = wanted_for
        self._tolerances = tolerances
        self.system = system
        self._explainer = None
        if aircraft is not None and model is not None:
            self._explainer = GustAnalyzer(aircraft, model, rate)
        self._expected = InputRequest()
        self._around = FlightContext(self._aircraft, rate, self._tick)
        self._history = SignalHistory(rate)
        self._sticks = StickReleaseDetector(self._history, self._around)
        self.restart()

    def restart(self) -> None:
        """Forget the flight; what is expected stays."""
        self._around.restart()
        self._history.clear()
        self._moving: InputCandidate | None = None
        self._verdicts: list[InputVerdict] = []
        self._busy_until = -math.inf
        self._now = -math.inf
        self._distrusted: list[int] = []

    def expect(
        self, wanted: TargetInput | None, point: TestPoint | None, card: TestCard | None
    ) -> None:
        """Say what is to be flown next, where and for which card; it holds from now on."""
        self._expected = InputRequest(target_input=wanted, point=point, card=card)

    def set_invalid_channels(self, channels: Sequence[str]) -> None:
        """Take these channels for missing, from the next rows on.

        Surfaces stay: an input that nobody sees is not judged at all.
        """
        believed = (*SURFACES, "altitude", "throttle", "rpm")
        self._distrusted = [
            SIGNAL_COLUMNS[name]
            for name in channels
            if name in SIGNAL_COLUMNS and name not in believed
        ]

    @property
    def verdicts(self) -> tuple[InputVerdict, ...]:
        return tuple(self._verdicts)

    @property
    def noise(self) -> Mapping[str, float]:
        """Return the noise of each channel before take-off, SI; empty until that is known."""
        floor = self._around.setting.noise
        return floor.std if floor.is_final else {}

    @property
    def unmeasured_surfaces(self) -> tuple[str, ...]:
        """Return the surfaces that nothing shows just now: no input on them is recognized."""
        return self._around.unmeasured_surfaces

    @property
    def input_in_progress(self) -> InputInProgress | None:
        """Return the input that is being made, or whose answer is awaited."""
        moving = self._moving
        if moving is None:
            return None
        free = bool(moving.inputs)
        if free:
            surfaces = tuple(
                one.surface for one in sorted(moving.inputs, key=lambda one: one.t_start)
            )
            sizes = {one.surface: one.amplitude for one in moving.inputs}
        else:
            sizes = self._sticks.amplitudes(moving, self._now)
            surfaces = tuple(sizes)
        left = moving.t_end + moving.hands_off - self._now if free else moving.hands_off
        return InputInProgress(
            time=self._now,
            phase="hands-off" if free else "moving",
            surfaces=surfaces,
            t_input=moving.first_move_time,
            amplitudes=sizes,
            hands_off_left=max(left, 0.0),
            hands_off_total=moving.hands_off,
        )

    # --- rows -----------------------------------------------------------------------------------

    def process_rows(self, rows: FlightRows) -> None:
        """Take in the next rows, in whole ticks."""
        if not len(rows):
            return
        if rows.starts_segment:
            self._interrupt(float(rows.times[0]))
        signals = rows.values[:, : len(SIGNALS)]
        if self._distrusted:
            signals = signals.copy()
            signals[:, self._distrusted] = np.nan
        self._history.add(rows, signals)
        moves = self._around.move_detector.measure(signals)
        for low in range(0, len(rows), self._tick):
            high = min(low + self._tick, len(rows))
            self._step(
                (rows.first_index + low) // self._tick, rows.times, signals, moves, low, high
            )

    def finish(self) -> None:
        """Draw conclusions from what came last; nothing more comes."""
        self._interrupt(self._now)

    def _interrupt(self, time: float) -> None:
        moving = self._moving
        if moving is not None and moving.inputs:
            self._conclude(moving, self._now)
        self._moving = None
        self._history.clear()
        self._around.start_segment(time)

    def _step(
        self,
        number: int,
        times: FloatArray,
        signals: FloatArray,
        moves: FloatArray,
        low: int,
        high: int,
    ) -> None:
        """Go through one tick."""
        self._now = float(times[high - 1])
        peaks = moves[low:high].max(axis=0)
        thresholds = self._around.move_detector.thresholds
        quick = [place for place in range(len(SURFACES)) if peaks[place] > thresholds[place]]
        if quick:
            over = (moves[low:high, quick] > np.array(thresholds)[quick]).any(axis=1)
            places = np.flatnonzero(over)
            first, last = (float(times[low + int(places[k])]) for k in (0, -1))
            self._quick_moves([SURFACES[place] for place in quick], first, last)
        self._around.process_tick(
            number, self._now, signals[low:high], peaks, steering=self._moving is None
        )
        moving = self._moving
        if moving is None:
            return
        if moving.inputs:
            self._watch_hands(moving)
        else:
            self._watch_sticks(moving)

    def _quick_moves(self, surfaces: Sequence[str], first: float, last: float) -> None:
        """Note that these surfaces moved quickly."""
        moving = self._moving
        if moving is not None and moving.inputs:
            awaited = bool(moving.pending_surfaces & set(surfaces))
            if first - moving.t_end <= (
                DOUBLETS.release_time_expected + DOUBLETS.continuation_time
                if awaited
                else DOUBLETS.continuation_time
            ):
                moving.previous_inputs = [] if awaited else moving.inputs
                moving.resume_time, moving.inputs = first, []
            else:
                self._conclude(moving, first)
                moving = None
        if moving is None:
            if not self._around.is_flying(first):
                return
            moving = InputCandidate(
                first_move_time=first,
                last_move_time=last,
                began_in_recovery=first < self._busy_until,
            )
            moving.request = self._expected
            if moving.request.target_input is not None:
                moving.hands_off = moving.request.target_input.hands_off
            self._moving = moving
        moving.last_move_time = last
        moving.surfaces += [name for name in surfaces if name not in moving.surfaces]

    # --- the input ------------------------------------------------------------------------------

    def _watch_sticks(self, moving: InputCandidate) -> None:
        """See whether the sticks were let go, or whether it was steering after all."""
        found = self._sticks.detect_release(moving, self._now)
        went_on = (
            bool(moving.expected_kind)
            and self._now - moving.resume_time > DOUBLETS.continuation_after_target
        )
        if moving.previous_inputs and (went_on if found is None else not found):
            # What seemed to go on was the hand that came back at once.
            moving.inputs = moving.previous_inputs
            self._conclude(moving, max(moving.resume_time, moving.t_end))
            return
        if found is None:
            return
        if not found or self._in_turn(found):
            self._dismiss()
            return
        moving.request, found = self._held_against(moving, found)
        moving.inputs = found
        moving.t_end = max(one.t_end for one in found)
        wanted = moving.request.target_input
        moving.hands_off = DETECTION.min_free_response_time if wanted is None else wanted.hands_off

    def _in_turn(self, found: Sequence[SurfaceInput]) -> bool:
        """Return whether the aircraft turned when the sticks began to move."""
        begun = min(one.t_start for one in found)
        attitude = self._history.extra_channel("phi", begun - 1.0, begun)
        if np.isfinite(attitude).any():
            return abs(float(np.nanmean(attitude))) > DOUBLETS.max_start_bank
        # In a level turn r V = g sin(bank).
        _, rows = self._history.segment(begun - 1.0, begun)
        drawn = rows[:, SIGNAL_COLUMNS["r"]] * rows[:, SIGNAL_COLUMNS["V"]]
        return bool(
            np.abs(np.nan_to_num(drawn).mean()) > GRAVITY * math.sin(DOUBLETS.max_start_bank)
        )

    def _held_against(
        self, moving: InputCandidate, found: list[SurfaceInput]
    ) -> tuple[InputRequest, list[SurfaceInput]]:
        """Return what an input is held against, and which of the surfaces belong to it."""
        asked = moving.request
        expected = moving.expected_surfaces
        moved = {one.surface for one in found}
        another = found[0].kind in UNAMBIGUOUS_SHAPES and moving.expected_kind not in (
            "",
            found[0].kind,
        )
        if expected and expected <= moved and found[0].surface in expected and not another:
            return asked, [one for one in found if one.surface in expected]
        # A second stick belongs to the input if it was moved in the same way.
        kept = [one for one in found if one is found[0] or one.kind == found[0].kind]
        kept.sort(key=lambda one: one.t_start)
        surfaces = tuple(one.surface for one in kept)
        if set(surfaces) == expected and not another:
            return asked, kept
        wanted = None
        if self._wanted_for is not None:
            speed = self._speed_before(min(one.t_start for one in kept))
            wanted = self._wanted_for(surfaces, kept[0].kind, speed)
        # The point of a card does not hold for what is flown in its place.
        point = asked.point if asked.target_input is None else None
        return InputRequest(target_input=wanted, point=point, card=None), kept

    def _speed_before(self, time: float) -> float | None:
        _, rows = self._history.segment(time - 1.0, time)
        speed = rows[:, SIGNAL_COLUMNS["V"]]
        return float(np.nanmean(speed)) if np.isfinite(speed).any() else None

    def _dismiss(self) -> None:
        self._around.reject_input()
        self._moving = None

    # --- the hands ------------------------------------------------------------------------------

    def _watch_hands(self, moving: InputCandidate) -> None:
        taken = self._sticks.detect_hands_on(moving, self._now, self._rate)
        wanted_end = moving.t_end + moving.hands_off
        if taken is not None and taken < wanted_end:
            self._conclude(moving, taken)
        elif self._now >= wanted_end:
            self._conclude(moving, wanted_end)

    def _conclude(self, moving: InputCandidate, t_end: float) -> None:
        """Give the verdict, unless the sticks moved so soon again that it was steering."""
        main = moving.inputs[0]
        threshold = self._around.move_detector.thresholds[SURFACES.index(main.surface)]
        free = t_end - moving.t_end
        if (
            main.has_returned_to_trim
            and not moving.is_confirmed
            and not is_deliberate_input(main, free, threshold)
        ):
            self._dismiss()
            return
        self._around.accept_input()
        self._moving = None
        measured = measure_input(
            self._history, moving.inputs, t_end, self._around.setting, self._explainer
        )
        self._verdicts.append(
            evaluate_input(
                f"M{len(self._verdicts) + 1}",
                self._now,
                measured,
                moving.request,
                self._around.setting,
                self._tolerances,
                known_aircraft=self._known_aircraft,
                system=self.system,
            )
        )
        self._busy_until = self._now + DOUBLETS.recovery_time
