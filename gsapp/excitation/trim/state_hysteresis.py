"""One state at a time, which does not flicker."""

from __future__ import annotations

from typing import Final

from gsapp.excitation.trim.trim_cue import TrimState

MIN_DWELL_TIME: Final = 0.6
"""Seconds that a state stands at least; GO ends at once when trim is clearly lost."""
STEADY_TIME: Final = 0.4
"""Seconds for which the mean of a second has to be within its tolerances before GO."""
_DOUBT: Final = 0.2
"""Seconds for which another state has to be wanted before it is taken."""
ENTER_RATIO: Final = 0.92
"""Share of the tolerances within which GO is given."""
LEAVE_RATIO: Final = 1.08
"""Share of the tolerances beyond which the aircraft is no longer trimmed, once it was."""
_ROUND_OFF: Final = 1e-6
"""s; sums of ticks are not exact."""


class StateHysteresis:
    """Keeps the state until another one has been wanted for long enough.

    Attributes
    ----------
    state : str
        See `gsapp.excitation.trim.trim_cue.TrimState`.
    since : float
        Flight time, s.
    """

    def __init__(self, state: TrimState, time: float) -> None:
        self.state: TrimState = state
        self.since = time
        self._wish: TrimState = state
        self._wished_since = time

    def step(self, time: float, wanted: TrimState, *, lost: bool) -> bool:
        """Go on to a time; return whether the state changed.

        Parameters
        ----------
        time : float
            Flight time, s.
        wanted : str
            What the state would be at this moment.
        lost : bool
            Whether GO must not stand any longer.
        """
        if wanted != self._wish:
            self._wish, self._wished_since = wanted, time
        if wanted == self.state:
            return False
        at_once = self.state == "go" and lost
        doubt = 0.0 if wanted in ("hold", "go") else _DOUBT
        stood = time - self.since >= MIN_DWELL_TIME - _ROUND_OFF
        sure = time - self._wished_since >= doubt - _ROUND_OFF
        if not at_once and not (stood and sure):
            return False
        self.state, self.since = wanted, time
        return True
