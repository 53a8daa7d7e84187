"""The map of maneuver and coefficient, and the ranking with its bars of evidence."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QItemSelectionModel, QPoint, QRectF, Qt, Signal
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from ui.display_limits import DISPLAY
from ui.display_style import DisplayStyle
from ui.gap.gap_view_models import MapCell
from ui.number_format import percent_text
from ui.translation import tr
from ui.widgets.paint_primitives import level_brushes, paint_focus_frame
from ui.widgets.row_model import VALUE_ROLE, ModelIndex, TableRow
from ui.widgets.table_view import FittedTableView

_ROW = 30
_CELL = 44


class _MapCellDelegate(QStyledItemDelegate):
    def __init__(self, look: DisplayStyle, parent: QWidget) -> None:
        super().__init__(parent)
        self._look = look

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        look, cell = self._look, index.data(VALUE_ROLE)[index.column()]
        fill, text = level_brushes(look, cell.level)
        box = option.rect.adjusted(1, 1, -1, -1)
        painter.save()
        painter.fillRect(box, fill)
        painter.setFont(look.font("body", strong=cell.level > 0))
        painter.setPen(text)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, index.data())
        if cell.proven:
            # A corner, so that it is not told by color alone.
            side = look.px(7)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(text)
            corner = box.topRight()
            painter.drawPolygon([corner, corner - QPoint(side, 0), corner + QPoint(0, side)])
        if option.state & QStyle.StateFlag.State_Selected:
            paint_focus_frame(painter, box, look)
        painter.restore()


class DisagreementMapView(FittedTableView):
    """The map; arrows or the mouse choose a cell."""

    cell_selected = Signal(str, str)
    """Maneuver and coefficient."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(
            look, tr("Disagreement map: maneuvers by coefficients"), (), stretch=None,
            least=4, most=16, wrap=False, row_height=_ROW,
        )  # fmt: skip
        self.setItemDelegate(_MapCellDelegate(look, self))
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
        cells = self.row_model.columnCount() * self._look.px(_CELL)
        wanted = self.verticalHeader().sizeHint().width()
        room = max(self.width() - cells - self._look.px(12), self._look.px(_CELL))
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

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        bounds = [f"{bound:g}" for bound in DISPLAY.map_levels]
        self._words = (tr("noise"), *(tr("from {bound}").format(bound=bound) for bound in bounds))
        self.setAccessibleName(
            tr(
                "Colors: noise, then from {bounds} times the noise floor; a corner "
                "marks significant cells"
            ).format(bounds=", ".join(bounds))
        )
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self.setMinimumHeight(self._look.px(24))
        self.setMinimumWidth(self._look.px(300))
        self.update()

    def paintEvent(self, _event: object) -> None:
        look = self._look
        painter = QPainter(self)
        painter.setFont(look.font("label"))
        wide = self.width() / len(self._words)
        for place, words in enumerate(self._words):
            fill, text = level_brushes(look, place)
            box = QRectF(place * wide, look.px(2), wide - 1, look.px(20))
            painter.fillRect(box, fill)
            painter.setPen(text)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)
        painter.setPen(look.color("line"))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(0, look.px(2), self.width() - 1, look.px(20)))
        painter.end()


class _EvidenceBarDelegate(QStyledItemDelegate):
    def __init__(self, look: DisplayStyle, parent: QWidget) -> None:
        super().__init__(parent)
        self._look = look

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        look, evidence = self._look, index.data(VALUE_ROLE)
        painter.save()
        if option.state & QStyle.StateFlag.State_Selected:
            painter.fillRect(option.rect, look.color("chosen"))
        number = look.px(56)
        box = option.rect.adjusted(look.px(6), 0, -look.px(2), 0)
        track = QRectF(box.left(), box.center().y() - look.px(4), box.width() - number, look.px(9))
        painter.fillRect(track, look.color("pressed"))
        share = min(max(evidence, 0.0), 1.0)
        bar = QRectF(track.left(), track.top(), track.width() * share, track.height())
        painter.fillRect(bar, look.color("text"))
        painter.setFont(index.data(Qt.ItemDataRole.FontRole))
        painter.setPen(look.color("text"))
        words = QRectF(track.right(), option.rect.top(), number, option.rect.height())
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(words, right, percent_text(evidence))
        painter.restore()


class RankingView(FittedTableView):
    """The competition: title, bar of evidence, gain, gain on maneuvers left out, size."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(
            look,
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
        self.setItemDelegateForColumn(1, _EvidenceBarDelegate(look, self))
        self.horizontalHeader().setMinimumSectionSize(8)

    def _fit_columns(self) -> None:
        """Give the titles the width where the table is narrow."""
        look = self._look
        room = self.viewport().width() / look.sizes.scale
        self.setColumnWidth(1, look.px(150 if room >= 720 else 116))
        for column in (2, 3, 4):
            self.setColumnWidth(column, look.px(74 if column < 4 else 60))
            self.setColumnHidden(column, room < (480 if column != 4 else 340))

    def show_rows(self, rows: Sequence[TableRow]) -> None:
        """Show another competition; the selected candidate stays where it still competes."""
        former = self.current_key()
        super().show_rows(rows)
        if rows and former not in [row.key for row in rows]:
            self.setCurrentIndex(self.row_model.index(0, 0))
