"""What the report on a campaign is made from: files with their sums, settings, versions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gsapp.identification.runs.request import describe_settings
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.report.provenance import Provenance


def campaign_provenance(outcome: RunOutcome) -> Provenance:
    """Return the files of a run with their sums, its settings in words, and the versions.

    Files are called by their names alone: where they lie on this machine changes no number.

    Parameters
    ----------
    outcome : RunOutcome
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
