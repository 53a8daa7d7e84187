"""What the crew is told before an input."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.quantities import channel, from_si

TrimState = Literal["blind", "ground", "fly", "hold", "go", "gusty", "turn"]
"""What to do now.

``blind``: too little is measured to judge; ``ground``: the aircraft is not airborne;
``fly``: fly to the test point, what is off is listed;
``hold``: everything is where it should be, keep it there a moment longer; ``go``: make the input;
``gusty``: it would be trimmed in calmer air, wait; ``turn``: in a turn, or the straight leg is
too short for another input.
"""


_WORDS: Final[Mapping[str, tuple[str, str]]] = {
    "bank": ("right wing low", "left wing low"),
    "roll rate": ("rolling right", "rolling left"),
    "pitch rate": ("nose rising", "nose dropping"),
    "yaw rate": ("nose swinging right", "nose swinging left"),
    "turn": ("turning right", "turning left"),
    "speed": ("fast", "slow"),
    "alpha": ("alpha high", "alpha low"),
    "climb": ("climbing", "sinking"),
    "acceleration": ("speeding up", "slowing down"),
    "height": ("high", "low"),
    "unrest": ("rough air", "rough air"),
}
"""What a spotter says of too much and of too little of each quantity."""

_NUMBERED: Final[Mapping[str, tuple[str, ...]]] = {
    "bank": ("phi",),
    "speed": ("V", "Vc"),
    "alpha": ("alpha",),
    "climb": ("climb_rate",),
    "height": ("height",),
}
"""Quantities told with a number, and the channels that earn it: a bank concluded from the turn
rate is not told in degrees, and nobody flies a rate to a number."""

_NUMBER_FIRST: Final = ("speed", "height")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimDeviation:
    """One thing that is not where it should be."""

    quantity: str
    """``bank``, ``roll rate``, ``pitch rate``, ``yaw rate``, ``speed``, ``alpha``, ``climb``,
    ``acceleration`` (the speed changes), ``turn``, ``height``, ``unrest`` (of the air)."""
    amount: float
    """By how much and which way, SI: value minus what is wanted."""
    tolerance_ratio: float
    """``abs(amount)`` over its tolerance; more than 1 is off."""
    channel: str
    """Of the vocabulary, for units and digits."""

    def format_text(self, system: str = "US") -> str:
        """Return what a spotter says: "3 ft/s slow", "left wing low 6 deg", "nose dropping".

        Parameters
        ----------
        system : {"US", "SI"}
        """
        words = _WORDS[self.quantity][0 if self.amount > 0.0 else 1]
        if self.channel not in _NUMBERED.get(self.quantity, ()):
            return words
        spec = channel(self.channel)
        unit = spec.display_unit(system)
        size = abs(from_si(self.amount, unit, spec.quantity))
        # Nobody flies to a tenth: one is told only where a whole unit is much.
        digits = 0 if size >= 2.0 else min(spec.decimals(unit), 1)
        number = f"{size:.{digits}f} {unit}"
        return f"{number} {words}" if self.quantity in _NUMBER_FIRST else f"{words} {number}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimCue:
    """The cue at one moment."""

    time: float
    """Flight time, s."""
    state: TrimState
    """See `TrimState`."""
    since: float
    """Flight time since which this state stands, s."""
    deviations: tuple[TrimDeviation, ...] = ()
    """The worst first; those beyond their tolerance come before the others. Empty while blind."""
    judged_by: tuple[str, ...] = ()
    """By what each thing is judged, in words: "wings: rates and lateral acceleration, for want of
    attitude"."""
    limitations: tuple[str, ...] = ()
    """What cannot be judged, in words."""
    gust_strength: float | None = None
    """Strength of the gusts, m/s; None where it cannot be told."""
    leg_time_left: float | None = None
    """Seconds of the straight leg that are left; None where unknown."""
    progress: float = 0.0
    """0 to 1: how much of the steady time that GO takes has passed."""

    @property
    def worst(self) -> TrimDeviation | None:
        """Return what is off most; None if nothing is beyond its tolerance."""
        return (
            self.deviations[0]
            if self.deviations and self.deviations[0].tolerance_ratio > 1.0
            else None
        )
