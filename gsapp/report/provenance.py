"""What a report was made from: the files with their sums, the settings, the versions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gsapp.flight.provenance import InputFile
from gsapp.report.document import DocumentPart, DocumentSection, DocumentTable, Paragraph


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """What a result was made from."""

    inputs: tuple[InputFile, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)


def provenance_section(provenance: Provenance) -> DocumentSection:
    """Return the last section of a report: enough to make it again, and to check that it is it."""
    parts: list[DocumentPart] = [
        Paragraph(
            text="The same files, settings and versions give the same report except for the date.",
            kind="note",
        )
    ]
    if provenance.inputs:
        parts.append(
            DocumentTable(
                caption="Files",
                columns=("what", "name", "SHA-256"),
                rows=tuple((one.role, one.name, one.sha256) for one in provenance.inputs),
            )
        )
    for caption, content in (("Settings", provenance.settings), ("Versions", provenance.versions)):
        if content:
            rows = tuple((name, value) for name, value in content.items())
            parts.append(DocumentTable(caption=caption, columns=("", ""), rows=rows))
    return DocumentSection(title="Provenance", parts=tuple(parts))
