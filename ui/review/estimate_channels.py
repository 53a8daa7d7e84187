"""Which channels the fit compares, integrates, and frees the errors of: a table of checks."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES, DEFAULT_BIASES, Axis
from ui.display_style import DisplayStyle
from ui.estimate_form import EstimateForm
from ui.widgets.table_menu import TableMenu

ModelIndex = QModelIndex | QPersistentModelIndex

FIT_CHANNELS: Final = AXIS_RESPONSES["both"]
"""Rows of the table."""
CHANNEL_COLUMNS: Final = (
    ("responses", "Compared"),
    ("states", "State"),
    ("biases", "Bias"),
    ("scale_factors", "Scale"),
    ("time_shifts", "Shift"),
)
"""Fields of the wishes, and their titles."""
_DEFAULTS_BY_AXIS: Final = {
    "responses": AXIS_RESPONSES,
    "states": AXIS_STATES,
    "biases": DEFAULT_BIASES,
}
_ROW: Final = 28


class FitChannelModel(QAbstractTableModel):
    """Channels by what may be asked of them.

    Attributes
    ----------
    edited : Signal(object)
        The wishes with other channels.
    """

    edited = Signal(object)

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.wishes = EstimateForm()

    def set_form(self, wishes: EstimateForm) -> None:
        """Show other wishes."""
        if wishes != self.wishes:
            self.wishes = wishes
            last = self.index(len(FIT_CHANNELS) - 1, len(CHANNEL_COLUMNS))
            self.dataChanged.emit(self.index(0, 0), last)

    @property
    def axis(self) -> Axis:
        """Return the axis whose channels are shown."""
        return "both" if self.wishes.six_degrees else self.wishes.axis

    def selected_channels(self, field: str) -> tuple[str, ...]:
        """Return the channels that a field holds, those of the axis where none were chosen."""
        own: tuple[str, ...] | None = getattr(self.wishes, field)
        return _DEFAULTS_BY_AXIS[field][self.axis] if own is None else own

    def is_cell_editable(self, field: str, channel: str) -> bool:
        """Return whether a cell can be changed: errors are those of compared channels."""
        alone = self.wishes.axis != "both" or self.wishes.six_degrees
        if field == "states":
            return alone and channel in AXIS_STATES["both"]
        if field == "responses":
            return alone
        return not alone or channel in self.selected_channels("responses")

    def rowCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of channels."""
        return 0 if parent is not None and parent.isValid() else len(FIT_CHANNELS)

    def columnCount(self, parent: ModelIndex | None = None) -> int:
        """Return the number of columns, with that of the names."""
        return 0 if parent is not None and parent.isValid() else len(CHANNEL_COLUMNS) + 1

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return the title of a column."""
        if orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return "" if section == 0 else CHANNEL_COLUMNS[section - 1][1]
        return None

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return the check, and what is said of it."""
        channel = FIT_CHANNELS[index.row()]
        if index.column() == 0:
            return channel if role == Qt.ItemDataRole.DisplayRole else None
        field, title = CHANNEL_COLUMNS[index.column() - 1]
        on, open_ = channel in self.selected_channels(field), self.is_cell_editable(field, channel)
        if role == Qt.ItemDataRole.DisplayRole:
            return ("✓" if on else "·") if open_ or on else ""
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return int(Qt.AlignmentFlag.AlignCenter)
        if role == Qt.ItemDataRole.ForegroundRole and not (open_ and on):
            return QColor(self._look.color("muted"))
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleTextRole):
            return f"{channel}, {title.lower()}: {'yes' if on else 'no'}"
        return None

    def toggle_cell(self, index: ModelIndex) -> None:
        """Check a cell, or take its check away."""
        if index.column() == 0:
            return
        channel, field = FIT_CHANNELS[index.row()], CHANNEL_COLUMNS[index.column() - 1][0]
        if not self.is_cell_editable(field, channel):
            return
        chosen = self.selected_channels(field)
        wanted = {*chosen} ^ {channel}
        ordered = tuple(name for name in FIT_CHANNELS if name in wanted)
        usual = field in _DEFAULTS_BY_AXIS and set(ordered) == set(
            _DEFAULTS_BY_AXIS[field][self.axis]
        )
        self.edited.emit(self.wishes.with_changes(**{field: None if usual else ordered}))


class FitChannelTable(QTableView):
    """The table; Space changes a cell."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.model_of = FitChannelModel(look)
        self.setModel(self.model_of)
        self.menu = TableMenu(self)
        self.setAccessibleName("Channels")
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setTabKeyNavigation(False)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignCenter)
        self.clicked.connect(self.model_of.toggle_cell)
        look.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        px = self._look.px
        self.verticalHeader().setDefaultSectionSize(px(_ROW))
        self.setFixedHeight(len(FIT_CHANNELS) * px(_ROW) + px(34))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Change with Space or Enter."""
        index = self.currentIndex()
        wanted = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if index.isValid() and event.key() in wanted:
            self.model_of.toggle_cell(index)
        else:
            super().keyPressEvent(event)
