"""What the crew is told before an input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

TrimState = Literal["blind", "fly", "hold", "go", "gusty", "turn"]
"""What to do now.

``blind``: too little is measured to judge; ``fly``: fly to the test point, what is off is listed;
``hold``: everything is where it should be, keep it there a moment longer; ``go``: make the input;
``gusty``: it would be trimmed in calmer air, wait; ``turn``: in a turn, or the straight leg is
too short for another input.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Off:
    """One thing that is not where it should be.

    Attributes
    ----------
    quantity : str
        ``bank``, ``roll rate``, ``pitch rate``, ``yaw rate``, ``speed``, ``alpha``, ``climb``,
        ``acceleration`` (the speed changes), ``turn``, ``height`` ...
    amount : float
        By how much and which way, SI: value minus what is wanted.
    share : float
        ``abs(amount)`` over its tolerance; more than 1 is off.
    channel : str
        Of the vocabulary, for units and digits.
    """

    quantity: str
    amount: float
    share: float
    channel: str

    def words(self, system: str = "US") -> str:
        """Return what a spotter says: "3 ft/s slow", "left wing low"."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimCue:
    """The cue at one moment.

    Attributes
    ----------
    time : float
        Flight time, s.
    state : str
        See `TrimState`.
    since : float
        Flight time since which this state stands, s.
    off : tuple of Off
        The worst first; those beyond their tolerance come before the others. Empty while blind.
    judged_by : tuple of str
        By what each thing is judged, in words: "wings: rates and lateral acceleration, for want
        of attitude".
    missing : tuple of str
        What cannot be judged, in words.
    gusts : float or None
        Strength of the gusts, m/s; None where it cannot be told.
    leg_left : float or None
        Seconds of the straight leg that are left; None where unknown.
    progress : float
        0 to 1: how much of the steady time that GO takes has passed.
    """

    time: float
    state: TrimState
    since: float
    off: tuple[Off, ...] = ()
    judged_by: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    gusts: float | None = None
    leg_left: float | None = None
    progress: float = 0.0

    @property
    def worst(self) -> Off | None:
        """Return what is off most; None if nothing is beyond its tolerance."""
        return self.off[0] if self.off and self.off[0].share > 1.0 else None
