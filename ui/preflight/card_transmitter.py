"""The transmitter on the flight card: dual rates, trims, mixers."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.flight.info import FlightInfo
from gsapp.foundation import UnitError
from ui.display_style import DisplayStyle
from ui.preflight.field_grid import FieldGrid, GridColumn, GrowingFieldGrid
from ui.preflight.flight_card_fields import (
    STICKS,
    THROW_COLUMNS,
    TRANSMITTER_CONTROLS,
    CardField,
    create_mixer_field,
    create_throw_field,
    format_field,
    parse_field,
)
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_part import FormPart
from ui.translation import tr
from ui.widgets.labels import create_label

_MIXERS = ("transmitter", "mixers")
_COLUMNS = (*(name for name, _words in THROW_COLUMNS), "trim")
_NO_CHANNEL_CHOICE = ("", "–")


class TransmitterForm(FormPart[FlightInfo]):
    """Throws of the sticks in percent, and what is mixed into what."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        titles = (*(tr(words) for _name, words in THROW_COLUMNS), tr("Trim"))
        self.throws = FieldGrid(
            look,
            [GridColumn(name=f"{words} %") for words in titles],
            [tr(words) for _stick, words in STICKS],
        )
        self.values: list[list[CardField]] = [
            [create_throw_field(stick, name) for name in _COLUMNS] for stick, _words in STICKS
        ]
        self.throws.cell_edited.connect(self._typed)
        self.throws.editing_finished.connect(self.editing_finished)
        self._column.addWidget(self.throws)
        self._column.addWidget(create_label(tr("Mixers"), "strong"))
        levers = (_NO_CHANNEL_CHOICE, *TRANSMITTER_CONTROLS)
        self.mixers = GrowingFieldGrid(
            look,
            [
                GridColumn(name=tr("From"), choices=levers, share=3),
                GridColumn(name=tr("To"), choices=levers, share=3),
                GridColumn(name=tr("Share %"), share=2),
            ],
        )
        self.mixers.rows_changed.connect(self._mixed)
        self.mixers.editing_finished.connect(self.editing_finished)
        self._column.addWidget(self.mixers)

    def show_card(self, editor: FormEditor[FlightInfo]) -> None:
        """Show what is on a card, and what is being typed."""
        self._editor = editor
        for row, values in enumerate(self.values):
            for place, value in enumerate(values):
                self.throws.set_text(row, place, editor.field_text(value, self._look.units))
        written = editor.stored_value(_MIXERS) or []
        if _MIXERS not in editor.problems:
            self.mixers.show_rows([self._mixer_texts(one) for one in written])
        self.validate()

    def _mixer_texts(self, mixer: Mapping[str, object]) -> tuple[str, str, str]:
        share = format_field(create_mixer_field(), mixer.get("share"), self._look.units)
        return str(mixer.get("source", "")), str(mixer.get("target", "")), share

    def validate(self) -> None:
        """Say what will not do."""
        editor = self._editor
        if editor is None:
            return
        wrong = [
            editor.problems[value.key]
            for values in self.values
            for value in values
            if value.key in editor.problems
        ]
        self.throws.show_message(wrong[0] if wrong else "", "warning")
        self.mixers.show_message(editor.problems.get(_MIXERS, ""), "caution")

    def _typed(self, row: int, place: int, text: str) -> None:
        if self._editor is not None:
            self._editor.enter_text(self.values[row][place], text, self._look.units)
            self.validate()
            self.edited.emit()

    def _mixed(self) -> None:
        """Put the mixers on the card that are whole."""
        editor = self._editor
        if editor is None:
            return
        mixers = []
        problem = ""
        for source, target, share in self.mixers.rows:
            if not (source and target and share):
                problem = tr("Incomplete: a mixer needs from, to and share.")
                continue
            try:
                written = parse_field(create_mixer_field(), share, self._look.units)
            except UnitError as error:
                problem = str(error)
                continue
            mixers.append({"source": source, "target": target, "share": written})
        if editor.set_values({_MIXERS: mixers or None}) and problem:
            editor.problems[_MIXERS] = problem
        self.validate()
        self.edited.emit()
