"""The page of one instrument: what to do large on the left, points and curve beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QFrame, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle, sans_serif_font
from ui.icons import IndicatorState, paint_indicator
from ui.preflight.calibration_charts import CalibrationCharts, CalibrationPointList
from ui.preflight.surface_motion_view import SurfaceMotionView
from ui.preflight.wizard_rows import (
    WizardRemark,
    build_point_rows,
    build_quality_rows,
    list_remarks,
    select_figure,
)
from ui.preflight.wizard_text import WizardPrompt, build_prompt
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import NameValueTable

if TYPE_CHECKING:
    from calibration.wizard import WizardView


_FULL_HEIGHT, _COMPACT_HEIGHT = 212, 140
"""Points of height: with room, and at least."""
_MAIN_FONT_SIZE, _PROMPT_FONT_SIZE, _MIN_FONT_SIZE = 76, 22, 13
_ALIGN = Qt.AlignmentFlag
_FILLS: dict[IndicatorState, str] = {
    "good": "good_fill",
    "caution": "caution_fill",
    "warning": "warning_fill",
}


def fit_text_font(
    text: str, box: QRectF, largest: int, least: int, *, bold: bool = False, wrap: bool = False
) -> QFont:
    """Return the largest font, in pixels between two sizes, in which a text fits into a box."""
    flags = Qt.TextFlag.TextWordWrap if wrap else Qt.TextFlag.TextSingleLine
    # As narrow as a word may be: a box without height still asks for the width.
    room = QRectF(0, 0, box.width(), 10_000)
    for pixels in range(largest, least, -1):
        font = sans_serif_font(pixels, bold=bold)
        taken = QFontMetricsF(font).boundingRect(room, flags, text)
        if taken.width() <= box.width() and taken.height() <= box.height():
            return font
    return sans_serif_font(least, bold=bold)


class WizardPromptView(QWidget):
    """Draws a `WizardPrompt`; everything keeps its place, so that nothing jitters."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.prompt = WizardPrompt()
        self._low = False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        # Held by the widget itself: a column that scrolls would squeeze a mere hint.
        self.setMinimumHeight(self._style.px(_COMPACT_HEIGHT))
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(
            self._style.px(480), self._style.px(_COMPACT_HEIGHT if self._low else _FULL_HEIGHT)
        )

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(240), self._style.px(_COMPACT_HEIGHT))

    def set_compact(self, *, low: bool) -> None:
        """Take the least height, or all that it would like."""
        if low != self._low:
            self._low = low
            self.updateGeometry()

    def show_prompt(self, cue: WizardPrompt) -> None:
        """Show another cue."""
        if cue == self.prompt:
            return
        self.prompt = cue
        self.setAccessibleName(cue.accessible_text)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        px, cue = self._style.px, self.prompt
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        wide = float(self.width())
        self._paint_head(painter, QRectF(0, 0, wide, px(28)))
        side = min(max(0.3 * wide, px(140)), px(240))
        # Where the window is low the number and the prompt share what is left.
        share = (self.height() - px(_COMPACT_HEIGHT)) / max(
            px(_FULL_HEIGHT) - px(_COMPACT_HEIGHT), 1
        )
        spare = min(max(share, 0.0), 1.0)
        top, high = px(34 + 4 * spare), px(60 + 34 * spare)
        self._paint_big(painter, QRectF(0, top, wide - side - px(12), high))
        self._paint_measured(painter, QRectF(wide - side, top, side, high))
        prompt = QRectF(0, top + high + px(4 * spare), wide, px(28 + 28 * spare))
        painter.setPen(self._style.color("text"))
        painter.setFont(
            fit_text_font(
                cue.prompt, prompt, px(_PROMPT_FONT_SIZE), px(_MIN_FONT_SIZE), bold=True, wrap=True
            )
        )
        painter.drawText(prompt, Qt.TextFlag.TextWordWrap | _ALIGN.AlignVCenter, cue.prompt)
        message = QRectF(0, self.height() - px(18), wide, px(18))
        painter.setPen(self._style.color("muted"))
        painter.setFont(fit_text_font(cue.message, message, px(14), px(10)))
        painter.drawText(message, _ALIGN.AlignVCenter, cue.message)
        painter.end()

    def _paint_head(self, painter: QPainter, box: QRectF) -> None:
        style, px = self._style, self._style.px
        painter.setPen(style.color("muted"))
        painter.setFont(style.font("value"))
        painter.drawText(box, _ALIGN.AlignVCenter | _ALIGN.AlignRight, self.prompt.position_text)
        taken = QFontMetricsF(painter.font()).horizontalAdvance(self.prompt.position_text)
        room = box.adjusted(0, 0, -taken - px(8), 0)
        painter.setPen(style.color("text"))
        painter.setFont(fit_text_font(self.prompt.title, room, px(22), px(12), bold=True))
        painter.drawText(room, _ALIGN.AlignVCenter, self.prompt.title)
        track = QRectF(box.left(), box.bottom() + px(1), box.width(), px(4))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(style.color("chosen"))
        painter.drawRoundedRect(track, px(2), px(2))
        painter.setBrush(style.color("text"))
        track.setWidth(track.width() * min(max(self.prompt.progress, 0.0), 1.0))
        painter.drawRoundedRect(track, px(2), px(2))

    def _paint_big(self, painter: QPainter, box: QRectF) -> None:
        style, px, cue = self._style, self._style.px, self.prompt
        painter.setPen(style.color("muted"))
        painter.setFont(style.font("body"))
        painter.drawText(box, _ALIGN.AlignTop, cue.caption)
        number = box.adjusted(0, px(14), 0, 0)
        beside = min(0.42 * box.width(), px(170)) if cue.side_text else 0.0
        number.setWidth(box.width() - beside - (px(10) if beside else 0))
        painter.setPen(style.color("target" if cue.is_target else "text"))
        painter.setFont(
            fit_text_font(cue.main_text, number, px(_MAIN_FONT_SIZE), px(18), bold=True)
        )
        painter.drawText(number, _ALIGN.AlignVCenter, cue.main_text)
        if beside:
            taken = QFontMetricsF(painter.font()).horizontalAdvance(cue.main_text)
            text = QRectF(taken + px(10), number.top(), beside, number.height())
            painter.setFont(
                fit_text_font(cue.side_text, text, px(20), px(11), bold=True, wrap=True)
            )
            flags = Qt.TextFlag.TextWordWrap | _ALIGN.AlignVCenter
            painter.drawText(text, flags, cue.side_text)

    def _paint_measured(self, painter: QPainter, box: QRectF) -> None:
        style, px, cue = self._style, self._style.px, self.prompt
        if not cue.state_text:
            return
        chip = QRectF(box.left(), box.top(), box.width(), 0.37 * box.height())
        fill = _FILLS.get(cue.state)
        painter.setPen(Qt.PenStyle.NoPen if fill else QPen(style.color("axis"), 1))
        painter.setBrush(QColor(style.color(fill)) if fill else Qt.BrushStyle.NoBrush)
        painter.drawRoundedRect(chip, px(6), px(6))
        ink = style.color("fill_text" if fill else "text")
        sign = QRectF(chip.left() + px(10), chip.center().y() - px(8), px(16), px(16))
        paint_indicator(painter, cue.state, sign, ink)
        text = chip.adjusted(px(34), 0, -px(6), 0)
        painter.setPen(ink)
        painter.setFont(fit_text_font(cue.state_text, text, px(18), px(10), bold=True))
        painter.drawText(text, _ALIGN.AlignVCenter, cue.state_text)
        now = QRectF(box.left(), chip.bottom() + px(2), box.width(), 0.35 * box.height())
        painter.setPen(style.color("text"))
        painter.setFont(fit_text_font(cue.value_text, now, px(26), px(12), bold=True))
        painter.drawText(now, _ALIGN.AlignVCenter | _ALIGN.AlignRight, cue.value_text)
        volts = QRectF(box.left(), now.bottom(), box.width(), 0.24 * box.height())
        painter.setPen(style.color("muted"))
        painter.setFont(fit_text_font(cue.volts_text, volts, px(18), px(10)))
        painter.drawText(volts, _ALIGN.AlignVCenter | _ALIGN.AlignRight, cue.volts_text)


_SIGNS = {"warning": "■", "caution": "▲", "plain": "·"}
_ROLES = {"warning": "strong", "caution": "strong", "plain": "muted"}
_MIN_HEIGHT = 216
"""Points of height from which the cue stays in sight while what is below it is scrolled."""
_SIDE_BY_SIDE_WIDTH = 860
"""Points of width from which the curve stands beside the cue."""


class RemarkList(QWidget):
    """Sentences that the crew should not pass over, each with its sign."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.shown: tuple[WizardRemark, ...] = ()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.hide()

    def show_remarks(self, remarks: tuple[WizardRemark, ...]) -> None:
        """Show other sentences."""
        if remarks == self.shown:
            return
        self.shown = remarks
        self._column.setSpacing(self._style.px(4))
        clear_layout(self._column)
        for state, sentence in remarks:
            line = create_label(f"{_SIGNS[state]} {sentence}", _ROLES[state], wrap=True)
            line.setProperty("state", state)
            self._column.addWidget(line)
        self.setVisible(bool(remarks))


class WizardCalibrationPanel(QWidget):
    """Shows a view of the wizard."""

    point_chosen = Signal(int)  # place among the points taken

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.prompt_view = WizardPromptView(style)
        self.motion_view = SurfaceMotionView(style)
        self.remarks = RemarkList(style)
        self.points = CalibrationPointList(style)
        self.points.point_selected.connect(self.point_chosen)
        self.quality = NameValueTable(style)
        self.charts = CalibrationCharts(style)
        self._box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._left = QVBoxLayout()
        self._left.addWidget(self.prompt_view)
        self._below, self._below_column = _create_scroll_area()
        self._left.addWidget(self._below, 1)
        self._box.addLayout(self._left, 1)
        self._scroll, self._column = _create_scroll_area()
        self._column.addWidget(self.points)
        self._column.addWidget(self.charts, 1)
        # Takes the room only where the charts are not there.
        self._column.addStretch(0)
        self._box.addWidget(self._scroll, 1)
        self._wide = self._low = False
        self._arranged: tuple[bool, bool] | None = None
        self._beside = True
        style.changed.connect(self._fit)
        self._fit()

    def show_view(self, view: WizardView, choice: int | None, *, catching_up: bool) -> None:
        """Show a view, one of its points being chosen, perhaps while the flight is being read."""
        self.prompt_view.show_prompt(build_prompt(view, catching_up=catching_up))
        figure = select_figure(view)
        self.motion_view.show_figure(figure)
        self.remarks.show_remarks(list_remarks(view, self._style.units))
        rows = build_point_rows(view)
        self.points.show_rows(rows, choice)
        self.points.setVisible(bool(rows))
        self.quality.show_rows(build_quality_rows(view))
        by_hand = view.instrument is not None and view.instrument.is_angle_sensor
        drawn = by_hand and bool(view.points)
        self.charts.setVisible(drawn)
        if drawn:
            self.charts.show_view(view)
        self._beside = by_hand or bool(rows)
        self._scroll.setVisible(self._beside or not self._wide)

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(240), self._style.px(120))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self._style.px
        margin = px(16)
        self._box.setContentsMargins(margin, px(8), margin, 0)
        self._box.setSpacing(px(24 if self.width() >= px(_SIDE_BY_SIDE_WIDTH) else 8))
        self._scroll.setMinimumHeight(px(40))
        self._left.setSpacing(px(8))
        self._below_column.setSpacing(px(8))
        self._column.setSpacing(px(12))
        self._column.setContentsMargins(0, 0, px(8), px(8))
        self._wide = self.width() >= px(_SIDE_BY_SIDE_WIDTH)
        self._low = not self._wide and self.height() < px(_MIN_HEIGHT)
        if (self._wide, self._low) != self._arranged:
            self._arranged = (self._wide, self._low)
            self._arrange()

    def _arrange(self) -> None:
        """Put everything where there is room for it; where there is least, in one column."""
        wide, low = self._wide, self._low
        side = QBoxLayout.Direction.LeftToRight
        self._box.setDirection(side if wide else QBoxLayout.Direction.TopToBottom)
        self._box.setStretch(0, 1 if wide else 0)
        self._below.setVisible(wide)
        self._scroll.setVisible(self._beside or not wide)
        self.prompt_view.set_compact(low=low)
        if low:
            self._column.insertWidget(0, self.prompt_view)
        else:
            self._left.insertWidget(0, self.prompt_view)
        for index, widget in enumerate((self.remarks, self.quality, self.motion_view)):
            if wide:
                self._below_column.addWidget(widget, 1 if widget is self.motion_view else 0)
            else:
                self._column.insertWidget(index + low, widget)

    def scroll_pages(self, pages: float) -> None:
        """Move what is below by parts of its height."""
        for area in (self._below, self._scroll):
            bar = area.verticalScrollBar()
            bar.setValue(bar.value() + round(pages * area.viewport().height()))


def _create_scroll_area() -> tuple[QScrollArea, QVBoxLayout]:
    """Return an area that scrolls down, and the column in it."""
    area = QScrollArea()
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setWidgetResizable(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    page = QWidget()
    page.setObjectName("page")
    area.setWidget(page)
    column = QVBoxLayout(page)
    column.setContentsMargins(0, 0, 0, 0)
    return area, column
