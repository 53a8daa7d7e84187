"""A breath into the pitot, which shows that the pitot answers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy.typing as npt

from calibration.certificate import Certificate
from calibration.pressures.settings import PRESSURES
from calibration.sample_segments import SampleSegment, SampleSegmenter

PitotBlowState = Literal["waiting", "blowing", "green", "reversed", "blocked", "leaking"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PitotBlowStatus:
    """How a breath into the pitot goes on."""

    state: PitotBlowState
    """``green`` once a breath was seen and has gone again, and stays. ``reversed``: the pressure
    fell. ``blocked``: it does not go back. ``leaking``: the static pressure rose with it."""
    pressure: float
    peak: float
    """Now, and the highest of the breath, Pa."""
    sentence: str
    """For the crew; empty while there is nothing to say."""


_SENTENCES: Mapping[PitotBlowState, str] = {
    "waiting": "Blow gently into the pitot.",
    "blowing": "",
    "green": "Pitot OK.",
    "reversed": "The pressure falls when you blow: the hoses of pitot and static are swapped.",
    "blocked": "The pressure remains after the breath: check the hose for water or a kink.",
    "leaking": "The static pressure rises with the breath: a hose leaks, or two are swapped.",
}


class PitotBlowDetector:
    """Goes green by itself when somebody blows into the pitot.

    Judged in means of a twentieth of a second, counted from time zero: the result does not depend
    on how the samples were cut.

    Parameters
    ----------
    dynamic : Certificate
        With today's zero: `PressureZero.certificate`.
    static : Certificate, optional
        To find hoses that are swapped or leak.
    """

    def __init__(self, dynamic: Certificate, static: Certificate | None = None) -> None:
        self._curves = tuple(c for c in (dynamic, static) if c is not None)
        self._cutter = SampleSegmenter([c.channel for c in self._curves], PRESSURES.averaging)
        self.restart()

    def restart(self) -> None:
        """Wait for another breath."""
        self._cutter.restart()
        self._state: PitotBlowState = "waiting"
        self._pressure = self._peak = math.nan
        self._began = self._sucked = self._calm = math.nan
        self._level = self._static_before = self._static_rise = math.nan

    def feed(self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]) -> None:
        for stretch in self._cutter.feed(times, volts):
            self._judge(stretch)

    @property
    def status(self) -> PitotBlowStatus:
        """Return how it goes on."""
        return PitotBlowStatus(
            state=self._state,
            pressure=self._pressure,
            peak=self._peak,
            sentence=_SENTENCES[self._state],
        )

    def _judge(self, stretch: SampleSegment) -> None:
        time = stretch.number * PRESSURES.averaging
        pressures = [
            float(curve.evaluate(volts))
            for curve, volts in zip(self._curves, stretch.mean, strict=True)
        ]
        if math.isnan(pressures[0]):
            return
        self._pressure = pressures[0]
        static = pressures[1] if len(pressures) > 1 else math.nan
        if self._state in ("waiting", "reversed"):
            self._await_breath(time, static)
        elif self._state in ("blowing", "blocked", "leaking"):
            self._follow_breath(time, static)

    def _await_breath(self, time: float, static: float) -> None:
        if self._pressure > PRESSURES.blow_pressure:
            self._state, self._began, self._peak = "blowing", time, self._pressure
            self._level = 0.0 if math.isnan(self._level) else self._level
            self._static_rise, self._calm = 0.0, math.nan
            return
        if self._pressure < -PRESSURES.suction_pressure:
            self._sucked = time if math.isnan(self._sucked) else self._sucked
            if time - self._sucked >= PRESSURES.min_duration:
                self._state = "reversed"
            return
        self._sucked = math.nan
        self._level = _track_baseline(self._level, self._pressure)
        self._static_before = _track_baseline(self._static_before, static)

    def _follow_breath(self, time: float, static: float) -> None:
        self._peak = max(self._peak, self._pressure)
        if not math.isnan(static) and not math.isnan(self._static_before):
            self._static_rise = max(self._static_rise, static - self._static_before)
        if self._pressure < PRESSURES.blow_pressure and math.isnan(self._calm):
            self._calm = time
        if self._pressure >= PRESSURES.blow_pressure:
            self._calm = math.nan
        if self._pressure > self._level + PRESSURES.end_pressure:
            if self._state == "blowing" and time - self._began > PRESSURES.blocked_time:
                self._state = "blocked"
            return
        lasted = (time if math.isnan(self._calm) else self._calm) - self._began
        if lasted < PRESSURES.min_duration:
            self._state, self._peak = "waiting", math.nan
        elif self._static_rise > PRESSURES.max_static_change:
            self._state = "leaking"
        else:
            self._state = "green"


def _track_baseline(before: float, now: float) -> float:
    return now if math.isnan(before) else before + 0.1 * (now - before)
