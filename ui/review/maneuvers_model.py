"""The rows of the table of maneuvers, and their order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QColor

from gsapp.session.review.review import ManeuverRow
from ui.display_style import DisplayStyle
from ui.review.maneuver_columns import EDITABLE_COLUMNS, MANEUVER_COLUMNS, ManeuverColumn
from ui.review.timeline_painter import GRADE_STATES
from ui.widgets.table_models import ModelIndex

_SORT_ROLE: Final = Qt.ItemDataRole.UserRole
"""Role of what a row is sorted by."""
_RIGHT: Final = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
_LEFT: Final = int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)


class ManeuversModel(QAbstractTableModel):
    """A row for each maneuver.

    Attributes
    ----------
    renamed, noted : Signal(str, str)
        Id in the campaign, and the new name or note.
    used : Signal(str, bool)
        Id in the campaign, and whether it shall take part.
    """

    renamed = Signal(str, str)
    noted = Signal(str, str)
    used = Signal(str, bool)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.rows: tuple[ManeuverRow, ...] = ()

    def set_rows(self, rows: Sequence[ManeuverRow]) -> None:
        """Show other rows; where the maneuvers are the same ones, only what changed."""
        new, old = tuple(rows), self.rows
        if [row.id for row in new] != [row.id for row in old]:
            self.beginResetModel()
            self.rows = new
            self.endResetModel()
            return
        self.rows = new
        for place, (row, former) in enumerate(zip(new, old, strict=True)):
            if row != former:
                last = self.index(place, len(MANEUVER_COLUMNS) - 1)
                self.dataChanged.emit(self.index(place, 0), last)

    def refresh(self) -> None:
        """Show everything again, in other units or sizes."""
        if self.rows:
            last = self.index(len(self.rows) - 1, len(MANEUVER_COLUMNS) - 1)
            self.dataChanged.emit(self.index(0, 0), last)
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(MANEUVER_COLUMNS) - 1)

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of maneuvers."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of columns."""
        return 0 if parent is not None and parent.isValid() else len(MANEUVER_COLUMNS)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return title, unit and hint of a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        column = MANEUVER_COLUMNS[section]
        if role == Qt.ItemDataRole.DisplayRole:
            return column.heading(self._look.units)
        if role == Qt.ItemDataRole.ToolTipRole:
            return column.hint or column.title
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if column.is_right_aligned else _LEFT
        return None

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return text, check mark, color, type of a cell."""
        row, column = self.rows[index.row()], MANEUVER_COLUMNS[index.column()]
        if role == _SORT_ROLE:
            return column.key(row)
        if role == Qt.ItemDataRole.EditRole and column.id == "id":
            # The number of the flight is not to be changed.
            return row.maneuver.id
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return column.cell_text(row, self._look.units)
        if role == Qt.ItemDataRole.CheckStateRole and column.id == "use":
            return Qt.CheckState.Checked if row.in_use else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.AccessibleTextRole and column.id == "use":
            return "used in the estimate" if row.in_use else "not used in the estimate"
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if column.is_right_aligned else _LEFT
        if role == Qt.ItemDataRole.FontRole:
            return self._look.font("body", strong=column.id in ("id", "grade"))
        if role == Qt.ItemDataRole.ForegroundRole:
            return self._color(row, column.id)
        if role == Qt.ItemDataRole.ToolTipRole:
            return self._hint(row, column)
        return None

    def _color(self, row: ManeuverRow, column: str) -> QColor | None:
        if column == "grade":
            return self._look.state_color(GRADE_STATES[row.maneuver.grade])
        return None if row.in_use else self._look.color("muted")

    def _hint(self, row: ManeuverRow, column: ManeuverColumn) -> str:
        if column.id == "grade":
            return "; ".join(row.maneuver.reasons) or "nothing to object to"
        return column.hint or column.cell_text(row, self._look.units)

    def flags(self, index: ModelIndex) -> Qt.ItemFlag:
        """Return what can be done with a cell."""
        flags = super().flags(index)
        column = MANEUVER_COLUMNS[index.column()].id
        if column in EDITABLE_COLUMNS:
            flags |= Qt.ItemFlag.ItemIsEditable
        if column == "use":
            flags |= Qt.ItemFlag.ItemIsUserCheckable
        return flags

    def setData(
        self, index: ModelIndex, value: object, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        """Hand on what was typed or checked; the row changes when the review has taken it."""
        row, column = self.rows[index.row()], MANEUVER_COLUMNS[index.column()].id
        if role == Qt.ItemDataRole.CheckStateRole and column == "use":
            self.used.emit(row.id, not row.in_use)
            return True
        text = str(value).strip()
        if role != Qt.ItemDataRole.EditRole or column not in EDITABLE_COLUMNS:
            return False
        if text != self.data(index, Qt.ItemDataRole.EditRole):
            (self.renamed if column == "id" else self.noted).emit(row.id, text)
        return True


class ManeuverSortProxy(QSortFilterProxyModel):
    """Sorts by what a column says, not by its letters."""

    def lessThan(self, left: QModelIndex, right: QModelIndex) -> bool:
        """Compare two cells."""
        return bool(left.data(_SORT_ROLE) < right.data(_SORT_ROLE))
