"""Where everything stands on the page, and the largest letters that fit there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QFont, QFontMetricsF

from ui.display_style import sans_serif_font

_ROW_SHARES: Final = (0.33, 0.24, 0.18, 0.2, 0.05)
"""Shares of the height: state, hints, gauges, card, small line."""
_SIGN_SHARE: Final = 0.19
"""Share of the width for seconds of leg and for time left, on the right."""
_MARGIN: Final = 0.016
"""Share of the width that is left free around everything."""
SMALL_FONT_SIZE: Final = 11
"""Pixels of the small line's letters, at least; times the scale of the window."""
_MIN_TITLE_SIZE: Final = 15
"""Pixels of the letters of titles, at least; times the scale of the window."""
_LINE_SPACING: Final = 1.25
"""Room for a line of letters, times their height."""
_MAX_TITLE_SHARE: Final = 0.36
"""Share of its box that a title takes at most."""
_FIRST_HINT_SHARE: Final = 0.6
"""Share of their row that the first of two hints takes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageRegions:
    """Boxes of the page, pixels; no `footer` where it has no room for a line of the small letters,
    and how high a title is at least."""  # noqa: D205, D209

    state: QRectF
    sign: QRectF
    word: QRectF
    hints: QRectF
    gauges: QRectF
    leg: QRectF
    card: QRectF
    time: QRectF
    footer: QRectF | None
    min_title_height: float

    def split_title(self, box: QRectF, share: float) -> tuple[QRectF, QRectF]:
        """Return the strip on top of a box for its title, `share` of its height, and the rest."""
        high = box.height()
        strip = min(max(share * high, self.min_title_height), _MAX_TITLE_SHARE * high)
        return box.adjusted(0, 0, 0, strip - high), box.adjusted(0, strip, 0, 0)

    def hint_boxes(self, count: int) -> tuple[QRectF, ...]:
        box = self.hints
        if count < 2:
            return (box,)
        first = _FIRST_HINT_SHARE * box.height()
        return (
            QRectF(box.left(), box.top(), box.width(), first),
            QRectF(box.left(), box.top() + first, box.width(), box.height() - first),
        )

    def gauge_boxes(self, count: int) -> tuple[QRectF, ...]:
        box, gap = self.gauges, _MARGIN * self.state.width()
        if count < 1:
            return ()
        wide = (box.width() - gap * (count - 1)) / count
        return tuple(
            QRectF(box.left() + place * (wide + gap), box.top(), wide, box.height())
            for place in range(count)
        )


def compute_regions(width: float, height: float, scale: float) -> PageRegions:
    """Return the boxes of a page of this size, with letters of this scale."""
    gap = _MARGIN * min(width, 1.6 * height)
    inner = QRectF(gap, gap, width - 2 * gap, height - 2 * gap)
    free = inner.height() - gap * (len(_ROW_SHARES) - 1)
    shares: tuple[float, ...] = _ROW_SHARES
    if _ROW_SHARES[-1] * free < _LINE_SPACING * SMALL_FONT_SIZE * scale:
        # What can be read from afar has its room before what cannot.
        shares = _ROW_SHARES[:-1]
        free += gap
    rows = []
    top = inner.top()
    for share in shares:
        high = share / sum(shares) * free
        rows.append(QRectF(inner.left(), top, inner.width(), high))
        top += high + gap
    state, hints, gauges, card = rows[:4]
    pad = 0.1 * state.height()
    side = min(state.height() - 2 * pad, 0.25 * state.width())
    sign = QRectF(state.left() + pad, state.center().y() - side / 2, side, side)
    word = QRectF(
        sign.right() + pad, state.top(), state.right() - sign.right() - 2 * pad, state.height()
    )
    right = _SIGN_SHARE * inner.width()
    return PageRegions(
        state=state,
        sign=sign,
        word=word,
        hints=hints,
        gauges=gauges.adjusted(0, 0, -right - gap, 0),
        leg=QRectF(gauges.right() - right, gauges.top(), right, gauges.height()),
        card=card.adjusted(0, 0, -right - gap, 0),
        time=QRectF(card.right() - right, card.top(), right, card.height()),
        footer=rows[4] if len(rows) > 4 else None,
        min_title_height=_LINE_SPACING * _MIN_TITLE_SIZE * scale,
    )


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
    """Return a font between two sizes for a text in a box, narrowed where the least is too wide."""
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
