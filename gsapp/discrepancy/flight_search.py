"""The search for a missing effect in flights: from files to the result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from gsapp.discrepancy.effect_catalog import find_effect
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import DiscrepancyResult
from gsapp.discrepancy.search_checks import check_model_match, record_remarks
from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgressCallback
from gsapp.dynamics.model import load_model
from gsapp.flight.flight import calibration_sentences
from gsapp.flight.maneuvers import uncalibrated_text
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.executors import WorkerPool
from gsapp.identification.maneuver import (
    FlightWithManeuvers,
    Maneuver,
    no_maneuvers_text,
    open_flights_with_maneuvers,
)


def check_effects(settings: DiscrepancySettings) -> None:
    """Raise if an effect that is refused or forced is not in the catalog."""
    for name in (*settings.refused, *settings.forced):
        # Structure without a name is found, not listed; it may be refused by what it was called.
        if not name.startswith("unnamed."):
            find_effect(name)


def search_flights(
    paths: Sequence[Path],
    settings: DiscrepancySettings,
    *,
    draw: Sequence[str] = (),
    doing: Callable[[str], object] | None = None,
    progress: SearchProgressCallback | None = None,
    pool: WorkerPool | None = None,
) -> tuple[tuple[FlightWithManeuvers, ...], DiscrepancyResult]:
    """Open flights, cut their maneuvers and search for the effect that the model lacks.

    `draw`: maneuvers that a report is to show, checked before the search.
    `doing`: told what is being done, in words, before the search.
    `progress`: told how far the search is.
    `pool`: where flights are read.

    Raises `GroundStationError` if a flight or file cannot be read, there are too few maneuvers, or
    one that was named is not among them.
    """
    model = load_model(settings.model) if settings.model else None
    flown = open_flights_with_maneuvers(paths, settings, doing=doing, pool=pool, keep_samples=False)
    own = flown[0].aircraft
    maneuvers = [one for flight in flown for one in flight.maneuvers]
    if not maneuvers:
        raise FlightError(
            f"no maneuver to compare model and flight by: {no_maneuvers_text(flown)}; name windows "
            "of the flight with --maneuver START:STOP, or fly doublets"
        )
    _check_maneuvers(maneuvers, settings.held_out or (), draw)
    if model is not None:
        check_model_match(model, maneuvers)
    try:
        found = Investigation(maneuvers, own, model).run(settings, progress=progress)
    except FlightError as error:
        causes = (text for one in flown for text in uncalibrated_text(one.flight))
        raise FlightError("; ".join(dict.fromkeys((str(error), *causes)))) from error
    remarks = (*calibration_sentences(one.flight for one in flown), *record_remarks(maneuvers, own))
    return flown, replace(found, warnings=tuple(dict.fromkeys((*found.warnings, *remarks))))


def _check_maneuvers(
    maneuvers: Sequence[Maneuver], held_out: Sequence[str], draw: Sequence[str]
) -> None:
    """Raise if one that was asked for by its id is not among them."""
    known = [one.id for one in maneuvers]
    for option, names in (("--held-out", held_out), ("--draw", draw)):
        for name in names:
            if name not in known:
                raise UnknownNameError(
                    f"{option}: there is no maneuver '{name}'; there are {', '.join(known)}"
                )
