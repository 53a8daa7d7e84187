"""Tables of rows: columns, heights, keys, editing in place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QItemSelectionModel, QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QFocusEvent, QFontMetrics, QKeyEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemDelegate,
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QSizePolicy,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.row_model import ModelIndex, TableRow, TableRowModel
from ui.widgets.table_menu import TableMenu

WIDEST_TIME_TEXT = "0:00:00.0"  # A flight time after the first hour, as wide as any.
_SELECT_ONE_ROW = (
    QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows
)
"""Whatever modifier keys are held."""
_MIN_STRETCH = 96
"""Points of the column that takes the rest of the width, below which the table scrolls."""
_PADDING = 24
"""Pixels of the design beside the text of a cell: what the style leaves free, and the frame."""


class TextEditDelegate(QStyledItemDelegate):
    """Fields in cells; what is being typed stays when the table is updated."""

    def createEditor(
        self, parent: QWidget, option: QStyleOptionViewItem, index: ModelIndex
    ) -> QWidget:
        editor = super().createEditor(parent, option, index)
        title = index.model().headerData(index.column(), Qt.Orientation.Horizontal)
        editor.setAccessibleName(str(title))
        return editor

    def setEditorData(self, editor: QWidget, index: ModelIndex) -> None:
        if not (isinstance(editor, QLineEdit) and editor.isModified()):
            super().setEditorData(editor, index)

    def updateEditorGeometry(
        self, editor: QWidget, option: QStyleOptionViewItem, _index: ModelIndex
    ) -> None:
        # The padding of the style would push the field out of its cell.
        editor.setGeometry(option.rect)


class WordWrapDelegate(TextEditDelegate):
    """Rows as high as their words need.

    Qt wraps words at the full width of a column for the height, and inside the padding of the
    style for the picture: the last line would be cut.
    """

    def __init__(self, style: DisplayStyle, table: QTableView) -> None:
        super().__init__(table)
        self._style = style
        self._table = table

    def sizeHint(self, _option: QStyleOptionViewItem, index: ModelIndex) -> QSize:
        style = self._style
        font = index.data(Qt.ItemDataRole.FontRole) or style.font("body")
        wide = max(self._table.columnWidth(index.column()) - style.px(20), 16)
        box = QFontMetrics(font).boundingRect(
            QRect(0, 0, wide, 10_000), Qt.TextFlag.TextWordWrap, str(index.data() or "")
        )
        return QSize(wide, box.height() + style.px(14))


class TableRowView(QTableView):
    """A table of rows; Enter or a double press opens, text columns may be edited in place.

    `stretch`: column that takes the rest of the width; None where `_fit_columns` sets all widths.
    `widths`: of the others, pixels of the design; or a text that must have room in strong letters.
    `least`: width that is left to `stretch` at least, pixels of the design; where there is less
    room the table scrolls. 0 never scrolls. `sortable`: whether a press on a title sorts, and
    several rows can be selected; at first backward by the first column.
    """

    opened = Signal(object)  # Key of the row the user pressed Enter on.
    deleted = Signal(object)  # Key of the row the user pressed Delete on.
    row_changed = Signal(object)  # Key of the row that the keyboard is on now.

    def __init__(
        self,
        model: TableRowModel,
        style: DisplayStyle,
        name: str,
        stretch: int | None = None,
        widths: Mapping[int, int | str] | None = None,
        *,
        wrap: bool = True,
        least: int = 0,
        sortable: bool = False,
        row_height: int = 32,
        commands: Sequence[QAction] = (),
    ) -> None:
        super().__init__()
        self.row_model = model
        self._stretch, self._least = stretch, least
        self._style = style
        self._widths = widths or {}
        self._row_height = row_height
        self._is_quiet = False
        self.is_scrolled = False  # Whether there is no room for all columns.
        self.setModel(model)
        self.menu = TableMenu(self, commands)
        self.setItemDelegate(WordWrapDelegate(style, self) if wrap else TextEditDelegate(self))
        self.setAccessibleName(name)
        self.setShowGrid(False)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setWordWrap(wrap)
        if not least:
            self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        if wrap:
            self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        if stretch is not None and not least:
            header.setSectionResizeMode(stretch, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(16)
        self.doubleClicked.connect(self._double_clicked)
        self.selectionModel().currentChanged.connect(self._current_changed)
        style.changed.connect(self._restyle)
        if sortable:
            self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
            self.sortByColumn(0, Qt.SortOrder.DescendingOrder)
            self.setSortingEnabled(True)
            for column, title in enumerate(model.titles):
                self.menu.add_command(
                    tr("Sort by {title}").format(title=title), partial(self._sort_by, column)
                )
        self._restyle()

    # Sizes

    def _restyle(self) -> None:
        height = self._style.px(self._row_height)
        self.verticalHeader().setMinimumSectionSize(height)
        self.verticalHeader().setDefaultSectionSize(height)
        self._fit_columns()
        self.row_model.refresh()

    def _fit_columns(self) -> None:
        """Set the widths; where the table may scroll, give the rest to its column."""
        for column, width in self._widths.items():
            self.setColumnWidth(column, self._pixels(width))
        if self._stretch is None:
            return
        if not self._least:
            self._fit_stretch(self._stretch)
            return
        # With room for the scroll bar whether it is there or not: else rows that grow higher show
        # it, which makes them grow again.
        least = self._style.px(self._least)
        width = max(self.width() - self.full_width + least, least)
        if width != self.columnWidth(self._stretch):
            self.setColumnWidth(self._stretch, width)
            QTimer.singleShot(0, self, self.resizeRowsToContents)

    def _fit_stretch(self, column: int) -> None:
        """Give a column what is left; where that is too little for words, let the table scroll."""
        fixed = sum(map(self._pixels, self._widths.values()))
        least, bars = self._style.px(_MIN_STRETCH), Qt.ScrollBarPolicy
        self.is_scrolled = len(self._widths) > 1 and self.viewport().width() - fixed < least
        modes = QHeaderView.ResizeMode
        mode = modes.Fixed if self.is_scrolled else modes.Stretch
        if self.horizontalHeader().sectionResizeMode(column) != mode:
            self.horizontalHeader().setSectionResizeMode(column, mode)
        self.setHorizontalScrollBarPolicy(
            bars.ScrollBarAsNeeded if self.is_scrolled else bars.ScrollBarAlwaysOff
        )
        if self.is_scrolled:
            self.setColumnWidth(column, least)

    @property
    def full_width(self) -> int:
        """Return the width (pixels) at which no column is out of sight."""
        beside = self.verticalScrollBar().sizeHint().width() + 2 * self.frameWidth()
        fixed = sum(map(self._pixels, self._widths.values()))
        return beside + fixed + self._style.px(self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_columns()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._least:
            # The font may be another one than at the last show.
            QTimer.singleShot(0, self, self.resizeRowsToContents)

    def _pixels(self, width: int | str) -> int:
        if isinstance(width, int):
            return self._style.px(width)
        letters = QFontMetrics(self._style.font("body", strong=True))
        return letters.horizontalAdvance(width) + self._style.px(_PADDING)

    # The current row

    def current_key(self) -> object | None:
        """Return the key of the row the keyboard is on."""
        index = self.currentIndex()
        return self.row_model.rows[index.row()].key if index.isValid() else None

    def select_row(self, key: object, column: int = 0) -> None:
        """Put the keyboard on a row, if it is there."""
        row = self.row_model.find_row(key)
        if row >= 0:
            self.selectionModel().setCurrentIndex(
                self.row_model.index(row, column), _SELECT_ONE_ROW
            )

    def _double_clicked(self, index: ModelIndex) -> None:
        self.opened.emit(self.row_model.rows[index.row()].key)

    def _sort_by(self, column: int) -> None:
        """Sort as a press on a title does: forward, then backward."""
        header, orders = self.horizontalHeader(), Qt.SortOrder
        is_forward = header.sortIndicatorOrder() == orders.AscendingOrder
        again = header.sortIndicatorSection() == column and is_forward
        self.sortByColumn(column, orders.DescendingOrder if again else orders.AscendingOrder)

    def _current_changed(self, current: ModelIndex) -> None:
        if not self._is_quiet and current.isValid():
            self.row_changed.emit(self.row_model.rows[current.row()].key)

    def edit_row(self, key: object, column: int) -> None:
        """Begin to edit the text of a row."""
        self.select_row(key, column)
        index = self.currentIndex()
        if self.current_key() == key and index.column() == column:
            self.scrollTo(index)
            self.edit(index)

    @property
    def is_editing(self) -> bool:
        return self.state() == QAbstractItemView.State.EditingState

    def finish_edit(self) -> None:
        """Take what was typed, as Enter does."""
        editor = self.viewport().findChild(QLineEdit)
        if self.is_editing and editor is not None:
            delegate = self.itemDelegate()
            delegate.commitData.emit(editor)
            delegate.closeEditor.emit(editor, QAbstractItemDelegate.EndEditHint.NoHint)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Select the row that the keyboard is on.

        Where there was none Qt puts it on the first one, without selecting it: nobody would see
        that Enter and Delete are for that row.
        """
        super().focusInEvent(event)
        index = self.currentIndex()
        if index.isValid() and not self.selectionModel().hasSelection():
            self.selectRow(index.row())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key = self.current_key()
        acts: dict[int, Callable[[object], None]] = {
            int(Qt.Key.Key_Return): self.opened.emit,
            int(Qt.Key.Key_Enter): self.opened.emit,
            int(Qt.Key.Key_Delete): self.deleted.emit,
        }
        # Enter ends the typing in a cell and comes by here, too: then it opens nothing.
        if key is not None and event.key() in acts and not self.is_editing:
            acts[event.key()](key)
        else:
            super().keyPressEvent(event)


class FittedTableView(TableRowView):
    """A table that is as high as its rows, up to a number of them.

    `style`, `name`, `stretch`, `widths`, `wrap`, `row_height`: as for `TableRowView`. `least`,
    `most`: rows in sight.
    """

    def __init__(
        self,
        style: DisplayStyle,
        name: str,
        titles: Sequence[str],
        *,
        stretch: int | None,
        widths: Mapping[int, int | str] | None = None,
        right: frozenset[int] = frozenset(),
        centered: frozenset[int] = frozenset(),
        least: int = 2,
        most: int = 8,
        editable: frozenset[int] = frozenset(),
        title_details: Mapping[int, str] | None = None,
        wrap: bool = True,
        row_height: int = 32,
    ) -> None:
        self._visible_rows = (least, most)
        self._preferred_height = 0
        self._wrapped: object = None
        self._given: tuple[TableRow, ...] = ()
        model = TableRowModel(
            style, titles, right, editable, centered=centered, title_details=title_details
        )
        super().__init__(model, style, name, stretch, widths, wrap=wrap, row_height=row_height)
        # Left to itself the header measures all rows again with every change of style.
        mode = QHeaderView.ResizeMode.Interactive if wrap else QHeaderView.ResizeMode.Fixed
        self.verticalHeader().setSectionResizeMode(mode)
        self.horizontalHeader().setVisible(any(titles))
        self.horizontalHeader().setSectionsClickable(False)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        # When the header has settled: within its own resizing the widths are not all known.
        self._settle = QTimer(self)
        self._settle.setSingleShot(True)
        self._settle.timeout.connect(self._rewrap)
        self.horizontalHeader().sectionResized.connect(lambda *_: self._settle.start(0))
        self._rewrap()

    def show_rows(self, rows: Sequence[TableRow]) -> None:
        """Show other rows; values in their texts are in the units of the screen."""
        self._given = tuple(rows)
        self._convert()
        self._rewrap()

    def _convert(self) -> None:
        units = self._style.units
        self.row_model.set_rows(
            replace(
                row,
                cells=tuple(
                    cell if column in self.row_model.editable else convert_text_units(cell, units)
                    for column, cell in enumerate(row.cells)
                ),
                detail=convert_text_units(row.detail, units),
            )
            for row in self._given
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._settle.start(0)

    def _restyle(self) -> None:
        super()._restyle()
        self._convert()
        self._wrapped = None
        if self._given:
            # The table forgot the heights with the change.
            self._settle.start(0)

    def _rewrap(self) -> None:
        state = (
            tuple(row.cells for row in self.row_model.rows),
            tuple(self.columnWidth(column) for column in range(self.row_model.columnCount())),
            self._style.scale,
        )
        if state == self._wrapped:
            return
        self._wrapped = state
        if self.wordWrap():
            self.resizeRowsToContents()
        self._fit_height()
        self.updateGeometry()

    def _fit_height(self) -> None:
        rows = range(len(self.row_model.rows))
        heights = [self.rowHeight(row) for row in rows] or [self._style.px(34)]
        head = self.horizontalHeader()
        top = (0 if head.isHidden() else head.sizeHint().height()) + 4
        if self.is_scrolled:
            top += self.horizontalScrollBar().sizeHint().height()
        least, most = self._visible_rows
        # Never higher than its rows: an empty half of a table says nothing.
        enough = min(sum(heights[:least]), self._style.px(44 * least))
        bounds = (top + enough, top + sum(heights))
        self._preferred_height = top + sum(heights[:most])
        if bounds != (self.minimumHeight(), self.maximumHeight()):
            self.setMinimumHeight(bounds[0])
            self.setMaximumHeight(bounds[1])

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(320), self._preferred_height)


class BoxedListView(FittedTableView):
    """A framed list of one column; texts are shown as they are."""

    def __init__(
        self,
        style: DisplayStyle,
        name: str,
        most: int = 5,
        elide: Qt.TextElideMode = Qt.TextElideMode.ElideRight,
    ) -> None:
        super().__init__(
            style, name, ("",), stretch=0, least=most, most=most, wrap=False, row_height=30
        )
        self.setProperty("role", "boxed")
        self.setTextElideMode(elide)

    def _convert(self) -> None:
        self.row_model.set_rows(self._given)
