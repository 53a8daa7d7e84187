"""What is on board beside what the aircraft file counts: ballast, cameras, things taken out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gsapp.flight.info import FlightInfo
from gsapp.foundation import UnitError
from ui.display_style import DisplayStyle
from ui.preflight.field_grid import GridColumn, GrowingFieldGrid
from ui.preflight.flight_card_fields import (
    create_payload_mass_field,
    create_payload_position_field,
    format_field,
    parse_field,
)
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_part import FormPart
from ui.translation import tr
from ui.widgets.labels import create_label

_LOADING = ("loading",)
_DEFAULT_YZ = ("0 m", "0 m")


class PayloadForm(FormPart[FlightInfo]):
    """Rows of things on board, each with its mass and its place."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        self._column.addWidget(
            create_label(tr("Ballast, cameras; negative for removed items"), "hint", wrap=True)
        )
        self.rows = GrowingFieldGrid(
            look,
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
        units = self._look.units
        mass, place = (
            create_payload_mass_field().unit_label(units),
            create_payload_position_field().unit_label(units),
        )
        for title, words in zip(
            self.rows.titles,
            (
                tr("What"),
                tr("Mass, {mass}").format(mass=mass),
                tr("Ahead of CG, {place}").format(place=place),
            ),
            strict=True,
        ):
            title.setText(words)
        if _LOADING not in editor.problems:
            self.rows.show_rows([self._texts(one) for one in editor.stored_value(_LOADING) or ()])
        self.validate()

    def _texts(self, item: Mapping[str, Any]) -> tuple[str, str, str]:
        units = self._look.units
        ahead = item.get("position", (None,))[0]
        return (
            str(item.get("what", "")),
            format_field(create_payload_mass_field(), item.get("mass"), units),
            format_field(create_payload_position_field(), ahead, units),
        )

    def validate(self) -> None:
        """Say what will not do."""
        if self._editor is not None:
            self.rows.show_message(self._editor.problems.get(_LOADING, ""), "caution")

    def _listed(self) -> None:
        """Put on the card what is whole."""
        editor = self._editor
        if editor is None:
            return
        known = {str(one.get("what")): one for one in editor.stored_value(_LOADING) or ()}
        items, problem = [], ""
        for row in self.rows.rows:
            if not all(row):
                problem = tr("Incomplete: enter item, mass and distance ahead of the CG.")
                continue
            try:
                items.append(self._item(row, known))
            except UnitError as error:
                problem = str(error)
        if editor.set_values({_LOADING: items or None}) and problem:
            editor.problems[_LOADING] = problem
        self.validate()
        self.edited.emit()

    def _item(self, row: Sequence[str], known: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
        what, mass, ahead = row
        units = self._look.units
        # To the side and down as the file says, where it does.
        beside = list(known.get(what, {}).get("position", ("", *_DEFAULT_YZ)))[1:]
        return {
            "what": what,
            "mass": parse_field(create_payload_mass_field(), mass, units),
            "position": [parse_field(create_payload_position_field(), ahead, units), *beside],
        }
