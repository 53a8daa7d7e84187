"""The flight card: a form in the user's units, saved as it is typed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from gsapp.aircraft import Aircraft
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import check_flight_info
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.preflight.flight_card_fields import (
    DEBRIEF_FIELDS,
    FLIGHT_FIELDS,
    TRANSMITTER_FIELDS,
    TRANSMITTER_REMARKS_FIELD,
    WEATHER_FIELDS,
    WEIGHT_FIELDS,
    CardField,
)
from ui.preflight.flight_card_forms import PayloadForm, TransmitterForm, WeighingForm
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_fields import FormField
from ui.preflight.preflight_model import PreflightModel
from ui.preflight.preflight_steps import SavingStepPage
from ui.translation import tr
from ui.undo import UndoHistory
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import FormColumns, FormSection


class FlightCardPage(SavingStepPage):
    """Asks for everything that no instrument writes down."""

    def __init__(self, style: DisplayStyle, fail: Callable[[BaseException], object]) -> None:
        super().__init__(style, tr("Flight card"), fail)
        self._aircraft: Aircraft | None = None
        self.editor: FormEditor[FlightInfo] | None = None
        self.fields: dict[str, tuple[CardField, FormField]] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self.area = FormColumns(style)
        column.addWidget(self.area)
        self._head()
        self.weighing = WeighingForm(style)
        self.transmitter = TransmitterForm(style)
        self.loading = PayloadForm(style)
        self._sections()
        for form in (self.weighing, self.transmitter, self.loading):
            form.edited.connect(self._typed_below)
            form.editing_finished.connect(self._left)
        style.changed.connect(self.show_card)

    def _head(self) -> None:
        row = QHBoxLayout()
        self.home = create_label("", wrap=True)
        row.addWidget(self.home, 1)
        self.saved = FieldMessage()
        self.saved.setWordWrap(False)
        row.addWidget(self.saved)
        self.area.head.addLayout(row)

    def _sections(self) -> None:
        flight = self._section(tr("Flight"), FLIGHT_FIELDS)
        weights = self._section(tr("Weight and fuel"), WEIGHT_FIELDS)
        wheels = FormSection(self.display_style, tr("On the scales"))
        wheels.add(self.weighing)
        board = FormSection(self.display_style, tr("Payload not in the aircraft file"))
        board.add(self.loading)
        weather = self._section(tr("Weather at the field"), WEATHER_FIELDS)
        sticks = self._section(tr("Transmitter"), TRANSMITTER_FIELDS)
        sticks.add(self.transmitter, self._field(TRANSMITTER_REMARKS_FIELD))
        debrief = self._section(tr("Debrief"), DEBRIEF_FIELDS)
        self.area.show_sections(
            [
                (flight, 0),
                (weights, 1),
                (wheels, 1),
                (board, 1),
                (weather, 2),
                (sticks, 2),
                (debrief, 0),
            ]
        )

    def _section(self, title: str, values: Sequence[CardField]) -> FormSection:
        section = FormSection(self.display_style, title)
        section.add(*(self._field(value) for value in values))
        return section

    def _field(self, value: CardField) -> QWidget:
        field = FormField(
            self.display_style,
            value.name,
            rows=3 if value.kind == "lines" else 1,
            choices=value.choices,
        )
        field.text_edited.connect(lambda text: self._typed(value, text))
        field.editing_finished.connect(self._left)
        self.fields[".".join(value.key)] = (value, field)
        return field

    # Showing

    def set_model(self, model: PreflightModel) -> None:
        """Show the card of another flight, and whose it is."""
        self.flush()
        self.editor, self._aircraft = model.card, model.aircraft
        self.home.setText(model.card_owner_text)
        self.area.setEnabled(model.card is not None)
        self.show_card()

    def refresh(self) -> None:
        """Take in what another program wrote into the card."""
        if (
            self.editor is not None
            and not self._save_timer.isActive()
            and self.editor.reload_if_changed()
        ):
            self.show_card()
            self.changed.emit()

    def show_card(self) -> None:
        """Show everything that is on the card."""
        editor, units = self.editor, self.display_style.units
        if editor is None:
            return
        for value, field in self.fields.values():
            field.set_text(editor.field_text(value, units))
            field.show_unit(value.unit_label(units) if value.kind == "number" else "")
        self.weighing.show_card(editor, self._aircraft)
        self.transmitter.show_card(editor)
        self.loading.show_card(editor)
        self._validate()

    def _validate(self) -> None:
        """Say below each field what is wrong or doubtful there."""
        editor = self.editor
        if editor is None:
            return
        doubts: dict[str, list[str]] = {}
        for doubt in check_flight_info(
            editor.file.model, self._aircraft, system=self.display_style.units
        ):
            doubts.setdefault(doubt.field, []).append(doubt.text)
        for name, (value, field) in self.fields.items():
            if value.key in editor.problems:
                field.show_message(
                    tr("Not saved: {problem}").format(problem=editor.problems[value.key]), "warning"
                )
            else:
                field.show_message(" ".join(doubts.get(name, ())), "caution")
        self.weighing.show_warning(" ".join(doubts.get("weighing", ())))
        self.show_save_state()

    def show_save_state(self) -> None:
        editor = self.editor
        if editor is None:
            return
        if editor.problems:
            self.saved.set_message(tr("Saved, except the marked fields"), "warning")
        elif editor.file.is_saved:
            self.saved.set_message(tr("Saved"), "good")
        elif self._save_timer.isActive():
            self.saved.set_message(tr("Saving…"))
        else:
            self.saved.set_message(tr("Not saved"), "warning")

    # Typing

    def _typed(self, value: CardField, text: str) -> None:
        if self.editor is not None:
            self.editor.enter_text(value, text, self.display_style.units)
            self._typed_on()

    def _typed_below(self) -> None:
        """Take in what a part of the form has put on the card."""
        if self.editor is not None:
            value, field = self.fields["takeoff_weight"]
            field.set_text(self.editor.field_text(value, self.display_style.units))
            self._typed_on()

    def _typed_on(self) -> None:
        self._save_timer.start()
        self._validate()
        self.changed.emit()

    def _left(self) -> None:
        """Show what was typed as it is on the card, in the unit of the screen."""
        if self.editor is not None:
            self.editor.end_merge()
            self.flush()
            self.show_card()

    @property
    def form_editor(self) -> FormEditor[FlightInfo] | None:
        return self.editor

    # Undo

    @property
    def undo_history(self) -> UndoHistory | None:
        return self.editor

    def show_restored(self) -> None:
        self.show_card()
        self.flush()
        self.changed.emit()

    def set_initial_focus(self) -> None:
        """Put the keyboard into the first field that is empty."""
        fields = [field for _value, field in self.fields.values()]
        first = next((field for field in fields if not field.text), fields[0])
        first.setFocus()
