"""The form of one test card."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.flight.cards import CardSet, TestCard
from ui.display_style import DisplayStyle
from ui.preflight.card_editor_fields import (
    create_amplitude_field,
    create_card_fields,
    create_surfaces_field,
    create_tolerance_fields,
    replace_surfaces,
)
from ui.preflight.flight_card_fields import CardField, format_field
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_fields import FormField
from ui.preflight.form_part import FormPart
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import FormColumns, FormSection

_SI = {"speed": "m/s", "alpha": "rad", "amplitude": "", "width": ""}
_SURFACES = ("de", "da", "dr")


class CardEditor(FormPart[CardSet]):
    """Everything on a card."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        self._row = 0
        self.fields: dict[str, FormField] = {}
        self.area = FormColumns(look, 2)
        self._column.addWidget(self.area)
        point, maneuver = FormSection(look, tr("Test point")), FormSection(look, tr("Maneuver"))
        allowed = FormSection(look, tr("Tolerance"))
        plain = {value.key[-1]: value for value in create_card_fields(0)}
        for name in ("id", "title", "speed", "alpha", "height", "flap"):
            point.add(self._field(name, plain[name]))
        maneuver.add(self._field("kind", plain["kind"]))
        maneuver.add(self._field("surfaces", create_surfaces_field(0)))
        for surface in _SURFACES:
            maneuver.add(self._field(surface, create_amplitude_field(0, surface, alone=False)))
        for name in ("width", "repeats", "remarks"):
            maneuver.add(self._field(name, plain[name]))
        for value in create_tolerance_fields(0):
            allowed.add(self._field(f"tolerance.{value.key[-1]}", value))
        self.area.head.addWidget(create_label(tr("Esc: back to the list"), "hint"))
        self.area.show_sections([(point, 0), (maneuver, 1), (allowed, 0)])

    def _field(self, name: str, value: CardField) -> FormField:
        rows = 2 if value.kind == "lines" else 1
        field = FormField(self._look, value.name, rows=rows, choices=value.choices)
        field.text_edited.connect(lambda text: self._typed(name, text))
        field.editing_finished.connect(self.editing_finished)
        self.fields[name] = field
        return field

    def _values(self, card: TestCard) -> Mapping[str, CardField]:
        """Return what stands in each field of the card shown."""
        row = self._row
        alone = len(card.surfaces) == 1
        return {
            **{value.key[-1]: value for value in create_card_fields(row)},
            **{f"tolerance.{value.key[-1]}": value for value in create_tolerance_fields(row)},
            **{name: create_amplitude_field(row, name, alone=alone) for name in card.surfaces},
        }

    def show_card(self, editor: FormEditor[CardSet], row: int) -> None:
        """Show a card of the set."""
        self._editor, self._row = editor, row
        cards = editor.file.model.cards
        if row >= len(cards):
            return
        card, units = cards[row], self._look.units
        order = ",".join(card.surfaces)
        self.fields["surfaces"].set_choices(
            create_surfaces_field(row, card.surfaces).choices, order
        )
        values = self._values(card)
        for name in _SURFACES:
            self.fields[name].setVisible(name in card.surfaces)
        for name, value in values.items():
            field = self.fields[name]
            field.name.setText(tr(value.name))
            field.set_text(editor.field_text(value, units))
            field.show_unit(value.unit_label(units) if value.kind == "number" else "")
            if name.startswith("tolerance."):
                part = value.key[-1]
                usual = f"{getattr(card.tolerance, part)!r} {_SI[part]}"
                field.show_hint(format_field(value, usual, units))
        self.fields["title"].show_hint(card.display_title)
        self.validate()

    def validate(self) -> None:
        """Say below each field what is wrong there."""
        editor = self._editor
        if editor is None:
            return
        for name, value in self._values(editor.file.model.cards[self._row]).items():
            problem = editor.problems.get(value.key, "")
            self.fields[name].show_message(
                tr("Not saved: {problem}").format(problem=problem) if problem else "", "warning"
            )

    def _typed(self, name: str, text: str) -> None:
        editor = self._editor
        if editor is None:
            return
        card = editor.file.model.cards[self._row]
        if name == "surfaces":
            place = ("cards", str(self._row))
            editor.set_values(
                {place: replace_surfaces(editor.stored_value(place), text.split(","))}
            )
            self.show_card(editor, self._row)
        else:
            editor.enter_text(self._values(card)[name], text, self._look.units)
            self.validate()
        self.edited.emit()

    def begin(self) -> None:
        """Put the keyboard into the first field, ready to be typed over."""
        self.fields["id"].setFocus()
        self.fields["id"].select_all()
