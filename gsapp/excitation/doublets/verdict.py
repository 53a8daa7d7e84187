"""What is said of an input: while it happens, and when it is over."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from gsapp.flight.maneuvers.detected_maneuver import Grade

VerdictResult = Literal[
    "good", "too-small", "too-large", "too-fast", "too-slow", "not-trimmed", "invalid", "unclear"
]
"""``unclear``: too little was measured to judge, or the input was cut short by a gap."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputInProgress:
    """An input that is being made, or its answer awaited."""

    time: float
    """Flight time of what is said here, s."""
    phase: Literal["moving", "hands-off"]
    surfaces: tuple[str, ...]
    """Moved on purpose so far."""
    t_input: float
    """When it began, s."""
    amplitudes: Mapping[str, float]
    """Reached so far by surface: half of peak to peak, rad."""
    hands_off_left: float
    hands_off_total: float
    """Seconds; what is left counts down while `phase` is ``hands-off``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputFinding:
    """One thing that speaks against an input."""

    result: VerdictResult
    """Which verdict it calls for."""
    words: str
    """In words: "rudder doublet too small: 50 % larger"."""
    surface: str = ""
    """The surface that it is about; empty for none."""
    factor: float | None = None
    """By what the amplitude, or the width, should be multiplied next time."""
    channel: str = ""
    """The sensor that clipped, or the state that left its linear range; empty for none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputVerdict:
    """The verdict on an input."""

    id: str
    """Of the maneuver, ``M7``: counted through the flight."""
    given_at: float
    """Flight time at which the verdict was reached, s."""
    t_start: float
    t_input: float
    t_input_end: float
    t_end: float
    """The second of trim before it, the input, the end of its hands-off interval; s."""
    surfaces: tuple[str, ...]
    """In the order in which they were moved."""
    kind: str
    """``doublet``, ``3-2-1-1``, ``pulse``, ``multistep``."""
    amplitudes: Mapping[str, float]
    """Half of peak to peak by surface, rad."""
    halves: Mapping[str, tuple[float, ...]]
    """Duration of each step by surface, s."""
    symmetry: Mapping[str, float]
    """Smaller over larger half of a doublet by area, 0 to 1."""
    left_over: Mapping[str, float]
    """How far each moved surface stayed from where it began, share of its amplitude."""
    cross: Mapping[str, float]
    """Surfaces moved that should not, rad."""
    V: float | None
    alpha: float | None
    """Before the input, m/s and rad."""
    result: VerdictResult
    """The first of the findings, or ``good``."""
    findings: tuple[InputFinding, ...]
    """The worst first."""
    advice: str
    """What to do next time, or "good", one short sentence to be spoken."""
    card: str = ""
    """Id of the test card that it was flown for; empty for none."""
    counts: bool = False
    """Whether it is one of the repeats that the card asks for."""
    judged_by: tuple[str, ...] = ()
    """What could not be judged, and why, in words."""
    grade: Grade | None = None
    """How good it is for estimates: A or B if it is good, B at best if it is not. None in debriefs
    that were kept before there was one."""
