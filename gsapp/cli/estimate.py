"""``gsapp estimate``: derivatives with bounds from the maneuvers of flights."""

from __future__ import annotations

import json as json_module
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.campaign import CampaignResult, CampaignValue
    from gsapp.identification.results import Estimate
    from gsapp.identification.runs.outcome import Outcome

_FIXED, _EACH = 44, 17
"""Characters that the means take, and each maneuver with a column of its own."""


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
    from rich.console import Console

    from gsapp.cli._aircraft_text import warn_of_aircraft
    from gsapp.cli._flight_text import calibration_list, check_catalog
    from gsapp.cli._results import on_screen, write_result
    from gsapp.cli._running import check_fitted, with_bar
    from gsapp.dynamics.model import load_model
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.campaign import CampaignSettings
    from gsapp.identification.estimate_json import campaign_json
    from gsapp.identification.maximum_likelihood import MLSettings
    from gsapp.identification.runs.inputs import openings_of
    from gsapp.identification.runs.keeping import keep
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.running import run as run_request
    from gsapp.identification.runs.shelf import FlightShelf

    console = Console(stderr=on_screen(json))
    check_catalog(catalog, calibration)
    if catalog is not None and (catalog.exists() or not catalog.parent.is_dir()):
        # What cannot be kept is told before the work; a new file is made after it.
        Catalog(catalog).close()
    known = None if model is None else load_model(model)
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
    shelf = FlightShelf()
    outcome = with_bar(
        console,
        lambda doing, step: run_request(request, flights=shelf, doing=doing, progress=step),
    )
    result = outcome.result
    opened = [shelf.open(one).opened for one in openings_of(outcome.request)]
    for number, one in enumerate(opened):
        if one.aircraft not in [before.aircraft for before in opened[:number]]:
            warn_of_aircraft(console, one.aircraft)
    kept = ""
    if catalog is not None:
        with Catalog(catalog) as store:
            kept = f"kept as run {keep(store, outcome)} in {catalog}"
    if json is not None:
        content = campaign_json(result)
        content["calibration"] = calibration_list(one.flight for one in opened)
        text = json_module.dumps(content, indent=1, allow_nan=False)
        write_result(json, text + "\n")
    _describe(console, outcome)
    check_fitted(result)
    if json is not None and not on_screen(json):
        console.print(f"written to {json}", highlight=False, soft_wrap=True)
    if kept:
        console.print(kept, highlight=False, markup=False, soft_wrap=True)


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
    import difflib

    from gsapp.dynamics.buildup import derivative_names
    from gsapp.foundation import UnknownNameError

    known = list(derivative_names())
    for name in names:
        if name in known or (model is not None and "." in name):
            continue
        near = difflib.get_close_matches(name, known, n=2)
        hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known)}"
        raise UnknownNameError(f"there is no derivative '{name}'; {hint}")


# --- the screen ---------------------------------------------------------------------------------


def _describe(console: Console, outcome: Outcome) -> None:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    result = outcome.result
    results = result.results
    wide = _FIXED + _EACH * len(results) <= console.width
    table = Table(
        title=f"{result.settings.method.upper()}: {len(results)} "
        f"maneuver{'' if len(results) == 1 else 's'}, per radian",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    table.add_column("", no_wrap=True)
    for heading in ("mean", "std", "scatter", "n"):
        table.add_column(heading, justify="right", no_wrap=True)
    if wide:
        for one in results:
            heading = f"{one.maneuver.id} {'+'.join(one.maneuver.inputs) or 'none'}"
            table.add_column(escape(heading), justify="right", no_wrap=True)
    for name in _rows(result):
        value = result.values.get(name)
        cells = _summary(value)
        if wide:
            cells += [_cell(one.estimate, name) for one in results]
        table.add_row(name, *cells)
    console.print(table)
    fits = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("maneuver", "seconds", "inputs", "rounds"):
        fits.add_column(heading, no_wrap=True)
    fits.add_column("R2 of each response")
    several = len({one.maneuver.flight for one in results}) > 1
    for one in results:
        maneuver, estimate = one.maneuver, one.estimate
        rounds = "failed" if estimate is None else str(estimate.iterations)
        if estimate is not None and not estimate.converged:
            rounds += ", not converged"
        fits.add_row(
            escape(f"{maneuver.id} {maneuver.flight}" if several else maneuver.id),
            f"{maneuver.t_start:.2f} - {maneuver.t_end:.2f}",
            "+".join(maneuver.inputs) or "none",
            rounds,
            "  ".join(
                f"{name} {fit.r2:.3f}" for name, fit in (estimate.fit if estimate else {}).items()
            ),
        )
    console.print(fits)
    for sentence in _sentences(outcome):
        console.print(sentence, style="yellow", highlight=False, markup=False, soft_wrap=True)


def _rows(result: CampaignResult) -> list[str]:
    """Return the names of all that was to be estimated, in the order of the build-up."""
    from gsapp.dynamics.buildup import derivative_names

    names = dict.fromkeys(
        name
        for one in result.results
        if one.estimate is not None
        for name, found in one.estimate.derivatives.items()
        if found.status != "held"
    )
    order = {name: place for place, name in enumerate(derivative_names())}
    return sorted(names, key=lambda name: order.get(name, len(order)))


def _summary(value: CampaignValue | None) -> list[str]:
    if value is None:
        return ["unknown", "", "", ""]
    scatter = "" if value.scatter is None else f"{value.scatter:.4f}"
    return [f"{value.mean:.4f}", f"{value.std:.4f}", scatter, str(value.n)]


def _cell(estimate: Estimate | None, name: str) -> str:
    if estimate is None or name not in estimate.derivatives:
        return ""
    one = estimate.derivatives[name]
    if one.status == "held":
        return f"[dim]held {one.value:.4g}[/dim]" if one.value else "[dim]held[/dim]"
    if one.value is None or one.std is None:
        return f"[dim]{one.status}[/dim]"
    return f"{one.value:.3f} ±{one.std:.3f}"


def _sentences(outcome: Outcome) -> list[str]:
    """Return what is to be said, each sentence once, with the maneuvers it is about."""
    said: dict[str, list[str]] = {}
    for one in outcome.result.results:
        told = (one.failure,) if one.estimate is None else one.estimate.warnings
        why: tuple[str, ...] = ()
        if one.estimate is not None:
            why = tuple(
                f"{name}: {found.why}"
                for name, found in one.estimate.derivatives.items()
                if found.status in ("unknown", "not-identifiable") and found.why
            )
        for sentence in (*told, *why):
            said.setdefault(sentence, []).append(one.maneuver.id)
    remarks = dict.fromkeys((*outcome.remarks, *outcome.result.remarks))
    return [
        *remarks,
        *(
            f"maneuver{'s' if len(ids) > 1 else ''} {', '.join(ids)}: {sentence}"
            for sentence, ids in said.items()
        ),
    ]
