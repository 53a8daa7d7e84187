"""The instruments of flights against one another."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from gsapp.flight.catalog import Catalog, FlightEntry, add_entry, store_instrument_errors
from gsapp.flight.flight import calibration_sentences
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.executors import WorkerLostError, WorkerPool, map_tasks
from gsapp.identification.compatibility.compatibility_check import check_compatibility
from gsapp.identification.compatibility.results import CompatibilityResult
from gsapp.identification.compatibility.settings import DEFAULT_FREE_ERRORS, CompatibilitySettings
from gsapp.identification.maneuver import (
    FlightWithManeuvers,
    no_maneuvers_text,
    open_flights_with_maneuvers,
)


def settings_with_errors(errors: Sequence[str]) -> CompatibilitySettings:
    """Return settings that estimate some errors, ``q.scale``, beside the usual ones."""
    return CompatibilitySettings(free=tuple(dict.fromkeys((*DEFAULT_FREE_ERRORS, *errors))))


def check_flights(
    paths: Sequence[Path],
    settings: ManeuverSettings,
    checked: CompatibilitySettings,
    *,
    doing: Callable[[str], object] = lambda _: None,
    pool: WorkerPool | None = None,
) -> tuple[tuple[FlightWithManeuvers, ...], CompatibilityResult]:
    """Compare the instruments of flights in all their maneuvers.

    `doing`: told what is being done, in words, before each step.
    `pool`: where flights are read.

    Raises `GroundStationError` if a flight cannot be read, or none has a maneuver.
    """
    flown = open_flights_with_maneuvers(
        paths, settings.with_changes(every_grade=True), doing=doing, pool=pool, keep_samples=False
    )
    maneuvers = [one for flight in flown for one in flight.maneuvers]
    if not maneuvers:
        raise FlightError(
            f"no maneuver to check instruments by: {no_maneuvers_text(flown)}; name a window of "
            "the flight with --maneuver START:STOP"
        )
    doing("comparing instruments")
    return flown, check_compatibility(maneuvers, settings=checked)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightCheck:
    """The instruments of one flight."""

    entry: FlightEntry  # What a catalog keeps of the flight.
    result: CompatibilityResult  # Without histories.
    calibration: Mapping[str, Any]  # As `calibration_json` gives it.
    sentences: tuple[str, ...]  # On its calibration.


def check_each_flight(
    paths: Sequence[Path],
    settings: ManeuverSettings,
    checked: CompatibilitySettings,
    *,
    doing: Callable[[str], object] = lambda _: None,
    pool: WorkerPool | None = None,
) -> Iterator[FlightCheck | str]:
    """Yield what comparing the instruments of each flight alone gives; in words why it fails.

    Memory does not grow with the number of flights.

    `pool`: where flights are read and compared.
    """
    work = partial(_check_one, settings.with_changes(every_grade=True), checked)

    def told() -> Iterator[Path]:
        for number, path in enumerate(paths, start=1):
            doing(f"comparing the instruments of {path.name} ({number} of {len(paths)})")
            yield path

    for found in map_tasks(pool, work, told()):
        yield str(found) if isinstance(found, WorkerLostError) else found


def _check_one(
    settings: ManeuverSettings, checked: CompatibilitySettings, path: Path
) -> FlightCheck | str:
    try:
        (flown,) = open_flights_with_maneuvers((path,), settings)
        if not flown.maneuvers:
            raise FlightError(f"no maneuver to check instruments by: {flown.no_maneuvers_text}")
        result = check_compatibility(flown.maneuvers, settings=checked)
    except GroundStationError as error:
        return str(error)
    flight = flown.flight
    return FlightCheck(
        entry=FlightEntry.from_flight(
            flight, flown.detected_maneuvers, aircraft=flown.aircraft, complete=False
        ),
        result=replace(result, histories=(), reconstructed=()),
        calibration=flight.calibration_json(),
        sentences=calibration_sentences([flight]),
    )


def store_check(catalog: Catalog, found: FlightCheck) -> None:
    """Store a flight with the errors of its instruments, in place of those stored before."""
    with catalog.transaction():
        add_entry(catalog, found.entry)
        store_instrument_errors(
            catalog,
            found.entry.name,
            {
                name: (one.value, one.std, one.status if found.result.converged else "unknown")
                for name, one in found.result.parameters.items()
            },
        )


def compatibility_json(result: CompatibilityResult) -> dict[str, Any]:
    """Return a result for programs: SI units; absent, and what is not finite, None."""
    content = {
        "maneuvers": result.maneuvers,
        "consistent": result.consistent,
        "summary": result.summary,
        "parameters": {name: asdict(one) for name, one in result.parameters.items()},
        "signs": result.signs,
        "verdicts": [{**asdict(one), "seen_in": one.seen_in or None} for one in result.verdicts],
        "comparisons": [asdict(one) for one in result.comparisons],
        "fit": {
            name: {key: getattr(one, key) for key in ("rms", "rms_over_range_pct", "r2", "theil")}
            for name, one in result.fit.items()
        },
        "noise": result.noise,
        "gust": result.gust,
        "remedies": result.remedies,
        "converged": result.converged,
        "warnings": result.warnings,
    }
    return {name: _finite(value) for name, value in content.items()}


def _finite(value: Any) -> Any:
    """Return a value for JSON: null for what is not finite."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return [_finite(one) for one in value] if isinstance(value, (list, tuple)) else value
