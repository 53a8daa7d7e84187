"""Tables of the side panel: a frozen row for each line, shown without flicker."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QRect,
    QSize,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QFontMetrics,
    QKeyEvent,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import (
    QAbstractItemDelegate,
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.icons import IndicatorState
from ui.widgets.table_menu import TableMenu

ModelIndex = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True, slots=True, kw_only=True)
class TableRow:
    """One line of a table.

    Attributes
    ----------
    key : object
        What it stands for.
    cells : tuple of str
        Texts of the columns.
    state : str
        Colors the cells of `colored`; the words in them say it too.
    is_bold, italic : bool
        Type of the whole line.
    detail : str
        Tool tip.
    sort_values : tuple
        What the columns are sorted by, in place of their texts; None comes first.
    """

    key: object
    cells: tuple[str, ...]
    state: IndicatorState = "plain"
    is_bold: bool = False
    italic: bool = False
    detail: str = ""
    colored: frozenset[int] = field(default_factory=frozenset)
    sort_values: tuple[float | str | None, ...] = ()

    def sort_key(self, column: int) -> tuple[bool, float | str]:
        """Return what a column is sorted by."""
        value = self.sort_values[column] if self.sort_values else self.cells[column]
        return (False, "") if value is None else (True, value)


WIDEST_TIME_TEXT = "0:00:00.0"
"""A flight time after the first hour, as wide as any."""
_INVALID_INDEX = QModelIndex()
_PADDING = 24
"""Pixels of the design beside the text of a cell: what the style leaves free, and the frame."""


def _find_inserted_keys(before: Sequence[object], after: Sequence[object]) -> int | None:
    """Return where one run of keys was put in; None if more than that changed."""
    place = 0
    while place < min(len(before), len(after)) and before[place] == after[place]:
        place += 1
    rest = len(before) - place
    return place if list(before[place:]) == list(after[len(after) - rest :]) else None


class TableRowModel(QAbstractTableModel):
    """Lines for a table view; one column may be edited.

    Attributes
    ----------
    edited : Signal(object, str)
        Key of the line and its new text.
    """

    edited = Signal(object, str)

    def __init__(
        self,
        look: DisplayStyle,
        titles: Sequence[str],
        right: frozenset[int] = frozenset(),
        editable: int | None = None,
    ) -> None:
        super().__init__()
        self._look = look
        self.titles = tuple(titles)
        self._right = right
        self._editable = editable
        self._sorted_by: tuple[int, bool] | None = None  # column, and whether backward
        self.lines: tuple[TableRow, ...] = ()

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort by a column from now on, as its title was pressed."""
        self._sorted_by = (column, order == Qt.SortOrder.DescendingOrder)
        self.set_rows(self.lines)

    def set_rows(self, lines: Sequence[TableRow]) -> None:
        """Show other lines; only what changed is painted again."""
        new, old = tuple(lines), self.lines
        if self._sorted_by is not None:
            column, backward = self._sorted_by
            new = tuple(sorted(new, key=lambda line: line.sort_key(column), reverse=backward))
        if new == old:
            return
        before, after = [line.key for line in old], [line.key for line in new]
        added = len(after) - len(before)
        place = _find_inserted_keys(before, after)
        if added > 0 and place is not None:
            # Rows come in beside the others, so that the one chosen, or being edited, stays so.
            self.beginInsertRows(_INVALID_INDEX, place, place + added - 1)
            self.lines = new
            self.endInsertRows()
            old = old[:place] + new[place : place + added] + old[place:]
        elif before != after:
            self.beginResetModel()
            self.lines = new
            self.endResetModel()
            return
        self.lines = new
        for row, (line, former) in enumerate(zip(new, old, strict=True)):
            if line != former:
                last = self.columnCount() - 1
                self.dataChanged.emit(self.index(row, 0), self.index(row, last))

    def refresh(self) -> None:
        """Paint everything again, after a change of theme or scale."""
        self.layoutChanged.emit()

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of lines."""
        return 0 if parent is not None and parent.isValid() else len(self.lines)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of columns."""
        return 0 if parent is not None and parent.isValid() else len(self.titles)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return the title of a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return self.titles[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return self._alignment(section)
        return None

    def _alignment(self, column: int) -> int:
        side = Qt.AlignmentFlag.AlignRight if column in self._right else Qt.AlignmentFlag.AlignLeft
        return int(side | Qt.AlignmentFlag.AlignVCenter)

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return text, color, type of a cell."""
        line, column = self.lines[index.row()], index.column()
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return line.cells[column]
        if role == Qt.ItemDataRole.ToolTipRole:
            return line.detail or line.cells[column]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return self._alignment(column)
        if role == Qt.ItemDataRole.FontRole:
            return self._look.font("body", strong=line.is_bold, italic=line.italic)
        if role == Qt.ItemDataRole.ForegroundRole and column in line.colored:
            return QColor(self._look.state_color(line.state))
        return None

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        """Return whether a cell may be edited."""
        flags = super().flags(index)
        if index.column() == self._editable:
            flags |= Qt.ItemFlag.ItemIsEditable
        return flags

    def setData(
        self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        """Hand an edited text on; the line changes when its source has taken it."""
        if role != Qt.ItemDataRole.EditRole or index.column() != self._editable:
            return False
        line = self.lines[index.row()]
        text = str(value).strip()
        if text != line.cells[index.column()]:
            self.edited.emit(line.key, text)
        return True


class TextEditDelegate(QStyledItemDelegate):
    """Fields in cells; what is being typed stays, whatever the table shows anew meanwhile."""

    def createEditor(
        self, parent: QWidget, option: QStyleOptionViewItem, index: ModelIndex
    ) -> QWidget:
        """Return the field, called as its column is."""
        editor = super().createEditor(parent, option, index)
        title = index.model().headerData(index.column(), Qt.Orientation.Horizontal)
        editor.setAccessibleName(str(title))
        return editor

    def setEditorData(self, editor: QWidget, index: ModelIndex) -> None:
        """Fill a field with its cell, for as long as nobody has typed into it."""
        if not (isinstance(editor, QLineEdit) and editor.isModified()):
            super().setEditorData(editor, index)


class WordWrapDelegate(TextEditDelegate):
    """Rows as high as their words need.

    Qt wraps words at the full width of a column for the height, and inside the padding of the
    style for the picture: the last line would be cut.
    """

    def __init__(self, look: DisplayStyle, table: QTableView) -> None:
        super().__init__(table)
        self._look = look
        self._table = table

    def sizeHint(self, _option: QStyleOptionViewItem, index: ModelIndex) -> QSize:
        """Return the size of a cell at the width of its column."""
        look = self._look
        font = index.data(Qt.ItemDataRole.FontRole) or look.font("body")
        wide = max(self._table.columnWidth(index.column()) - look.px(20), 16)
        box = QFontMetrics(font).boundingRect(
            QRect(0, 0, wide, 10_000), Qt.TextFlag.TextWordWrap, str(index.data() or "")
        )
        return QSize(wide, box.height() + look.px(14))


class TableRowView(QTableView):
    """A table of lines; Enter or a double press jumps, text columns may be edited in place.

    Parameters
    ----------
    model : TableRowModel
    look : DisplayStyle
        Sizes.
    name : str
        Accessible name.
    stretch : int
        Column that takes the rest of the width.
    widths : dict of int to int or str
        Of the others, pixels of the design; or a text that must have room in strong letters.
    wrap : bool
        Whether long texts take several rows.
    least : int
        Width that is left to `stretch` at least, pixels of the design; where there is less room
        the table scrolls. 0 never scrolls.
    sortable : bool
        Whether a press on a title sorts, and several lines can be chosen; at first backward by
        the first column.

    Attributes
    ----------
    opened : Signal(object)
        Key of the line the user pressed Enter on.
    deleted : Signal(object)
        Key of the line the user pressed Delete on.
    menu : TableMenu
        Under the right button.
    """

    opened = Signal(object)
    deleted = Signal(object)

    def __init__(
        self,
        model: TableRowModel,
        look: DisplayStyle,
        name: str,
        stretch: int,
        widths: dict[int, int] | dict[int, str],
        *,
        wrap: bool = True,
        least: int = 0,
        sortable: bool = False,
    ) -> None:
        super().__init__()
        self.lines = model
        self._stretch, self._least = stretch, least
        self._look = look
        self._widths = widths
        self.setModel(model)
        self.menu = TableMenu(self)
        self.setItemDelegate(WordWrapDelegate(look, self) if wrap else TextEditDelegate(self))
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
            # Rows as high as their words need.
            self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        if not least:
            header.setSectionResizeMode(stretch, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(16)
        self.doubleClicked.connect(lambda index: self.opened.emit(model.lines[index.row()].key))
        look.changed.connect(self._resized)
        model.modelAboutToBeReset.connect(self._remember)
        model.modelReset.connect(self._find_again)
        self._kept: object | None = None
        if sortable:
            self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
            self.sortByColumn(0, Qt.SortOrder.DescendingOrder)
            self.setSortingEnabled(True)
        self._resized()

    def _remember(self) -> None:
        self._kept = self.current_key()

    def _find_again(self) -> None:
        """Stay on the line that was chosen, wherever it stands now."""
        for row, line in enumerate(self.lines.lines):
            if self._kept is not None and line.key == self._kept:
                self.setCurrentIndex(self.lines.index(row, 0))

    def _resized(self) -> None:
        for column, width in self._widths.items():
            self.setColumnWidth(column, self._pixels(width))
        self._give_rest()
        self.verticalHeader().setMinimumSectionSize(self._look.px(32))
        self.verticalHeader().setDefaultSectionSize(self._look.px(32))
        self.lines.refresh()

    def _give_rest(self) -> None:
        """Give the rest of the width to its column, and as much as it needs at least."""
        if not self._least:
            return
        # With room for the scroll bar whether it is there or not: else rows that grow higher show
        # it, which makes them grow again.
        least = self._look.px(self._least)
        width = max(self.width() - self.full_width + least, least)
        if width != self.columnWidth(self._stretch):
            self.setColumnWidth(self._stretch, width)
            QTimer.singleShot(0, self, self.resizeRowsToContents)

    @property
    def full_width(self) -> int:
        """Return the width (pixels) at which no column is out of sight."""
        beside = self.verticalScrollBar().sizeHint().width() + 2 * self.frameWidth()
        fixed = sum(map(self._pixels, self._widths.values()))
        return beside + fixed + self._look.px(self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Share the width anew."""
        super().resizeEvent(event)
        self._give_rest()

    def showEvent(self, event: QShowEvent) -> None:
        """Take the heights that the words need, with the letters there are now."""
        super().showEvent(event)
        if self._least:
            QTimer.singleShot(0, self, self.resizeRowsToContents)

    def _pixels(self, width: int | str) -> int:
        if isinstance(width, int):
            return self._look.px(width)
        letters = QFontMetrics(self._look.font("body", strong=True))
        return letters.horizontalAdvance(width) + self._look.px(_PADDING)

    def current_key(self) -> object | None:
        """Return the key of the line the keyboard is on."""
        index = self.currentIndex()
        return self.lines.lines[index.row()].key if index.isValid() else None

    def edit_row(self, key: object, column: int) -> None:
        """Begin to edit the text of a line."""
        for row, line in enumerate(self.lines.lines):
            if line.key == key:
                index = self.lines.index(row, column)
                self.setCurrentIndex(index)
                self.scrollTo(index)
                self.edit(index)
                return

    @property
    def is_editing(self) -> bool:
        """Return whether somebody types into a cell."""
        return self.state() == QAbstractItemView.State.EditingState

    def finish_edit(self) -> None:
        """Take what was typed so far, as Enter does."""
        editor = self.viewport().findChild(QLineEdit)
        if self.is_editing and editor is not None:
            delegate = self.itemDelegate()
            delegate.commitData.emit(editor)
            delegate.closeEditor.emit(editor, QAbstractItemDelegate.EndEditHint.NoHint)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show the line that the keyboard is on.

        Where there was none Qt puts it on the first one, without choosing it: nobody would see
        that Enter and Delete are for that line.
        """
        super().focusInEvent(event)
        index = self.currentIndex()
        if index.isValid() and not self.selectionModel().hasSelection():
            self.selectRow(index.row())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Jump with Enter, delete with Delete."""
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
