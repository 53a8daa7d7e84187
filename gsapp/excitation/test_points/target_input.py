"""How large and how long an input should be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class ToleranceBand:
    """A wanted value with the room around it."""

    low: float
    best: float
    high: float
    why_low: str = ""
    why_high: str = ""
    """What sets each end, in words: "the pitch rate must stand out of its noise ten times", "alpha
    leaves its linear range"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetInput:
    """The input wanted at a test point."""

    surfaces: tuple[str, ...]
    """``de``, ``da``, ``dr`` in the order in which they are moved."""
    kind: str
    """Shape of each input."""
    amplitudes: Mapping[str, ToleranceBand]
    """Half of peak to peak by surface, rad; a surface of which nothing is known is absent."""
    width: ToleranceBand
    """Of one step, s."""
    hands_off: float
    """Two periods of the slowest oscillation that the input excites (phugoid and spiral, which no
    straight leg is long enough for, are not meant), s."""
    mode: str
    """Which oscillation sets `hands_off` and `width`: ``short period``, ``dutch roll``,
    ``roll``."""
    source: Literal["card", "model", "flight", "usual"]
    """Where it comes from; ``flight`` once derivatives estimated in this flight replaced those of
    the model, ``usual`` where no model flies there."""
