"""The flight card being filled in: ``flight.toml`` changed value by value."""

from __future__ import annotations

import tomllib

from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.toml_document import TomlContent, TomlDocument
from gsapp.foundation import read_toml
from gsapp.foundation.toml import validate_content


class FlightInfoFile(TomlDocument[FlightInfo]):
    """The card of one flight; see `TomlDocument`.

    Comments that people wrote into the file stay, except within tables that change.

    Parameters
    ----------
    folder : FlightFolder
        Its folder; neither it nor the file need be there yet.
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
