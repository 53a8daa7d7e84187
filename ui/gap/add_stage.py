"""Add: effects taken over one after the other, refused or forced; what the model becomes."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtGui import QAction

from ui.display_style import DisplayStyle
from ui.gap.gap_text import effect_confidence_text, signed_number_text
from ui.gap.gap_view_models import (
    build_changed_value_rows,
    build_effect_status_rows,
    build_parameter_rows,
    describe_runner_up,
    list_effect_statuses,
)
from ui.gap.stage_view import StageView
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import NameValueTable, StackingColumns, create_button_row
from ui.widgets.table_view import FittedTableView

_BUTTONS = (
    ("gap_accept", QT_TR_NOOP("Accept next")),
    ("gap_refuse", QT_TR_NOOP("Refuse")),
    ("gap_force", QT_TR_NOOP("Force another…")),
    ("undo", QT_TR_NOOP("Undo")),
    ("redo", QT_TR_NOOP("Redo")),
    ("gap_save", QT_TR_NOOP("Save the model…")),
)


class AddStage(StageView):
    """Effects and values of the revised model, with the buttons that decide."""

    def __init__(self, look: DisplayStyle, actions: Mapping[str, QAction]) -> None:
        super().__init__(look)
        self.buttons = {
            name: ActionButton(actions[name], tr(words), look) for name, words in _BUTTONS
        }
        self.buttons["gap_accept"].setProperty("role", "primary")
        pair = StackingColumns(look, (6, 5))
        self.column.addWidget(pair, 1)
        pair.left.addWidget(create_label(tr("Effects"), "heading"))
        self.effects = FittedTableView(
            look, tr("Effects: in the model, next, rejected"),
            (tr("Step"), tr("Effect"), tr("State")), stretch=1, widths={0: 52, 2: 150}, least=3,
        )  # fmt: skip
        pair.left.addWidget(self.effects, 30)
        self.empty_label = create_label("", "muted", wrap=True)
        pair.left.addWidget(self.empty_label)
        pair.left.addWidget(create_button_row(look, *self.buttons.values()))
        pair.left.addSpacing(look.px(8))
        self.values_heading = create_label(tr("Values that moved beyond their bounds"), "heading")
        pair.left.addWidget(self.values_heading)
        self.values = FittedTableView(
            look, tr("Values that moved"),
            (tr("Derivative"), tr("Before"), tr("After"), tr("Moved by")), stretch=2,
            widths={0: 100, 1: 100, 3: 76}, right=frozenset({1, 2, 3}), least=2,
        )  # fmt: skip
        pair.left.addWidget(self.values, 30)
        self.settled = create_label("", "muted", wrap=True, remarks_in=look)
        pair.left.addWidget(self.settled)
        pair.left.addStretch(1)
        self.title = create_label("", "heading", wrap=True)
        pair.right.addWidget(self.title)
        self.equation = create_label("", wrap=True)
        pair.right.addWidget(self.equation)
        self.parameters = NameValueTable(look)
        pair.right.addWidget(self.parameters)
        self.sentences = create_label("", "muted", wrap=True)
        pair.right.addWidget(self.sentences)
        self.remarks = create_label("", "hint", wrap=True, remarks_in=look)
        pair.right.addWidget(self.remarks)
        pair.right.addStretch(1)
        self.effects.selectionModel().currentChanged.connect(lambda *_: self._show_effect())

    def begin(self) -> None:
        (self.effects if self.effects.row_model.rows else self.buttons["gap_force"]).setFocus()

    @property
    def selected_effect(self) -> str:
        return str(self.effects.current_key() or "")

    def refresh(self) -> None:
        result, step = self.result, self.selection.step
        if result is None:
            return
        states = list_effect_statuses(result, step)
        former = self.selected_effect
        self.effects.show_rows(build_effect_status_rows(states))
        ids = [one.effect for one in states]
        if ids and former not in ids:
            self.effects.select_row(ids[min(step, len(ids) - 1)])
        self.effects.setVisible(bool(states))
        last = step == len(result.discrepancy.steps) - 1
        self.empty_label.setVisible(last)
        self.empty_label.setText(
            tr("All proven effects are in the model. Force another to see its effect.")
            if any(one.step for one in states)
            else tr("No effect is proven. Force one to see its effect.")
        )
        values = build_changed_value_rows(result)
        self.values.show_rows(values)
        self.values.setVisible(bool(values))
        self.values_heading.setVisible(bool(values))
        gust = result.discrepancy.disturbance.get("gust")
        sentences = [] if values else [tr("All other values stay within their bounds.")]
        if gust:
            sentences.append(
                tr("Turbulence of {gust:.2f} m/s (rms) is a disturbance, not an effect.").format(
                    gust=gust
                )
            )
        self.settled.setText(" ".join(sentences))
        self.settled.setVisible(bool(sentences))
        self.remarks.setText("\n".join((*result.discrepancy.warnings, *result.remarks)))
        self._show_effect()

    def _show_effect(self) -> None:
        result, effect = self.result, self.selected_effect
        if result is None:
            return
        found = next((one for one in result.discrepancy.effects if one.effect == effect), None)
        note = result.effect_infos.get(effect)
        self.title.setText(result.title(effect) if effect else "")
        equation = found.equation if found else note.equation if note else ""
        self.equation.setText(equation)
        self.equation.setVisible(bool(equation))
        self.parameters.show_rows(build_parameter_rows(result, effect, self.look.units))
        if found is None:
            self.sentences.setText(tr("Rejected: excluded from the search.") if effect else "")
            return
        said = [
            tr("Forced by the crew.")
            if found.forced
            else f"{effect_confidence_text(result, found)}."
        ]
        said[0] = said[0][:1].upper() + said[0][1:]
        said.append(describe_runner_up(result, found))
        said.append(
            tr("Log-likelihood gain on the held-out maneuvers: {held_out}.").format(
                held_out=signed_number_text(found.held_out, 1)
            )
        )
        self.sentences.setText("\n".join(said))
