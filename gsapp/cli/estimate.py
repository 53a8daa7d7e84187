"""``gsapp estimate``: derivatives with bounds from the maneuvers of flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal


def run(
    *,
    flights: Sequence[Path],
    aircraft: str | None = None,
    method: Literal["ml", "ee", "ftr"] = "ml",
    axis: Literal["lon", "lat", "both"] = "both",
    six_degrees: bool = False,
    weights: str | None = None,
    hold: Sequence[str] = (),
    free: str | None = None,
    prior: Sequence[str] = (),
    stand_in: Sequence[str] = (),
    states: str | None = None,
    responses: str | None = None,
    biases: str | None = None,
    scales: str | None = None,
    shifts: str | None = None,
    euler: bool = False,
    bound_factor: float | None = None,
    joint: bool = False,
    model: str | None = None,
    maneuver: Sequence[str] = (),
    every_grade: bool = False,
    as_found: bool = False,
    channel_map: str | None = None,
    calibration: str | None = None,
    catalog: Path | None = None,
    label: str = "",
    json: Path | None = None,
) -> None:
    """Estimate derivatives.

    Parameters
    ----------
    flights : sequence of Path
    aircraft, model, channel_map : str, optional
        Names or paths.
    calibration : str, optional
        Certificates in place of those kept with the flights: a folder, or a shipped set.
    method : {"ml", "ee", "ftr"}
    axis : {"lon", "lat", "both"}
    six_degrees : bool
        Fit all six degrees of freedom in every maneuver.
    weights : str, optional
        A weights file, or the name of a shipped one.
    hold : sequence of str
        Each ``NAME=VALUE``.
    free : str, optional
        Names with commas between: these alone are estimated.
    prior : sequence of str
        Each ``NAME=VALUE:STD``.
    stand_in : sequence of str
        Each ``NAME=VALUE`` in SI, for states and inputs that were not measured.
    states, responses, biases, scales, shifts : str, optional
        Channels with commas between: active states, responses, and responses whose sensor bias,
        scale factor or time shift is free.
    euler : bool
        Integrate by Euler's rule in place of Runge and Kutta's.
    bound_factor : float, optional
        In place of the correction for colored residuals.
    joint : bool
        Fit all maneuvers of an axis together, too.
    maneuver : sequence of str
        ``START:STOP`` or ``K:START:STOP``.
    every_grade : bool
        Keep maneuvers that were graded unfit.
    as_found : bool
        Leave out what was changed by hand.
    catalog : Path, optional
        Where the run is kept.
    label : str
        What it is called there.
    json : Path, optional
        Where the result for programs goes.

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
    from gsapp.identification.campaign import CampaignSettings
    from gsapp.identification.maximum_likelihood import MLSettings
    from gsapp.identification.runs.flight_cache import FlightCache
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_execution import execute_run as run_request
    from gsapp.identification.runs.run_store import save_run
    from gsapp.quantities import channel

    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    if catalog is not None and (catalog.exists() or not catalog.parent.is_dir()):
        # What cannot be kept is told before the work; a new file is made after it.
        Catalog(catalog).close()
    check_windows(maneuver, flights)
    known = None if model is None else load_model(model)
    with as_usage_error():
        likelihood = MLSettings(
            axis="lon",
            states=_names(states),
            responses=_names(responses),
            biases=_names(biases),
            scale_factors=_names(scales) or (),
            time_shifts=_names(shifts) or (),
            priors=_priors(prior),
            stand_ins=_values(stand_in, "--stand-in"),
            integration="euler" if euler else "rk4",
            bound_factor=bound_factor,
        )
        for name in likelihood.stand_ins:
            channel(name)
        held = _values(hold, "--hold")
        _check_derivatives((*held, *(_names(free) or ()), *likelihood.priors), known)
    request = RunRequest(
        flights=tuple(flights),
        settings=CampaignSettings(
            method=method,
            axis=axis,
            six_degrees=six_degrees,
            free=_names(free),
            held=held,
            likelihood=likelihood,
            joint=joint,
        ),
        aircraft=aircraft or "",
        calibration=calibration or "",
        channel_map=channel_map or "",
        label=label,
        given=tuple(maneuver),
        every_grade=every_grade,
        as_found=as_found,
        weights=weights or "",
        model=model or "",
    )
    shelf = FlightCache()
    outcome = run_with_progress_bar(
        console,
        lambda doing, step: run_request(request, flights=shelf, doing=doing, progress=step),
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


# --- what is typed ------------------------------------------------------------------------------


def _names(text: str | None) -> tuple[str, ...] | None:
    if text is None:
        return None
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _values(texts: Sequence[str], option: str) -> dict[str, float]:
    from gsapp.foundation import FlightError

    found: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise FlightError(f"{option} '{text}' cannot be read; write NAME=VALUE, as Cm_q=-20")
    return found


def _priors(texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    from gsapp.foundation import FlightError

    found: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, equals, pair = text.partition("=")
        value, colon, std = pair.partition(":")
        try:
            found[name.strip()] = (float(value), float(std))
        except ValueError:
            equals = ""
        if not equals or not colon:
            raise FlightError(
                f"--prior '{text}' cannot be read; write NAME=VALUE:STD, as Cm_q=-20:5"
            )
    return found


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
