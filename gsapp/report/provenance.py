"""What a report was made from: the files with their sums, the settings, the versions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from calibration import certificate_paths
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.model import SHIPPED_MODELS as MODELS
from gsapp.flight.events import events_path
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import InputFile, hash_input_file
from gsapp.identification.runs.request import describe_settings
from gsapp.identification.runs.run_execution import RunOutcome
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


def campaign_provenance(outcome: RunOutcome) -> Provenance:
    """Return the files of a run with their sums, its settings in words, and the versions.

    Files are called by their names alone: where they lie on this machine changes no number.
    """
    request = outcome.request
    settings = describe_settings(
        request.with_changes(
            aircraft=_name(request.aircraft),
            channel_map=_name(request.channel_map),
            calibration=_name(request.calibration),
        )
    )
    return Provenance(
        inputs=tuple(replace(one, name=_name(one.name)) for one in outcome.inputs),
        settings={
            "maneuvers": ", ".join(request.maneuver_windows)
            or "as found, with what was changed by hand",
            **settings,
        },
        versions=outcome.versions,
    )


def _name(path: str) -> str:
    return Path(path).name if path else ""


def search_provenance(flights: Sequence[Path], settings: DiscrepancySettings) -> Provenance:
    """Return the files of a search with their sums, its settings, and the versions.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    OSError
        If one cannot be read.
    """
    calibration, as_found = settings.calibration, settings.as_found
    named = (
        ("aircraft", settings.aircraft, AIRCRAFT_FILES),
        ("model", settings.model, MODELS),
        ("channel map", settings.channel_map, MAPS),
    )
    return Provenance(
        inputs=(
            *(hash_input_file("flight", path) for path in flights),
            *(
                hash_input_file("manual changes", events_path(path))
                for path in flights
                if not (as_found or path.is_dir()) and events_path(path).is_file()
            ),
            *(
                hash_input_file(role, shipped.find(name), name=name)
                for role, name, shipped in named
                if name
            ),
            *(
                hash_input_file("certificate", path, name=f"{calibration}: {path.name}")
                for path in (certificate_paths(calibration) if calibration else ())
            ),
        ),
        settings={
            "maneuvers": ", ".join(settings.maneuver_windows)
            or f"found by the program{'' if as_found else ', with manual changes'}",
            "certificates": f"those of '{calibration}' in place of the flights' own"
            if calibration
            else "certificates of the flights",
            "model before": settings.model or "fitted on these flights",
            "held out": ", ".join(settings.held_out or ()) or "automatic",
            "refused": ", ".join(settings.refused) or "none",
            "forced": ", ".join(settings.forced) or "none",
            "most effects": str(settings.most_effects),
            "chance of a false name": f"{settings.false_alarm:g}",
        },
        versions=current_versions(),
    )
