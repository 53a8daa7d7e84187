"""The test cards of a flight being planned: ``cards.toml`` changed value by value."""

from __future__ import annotations

import copy
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from gsapp.flight.atomic_files import write_flight_file
from gsapp.flight.cards import SHIPPED_CARDS, CardSet, load_cards
from gsapp.flight.toml_document import TomlContent, TomlDocument
from gsapp.foundation import FileProblem, FileProblemsError
from gsapp.foundation.toml import toml_text, validate_content


class CardSetFile(TomlDocument[CardSet]):
    """A set of test cards; see `TomlDocument`. Values stay in the units they were typed in.

    Parameters
    ----------
    path : Path
        ``cards.toml`` of a flight, or of the next one.
    usual : str
        Name of the shipped set that counts while there is no such file.
    """

    def __init__(self, path: Path, usual: str) -> None:
        self._usual = usual
        super().__init__(path)

    def _load(self) -> tuple[TomlContent, CardSet]:
        path = self.path if self.path.is_file() else SHIPPED_CARDS.find(self._usual)
        cards = load_cards(path)
        return tomllib.loads(path.read_text(encoding="utf-8")), cards

    def _checked(self, content: TomlContent) -> CardSet:
        cards = validate_content(self.path, content, CardSet)
        count = Counter(card.id for card in cards.cards)
        twice = [name for name, number in count.items() if number > 1]
        if twice:
            raise FileProblemsError(
                self.path,
                [
                    FileProblem(
                        where="cards",
                        what=f"two cards have the id '{twice[0]}'",
                        remedy="give each its own",
                    )
                ],
            )
        return cards

    def _store(self, content: TomlContent, saved: TomlContent) -> None:  # noqa: ARG002
        write_flight_file(self.path, toml_text(content))

    def save_as(self, path: Path) -> None:
        """Write the cards into another file as well.

        Raises
        ------
        FlightError
            If the disk refuses.
        """
        write_flight_file(path, toml_text(self.content))

    # The cards as a list

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Return a copy of the cards as the file holds them, to be changed and put back."""
        return copy.deepcopy(list(self.content["cards"]))

    def with_duplicated_row(self, row: int) -> list[dict[str, Any]]:
        """Return the cards with a copy of one below it, under an id of its own."""
        rows = self.rows
        made = copy.deepcopy(rows[row])
        known = {str(one["id"]) for one in rows}
        stem = str(made["id"]).rstrip("0123456789") or str(made["id"])
        number = 1
        while f"{stem}{number}" in known:
            number += 1
        made["id"] = f"{stem}{number}"
        rows.insert(row + 1, made)
        return rows
