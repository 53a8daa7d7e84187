"""What an estimation is asked for: flights, maneuvers with their edges, and settings."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.identification.campaign import CampaignSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectedManeuver:
    """A maneuver to estimate from, with its edges as they are now.

    Attributes
    ----------
    flight : Path
        One of the request's flights.
    id : str
        Within its flight.
    t_start, t_end : float
        First and last sample, s of flight time.
    inputs : tuple of str
        Surfaces moved, of ``de``, ``da``, ``dr``.
    kind : str
        ``doublet`` ...
    found : DetectedManeuver or None
        All that is known of it, where it is at hand: for the catalog, which wants its grade. It
        changes no number, and is not kept with a run.
    """

    flight: Path
    id: str
    t_start: float
    t_end: float
    inputs: tuple[str, ...]
    kind: str = ""
    found: DetectedManeuver | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """One estimation.

    Attributes
    ----------
    flights : tuple of Path
        Flight folders or files, in the order in which they are numbered.
    maneuvers : tuple of SelectedManeuver
        Those to be used, in order. Empty: all that stand in the flights and are not unfit.
    settings : CampaignSettings
        Its weights are by name of the flight.
    aircraft : str
        Name or path; empty takes the copy in each flight folder.
    calibration, channel_map : str
        Names or paths; empty where the flights say it themselves.
    label : str
        What the user calls the run.
    given : tuple of str
        Windows ``START:STOP`` or ``K:START:STOP`` in place of what stands in the flights. Where
        `maneuvers` are named, they only tell where those came from.
    every_grade : bool
        Whether maneuvers graded unfit stay in; likewise.
    as_found : bool
        Whether to leave out what was changed by hand; likewise.
    weights, model : str
        Names or paths of files. They are read where `settings` hold none; else they only tell
        where those came from.
    without : tuple of str
        Maneuvers that count in no mean, as the outcome calls them: ``M4``, of several flights
        ``2:M4``. They are fitted all the same.
    """

    flights: tuple[Path, ...]
    maneuvers: tuple[SelectedManeuver, ...] = ()
    settings: CampaignSettings = field(default_factory=CampaignSettings)
    aircraft: str = ""
    calibration: str = ""
    channel_map: str = ""
    label: str = ""
    given: tuple[str, ...] = ()
    every_grade: bool = False
    as_found: bool = False
    weights: str = ""
    model: str = ""
    without: tuple[str, ...] = ()
