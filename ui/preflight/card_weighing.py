"""Weight and center of gravity from scales under the wheels, computed as they are typed."""

from __future__ import annotations

from PySide6.QtWidgets import QPushButton

from gsapp.aircraft import Aircraft
from gsapp.flight.info import FlightInfo
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.preflight.flight_card_fields import (
    WEIGHING_CONDITION_FIELDS,
    WEIGHING_METHODS,
    CardField,
    create_scale_fields,
    find_weighing_method,
    list_weighed_supports,
)
from ui.preflight.flight_card_text import describe_weighing, format_takeoff_weight
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_fields import FormField, set_touch_height
from ui.preflight.form_part import FormPart
from ui.translation import tr
from ui.widgets.labels import create_label

_TABLE = ("weighing",)
_LOADS = (*_TABLE, "loads")


class WeighingForm(FormPart[FlightInfo]):
    """Readings of the scales, and what they say."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        self._aircraft: Aircraft | None = None
        self._way = ""
        self.way = FormField(look, tr("Weighed on"), choices=WEIGHING_METHODS)
        self.way.text_edited.connect(self._choose)
        self._column.addWidget(self.way)
        self.fields: dict[str, tuple[CardField, FormField]] = {}
        for value in (*create_scale_fields(), *WEIGHING_CONDITION_FIELDS):
            self._add(value.key[-1], value)
        self.weight = create_label("", "title")
        self.summary = create_label("", wrap=True)
        self.take = QPushButton(tr("Use as take-off weight"))
        self.take.setAccessibleName(tr("Use the measured weight as take-off weight"))
        set_touch_height(self.take)
        self.take.clicked.connect(self._apply_weighing)
        self.doubts = FieldMessage()
        for widget in (self.weight, self.summary, self.doubts, self.take):
            self._column.addWidget(widget)
        look.changed.connect(self._fit)
        self._fit()

    def _add(self, name: str, value: CardField) -> None:
        field = FormField(self._look, value.name)
        field.text_edited.connect(lambda text: self._typed(value, text))
        field.editing_finished.connect(self.editing_finished)
        self.fields[name] = (value, field)
        self._column.addWidget(field)

    def _fit(self) -> None:
        self._column.setSpacing(self._look.px(8))

    def _scales(self, way: str) -> tuple[str, ...]:
        """Return the supports that are asked for; an aircraft on a tail wheel has no nose wheel."""
        axles = () if self._aircraft is None else self._aircraft.axles.keys()
        return list_weighed_supports(
            way, "tail" if "tail" in axles and "nose" not in axles else "nose"
        )

    # Showing

    def show_card(self, editor: FormEditor[FlightInfo], aircraft: Aircraft | None) -> None:
        """Show what is on a card, and what is being typed."""
        if editor is not self._editor:
            self._way = ""
        self._editor, self._aircraft = editor, aircraft
        on_card = find_weighing_method(editor.stored_value(_TABLE))
        self._way = on_card or self._way
        self.way.set_text(self._way)
        for value, field in self.fields.values():
            field.set_text(editor.field_text(value, self._look.units))
            field.show_unit(value.unit_label(self._look.units))
        self.validate()

    def validate(self) -> None:
        """Say what the scales say, or what is missing."""
        editor = self._editor
        if editor is None:
            return
        asked = self._scales(self._way)
        more = [value.key[-1] for value in WEIGHING_CONDITION_FIELDS] if self._way else []
        for name, (value, field) in self.fields.items():
            field.setVisible(name in (*asked, *more))
            field.show_message(*self._remark(value))
        said = describe_weighing(editor.file.model, self._aircraft, self._look.units)
        waits = any(key[:1] == _TABLE for key in editor.problems)
        self.weight.setText("" if waits else said.weight)
        self.summary.setText("" if waits else said.problem or "\n".join(said.lines))
        self.weight.setVisible(bool(self.weight.text()))
        self.summary.setVisible(bool(self.summary.text()))
        self.take.setVisible(bool(self.weight.text()))

    def _remark(self, value: CardField) -> tuple[str, str]:
        editor = self._editor
        problem = editor.problems.get(value.key, "") if editor is not None else ""
        if not problem:
            return "", ""
        asked = [self.fields[name][1] for name in self._scales(self._way)]
        if any(not one.text.strip() for one in asked):
            return tr("Incomplete: read the other scales too."), "caution"
        return problem, "warning"

    def show_warning(self, words: str) -> None:
        """Say what is odd about the weighing, or nothing."""
        self.doubts.set_message(words, "caution")
        self.doubts.setVisible(bool(words))

    # Typing

    def _choose(self, way: str) -> None:
        """Weigh another way; readings that it has no use for go."""
        editor = self._editor
        if editor is None:
            return
        self._way = way
        kept = self._scales(way)
        loads = editor.stored_value(_LOADS) or {}
        if set(loads) - set(kept):
            # What is left of another way is no weighing: it waits until it is one again.
            texts = {
                name: editor.field_text(self.fields[name][0], self._look.units) for name in kept
            }
            editor.set_values({_TABLE: None})
            for name, text in texts.items():
                if text:
                    editor.enter_text(self.fields[name][0], text, self._look.units)
        elif not way:
            editor.discard_group(_TABLE)
        self.show_card(editor, self._aircraft)
        self.edited.emit()

    def _typed(self, value: CardField, text: str) -> None:
        if self._editor is not None:
            self._editor.enter_text(value, text, self._look.units)
            self.validate()
            self.edited.emit()

    def _apply_weighing(self) -> None:
        editor = self._editor
        if editor is None:
            return
        said = describe_weighing(editor.file.model, self._aircraft, self._look.units)
        if said.weighed is not None:
            weight = format_takeoff_weight(said.weighed, editor.file.model, self._look.units)
            editor.set_values({("takeoff_weight",): weight})
            self.edited.emit()
