"""Derivatives of a run in the forms that others publish."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QVBoxLayout, QWidget

from gsapp.quantities.notation import unit_text
from ui.display_style import DisplayStyle
from ui.number_format import MINUS, symbol_text
from ui.translation import tr
from ui.widgets.flow_layout import clear_layout
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox, add_widgets
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.report.form_text import FormTable

_NUMBER_WIDTH = 84


def _name(text: str) -> str:
    """Return ``Zα`` for ``Z_alpha`` and ``α'`` for ``alpha'``; coefficients have their symbols."""
    family, _, variable = text.rpartition("_")
    if len(family) > 1 or " " in text:
        return symbol_text(text)
    plain = variable.removesuffix("'")
    symbol = symbol_text(f"CX_{plain}").removeprefix("CX")
    shown = symbol_text(plain) if symbol.startswith("_") else symbol
    return family + shown + variable[len(plain) :]


def _cell(text: str) -> str:
    return unit_text(text.replace("-", MINUS))


class DerivativeFormsPanel(QWidget):
    """Shows the means, and each joint fit, in one form."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._outcome: RunOutcome | None = None
        self.form = LabeledComboBox(style, tr("Show as"), letters=24)
        self._tables = QVBoxLayout()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        heading = create_label(tr("Derivatives in another form"), "strong")
        add_widgets(column, heading, self.form)
        column.addLayout(self._tables)
        self.form.box.currentIndexChanged.connect(self._show)
        style.changed.connect(self._show)

    @property
    def tables(self) -> tuple[FittedTableView, ...]:
        items = (self._tables.itemAt(place) for place in range(self._tables.count()))
        widgets = (item.widget() for item in items if item is not None)
        return tuple(one for one in widgets if isinstance(one, FittedTableView))

    def show_outcome(self, outcome: RunOutcome) -> None:
        from gsapp.identification.summary.derivative_forms import FORM_TITLES

        self._outcome = outcome
        choices = [(name, f"{words[:1].upper()}{words[1:]}") for name, words in FORM_TITLES.items()]
        self.form.set_choices([("", tr("Choose a form")), *choices], self.form.current_key)
        self._show()

    def _show(self) -> None:
        clear_layout(self._tables)
        if self._outcome is None or not self.form.current_key:
            return
        from gsapp.report.form_text import campaign_form_tables

        outcome, form = self._outcome, self.form.current_key
        found = campaign_form_tables(outcome.result, outcome.summary, self._style.units, [form])
        for one in found:
            if one.title:
                self._tables.addWidget(create_label(one.title, "muted", wrap=True))
            self._tables.addWidget(self._table(one))
        if not found:
            text = tr("No derivative of this form was estimated.")
            self._tables.addWidget(create_label(text, "muted", wrap=True))

    def _table(self, one: FormTable) -> FittedTableView:
        numbers = frozenset(range(1, len(one.columns)))
        table = FittedTableView(
            self._style, one.title or tr("Modes"), list(map(_name, one.columns)), stretch=0,
            widths=dict.fromkeys(numbers, _NUMBER_WIDTH), right=numbers, least=1, most=12,
        )  # fmt: skip
        table.show_rows(
            [
                TableRow(key=name, cells=(_name(name), *map(_cell, cells)))
                for name, *cells in one.rows
            ]
        )
        return table
