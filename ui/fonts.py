"""The one sans-serif family of the window, with figures of equal width."""

from __future__ import annotations

from functools import cache

from PySide6.QtGui import QFont, QFontDatabase, QFontMetricsF

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
