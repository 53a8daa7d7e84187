"""``gsapp estimate``: derivatives with bounds from the maneuvers of flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any


def run(
    *,
    flights: Sequence[Path],
    catalog: Path | None = None,
    json: Path | None = None,
    **settings: Any,
) -> None:
    """Estimate derivatives.

    Parameters
    ----------
    flights : sequence of Path
    catalog : Path, optional
        Where the run is stored.
    json : Path, optional
        Where the result for programs goes.
    **settings
        Fields of `gsapp.identification.estimate_settings.EstimateSettings`.

    Raises
    ------
    GroundStationError
        If a file or name is wrong, or no maneuver gives anything.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._estimate_text import print_outcome
    from gsapp.cli._flight_text import check_catalog
    from gsapp.cli._json_output import format_json, is_stdout, outcome_json, write_json
    from gsapp.cli._progress_bar import check_fitted, run_with_progress_bar
    from gsapp.cli._usage_errors import as_usage_error, check_windows
    from gsapp.dynamics.model import load_model
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_execution import execute_run
    from gsapp.identification.runs.run_store import save_run
    from gsapp.quantities import channel

    console = PlainConsole(stderr=is_stdout(json))
    with as_usage_error():
        request = RunRequest(flights=tuple(flights), **settings)
        for name in request.stand_ins:
            channel(name)
    check_catalog(catalog, request.calibration or None)
    if catalog is not None and (catalog.exists() or not catalog.parent.is_dir()):
        # What cannot be kept is told before the work; a new file is made after it.
        Catalog(catalog).close()
    check_windows(request.maneuver_windows, flights)
    known = load_model(request.model) if request.model else None
    with as_usage_error():
        names = (*request.held, *(request.free or ()), *request.priors, *request.start)
        _check_derivatives(names, known)
    shelf = FlightCache()
    outcome = run_with_progress_bar(
        console,
        lambda doing, step: execute_run(request, flights=shelf, doing=doing, progress=step),
    )
    kept = ""
    if catalog is not None:
        with Catalog(catalog) as store:
            kept = f"kept as run {save_run(store, outcome)} in {catalog}"
    if json is not None:
        write_json(json, format_json(outcome_json(outcome, shelf)))
    print_outcome(console, outcome)
    check_fitted(outcome)
    if json is not None and not is_stdout(json):
        console.print(f"written to {json}", highlight=False, soft_wrap=True)
    if kept:
        console.print(kept, highlight=False, soft_wrap=True)


def _check_derivatives(names: Sequence[str], model: object) -> None:
    """Raise unless every name is a derivative, or the parameter of an effect of the model."""
    from gsapp.dynamics.buildup import derivative_names
    from gsapp.foundation import UnknownNameError
    from gsapp.foundation.name_suggestions import did_you_mean

    known = list(derivative_names())
    for name in names:
        if name in known or (model is not None and "." in name):
            continue
        hint = did_you_mean(name, known, f"known are {', '.join(known)}", most=2)
        raise UnknownNameError(f"there is no derivative '{name}'; {hint}")
