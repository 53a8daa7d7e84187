"""The map of maneuver and coefficient, and the ranking with its bars of evidence."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QPainter, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.gap.gap_text import COEFFICIENT_NAMES
from ui.gap.gap_view_models import MAP_LEVELS, DisagreementMap, MapCell, RankingRow
from ui.number_format import percent_text
from ui.widgets.paint_primitives import level_brushes, paint_focus_frame
from ui.widgets.table_menu import TableMenu

ModelIndex = QModelIndex | QPersistentModelIndex
_CELL_ROLE = Qt.ItemDataRole.UserRole
_ROW = 30
_CELL = 44
_MOST_ROWS = 16
_LEAST_ROWS = 4


class DisagreementMapModel(QAbstractTableModel):
    """The cells of the map."""

    def __init__(self) -> None:
        super().__init__()
        self.picture = DisagreementMap()

    def set_map(self, picture: DisagreementMap) -> None:
        """Show another map; a map of the same places is only painted again."""
        former, self.picture = self.picture, picture
        if (former.rows, former.columns) != (picture.rows, picture.columns):
            self.beginResetModel()
            self.endResetModel()
        elif picture.rows:
            self.dataChanged.emit(
                self.index(0, 0), self.index(self.rowCount() - 1, self.columnCount() - 1)
            )

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of maneuvers."""
        return 0 if parent is not None and parent.isValid() else len(self.picture.rows)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of coefficients."""
        return 0 if parent is not None and parent.isValid() else len(self.picture.columns)

    def cell(self, index: ModelIndex) -> MapCell:
        """Return a cell."""
        return self.picture.cells[index.row()][index.column()]

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return number and words of a cell."""
        cell = self.cell(index)
        if role == Qt.ItemDataRole.DisplayRole:
            return cell.text
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleDescriptionRole):
            row, column = self.picture.rows[index.row()], self.picture.columns[index.column()]
            proven = ", more than chance" if cell.proven else ""
            words = COEFFICIENT_NAMES.get(column, column)
            return f"{words} of maneuver {row[1]}: {cell.text} times the noise floor{proven}"
        return cell if role == _CELL_ROLE else None

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return the words of a row or column."""
        across = orientation is Qt.Orientation.Horizontal
        if role == Qt.ItemDataRole.DisplayRole:
            return self.picture.columns[section] if across else self.picture.rows[section][1]
        if role == Qt.ItemDataRole.ToolTipRole and across:
            name = self.picture.columns[section]
            return COEFFICIENT_NAMES.get(name, name)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            side = Qt.AlignmentFlag.AlignHCenter if across else Qt.AlignmentFlag.AlignLeft
            return int(side | Qt.AlignmentFlag.AlignVCenter)
        return None


class _MapCellDelegate(QStyledItemDelegate):
    def __init__(self, look: DisplayStyle, parent: QWidget) -> None:
        super().__init__(parent)
        self._look = look

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        look, cell = self._look, index.data(_CELL_ROLE)
        fill, text = level_brushes(look, cell.level)
        box = option.rect.adjusted(1, 1, -1, -1)
        painter.save()
        painter.fillRect(box, fill)
        painter.setFont(look.font("body", strong=cell.level > 0))
        painter.setPen(text)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, cell.text)
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


class DisagreementMapView(QTableView):
    """The map; arrows or the mouse choose a cell.

    Attributes
    ----------
    cell_selected : Signal(str, str)
        Maneuver and coefficient.
    """

    cell_selected = Signal(str, str)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._quiet = False
        self.map = DisagreementMapModel()
        self.setModel(self.map)
        self.setItemDelegate(_MapCellDelegate(look, self))
        self.setAccessibleName("Map of disagreement: maneuvers down, coefficients across")
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setShowGrid(False)
        self.setCornerButtonEnabled(False)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.horizontalHeader().setMinimumSectionSize(8)
        self.horizontalHeader().setSectionsClickable(False)
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.verticalHeader().setSectionsClickable(False)
        self.verticalHeader().setTextElideMode(Qt.TextElideMode.ElideRight)
        self.selectionModel().currentChanged.connect(self._moved)
        self.menu = TableMenu(self)
        look.changed.connect(self._resized)
        self._resized()

    def _resized(self) -> None:
        self.verticalHeader().setDefaultSectionSize(self._look.px(_ROW))
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the cells the room that their numbers need, and the rest to the maneuvers."""
        super().resizeEvent(event)
        self._share()

    def _share(self) -> None:
        cells = self.map.columnCount() * self._look.px(_CELL)
        wanted = self.verticalHeader().sizeHint().width()
        room = max(self.width() - cells - self._look.px(12), self._look.px(_CELL))
        self.verticalHeader().setFixedWidth(min(wanted, room))

    def _fit(self) -> None:
        rows = min(max(self.map.rowCount(), 1), _MOST_ROWS)
        head = self.horizontalHeader().sizeHint().height()
        row = self._look.px(_ROW)
        self.setMinimumHeight(head + min(rows, _LEAST_ROWS) * row + 2)
        self.setMaximumHeight(head + max(self.map.rowCount(), 1) * row + 2)

    def sizeHint(self) -> QSize:
        """Return the size of the whole map, within reason."""
        rows = min(max(self.map.rowCount(), 1), _MOST_ROWS)
        head = self.horizontalHeader().sizeHint().height()
        return QSize(self._look.px(420), head + rows * self._look.px(_ROW) + 2)

    def show_map(self, picture: DisagreementMap, maneuver: str, coefficient: str) -> None:
        """Show a map with one cell chosen."""
        self._quiet = True
        self.map.set_map(picture)
        rows = [row[0] for row in picture.rows]
        if maneuver in rows and coefficient in picture.columns:
            index = self.map.index(rows.index(maneuver), picture.columns.index(coefficient))
            self.selectionModel().setCurrentIndex(
                index, QItemSelectionModel.SelectionFlag.ClearAndSelect
            )
            self.scrollTo(index)
        self._quiet = False
        self._fit()
        self._share()
        self.updateGeometry()

    def _moved(self, current: QModelIndex, _former: QModelIndex) -> None:
        if not self._quiet and current.isValid():
            row = self.map.picture.rows[current.row()][0]
            self.cell_selected.emit(row, self.map.picture.columns[current.column()])


class DisagreementMapLegend(QWidget):
    """The colors of the map and what they say."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        bounds = [f"{bound:g}" for bound in MAP_LEVELS]
        self._words = ("noise", *(f"from {bound}" for bound in bounds))
        self.setAccessibleName(
            f"Colors: noise, then from {', '.join(bounds)} times the noise floor; "
            "a corner marks what is more than chance"
        )
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self.setMinimumHeight(self._look.px(24))
        self.setMinimumWidth(self._look.px(300))
        self.update()

    def paintEvent(self, _event: object) -> None:
        """Draw the levels side by side."""
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


_RANKING_TITLES = ("Effect", "Evidence", "Gain", "Held out", "Size")
_RANKING_HINTS = (
    "",
    "Probability among all candidates",
    "Gain of the log-likelihood, less what its parameters cost",
    "Gain of the log-likelihood on maneuvers left out of the fit",
    "Size over its standard deviation",
)


class RankingModel(QAbstractTableModel):
    """The candidates of one competition, best first."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.rows: tuple[RankingRow, ...] = ()

    def set_rows(self, rows: Sequence[RankingRow]) -> None:
        """Show another competition."""
        self.beginResetModel()
        self.rows = tuple(rows)
        self.endResetModel()

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of candidates."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of columns."""
        return 0 if parent is not None and parent.isValid() else len(_RANKING_TITLES)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return title and hint of a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return _RANKING_TITLES[section]
        if role == Qt.ItemDataRole.ToolTipRole:
            return _RANKING_HINTS[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            side = Qt.AlignmentFlag.AlignLeft if section < 2 else Qt.AlignmentFlag.AlignRight
            return int(side | Qt.AlignmentFlag.AlignVCenter)
        return None

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return text and type of a cell."""
        row, column = self.rows[index.row()], index.column()
        texts = (row.title, percent_text(row.evidence), row.score, row.held_out, row.size)
        if role == Qt.ItemDataRole.DisplayRole:
            return texts[column]
        if role == Qt.ItemDataRole.ToolTipRole:
            return f"{row.title} ({row.effect})" if column == 0 else _RANKING_HINTS[column]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            side = Qt.AlignmentFlag.AlignLeft if column < 2 else Qt.AlignmentFlag.AlignRight
            return int(side | Qt.AlignmentFlag.AlignVCenter)
        if role == Qt.ItemDataRole.FontRole:
            return self._look.font("body", strong=row.proven)
        return row if role == _CELL_ROLE else None


class _EvidenceBarDelegate(QStyledItemDelegate):
    def __init__(self, look: DisplayStyle, parent: QWidget) -> None:
        super().__init__(parent)
        self._look = look

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        look, row = self._look, index.data(_CELL_ROLE)
        painter.save()
        if option.state & QStyle.StateFlag.State_Selected:
            painter.fillRect(option.rect, look.color("chosen"))
        number = look.px(56)
        box = option.rect.adjusted(look.px(6), 0, -look.px(2), 0)
        track = QRectF(box.left(), box.center().y() - look.px(4), box.width() - number, look.px(9))
        painter.fillRect(track, look.color("pressed"))
        share = min(max(row.evidence, 0.0), 1.0)
        bar = QRectF(track.left(), track.top(), track.width() * share, track.height())
        painter.fillRect(bar, look.color("text"))
        painter.setFont(look.font("body", strong=row.proven))
        painter.setPen(look.color("text"))
        words = QRectF(track.right(), option.rect.top(), number, option.rect.height())
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(words, right, percent_text(row.evidence))
        painter.restore()


class RankingView(QTableView):
    """The competition: title, bar of evidence, gain, gain on maneuvers left out, size.

    Attributes
    ----------
    effect_selected : Signal(str)
        Id of the effect the keyboard is on.
    """

    effect_selected = Signal(str)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.ranks = RankingModel(look)
        self.setModel(self.ranks)
        self.setItemDelegateForColumn(1, _EvidenceBarDelegate(look, self))
        self.setAccessibleName("Candidates, best first")
        self.menu = TableMenu(self)
        self.setShowGrid(False)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setWordWrap(False)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionsClickable(False)
        header.setMinimumSectionSize(8)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.selectionModel().currentChanged.connect(self._moved)
        look.changed.connect(self._resized)
        self._resized()

    def _resized(self) -> None:
        look = self._look
        self.verticalHeader().setDefaultSectionSize(look.px(_ROW))
        self._fit_columns()
        self._fit()

    def _fit(self) -> None:
        head = self.horizontalHeader().sizeHint().height() + 2
        rows, row = max(len(self.ranks.rows), 1), self._look.px(_ROW)
        self.setMinimumHeight(head + min(rows, _LEAST_ROWS) * row)
        self.setMaximumHeight(head + rows * row)
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the size of the whole competition, within reason."""
        rows = min(max(len(self.ranks.rows), 1), _MOST_ROWS)
        head = self.horizontalHeader().sizeHint().height()
        return QSize(self._look.px(420), head + rows * self._look.px(_ROW) + 2)

    def resizeEvent(self, event: object) -> None:
        """Give the titles the room where the table is narrow."""
        super().resizeEvent(event)
        self._fit_columns()

    def _fit_columns(self) -> None:
        look = self._look
        room = self.viewport().width() / look.sizes.scale
        self.setColumnWidth(1, look.px(150 if room >= 720 else 116))
        for column in (2, 3, 4):
            self.setColumnWidth(column, look.px(74 if column < 4 else 60))
            self.setColumnHidden(column, room < (480 if column != 4 else 340))

    def show_rows(self, rows: Sequence[RankingRow]) -> None:
        """Show another competition; the chosen candidate stays chosen where it competes still."""
        former = self.current
        if tuple(rows) == self.ranks.rows:
            return
        self.ranks.set_rows(rows)
        self._fit()
        names = [row.effect for row in rows]
        if names:
            place = names.index(former) if former in names else 0
            self.setCurrentIndex(self.ranks.index(place, 0))

    @property
    def current(self) -> str:
        """Return the id of the chosen candidate; empty for none."""
        index = self.currentIndex()
        return self.ranks.rows[index.row()].effect if index.isValid() else ""

    def _moved(self, current: QModelIndex, _former: QModelIndex) -> None:
        if current.isValid():
            self.effect_selected.emit(self.ranks.rows[current.row()].effect)
