"""Map and ranking, bars of the gap, the waterfall over the steps, the slider through them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QItemSelectionModel, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QFontMetricsF, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QSizePolicy,
    QSlider,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.quantities import trace_color
from gsapp.report.discrepancy_pictures import ChannelGapPair, WaterfallStep
from ui.commands import shortcut_text
from ui.display_limits import DISPLAY
from ui.display_style import DisplayStyle
from ui.gap.gap_text import channel_symbol, noise_ratio_text
from ui.gap.gap_view_models import ARROW, MapCell
from ui.number_format import percent_text
from ui.shortcut_filter import ArrowKeyNavigation
from ui.translation import tr
from ui.widgets.labels import plain_tooltip
from ui.widgets.paint_primitives import curve_color, level_brushes, paint_focus_frame
from ui.widgets.row_model import VALUE_ROLE, ModelIndex, TableRow
from ui.widgets.table_view import FittedTableView

_ROW = 30
_CELL = 44


class _StyledDelegate(QStyledItemDelegate):
    def __init__(self, style: DisplayStyle, parent: QWidget) -> None:
        super().__init__(parent)
        self._style = style


class _MapCellDelegate(_StyledDelegate):
    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        style, cell = self._style, index.data(VALUE_ROLE)[index.column()]
        fill, text = level_brushes(style, cell.level)
        box = option.rect.adjusted(1, 1, -1, -1)
        painter.save()
        painter.fillRect(box, fill)
        painter.setFont(style.font("body", strong=cell.level > 0))
        painter.setPen(text)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, index.data())
        if cell.proven:
            # A corner, so that it is not told by color alone.
            side = style.px(7)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(text)
            corner = box.topRight()
            painter.drawPolygon([corner, corner - QPoint(side, 0), corner + QPoint(0, side)])
        if option.state & QStyle.StateFlag.State_Selected:
            paint_focus_frame(painter, box, style)
        painter.restore()


class DisagreementMapView(FittedTableView):
    """The map; arrows or the mouse choose a cell."""

    cell_selected = Signal(str, str)

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(
            style, tr("Disagreement map: maneuvers by coefficients"), (), stretch=None,
            least=4, most=16, wrap=False, row_height=_ROW,
        )  # fmt: skip
        self.setItemDelegate(_MapCellDelegate(style, self))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.setCornerButtonEnabled(False)
        header = self.horizontalHeader()
        header.show()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(8)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignCenter)
        self.verticalHeader().show()
        self.verticalHeader().setSectionsClickable(False)
        self.verticalHeader().setTextElideMode(Qt.TextElideMode.ElideRight)

    def _fit_columns(self) -> None:
        """Give the cells the width that their numbers need, and the rest to the maneuvers."""
        cells = self.row_model.columnCount() * self._style.px(_CELL)
        wanted = self.verticalHeader().sizeHint().width()
        room = max(self.width() - cells - self._style.px(12), self._style.px(_CELL))
        self.verticalHeader().setFixedWidth(min(wanted, room))

    def show_map(
        self, coefficients: Sequence[str], rows: Sequence[TableRow], maneuver: str, coefficient: str
    ) -> None:
        self._is_quiet = True
        names = [COEFFICIENT_TITLES.get(name, name) for name in coefficients]
        self.row_model.set_titles(coefficients, dict(enumerate(names)))
        self.show_rows(rows)
        row = self.row_model.find_row(maneuver)
        if row >= 0 and coefficient in coefficients:
            index = self.row_model.index(row, list(coefficients).index(coefficient))
            self.selectionModel().setCurrentIndex(
                index, QItemSelectionModel.SelectionFlag.ClearAndSelect
            )
            self.scrollTo(index)
        self._is_quiet = False
        self._fit_columns()

    def cell(self, maneuver: str, coefficient: str) -> MapCell | None:
        row = self.row_model.find_row(maneuver)
        if row < 0 or coefficient not in self.row_model.titles:
            return None
        cells: Sequence[MapCell] = self.row_model.rows[row].value
        return cells[self.row_model.titles.index(coefficient)]

    def _current_changed(self, current: ModelIndex) -> None:
        if not self._is_quiet and current.isValid():
            maneuver = self.row_model.rows[current.row()].key
            self.cell_selected.emit(maneuver, self.row_model.titles[current.column()])


class DisagreementMapLegend(QWidget):
    """The colors of the map and what they say."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        bounds = [f"{bound:g}" for bound in DISPLAY.map_levels]
        self._words = (tr("noise"), *(tr("from {bound}").format(bound=bound) for bound in bounds))
        self.setAccessibleName(
            tr(
                "Colors: noise, then from {bounds} times the noise floor; a corner "
                "marks significant cells"
            ).format(bounds=", ".join(bounds))
        )
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self.setMinimumHeight(self._style.px(24))
        self.setMinimumWidth(self._style.px(300))
        self.update()

    def paintEvent(self, _event: object) -> None:
        style = self._style
        painter = QPainter(self)
        painter.setFont(style.font("label"))
        wide = self.width() / len(self._words)
        for index, words in enumerate(self._words):
            fill, text = level_brushes(style, index)
            box = QRectF(index * wide, style.px(2), wide - 1, style.px(20))
            painter.fillRect(box, fill)
            painter.setPen(text)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)
        painter.setPen(style.color("line"))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(0, style.px(2), self.width() - 1, style.px(20)))
        painter.end()


class _EvidenceBarDelegate(_StyledDelegate):
    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        style, evidence = self._style, index.data(VALUE_ROLE)
        painter.save()
        if option.state & QStyle.StateFlag.State_Selected:
            painter.fillRect(option.rect, style.color("chosen"))
        number = style.px(56)
        box = option.rect.adjusted(style.px(6), 0, -style.px(2), 0)
        track = QRectF(
            box.left(), box.center().y() - style.px(4), box.width() - number, style.px(9)
        )
        painter.fillRect(track, style.color("pressed"))
        share = min(max(evidence, 0.0), 1.0)
        bar = QRectF(track.left(), track.top(), track.width() * share, track.height())
        painter.fillRect(bar, style.color("text"))
        painter.setFont(index.data(Qt.ItemDataRole.FontRole))
        painter.setPen(style.color("text"))
        text = QRectF(track.right(), option.rect.top(), number, option.rect.height())
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(text, right, percent_text(evidence))
        painter.restore()


class RankingView(FittedTableView):
    """The competition: title, bar of evidence, gain, gain on maneuvers left out, size."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(
            style,
            tr("Candidates, best first"),
            (tr("Effect"), tr("Evidence"), tr("Gain"), tr("Held out"), tr("Size")),
            stretch=0,
            right=frozenset({2, 3, 4}),
            least=4,
            most=16,
            wrap=False,
            row_height=_ROW,
            title_details={
                1: tr("Probability among all candidates"),
                2: tr("Log-likelihood gain, minus the penalty for its parameters"),
                3: tr("Log-likelihood gain on held-out maneuvers"),
                4: tr("Size / standard deviation"),
            },
        )
        self.setItemDelegateForColumn(1, _EvidenceBarDelegate(style, self))
        self.horizontalHeader().setMinimumSectionSize(8)

    def _fit_columns(self) -> None:
        """Give the titles the width where the table is narrow."""
        style = self._style
        room = self.viewport().width() / style.sizes.scale
        self.setColumnWidth(1, style.px(150 if room >= 720 else 116))
        for column in (2, 3, 4):
            self.setColumnWidth(column, style.px(74 if column < 4 else 60))
            self.setColumnHidden(column, room < (480 if column != 4 else 340))

    def show_rows(self, rows: Sequence[TableRow]) -> None:
        """Show another competition; the selected candidate stays where it still competes."""
        former = self.current_key()
        super().show_rows(rows)
        if rows and former not in [row.key for row in rows]:
            self.setCurrentIndex(self.row_model.index(0, 0))


_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


class _PaintedWidget(QWidget):
    """A drawing without keys; its words are heard."""

    def __init__(self, style: DisplayStyle, name: str) -> None:
        super().__init__()
        self._style = style
        self.setAccessibleName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        style.changed.connect(self._restyle)

    def _restyle(self) -> None:
        self.updateGeometry()
        self.update()

    def _floor_line(self, painter: QPainter, x: float, top: float, bottom: float) -> None:
        pen = QPen(self._style.color("text"))
        pen.setWidthF(1.5 * self._style.sizes.scale)
        pen.setStyle(Qt.PenStyle.DotLine)
        painter.setPen(pen)
        painter.drawLine(QPointF(x, top), QPointF(x, bottom))

    def _paint_floor_name(self, painter: QPainter, x: float, top: float) -> None:
        painter.setFont(self._style.font("label"))
        painter.setPen(self._style.color("muted"))
        text = tr("1 = noise floor")
        across = QFontMetricsF(painter.font()).horizontalAdvance(text)
        left = min(max(x - across / 2, 0), self.width() - across)
        painter.drawText(QRectF(left, top, across + 2, self._style.px(20)), _LEFT, text)

    def _describe(self, text: str) -> None:
        self.setAccessibleDescription(text)
        self.setToolTip(plain_tooltip(text.replace("; ", "\n")))
        self._restyle()


def _largest_finite(values: Sequence[float]) -> float:
    return max((value for value in values if math.isfinite(value)), default=1.0)


class ChannelGapBars(_PaintedWidget):
    """The gap of each channel before (gray) and after (colored), and the noise floor as a line."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, tr("Gap per channel"))
        self._pairs: tuple[ChannelGapPair, ...] = ()

    def show_pairs(self, pairs: Sequence[ChannelGapPair]) -> None:
        self._pairs = tuple(pairs)
        text = "; ".join(
            tr("{channel} from {before} to {after} times the noise").format(
                channel=channel_symbol(one.channel),
                before=noise_ratio_text(one.before),
                after=noise_ratio_text(one.after),
            )
            for one in pairs
        )
        self._describe(text)

    def sizeHint(self) -> QSize:
        style = self._style
        return QSize(style.px(280), style.px(34 * max(len(self._pairs), 1) + 22))

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        painter.setFont(style.font("body"))
        names, number = style.px(44), style.px(46)
        room = max(self.width() - names - number - style.px(8), 1)
        largest = max(
            1.2, _largest_finite([v for one in self._pairs for v in (one.before, one.after)])
        )
        step, thick = style.px(34), style.px(12)
        for row, one in enumerate(self._pairs):
            top = row * step + style.px(2)
            painter.setFont(style.font("body"))
            painter.setPen(style.color("text"))
            painter.drawText(
                QRectF(0, top, names, 2 * thick + 2), _LEFT, channel_symbol(one.channel)
            )
            values = ((one.before, "previous"), (one.after, trace_color(one.channel)))
            for index, (value, color) in enumerate(values):
                y = top + index * (thick + 2)
                wide = room * min(value, largest) / largest if math.isfinite(value) else 0.0
                painter.fillRect(QRectF(names, y, wide, thick), curve_color(style, color))
                painter.setFont(style.font("label", strong=index == 1))
                painter.setPen(style.color("text" if index else "muted"))
                # Right of the floor's line, not across it.
                left = names + max(wide, room / largest) + style.px(4)
                box = QRectF(left, y - 2, number, thick + 4)
                painter.drawText(box, _LEFT, noise_ratio_text(value))
        bottom = len(self._pairs) * step
        x = names + room / largest
        self._floor_line(painter, x, 0, bottom)
        self._paint_floor_name(painter, x, bottom)
        painter.end()


class MisfitWaterfall(_PaintedWidget):
    """How the misfit of all channels fell, effect by effect, towards the noise floor."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, tr("Residual by step"))
        self._steps: tuple[WaterfallStep, ...] = ()
        self._titles: tuple[str, ...] = ()
        self._current = 0

    def show_steps(
        self, steps: Sequence[WaterfallStep], titles: Sequence[str], current: int
    ) -> None:
        self._steps, self._titles, self._current = tuple(steps), tuple(titles), current
        text = "; ".join(
            tr("{title}: {after} times the noise floor").format(
                title=title, after=noise_ratio_text(one.after)
            )
            for title, one in zip(titles, steps, strict=True)
        )
        self._describe(text)

    def sizeHint(self) -> QSize:
        style = self._style
        return QSize(style.px(280), style.px(40 * max(len(self._steps), 1) + 22))

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        number = style.px(72)
        room = max(self.width() - number - style.px(8), 1)
        values = [v for one in self._steps for v in (one.before, one.after)]
        largest = max(1.2, _largest_finite(values))
        step, thick = style.px(40), style.px(14)
        metrics = QFontMetricsF(style.font("body"))
        for row, one in enumerate(self._steps):
            top = row * step
            current = row == self._current
            if current:
                painter.fillRect(QRectF(0, top, self.width(), step - 2), style.color("chosen"))
            painter.setFont(style.font("body", strong=current))
            painter.setPen(style.color("text"))
            words = metrics.elidedText(
                self._titles[row], Qt.TextElideMode.ElideRight, self.width() - style.px(8)
            )
            painter.drawText(QRectF(style.px(4), top, self.width(), style.px(20)), _LEFT, words)
            low, high = sorted((one.before, one.after))
            if not (math.isfinite(low) and math.isfinite(high)):
                continue
            y = top + style.px(20)
            rest = QRectF(0, y, room * low / largest, thick)
            painter.fillRect(rest, curve_color(style, "previous"))
            if high > low:
                fall = QRectF(room * low / largest, y, room * (high - low) / largest, thick)
                pattern = Qt.BrushStyle.BDiagPattern
                if one.after > one.before:
                    pattern = Qt.BrushStyle.DiagCrossPattern
                painter.setPen(QPen(style.color("text"), 1.5))
                painter.setBrush(QBrush(style.color("text"), pattern))
                painter.drawRect(fall)
            painter.setPen(style.color("text"))
            painter.setFont(style.font("label", strong=True))
            left = room * max(high, 1.0) / largest + style.px(4)
            text = noise_ratio_text(one.after)
            if row:
                text = f"{noise_ratio_text(one.before)}{ARROW}{text}"
            painter.drawText(QRectF(left, y - 2, number, thick + 4), _LEFT, text)
        bottom = len(self._steps) * step
        x = room / largest
        for row in range(len(self._steps)):
            # Beside the bars only, not through the words.
            top = row * step + style.px(20)
            self._floor_line(painter, x, top, top + thick + style.px(2))
        self._paint_floor_name(painter, x, bottom)
        painter.end()


class StepSlider(ArrowKeyNavigation, QSlider):
    """A slider through the models, from the baseline to the last one, with their names."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self._style = style
        self._names: tuple[str, ...] = (tr("Baseline"),)
        self.setAccessibleName(tr("Model from the baseline to the last effect"))
        back, on = shortcut_text("Alt+Left"), shortcut_text("Alt+Right")
        self.setToolTip(
            tr("Left and Right, or {back} and {on} from anywhere on this page").format(
                back=back, on=on
            )
        )
        self.setPageStep(1)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.valueChanged.connect(self._update_description)
        style.changed.connect(self.updateGeometry)

    def show_steps(self, names: Sequence[str], step: int) -> None:
        self.blockSignals(True)
        self._names = tuple(names) or (tr("Baseline"),)
        self.setRange(0, len(self._names) - 1)
        self.setValue(step)
        self.blockSignals(False)
        self._update_description()
        self.update()

    def _update_description(self) -> None:
        name = self._names[min(self.value(), len(self._names) - 1)]
        self.setAccessibleDescription(
            tr("Step {value} of {maximum}: {name}").format(
                value=self.value(), maximum=self.maximum(), name=name
            )
        )

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(240), self._style.px(44))

    def minimumSizeHint(self) -> QSize:
        return QSize(self._style.px(160), self._style.px(44))

    def _columns(self) -> float:
        return self.width() / len(self._names)

    def _at(self, x: float) -> int:
        return min(max(int(x / self._columns()), 0), self.maximum())

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        self.setValue(self._at(event.position().x()))
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self.setValue(self._at(event.position().x()))

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        wide, y = self._columns(), style.px(12)
        radius = style.px(6)
        centers = [place * wide + style.px(10) for place in range(len(self._names))]
        painter.setPen(QPen(style.color("axis"), style.px(2)))
        painter.drawLine(QPointF(centers[0], y), QPointF(centers[-1], y))
        painter.setPen(QPen(style.color("text"), style.px(3)))
        painter.drawLine(QPointF(centers[0], y), QPointF(centers[self.value()], y))
        for place, (x, name) in enumerate(zip(centers, self._names, strict=True)):
            reached, here = place <= self.value(), place == self.value()
            painter.setPen(QPen(style.color("text" if reached else "axis"), style.px(2)))
            painter.setBrush(style.color("text" if reached else "background"))
            size = radius + (style.px(2) if here else 0)
            painter.drawEllipse(QPointF(x, y), size, size)
            font = style.font("label", strong=here)
            painter.setFont(font)
            painter.setPen(style.color("text" if here else "muted"))
            box = QRectF(place * wide, style.px(24), wide - style.px(8), style.px(18))
            text = QFontMetricsF(font).elidedText(name, Qt.TextElideMode.ElideRight, box.width())
            painter.drawText(box, _LEFT, text)
        if self.hasFocus():
            paint_focus_frame(painter, self.rect(), style)
        painter.end()
