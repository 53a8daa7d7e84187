"""The tables of the panel: derivatives, and the channels that the fit compares and integrates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from gsapp.identification.axes import (
    AXIS_RESPONSES,
    AXIS_STATES,
    DEFAULT_BIASES,
    Axis,
    axis_derivatives,
)
from ui.display_style import DisplayStyle
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.number_format import MINUS, symbol_text, value_with_std_text
from ui.review.estimate_request import AS_MODEL_TEXT, TREATMENT_CHOICES
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import CellFormat, ModelIndex, TableRow, TableRowModel
from ui.widgets.table_view import TableRowView

ESTIMATE_COLUMN_TITLES: Final = (
    "", QT_TR_NOOP("Treated"), QT_TR_NOOP("Last run"), QT_TR_NOOP("Held at"), QT_TR_NOOP("Start"),
    QT_TR_NOOP("Known"), "±",
)  # fmt: skip
(
    NAME_COLUMN,
    TREATMENT_COLUMN,
    LAST_COLUMN,
    VALUE_COLUMN,
    START_COLUMN,
    PRIOR_COLUMN,
    DEVIATION_COLUMN,
) = range(7)
_FIELDS: Final = {
    VALUE_COLUMN: "value",
    START_COLUMN: "start",
    PRIOR_COLUMN: "prior",
    DEVIATION_COLUMN: "deviation",
}
_COLUMN_DESCRIPTIONS: Final = {
    VALUE_COLUMN: QT_TR_NOOP("held value"),
    START_COLUMN: QT_TR_NOOP("start value"),
    PRIOR_COLUMN: "prior",
    DEVIATION_COLUMN: QT_TR_NOOP("standard deviation of the prior"),
}
_MOST_ROWS: Final = 12
_PADDING: Final = 14
"""Points beside the letters of a cell."""
_WIDEST: Final = 176
"""Points of the names of effects' parameters."""
_WIDTHS: Final = {
    NAME_COLUMN: 76,
    TREATMENT_COLUMN: 54,
    VALUE_COLUMN: 58,
    START_COLUMN: 50,
    PRIOR_COLUMN: 50,
    DEVIATION_COLUMN: 38,
}


class DerivativeTable(TableRowView):
    """The table; Space changes the treatment, typing writes, Delete resets a row."""

    edited = Signal(object)

    def __init__(self, style: DisplayStyle) -> None:
        self.names: tuple[str, ...] = ()
        """Derivatives of the axis, then the parameters of the model's effects."""
        self.form = EstimateForm()
        self.last: Mapping[str, str] = {}
        self.effects: Mapping[str, float] = {}
        right = frozenset(range(LAST_COLUMN, len(ESTIMATE_COLUMN_TITLES)))
        model = TableRowModel(
            style, ESTIMATE_COLUMN_TITLES, right, frozenset(_FIELDS),
            title_details={
                NAME_COLUMN: tr("Derivative"), DEVIATION_COLUMN: tr("Standard deviation"),
            },
        )  # fmt: skip
        # Not wrapped: a bound that has no room would go to a second line, where nobody sees it.
        super().__init__(model, style, tr("Derivatives"), wrap=False, row_height=30)
        self.setProperty("role", "close")
        self.setAlternatingRowColors(True)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.AnyKeyPressed
            | QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        self.clicked.connect(self._clicked)
        model.edited.connect(self._edited)

    # Rows

    def set_form(self, form: EstimateForm) -> None:
        self.form = form
        self._show_rows()

    def show_effects(self, effects: Mapping[str, float]) -> None:
        self.effects = effects
        self._show_rows()

    def show_last(self, last: Mapping[str, str]) -> None:
        self.last = last
        self._show_rows()

    def _show_rows(self) -> None:
        axis = axis_derivatives("both" if self.form.six_degrees else self.form.axis)
        self.names = (*axis, *self.effects)
        self.row_model.set_rows(map(self._row, self.names))
        self._fit_columns()

    def _row(self, name: str) -> TableRow:
        entry, is_effect = self.form.derivative(name), name in self.effects
        texts = tuple(self._text(name, entry, column) for column in range(DEVIATION_COLUMN + 1))
        formats = {}
        for column, text in enumerate(texts):
            detail = _describe_cell(name, column, text)
            formats[column] = CellFormat(
                color="" if _has_effect(entry, column) else "muted",
                detail=detail,
                accessible_text=detail,
                is_bold=column == NAME_COLUMN and entry != DerivativeEntry(),
                text_style="small" if column == NAME_COLUMN and is_effect else "body",
            )
        return TableRow(key=name, cells=texts, formats=formats)

    def _text(self, name: str, entry: DerivativeEntry, column: int) -> str:
        if column == NAME_COLUMN:
            return symbol_text(name)
        if column == TREATMENT_COLUMN:
            usual = name in self.effects and entry.treated == "tables"
            return tr(AS_MODEL_TEXT if usual else dict(TREATMENT_CHOICES)[entry.treated])
        if column == LAST_COLUMN:
            return self.last.get(name, "")
        if column == VALUE_COLUMN and name in self.effects and not entry.value:
            return f"{self.effects[name]:.4g}"
        return str(getattr(entry, _FIELDS[column]))

    # Sizes

    def _fit_columns(self) -> None:
        px = self._style.px
        for column, width in _WIDTHS.items():
            self.setColumnWidth(column, px(width))
        # Strong, as they are once something is asked of them.
        own = QFontMetrics(self._style.font("body", strong=True))
        small = QFontMetrics(self._style.font("small", strong=True))
        names = [
            (small if name in self.effects else own).horizontalAdvance(symbol_text(name))
            + px(_PADDING)
            for name in self.names
        ]
        self.setColumnWidth(NAME_COLUMN, min(max([px(_WIDTHS[NAME_COLUMN]), *names]), px(_WIDEST)))
        letters = QFontMetrics(self._style.font("body"))
        written = map(letters.horizontalAdvance, self.last.values())
        least = max(written, default=0) + px(_PADDING)
        room = self.viewport().width() - sum(self.columnWidth(column) for column in _WIDTHS)
        self.setColumnWidth(LAST_COLUMN, max(room, least))
        self.horizontalHeader().setMinimumSectionSize(px(40))
        rows = min(len(self.names), _MOST_ROWS)
        bar = self.horizontalScrollBar().sizeHint().height() if room < least else 0
        self.setFixedHeight(rows * px(self._row_height) + px(34) + bar)

    # Changes

    def _edited(self, name: str, text: str, column: int) -> None:
        """Take what was typed; a value to hold at holds the derivative."""
        entry = self.form.derivative(name)
        changes = {_FIELDS[column]: text}
        if column == VALUE_COLUMN and text and text != entry.value:
            changes["treated"] = "held"
        self._change(name, entry.model_copy(update=changes))

    def _cycle_treatment(self, name: str) -> None:
        """Treat a derivative in the next way; held, it begins with the value of the last run."""
        entry = self.form.derivative(name)
        ways = [key for key, _ in TREATMENT_CHOICES]
        treated = ways[(ways.index(entry.treated) + 1) % len(ways)]
        value = entry.value
        if treated == "held" and not value:
            value = self.last.get(name, "").partition(" ")[0].replace(MINUS, "-")
            if not value and name in self.effects:
                value = repr(self.effects[name])
        self._change(name, entry.model_copy(update={"treated": treated, "value": value}))

    def _change(self, name: str, entry: DerivativeEntry) -> None:
        if entry != self.form.derivative(name):
            self.edited.emit(self.form.with_derivative(name, entry))

    def _clicked(self, index: ModelIndex) -> None:
        if index.column() == TREATMENT_COLUMN:
            self._cycle_treatment(self.names[index.row()])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        index, key = self.currentIndex(), event.key()
        if self.is_editing or not index.isValid():
            super().keyPressEvent(event)
            return
        name = self.names[index.row()]
        is_enter = key in (Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if is_enter and index.column() in _FIELDS:
            self.edit(index)
        elif is_enter or key == Qt.Key.Key_Space:
            self._cycle_treatment(name)
        elif key == Qt.Key.Key_Delete:
            self._change(name, DerivativeEntry())
        else:
            super().keyPressEvent(event)


def _has_effect(entry: DerivativeEntry, column: int) -> bool:
    if column == TREATMENT_COLUMN:
        return entry.treated != "tables"
    if column == VALUE_COLUMN:
        return entry.treated == "held"
    if column in (START_COLUMN, PRIOR_COLUMN, DEVIATION_COLUMN):
        return entry.treated != "held"
    return True


def _describe_cell(name: str, column: int, text: str) -> str:
    if column == TREATMENT_COLUMN:
        return tr("{name} {text}; Space changes it").format(name=symbol_text(name), text=text)
    if column in _COLUMN_DESCRIPTIONS:
        return tr("{what} of {name}: {text}").format(
            what=tr(_COLUMN_DESCRIPTIONS[column]), name=symbol_text(name), text=text or tr("none")
        )
    return (
        tr("{name}, last run: {text}").format(name=symbol_text(name), text=text)
        if column == LAST_COLUMN and text
        else text
    )


def format_last_values(
    names: Sequence[str], values: Mapping[str, tuple[float, float]]
) -> dict[str, str]:
    """Return what a run gave of each derivative, in words."""
    return {name: value_with_std_text(*values[name]) for name in names if name in values}


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

    def __init__(self, style: DisplayStyle) -> None:
        titles = ("", *(title for _, title in CHANNEL_COLUMNS))
        model = TableRowModel(
            style, titles, centered=frozenset(range(1, len(titles))),
            title_details={0: tr("Channel")},
        )  # fmt: skip
        super().__init__(model, style, tr("Channels"), wrap=False, row_height=28)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.setAlternatingRowColors(True)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.clicked.connect(self._toggle)
        self.set_form(EstimateForm())

    def _restyle(self) -> None:
        super()._restyle()
        px = self._style.px
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
