"""The debrief of a flight in the catalog of the campaign, and what its flights show in a row."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from gsapp.excitation.debrief import Debrief, FlightTrend, compute_trends
from gsapp.flight.catalog import Catalog, list_card_scores, search_verdicts, store_debrief
from gsapp.flight.flight_loader import load_flight


def save_debrief(path: Path, debrief: Debrief, catalog: Path, aircraft: str = "") -> Path:
    """Write a debrief into a catalog, in place of that of the same flight; return the catalog.

    Parameters
    ----------
    path : Path
        Of the flight.
    debrief : Debrief
    catalog : Path
        Made if it is not there.
    aircraft : str
        Its name.

    Raises
    ------
    FlightError
        If the flight cannot be read, or the catalog cannot be written.
    """
    flight = load_flight(path)
    catalog.parent.mkdir(parents=True, exist_ok=True)
    with Catalog(catalog) as opened:
        store_debrief(
            opened, flight, debrief.to_stored_verdicts(), debrief.cards, aircraft=aircraft
        )
    return catalog


def load_trends(catalog: Path) -> tuple[FlightTrend, ...]:
    """Return what the flights of a catalog show, in order; none where there is no catalog.

    Raises
    ------
    FlightError
        If it cannot be read.
    """
    if not catalog.is_file():
        return ()
    with Catalog(catalog) as opened:
        verdicts = search_verdicts(opened)
        names = [name for name, _ in groupby(verdicts, key=lambda one: one.flight)]
        return compute_trends(verdicts, {name: list_card_scores(opened, name) for name in names})
