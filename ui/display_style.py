"""How everything looks now: theme, scale, units, fonts. One object that all widgets share."""

from __future__ import annotations

from functools import cache
from typing import Literal

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontMetricsF

from ui.icons import IndicatorState
from ui.theme import THEMES, Theme, compute_sizes

TextRole = Literal["body", "label", "small", "value", "title"]
_TYPE = {"body": 13, "label": 11, "small": 10, "value": 18, "title": 22}
SCALE_STEPS = (100, 110, 125, 150, 175, 200, 225, 250)  # Steps of the scale, percent.


# The systems' own faces first, then the free ones that Linux distributions carry.
_PREFERRED = (
    ".AppleSystemUIFont",
    "SF Pro Text",
    "Segoe UI Variable Text",
    "Segoe UI",
    "Inter",
    "Adwaita Sans",
    "Cantarell",
    "Noto Sans",
    "Ubuntu",
    "Roboto",
    "Liberation Sans",
    "DejaVu Sans",
)


def has_tabular_figures(font: QFont) -> bool:
    """Return whether all ten figures of a font are equally wide."""
    metrics = QFontMetricsF(font)
    return len({round(metrics.horizontalAdvance(figure), 3) for figure in "0123456789"}) == 1


@cache
def font_family() -> str:
    """Return the family in use: the system's own if its figures can be made tabular."""
    system = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont).family()
    known = set(QFontDatabase.families())
    candidates = [name for name in _PREFERRED if name in known]
    # Fontconfig's aliases ("Sans Serif") stand for whatever is there; a real name is steadier.
    if system and system not in ("Sans Serif", "Sans"):
        candidates.insert(0, system)
    candidates.append(system)
    for name in candidates:
        if has_tabular_figures(_create_font(name, 16)):
            return name
    return candidates[0]


def _create_font(name: str, pixels: int) -> QFont:
    font = QFont(name)
    font.setPixelSize(max(pixels, 1))
    font.setFeature(QFont.Tag("tnum"), 1)
    return font


def sans_serif_font(pixels: int, *, bold: bool = False, italic: bool = False) -> QFont:
    """Return the window's font at a size in logical pixels, with tabular figures."""
    font = _create_font(font_family(), pixels)
    font.setWeight(QFont.Weight.DemiBold if bold else QFont.Weight.Normal)
    font.setItalic(italic)
    return font


def mix_colors(one: str, other: str, share: float) -> QColor:
    """Return a color between two, `share` of the way to the second."""
    first, second = QColor(one), QColor(other)
    return QColor.fromRgbF(
        *(
            a + (b - a) * share
            for a, b in (
                (first.redF(), second.redF()),
                (first.greenF(), second.greenF()),
                (first.blueF(), second.blueF()),
            )
        )
    )


class DisplayStyle(QObject):
    """Theme, scale and units, with a signal when one of them changes.

    `theme`: name of a theme; an unknown one is taken for daylight.
    """

    changed = Signal()  # Theme, scale or units are others now.

    def __init__(self, theme: str = "daylight", scale: int = 100, units: str = "US") -> None:
        super().__init__()
        self.theme: Theme = THEMES.get(theme, THEMES["daylight"])
        self.scale = scale
        self.units = units
        self.sizes = compute_sizes(scale / 100)

    def set_theme(self, name: str) -> None:
        if name in THEMES and name != self.theme.name:
            self.theme = THEMES[name]
            self.changed.emit()

    def set_scale(self, percent: int) -> None:
        """Take another scale, held within 100 to 250 %."""
        percent = min(max(percent, SCALE_STEPS[0]), SCALE_STEPS[-1])
        if percent != self.scale:
            self.scale = percent
            self.sizes = compute_sizes(percent / 100)
            self.changed.emit()

    def set_units(self, units: str) -> None:
        if units != self.units:
            self.units = units
            self.changed.emit()

    def px(self, points: float) -> int:
        """Return points of the design in logical pixels at this scale."""
        return round(points * self.sizes.scale)

    def font(self, role: TextRole, *, strong: bool = False, italic: bool = False) -> QFont:
        return sans_serif_font(self.px(_TYPE[role]), bold=strong, italic=italic)

    def color(self, role: str) -> QColor:
        """Return a color: a field of the theme, or one of the frame's own, made from these.

        ``accent`` is for what can be pressed and where the keyboard is: ink, since every hue
        already means something.
        """
        theme = self.theme
        if role == "accent":
            return QColor(theme.selection)
        if role == "panel":
            return QColor(theme.plot)
        if role == "line":
            return mix_colors(theme.background, theme.text, 0.16)
        if role == "hover":
            return mix_colors(theme.background, theme.text, 0.06)
        if role == "chosen":
            return mix_colors(theme.background, theme.text, 0.11)
        if role == "pressed":
            return mix_colors(theme.background, theme.text, 0.18)
        return QColor(getattr(theme, role))

    def state_color(self, state: IndicatorState) -> QColor:
        """Return the color of a state, for its sign and its words."""
        role = {"plain": "text", "unknown": "muted"}.get(state, state)
        return self.color(role)
