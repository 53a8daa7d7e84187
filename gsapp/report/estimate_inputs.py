"""What the report on a campaign is made from: files with their sums, settings, versions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from calibration import certificate_files
from gsapp.aircraft.reading import SHIPPED as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED as MAPS
from gsapp.dynamics.model import SHIPPED as MODELS
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import input_file
from gsapp.identification.campaign import CampaignSettings
from gsapp.identification.weights import SHIPPED as WEIGHTS
from gsapp.report.estimate_words import METHODS
from gsapp.report.provenance import Provenance


def campaign_provenance(
    flights: Sequence[Path],
    settings: CampaignSettings,
    *,
    aircraft: str | None = None,
    model: str | None = None,
    weights: str | None = None,
    channel_map: str | None = None,
    calibration: str | None = None,
    maneuvers: Sequence[str] = (),
    every_grade: bool = False,
) -> Provenance:
    """Return the files of an estimation with their sums, its settings, and the versions.

    Parameters
    ----------
    flights : sequence of Path
    settings : CampaignSettings
    aircraft, model, weights, channel_map : str, optional
        Names or paths, where they were given.
    calibration : str, optional
        Certificates given in place of those kept with the flights: a folder, or a shipped set.
    maneuvers : sequence of str
        Windows that were named in place of what would be found.
    every_grade : bool
        Whether maneuvers that were graded unfit stayed in.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    OSError
        If one cannot be read.
    """
    named = (
        ("aircraft", aircraft, AIRCRAFT_FILES),
        ("model", model, MODELS),
        ("weights", weights, WEIGHTS),
        ("channel map", channel_map, MAPS),
    )
    return Provenance(
        inputs=(
            *(input_file("flight", path, name=path.name) for path in flights),
            *(
                input_file(role, shipped.find(name), name=name)
                for role, name, shipped in named
                if name
            ),
            *(
                input_file("certificate", path, name=f"{calibration}: {path.name}")
                for path in (certificate_files(calibration) if calibration else ())
            ),
        ),
        settings={
            "method": METHODS[settings.method],
            "axis": settings.axis,
            "maneuvers": ", ".join(maneuvers) or "found by the program",
            "unfit maneuvers": "kept" if every_grade else "left out",
            "certificates": f"those of '{calibration}' in place of the flights' own"
            if calibration
            else "those kept with the flights",
            "weights": weights or "noise estimated from the residuals",
            "model before": model or "none",
            "all maneuvers together": "fitted too" if settings.joint else "not fitted",
        },
        versions=current_versions(),
    )
