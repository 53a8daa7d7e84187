"""A run: from flights with their maneuvers to an outcome."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import IO, Any, Final

from gsapp.aircraft import SHIPPED_AIRCRAFT, write_sensor_values
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import load_model
from gsapp.flight.catalog import FlightEntry
from gsapp.flight.folder import FlightFolder
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.executors import WorkerPool
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.temporary_arrays import open_temporary_file
from gsapp.identification.accelerometer_position import find_lateral_offset
from gsapp.identification.campaign import CampaignProgressCallback, CampaignResult, run_campaign
from gsapp.identification.compatibility import (
    InstrumentError,
    correct_instruments,
    find_instrument_errors,
)
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.maneuver import Maneuver, StatusCallback, map_flights
from gsapp.identification.runs.inputs import (
    FlightCache,
    FlightSelection,
    check_requested_maneuvers,
    in_requested_order,
    input_files,
    run_versions,
    select_flight_maneuvers,
    selected_maneuvers,
    weights_file,
    with_absolute_paths,
)
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.summary import CampaignSummary, summarize_campaign
from gsapp.identification.summary.campaign_linear_models import (
    NO_LINEAR_MODEL_PREFIX,
    build_linear_models,
)
from gsapp.quantities.stored_block import StoredBlock

SAME_SAMPLES_TEXT: Final = "the same samples are in"
"""Begins a remark on flights that are one and the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunOutcome:
    """One estimation, done."""

    request: RunRequest  # With the maneuvers that were used.
    aircraft: str  # Name of the one that flew.
    result: CampaignResult
    """Maneuver ids begin with the flight's number where there are several, ``2:M4``."""
    summary: CampaignSummary
    models: Mapping[LinearAxis, LinearModel] = field(default_factory=dict)
    """Linear models with the means, by axis; may be empty."""
    remarks: tuple[str, ...] = ()
    """What is suspicious about the aircraft, of reading the flights, and why there is no linear
    model."""
    instruments: tuple[InstrumentError, ...] = ()
    """Those that are not as the aircraft file says, and were corrected."""
    number: int | None = None  # In the catalog; None where it was not kept.
    inputs: tuple[InputFile, ...] = ()
    """Flights and files that went in, with their sums when they were read."""
    versions: Mapping[str, str] = field(default_factory=dict)
    """Of the program and what shapes its numbers."""
    flights: tuple[FlightEntry, ...] = ()  # What a catalog keeps of the flights.
    uncalibrated: tuple[str, ...] = ()
    """Which inputs and answers of the flights were volts only, in words."""
    calibration: tuple[Mapping[str, Any], ...] = ()
    """By flight: its name and the certificates that it was read with, for programs."""

    @property
    def sensor_values(self) -> Mapping[str, Mapping[str, float]]:
        """Return what was found for the aircraft file, by sensor and key; SI."""
        found: dict[str, dict[str, float]] = {}
        for one in self.instruments:
            if one.file_entry is not None:
                key, value = one.file_entry
                found.setdefault(one.section, {})[key] = value
        return found


def execute_run(
    request: RunRequest,
    *,
    flights: FlightCache | None = None,
    doing: StatusCallback | None = None,
    progress: CampaignProgressCallback | None = None,
    pool: WorkerPool | None = None,
    keep_samples: bool = True,
) -> RunOutcome:
    """Estimate as asked.

    Parameters
    ----------
    flights : FlightCache, optional
        Flights that are open already; those of this run are open there afterwards. Without it
        one flight at a time is open.
    doing : callable, optional
        Told what is being done before the fits begin.
    progress : callable, optional
        Told of the fits; returning False stops.
    pool : WorkerPool, optional
        Where flights are read and maneuvers fitted; the numbers are the same to the last bit. In
        this process without it.
    keep_samples : bool
        Whether the outcome holds the samples of maneuvers and the histories of responses, for
        figures. Without them memory does not grow with the number of flights.

    Returns
    -------
    RunOutcome
        Its request names every maneuver and weight that was used: run again, it gives the same
        numbers to the last bit.

    Raises
    ------
    GroundStationError
        If a flight or file cannot be read, a maneuver is not where it should be, or none of the
        axis asked for is left; if a flight ended two workers of the pool.
    CanceledError
        If `progress` returned False.
    """
    request = with_absolute_paths(request)
    model = request.known_model
    if model is None and request.model:
        model = load_model(request.model)
    file = weights_file(request)
    check_requested_maneuvers(request)
    store = None if keep_samples else open_temporary_file()
    flown = tuple(_select_maneuvers(request, flights, doing, pool, store))
    if not any(own.cut for own in flown):
        why = "; ".join(
            f"{own.name}: {own.no_maneuvers_text}" for own in flown if own.no_maneuvers_text
        )
        raise FlightError(
            f"no maneuver to estimate from{': ' if why else ''}{why}; name windows with "
            "--maneuver START:STOP, or see what 'gsapp maneuvers' finds"
        )
    used = request.with_changes(
        maneuvers=selected_maneuvers(request, flown),
        known_model=model,
        response_weights=request.response_weights
        if file is None
        else {one.name: file.for_flight(one.name) for one in flown},
    )
    cut = in_requested_order(request, flown)
    errors: tuple[InstrumentError, ...] = ()
    if request.instruments == "find":
        if doing is not None:
            doing("comparing instruments")
        # First the accelerometers: kinematics know where vanes are from them only.
        errors = find_lateral_offset(cut)
        errors += find_instrument_errors(_corrected(cut, errors, store))
    result = run_campaign(
        _corrected(cut, errors, store),
        used,
        progress=progress,
        pool=pool,
        keep_histories=keep_samples,
    )
    ids = {one.maneuver.id for one in result.results}
    unknown = [name for name in request.without if name not in ids]
    if unknown:
        hint = did_you_mean(unknown[0], ids, f"there are {', '.join(sorted(ids))}")
        raise UnknownNameError(f"no maneuver '{unknown[0]}' to exclude from the means; {hint}")
    summary = summarize_campaign(result, without=request.without)
    models, why_not = build_linear_models(result, summary)
    return RunOutcome(
        request=used,
        aircraft=flown[0].aircraft,
        result=result,
        summary=summary,
        models=models,
        remarks=tuple(
            dict.fromkeys(
                (
                    *_duplicate_flight_warnings(flown),
                    *(one.text for one in errors),
                    # Of mass and inertia: moments rest on them.
                    *(doubt for own in flown for doubt in own.doubts),
                    *(remark for own in flown for remark in own.remarks),
                    *why_not,
                )
            )
        ),
        instruments=errors,
        inputs=input_files(request, flown),
        versions=run_versions(),
        uncalibrated=tuple(text for own in flown for text in own.uncalibrated),
        calibration=tuple({"flight": own.name, **own.calibration} for own in flown),
        flights=tuple(own.entry for own in flown),
    )


def _select_maneuvers(
    request: RunRequest,
    flights: FlightCache | None,
    doing: StatusCallback | None,
    pool: WorkerPool | None,
    store: IO[bytes] | None,
) -> Iterator[FlightSelection]:
    """Yield the maneuvers of each flight; with a store, their samples lie in that file."""
    cache = FlightCache(max_flights=1) if flights is None else flights
    here = partial(select_flight_maneuvers, request, flights=cache, doing=doing)
    work = here if pool is None else partial(select_flight_maneuvers, request)
    for own in map_flights(pool, work, request.flights, doing):
        yield replace(own, cut=tuple(_stored(one, store) for one in own.cut))


def _corrected(
    cut: Sequence[Maneuver], errors: Sequence[InstrumentError], store: IO[bytes] | None
) -> list[Maneuver]:
    return [_stored(correct_instruments(one, errors), store) for one in cut]


def _stored(maneuver: Maneuver, store: IO[bytes] | None) -> Maneuver:
    """Return a maneuver whose samples lie in a file."""
    if store is None or isinstance(maneuver.block, StoredBlock):
        return maneuver
    return replace(maneuver, block=StoredBlock(maneuver.block, store))


def _duplicate_flight_warnings(flown: Sequence[FlightSelection]) -> Iterator[str]:
    """Say of flights that are copies of one another that they narrow the bounds of the means."""
    places: dict[str, list[int]] = {}
    for place, one in enumerate(flown, start=1):
        places.setdefault(one.digest, []).append(place)
    for alike in places.values():
        for place, other_place in combinations(alike, 2):
            yield (
                f"{SAME_SAMPLES_TEXT} flights {place} and {other_place}: their maneuvers count "
                "twice and the bounds of the means are too small; exclude one"
            )


def check_fitted(outcome: RunOutcome) -> None:
    """Raise `FlightError` where no maneuver gave anything; what is uncalibrated comes first."""
    results = outcome.result.results
    failures = [one.failure for one in results if one.estimate is None]
    if len(failures) == len(results):
        causes = (*outcome.uncalibrated, failures[0])
        raise FlightError(f"no maneuver could be fitted: {'; '.join(causes)}")


def accept_instruments(outcome: RunOutcome) -> tuple[Path, ...]:
    """Write what a run found of vanes and accelerometers into the aircraft files that it read.

    Raises `GroundStationError` if a file came with the program, or cannot be written.
    """
    request = outcome.request
    if request.aircraft:
        files = [SHIPPED_AIRCRAFT.find(request.aircraft)]
    else:
        files = [
            FlightFolder(path=one).aircraft_file
            for one in dict.fromkeys(request.flights)
            if one.is_dir() and FlightFolder(path=one).aircraft_file.exists()
        ]
    if not files:
        raise FlightError(
            "no aircraft file to write into what was found of the instruments: name your own "
            "with --aircraft FILE"
        )
    for file in files:
        write_sensor_values(file, outcome.sensor_values)
    return tuple(files)


def exclude_maneuvers(outcome: RunOutcome, maneuvers: Collection[str]) -> RunOutcome:
    """Return an outcome with other maneuvers left out of its means; no maneuver is fitted again.

    `maneuvers`: ids as in its result; empty takes all of them in.
    """
    summary = summarize_campaign(outcome.result, without=maneuvers)
    models, why_not = build_linear_models(outcome.result, summary)
    rest = tuple(one for one in outcome.remarks if not one.startswith(NO_LINEAR_MODEL_PREFIX))
    return replace(
        outcome,
        request=outcome.request.with_changes(without=tuple(sorted(summary.excluded_maneuvers))),
        summary=summary,
        models=models,
        remarks=(*rest, *why_not),
    )
