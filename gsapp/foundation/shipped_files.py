"""Files that come with the program and are called by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gsapp.foundation.errors import UnknownNameError
from gsapp.foundation.files import list_files
from gsapp.foundation.name_suggestions import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class ShippedFiles:
    """A folder of TOML files that can be named without path or ending."""

    folder: Path  # Where they lie.
    kind: str  # What they are, in words.

    def names(self) -> tuple[str, ...]:
        return tuple(path.stem for path in list_files(self.folder, "*.toml"))

    def find(self, name_or_path: str | Path) -> Path:
        """Return the path for a path or a name; a file on disk goes before a name.

        Raise UnknownNameError if there is neither; near names are proposed.
        """
        path = Path(name_or_path)
        if path.is_file():
            return path
        text = str(name_or_path)
        if text in self.names():
            return self.folder / f"{text}.toml"
        hint = did_you_mean(text, self.names(), most=1)
        raise UnknownNameError(
            f"there is no {self.kind} file '{text}', and no shipped one has that name; "
            f"{hint + ' ' if hint else ''}shipped are: {', '.join(self.names())}"
        )
