"""Parts of the flight card: payload, transmitter, and weight by scales under the wheels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from PySide6.QtWidgets import QPushButton

from gsapp.aircraft import Aircraft
from gsapp.flight.info import FlightInfo
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.preflight.flight_card_fields import (
    STICKS,
    THROW_COLUMNS,
    TRANSMITTER_CONTROLS,
    WEIGHING_CONDITION_FIELDS,
    WEIGHING_METHODS,
    CardField,
    create_mixer_field,
    create_payload_mass_field,
    create_payload_position_field,
    create_scale_fields,
    create_throw_field,
    describe_weighing,
    find_weighing_method,
    format_field,
    format_takeoff_weight,
    list_weighed_supports,
    parse_field,
)
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_fields import (
    FieldGrid,
    FormField,
    FormPart,
    GridColumn,
    GrowingFieldGrid,
    set_touch_height,
)
from ui.translation import tr
from ui.widgets.labels import create_label

_LOADING = ("loading",)
_DEFAULT_YZ = ("0 m", "0 m")


class PayloadForm(FormPart[FlightInfo]):
    """Rows of things on board, each with its mass and its place."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        self._column.addWidget(
            create_label(tr("Ballast, cameras; negative for removed items"), "hint", wrap=True)
        )
        self.rows = GrowingFieldGrid(
            style,
            [
                GridColumn(name=tr("What"), share=3),
                GridColumn(name=tr("Mass"), share=2),
                GridColumn(name=tr("Ahead of CG"), share=2),
            ],
        )
        self.rows.rows_changed.connect(self._listed)
        self.rows.editing_finished.connect(self.editing_finished)
        self._column.addWidget(self.rows)

    def show_card(self, editor: FormEditor[FlightInfo]) -> None:
        """Show what is on a card, and what is being typed."""
        self._editor = editor
        units = self._style.units
        mass, place = (
            create_payload_mass_field().unit_label(units),
            create_payload_position_field().unit_label(units),
        )
        for title, text in zip(
            self.rows.titles,
            (
                tr("What"),
                tr("Mass, {mass}").format(mass=mass),
                tr("Ahead of CG, {place}").format(place=place),
            ),
            strict=True,
        ):
            title.setText(text)
        if _LOADING not in editor.problems:
            self.rows.show_rows([self._texts(one) for one in editor.stored_value(_LOADING) or ()])
        self.validate()

    def _texts(self, item: Mapping[str, Any]) -> tuple[str, str, str]:
        units = self._style.units
        ahead = item.get("position", (None,))[0]
        return (
            str(item.get("what", "")),
            format_field(create_payload_mass_field(), item.get("mass"), units),
            format_field(create_payload_position_field(), ahead, units),
        )

    def validate(self) -> None:
        if self._editor is not None:
            self.rows.show_message(self._editor.problems.get(_LOADING, ""), "caution")

    def _listed(self) -> None:
        if self._editor is not None:
            written = self._editor.stored_value(_LOADING) or ()
            known = {str(one.get("what")): one for one in written}
            self._store_rows(
                _LOADING,
                self.rows.rows,
                lambda row: self._item(row, known),
                tr("Incomplete: enter item, mass and distance ahead of the CG."),
            )

    def _item(self, row: Sequence[str], known: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
        what, mass, ahead = row
        units = self._style.units
        # To the side and down as the file says, where it does.
        beside = list(known.get(what, {}).get("position", ("", *_DEFAULT_YZ)))[1:]
        return {
            "what": what,
            "mass": parse_field(create_payload_mass_field(), mass, units),
            "position": [parse_field(create_payload_position_field(), ahead, units), *beside],
        }


_TABLE = ("weighing",)
_LOADS = (*_TABLE, "loads")
_MIXERS = ("transmitter", "mixers")
_COLUMNS = (*(name for name, _words in THROW_COLUMNS), "trim")
_NO_CHANNEL_CHOICE = ("", "–")


class TransmitterForm(FormPart[FlightInfo]):
    """Throws of the sticks in percent, and what is mixed into what."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        titles = (*(tr(text) for _name, text in THROW_COLUMNS), tr("Trim"))
        self.throws = FieldGrid(
            style,
            [GridColumn(name=f"{text} %") for text in titles],
            [tr(text) for _stick, text in STICKS],
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
            style,
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
            for index, value in enumerate(values):
                self.throws.set_text(row, index, editor.field_text(value, self._style.units))
        written = editor.stored_value(_MIXERS) or []
        if _MIXERS not in editor.problems:
            self.mixers.show_rows([self._mixer_texts(one) for one in written])
        self.validate()

    def _mixer_texts(self, mixer: Mapping[str, object]) -> tuple[str, str, str]:
        share = format_field(create_mixer_field(), mixer.get("share"), self._style.units)
        return str(mixer.get("source", "")), str(mixer.get("target", "")), share

    def validate(self) -> None:
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
            self._editor.enter_text(self.values[row][place], text, self._style.units)
            self.validate()
            self.edited.emit()

    def _mixed(self) -> None:
        incomplete = tr("Incomplete: a mixer needs from, to and share.")
        self._store_rows(_MIXERS, self.mixers.rows, self._mixer, incomplete)

    def _mixer(self, row: Sequence[str]) -> dict[str, Any]:
        source, target, share = row
        written = parse_field(create_mixer_field(), share, self._style.units)
        return {"source": source, "target": target, "share": written}


class WeighingForm(FormPart[FlightInfo]):
    """Readings of the scales, and what they say."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        self._aircraft: Aircraft | None = None
        self._way = ""
        self.way = FormField(style, tr("Weighed on"), choices=WEIGHING_METHODS)
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
        style.changed.connect(self._fit)
        self._fit()

    def _add(self, name: str, value: CardField) -> None:
        field = FormField(self._style, value.name)
        field.text_edited.connect(lambda text: self._typed(value, text))
        field.editing_finished.connect(self.editing_finished)
        self.fields[name] = (value, field)
        self._column.addWidget(field)

    def _fit(self) -> None:
        self._column.setSpacing(self._style.px(8))

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
            field.set_text(editor.field_text(value, self._style.units))
            field.show_unit(value.unit_label(self._style.units))
        self.validate()

    def validate(self) -> None:
        editor = self._editor
        if editor is None:
            return
        asked = self._scales(self._way)
        more = [value.key[-1] for value in WEIGHING_CONDITION_FIELDS] if self._way else []
        for name, (value, field) in self.fields.items():
            field.setVisible(name in (*asked, *more))
            field.show_message(*self._remark(value))
        said = describe_weighing(editor.file.model, self._aircraft, self._style.units)
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

    def show_warning(self, text: str) -> None:
        """Say what is odd about the weighing, or nothing."""
        self.doubts.set_message(text, "caution")
        self.doubts.setVisible(bool(text))

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
                name: editor.field_text(self.fields[name][0], self._style.units) for name in kept
            }
            editor.set_values({_TABLE: None})
            for name, text in texts.items():
                if text:
                    editor.enter_text(self.fields[name][0], text, self._style.units)
        elif not way:
            editor.discard_group(_TABLE)
        self.show_card(editor, self._aircraft)
        self.edited.emit()

    def _typed(self, value: CardField, text: str) -> None:
        if self._editor is not None:
            self._editor.enter_text(value, text, self._style.units)
            self.validate()
            self.edited.emit()

    def _apply_weighing(self) -> None:
        editor = self._editor
        if editor is None:
            return
        said = describe_weighing(editor.file.model, self._aircraft, self._style.units)
        if said.weighed is not None:
            weight = format_takeoff_weight(said.weighed, editor.file.model, self._style.units)
            editor.set_values({("takeoff_weight",): weight})
            self.edited.emit()
