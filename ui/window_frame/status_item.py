"""One part of the bar: words, a number, a state."""

from __future__ import annotations

from dataclasses import dataclass

from ui.icons import IndicatorState
from ui.number_format import DASH


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusItem:
    """What one part of the bar says.

    Attributes
    ----------
    id : str
        Name in code.
    title : str
        What it is about, such as ``LINK``.
    value : str
        The number, or a dash.
    note : str
        What else belongs to it, smaller.
    state : str
        ``plain``, ``good``, ``caution``, ``warning`` or ``unknown`` (hatched).
    detail : str
        The whole in a sentence, for the tool tip and for screen readers.
    width : int
        Points reserved for value and note, so that nothing moves when numbers change.
    hint : str
        What can be done, beside the word where there is room.
    shows_button : bool
        Whether the button beside it is shown.
    stretches : bool
        Whether it takes what is left of the bar, and breaks a long value into two lines.
    """

    id: str
    title: str
    value: str = DASH
    note: str = ""
    state: IndicatorState = "unknown"
    detail: str = ""
    width: int = 96
    hint: str = ""
    shows_button: bool = False
    stretches: bool = False
