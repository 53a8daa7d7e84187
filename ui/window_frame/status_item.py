"""One part of the bar: words, a number, a state."""

from __future__ import annotations

from dataclasses import dataclass

from ui.icons import IndicatorState
from ui.number_format import DASH


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusItem:
    """What one part of the bar says."""

    id: str  # Name in code.
    title: str  # What it is about, such as ``LINK``.
    value: str = DASH  # The number, or a dash.
    note: str = ""  # What else belongs to it, smaller.
    # ``plain``, ``good``, ``caution``, ``warning`` or ``unknown`` (hatched).
    state: IndicatorState = "unknown"
    detail: str = ""  # The whole in a sentence, for the tool tip and for screen readers.
    # Points reserved for value and note, so that nothing moves when numbers change.
    width: int = 96
    hint: str = ""  # What can be done, beside the word where there is room.
    shows_button: bool = False  # Whether the button beside it is shown.
    # Whether it takes what is left of the bar, and breaks a long value into two lines.
    stretches: bool = False
