"""Files of a flight being filled in: changed value by value, checked at once, saved whole."""

from __future__ import annotations

import copy
import tomllib
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import BaseModel

from gsapp.flight.atomic_files import write_flight_file
from gsapp.flight.cards import SHIPPED_CARDS, CardSet, load_cards
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.foundation import FileProblem, FileProblemsError, FlightError, read_toml
from gsapp.foundation.files import file_stamp
from gsapp.foundation.toml import toml_text, validate_content

KeyPath = tuple[str, ...]
"""Path of a value in the file: ``("weather", "temperature")``; a place in a list is its number."""

TomlContent = Mapping[str, Any]
"""What a file holds, as written there: values with units as text."""

Model = TypeVar("Model", bound=BaseModel)


class TomlDocument(ABC, Generic[Model]):
    """A TOML file, which need not be there yet, while people type into it.

    `content` is what it holds, saved or not: replaced by a change, never changed in place.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.content, self.model = self._load()
        self._saved = self.content
        self._stamp = file_stamp(self.path)
        self._placed = path.parent.is_dir()

    @abstractmethod
    def _load(self) -> tuple[TomlContent, Model]:
        """Read the file, or return what counts while there is none."""

    @abstractmethod
    def _checked(self, content: TomlContent) -> Model:
        """Return what a content says; raise `FileProblemsError` for mistakes."""

    @abstractmethod
    def _store(self, content: TomlContent, saved: TomlContent) -> None:
        """Write a content in place of one that was saved; raise `FlightError` if that fails."""

    def reload_if_changed(self) -> bool:
        """Read the file again if it changed on the disk; return whether it did.

        Changes that were not saved are given up then. While its folder is gone, what was known
        stays.
        """
        stamp = file_stamp(self.path)
        if stamp == self._stamp or self._folder_is_gone:
            return False
        self.content, self.model = self._load()
        self._saved = self.content
        self._stamp = stamp
        return True

    def value(self, key: KeyPath) -> Any:
        """Return what is written at a path; None if nothing is."""
        place: Any = self.content
        for part in key:
            if isinstance(place, list) and part.isdigit() and int(part) < len(place):
                place = place[int(part)]
            elif isinstance(place, Mapping) and part in place:
                place = place[part]
            else:
                return None
        return place

    def change(self, values: Mapping[KeyPath, Any]) -> None:
        """Take other values as they would stand in the file, None for out; `save` writes them.

        All stays as it was if the file would hold mistakes then.
        """
        content = copy.deepcopy(dict(self.content))
        for key, value in values.items():
            _set_value(content, key, value)
        self.restore(content)

    def restore(self, content: TomlContent) -> None:
        """Take a content there was before; `save` writes it."""
        self.model = self._checked(content)
        self.content = content

    @property
    def is_saved(self) -> bool:
        return self.content == self._saved

    def save(self) -> None:
        """Write what changed.

        `FlightError` if the disk refuses, or was taken away: a folder made anew in its place would
        be hidden when it comes back. What changed is still known here then.
        """
        if not self.is_saved:
            if self._folder_is_gone:
                raise FlightError(
                    f"{self.path.name} cannot be written: the folder {self.path.parent} no "
                    "longer exists; reconnect its disk, or restore its name"
                )
            self._store(self.content, self._saved)
            self._saved = self.content
            self._stamp = file_stamp(self.path)
            self._placed = True

    @property
    def _folder_is_gone(self) -> bool:
        return self._placed and not self.path.parent.is_dir()


def _set_value(place: Any, key: KeyPath, value: Any) -> None:
    """Put a value at a path; tables that become empty go."""
    head: Any = int(key[0]) if isinstance(place, list) else key[0]
    rest = key[1:]
    if rest:
        known = place[head] if isinstance(place, list) else place.get(head)
        inner = known if isinstance(known, (dict, list)) else {}
        _set_value(inner, rest, value)
        value = inner or None
    if value is not None:
        place[head] = value
    elif isinstance(place, list):
        del place[head]
    else:
        place.pop(head, None)


class FlightInfoFile(TomlDocument[FlightInfo]):
    """The card of one flight; see `TomlDocument`. Neither folder nor file need be there yet.

    Comments that people wrote into the file stay, except within tables that change.
    """

    def __init__(self, folder: FlightFolder) -> None:
        self.folder = folder
        super().__init__(folder.info_file)

    def _load(self) -> tuple[TomlContent, FlightInfo]:
        if not self.path.exists():
            return {}, FlightInfo()
        info = read_toml(self.path, FlightInfo)
        return tomllib.loads(self.path.read_text(encoding="utf-8")), info

    def _checked(self, content: TomlContent) -> FlightInfo:
        return validate_content(self.path, content, FlightInfo)

    def _store(self, content: TomlContent, saved: TomlContent) -> None:
        names = dict.fromkeys((*content, *saved))
        changes = {name: content.get(name) for name in names}
        self.folder.update_info(
            **{name: value for name, value in changes.items() if value != saved.get(name)}
        )


class CardSetFile(TomlDocument[CardSet]):
    """A set of test cards; see `TomlDocument`. Values stay in the units they were typed in.

    While there is no such file, the shipped set called `usual` counts.
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
        """Write the cards into another file as well."""
        write_flight_file(path, toml_text(self.content))

    # The cards as a list

    @property
    def rows(self) -> list[dict[str, Any]]:
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
