"""The flights under review together: numbered, with all their maneuvers in one table."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.flight.catalog import StoredVerdict
from gsapp.flight.maneuvers import DetectedManeuver
from gsapp.session.review.reviewed_flight import ReviewedFlight

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.identification.runs.request import SelectedManeuver


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverRow:
    """One maneuver of a campaign, for tables."""

    id: str
    """In the campaign: ``2:M4``; with one flight ``M4``."""
    flight: str
    """Name of the flight, as `Review.title` gives it."""
    flight_number: int
    maneuver: DetectedManeuver
    in_use: bool
    is_edited: bool
    """Whether a person changed it or put it in."""
    verdict: StoredVerdict | None
    overlaps: tuple[str, ...]
    """Ids within the flight of others that share samples with it."""


class Review:
    """The flights under review, in the order in which they are numbered."""

    def __init__(self) -> None:
        self.flights: tuple[ReviewedFlight, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        return tuple(flight.path for flight in self.flights)

    def add(self, flight: ReviewedFlight) -> None:
        """Put a flight at the end, or in the place of the same one that was opened before."""
        paths = [path.resolve() for path in self.paths]
        path = flight.path.resolve()
        if path in paths:
            index = paths.index(path)
            self.flights = (*self.flights[:index], flight, *self.flights[index + 1 :])
        else:
            self.flights = (*self.flights, flight)

    def remove(self, flight: ReviewedFlight) -> None:
        """Take a flight out of the review; its files stay as they are."""
        self.flights = tuple(one for one in self.flights if one is not flight)

    def title(self, flight: ReviewedFlight) -> str:
        """Return the name of a flight; of several with that name, with the folder that parts them.

        A copy on another disk is called as the flight is.
        """
        alike = [one.path.resolve() for one in self.flights if one.name == flight.name]
        if len(alike) < 2:
            return flight.name
        own, count = flight.path.resolve(), 1
        # No two flights under review have the same path.
        while sum(path.parts[-count:] == own.parts[-count:] for path in alike) > 1:
            count += 1
        return f"{flight.name} ({'/'.join(own.parts[-count:])})"

    def campaign_id(self, flight: ReviewedFlight, name: str) -> str:
        """Return the id in the campaign of a flight's maneuver."""
        if len(self.flights) < 2:
            return name
        return f"{self.flights.index(flight) + 1}:{name}"

    def find_maneuver(self, campaign_id: str) -> tuple[ReviewedFlight, DetectedManeuver] | None:
        """Return flight and maneuver of an id in the campaign; None if there is none."""
        for flight in self.flights:
            for maneuver in flight.maneuvers:
                if self.campaign_id(flight, maneuver.id) == campaign_id:
                    return flight, maneuver
        return None

    def rows(self) -> tuple[ManeuverRow, ...]:
        """Return all maneuvers, by flight and time."""
        return tuple(
            ManeuverRow(
                id=self.campaign_id(flight, maneuver.id),
                flight=self.title(flight),
                flight_number=number,
                maneuver=maneuver,
                in_use=flight.in_use(maneuver),
                is_edited=flight.is_edited(maneuver.id),
                verdict=flight.verdict(maneuver),
                overlaps=flight.overlapping(maneuver),
            )
            for number, flight in enumerate(self.flights, start=1)
            for maneuver in flight.maneuvers
        )

    def select_maneuvers(self, ids: Collection[str] | None = None) -> tuple[SelectedManeuver, ...]:
        """Return maneuvers for a run, with their edges as they stand.

        Parameters
        ----------
        ids : collection of str, optional
            In the campaign; by default those in use.
        """
        from gsapp.identification.runs.request import SelectedManeuver

        return tuple(
            SelectedManeuver(
                flight=flight.path,
                id=maneuver.id,
                t_start=maneuver.t_start,
                t_end=maneuver.t_end,
                inputs=maneuver.inputs,
                kind=maneuver.kind,
                found=maneuver,
            )
            for flight in self.flights
            for maneuver in flight.maneuvers
            if (
                flight.in_use(maneuver)
                if ids is None
                else self.campaign_id(flight, maneuver.id) in ids
            )
        )

    def poll(self) -> tuple[ReviewedFlight, ...]:
        """Take in what other windows changed; return the flights that it may have changed."""
        return tuple(flight for flight in self.flights if flight.poll())
