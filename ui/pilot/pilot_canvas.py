"""The pilot's page itself: five things, drawn as large as the window lets them be."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from ui.display_style import DisplayStyle, mix_colors
from ui.number_format import DASH
from ui.pilot.cue_display import STATEMENT_SEPARATOR, CardDisplay, CueDisplay, DisplayTone, Hint
from ui.pilot.font_fitting import elide_text, fit_font
from ui.pilot.gauge_painter import TITLE_SHARE, paint_gauge
from ui.pilot.page_regions import SMALL_FONT_SIZE, PageRegions, compute_regions
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
_CAP_HEIGHT: Final = 1.0
"""Size of the big word's letters, times the height of its box."""
_LEAD_SHARE: Final = 0.2
"""Share of the card's height for its title."""
_CORNER: Final = 8
_BORDER: Final = 2.0


class PilotCanvas(QWidget):
    """Draws a `CueDisplay`."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.display = CueDisplay(status_text=tr("NO FLIGHT"), sign="unknown", tone="unknown")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setAccessibleName(tr("Pilot page"))
        look.changed.connect(self.update)

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
        return compute_regions(float(self.width()), float(self.height()), self._look.sizes.scale)

    def paintEvent(self, event: QPaintEvent) -> None:
        places = self.compute_regions()
        asked = QRectF(event.rect())
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(event.rect(), self._look.color("panel"))
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
        """Return fill (None for none) and ink of a tone."""
        look = self._look
        if tone in ("good", "caution", "warning"):
            return look.color(f"{tone}_fill"), look.color("fill_text")
        if tone == "strong":
            return look.color("text"), look.color("panel")
        return None, look.color("muted" if tone == "unknown" else "text")

    def _paint_state(self, painter: QPainter, places: PageRegions) -> None:
        sheet, look = self.display, self._look
        fill, ink = self._colors(sheet.tone)
        painter.save()
        if fill is not None:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(fill)
        else:
            dashes = Qt.PenStyle.DashLine if sheet.tone == "unknown" else Qt.PenStyle.SolidLine
            painter.setPen(QPen(look.color("axis"), 2 * _BORDER, dashes))
            painter.setBrush(Qt.BrushStyle.NoBrush)
        inset = 0.0 if fill is not None else _BORDER
        painter.drawRoundedRect(
            places.state.adjusted(inset, inset, -inset, -inset), _CORNER, _CORNER
        )
        painter.restore()
        if sheet.ring is not None:
            track = mix_colors((fill or look.color("panel")).name(), ink.name(), 0.3)
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
            paint_gauge(painter, self._look, gauge, box, places)

    def _paint_foot(self, painter: QPainter, places: PageRegions) -> None:
        if places.footer is not None:
            scale = self._look.sizes.scale
            words = footer_text(self.display.footer, places.footer, round(SMALL_FONT_SIZE * scale))
            largest = round(_MAX_SMALL_FONT_SIZE * scale)
            self._text(painter, words, places.footer, largest, "muted", wrap=True)

    def _paint_hint(self, painter: QPainter, hint: Hint, box: QRectF, *, wrap: bool) -> None:
        color = self._look.color(
            {"plain": "text", "strong": "text", "unknown": "muted"}.get(hint.tone, hint.tone)
        )
        words = box
        if hint.sign:
            side = min(0.72 * box.height(), 0.1 * box.width())
            sign = QRectF(box.left() + 0.15 * side, 0, side, side)
            sign.moveTop(box.center().y() - side / 2)
            paint_sign(painter, hint.sign, sign, color)
            words = box.adjusted(1.45 * side, 0, 0, 0)
        painter.setPen(color)
        largest = round(0.8 * box.height()) if not wrap else round(0.62 * box.height())
        painter.setFont(fit_font(hint.text, words, largest, _MIN_FONT_SIZE, bold=True, wrap=wrap))
        flags = _ALIGN.AlignVCenter | _ALIGN.AlignLeft
        painter.drawText(words, flags | _WRAP if wrap else flags, hint.text)

    def _paint_leg(self, painter: QPainter, places: PageRegions) -> None:
        box = places.leg
        if not self.display.leg_time_text:
            return
        title, number = places.split_title(box, TITLE_SHARE)
        self._title(painter, tr("LEG LEFT"), title, right=True)
        role = "caution" if self.display.leg_short else "text"
        words = (
            self.display.leg_time_text
            if self.display.leg_time_text == DASH
            else f"{self.display.leg_time_text} s"
        )
        self._text(painter, words, number, 400, role, bold=True, right=True)

    def _paint_card(self, painter: QPainter, places: PageRegions) -> None:
        card, box, time = self.display.card, places.card, places.time
        lead, below = places.split_title(box, _LEAD_SHARE)
        words, gain = _split_card_box(below)
        if card == CardDisplay():
            return
        painter.setPen(self._look.color("line"))
        painter.drawLine(box.topLeft(), time.topRight())
        self._title(painter, card.heading, lead)
        self._text(painter, card.text, words, 400, "text", bold=True)
        self._text(
            painter, card.benefit_text, gain, 400, "caution" if card.problem else "text", wrap=True
        )
        title, below = places.split_title(time, _LEAD_SHARE)
        upper, lower = _split_card_box(below)
        if card.time_left_text or card.maneuvers_left_text:
            self._title(painter, tr("FLIGHT"), title, right=True)
        self._text(painter, card.time_left_text, upper, 400, "text", bold=True, right=True)
        self._text(painter, card.maneuvers_left_text, lower, 400, "text", right=True)

    def _title(self, painter: QPainter, words: str, box: QRectF, *, right: bool = False) -> None:
        largest = round(_MAX_TITLE_FONT_SIZE * self._look.sizes.scale)
        self._text(painter, words, box, largest, "muted", right=right)

    def _text(
        self,
        painter: QPainter,
        words: str,
        box: QRectF,
        largest: int,
        role: str,
        *,
        bold: bool = False,
        wrap: bool = False,
        right: bool = False,
    ) -> None:
        """Write as large as a box allows."""
        if not words:
            return
        painter.setPen(self._look.color(role))
        top = min(largest, round(0.8 * box.height()))
        painter.setFont(
            fit_font(words, box, max(top, _MIN_FONT_SIZE), _MIN_FONT_SIZE, bold=bold, wrap=wrap)
        )
        flags = _ALIGN.AlignVCenter | (_ALIGN.AlignRight if right else _ALIGN.AlignLeft)
        painter.drawText(box, flags | _WRAP if wrap else flags, words)


def _split_card_box(box: QRectF) -> tuple[QRectF, QRectF]:
    """Return where the words of a card stand below its title, and the smaller ones below them."""
    high = box.height()
    return box.adjusted(0, 0, 0, -0.45 * high), box.adjusted(0, 0.575 * high, 0, 0)


def footer_text(told: str, box: QRectF, pixels: int) -> str:
    """Return what the small line holds: whole statements where one fits, the first one first.

    All of it is in the description of the page; here what cannot be judged goes before what can.
    """
    held = elide_text(told, box, pixels)
    return held if held == told else elide_text(told.split(STATEMENT_SEPARATOR)[0], box, pixels)
