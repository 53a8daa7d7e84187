"""The model behind every table and list: rows made beforehand, shown without flicker."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor

from ui.display_style import DisplayStyle, TextRole
from ui.icons import IndicatorState
from ui.translation import tr
from ui.widgets.labels import plain_tooltip

ModelIndex = QModelIndex | QPersistentModelIndex
VALUE_ROLE = Qt.ItemDataRole.UserRole  # Role of `TableRow.value`, for delegates.
_INVALID_INDEX = QModelIndex()


@dataclass(frozen=True, slots=True, kw_only=True)
class CellFormat:
    """What sets one cell apart from its row."""

    color: str = ""  # Role of the theme; empty for the color of the row.
    is_bold: bool | None = None  # None for the type of the row.
    text_style: TextRole = "body"  # Font of `DisplayStyle`.
    # Tool tip, and text for a screen reader.
    detail: str = ""
    accessible_text: str = ""
    # Text that editing starts from, where it is not the text of the cell.
    edit_text: str | None = None
    is_checked: bool | None = None  # Whether its box is checked; None for a cell without one.


_PLAIN = CellFormat()


@dataclass(frozen=True, slots=True, kw_only=True)
class TableRow:
    """One row of a table."""

    key: object  # What it stands for; unique in its table.
    cells: tuple[str, ...]  # Texts of the columns.
    state: IndicatorState = "plain"  # Colors the cells of `colored`; the words in them say it too.
    # Type of the whole row.
    is_bold: bool = False
    italic: bool = False
    detail: str = ""  # Tool tip.
    colored: frozenset[int] = field(default_factory=frozenset)  # Columns in the color of the state.
    # What the columns are sorted by, in place of their texts; None comes first.
    sort_values: tuple[Any, ...] = ()
    heading: str = ""  # Left of the row, where the table shows headings.
    formats: Mapping[int, CellFormat] = field(default_factory=dict)  # By column.
    value: Any = None  # What a delegate paints.

    def sort_key(self, column: int) -> tuple[bool, Any]:
        value = self.sort_values[column] if self.sort_values else self.cells[column]
        return (False, "") if value is None else (True, value)


class TableRowModel(QAbstractTableModel):
    """Rows for a table or a list; some columns may be edited.

    `title_details`: tool tips of titles.
    """

    edited = Signal(object, str, int)  # Key of the row, its new text, the column.
    checked = Signal(object, bool)  # Key of the row, whether its box shall be checked.

    def __init__(
        self,
        style: DisplayStyle,
        titles: Sequence[str],
        right: frozenset[int] = frozenset(),
        editable: frozenset[int] = frozenset(),
        *,
        centered: frozenset[int] = frozenset(),
        title_details: Mapping[int, str] | None = None,
    ) -> None:
        super().__init__()
        self._style = style
        self.titles = tuple(map(tr, titles))
        self.editable = editable
        self._title_details = title_details or {}
        self._sides = dict.fromkeys(centered, Qt.AlignmentFlag.AlignHCenter)
        self._sides |= dict.fromkeys(right, Qt.AlignmentFlag.AlignRight)
        self._sorted_by: tuple[int, bool] | None = None  # column, and whether backward
        self.rows: tuple[TableRow, ...] = ()

    def set_titles(self, titles: Sequence[str], details: Mapping[int, str]) -> None:
        """Show other columns, or the same ones with other titles."""
        self._title_details = details
        if len(titles) != len(self.titles):
            self.beginResetModel()
            self.titles, self.rows = tuple(titles), ()
            self.endResetModel()
        elif tuple(titles) != self.titles:
            self.titles = tuple(titles)
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(titles) - 1)

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort by a column from now on, as its title was pressed."""
        self._sorted_by = (column, order == Qt.SortOrder.DescendingOrder)
        self.set_rows(self.rows)

    def set_rows(self, rows: Iterable[TableRow]) -> None:
        """Show other rows; those that stay keep selection and open editors."""
        new = tuple(rows)
        if self._sorted_by is not None:
            column, backward = self._sorted_by
            new = tuple(sorted(new, key=lambda row: row.sort_key(column), reverse=backward))
        if new == self.rows:
            return
        before, after = {row.key for row in self.rows}, {row.key for row in new}
        kept = before & after
        if not kept or (len(before), len(after)) != (len(self.rows), len(new)):
            self.beginResetModel()
            self.rows = new
            self.endResetModel()
            return
        for first, last in _runs(row.key not in kept for row in self.rows)[::-1]:
            self.beginRemoveRows(_INVALID_INDEX, first, last)
            self.rows = self.rows[:first] + self.rows[last + 1 :]
            self.endRemoveRows()
        self._reorder([row.key for row in new if row.key in kept])
        for first, last in _runs(row.key not in kept for row in new):
            self.beginInsertRows(_INVALID_INDEX, first, last)
            self.rows = self.rows[:first] + new[first : last + 1] + self.rows[first:]
            self.endInsertRows()
        old, self.rows = self.rows, new
        for first, last in _runs(row != former for row, former in zip(new, old, strict=True)):
            self.dataChanged.emit(self.index(first, 0), self.index(last, len(self.titles) - 1))

    def _reorder(self, keys: Sequence[object]) -> None:
        before = [row.key for row in self.rows]
        if before == list(keys):
            return
        self.layoutAboutToBeChanged.emit()
        indexes = {key: index for index, key in enumerate(keys)}
        self.rows = tuple(sorted(self.rows, key=lambda row: indexes[row.key]))
        former = self.persistentIndexList()
        now = [self.index(indexes[before[one.row()]], one.column()) for one in former]
        self.changePersistentIndexList(former, now)
        self.layoutChanged.emit()

    def refresh(self) -> None:
        self.layoutChanged.emit()

    def find_row(self, key: object) -> int:
        return next((index for index, row in enumerate(self.rows) if row.key == key), -1)

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.titles)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        if orientation is not Qt.Orientation.Horizontal:
            return self.rows[section].heading if role == Qt.ItemDataRole.DisplayRole else None
        if role == Qt.ItemDataRole.DisplayRole:
            return self.titles[section]
        if role == Qt.ItemDataRole.ToolTipRole:
            return plain_tooltip(self._title_details.get(section, ""))
        if role == Qt.ItemDataRole.AccessibleTextRole:
            # Titles of letters are read as they are.
            has_letters = any(map(str.isalpha, self.titles[section]))
            return None if has_letters else self._title_details.get(section) or None
        return self._alignment(section) if role == Qt.ItemDataRole.TextAlignmentRole else None

    def _alignment(self, column: int) -> int:
        side = self._sides.get(column, Qt.AlignmentFlag.AlignLeft)
        return int(side | Qt.AlignmentFlag.AlignVCenter)

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        row, column = self.rows[index.row()], index.column()
        form = row.formats.get(column, _PLAIN)
        if role == Qt.ItemDataRole.DisplayRole:
            return row.cells[column]
        if role == Qt.ItemDataRole.EditRole:
            return row.cells[column] if form.edit_text is None else form.edit_text
        if role == VALUE_ROLE:
            return row.value
        if role == Qt.ItemDataRole.CheckStateRole and form.is_checked is not None:
            return Qt.CheckState.Checked if form.is_checked else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return self._alignment(column)
        if role == Qt.ItemDataRole.ToolTipRole:
            return plain_tooltip(form.detail or row.detail or row.cells[column])
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return form.accessible_text or None
        if role == Qt.ItemDataRole.AccessibleDescriptionRole:
            return form.detail or None
        if role == Qt.ItemDataRole.FontRole:
            bold = row.is_bold if form.is_bold is None else form.is_bold
            return self._style.font(form.text_style, strong=bold, italic=row.italic)
        if role == Qt.ItemDataRole.ForegroundRole:
            if form.color:
                return QColor(self._style.color(form.color))
            return QColor(self._style.state_color(row.state)) if column in row.colored else None
        return None

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        flags = super().flags(index)
        if not index.isValid():
            return flags
        if index.column() in self.editable:
            flags |= Qt.ItemFlag.ItemIsEditable
        if self.rows[index.row()].formats.get(index.column(), _PLAIN).is_checked is not None:
            flags |= Qt.ItemFlag.ItemIsUserCheckable
        return flags

    def setData(
        self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        row, column = self.rows[index.row()], index.column()
        is_checked = row.formats.get(column, _PLAIN).is_checked
        if role == Qt.ItemDataRole.CheckStateRole and is_checked is not None:
            self.checked.emit(row.key, not is_checked)
            return True
        if role != Qt.ItemDataRole.EditRole or column not in self.editable:
            return False
        text = str(value).strip()
        if text != self.data(index, Qt.ItemDataRole.EditRole):
            self.edited.emit(row.key, text, column)
        return True


def _runs(flags: Iterable[bool]) -> list[tuple[int, int]]:
    runs: list[tuple[int, int]] = []
    for index, flag in enumerate(flags):
        if flag and runs and runs[-1][1] == index - 1:
            runs[-1] = (runs[-1][0], index)
        elif flag:
            runs.append((index, index))
    return runs
