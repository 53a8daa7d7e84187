"""Three themes, the type sizes, and the scale: everything that decides how the window looks.

Green, amber and red speak of state and of nothing else; cyan is a target. Traces begin from the
Okabe-Ito set, without its orange and green (they would be mistaken for amber and green states).
Hue and lightness are moved until a trace's color is readable as text on that theme's background,
and until traces and states are told apart by all kinds of color vision: `tests.ui.test_colors`
simulates protanopia, deuteranopia and tritanopia. The colors are those nearest to the set before
that reach these distances. A shape or a word says each state, too. Plain data, no Qt.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from gsapp.quantities import TRACE_COLORS

MINIMUM_SCALE, MAXIMUM_SCALE = 1.0, 2.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """Colors (``#rrggbb``) and line weight of one theme."""

    name: str  # ``daylight``, ``dark`` or ``high-contrast``.
    # Behind everything; behind the traces.
    background: str
    plot: str
    # What is read; what is read second (units, tick labels).
    text: str
    muted: str
    # Faint grid; frames and tick marks.
    grid: str
    axis: str
    # State as text or as a line: within limits, caution, warning.
    good: str
    caution: str
    warning: str
    # State as an area behind the traces.
    caution_band: str
    warning_band: str
    # State as a filled label with its text.
    good_fill: str
    caution_fill: str
    warning_fill: str
    fill_text: str
    target: str  # What is wanted: test point, wanted band.
    # Areas behind the traces: a maneuver; any other labeled span.
    span: str
    event: str
    span_edge: str  # Borders of spans, and marks.
    # The cursor and the two that measure differences.
    cursor: str
    cursor_a: str
    cursor_b: str
    previous: str  # Traces of earlier results.
    selection: str  # The chosen chart.
    # Across the top while the display is paused.
    banner: str
    banner_text: str
    traces: Mapping[str, str]  # One color for each name of `TRACE_COLORS`.
    line_width: float  # Of a trace, in points at 100 %.

    def trace(self, name: str) -> str:
        """Return the color of that name, or of ``previous``."""
        return self.previous if name == "previous" else self.traces[name]

    def colors(self) -> Iterator[tuple[str, str]]:
        """Yield every color with its name, traces as ``traces.blue``."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, str) and value.startswith("#"):
                yield field.name, value
        for name, value in self.traces.items():
            yield f"traces.{name}", value


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Sizes in logical pixels at a scale: type, the 8-point grid, controls."""

    scale: float  # 1.0 to 2.5.
    # Type: sentences, labels, current values, what the pilot reads from afar.
    body: int
    label: int
    value: int
    cue: int
    unit: int  # The grid's step.
    control: int  # Least height of what is pressed with gloves.


def compute_sizes(scale: float) -> Sizes:
    """Return the sizes at `scale`, held within 100 to 250 %."""
    held = min(max(float(scale), MINIMUM_SCALE), MAXIMUM_SCALE)
    return Sizes(
        scale=held,
        body=round(13 * held),
        label=round(11 * held),
        value=round(18 * held),
        cue=round(72 * held),
        unit=round(8 * held),
        control=round(44 * held),
    )


def luminance(color: str) -> float:
    """Return the relative luminance of ``#rrggbb``, 0 to 1 (WCAG 2.2)."""
    channels = (int(color[index : index + 2], 16) / 255.0 for index in (1, 3, 5))
    red, green, blue = (
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
        for value in channels
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colors, 1 to 21 (WCAG 2.2)."""
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


_COLORS: Mapping[str, tuple[str, str, str]] = {
    "background": ("#f3f5f7", "#101418", "#000000"),
    "plot": ("#ffffff", "#161b21", "#000000"),
    "text": ("#10161c", "#e8edf2", "#ffffff"),
    "muted": ("#434d57", "#9fabb8", "#dadada"),
    "grid": ("#e3e8ec", "#252d36", "#2e2e2e"),
    "axis": ("#a9b4be", "#4b5764", "#a0a0a0"),
    "good": ("#045f2f", "#41df8a", "#4cff9a"),
    "caution": ("#693f01", "#ffb52e", "#ffc400"),
    "warning": ("#6b0614", "#f97268", "#ff8a85"),
    "caution_band": ("#ffefc4", "#362b13", "#3d3000"),
    "warning_band": ("#ffe4e2", "#3f1b1d", "#400c0c"),
    "good_fill": ("#07ca96", "#0ac28b", "#5fff9d"),
    "caution_fill": ("#ffb20e", "#ffb000", "#ffc400"),
    "warning_fill": ("#ff7a70", "#ff6f66", "#ff7a75"),
    "fill_text": ("#0b0f13", "#0b0f13", "#000000"),
    "target": ("#11444d", "#3ef1ff", "#4dd6e3"),
    "span": ("#e6ecf6", "#1f2a3a", "#16233d"),
    "event": ("#e5e0e7", "#211c2e", "#1f1134"),
    "span_edge": ("#66788c", "#6f8299", "#b8c8dc"),
    "cursor": ("#10161c", "#e8edf2", "#ffffff"),
    "cursor_a": ("#8a2465", "#e59bc8", "#ffa3d6"),
    "cursor_b": ("#004a94", "#7db9ff", "#8ac6ff"),
    "previous": ("#8d98a3", "#6c7885", "#9a9a9a"),
    "selection": ("#10161c", "#e8edf2", "#ffffff"),
    "banner": ("#10161c", "#e8edf2", "#ffffff"),
    "banner_text": ("#ffffff", "#101418", "#000000"),
}
"""Of daylight, dark and high contrast, by role."""


def _create_theme(index: int, name: str, traces: str, line_width: float) -> Theme:
    return Theme(
        name=name,
        traces=MappingProxyType(dict(zip(TRACE_COLORS, traces.split(), strict=True))),
        line_width=line_width,
        **{role: colors[index] for role, colors in _COLORS.items()},
    )


DAYLIGHT = _create_theme(0, "daylight", "#0147c5 #680949 #843600 #10161c #1e556f #332a00", 2.0)
DARK = _create_theme(1, "dark", "#74b6ff #e4a5cb #ee9967 #eef2f6 #a8dbf9 #e6dc6a", 2.0)
HIGH_CONTRAST = _create_theme(
    2, "high-contrast", "#7cc2fe #f992c6 #ffc298 #ffffff #b5e4ff #fff04d", 3.0
)

THEMES: Mapping[str, Theme] = MappingProxyType(
    {theme.name: theme for theme in (DAYLIGHT, DARK, HIGH_CONTRAST)}
)
"""The themes by name."""


def theme_title(name: str) -> str:
    """Return what a theme is called on screen."""
    return name.replace("-", " ").capitalize()
