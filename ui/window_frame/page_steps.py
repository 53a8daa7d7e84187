"""Steps that a place leads through, and what is said of each at a glance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ui.icons import IndicatorState


@dataclass(frozen=True, slots=True, kw_only=True)
class PageStep:
    """One step: its name, and what is done there."""

    id: str
    title: str
    purpose: str


@dataclass(frozen=True, slots=True, kw_only=True)
class StepStatus:
    """How a step stands."""

    state: IndicatorState = "unknown"  # Sign and color; the words say it too.
    text: str = ""  # A few words: ``2 not green``.
    detail: str = ""  # The whole of it, for the tool tip.
