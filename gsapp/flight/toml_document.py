"""A file of a flight being filled in: changed value by value, checked at once, saved whole."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import BaseModel

from gsapp.foundation import FlightError
from gsapp.foundation.files import file_stamp

KeyPath = tuple[str, ...]
"""Path of a value in the file: ``("weather", "temperature")``; a place in a list is its number."""

TomlContent = Mapping[str, Any]
"""What a file holds, as written there: values with units as text."""

Model = TypeVar("Model", bound=BaseModel)


class TomlDocument(ABC, Generic[Model]):
    """A TOML file while people type into it.

    Parameters
    ----------
    path : Path
        The file; it need not be there yet.

    Attributes
    ----------
    content : mapping
        What it holds, saved or not. Replaced by a change, never changed in place.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes.
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

        Raises
        ------
        FileProblemsError
            If it holds mistakes; what was known before stays.
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
        """Take other values; `save` writes them.

        Parameters
        ----------
        values : mapping of path to value
            As they would stand in the file; None takes one out.

        Raises
        ------
        FileProblemsError
            If the file would hold mistakes then; key paths say where. All stays as it was.
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
        """Return whether the file holds what is known here."""
        return self.content == self._saved

    def save(self) -> None:
        """Write what changed.

        Raises
        ------
        FlightError
            If the disk refuses, or was taken away: a folder made anew in its place would be
            hidden when it comes back. What changed is still known here then.
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
