"""A pyqtgraph plot in the look of the window, and the legend above it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyqtgraph
from pyqtgraph.graphicsItems.ScatterPlotItem import Symbols
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import (
    QColor,
    QFontMetrics,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPixmap,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QFrame,
    QGraphicsPixmapItem,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.foundation.delimited_text import delimited_text
from gsapp.quantities import FloatArray
from ui.display_style import DisplayStyle
from ui.number_format import MINUS, clock_text, sanitize_file_name
from ui.shortcut_filter import ArrowKeyNavigation
from ui.strips.axis_ticks import step_decimals, time_step
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.crosshair_keys import CrosshairKeys
from ui.widgets.figure_menu import ContentFunction, FigureMenu, render_widget
from ui.widgets.flow_layout import FlowLayout, arrange, clear_layout
from ui.widgets.labels import create_label
from ui.widgets.paint_primitives import curve_color, paint_focus_frame, paint_readout

_MIN_HEIGHT = 168  # Points of height below which a plot says too little.
_MOST_POINTS = 4000
_TICK_SPACING = 1.7  # Distance of times along an axis, in widths of a time.
_LARGE_SYMBOL_SIZE = 11  # Points across of a point with a shape of its own.
_MARGIN, _MARGIN_OF_POINTS = 0.02, 0.05
"""Beyond the ends of what is drawn, as shares of its width: a large point is not cut."""
_TARGET_ALPHA = 0.28
_MIN_TICKS_WIDTH = 8  # Points up to which a line is no curve to be read: limits, means.
_PICTURE_DEPTH = -40  # Below bands.
_PICTURE_OPACITY = 0.55  # Curves of each look stand out from it.
_ZOOM = 0.8  # Factor of the range that a notch of the wheel zooms by.
_UNIT_PATTERN = re.compile(r"(.*?)(?:, | \[)([^\],]*)\]?")
"""Symbol and unit in the title of an axis."""
FLIGHT_TIME_LABEL = QT_TR_NOOP("flight time, mm:ss.s")
"""Title of an axis of flight time; its ticks are a clock."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlotCurve:
    """One line, or one cloud of points."""

    x: FloatArray
    y: FloatArray
    color: str  # Name of a trace color, ``previous``, or a role of the look.
    name: str = ""  # In the legend; empty for none.
    dashed: bool = False  # Computed values are dashed.
    points: bool = False  # Points in place of a line.
    symbol: str = ""  # Shape of large points, as pyqtgraph names it; empty for small round ones.


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotBand:
    """A range across the plot, of y (``across``) or of x; one that is wanted is cyan."""

    low: float
    high: float
    name: str = ""
    is_horizontal: bool = True
    is_target: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotPicture:
    """A picture below the curves: its edges in the values of the axes."""

    image: QImage
    west: float
    south: float
    east: float
    north: float


class LegendSymbol(QWidget):
    """A short piece of a curve, or of a band."""

    def __init__(self, style: DisplayStyle, curve: PlotCurve | PlotBand) -> None:
        super().__init__()
        self._style = style
        self._curve = curve
        self.setFixedSize(style.px(24), style.px(16))

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, curve = self._style, self._curve
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.height() / 2
        if isinstance(curve, PlotBand):
            box = self.rect().adjusted(0, style.px(3), -1, -style.px(3))
            painter.fillRect(box, band_color(style, curve))
            painter.setPen(style.color("span_edge"))
            painter.drawRect(box)
        elif curve.symbol:
            painter.setBrush(curve_color(style, curve.color))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.translate(0.5 * self.width(), middle)
            painter.scale(style.px(_LARGE_SYMBOL_SIZE), style.px(_LARGE_SYMBOL_SIZE))
            painter.drawPath(Symbols[curve.symbol])
        elif curve.points:
            painter.setBrush(curve_color(style, curve.color))
            painter.setPen(Qt.PenStyle.NoPen)
            for place in (0.25, 0.5, 0.75):
                painter.drawEllipse(QPointF(self.width() * place, middle), *[style.px(2)] * 2)
        else:
            painter.setPen(curve_pen(style, curve))
            painter.drawLine(QPointF(0, middle), QPointF(self.width(), middle))
        painter.end()


def curve_pen(style: DisplayStyle, curve: PlotCurve) -> QPen:
    """Return the pen of a curve."""
    pen = QPen(curve_color(style, curve.color))
    pen.setWidthF(style.theme.line_width * style.sizes.scale * 0.85)
    pen.setCosmetic(True)
    if curve.dashed:
        pen.setDashPattern([4.0, 2.5])
    return pen


def band_color(style: DisplayStyle, band: PlotBand) -> QColor:
    """Return the fill of a band: the noise floor lies across, a stretch of interest upright."""
    if band.is_target:
        color = style.color("target")
        color.setAlphaF(_TARGET_ALPHA)
        return color
    return style.color("chosen" if band.is_horizontal else "event")


class PlotLegend(QWidget):
    """What each curve is; breaks into rows where the window is narrow."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._shown: tuple[PlotCurve | PlotBand, ...] = ()
        self._flow = FlowLayout(self, spacing=style.px(12))
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)

    def show_entries(self, entries: Sequence[PlotCurve | PlotBand]) -> None:
        clear_layout(self._flow)
        self._flow.setSpacing(self._style.px(12))
        for one in entries:
            if not one.name:
                continue
            holder = QWidget()
            row = FlowLayout(holder, spacing=self._style.px(6))
            row.addWidget(LegendSymbol(self._style, one))
            row.addWidget(create_label(one.name, "label"))
            self._flow.addWidget(holder)
            holder.show()
        self.updateGeometry()


class AnalysisPlot(QFrame):
    """A titled plot with legend.

    The wheel zooms x at the pointer (over the left axis, values), a drag zooms to a rectangle,
    the middle button moves, a double click shows everything. Left and Right move, Up and Down
    zoom, Home shows everything. Values stand beside the pointer; the menu saves and copies.
    """

    def __init__(self, style: DisplayStyle, name: str, *, high: int = _MIN_HEIGHT) -> None:
        super().__init__()
        self._style = style
        self._name = name
        self._high = high
        self._drawn: tuple[tuple[PlotCurve, ...], tuple[PlotBand, ...]] = ((), ())
        self._labels = ("", "")
        column = arrange(QVBoxLayout(self), style.px(4))
        self._column = column
        self.title = create_label(name, "heading", wrap=True)
        column.addWidget(self.title)
        self.legend = PlotLegend(style)
        column.addWidget(self.legend)
        self.plot = _PlotArea(style, name)
        column.addWidget(self.plot, 1)
        self.setFocusProxy(self.plot)
        self.menu = FigureMenu(self.plot, self._file, self._content, self.plot.fit_view)
        style.changed.connect(self._restyle)
        self._restyle()

    def draw(
        self,
        curves: Sequence[PlotCurve],
        bands: Sequence[PlotBand] = (),
        *,
        title: str,
        bottom: str,
        left: str,
        words: str = "",
        keep_zoom: bool = False,
    ) -> None:
        """Draw other curves.

        `words`: the picture in a sentence, for those who hear it. `keep_zoom`: what the user has
        zoomed to stays in sight.
        """
        is_kept = keep_zoom and self.plot.is_zoomed
        self._drawn = (tuple(curves), tuple(bands))
        self.menu.enable(bool(curves))
        self._labels = (bottom, left)
        self.title.setText(title)
        self.plot.setAccessibleDescription(words or title)
        self._redraw()
        if not is_kept:
            self.plot.fit_view()

    def show_pictures(self, pictures: Sequence[PlotPicture]) -> None:
        """Show other pictures below the curves; those drawn before stay with `draw`."""
        self.plot.show_pictures(pictures)

    @property
    def edges(self) -> tuple[float, float, float, float]:
        """Return the left, lower, right and upper edges in sight, in the values of the axes."""
        (left, right), (low, high) = self.plot.getPlotItem().getViewBox().viewRange()
        return float(left), float(low), float(right), float(high)

    def lock_aspect(self, locked: bool) -> None:
        """Draw both axes at one scale, or each at its own."""
        self.plot.getPlotItem().getViewBox().setAspectLocked(locked)

    def _file(self) -> Path:
        return Path.home() / f"{sanitize_file_name(self.title.text()) or 'chart'}.png"

    def _content(self, ending: str) -> ContentFunction:
        """Return the content of a file: the chart as it looks, or its curves as rows of x, y."""
        if ending not in (".csv", ".tsv"):
            picture = render_widget(self, ending)  # the thread must not touch a widget
            return lambda: picture
        curves, titles = self._drawn[0], (strip_markup(title) for title in self._labels)
        heading = ("curve", *titles)

        def rows() -> bytes:
            points = (
                (curve.name, repr(float(x)), repr(float(y)))
                for curve in curves
                for x, y in zip(curve.x, curve.y, strict=True)
            )
            return delimited_text([heading, *points], "," if ending == ".csv" else "\t").encode()

        return rows

    def _redraw(self) -> None:
        curves, bands = self._drawn
        self.plot.show_items(curves, bands, *self._labels)
        entries: tuple[PlotCurve | PlotBand, ...] = (*curves, *bands)
        self.legend.show_entries(entries)
        self.legend.setVisible(any(one.name for one in entries))

    def _restyle(self) -> None:
        self.plot.setMinimumHeight(self._style.px(self._high))
        self.plot.restyle()
        self._column.setSpacing(self._style.px(4))
        self._redraw()


class _PlotAxis(pyqtgraph.AxisItem):
    """An axis with a true minus sign and no factor hidden in its label, or a clock."""

    def __init__(self, **options: object) -> None:
        super().__init__(**options)
        self.enableAutoSIPrefix(False)
        self.clock = False  # Whether the values are flight time.

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        if not self.clock:
            return list(super().tickSpacing(low, high, size))
        return [(time_step(high - low, max(size / (_TICK_SPACING * self.font_width()), 2.0)), 0.0)]

    def font_width(self) -> float:
        """Return the width of a time, pixels."""
        font = self.style["tickFont"]
        return QFontMetrics(font).horizontalAdvance("00:00.0") if font is not None else 48.0

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        if self.clock:
            decimals = max(step_decimals(spacing), 1)
            return [clock_text(value, decimals=decimals) for value in values]
        return [text.replace("-", MINUS) for text in super().tickStrings(values, scale, spacing)]


class _PlotArea(ArrowKeyNavigation, pyqtgraph.PlotWidget):
    """The plot itself."""

    def __init__(self, style: DisplayStyle, name: str) -> None:
        super().__init__(
            axisItems={side: _PlotAxis(orientation=side) for side in ("left", "bottom")}
        )
        self._style = style
        self.setAccessibleName(tr("Chart: {name}").format(name=name))
        self.setMouseTracking(True)
        self.pointer: QPointF | None = None
        self._crosshair = CrosshairKeys(self)
        self._curves: tuple[PlotCurve, ...] = ()
        self._pictures: list[QGraphicsPixmapItem] = []
        self._titles = ("", "")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFrameShape(QFrame.Shape.NoFrame)
        item = self.getPlotItem()
        item.setMenuEnabled(False)
        item.hideButtons()
        item.getViewBox().setMouseMode(pyqtgraph.ViewBox.RectMode)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._whole: tuple[float, float] | None = None
        self._fitted = self._wanted_range()
        self._margin = _MARGIN

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(320), self._style.px(220))

    def restyle(self) -> None:
        style = self._style
        self.setBackground(style.color("panel"))
        item = self.getPlotItem()
        item.getViewBox().setBorder(pyqtgraph.mkPen(style.color("axis")))
        font = style.font("label")
        for side in ("left", "bottom"):
            axis = item.getAxis(side)
            axis.setPen(pyqtgraph.mkPen(style.color("axis")))
            axis.setTextPen(pyqtgraph.mkPen(style.color("text")))
            axis.setTickFont(font)
            axis.setStyle(tickTextOffset=style.px(4), tickLength=-style.px(4))
            axis.label.setFont(font)
        item.getAxis("left").setWidth(style.px(64))
        # Ticks and label below each other, with the margin that rich text brings.
        item.getAxis("bottom").setHeight(2 * QFontMetrics(font).height() + 12 + style.px(6))
        item.showGrid(x=True, y=True, alpha=0.18)

    def show_items(
        self, curves: Sequence[PlotCurve], bands: Sequence[PlotBand], bottom: str, left: str
    ) -> None:
        style, item = self._style, self.getPlotItem()
        item.clear()
        self._curves, self._titles = tuple(curves), (bottom, left)
        item.getAxis("bottom").clock = bottom == FLIGHT_TIME_LABEL
        for band in bands:
            if not (np.isfinite(band.low) and np.isfinite(band.high)):
                continue
            region = pyqtgraph.LinearRegionItem(
                (band.low, band.high),
                orientation="horizontal" if band.is_horizontal else "vertical",
                movable=False,
                brush=band_color(style, band),
                pen=pyqtgraph.mkPen(style.color("span_edge"), width=1),
            )
            region.setZValue(-20 if band.is_horizontal else -30)
            item.addItem(region, ignoreBounds=not band.is_horizontal)
        for curve in curves:
            item.addItem(self._create_item(curve))
        label_style = {"color": style.color("text").name(), "font-size": f"{style.sizes.label}px"}
        item.setLabel("bottom", tr(bottom), **label_style)
        item.setLabel("left", left, **label_style)
        finite = [curve.x[np.isfinite(curve.x)] for curve in curves]
        ends = [(float(x[0]), float(x[-1])) if x.size else None for x in map(np.sort, finite)]
        known = [pair for pair in ends if pair is not None]
        self._whole = (
            (min(low for low, _ in known), max(high for _, high in known)) if known else None
        )
        self._margin = _MARGIN_OF_POINTS if any(one.symbol for one in curves) else _MARGIN

    def show_pictures(self, pictures: Sequence[PlotPicture]) -> None:
        box = self.getPlotItem().getViewBox()
        for item in self._pictures:
            box.removeItem(item)
        self._pictures = []
        for one in pictures:
            item = QGraphicsPixmapItem(QPixmap.fromImage(one.image))
            item.setTransformationMode(Qt.TransformationMode.SmoothTransformation)
            across = (one.east - one.west) / one.image.width()
            down = (one.south - one.north) / one.image.height()
            item.setTransform(QTransform(across, 0.0, 0.0, down, one.west, one.north))
            item.setZValue(_PICTURE_DEPTH)
            item.setOpacity(_PICTURE_OPACITY)
            box.addItem(item, ignoreBounds=True)
            self._pictures.append(item)

    def _create_item(self, curve: PlotCurve) -> pyqtgraph.PlotDataItem:
        style = self._style
        every = max(curve.x.size // _MOST_POINTS, 1)
        if curve.points:
            color = curve_color(style, curve.color)
            return pyqtgraph.ScatterPlotItem(
                curve.x[::every],
                curve.y[::every],
                size=style.px(
                    _LARGE_SYMBOL_SIZE
                    if curve.symbol
                    else 5
                    if curve.name.startswith("maneuver")
                    else 4
                ),
                symbol=curve.symbol or "o",
                pen=None,
                brush=pyqtgraph.mkBrush(color),
            )
        return pyqtgraph.PlotDataItem(
            curve.x, curve.y, pen=curve_pen(style, curve), connect="finite", antialias=True
        )

    def fit_view(self) -> None:
        item = self.getPlotItem()
        if item.getViewBox().state["aspectLocked"]:
            # With one scale for both axes a range that follows the values of y alone would cut x.
            item.getViewBox().autoRange(padding=self._margin)
            self._fitted = self._wanted_range()
            return
        item.enableAutoRange(x=False, y=True)
        item.setAutoVisible(y=False)
        if self._whole is not None and self._whole[1] > self._whole[0]:
            item.setXRange(*self._whole, padding=self._margin)
        self._fitted = self._wanted_range()

    @property
    def is_zoomed(self) -> bool:
        """Return whether the user shows another range of x than all."""
        return self._wanted_range() != self._fitted

    def _wanted_range(self) -> tuple[float, float]:
        low, high = self.getPlotItem().getViewBox().targetRange()[0]
        return float(low), float(high)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        box = self.getPlotItem().getViewBox()
        low, high = box.viewRange()[0]
        span = high - low
        moves = {Qt.Key.Key_Left: -0.2, Qt.Key.Key_Right: 0.2}
        zooms = {Qt.Key.Key_Up: 0.7, Qt.Key.Key_Down: 1 / 0.7}
        key = Qt.Key(event.key())
        is_crosshair, pointer = self._crosshair.move(event, self._area(), self.pointer)
        if is_crosshair:
            self.pointer = pointer
            self._crosshair.describe("" if pointer is None else self.text_at(pointer))
            self.viewport().update()
        elif key in moves:
            box.setXRange(low + moves[key] * span, high + moves[key] * span, padding=0)
        elif key in zooms:
            middle, half = (low + high) / 2, zooms[key] * span / 2
            box.setXRange(middle - half, middle + half, padding=0)
        elif key == Qt.Key.Key_Home:
            self.fit_view()
        else:
            event.ignore()

    def wheelEvent(self, event: QWheelEvent) -> None:
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            event.ignore()
            return
        box = self.getPlotItem().getViewBox()
        if not self._area().contains(event.position()):
            super().wheelEvent(event)
            return
        at = box.mapSceneToView(self.mapToScene(event.position().toPoint()))
        low, high = box.viewRange()[0]
        factor = _ZOOM ** (event.angleDelta().y() / 120)
        box.setXRange(*(at.x() + factor * (end - at.x()) for end in (low, high)), padding=0)
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.fit_view()
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        super().mouseMoveEvent(event)
        self._crosshair.is_on = False
        self.pointer = event.position()
        self.viewport().update()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.pointer = self.pointer if self._crosshair.is_on else None
        self.viewport().update()

    def _area(self) -> QRectF:
        box = self.getPlotItem().getViewBox()
        return QRectF(self.mapFromScene(box.sceneBoundingRect()).boundingRect())

    def text_at(self, point: QPointF) -> str:
        """Return the values of the curves at a pixel; of the axes where there are only points."""
        box = self.getPlotItem().getViewBox()
        at = box.mapSceneToView(self.mapToScene(point.toPoint()))
        bottom, left = self._titles
        if bottom == FLIGHT_TIME_LABEL:
            parts = [clock_text(at.x(), decimals=2)]
        else:
            parts = [_value_text(bottom, at.x())]
        values = [
            (curve.name, float(np.interp(at.x(), curve.x, curve.y, left=np.nan, right=np.nan)))
            for curve in self._curves
            if not curve.points and curve.x.size > _MIN_TICKS_WIDTH
        ]
        parts += [_value_text(left, value, name) for name, value in values if np.isfinite(value)]
        if len(parts) == 1:
            parts.append(_value_text(left, at.y()))
        return "\n".join(parts)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        area = self._area()
        held = QApplication.mouseButtons() != Qt.MouseButton.NoButton
        if self.pointer is not None and area.contains(self.pointer) and not held:
            painter = QPainter(self.viewport())
            paint_readout(painter, area, self.pointer, self.text_at(self.pointer), self._style)
            painter.end()
        if self.hasFocus():
            painter = QPainter(self.viewport())
            paint_focus_frame(painter, self.viewport().rect(), self._style)
            painter.end()


def strip_markup(title: str) -> str:
    """Return the title of an axis without its markup."""
    return re.sub(r"<[^>]*>", "", title)


def _value_text(title: str, value: float, name: str = "") -> str:
    """Return a value with what its axis says of it: ``q, °/s`` gives ``q measured 3.2 °/s``."""
    match = _UNIT_PATTERN.fullmatch(strip_markup(title))
    symbol, unit = (match[1], match[2]) if match else (strip_markup(title), "")
    number = f"{value:.4g}".replace("-", MINUS)
    return " ".join(filter(None, (symbol, name, number, unit)))
