"""What a run is made from: its flights opened, its files with their sums."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from calibration import certificate_paths
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.dynamics.model import SHIPPED_MODELS as MODELS
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import InputFile, hash_input_file
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT
from gsapp.foundation import FlightError
from gsapp.identification.runs.flight_cache import CachedFlight, FlightOpenRequest
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.weights import SHIPPED_WEIGHTS as WEIGHTS
from gsapp.identification.weights import Weights, load_weights


def flight_open_requests(request: RunRequest) -> tuple[FlightOpenRequest, ...]:
    """Return what the flights of a run are opened with, in their order."""
    return tuple(
        FlightOpenRequest(
            path=path,
            aircraft=request.aircraft,
            channel_map=request.channel_map,
            calibration=request.calibration,
        )
        for path in request.flights
    )


def run_versions() -> dict[str, str]:
    """Return the versions of what the last bit of a number depends on."""
    return {**current_versions(), "machine": f"{platform.system()} {platform.machine()}"}


def with_absolute_paths(request: RunRequest) -> RunRequest:
    """Return a request that means the same wherever the program is started.

    Raises
    ------
    FlightError
        If it names no flight.
    """
    if not request.flights:
        raise FlightError("no flight to estimate from; name one")
    return request.with_changes(
        flights=tuple(path.absolute() for path in request.flights),
        maneuvers=tuple(replace(one, flight=one.flight.absolute()) for one in request.maneuvers),
        aircraft=_absolute_path(request.aircraft),
        channel_map=_absolute_path(request.channel_map),
        calibration=_absolute_path(request.calibration),
        weights=_absolute_path(request.weights),
        model=_absolute_path(request.model),
    )


def _absolute_path(name: str) -> str:
    """Return the whole path of what is a file or folder, else the name as it is."""
    return str(Path(name).absolute()) if name and Path(name).exists() else name


def weights_file(request: RunRequest) -> Weights | None:
    """Return the weights file of a run; None where its settings hold weights, or there is none."""
    if request.response_weights is not None or not request.weights:
        return None
    return load_weights(request.weights)


def input_files(request: RunRequest, shelved: Sequence[CachedFlight]) -> tuple[InputFile, ...]:
    """Return the files of a run with their sums when they were read.

    Files of a model or of weights are among them only if the settings did not hold these already.

    `request`: as it was asked, with whole paths.
    `shelved`: its flights.

    Raises
    ------
    FlightError
        If one cannot be read.
    """
    aircraft = request.aircraft
    if not aircraft and not all(_has_aircraft(path) for path in request.flights):
        aircraft = DEFAULT_AIRCRAFT
    named = (
        ("aircraft", aircraft, AIRCRAFT_FILES),
        ("model", request.model if request.known_model is None else "", MODELS),
        ("weights", request.weights if request.response_weights is None else "", WEIGHTS),
        ("channel map", request.channel_map, MAPS),
    )
    certificates = certificate_paths(request.calibration) if request.calibration else ()
    try:
        return (
            *(one.file for one in shelved),
            *(
                hash_input_file(role, shipped.find(name), name=name)
                for role, name, shipped in named
                if name
            ),
            *(hash_input_file("certificate", path) for path in certificates),
        )
    except OSError as error:
        raise FlightError(f"a file of the run cannot be read ({error}); check it") from error


def _has_aircraft(path: Path) -> bool:
    return path.is_dir() and FlightFolder(path=path).aircraft_file.is_file()
