"""What a result was made from: files and folders with their sums."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from gsapp.flight.file_names import (
    CACHE_FOLDER,
    EVENTS_FILE,
    LOCK_FILE,
    LOG_FILE,
    STATUS_FILE,
    STOP_FILE,
)
from gsapp.foundation.files import is_system_file

NON_DATA_FILES: Final = frozenset({EVENTS_FILE, STATUS_FILE, LOCK_FILE, STOP_FILE, LOG_FILE})
"""Files of a flight folder from which no number of the record comes: notes, the recorder's own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputFile:
    """A file or folder that went in."""

    role: str
    name: str
    """As the user called it."""
    sha256: str
    """Of the bytes; of a folder: of the names and bytes of all its files but its cache."""
    parts: Mapping[str, str] = field(default_factory=dict)
    """Of a folder: the sum of each of its files; empty for a file."""


def hash_input_file(role: str, path: Path, *, name: str = "") -> InputFile:
    """Return a file or folder with its sum, under the name given or its path."""
    parts: dict[str, str] = {}
    if path.is_dir():
        for inner in sorted(path.rglob("*"), key=lambda one: one.relative_to(path).parts):
            inside = inner.relative_to(path)
            if inner.is_file() and not is_system_file(inner) and inside.parts[0] != CACHE_FOLDER:
                parts[inside.as_posix()] = _sum(inner)
        digest = hashlib.sha256()
        for inside_name, found in parts.items():
            digest.update(f"{inside_name}\0{found}\n".encode())
        return InputFile(role=role, name=name or str(path), sha256=digest.hexdigest(), parts=parts)
    return InputFile(role=role, name=name or str(path), sha256=_sum(path))


def find_changed_parts(before: InputFile, now: InputFile) -> tuple[str, ...]:
    """Return what changed of an input that can change numbers, by name; empty for nothing.

    Marks, notes and edits of maneuvers are no part of the record.
    """
    if before.sha256 == now.sha256:
        return ()
    if not before.parts or not now.parts:
        return (now.name,)
    names = sorted({*before.parts, *now.parts} - NON_DATA_FILES)
    return tuple(
        f"{now.name}/{name}" for name in names if before.parts.get(name) != now.parts.get(name)
    )


def _sum(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
