"""Strip charts: many channels over one time axis, live and scrolled back."""

from ui.strips.furniture import Mark, Span
from ui.strips.keys import KEY_ACTIONS, KeyAction
from ui.strips.layout import (
    Strip,
    StripGroup,
    StripLayout,
    Trace,
    default_layout,
    load_layout,
    save_layout,
)
from ui.strips.view import StripView
from ui.strips.widget import StripChart

__all__ = [
    "KEY_ACTIONS",
    "KeyAction",
    "Mark",
    "Span",
    "Strip",
    "StripChart",
    "StripGroup",
    "StripLayout",
    "StripView",
    "Trace",
    "default_layout",
    "load_layout",
    "save_layout",
]
