"""The maneuvers of a run: those that stand in its flights, or exactly those that were named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gsapp.flight.maneuvers import (
    DetectedManeuver,
    FlightManeuvers,
    ManeuverAssessor,
    parse_maneuver_windows,
)
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maneuver_extraction import OpenedFlight, cut_flight_maneuvers
from gsapp.identification.runs.flight_cache import FlightCache
from gsapp.identification.runs.inputs import flight_open_requests
from gsapp.identification.runs.request import RunRequest, SelectedManeuver

StatusCallback = Callable[[str], object]
"""Told what is being done, in words."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSelection:
    """The maneuvers of one flight of a run."""

    cut: tuple[Maneuver, ...]  # To be used.
    detected: tuple[DetectedManeuver, ...]  # The same, as they stand in the flight.
    stored: tuple[DetectedManeuver, ...]
    """What a catalog is told of: all of the flight, or those that were named."""
    remarks: tuple[str, ...]
    no_maneuvers_text: str = ""  # Why none was cut; empty where one was.


def select_maneuvers(
    request: RunRequest, flights: FlightCache, *, doing: StatusCallback | None = None
) -> tuple[FlightSelection, ...]:
    """Return the maneuvers of a run, flight by flight.

    `request`: with whole paths.

    Raises
    ------
    GroundStationError
        If a flight cannot be read, a window cannot, or a maneuver is not where it should be.
    """
    if request.maneuvers:
        return _requested_maneuvers(request, flights, doing)
    return _all_flight_maneuvers(request, flights, doing)


def selected_maneuvers(
    request: RunRequest, flown: Sequence[FlightSelection]
) -> tuple[SelectedManeuver, ...]:
    """Return the maneuvers of a run by name, with their edges."""
    if request.maneuvers:
        return request.maneuvers
    return tuple(
        SelectedManeuver(
            flight=path,
            id=one.id,
            t_start=one.t_start,
            t_end=one.t_end,
            inputs=one.inputs,
            kind=one.kind,
            found=one,
        )
        for path, own in zip(request.flights, flown, strict=True)
        for one in own.detected
    )


def _all_flight_maneuvers(
    request: RunRequest,
    shelf: FlightCache,
    doing: StatusCallback | None,
) -> tuple[FlightSelection, ...]:
    """Return all maneuvers that stand in the flights, or those of the windows given."""
    windows = parse_maneuver_windows(request.maneuver_windows, len(request.flights))
    flown = []
    for number, opening in enumerate(flight_open_requests(request), start=1):
        named = tuple(
            f"{window.start!r}:{window.stop!r}" for window in windows if window.flight == number
        )
        surveyed = shelf.detected_maneuvers(
            opening, windows=named, as_found=request.as_found, doing=doing
        )
        every = request.every_grade or bool(named)
        prefix = _prefix(request, number)
        opened = shelf.open(opening).opened
        own = cut_flight_maneuvers(opened, surveyed, prefix=prefix, every_grade=every)
        ids = {one.id.removeprefix(prefix) for one in own.maneuvers}
        flown.append(
            FlightSelection(
                detected=tuple(found for found in surveyed.maneuvers if found.id in ids),
                cut=own.maneuvers,
                stored=surveyed.maneuvers,
                remarks=own.remarks,
                no_maneuvers_text=own.no_maneuvers_text,
            )
        )
    return tuple(flown)


def _requested_maneuvers(
    request: RunRequest,
    shelf: FlightCache,
    doing: StatusCallback | None,
) -> tuple[FlightSelection, ...]:
    """Return the maneuvers that were named, with exactly their edges."""
    strange = {one.flight for one in request.maneuvers} - set(request.flights)
    if strange:
        raise FlightError(
            f"the maneuvers of {', '.join(sorted(map(str, strange)))} cannot be used: it is not "
            "among the flights of this run; add it"
        )
    flown = []
    for number, opening in enumerate(flight_open_requests(request), start=1):
        opened = shelf.open(opening, doing=doing).opened
        named = [own for own in request.maneuvers if own.flight == request.flights[number - 1]]
        cut = tuple(
            opened.cut(
                _prefix(request, number) + own.id, own.t_start, own.t_end, own.inputs, own.kind
            )
            for own in named
        )
        found = tuple(
            own.found
            for own in named
            if own.found is not None and _is_same_maneuver(own.found, own)
        )
        if len(found) < len(named):
            surveyed = shelf.detected_maneuvers(opening, latest=False, doing=doing)
            found = tuple(_detected_maneuver(own, surveyed, opened) for own in named)
        flown.append(FlightSelection(detected=found, cut=cut, stored=found, remarks=opened.remarks))
    return tuple(flown)


def _detected_maneuver(
    own: SelectedManeuver, surveyed: FlightManeuvers, opened: OpenedFlight
) -> DetectedManeuver:
    """Return all that is known of a maneuver that was named."""
    for one in (own.found, *surveyed.maneuvers):
        if one is not None and _is_same_maneuver(one, own):
            return one
    assessor = ManeuverAssessor(opened.flight, opened.aircraft, surveyed.noise)
    seen = assessor.assess(own.id, own.t_start, own.t_end)
    return replace(seen, inputs=own.inputs or seen.inputs, kind=own.kind or seen.kind)


def _is_same_maneuver(found: DetectedManeuver, own: SelectedManeuver) -> bool:
    return (found.id, found.t_start, found.t_end) == (own.id, own.t_start, own.t_end)


def in_requested_order(request: RunRequest, flown: Sequence[FlightSelection]) -> list[Maneuver]:
    """Return the maneuvers that were cut, in the order asked for."""
    cut = [one for own in flown for one in own.cut]
    if not request.maneuvers:
        return cut
    by_id = {one.id: one for one in cut}
    numbers = {path: number for number, path in enumerate(request.flights, start=1)}
    return [by_id[_prefix(request, numbers[one.flight]) + one.id] for one in request.maneuvers]


def _prefix(request: RunRequest, number: int) -> str:
    return f"{number}:" if len(request.flights) > 1 else ""
