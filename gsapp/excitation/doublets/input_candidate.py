"""Quick moves that may be an input, while that is open."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gsapp.excitation.doublets.input_evaluation import InputRequest
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.maneuver_grade import MIN_FREE_RESPONSE_TIME


@dataclass(slots=True)
class InputCandidate:
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
    asked : InputRequest
        What the input is held against, once it is known.
    hands_off : float
        Seconds for which the hands should be off.
    former : list of SurfaceInput
        What was found before the sticks moved again so soon that it seemed to go on; empty for
        nothing.
    again : float
        When they did, s.
    sure : bool
        Whether it was what had been expected, so that nothing that follows makes it steering.
    """

    first: float
    last: float
    busy: bool
    moved: list[str] = field(default_factory=list)
    found: list[SurfaceInput] = field(default_factory=list)
    t_end: float = math.nan
    asked: InputRequest = field(default_factory=InputRequest)
    hands_off: float = MIN_FREE_RESPONSE_TIME
    former: list[SurfaceInput] = field(default_factory=list)
    again: float = math.nan
    sure: bool = False

    @property
    def expected(self) -> set[str]:
        """Return the surfaces that the crew expects to be moved."""
        return set() if self.asked.wanted is None else set(self.asked.wanted.surfaces)

    @property
    def awaited(self) -> set[str]:
        """Return the surfaces expected that have not moved yet."""
        return self.expected - set(self.moved)

    @property
    def kind(self) -> str:
        """Return the shape expected; empty for none."""
        return "" if self.asked.wanted is None else self.asked.wanted.kind
