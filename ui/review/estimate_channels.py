"""Which channels the fit compares, integrates, and frees the errors of: a table of checks."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES, DEFAULT_BIASES, Axis
from ui.display_style import DisplayStyle
from ui.estimate_form import EstimateForm
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import CellFormat, ModelIndex, TableRow, TableRowModel
from ui.widgets.table_view import TableRowView

FIT_CHANNELS: Final = AXIS_RESPONSES["both"]
"""Rows of the table."""
CHANNEL_COLUMNS: Final = (
    ("responses", QT_TR_NOOP("Compared")),
    ("states", QT_TR_NOOP("State")),
    ("biases", QT_TR_NOOP("Bias")),
    ("scale_factors", QT_TR_NOOP("Scale")),
    ("time_shifts", QT_TR_NOOP("Shift")),
)
"""Fields of the form, and their titles."""
_DEFAULTS_BY_AXIS: Final = {
    "responses": AXIS_RESPONSES,
    "states": AXIS_STATES,
    "biases": DEFAULT_BIASES,
}


class FitChannelTable(TableRowView):
    """The table; Space changes a cell."""

    edited = Signal(object)

    def __init__(self, look: DisplayStyle) -> None:
        titles = ("", *(title for _, title in CHANNEL_COLUMNS))
        model = TableRowModel(look, titles, centered=frozenset(range(1, len(titles))))
        super().__init__(model, look, tr("Channels"), wrap=False, row_height=28)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.setAlternatingRowColors(True)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.clicked.connect(self._toggle)
        self.set_form(EstimateForm())

    def _restyle(self) -> None:
        super()._restyle()
        px = self._look.px
        self.setFixedHeight(len(FIT_CHANNELS) * px(self._row_height) + px(34))

    def set_form(self, form: EstimateForm) -> None:
        self.form = form
        self.row_model.set_rows(self._row(channel) for channel in FIT_CHANNELS)

    def _row(self, channel: str) -> TableRow:
        texts, formats = [channel], {}
        for column, (field, title) in enumerate(CHANNEL_COLUMNS, 1):
            is_on = channel in self.selected_channels(field)
            is_editable = self.is_cell_editable(field, channel)
            texts.append("✓" if is_on else "·" if is_editable else "")
            on = tr("yes") if is_on else tr("no")
            detail = f"{channel}, {tr(title).lower()}: {on}"
            color = "" if is_on and is_editable else "muted"
            formats[column] = CellFormat(color=color, detail=detail, accessible_text=detail)
        return TableRow(key=channel, cells=tuple(texts), formats=formats)

    @property
    def axis(self) -> Axis:
        """Return the axis whose channels are shown."""
        return "both" if self.form.six_degrees else self.form.axis

    def selected_channels(self, field: str) -> tuple[str, ...]:
        """Return the channels that a field holds, those of the axis where none were chosen."""
        own: tuple[str, ...] | None = getattr(self.form, field)
        return _DEFAULTS_BY_AXIS[field][self.axis] if own is None else own

    def is_cell_editable(self, field: str, channel: str) -> bool:
        """Return whether a cell can be changed: errors are those of compared channels."""
        alone = self.form.axis != "both" or self.form.six_degrees
        if field == "states":
            return alone and channel in AXIS_STATES["both"]
        if field == "responses":
            return alone
        return not alone or channel in self.selected_channels("responses")

    def _toggle(self, index: ModelIndex) -> None:
        channel = FIT_CHANNELS[index.row()]
        field = CHANNEL_COLUMNS[index.column() - 1][0] if index.column() else ""
        if not field or not self.is_cell_editable(field, channel):
            return
        wanted = {*self.selected_channels(field)} ^ {channel}
        ordered = tuple(name for name in FIT_CHANNELS if name in wanted)
        usual = field in _DEFAULTS_BY_AXIS and wanted == set(_DEFAULTS_BY_AXIS[field][self.axis])
        self.edited.emit(self.form.with_changes(**{field: None if usual else ordered}))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        wanted = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if self.currentIndex().isValid() and event.key() in wanted:
            self._toggle(self.currentIndex())
        else:
            super().keyPressEvent(event)
