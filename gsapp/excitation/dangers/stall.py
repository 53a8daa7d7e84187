"""Stall margin: speed with load factor, and angle of attack.

Limits (`gsapp.session.limits`) alarm at fixed figures of `Vc` and `alpha`, each for itself. They do
not know that a turn stalls earlier, nor which of the two instruments still deserves belief; that is
said here: the least speed grows with the square root of the load factor, and a few tenths of
a second of what comes are added.
"""

from __future__ import annotations

import math
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.excitation.dangers.danger import Urgency
from gsapp.excitation.dangers.frames import FRAME, Frame
from gsapp.excitation.dangers.standing import Finding
from gsapp.excitation.dangers.wording import amount
from gsapp.quantities.constants import GRAVITY

_AHEAD: Final = 0.5
"""Seconds ahead of which is spoken: what the pilot needs to hear and to push."""
_LEAST_LOAD: Final = 0.5
"""Load factors below this do not lower the stall speed any more: it will be pulled again."""
_CAUTION: Final = 1.08
"""Of the stall speed at the present load factor."""
_WARNING: Final = 1.0
"""The same: here it stalls."""
_ALPHA_CALM: Final = 0.93
"""Of the two figures above, where a vane that is believed shows alpha within its linear range: a
gust that loads the wing for a moment is not yet a stall."""
_FAR_FROM_STALL: Final = 1.35
"""Of the least speed; there lift takes little more than half of what the wing can give."""
_ALPHA_SHARE: Final = 0.55
"""Share of the way from the linear range's end to the stall, at which alpha calls for caution."""
_FLAP_GAIN: Final = 0.12
"""Share of the stall speed that full flap takes off: half of what a slotted flap gives."""
_SETTLED: Final = 3.0
"""Seconds after lift-off from which on being slow is no part of the take-off."""
_FRAMES: Final = 2
"""Successive frames: a gust is no stall."""


class StallRoom:
    """Watches the margin in the air.

    Parameters
    ----------
    aircraft : Aircraft or None
        Without stall figures nothing is said.
    """

    def __init__(self, aircraft: Aircraft | None) -> None:
        self._limits = None if aircraft is None else aircraft.limits
        self._full_flap = 0.0 if aircraft is None else aircraft.controls.flap.travel[1]
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._before: float | None = None
        self._slow = {Urgency.CAUTION: 0, Urgency.WARNING: 0}

    def judge(self, frame: Frame, distrusted: frozenset[str], system: str = "US") -> list[Finding]:
        """Return how near the stall is.

        Parameters
        ----------
        frame : Frame
        distrusted : frozenset of str
            Channels that are not believed.
        system : {"US", "SI"}
            Units of the words.
        """
        limits = self._limits
        if limits is None or frame.aloft < _SETTLED or frame.near_ground:
            self.restart()
            return []
        speed, least = self._speeds(frame, distrusted, limits.stall_speed)
        nearness = [
            one
            for one in (
                self._by_speed(frame, speed, least, self._calm(frame, distrusted), system),
                # So fast for its load it cannot be near the stall, whatever a vane shows.
                None
                if speed > _FAR_FROM_STALL * least
                else _by_alpha(frame, distrusted, limits.alpha_linear[1], limits.alpha_stall),
            )
            if one is not None
        ]
        worst = max((each for each, _ in nearness), default=None)
        for urgency, count in self._slow.items():
            beyond = worst is not None and worst >= urgency
            self._slow[urgency] = count + 1 if beyond else 0
        if self._slow[Urgency.WARNING] >= _FRAMES:
            return [_finding(Urgency.WARNING, _words(nearness, Urgency.WARNING))]
        if self._slow[Urgency.CAUTION] >= _FRAMES:
            return [_finding(Urgency.CAUTION, _words(nearness, Urgency.CAUTION))]
        return []

    def _speeds(
        self, frame: Frame, distrusted: frozenset[str], stall_speed: float
    ) -> tuple[float, float]:
        """Return the airspeed and the least one at this load, m/s; NaN where not believed."""
        speed = frame.mean("Vc")
        speed = frame.mean("V") if math.isnan(speed) else speed
        if "V" in distrusted or stall_speed <= 0.0:
            return math.nan, math.nan
        load = frame.mean("an") / GRAVITY
        load = 1.0 if math.isnan(load) or "an" in distrusted else max(load, _LEAST_LOAD)
        flap = frame.mean("flap")
        share = flap / self._full_flap if flap == flap and self._full_flap > 0.0 else 0.0
        flapped = 1.0 - _FLAP_GAIN * min(max(share, 0.0), 1.0)
        return speed, stall_speed * flapped * math.sqrt(load)

    def _calm(self, frame: Frame, distrusted: frozenset[str]) -> float:
        """Return the factor by which a low alpha lowers the speed that calls for attention."""
        alpha = frame.mean("alpha")
        linear = 0.0 if self._limits is None else self._limits.alpha_linear[1]
        return _ALPHA_CALM if "alpha" not in distrusted and alpha < linear else 1.0

    def _by_speed(
        self, frame: Frame, speed: float, least: float, calm: float, system: str
    ) -> tuple[Urgency, str] | None:
        before, self._before = self._before, speed
        if math.isnan(speed):
            return None
        slope = 0.0 if before is None or math.isnan(before) else (speed - before) / FRAME
        coming = speed + _AHEAD * min(slope, 0.0)
        if min(speed, coming) >= _CAUTION * calm * least:
            return None
        urgency = Urgency.WARNING if speed < _WARNING * calm * least else Urgency.CAUTION
        side = "above" if speed > least else "below"
        said = f"{amount('V', abs(speed - least), system)} {side}"
        return urgency, f"{said} the stall speed at {frame.mean('an') / GRAVITY:.1f} g"


def _by_alpha(
    frame: Frame, distrusted: frozenset[str], linear: float, stall: float
) -> tuple[Urgency, str] | None:
    alpha = frame.mean("alpha")
    if "alpha" in distrusted or math.isnan(alpha):
        return None
    if alpha < linear + _ALPHA_SHARE * (stall - linear):
        return None
    urgency = Urgency.WARNING if alpha >= stall else Urgency.CAUTION
    return urgency, f"alpha {math.degrees(alpha):.0f} deg, stall at {math.degrees(stall):.0f}"


def _words(nearness: list[tuple[Urgency, str]], least: Urgency) -> str:
    return " and ".join(words for urgency, words in nearness if urgency >= least)


def _finding(urgency: Urgency, why: str) -> Finding:
    if urgency is Urgency.WARNING:
        return Finding(
            key="stall", urgency=urgency, words=f"Stall: {why}; push", spoken="stall: push"
        )
    return Finding(
        key="stall", urgency=urgency, words=f"Near the stall: {why}; ease the pull", spoken="slow"
    )
