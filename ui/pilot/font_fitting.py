"""The largest letters in which a text fits into a box."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QFont, QFontMetricsF

from ui.fonts import sans_serif_font

_MIN_STRETCH: Final = 72
"""Percent of their width to which letters are narrowed before they become lower."""
_STRETCH_STEP: Final = 4
"""Percent of width from one try to the next."""
_UNLIMITED_SIZE: Final = 100_000
"""Pixels: more than any text takes."""
_CACHE_SIZE: Final = 512
"""Texts of which the fitting font is kept."""


def create_font(pixels: int, *, bold: bool = False, stretch: int = 100) -> QFont:
    """Return the window's font, narrowed to a percentage of its width."""
    font = sans_serif_font(pixels, bold=bold)
    if stretch != 100:
        font.setStretch(stretch)
    return font


def fit_font(
    text: str, box: QRectF, largest: int, least: int, *, bold: bool = False, wrap: bool = False
) -> QFont:
    """Return the font for a text in a box.

    Parameters
    ----------
    largest, least : int
        Pixels between which it lies. What does not fit in the least is narrowed, and fits or not.
    """
    pixels, stretch = _fit_font_size(
        text, int(box.width()), int(box.height()), largest, least, bold=bold, wrap=wrap
    )
    return create_font(pixels, bold=bold, stretch=stretch)


@lru_cache(maxsize=_CACHE_SIZE)
def _fit_font_size(
    text: str, wide: int, high: int, largest: int, least: int, *, bold: bool, wrap: bool
) -> tuple[int, int]:
    """Return pixels and stretch; a page asks for the same again and again."""
    flags = Qt.TextFlag.TextWordWrap if wrap else Qt.TextFlag.TextSingleLine

    def fits(pixels: int, stretch: int) -> bool:
        metrics = QFontMetricsF(create_font(pixels, bold=bold, stretch=stretch))
        room = QRectF(0, 0, wide if wrap else _UNLIMITED_SIZE, _UNLIMITED_SIZE)
        taken = metrics.boundingRect(room, flags, text)
        return taken.width() <= wide and taken.height() <= high

    low, top = least, max(largest, least)
    if not wrap:
        # One line is first as high as the box lets it be, then narrowed, then made lower.
        while top > low and QFontMetricsF(create_font(top, bold=bold)).height() > high:
            top -= 1
        for stretch in range(100, _MIN_STRETCH - 1, -_STRETCH_STEP):
            if fits(top, stretch):
                return top, stretch
    stretch = 100 if wrap else _MIN_STRETCH
    while low < top:
        middle = (low + top + 1) // 2
        low, top = (middle, top) if fits(middle, stretch) else (low, middle - 1)
    if wrap and not fits(low, 100):
        return low, _MIN_STRETCH
    return low, stretch


def elide_text(text: str, box: QRectF, pixels: int) -> str:
    """Return as many words as several lines of a box hold at a size, with an ellipsis for more."""
    return _elide_text_cached(text, int(box.width()), int(box.height()), pixels)


@lru_cache(maxsize=_CACHE_SIZE)
def _elide_text_cached(text: str, wide: int, high: int, pixels: int) -> str:
    metrics = QFontMetricsF(create_font(pixels))
    room = QRectF(0, 0, wide, _UNLIMITED_SIZE)
    words = text.split(" ")

    def taken(count: int) -> str:
        return text if count == len(words) else f"{' '.join(words[:count])} …"

    low, top = 0, len(words)
    while low < top:
        middle = (low + top + 1) // 2
        needed = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, taken(middle))
        fits = needed.width() <= wide and needed.height() <= high
        low, top = (middle, top) if fits else (low, middle - 1)
    return taken(low)
