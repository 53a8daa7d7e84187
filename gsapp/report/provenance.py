"""What a report was made from: the files with their sums, the settings, the versions."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gsapp.report.document import Paragraph, Part, Section, Table

_REBUILT = "cache"
"""Folder of a flight that can always be made again and says nothing of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputFile:
    """A file or folder that went in.

    Attributes
    ----------
    role : str
        "flight", "aircraft", ...
    name : str
        As the user called it.
    sha256 : str
        Of the bytes; of a folder: of the names and bytes of all its files but its cache.
    """

    role: str
    name: str
    sha256: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """What a result was made from."""

    inputs: tuple[InputFile, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)


def input_file(role: str, path: Path, *, name: str = "") -> InputFile:
    """Return a file or folder with its sum.

    Parameters
    ----------
    role : str
    path : Path
    name : str
        As it shall be called; the path where empty.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    digest = hashlib.sha256()
    if path.is_dir():
        for inner in sorted(path.rglob("*"), key=lambda one: one.relative_to(path).parts):
            parts = inner.relative_to(path).parts
            if inner.is_file() and parts[0] != _REBUILT:
                digest.update(f"{'/'.join(parts)}\0{_sum(inner)}\n".encode())
        found = digest.hexdigest()
    else:
        found = _sum(path)
    return InputFile(role=role, name=name or str(path), sha256=found)


def _sum(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def provenance_section(provenance: Provenance) -> Section:
    """Return the last section of a report: enough to make it again, and to check that it is it."""
    parts: list[Part] = [
        Paragraph(
            text="The same files, settings and versions give the same report, but for the date.",
            kind="note",
        )
    ]
    if provenance.inputs:
        parts.append(
            Table(
                caption="Files",
                columns=("what", "name", "SHA-256"),
                rows=tuple((one.role, one.name, one.sha256) for one in provenance.inputs),
            )
        )
    for caption, content in (("Settings", provenance.settings), ("Versions", provenance.versions)):
        if content:
            rows = tuple((name, value) for name, value in content.items())
            parts.append(Table(caption=caption, columns=("", ""), rows=rows))
    return Section(title="What this report was made from", parts=tuple(parts))
