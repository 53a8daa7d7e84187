"""The derivatives beside the charts while they form: value, bound, excitation, history."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetricsF, QKeyEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QListView,
    QStackedLayout,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from gsapp.quantities import FloatArray, trace_color
from ui.display_limits import DISPLAY
from ui.display_style import DisplayStyle
from ui.flight.evidence_panel import EvidencePanel
from ui.number_format import DASH, count_text, number_text, symbol_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label
from ui.widgets.row_model import VALUE_ROLE, ModelIndex, TableRow, TableRowModel
from ui.widgets.table_menu import TableMenu

if TYPE_CHECKING:
    from gsapp.session.live_estimation.estimate_table import EstimateRow

_ROW_HEIGHT: Final = 64  # Height of a derivative, points at 100 %.
_MARGIN: Final = 12
_PLOT_WIDTH: Final = 112  # Width of the history, points.
_TEXT_WIDTH: Final = 150  # Width that words and numbers take beside it at least.

_ARROW: Final = "→"  # Between the bounds in percent before and after the last maneuver.


def _build_row(row: EstimateRow) -> TableRow:
    spoken = accessible_row_text(row)
    return TableRow(key=row.name, cells=(spoken,), detail=row.why or spoken, value=row)


def accessible_row_text(row: EstimateRow) -> str:
    """Return a row as a sentence."""
    best = row.best
    if best is None:
        return tr("{name} unknown: {reason}").format(
            name=symbol_text(row.name), reason=row.why or tr("not excited yet")
        )
    text = f"{symbol_text(row.name)} {estimate_value_text(*best)}"
    if row.percent is not None:
        text += tr(", standard error {bound_percent}").format(
            bound_percent=bound_percent_text(row.percent)
        )
    if row.change_text:
        text += tr(", last maneuver: {change}").format(change=row.change_text)
    return text


def describe_value(row: EstimateRow) -> tuple[str, str]:
    """Return the value to go by, whose bound in percent stands above it, and what is beside it."""
    change = row.change_text.replace(" % to ", _ARROW)
    live = (
        ""
        if row.value is None
        else tr("FTR {value}").format(value=estimate_value_text(row.value, row.std or 0.0))
    )
    if row.mean is None:
        return live or tr("unknown"), change
    best = tr("{method} {value}").format(
        method=_method_text(row), value=estimate_value_text(row.mean.mean, row.mean.std)
    )
    if _ARROW in change:
        # It ends with the bound in percent; both have no room.
        live = live.partition(" ±")[0]
    return best, "  ".join(part for part in (live, change) if part)


def _method_text(row: EstimateRow) -> str:
    """Return by which methods the fits of a derivative are, as short as the legend has them."""
    return "/".join(one.upper() for one in row.methods)


def estimate_value_text(value: float, std: float) -> str:
    """Return a value with as many digits as its bound earns, and the bound."""
    decimals = 1
    while decimals < 6 and std < 9.5 * 10.0**-decimals:
        decimals += 1
    return f"{number_text(value, decimals)} ± {number_text(std, decimals)}"


def bound_percent_text(percent: float) -> str:
    """Return a bound in percent."""
    if percent > 999.0:
        return "> 999 %"
    return f"{percent:.0f} %" if percent >= 9.5 else f"{percent:.1f} %"


class EstimateDelegate(QStyledItemDelegate):
    """Paints a derivative: words and number left, its history right."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style

    def sizeHint(self, _option: QStyleOptionViewItem, _index: ModelIndex) -> QSize:
        return QSize(self._style.px(200), self._style.px(_ROW_HEIGHT))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        row = index.data(VALUE_ROLE)
        style, px = self._style, self._style.px
        theme = style.theme
        box = QRectF(option.rect)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)
        if option.state & QStyle.StateFlag.State_Selected:
            painter.fillRect(box, QColor(theme.grid))
        painter.setPen(QPen(QColor(theme.grid), 1))
        painter.drawLine(box.bottomLeft(), box.bottomRight())
        inner = box.adjusted(px(_MARGIN), px(5), -px(_MARGIN), -px(5))
        wide = inner.width() > px(_PLOT_WIDTH + _TEXT_WIDTH)
        plot = QRectF(inner.right() - px(_PLOT_WIDTH), inner.top(), px(_PLOT_WIDTH), inner.height())
        text = QRectF(inner)
        if wide:
            text.setRight(plot.left() - px(10))
            self._paint_history(painter, plot, row)
        self._paint_words(painter, text, row)
        painter.restore()

    def _paint_words(self, painter: QPainter, box: QRectF, row: EstimateRow) -> None:
        style, theme = self._style, self._style.theme
        line = box.height() / 3.0
        top = QRectF(box.left(), box.top(), box.width(), line)
        middle = top.translated(0.0, line)
        low = middle.translated(0.0, line)
        value, beside = describe_value(row)
        painter.setFont(style.font("body", strong=True))
        painter.setPen(QColor(theme.text))
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft | _CENTER, symbol_text(row.name))
        painter.setPen(QColor(theme.muted if row.best is None else theme.text))
        percent = DASH if row.percent is None else f"±{bound_percent_text(row.percent)}"
        painter.drawText(top, Qt.AlignmentFlag.AlignRight | _CENTER, percent)
        painter.setFont(style.font("body"))
        painter.drawText(middle, Qt.AlignmentFlag.AlignLeft | _CENTER, value)
        painter.setFont(style.font("label"))
        painter.setPen(QColor(theme.muted))
        if row.value is None:
            self._paint_excitation(painter, low, row)
            return
        metrics = QFontMetricsF(painter.font())
        painter.drawText(
            low,
            Qt.AlignmentFlag.AlignLeft | _CENTER,
            metrics.elidedText(beside, Qt.TextElideMode.ElideRight, low.width()),
        )

    def _paint_excitation(self, painter: QPainter, box: QRectF, row: EstimateRow) -> None:
        """Paint how far the excitation is from what it takes; a word stands beside the bar."""
        style, theme, px = self._style, self._style.theme, self._style.px
        progress = min(max(row.progress, 0.0), 1.0)
        text = tr("excited {progress:.0f} %").format(progress=100.0 * progress)
        width = QFontMetricsF(style.font("label")).horizontalAdvance(tr("excited 100 %"))
        bar = QRectF(
            box.left() + width + px(8), box.center().y() - px(3), box.width() - width - px(8), px(6)
        )
        painter.drawText(box, Qt.AlignmentFlag.AlignLeft | _CENTER, text)
        if bar.width() < px(16):
            return
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.grid))
        painter.drawRect(bar)
        painter.setBrush(QColor(theme.trace(trace_color(row.name))))
        painter.drawRect(QRectF(bar.left(), bar.top(), bar.width() * progress, px(6)))

    def _paint_history(self, painter: QPainter, box: QRectF, row: EstimateRow) -> None:
        """Paint FTR's line, the points of maximum likelihood, and what was known before."""
        theme, px = self._style.theme, self._style.px
        painter.fillRect(box, QColor(theme.plot))
        best = row.best
        if best is None or not row.times.size:
            return
        value, std = best
        reach = DISPLAY.history_sigmas * max(std, row.std or 0.0)
        if row.prior is not None:
            # What was known before stays in sight, unless it is far from everything.
            away = abs(row.prior - value)
            reach = max(reach, 1.2 * away) if away < 4.0 * reach else reach
        if not reach > 0.0:
            return
        first, last = float(row.times[0]), float(row.times[-1])
        span = max(last - first, 1.0)

        def places(
            times: FloatArray | float, numbers: FloatArray | float
        ) -> tuple[FloatArray, FloatArray]:
            shares = np.clip((np.asarray(numbers) - value) / reach, -1.0, 1.0)
            return (
                box.left() + (np.asarray(times) - first) / span * box.width(),
                box.center().y() - 0.46 * shares * box.height(),
            )

        def place(time: float, number: float) -> QPointF:
            x, y = places(time, number)
            return QPointF(float(x), float(y))

        painter.setClipRect(box)
        if row.prior is not None:
            painter.setPen(QPen(QColor(theme.previous), px(1), Qt.PenStyle.DotLine))
            painter.drawLine(place(first, row.prior), place(last, row.prior))
        painter.setPen(QPen(QColor(theme.trace(trace_color(row.name))), px(1.5)))
        from pyqtgraph.functions import arrayToQPolygonF  # a quarter of a second

        # One point per point of width shows all that can be seen.
        step = max(1, row.times.size // _PLOT_WIDTH)
        x, y = places(row.times[::step], row.values[::step])
        for run in _contiguous_segments(np.isfinite(y)):
            painter.drawPolyline(arrayToQPolygonF(x[run], y[run]))
        color = QColor(theme.text)
        painter.setPen(QPen(color, px(1)))
        painter.setBrush(color)
        for point in row.points:
            half = DISPLAY.bar_sigmas * point.std
            painter.drawLine(place(point.time, point.value - half),
                             place(point.time, point.value + half))  # fmt: skip
            painter.drawEllipse(place(point.time, point.value), px(2.5), px(2.5))
        painter.setClipping(False)


_CENTER = Qt.AlignmentFlag.AlignVCenter


def _contiguous_segments(good: np.ndarray) -> list[slice]:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], good.astype(int), [0]))))
    return [slice(int(one), int(other)) for one, other in edges.reshape(-1, 2)]


def _format_number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


class EstimatesList(QListView):
    """The rows; Enter goes to the last maneuver that gave the derivative."""

    opened = Signal(str)  # The derivative that the user pressed Enter on.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self.row_model = TableRowModel(style, (tr("Derivative"),))
        self._style = style
        self.setModel(self.row_model)
        self.menu = TableMenu(self, table=self._table)
        self.menu.add_command(tr("Go to the last maneuver"), self._open)
        self.setItemDelegate(EstimateDelegate(style))
        self.setAccessibleName(tr("Derivatives"))
        self.setUniformItemSizes(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.doubleClicked.connect(self._open)
        style.changed.connect(self.row_model.refresh)

    def _table(self) -> list[tuple[str, ...]]:
        """Return value and standard error of each derivative by FTR and by fits, per radian."""
        rows = [
            (
                row.name, *map(_format_number, (row.value, row.std)),
                *map(_format_number, (None, None) if row.mean is None else (row.mean.mean,
                row.mean.std)),
                "" if row.mean is None else _method_text(row), _format_number(row.prior), row.why,
            )
            for row in (one.value for one in self.row_model.rows)
        ]  # fmt: skip
        return [
            (tr("Derivative"), "FTR", tr("FTR std"), tr("Fit"), tr("Fit std"), tr("Fit by"),
             tr("Prior"), tr("Remark")),
            *rows,
        ]  # fmt: skip

    def _open(self) -> None:
        if self.currentIndex().isValid():
            self.opened.emit(self.row_model.rows[self.currentIndex().row()].key)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._open()
        else:
            super().keyPressEvent(event)


_LEGEND_ENTRIES = (
    ("line", QT_TR_NOOP("FTR, in flight")),
    ("point", QT_TR_NOOP("ML or filter error (FEM), ±2 standard errors")),
    ("known", QT_TR_NOOP("Prior")),
    ("", QT_TR_NOOP("±%: standard error / value")),
)
"""What is drawn and written in the rows, by the sign before it."""


class EstimatesLegend(QWidget):
    """Explains what the rows draw, and their percentage."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setAccessibleName(
            tr("Legend: {entries}").format(
                entries=", ".join(tr(text) for _, text in _LEGEND_ENTRIES)
            )
        )
        style.changed.connect(self.updateGeometry)

    def _places(self, width: float) -> list[tuple[float, float]]:
        """Return where each entry begins; those without room go into the next line."""
        px, metrics = self._style.px, QFontMetricsF(self._style.font("label"))
        x = y = 0.0
        found = []
        for sign, text in _LEGEND_ENTRIES:
            needed = metrics.horizontalAdvance(tr(text)) + (px(22) if sign else 0)
            if x and x + needed > width - 2 * px(_MARGIN):
                x, y = 0.0, y + px(18)
            found.append((x + px(_MARGIN), y))
            x += needed + px(14)
        return found

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        return round(self._places(width)[-1][1]) + self._style.px(24)

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(200), self.heightForWidth(max(self.width(), 1)))

    def paintEvent(self, _event: QPaintEvent) -> None:
        style, theme, px = self._style, self._style.theme, self._style.px
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)
        painter.setFont(style.font("label"))
        for (sign, text), (x, y) in zip(_LEGEND_ENTRIES, self._places(self.width()), strict=True):
            middle = y + px(11)
            if sign == "point":
                painter.setPen(QPen(QColor(theme.text), px(1)))
                painter.setBrush(QColor(theme.text))
                painter.drawLine(
                    QPointF(x + px(8), middle - px(6)), QPointF(x + px(8), middle + px(6))
                )
                painter.drawEllipse(QPointF(x + px(8), middle), px(2.5), px(2.5))
            elif sign:
                dotted = sign == "known"
                color = theme.previous if dotted else theme.text
                pen_style = Qt.PenStyle.DotLine if dotted else Qt.PenStyle.SolidLine
                painter.setPen(QPen(QColor(color), px(1 if dotted else 1.5), pen_style))
                painter.drawLine(QPointF(x, middle), QPointF(x + px(16), middle))
            painter.setPen(QColor(theme.muted))
            room = QRectF(x + (px(22) if sign else 0), y, self.width(), px(22))
            painter.drawText(room, Qt.AlignmentFlag.AlignLeft | _CENTER, tr(text))
        painter.end()


class EstimatesPanel(QWidget):
    """Derivatives with a sentence in their place while there are none."""

    opened = Signal(str)  # A derivative whose last maneuver is to be shown.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        column = arrange(QVBoxLayout(self), 0)
        self._state = create_label("", "label", wrap=True)
        self._state.setContentsMargins(12, 8, 12, 4)
        column.addWidget(self._state)
        self._legend = EstimatesLegend(style)
        column.addWidget(self._legend)
        holder = QWidget()
        self._pile = QStackedLayout(holder)
        self._empty = create_label("", "muted", wrap=True)
        self._empty.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._empty.setContentsMargins(16, 16, 16, 16)
        self._pile.addWidget(self._empty)
        self.list = EstimatesList(style)
        self._pile.addWidget(self.list)
        column.addWidget(holder, 1)
        self.search = EvidencePanel(style)
        self.search.setVisible(False)
        column.addWidget(self.search)
        self.list.opened.connect(self.opened)
        self.show_rows((), "")

    def show_rows(self, rows: Sequence[EstimateRow], state: str) -> None:
        """Show derivatives, and a line on how the fits stand."""
        self._state.setText(state)
        self._state.setVisible(bool(state))
        self._legend.setVisible(bool(rows))
        self.list.row_model.set_rows(map(_build_row, rows))
        self._pile.setCurrentIndex(1 if rows else 0)
        if not rows:
            # The panel has the focus itself while the list is hidden.
            self.setAccessibleName(self.list.accessibleName())
            self._empty.setText(
                tr(
                    "Derivatives appear here as maneuvers are flown. Requires an aircraft file and "
                    "measured surfaces and rates."
                )
            )
        # The stub lacks None, which Qt takes.
        self.setFocusProxy(self.list if rows else None)  # type: ignore[arg-type]


def fit_status_text(fitted: int, pending: int, failures: dict[str, str]) -> str:
    """Return how the fits of the maneuvers stand."""
    parts = []
    if fitted:
        parts.append(tr("{maneuvers} fitted").format(maneuvers=count_text(fitted, "maneuver")))
    if pending:
        parts.append(tr("{pending} in progress").format(pending=pending))
    if failures:
        last = next(reversed(failures))
        parts.append(tr("{last} not fitted: {failure}").format(last=last, failure=failures[last]))
    return " · ".join(parts)
