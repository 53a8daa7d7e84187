"""Where everything stands on the page; from its size alone, so that nothing ever jumps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QRectF

_ROWS: Final = (0.33, 0.24, 0.18, 0.2, 0.05)
"""Shares of the height: state, hints, gauges, card, small line."""
_SIDE: Final = 0.19
"""Share of the width for seconds of leg and for time left, on the right."""
_MARGIN: Final = 0.016
"""Share of the width that is left free around everything."""
_FIRST_HINT: Final = 0.6
"""Share of their row that the first of two hints takes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Regions:
    """Boxes of the page, pixels."""

    state: QRectF
    sign: QRectF
    word: QRectF
    hints: QRectF
    gauges: QRectF
    leg: QRectF
    card: QRectF
    time: QRectF
    foot: QRectF

    def hint_boxes(self, count: int) -> tuple[QRectF, ...]:
        """Return the boxes of so many hints, the first one larger."""
        box = self.hints
        if count < 2:
            return (box,)
        first = _FIRST_HINT * box.height()
        return (
            QRectF(box.left(), box.top(), box.width(), first),
            QRectF(box.left(), box.top() + first, box.width(), box.height() - first),
        )

    def gauge_boxes(self, count: int) -> tuple[QRectF, ...]:
        """Return the boxes of so many gauges, side by side."""
        box, gap = self.gauges, _MARGIN * self.state.width()
        if count < 1:
            return ()
        wide = (box.width() - gap * (count - 1)) / count
        return tuple(
            QRectF(box.left() + place * (wide + gap), box.top(), wide, box.height())
            for place in range(count)
        )


def regions(width: float, height: float) -> Regions:
    """Return the boxes of a page of this size."""
    gap = _MARGIN * min(width, 1.6 * height)
    inner = QRectF(gap, gap, width - 2 * gap, height - 2 * gap)
    free = inner.height() - gap * (len(_ROWS) - 1)
    rows = []
    top = inner.top()
    for share in _ROWS:
        rows.append(QRectF(inner.left(), top, inner.width(), share * free))
        top += share * free + gap
    state, hints, gauges, card, foot = rows
    pad = 0.1 * state.height()
    side = min(state.height() - 2 * pad, 0.25 * state.width())
    sign = QRectF(state.left() + pad, state.center().y() - side / 2, side, side)
    word = QRectF(
        sign.right() + pad, state.top(), state.right() - sign.right() - 2 * pad, state.height()
    )
    right = _SIDE * inner.width()
    return Regions(
        state=state,
        sign=sign,
        word=word,
        hints=hints,
        gauges=gauges.adjusted(0, 0, -right - gap, 0),
        leg=QRectF(gauges.right() - right, gauges.top(), right, gauges.height()),
        card=card.adjusted(0, 0, -right - gap, 0),
        time=QRectF(card.right() - right, card.top(), right, card.height()),
        foot=foot,
    )
