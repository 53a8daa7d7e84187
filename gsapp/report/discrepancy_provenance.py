"""What a search for a missing effect was made from, for the last page of its report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from calibration import certificate_paths
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.model import SHIPPED_MODELS as MODELS
from gsapp.flight.events import events_path
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import hash_input_file
from gsapp.report.provenance import Provenance


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
