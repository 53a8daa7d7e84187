"""The pilot's page itself: five things, drawn as large as the window lets them be."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from ui.display_style import DisplayStyle, mix_colors
from ui.number_format import DASH
from ui.pilot.cue_display import (
    STATEMENT_SEPARATOR,
    CardDisplay,
    CueDisplay,
    DisplayTone,
    Gauge,
    Hint,
)
from ui.pilot.page_layout import SMALL_FONT_SIZE, PageRegions, compute_regions, elide_text, fit_font
from ui.pilot.sign_shapes import paint_ring, paint_sign
from ui.translation import tr

_ALIGN: Final = Qt.AlignmentFlag
_WRAP: Final = Qt.TextFlag.TextWordWrap
_MIN_FONT_SIZE: Final = 9
"""Pixels of the smallest letters, in a window smaller than any that is meant."""
_MAX_SMALL_FONT_SIZE: Final = 17
"""Pixels of the small line's letters, at most; times the scale of the window."""
_MAX_TITLE_FONT_SIZE: Final = 24
"""Pixels of the letters of titles, at most; times the scale of the window."""
_NUMBER_SHARE: Final = 0.36
"""Share of a gauge's width for its number."""
_TITLE_SHARE: Final = 0.22
"""Share of a gauge's height for its title."""


def paint_gauge(
    painter: QPainter, style: DisplayStyle, gauge: Gauge, box: QRectF, places: PageRegions
) -> None:
    """Draw a gauge into a box."""
    high = box.height()
    left = QRectF(box.left(), box.top(), _NUMBER_SHARE * box.width(), high)
    title, number = places.split_title(left, _TITLE_SHARE)
    largest = round(_MAX_TITLE_FONT_SIZE * style.sizes.scale)
    _paint_text(painter, style, gauge.title, title, "muted", largest=largest, share=0.9)
    _paint_number(painter, style, gauge, number)
    if gauge.low is None or gauge.high is None:
        return
    right = box.adjusted(left.width() + 0.02 * box.width(), 0, 0, 0)
    text = right.adjusted(0, 0, 0, -0.68 * high)
    target = f"{gauge.target_text} {gauge.unit}"
    _paint_text(painter, style, target, text, "target", share=0.9, bold=True)
    track = right.adjusted(0, 0.46 * high, 0, -0.1 * high)
    _paint_track(painter, style, gauge, track)


def _paint_number(painter: QPainter, style: DisplayStyle, gauge: Gauge, box: QRectF) -> None:
    """Draw number and unit; the number's room is as wide as three figures, so nothing jitters."""
    high = box.height()
    room = QRectF(box.left(), box.top() - 0.15 * high, 0.72 * box.width(), 1.3 * high)
    widest = max(gauge.number, "000", key=len)
    painter.setPen(style.color("text"))
    painter.setFont(fit_font(widest, room, round(0.95 * high), _MIN_FONT_SIZE, bold=True))
    painter.drawText(room, _ALIGN.AlignVCenter | _ALIGN.AlignLeft, gauge.number)
    taken = painter.fontMetrics().horizontalAdvance(widest)
    unit = box.adjusted(taken + 0.03 * box.width(), 0.36 * high, 0, 0)
    _paint_text(painter, style, gauge.unit, unit, "muted", largest=round(0.42 * high), share=0.9)


def _paint_track(painter: QPainter, style: DisplayStyle, gauge: Gauge, box: QRectF) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(style.color("chosen"))
    painter.drawRect(box)
    low, high = _bar_position(gauge.low, box), _bar_position(gauge.high, box)
    band = QRectF(low, box.top(), high - low, box.height())
    cyan = style.color("target")
    soft = QColor(cyan)
    soft.setAlphaF(0.35)
    painter.setBrush(soft)
    painter.drawRect(band)
    painter.setPen(QPen(cyan, max(0.06 * box.height(), 2.0)))
    painter.drawLine(band.topLeft(), band.bottomLeft())
    painter.drawLine(band.topRight(), band.bottomRight())
    if gauge.marker is not None:
        _paint_marker(painter, style, gauge.marker, box)


def _paint_marker(painter: QPainter, style: DisplayStyle, at: float, box: QRectF) -> None:
    ink = style.color("text")
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(ink)
    side = 0.5 * box.height()
    if 0.0 <= at <= 1.0:
        x = _bar_position(at, box)
        thick = max(0.16 * box.height(), 4.0)
        top = box.top() - 0.22 * box.height()
        painter.drawRect(QRectF(x - thick / 2, top, thick, 1.36 * box.height()))
        return
    way = 1.0 if at > 1.0 else -1.0
    tip = box.right() if at > 1.0 else box.left()
    middle = box.center().y()
    painter.drawPolygon(
        QPolygonF(
            [
                QPointF(tip, middle),
                QPointF(tip - way * 1.4 * side, middle - side),
                QPointF(tip - way * 1.4 * side, middle + side),
            ]
        )
    )


def _bar_position(share: float | None, box: QRectF) -> float:
    return box.left() + min(max(share or 0.0, 0.0), 1.0) * box.width()


def _paint_text(
    painter: QPainter,
    style: DisplayStyle,
    text: str,
    box: QRectF,
    role: str,
    *,
    largest: int = 400,
    share: float = 0.8,
    bold: bool = False,
    wrap: bool = False,
    right: bool = False,
) -> None:
    """Write as large as a box allows, at most as high as a share of it."""
    if not text:
        return
    painter.setPen(style.color(role))
    top = max(min(largest, round(share * box.height())), _MIN_FONT_SIZE)
    painter.setFont(fit_font(text, box, top, _MIN_FONT_SIZE, bold=bold, wrap=wrap))
    flags = _ALIGN.AlignVCenter | (_ALIGN.AlignRight if right else _ALIGN.AlignLeft)
    painter.drawText(box, flags | _WRAP if wrap else flags, text)


_CAP_HEIGHT: Final = 1.0
"""Size of the big word's letters, times the height of its box."""
_LEAD_SHARE: Final = 0.2
"""Share of the card's height for its title."""
_CORNER: Final = 8
_BORDER: Final = 2.0


class PilotCanvas(QWidget):
    """Draws a `CueDisplay`."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.display = CueDisplay(status_text=tr("NO FLIGHT"), sign="unknown", tone="unknown")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setAccessibleName(tr("Pilot page"))
        style.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(960, 600)

    def show_display(self, sheet: CueDisplay) -> None:
        if sheet == self.display:
            return
        if sheet.accessible_text != self.display.accessible_text:
            self.setAccessibleDescription(sheet.accessible_text)
        former, self.display = self.display, sheet
        places = self.compute_regions()
        if replace(former, gauges=sheet.gauges) == sheet:
            self.update(places.gauges.toAlignedRect())
        elif replace(former, ring=sheet.ring, count=sheet.count) == sheet:
            self.update(places.state.toAlignedRect())
        else:
            self.update()

    def compute_regions(self) -> PageRegions:
        return compute_regions(float(self.width()), float(self.height()), self._style.sizes.scale)

    def paintEvent(self, event: QPaintEvent) -> None:
        places = self.compute_regions()
        asked = QRectF(event.rect())
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(event.rect(), self._style.color("panel"))
        for box, paint in (
            (places.state, self._paint_state),
            (places.hints, self._paint_hints),
            (places.gauges, self._paint_gauges),
            (places.leg, self._paint_leg),
            (places.card.united(places.time), self._paint_card),
            (places.footer, self._paint_foot),
        ):
            if box is not None and asked.intersects(box):
                paint(painter, places)
        painter.end()

    # The state

    def _colors(self, tone: DisplayTone) -> tuple[QColor | None, QColor]:
        style = self._style
        if tone in ("good", "caution", "warning"):
            return style.color(f"{tone}_fill"), style.color("fill_text")
        if tone == "strong":
            return style.color("text"), style.color("panel")
        return None, style.color("muted" if tone == "unknown" else "text")

    def _paint_state(self, painter: QPainter, places: PageRegions) -> None:
        sheet, style = self.display, self._style
        fill, ink = self._colors(sheet.tone)
        painter.save()
        if fill is not None:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(fill)
        else:
            dashes = Qt.PenStyle.DashLine if sheet.tone == "unknown" else Qt.PenStyle.SolidLine
            painter.setPen(QPen(style.color("axis"), 2 * _BORDER, dashes))
            painter.setBrush(Qt.BrushStyle.NoBrush)
        inset = 0.0 if fill is not None else _BORDER
        painter.drawRoundedRect(
            places.state.adjusted(inset, inset, -inset, -inset), _CORNER, _CORNER
        )
        painter.restore()
        if sheet.ring is not None:
            track = mix_colors((fill or style.color("panel")).name(), ink.name(), 0.3)
            paint_ring(painter, sheet.ring, places.sign, ink, track)
        inner = places.sign
        if sheet.ring is not None:
            inset = 0.2 * inner.width()
            inner = inner.adjusted(inset, inset, -inset, -inset)
        if sheet.count:
            painter.setPen(ink)
            painter.setFont(
                fit_font("00", inner, round(0.9 * inner.height()), _MIN_FONT_SIZE, bold=True)
            )
            painter.drawText(inner, _ALIGN.AlignCenter, sheet.count)
        else:
            paint_sign(painter, sheet.sign, inner, ink)
        painter.setPen(ink)
        # Capitals alone: what letters reach below their line may leave the box.
        high = places.word.height()
        room = places.word.adjusted(0, -0.2 * high, 0, 0.2 * high)
        painter.setFont(
            fit_font(sheet.status_text, room, round(_CAP_HEIGHT * high), _MIN_FONT_SIZE, bold=True)
        )
        painter.drawText(places.word, _ALIGN.AlignVCenter | _ALIGN.AlignLeft, sheet.status_text)

    # The others

    def _paint_hints(self, painter: QPainter, places: PageRegions) -> None:
        hints = self.display.hints
        for hint, box in zip(hints, places.hint_boxes(len(hints)), strict=False):
            self._paint_hint(painter, hint, box, wrap=len(hints) == 1)

    def _paint_gauges(self, painter: QPainter, places: PageRegions) -> None:
        gauges = self.display.gauges
        for gauge, box in zip(gauges, places.gauge_boxes(len(gauges)), strict=True):
            paint_gauge(painter, self._style, gauge, box, places)

    def _paint_foot(self, painter: QPainter, places: PageRegions) -> None:
        if places.footer is not None:
            scale = self._style.sizes.scale
            text = footer_text(self.display.footer, places.footer, round(SMALL_FONT_SIZE * scale))
            largest = round(_MAX_SMALL_FONT_SIZE * scale)
            _paint_text(
                painter, self._style, text, places.footer, "muted", largest=largest, wrap=True
            )

    def _paint_hint(self, painter: QPainter, hint: Hint, box: QRectF, *, wrap: bool) -> None:
        color = self._style.color(
            {"plain": "text", "strong": "text", "unknown": "muted"}.get(hint.tone, hint.tone)
        )
        text = box
        if hint.sign:
            side = min(0.72 * box.height(), 0.1 * box.width())
            sign = QRectF(box.left() + 0.15 * side, 0, side, side)
            sign.moveTop(box.center().y() - side / 2)
            paint_sign(painter, hint.sign, sign, color)
            text = box.adjusted(1.45 * side, 0, 0, 0)
        painter.setPen(color)
        largest = round(0.8 * box.height()) if not wrap else round(0.62 * box.height())
        painter.setFont(fit_font(hint.text, text, largest, _MIN_FONT_SIZE, bold=True, wrap=wrap))
        flags = _ALIGN.AlignVCenter | _ALIGN.AlignLeft
        painter.drawText(text, flags | _WRAP if wrap else flags, hint.text)

    def _paint_leg(self, painter: QPainter, places: PageRegions) -> None:
        box = places.leg
        if not self.display.leg_time_text:
            return
        title, number = places.split_title(box, _TITLE_SHARE)
        self._title(painter, tr("LEG LEFT"), title, right=True)
        role = "caution" if self.display.leg_short else "text"
        text = (
            self.display.leg_time_text
            if self.display.leg_time_text == DASH
            else f"{self.display.leg_time_text} s"
        )
        _paint_text(painter, self._style, text, number, role, bold=True, right=True)

    def _paint_card(self, painter: QPainter, places: PageRegions) -> None:
        card, box, time = self.display.card, places.card, places.time
        lead, below = places.split_title(box, _LEAD_SHARE)
        text, gain = _split_card_box(below)
        if card == CardDisplay():
            return
        painter.setPen(self._style.color("line"))
        painter.drawLine(box.topLeft(), time.topRight())
        self._title(painter, card.heading, lead)
        style, role = self._style, "caution" if card.problem else "text"
        _paint_text(painter, style, card.text, text, "text", bold=True)
        _paint_text(painter, style, card.benefit_text, gain, role, wrap=True)
        title, below = places.split_title(time, _LEAD_SHARE)
        upper, lower = _split_card_box(below)
        if card.time_left_text or card.maneuvers_left_text:
            self._title(painter, tr("FLIGHT"), title, right=True)
        _paint_text(painter, style, card.time_left_text, upper, "text", bold=True, right=True)
        _paint_text(painter, style, card.maneuvers_left_text, lower, "text", right=True)

    def _title(self, painter: QPainter, text: str, box: QRectF, *, right: bool = False) -> None:
        largest = round(_MAX_TITLE_FONT_SIZE * self._style.sizes.scale)
        _paint_text(painter, self._style, text, box, "muted", largest=largest, right=right)


def _split_card_box(box: QRectF) -> tuple[QRectF, QRectF]:
    high = box.height()
    return box.adjusted(0, 0, 0, -0.45 * high), box.adjusted(0, 0.575 * high, 0, 0)


def footer_text(told: str, box: QRectF, pixels: int) -> str:
    """Return what the small line holds: whole statements where one fits, the first one first.

    All of it is in the description of the page; here what cannot be judged goes before what can.
    """
    held = elide_text(told, box, pixels)
    return held if held == told else elide_text(told.split(STATEMENT_SEPARATOR)[0], box, pixels)
