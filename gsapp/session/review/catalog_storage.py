"""What the review shares with the catalog of the campaign: maneuvers in, verdicts out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gsapp.flight.catalog import Catalog, StoredVerdict, search_verdicts, store_maneuvers
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers import DetectedManeuver


def save_maneuvers_to_catalog(
    catalog: Path, flight: Flight, maneuvers: Sequence[DetectedManeuver], aircraft: str
) -> None:
    """Write the maneuvers of a flight as they stand into a catalog, all or none.

    Parameters
    ----------
    catalog : Path
        Made if it is not there.
    maneuvers : sequence of DetectedManeuver
        In place of those that the catalog had of this flight.

    Raises
    ------
    FlightError
        If the catalog cannot be written.
    """
    catalog.parent.mkdir(parents=True, exist_ok=True)
    with Catalog(catalog) as opened:
        store_maneuvers(opened, flight, maneuvers, aircraft=aircraft)


def load_catalog_verdicts(catalog: Path | None, flight: str) -> tuple[StoredVerdict, ...]:
    """Return what the pilot was told in a flight, by time; nothing where it was not kept.

    Raises
    ------
    FlightError
        If the catalog cannot be read.
    """
    if catalog is None or not catalog.is_file():
        return ()
    with Catalog(catalog) as opened:
        return search_verdicts(opened, flight=flight)
