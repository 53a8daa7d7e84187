"""The flight card being filled in: ``flight.toml`` changed value by value, saved at once."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from typing import Any

from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.foundation import read_toml
from gsapp.foundation.toml import validate

Key = tuple[str, ...]
"""Path of a value in the file: ``("weather", "temperature")``."""

Content = Mapping[str, Any]
"""What the file holds, as written there: values with units as text."""


class CardFile:
    """The card of one flight.

    Parameters
    ----------
    folder : FlightFolder
        Its folder; neither it nor the file need be there yet.

    Attributes
    ----------
    content : mapping
        What the file holds. Replaced by a change, never changed in place.
    info : FlightInfo
        The same, read.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes.
    """

    def __init__(self, folder: FlightFolder) -> None:
        self.folder = folder
        self.content: Content = {}
        self.info = FlightInfo()
        self._saved: Content = {}
        self._stamp: tuple[int, int] | None = None
        self.read()

    def read(self) -> bool:
        """Read the file again if it changed on the disk; return whether it did.

        Changes that were not saved are given up then.

        Raises
        ------
        FileProblemsError
            If it holds mistakes; what was known before stays.
        """
        stamp = self._stamp_now()
        if stamp == self._stamp:
            return False
        path = self.folder.info_file
        if stamp is None:
            self.info, self.content = FlightInfo(), {}
        else:
            self.info = read_toml(path, FlightInfo)
            self.content = tomllib.loads(path.read_text(encoding="utf-8"))
        self._saved = self.content
        self._stamp = stamp
        return True

    def value(self, key: Key) -> Any:
        """Return what is written at a path; None if nothing is."""
        place: Any = self.content
        for part in key:
            if not isinstance(place, Mapping) or part not in place:
                return None
            place = place[part]
        return place

    def change(self, values: Mapping[Key, Any]) -> None:
        """Take other values; `save` writes them.

        Parameters
        ----------
        values : mapping of path to value
            As they would stand in the file; None takes one out.

        Raises
        ------
        FileProblemsError
            If the card would hold mistakes then; key paths say where. It stays as it was.
        """
        content = copy.deepcopy(dict(self.content))
        for key, value in values.items():
            _put(content, key, value)
        self.restore(content)

    def restore(self, content: Content) -> None:
        """Take a content there was before; `save` writes it."""
        self.info = validate(self.folder.info_file, content, FlightInfo)
        self.content = content

    @property
    def is_saved(self) -> bool:
        """Return whether the file holds what is known here."""
        return self.content == self._saved

    def save(self) -> None:
        """Write what changed.

        Comments that people wrote into the file stay, except within tables that change.

        Raises
        ------
        FlightError
            If the disk refuses; what changed is still known here then.
        """
        names = dict.fromkeys((*self.content, *self._saved))
        changes = {
            name: self.content.get(name)
            for name in names
            if self.content.get(name) != self._saved.get(name)
        }
        if changes:
            self.folder.update_info(**changes)
            self._saved = self.content
            self._stamp = self._stamp_now()

    def _stamp_now(self) -> tuple[int, int] | None:
        try:
            found = self.folder.info_file.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size


def _put(content: dict[str, Any], key: Key, value: Any) -> None:
    """Put a value at a path; tables that become empty go."""
    head, rest = key[0], key[1:]
    if rest:
        inner = dict(content.get(head) or {})
        _put(inner, rest, value)
        value = inner or None
    if value is None:
        content.pop(head, None)
    else:
        content[head] = value
