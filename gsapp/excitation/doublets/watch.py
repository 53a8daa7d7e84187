"""`DoubletWatch`: inputs recognized while they happen, hands off, and a verdict on each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.explaining import Explainer
from gsapp.excitation.doublets.giving import Asked, give_verdict
from gsapp.excitation.doublets.history import History
from gsapp.excitation.doublets.measuring import LOOKED_BACK, measure_input
from gsapp.excitation.doublets.surroundings import Surroundings
from gsapp.excitation.doublets.verdict import InputUnderWay, Verdict
from gsapp.excitation.points.point import TestPoint
from gsapp.excitation.points.wanted import WantedInput
from gsapp.excitation.rows import TICK, FlightRows
from gsapp.excitation.trim.tolerances import TOLERANCES, TrimTolerances
from gsapp.flight.cards import TestCard
from gsapp.flight.maneuvers.grading import HANDS_OFF_WANTED
from gsapp.flight.maneuvers.moves import (
    ALSO_MOVED,
    CLOSED,
    CLOSED_AWAY,
    deliberate,
    moved_inputs,
    strong_moves,
    taken_over,
)
from gsapp.flight.maneuvers.shape import LOOK_BACK, SurfaceInput, measure
from gsapp.flight.maneuvers.signals import SIGNALS, SURFACES
from gsapp.quantities import FloatArray

WantedFor = Callable[[tuple[str, ...], str, float | None], WantedInput | None]
"""What is wanted of these surfaces, in this shape, at this airspeed (m/s)."""

QUIET: Final = 0.15
"""Seconds without a quick move after which an input is over, if the surfaces are back."""
AWAITED: Final = 0.6
"""The same while a surface that is expected has not moved yet."""
JOINED: Final = 0.7
"""A quick move so soon after an input, s, goes on with it."""
_LONGEST = 10.0
"""An input that goes on for longer, s, is steering."""
_ODD_FREE = 1.05
"""Seconds without a stick after which an input of an unusual shape is believed."""
_BACK = 0.4
"""Share of its excursion that a surface may be away from trim and be back."""
_LEFT = 0.25
"""Share of its amplitude from which a surface was not brought back, and looks like another shape
about the line between its trims."""
_BOTH_SIDES = 0.35
"""Share of the larger excursion from which the smaller one is the other half of a doublet."""
_AFTER_LAST_STEP = 0.8
"""Seconds after which an input that ends away from trim is over, once both sides were seen."""
_BUSY = 4.0
"""Seconds after a verdict in which the pilot recovers, and only unmistakable inputs are any."""
_CLEAR = ("doublet", "3-2-1-1")


@dataclass(slots=True)
class _Moving:
    """Quick moves that may be an input.

    Attributes
    ----------
    first, last : float
        Time of the first and of the last quick move, s.
    moved : list of str
        Surfaces in the order of their first quick move.
    busy : bool
        Whether the pilot was recovering when it began.
    found : list of SurfaceInput
        Measured when the sticks were let go; empty before.
    t_end : float
        When the last surface was back, s.
    asked : Asked
        What the input is held against, once it is known.
    hands_off : float
        Seconds for which the hands should be off.
    """

    first: float
    last: float
    busy: bool
    moved: list[str] = field(default_factory=list)
    found: list[SurfaceInput] = field(default_factory=list)
    t_end: float = math.nan
    asked: Asked = field(default_factory=Asked)
    hands_off: float = HANDS_OFF_WANTED


class DoubletWatch:
    """Watches the surfaces of one flight.

    Parameters
    ----------
    aircraft : Aircraft or None
        Travel, ranges, linear limits, sticks. None takes usual travels and knows no limits.
    rate : float
        Of the rows, Hz.
    model : Model or None
        Tells how much of an answer the input explains, and how much the air.
    wanted_for : callable or None
        What is wanted of an input that nobody expected.
    tolerances : TrimTolerances
        Of the trim before an input.
    system : {"US", "SI"}
        Units of the words.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        *,
        model: Model | None = None,
        wanted_for: WantedFor | None = None,
        tolerances: TrimTolerances = TOLERANCES,
        system: str = "US",
    ) -> None:
        self._known_aircraft = aircraft is not None
        self._aircraft = aircraft or _usual_aircraft()
        self._rate = rate
        self._tick = max(round(TICK * rate), 1)
        self._wanted_for = wanted_for
        self._tolerances = tolerances
        self._system = system
        self._explainer = None
        if aircraft is not None and model is not None:
            self._explainer = Explainer(aircraft, model, rate)
        self._expected = Asked()
        self._around = Surroundings(self._aircraft, rate, self._tick)
        self._history = History(rate)
        self.restart()

    def restart(self) -> None:
        """Forget the flight; what is expected stays."""
        self._around.restart()
        self._history.clear()
        self._moving: _Moving | None = None
        self._verdicts: list[Verdict] = []
        self._busy_until = -math.inf
        self._now = -math.inf

    def expect(
        self, wanted: WantedInput | None, point: TestPoint | None, card: TestCard | None
    ) -> None:
        """Say what is to be flown next; it holds for inputs that begin from now on.

        Parameters
        ----------
        wanted : WantedInput or None
        point : TestPoint or None
            Where it should begin.
        card : TestCard or None
            What it is flown for.
        """
        self._expected = Asked(wanted=wanted, point=point, card=card)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Return all verdicts of the flight so far."""
        return tuple(self._verdicts)

    @property
    def under_way(self) -> InputUnderWay | None:
        """Return the input that is being made, or whose answer is awaited."""
        moving = self._moving
        if moving is None:
            return None
        free = bool(moving.found)
        if free:
            surfaces = tuple(
                one.surface for one in sorted(moving.found, key=lambda one: one.t_start)
            )
            sizes = {one.surface: one.amplitude for one in moving.found}
        else:
            sizes = self._sizes(moving)
            surfaces = tuple(sizes)
        left = moving.t_end + moving.hands_off - self._now if free else moving.hands_off
        return InputUnderWay(
            time=self._now,
            phase="hands-off" if free else "moving",
            surfaces=surfaces,
            t_input=moving.first,
            amplitudes=sizes,
            hands_off_left=max(left, 0.0),
            hands_off_total=moving.hands_off,
        )

    # --- rows -----------------------------------------------------------------------------------

    def take(self, rows: FlightRows) -> None:
        """Take in the next rows, in whole ticks."""
        if not len(rows):
            return
        if rows.fresh:
            self._interrupt(float(rows.times[0]))
        self._history.add(rows)
        signals = rows.values[:, : len(SIGNALS)]
        moves = self._around.quick.measure(signals)
        for low in range(0, len(rows), self._tick):
            high = min(low + self._tick, len(rows))
            self._step((rows.first + low) // self._tick, rows.times, signals, moves, low, high)

    def finish(self) -> None:
        """Draw conclusions from what came last; nothing more comes."""
        self._interrupt(self._now)

    def _interrupt(self, time: float) -> None:
        moving = self._moving
        if moving is not None and moving.found:
            self._conclude(moving, self._now)
        self._moving = None
        self._history.clear()
        self._around.interrupt(time)

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
        self._around.take(
            number, self._now, signals[low:high], peaks, steering=self._moving is None
        )
        thresholds = self._around.quick.thresholds
        quick = [place for place in range(len(SURFACES)) if peaks[place] > thresholds[place]]
        if quick:
            over = (moves[low:high, quick] > np.array(thresholds)[quick]).any(axis=1)
            places = np.flatnonzero(over)
            first, last = (float(times[low + int(places[k])]) for k in (0, -1))
            self._quick_moves([SURFACES[place] for place in quick], first, last)
        moving = self._moving
        if moving is None:
            return
        if moving.found:
            self._watch_hands(moving)
        else:
            self._watch_sticks(moving)

    def _quick_moves(self, surfaces: Sequence[str], first: float, last: float) -> None:
        """Note that these surfaces moved quickly."""
        moving = self._moving
        if moving is not None and moving.found:
            awaited = set(_surfaces(moving.asked.wanted)) - set(moving.moved)
            joined = AWAITED + JOINED if awaited & set(surfaces) else JOINED
            if first - moving.t_end <= joined:
                moving.found = []
            else:
                self._conclude(moving, first)
                moving = None
        if moving is None:
            if not self._around.flies(first):
                return
            moving = _Moving(first=first, last=last, busy=first < self._busy_until)
            moving.asked = self._expected
            if moving.asked.wanted is not None:
                moving.hands_off = moving.asked.wanted.hands_off
            self._moving = moving
        moving.last = last
        moving.moved += [name for name in surfaces if name not in moving.moved]

    # --- the input ------------------------------------------------------------------------------

    def _watch_sticks(self, moving: _Moving) -> None:
        """See whether the sticks were let go, or whether it was steering after all."""
        if moving.last - moving.first > _LONGEST:
            self._dismiss()
            return
        idle = self._now - moving.last
        awaited = set(_surfaces(moving.asked.wanted)) - set(moving.moved)
        if idle < (AWAITED if awaited and set(moving.moved) & set(_expected(moving)) else QUIET):
            return
        if idle < CLOSED_AWAY and not self._back(moving):
            found = self._measured(moving) if idle > _AFTER_LAST_STEP else []
            if not (found and self._both_sides(moving, found[0]) and _complete(found[0], idle)):
                return
        else:
            found = self._measured(moving)
        if not found:
            self._dismiss()
            return
        main = found[0]
        place = SURFACES.index(main.surface)
        threshold = self._around.quick.thresholds[place]
        clear = main.kind in _CLEAR or main.kind == _kind(moving.asked.wanted)
        if moving.busy and not main.unmistakable:
            if idle >= CLOSED:
                self._dismiss()
        elif not clear and (idle < _ODD_FREE or moving.asked.wanted is not None):
            # Steering makes such moves as well; who asked for another shape has no use for them.
            if idle >= CLOSED:
                self._dismiss()
        elif deliberate(main, math.inf, threshold) or (
            not main.returned and self._both_sides(moving, main) and _steps(main, threshold)
        ):
            self._let_go(moving, found)
        elif idle >= CLOSED:
            self._dismiss()

    def _let_go(self, moving: _Moving, found: list[SurfaceInput]) -> None:
        """Begin the hands-off interval."""
        moving.asked, found = self._held_against(moving, found)
        moving.found = found
        moving.t_end = max(one.t_end for one in found)
        wanted = moving.asked.wanted
        moving.hands_off = HANDS_OFF_WANTED if wanted is None else wanted.hands_off

    def _held_against(
        self, moving: _Moving, found: list[SurfaceInput]
    ) -> tuple[Asked, list[SurfaceInput]]:
        """Return what an input is held against, and which of the surfaces belong to it."""
        asked = moving.asked
        expected = set(_surfaces(asked.wanted))
        moved = {one.surface for one in found}
        if expected and expected <= moved and found[0].surface in expected:
            return asked, [one for one in found if one.surface in expected]
        # A second stick belongs to the input if it was moved in the same way.
        kept = [one for one in found if one is found[0] or one.kind == found[0].kind]
        kept.sort(key=lambda one: one.t_start)
        surfaces = tuple(one.surface for one in kept)
        if set(surfaces) == expected:
            return asked, kept
        wanted = None
        if self._wanted_for is not None:
            speed = self._speed_before(min(one.t_start for one in kept))
            wanted = self._wanted_for(surfaces, kept[0].kind, speed)
        # The point of a card does not hold for what is flown in its place.
        point = asked.point if asked.wanted is None else None
        return Asked(wanted=wanted, point=point, card=None), kept

    def _speed_before(self, time: float) -> float | None:
        _, rows = self._history.stretch(time - 1.0, time)
        speed = rows[:, SIGNALS.index("V")]
        return float(np.nanmean(speed)) if np.isfinite(speed).any() else None

    def _measured(self, moving: _Moving) -> list[SurfaceInput]:
        """Return what each surface did, the main one first."""
        times, rows = self._history.stretch(moving.first - LOOK_BACK - LOOKED_BACK, self._now)
        lag = self._around.quick.lag
        if times.size <= lag:
            return []
        moves = strong_moves(times, rows, moving.moved, moving.first, moving.last, lag)
        found = moved_inputs(times, rows, moves, self._around.setting)
        return [self._left(one, moves, moving.last, times, rows) for one in found]

    def _left(
        self,
        one: SurfaceInput,
        moves: Mapping[str, tuple[float, float]],
        last: float,
        times: FloatArray,
        rows: FloatArray,
    ) -> SurfaceInput:
        """Return an input that was not brought back as it shows about its trim before."""
        if abs(one.after - one.before) < _LEFT * one.amplitude:
            return one
        noise = self._around.setting.noise.of(one.surface)
        samples = rows[:, SURFACES.index(one.surface)]
        first = moves[one.surface][0]
        other = measure(one.surface, times, samples, first, last, noise, left=True)
        return one if other is None or other.kind not in _CLEAR else other

    def _both_sides(self, moving: _Moving, main: SurfaceInput) -> bool:
        """Return whether a surface truly went to both sides of where it stood before."""
        _, rows = self._history.stretch(main.t_start, moving.last + 0.2)
        away = rows[:, SURFACES.index(main.surface)] - main.before
        if not np.isfinite(away).any():
            return False
        sides = sorted((float(np.nanmax(away)), float(-np.nanmin(away))))
        return sides[0] > _BOTH_SIDES * sides[1]

    def _back(self, moving: _Moving) -> bool:
        """Return whether every moved surface is near where it was before."""
        begin = moving.first - LOOK_BACK
        times, rows = self._history.stretch(begin - 0.5, self._now)
        for surface in moving.moved:
            samples = rows[:, SURFACES.index(surface)]
            early, late = samples[times < begin], samples[times > self._now - 2.0 * TICK]
            if not (np.isfinite(early).any() and np.isfinite(late).any()):
                continue
            level = float(np.nanmedian(early))
            largest = float(np.nanmax(np.abs(samples - level)))
            if abs(float(np.nanmedian(late)) - level) > _BACK * largest:
                return False
        return True

    def _sizes(self, moving: _Moving) -> dict[str, float]:
        """Return how far each surface went so far, rad: half of peak to peak."""
        _, rows = self._history.stretch(moving.first - LOOK_BACK, self._now)
        found = {}
        for surface in moving.moved:
            samples = rows[:, SURFACES.index(surface)]
            if np.isfinite(samples).any():
                found[surface] = 0.5 * float(np.nanmax(samples) - np.nanmin(samples))
        shares = {
            name: size / self._around.setting.half_travel(name) for name, size in found.items()
        }
        most = max(shares.values(), default=0.0)
        return {name: size for name, size in found.items() if shares[name] >= ALSO_MOVED * most}

    def _dismiss(self) -> None:
        """Take what was under way for steering."""
        self._around.dismiss()
        self._moving = None

    # --- the hands ------------------------------------------------------------------------------

    def _watch_hands(self, moving: _Moving) -> None:
        """See whether the hands stayed off for long enough, or are on again."""
        # The last step of a small input may be no quick move.
        last = max(moving.last, moving.t_end - 0.1)
        times, rows = self._history.stretch(last - 0.1, self._now)
        taken = taken_over(times, rows, last, self._around.setting, self._rate)
        wanted_end = moving.t_end + moving.hands_off
        if taken is not None and taken < wanted_end:
            self._conclude(moving, taken)
        elif self._now >= wanted_end:
            self._conclude(moving, wanted_end)

    def _conclude(self, moving: _Moving, t_end: float) -> None:
        """Give the verdict, unless the sticks moved so soon again that it was steering."""
        main = moving.found[0]
        threshold = self._around.quick.thresholds[SURFACES.index(main.surface)]
        if main.returned and not deliberate(main, t_end - moving.t_end, threshold):
            self._dismiss()
            return
        self._around.accept()
        self._moving = None
        measured = measure_input(
            self._history, moving.found, t_end, self._around.setting, self._explainer
        )
        self._verdicts.append(
            give_verdict(
                f"M{len(self._verdicts) + 1}",
                self._now,
                measured,
                moving.asked,
                self._around.setting,
                self._tolerances,
                known_aircraft=self._known_aircraft,
                system=self._system,
            )
        )
        self._busy_until = self._now + _BUSY


def _surfaces(wanted: WantedInput | None) -> tuple[str, ...]:
    return () if wanted is None else wanted.surfaces


def _expected(moving: _Moving) -> tuple[str, ...]:
    return _surfaces(moving.asked.wanted)


def _kind(wanted: WantedInput | None) -> str:
    return "" if wanted is None else wanted.kind


def _complete(main: SurfaceInput, idle: float) -> bool:
    """Return whether an input that ends away from its trim has had all its steps."""
    longest = max(length for _, length in main.runs)
    return main.kind in _CLEAR and idle > max(_AFTER_LAST_STEP, 1.5 * longest + 0.2)


def _steps(main: SurfaceInput, threshold: float) -> bool:
    """Return whether a doublet that was not brought back is one all the same."""
    clear = main.kind in _CLEAR and main.quickest > threshold
    return clear and main.abruptness > 0.5 and main.unrest < main.amplitude


def _usual_aircraft() -> Aircraft:
    """Return what is taken for an aircraft of which nothing is known."""
    return Aircraft.model_validate(
        {
            "name": "unknown",
            "geometry": {"wing_area": "1 m^2", "span": "2.7 m", "chord": "0.43 m"},
            "mass": {
                "mass": "20 kg",
                "ixx": "7 kg*m^2",
                "iyy": "8.5 kg*m^2",
                "izz": "9.5 kg*m^2",
            },
        }
    )
