"""Painting everything around the lines: names, axes, values, labels, the banner of the pause.

All coordinates are whole pixels of the screen; the painter that comes in is set up for that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen

from gsapp.quantities import ChannelSpec, symbol_parts
from ui.display_style import sans_serif_font
from ui.icons import paint_indicator
from ui.number_format import DASH, clock_text, elapsed_text, number_text, time_span_text, unit_text
from ui.strips.axis_ticks import multiples, step_decimals, time_step
from ui.strips.chart_annotations import AlarmSpan, ChartMark, ChartSpan, DisplayFormat
from ui.strips.chart_geometry import ChartGeometry, ColumnWidths, PixelBox
from ui.strips.chart_state import (
    BEYOND_CALIBRATION_MARK,
    BEYOND_CALIBRATION_TEXT,
    ChartState,
    DisplayedValue,
    line_width,
)
from ui.strips.strip_view import StripView
from ui.theme import Theme
from ui.translation import tr

_LABEL_SIZE, _BODY_SIZE, _SYMBOL_SIZE, _VALUE_SIZE = 11, 13, 14, 18
_WIDE_LABEL_SPACING, _LABEL_SPACING = 1.9, 1.2
"""Distance of the labels of the time axis in widths of one: of minutes as a rule, of hours at
least."""
_WIDTH_CACHE_SIZE = 4096
_CURSOR_LETTERS = {"cursor": "C", "a": "A", "b": "B", "delta": "Δ"}
"""Before the values at cursors, in their order."""
_CURSOR_STEP = 18  # Logical pixels from one value at a cursor to the next, at most.


class PaintStyle:
    """Fonts, colors and strokes of a theme at a pixel ratio, and what they paint now."""

    def __init__(self, theme: Theme, ratio: float) -> None:
        # Set before each repaint; the painter is set up for whole pixels of the screen.
        self.painter = QPainter()
        self.geometry: ChartGeometry
        self.view: StripView
        self.theme = theme
        self.ratio = ratio
        self._fonts: dict[tuple[int, bool, bool], tuple[QFont, QFontMetricsF]] = {}
        self._colors: dict[str, QColor] = {}
        self._widths: dict[tuple[str, int, bool, bool], float] = {}

    def color(self, text: str) -> QColor:
        if text not in self._colors:
            self._colors[text] = QColor(text)
        return self._colors[text]

    def px(self, points: float) -> int:
        """Return points of the design in pixels of the screen."""
        return round(points * self.ratio)

    def font(
        self, pixels: int, *, bold: bool = False, italic: bool = False
    ) -> tuple[QFont, QFontMetricsF]:
        """Return a font of a size in pixels of the screen, with its measures."""
        key = (max(pixels, 1), bold, italic)
        if key not in self._fonts:
            font = sans_serif_font(key[0], bold=bold, italic=italic)
            self._fonts[key] = (font, QFontMetricsF(font))
        return self._fonts[key]

    def width(self, text: str, points: float, *, bold: bool = False) -> float:
        return self._advance(text, max(self.px(points), 1), bold, False)

    def _advance(self, text: str, pixels: int, bold: bool, italic: bool) -> float:
        """Return the width of a text; asked of the font once for each."""
        key = (text, pixels, bold, italic)
        width = self._widths.get(key)
        if width is None:
            if len(self._widths) >= _WIDTH_CACHE_SIZE:
                self._widths.clear()
            width = self.font(pixels, bold=bold, italic=italic)[1].horizontalAdvance(text)
            self._widths[key] = width
        return width

    def text(
        self,
        x: float,
        center: float,
        text: str,
        color: str,
        points: float,
        *,
        bold: bool = False,
        italic: bool = False,
        align: str = "left",
        pixels: int = 0,
        room: float = 0.0,
    ) -> float:
        """Write a text whose capitals stand around `center`; return its width.

        ``room`` is the width at which it is cut with an ellipsis; 0 is any width.
        """
        if not text:
            return 0.0
        key = (text, max(pixels or self.px(points), 1), bold, italic)
        font, metrics = self.font(key[1], bold=bold, italic=italic)
        width = self._advance(*key)
        if room and width > room:
            text = metrics.elidedText(text, Qt.TextElideMode.ElideRight, room)
            width = metrics.horizontalAdvance(text)
        if align == "right":
            x -= width
        elif align == "center":
            x -= width / 2.0
        self.painter.setFont(font)
        self.painter.setPen(self.color(color))
        self.painter.drawText(QPointF(round(x), round(center + metrics.capHeight() / 2.0)), text)
        return width


def measure_column_widths(
    pen: PaintStyle, charts: Sequence[ChartState], group_names: Sequence[str], width: int
) -> ColumnWidths:
    """Return the widths that the text beside the plot needs."""
    names = ticks = values = units = 0.0
    for chart in charts:
        for spec, display in zip(chart.specs, chart.displays, strict=True):
            unit = unit_text(display.unit)
            names = max(
                names,
                _symbol_width(pen, spec.symbol) + pen.px(5) + pen.width(unit, _LABEL_SIZE),
                min(pen.width(spec.title, _LABEL_SIZE), pen.px(116)),
            )
            widest = _widest_value_text(spec, display)
            values = max(values, pen.width(widest, _VALUE_SIZE, bold=True))
            units = max(units, pen.width(unit, _LABEL_SIZE))
            ticks = max(ticks, pen.width(widest.replace(".", ""), _LABEL_SIZE))
    if width < pen.px(760):
        # Little room, as at 250 %: titles give way first.
        names = min(names, pen.px(84))
    tag = pen.width(tr("uncal"), _LABEL_SIZE) + pen.px(12)
    return ColumnWidths(
        gutter=pen.px(22) if any(group_names) else pen.px(8),
        names=math.ceil(names) + pen.px(8),
        ticks=math.ceil(min(max(ticks, pen.px(30)), pen.px(56))) + pen.px(8),
        values=math.ceil(pen.px(10) + tag + values + pen.px(5) + units + pen.px(10)),
        units=math.ceil(units),
        cursor=math.ceil(values * _BODY_SIZE / _VALUE_SIZE + pen.width("C", _LABEL_SIZE, bold=True))
        + pen.px(18),
    )


def _widest_value_text(spec: ChannelSpec, display: DisplayFormat) -> str:
    ends = (number_text(display.to_display(value), display.decimals) for value in spec.limits)
    return max(ends, key=len)


def _symbol_width(pen: PaintStyle, symbol: str) -> float:
    base, below, rest = symbol_parts(symbol)
    return (
        pen.width(base, _SYMBOL_SIZE, bold=True)
        + (pen.width(below, _LABEL_SIZE, bold=True) + pen.px(1) if below else 0.0)
        + pen.width(rest, _BODY_SIZE)
    )


def draw_names(
    pen: PaintStyle, charts: Mapping[int, ChartState], selected: int, focused: bool
) -> None:
    """Write group names, symbols, units, titles and the labels of the y axes."""
    theme = pen.theme
    for name, box in pen.geometry.groups:
        _draw_group(pen, tr(name), box)
    lowest: dict[float, int] = {}
    for number_of_chart, box in zip(pen.geometry.numbers, pen.geometry.charts, strict=True):
        share = charts[number_of_chart].strip.height
        lowest[share] = min(lowest.get(share, box.height), box.height)
    for number_of_chart, box in zip(pen.geometry.numbers, pen.geometry.charts, strict=True):
        chart = charts[number_of_chart]
        x = pen.geometry.columns.gutter
        if number_of_chart == selected and focused:
            bar = QRect(x - pen.px(4), box.y, pen.px(3), box.height)
            pen.painter.fillRect(bar, pen.color(theme.selection))
        # Charts that are to be equally high differ by a pixel: all have their title, or none.
        titled = lowest[chart.strip.height] >= pen.px(34)
        _draw_name(pen, chart, box, titled=titled)
        draw_ticks(pen, chart, box)


def _draw_group(pen: PaintStyle, name: str, box: PixelBox) -> None:
    if not name:
        return
    theme = pen.theme
    line = max(pen.px(1), 1)
    x = box.right - pen.px(8)
    pen.painter.fillRect(QRect(x, box.y, line, box.height), pen.color(theme.axis))
    room = box.height - pen.px(2)
    if pen.width(name, _LABEL_SIZE) > room and room < pen.px(36):
        return
    pen.painter.save()
    pen.painter.translate(x - pen.px(7), box.center)
    pen.painter.rotate(-90.0)
    pen.text(0.0, 0.0, name, theme.muted, _LABEL_SIZE, align="center", room=room)
    pen.painter.restore()


def _draw_name(pen: PaintStyle, chart: ChartState, box: PixelBox, *, titled: bool) -> None:
    theme = pen.theme
    x: float = pen.geometry.columns.gutter + pen.px(4)
    room: float = pen.geometry.columns.names - pen.px(8)
    count = len(chart.specs)
    if count == 1:
        spec, display = chart.specs[0], chart.displays[0]
        center = box.center - (pen.px(8) if titled else 0)
        _draw_symbol(pen, x, center, spec.symbol, chart.text_colors[0], display.unit, room)
        if titled:
            below = box.center + pen.px(9)
            pen.text(x, below, spec.title, theme.muted, _LABEL_SIZE, room=room)
        return
    fitting = max(min(count, int(box.height // pen.px(15))), 1)
    if fitting < count:
        # One line for all: the letters alone, each in its color.
        for spec, color in zip(chart.specs, chart.text_colors, strict=True):
            used = _draw_symbol(pen, x, box.center, spec.symbol, color, "", room)
            x, room = x + used + pen.px(6), room - used - pen.px(6)
            if room <= pen.px(10):
                break
        return
    step = min(box.height / count, pen.px(18))
    for index, (spec, color) in enumerate(zip(chart.specs, chart.text_colors, strict=True)):
        # What hangs below the last line stays within the chart.
        center = box.center + (index - (count - 1) / 2.0) * step
        center = min(center, box.bottom - pen.px(10))
        unit = chart.displays[index].unit
        _draw_symbol(pen, x, center, spec.symbol, color, unit, room)


def _draw_symbol(
    pen: PaintStyle, x: float, center: float, symbol: str, color: str, unit: str, room: float
) -> float:
    base, below, rest = symbol_parts(symbol)
    start = x
    x += pen.text(x, center, base, color, _SYMBOL_SIZE, bold=True)
    if below:
        x += pen.px(1)
        x += pen.text(x, center + pen.px(2.5), below, color, _LABEL_SIZE, bold=True)
    if rest:
        x += pen.text(x, center, rest, color, _BODY_SIZE, room=max(room - (x - start), 1.0))
    if unit:
        text = unit_text(unit)
        if x - start + pen.px(5) + pen.width(text, _LABEL_SIZE) <= room + pen.px(2):
            pen.text(x + pen.px(5), center, text, pen.theme.muted, _LABEL_SIZE)
    return x - start


def draw_ticks(pen: PaintStyle, chart: ChartState, box: PixelBox) -> None:
    """Write the labels of a y axis, kept within the chart."""
    theme = pen.theme
    line = max(pen.px(1), 1)
    edge = pen.geometry.plot.x
    free = line_width(theme, pen.geometry.ratio) / 2.0 + 1.0
    pen.painter.fillRect(QRect(edge - line, box.y, line, box.height), pen.color(theme.axis))
    decimals = tick_decimals(chart.ticks)
    half = pen.px(_LABEL_SIZE) * 0.42
    for value in chart.ticks:
        row = box.y + value_y_offset(chart, box, value, free)
        pen.painter.fillRect(
            QRect(edge - pen.px(4), round(row - line / 2.0), pen.px(4), line), pen.color(theme.axis)
        )
        center = min(max(row, box.y + half), box.bottom - half)
        pen.text(
            edge - pen.px(7),
            center,
            number_text(value, decimals),
            theme.muted,
            _LABEL_SIZE,
            align="right",
        )


def tick_decimals(ticks: Sequence[float]) -> int:
    """Return the digits after the point that the labels of an axis need."""
    return max((step_decimals(abs(value)) for value in ticks if value), default=0)


def value_y_offset(chart: ChartState, box: PixelBox, value: float, free: float) -> float:
    """Return how far below the top of its box a chart shows a displayed value."""
    gain = (box.height - 2.0 * free) / (chart.high - chart.low)
    return free + gain * (chart.high - value)


def draw_displayed_values(
    pen: PaintStyle,
    chart: ChartState,
    box: PixelBox,
    readings: Sequence[DisplayedValue],
    *,
    unit: bool,
) -> None:
    """Write the current values of a chart, with their unit if that needs to be drawn, too."""
    place = pen.geometry.values
    count = len(readings)
    step = box.height / count
    unit_x = pen.geometry.units.x
    pixels = min(pen.px(_VALUE_SIZE), round((step - pen.px(1)) / (0.78 if count > 1 else 0.74)))
    pixels = max(pixels, pen.px(8))
    if unit and not all(reading.stale for reading in readings):
        text = unit_text(chart.displays[0].unit)
        pen.text(unit_x, box.center, text, pen.theme.muted, _LABEL_SIZE)
    for index, reading in enumerate(readings):
        center = box.y + (index + 0.5) * step
        cell = QRect(
            place.x + pen.px(6), box.y + round(index * step), place.width - pen.px(10), round(step)
        )
        _draw_displayed_value(pen, chart, index, reading, cell, center, unit_x, pixels)


def _draw_displayed_value(
    pen: PaintStyle,
    chart: ChartState,
    index: int,
    reading: DisplayedValue,
    cell: QRect,
    center: float,
    unit_x: float,
    pixels: int,
) -> None:
    theme = pen.theme
    color = chart.text_colors[index]
    if reading.stale:
        color = theme.muted
        _draw_hatching(pen, cell, unit_x)
    text = f"≈{reading.text}" if reading.estimated and not reading.stale else reading.text
    pen.text(
        unit_x - pen.px(5),
        center,
        text,
        color,
        _VALUE_SIZE,
        bold=True,
        italic=reading.estimated,
        align="right",
        pixels=pixels,
    )
    _draw_tags(pen, reading, cell, center)


def _draw_hatching(pen: PaintStyle, cell: QRect, unit_x: float) -> None:
    """Hatch a cell, but for the place of its dash and its tags."""
    left = cell.x() + pen.px(38)
    right = round(unit_x - pen.px(5) - pen.width(DASH, _VALUE_SIZE, bold=True) - pen.px(8))
    box = QRect(left, cell.y() + pen.px(1), right - left, cell.height() - 2 * pen.px(1))
    if box.width() <= 0:
        return
    pen.painter.save()
    pen.painter.setClipRect(box, Qt.ClipOperation.IntersectClip)
    pen.painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)
    pen.painter.setPen(QPen(pen.color(pen.theme.axis), max(pen.px(1), 1)))
    step = pen.px(6)
    for x in range(box.x() - box.height(), box.x() + box.width(), step):
        pen.painter.drawLine(x, box.y() + box.height(), x + box.height(), box.y())
    pen.painter.restore()


def _draw_tags(pen: PaintStyle, reading: DisplayedValue, cell: QRect, center: float) -> None:
    theme = pen.theme
    tags: list[tuple[str, str, str]] = []
    if reading.state:
        fill = theme.warning_fill if reading.state == "warning" else theme.caution_fill
        sign = "▲" if reading.state_text == tr("HIGH") else "▼"
        tags.append((f"{sign} {reading.state_text}", theme.fill_text, fill))
    if reading.uncalibrated:
        tags.append((tr("uncal"), theme.caution, ""))
    if reading.extrapolated:
        # In two lines: beside each other they reach into a long number.
        first, second = BEYOND_CALIBRATION_TEXT.split()
        tags += [
            (f"{BEYOND_CALIBRATION_MARK} {first}", theme.caution, ""),
            (second, theme.caution, ""),
        ]
    if reading.estimated:
        tags.append((tr("est"), theme.muted, ""))
    fitting = max(int(cell.height() // pen.px(15)), 1)
    tags = tags[:fitting]
    for index, (word, color, fill) in enumerate(tags):
        middle = center + (index - (len(tags) - 1) / 2.0) * pen.px(15)
        width = pen.width(word, 10, bold=bool(fill))
        x = cell.x() + pen.px(2)
        if fill:
            box = QRectF(x, round(middle - pen.px(7)), width + pen.px(8), pen.px(14))
            pen.painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)
            pen.painter.setPen(Qt.PenStyle.NoPen)
            pen.painter.setBrush(pen.color(fill))
            pen.painter.drawRoundedRect(box, pen.px(3), pen.px(3))
            pen.painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
            x += pen.px(4)
        pen.text(x, middle, word, color, 10, bold=bool(fill))


def draw_cursor_values(
    pen: PaintStyle,
    box: PixelBox,
    columns: Sequence[PixelBox],
    texts: Mapping[str, Sequence[str]],
    chart: ChartState,
) -> None:
    """Write the values of a chart at the cursors, and what is to be said of them if it fits."""
    cells = [
        (name, index, text)
        for name in _CURSOR_LETTERS
        for index, text in enumerate(texts.get(name, ()))
    ]
    rows = math.ceil(len(cells) / len(columns))
    if not rows:
        return
    step = min(box.height / rows, pen.px(_CURSOR_STEP))
    pixels = max(min(pen.px(_BODY_SIZE), round(step / 0.9)), pen.px(8))
    for number, (name, index, text) in enumerate(cells):
        column = columns[number // rows]
        middle = box.center + (number % rows - (rows - 1) / 2.0) * step
        color = cursor_color(pen.theme, name) if name != "delta" else pen.theme.text
        pen.text(column.x + pen.px(6), middle, _CURSOR_LETTERS[name], color, _LABEL_SIZE,
            bold=True,
            pixels=min(pixels, pen.px(_LABEL_SIZE)),
        )  # fmt: skip
        if (
            text.startswith(BEYOND_CALIBRATION_MARK)
            and rows == 1
            and box.height >= pen.px(3 * _BODY_SIZE)
        ):
            _draw_beyond_calibration(pen, column, middle + pen.px(_BODY_SIZE))
        pen.text(
            column.right - pen.px(6),
            middle,
            text,
            pen.theme.text if name == "delta" else chart.text_colors[index],
            _BODY_SIZE,
            bold=name == "delta",
            align="right",
            pixels=pixels,
        )


def _draw_beyond_calibration(pen: PaintStyle, column: PixelBox, middle: float) -> None:
    """Say under a value that it lies beyond what was calibrated."""
    pen.text(column.right - pen.px(6), middle, BEYOND_CALIBRATION_TEXT, pen.theme.caution, 10,
        align="right",
    )  # fmt: skip


def cursor_color(theme: Theme, name: str) -> str:
    """Return the color of a cursor's line and heading."""
    return {"a": theme.cursor_a, "b": theme.cursor_b}.get(name, theme.cursor)


def draw_header(pen: PaintStyle, title: str, *, recording: bool) -> None:
    """Write the pause or the time in sight above the plot."""
    theme = pen.theme
    header, plot = pen.geometry.header, pen.geometry.plot
    center = header.center + pen.px(1)
    if pen.view.paused:
        banner = QRect(0, 0, plot.right, header.height - pen.px(3))
        pen.painter.fillRect(banner, pen.color(theme.banner))
        middle = banner.height() / 2.0
        x = float(pen.px(10))
        bar = pen.px(3)
        for shift in (0, 2 * bar):
            pen.painter.fillRect(
                QRectF(x + shift, middle - pen.px(5), bar, pen.px(10)), pen.color(theme.banner_text)
            )
        x += pen.px(18)
        behind = tr("PAUSED   {elapsed} behind").format(
            elapsed=elapsed_text(pen.view.seconds_behind)
        )
        x += pen.text(x, middle, behind, theme.banner_text, _BODY_SIZE, bold=True)
        note = tr("Home: back to now")
        if recording:
            note = tr("Still recording. {note}").format(note=note)
        end: float = plot.right - pen.px(10)
        if x + pen.px(14) + pen.width(note, _BODY_SIZE) < end:
            end -= pen.text(end, middle, note, theme.banner_text, _BODY_SIZE, align="right"
            )  # fmt: skip
        x, sight = x + pen.px(16), visible_time_text(pen.view)
        if x + pen.width(sight, _LABEL_SIZE) + pen.px(12) < end:
            pen.text(x, middle, sight, theme.banner_text, _LABEL_SIZE)
    else:
        room = plot.x - pen.geometry.columns.gutter - pen.px(8)
        x = pen.geometry.columns.gutter + pen.px(4)
        pen.text(x, center, title, theme.muted, _LABEL_SIZE, room=room)
        pen.text(
            plot.right, center, visible_time_text(pen.view), theme.muted, _LABEL_SIZE, align="right"
        )


def draw_clock(pen: PaintStyle, newest: str) -> None:
    """Write the newest flight time above the values, and what it is."""
    theme = pen.theme
    center = pen.geometry.header.center + pen.px(1)
    now = clock_text(pen.view.now, decimals=1)
    right = pen.geometry.values.right - pen.px(10)
    width = pen.text(right, center, now, theme.text, _BODY_SIZE, bold=True, align="right")
    pen.text(right - width - pen.px(6), center, newest, theme.muted, _LABEL_SIZE, align="right")


def visible_time_text(view: StripView) -> str:
    """Return how much time is in sight, and from A to B where both are set."""
    a, b = view.cursors.get("a"), view.cursors.get("b")
    sight = tr("{window} shown").format(window=time_span_text(view.window))
    if a is None or b is None:
        return sight
    return tr("B−A {number} s · {sight}").format(number=number_text(b - a, 2), sight=sight)


def draw_lane(pen: PaintStyle, spans: Sequence[ChartSpan], marks: Sequence[ChartMark]) -> None:
    """Write the labels of spans and marks above the charts, none upon another."""
    theme = pen.theme
    lane, plot = pen.geometry.lane, pen.geometry.plot
    line = max(pen.px(1), 1)
    latest = plot.width
    labels: list[tuple[int, str, bool]] = []
    for span in spans:
        begin = pen.view.x(span.start)
        end = pen.view.x(span.stop) if span.stop is not None else latest
        if end < 0 or begin >= latest:
            continue
        left, right = max(begin, 0), min(end + line, latest)
        color = pen.color(theme.span if span.kind == "maneuver" else theme.event)
        top = lane.y + pen.px(2)
        pen.painter.fillRect(QRect(plot.x + left, top, right - left, lane.bottom - top), color)
        pen.painter.fillRect(
            QRect(plot.x + left, top, right - left, line), pen.color(theme.span_edge)
        )
        labels.append((left, span.label, True))
    for x, label in _mark_labels_by_column(pen.view, marks).items():
        flag = QRect(plot.x + x, lane.y + pen.px(5), pen.px(6), pen.px(7))
        pen.painter.fillRect(flag, pen.color(theme.span_edge))
        pen.painter.fillRect(
            QRect(plot.x + x, lane.y + pen.px(5), line, lane.height - pen.px(5)),
            pen.color(theme.span_edge),
        )
        labels.append((x, label, False))
    labels.sort(key=lambda label: label[0])
    taken = 0
    for index, (left, text, within) in enumerate(labels):
        indent = pen.px(5) if within else pen.px(9)
        start = max(left + indent, taken)
        others = [label[0] for label in labels[index + 1 :] if label[0] > left]
        # A label may be longer than its span while nothing else stands there.
        end = min([latest, *others]) - pen.px(4)
        room = end - start
        needed = math.ceil(pen.width(text, _LABEL_SIZE))
        before = left - pen.px(4) - taken
        if not within and room < needed and (before >= needed or room < pen.px(16)):
            # A mark just made stands at the right edge; its words stand before it.
            start, room = left - pen.px(4) - min(needed, before), min(needed + 1, before)
        if room < pen.px(16):
            continue
        width = pen.text(
            plot.x + start, lane.center + pen.px(1), text, theme.text, _LABEL_SIZE, room=room
        )
        taken = start + math.ceil(width) + pen.px(6)


def _alarm_color(theme: Theme, alarm: AlarmSpan) -> str:
    return theme.warning_fill if alarm.state == "warning" else theme.caution_fill


def _alarm_columns(view: StripView, alarm: AlarmSpan) -> tuple[int, int]:
    stop = view.now if alarm.stop is None else alarm.stop
    begin = view.x(alarm.start)
    return begin, max(begin, begin if stop is None else view.x(stop)) + 1


def draw_lane_alarms(pen: PaintStyle, alarms: Sequence[AlarmSpan]) -> None:
    """Draw the alarms in sight below the labels of spans and marks: how long, and how bad."""
    lane, plot = pen.geometry.lane, pen.geometry.plot
    high, side = pen.px(3), pen.px(8)
    for alarm in alarms:
        begin, end = _alarm_columns(pen.view, alarm)
        if end <= 0 or begin >= plot.width:
            continue
        color = pen.color(_alarm_color(pen.theme, alarm))
        left, right = max(begin, 0), min(end, plot.width)
        pen.painter.fillRect(QRect(plot.x + left, lane.bottom - high, right - left, high), color)
        if begin >= 0:
            # Triangle or square: the shape tells the state without its color.
            box = QRectF(plot.x + begin - side // 2, lane.bottom - side, side, side)
            state: Literal["caution", "warning"]
            state = "warning" if alarm.state == "warning" else "caution"
            paint_indicator(pen.painter, state, box, color)


def draw_alarms(
    pen: PaintStyle,
    charts: Mapping[int, ChartState],
    alarms: Sequence[AlarmSpan],
    first: int,
    last: int,
) -> None:
    """Draw alarms along the top of the charts of their channels.

    Only what lies in the columns ``first <= x < last`` from the left edge needs to be drawn.
    """
    plot, high = pen.geometry.plot, pen.px(3)
    boxes = {
        trace.channel: box
        for number, box in zip(pen.geometry.numbers, pen.geometry.charts, strict=True)
        for trace in charts[number].strip.traces
    }
    for alarm in alarms:
        box = boxes.get(alarm.channel)
        begin, end = _alarm_columns(pen.view, alarm)
        left, right = max(begin, first), min(end, last)
        if box is not None and left < right:
            color = pen.color(_alarm_color(pen.theme, alarm))
            pen.painter.fillRect(QRect(plot.x + left, box.y, right - left, high), color)


def _mark_labels_by_column(view: StripView, marks: Sequence[ChartMark]) -> dict[int, str]:
    """Return the words of the marks in sight by column; marks in one column share a label."""
    found: dict[int, list[str]] = {}
    for mark in marks:
        x = view.x(mark.time)
        if 0 <= x < view.width:
            found.setdefault(x, []).append(mark.label)
    return {x: ", ".join(labels) for x, labels in found.items()}


def time_axis_step(pen: PaintStyle, seconds: float, width: int) -> float:
    """Return the step of a time axis of some seconds and pixels, s.

    Labels stand well apart, but rather nearer than that there is only one: those at the edges
    have no room, whatever the time. One label is no scale.
    """

    def room(step: float) -> float:
        return _LABEL_SPACING * pen.width(
            clock_text(3600.0, decimals=_step_digits(step)), _LABEL_SIZE
        )

    usual = time_step(
        seconds, max(width / (_WIDE_LABEL_SPACING * pen.width("00:00", _LABEL_SIZE)), 2.0)
    )
    if 2.0 * usual * width / seconds <= width - room(usual):
        return usual
    nearer = time_step(seconds, max(width / room(usual), 2.0))
    return nearer if nearer * width / seconds >= room(nearer) else usual


def _step_digits(step: float) -> int:
    return step_decimals(step) if step < 1.0 else 0


def _place_labels(labels: list[tuple[float, float, str]], width: int) -> list[tuple[float, str]]:
    """Return where labels of places and half widths stand whole.

    Those at the edges have no room; where there would be but one without them, they are moved
    inwards as far as they must.
    """
    whole = [(x, label) for x, half, label in labels if half <= x <= width - half]
    if len(whole) > 1:
        return whole
    placed: list[tuple[float, str]] = []
    end = 0.0
    for x, half, label in labels:
        moved = min(max(x, half), width - half)
        if moved - half >= end:
            placed.append((moved, label))
            end = moved + _LABEL_SPACING * half
    return placed


def draw_time_axis(pen: PaintStyle, step: float, hidden: int) -> None:
    """Write the time axis: flight time under the grid lines and at the cursors."""
    theme = pen.theme
    axis, plot = pen.geometry.axis, pen.geometry.plot
    line = max(pen.px(1), 1)
    pen.painter.fillRect(QRect(plot.x, axis.y, plot.width, line), pen.color(theme.axis))
    center = axis.y + pen.px(14)
    first, last = pen.view.columns
    decimals = _step_digits(step)
    labels: list[tuple[float, float, str]] = []
    for time in multiples(pen.view.scale.time(first), pen.view.scale.time(last), step):
        x = pen.view.x(time)
        if not 0 <= x < plot.width:
            continue
        pen.painter.fillRect(QRect(plot.x + x, axis.y, line, pen.px(5)), pen.color(theme.axis))
        label = clock_text(time, decimals=decimals)
        labels.append((x, pen.width(label, _LABEL_SIZE) / 2.0, label))
    times = _cursor_times(pen, plot.width, pen.view)
    placed = _place_labels(labels, plot.width)
    free = [
        (x, label)
        for x, label in placed
        if not any(
            abs(2.0 * x - left - right) < right - left + pen.width(label, _LABEL_SIZE) + pen.px(8)
            for left, right, _, _ in times
        )
    ]
    if len(free) + len(times) < 2:
        # A single label is no scale.
        times, free = [], placed
    for label_x, label in free:
        pen.text(plot.x + label_x, center, label, theme.text, _LABEL_SIZE, align="center")
    for left, right, text, color in times:
        box = QRect(plot.x + left, axis.y + pen.px(5), right - left, pen.px(18))
        pen.painter.fillRect(box, pen.color(color))
        pen.text(plot.x + (left + right) / 2.0, center, text, theme.background, _LABEL_SIZE,
            bold=True, align="center",
        )  # fmt: skip
    note = tr("flight time") if not hidden else tr("{hidden} more: Up, Down").format(hidden=hidden)
    pen.text(
        pen.geometry.columns.gutter + pen.px(4),
        center,
        note,
        theme.muted if not hidden else theme.text,
        _LABEL_SIZE,
        room=plot.x - pen.geometry.columns.gutter - pen.px(12),
    )


def _cursor_times(
    pen: PaintStyle, width_of_plot: int, view: StripView
) -> list[tuple[int, int, str, str]]:
    """Return first and last column, text and color of the times of the cursors in sight."""
    names: dict[float, list[str]] = {}
    for name, time in sorted(view.cursors.items(), key=lambda one: (one[1], one[0] != "cursor")):
        if 0 <= view.x(time) < width_of_plot:
            names.setdefault(time, []).append(name)
    taken: list[tuple[int, int, str, str]] = []
    for time, those in names.items():
        letters = "".join(_CURSOR_LETTERS[name] for name in those)
        text = f"{letters} {clock_text(time, decimals=2)}"
        width = math.ceil(pen.width(text, _LABEL_SIZE, bold=True)) + pen.px(8)
        # Beside the one before, and the last ones as far right as they can.
        left = max(view.x(time) - width // 2, taken[-1][1] + pen.px(2) if taken else 0)
        left = min(left, width_of_plot - width)
        if left >= (taken[-1][1] if taken else 0):
            taken.append((left, left + width, text, cursor_color(pen.theme, those[-1])))
    return taken


def draw_cursor_lines(pen: PaintStyle, first: int, last: int) -> None:
    """Draw the cursors through all charts, and a bar from A to B.

    Only what lies in the columns ``first <= x < last`` from the left edge needs to be drawn.
    """
    theme, plot = pen.theme, pen.geometry.plot
    places = {name: pen.view.x(time) for name, time in pen.view.cursors.items()}
    if "a" in places and "b" in places:
        left, right = sorted((places["a"], places["b"]))
        left, right = max(left, first), min(right, last)
        if right > left:
            bracket = QRect(plot.x + left, plot.y + pen.px(6), right - left, max(pen.px(2), 1))
            pen.painter.fillRect(bracket, pen.color(theme.cursor))
    line = max(pen.px(1), 1)
    near = pen.px(14)
    for name, x in places.items():
        if not 0 <= x < plot.width or not first - near <= x < last + near:
            continue
        color = pen.color(cursor_color(theme, name))
        pen.painter.fillRect(QRect(plot.x + x, plot.y, line, plot.height), color)
        if name != "cursor":
            size = near
            left = min(max(x - size // 2, 0), plot.width - size)
            pen.painter.fillRect(QRect(plot.x + left, plot.y, size, size), color)
            pen.text(plot.x + left + size / 2.0, plot.y + size / 2.0, name.upper(),
                theme.background, _LABEL_SIZE, bold=True, align="center",
            )  # fmt: skip


def draw_empty_message(pen: PaintStyle, text: str) -> None:
    """Say in the middle of the plot why there is nothing to see, in as many lines as it takes."""
    plot, margin = pen.geometry.plot, pen.px(8)
    pen.painter.setPen(QPen(pen.color(pen.theme.muted)))
    pen.painter.setFont(pen.font(pen.px(_BODY_SIZE), bold=False, italic=False)[0])
    pen.painter.drawText(
        QRectF(plot.x + margin, plot.y, plot.width - 2 * margin, plot.height),
        Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap,
        text,
    )
