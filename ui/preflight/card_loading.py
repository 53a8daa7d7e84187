"""What is on board beside what the aircraft file counts: ballast, cameras, things taken out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gsapp.flight.info import FlightInfo
from gsapp.foundation import UnitError
from ui.look import Look
from ui.pages import label
from ui.preflight.card_form import loading_mass, loading_place, read, shown
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_part import FormPart
from ui.preflight.row_fields import Column, GrowingRows

_LOADING = ("loading",)
_BESIDE = ("0 m", "0 m")


class LoadingForm(FormPart[FlightInfo]):
    """Rows of things on board, each with its mass and its place."""

    def __init__(self, look: Look) -> None:
        super().__init__(look)
        self._column.addWidget(
            label("Ballast, cameras, what was taken out (negative)", "hint", wrap=True)
        )
        self.rows = GrowingRows(
            look,
            [
                Column(name="What", share=3),
                Column(name="Mass", share=2),
                Column(name="Ahead of CG", share=2),
            ],
        )
        self.rows.listed.connect(self._listed)
        self.rows.left.connect(self.left)
        self._column.addWidget(self.rows)

    def show_card(self, editor: FormEditor[FlightInfo]) -> None:
        """Show what is on a card, and what is being typed."""
        self._editor = editor
        units = self._look.units
        mass, place = loading_mass().unit_shown(units), loading_place().unit_shown(units)
        for title, words in zip(
            self.rows.titles, ("What", f"Mass, {mass}", f"Ahead of CG, {place}"), strict=True
        ):
            title.setText(words)
        if _LOADING not in editor.problems:
            self.rows.show_rows([self._texts(one) for one in editor.written(_LOADING) or ()])
        self.judge()

    def _texts(self, item: Mapping[str, Any]) -> tuple[str, str, str]:
        units = self._look.units
        ahead = item.get("position", (None,))[0]
        return (
            str(item.get("what", "")),
            shown(loading_mass(), item.get("mass"), units),
            shown(loading_place(), ahead, units),
        )

    def judge(self) -> None:
        """Say what will not do."""
        if self._editor is not None:
            self.rows.say(self._editor.problems.get(_LOADING, ""), "caution")

    def _listed(self) -> None:
        """Put on the card what is whole."""
        editor = self._editor
        if editor is None:
            return
        known = {str(one.get("what")): one for one in editor.written(_LOADING) or ()}
        items, problem = [], ""
        for row in self.rows.rows:
            if not all(row):
                problem = "Not on the card yet: write what, mass, and how far ahead of the CG."
                continue
            try:
                items.append(self._item(row, known))
            except UnitError as error:
                problem = str(error)
        if editor.put({_LOADING: items or None}) and problem:
            editor.problems[_LOADING] = problem
        self.judge()
        self.typed.emit()

    def _item(self, row: Sequence[str], known: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
        what, mass, ahead = row
        units = self._look.units
        # To the side and down as the file says, where it does.
        beside = list(known.get(what, {}).get("position", ("", *_BESIDE)))[1:]
        return {
            "what": what,
            "mass": read(loading_mass(), mass, units),
            "position": [read(loading_place(), ahead, units), *beside],
        }
