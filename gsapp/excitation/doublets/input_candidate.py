"""Quick moves that may be an input, while that is open."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gsapp.excitation.doublets.input_evaluation import InputRequest
from gsapp.flight.maneuvers.input_measures import MIN_FREE_RESPONSE_TIME
from gsapp.flight.maneuvers.input_shape import SurfaceInput


@dataclass(slots=True)
class InputCandidate:
    """Quick moves that may be an input.

    Attributes
    ----------
    first_move_time, last_move_time : float
        Time of the first and of the last quick move, s.
    surfaces : list of str
        Surfaces in the order of their first quick move.
    began_in_recovery : bool
        Whether the pilot was recovering when it began.
    inputs : list of SurfaceInput
        Measured when the sticks were let go; empty before.
    t_end : float
        When the last surface was back, s.
    request : InputRequest
        What the input is held against, once it is known.
    hands_off : float
        Seconds for which the hands should be off.
    previous_inputs : list of SurfaceInput
        What was found before the sticks moved again so soon that it seemed to go on; empty for
        nothing.
    resume_time : float
        When they did, s.
    is_confirmed : bool
        Whether it was what had been expected, so that nothing that follows makes it steering.
    """

    first_move_time: float
    last_move_time: float
    began_in_recovery: bool
    surfaces: list[str] = field(default_factory=list)
    inputs: list[SurfaceInput] = field(default_factory=list)
    t_end: float = math.nan
    request: InputRequest = field(default_factory=InputRequest)
    hands_off: float = MIN_FREE_RESPONSE_TIME
    previous_inputs: list[SurfaceInput] = field(default_factory=list)
    resume_time: float = math.nan
    is_confirmed: bool = False

    @property
    def expected_surfaces(self) -> set[str]:
        """Return the surfaces that the crew expects to be moved."""
        return (
            set() if self.request.target_input is None else set(self.request.target_input.surfaces)
        )

    @property
    def pending_surfaces(self) -> set[str]:
        """Return the surfaces expected that have not moved yet."""
        return self.expected_surfaces - set(self.surfaces)

    @property
    def expected_kind(self) -> str:
        """Return the shape expected; empty for none."""
        return "" if self.request.target_input is None else self.request.target_input.kind
