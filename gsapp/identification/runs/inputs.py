"""What a run is made from: its flights opened, its files with their sums."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from calibration import certificate_files
from gsapp.aircraft.reading import SHIPPED as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED as MAPS
from gsapp.dynamics.model import SHIPPED as MODELS
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import current_versions
from gsapp.flight.provenance import InputFile, input_file
from gsapp.flight.setting import USUAL_AIRCRAFT
from gsapp.foundation import FlightError
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.shelf import Opening, Shelved
from gsapp.identification.weights import SHIPPED as WEIGHTS
from gsapp.identification.weights import Weights, load_weights


def openings_of(request: RunRequest) -> tuple[Opening, ...]:
    """Return what the flights of a run are opened with, in their order."""
    return tuple(
        Opening(
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


def with_whole_paths(request: RunRequest) -> RunRequest:
    """Return a request that means the same wherever the program is started.

    Raises
    ------
    FlightError
        If it names no flight.
    """
    if not request.flights:
        raise FlightError("there is no flight to estimate from; name one")
    return replace(
        request,
        flights=tuple(path.absolute() for path in request.flights),
        maneuvers=tuple(replace(one, flight=one.flight.absolute()) for one in request.maneuvers),
        aircraft=_whole(request.aircraft),
        channel_map=_whole(request.channel_map),
        calibration=_whole(request.calibration),
        weights=_whole(request.weights),
        model=_whole(request.model),
    )


def _whole(name: str) -> str:
    """Return the whole path of what is a file or folder, else the name as it is."""
    return str(Path(name).absolute()) if name and Path(name).exists() else name


def weights_file(request: RunRequest) -> Weights | None:
    """Return the weights file of a run; None where its settings hold weights, or there is none."""
    if request.settings.weights is not None or not request.weights:
        return None
    return load_weights(request.weights)


def inputs_of(request: RunRequest, shelved: Sequence[Shelved]) -> tuple[InputFile, ...]:
    """Return the files of a run with their sums when they were read.

    Files of a model or of weights are among them only if the settings did not hold these already.

    Parameters
    ----------
    request : RunRequest
        As it was asked, with whole paths.
    shelved : sequence of Shelved
        Its flights.

    Raises
    ------
    FlightError
        If one cannot be read.
    """
    aircraft = request.aircraft
    if not aircraft and not all(_has_aircraft(path) for path in request.flights):
        aircraft = USUAL_AIRCRAFT
    held = request.settings
    named = (
        ("aircraft", aircraft, AIRCRAFT_FILES),
        ("model", request.model if held.model is None else "", MODELS),
        ("weights", request.weights if held.weights is None else "", WEIGHTS),
        ("channel map", request.channel_map, MAPS),
    )
    certificates = certificate_files(request.calibration) if request.calibration else ()
    try:
        return (
            *(one.file for one in shelved),
            *(
                input_file(role, shipped.find(name), name=name)
                for role, name, shipped in named
                if name
            ),
            *(input_file("certificate", path) for path in certificates),
        )
    except OSError as error:
        raise FlightError(f"a file of the run cannot be read ({error}); check it") from error


def _has_aircraft(path: Path) -> bool:
    return path.is_dir() and FlightFolder(path=path).aircraft_file.is_file()
