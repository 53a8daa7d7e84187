"""``gsapp estimate``: derivatives with bounds from the maneuvers of flights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import ESTIMATE_SETTINGS, takes_settings
from gsapp.cli._options import CatalogFile, FlightPaths, JsonFile, Units

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from gsapp.cli._console import PlainConsole
    from gsapp.identification.campaign import CampaignResult, CampaignValue, ManeuverResult
    from gsapp.identification.results import Estimate
    from gsapp.identification.runs.run_execution import RunOutcome

_FIXED, _EACH = 52, 22
"""Characters that the means take, and each column of a maneuver's own."""
_BY_EQUATIONS = "equation error"
"""Heads what stands beside maximum likelihood in gusts."""


@takes_settings(ESTIMATE_SETTINGS)
def estimate(
    flights: FlightPaths,
    euler: Annotated[bool, typer.Option("--euler", hidden=True)] = False,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Estimate stability and control derivatives, with bounds.

    The bounds are honest: they count that residuals are colored.

    Example: gsapp estimate flights/a flights/b --aircraft b777 --json derivatives.json

    Example: gsapp estimate flights/a --method ml --axis lon --weights table-6.2.7 --hold CN_q=5

    Example: gsapp estimate flights/a --catalog campaign.sqlite --label "weights of the source"

    Example: gsapp estimate doublet.csv --maneuver 2:12 --free Cm_alpha,Cm_q,Cm_de --model b777
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import check_fitted, outcome_json
    from gsapp.cli._usage_errors import as_usage_error, check_catalog, check_windows
    from gsapp.dynamics.model import load_model
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_execution import execute_run
    from gsapp.identification.runs.run_store import save_run
    from gsapp.quantities import channel

    console = PlainConsole(stderr=is_stdout(json))
    if euler:
        settings["integration"] = "euler"
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
    outcome = console.run_with_progress_bar(
        lambda doing, step: execute_run(request, flights=shelf, doing=doing, progress=step)
    )
    kept = ""
    if catalog is not None:
        with Catalog(catalog) as store:
            kept = f"kept as run {save_run(store, outcome)} in {catalog}"
    if json is not None:
        write_json(json, outcome_json(outcome, shelf))
    print_outcome(console, outcome)
    check_fitted(outcome)
    if json is not None and not is_stdout(json):
        console.print(f"written to {json}", soft_wrap=True)
    if kept:
        console.print(kept, soft_wrap=True)


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


def print_outcome(console: PlainConsole, outcome: RunOutcome) -> None:
    """Print the derivatives, how well each maneuver was fitted, and what is to be said."""
    from gsapp.cli._console import MEAN_LEGEND

    results = outcome.result.results
    console.print_unwrapped(_values(console, outcome.result))
    console.print_sentence(MEAN_LEGEND, "dim")
    console.print_unwrapped(_fits(console, results))
    for sentence in _sentences(outcome):
        console.print_sentence(sentence, "yellow")


def _values(console: PlainConsole, result: CampaignResult) -> Table:
    """Return means, and what each maneuver gave where a line has room for it."""
    from gsapp.cli._console import MEAN_HEADINGS, mean_cells
    from gsapp.identification.campaign import campaign_values

    results = result.results
    gusty = [one for one in results if one.equation_error_estimate is not None]
    columns = len(results) + len(gusty) + bool(gusty)
    wide = _FIXED + _EACH * columns <= console.width
    table = console.create_table(
        title=f"{result.settings.method.upper()}: {len(results)} "
        f"maneuver{'' if len(results) == 1 else 's'}, per radian"
    )
    table.add_column("", no_wrap=True)
    headings = [*MEAN_HEADINGS]
    if gusty:
        headings.append(f"{_BY_EQUATIONS}, n")
    for one in results if wide else ():
        headings.append(f"{one.maneuver.id} {'+'.join(one.maneuver.inputs) or 'none'}")
        if one in gusty:
            headings.append(_BY_EQUATIONS)
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    by_equations = campaign_values([one.equation_error_estimate for one in gusty])
    for name in _rows(result):
        cells: list[str | Text] = [*mean_cells(result.values.get(name))]
        if gusty:
            cells.append(_mean(by_equations.get(name)))
        for one in results if wide else ():
            cells.append(_cell(one.estimate, name))
            if one in gusty:
                cells.append(_cell(one.equation_error_estimate, name))
        table.add_row(name, *cells)
    return table


def _fits(console: PlainConsole, results: Sequence[ManeuverResult]) -> Table:
    fits = console.create_table()
    for heading in ("maneuver", "seconds", "inputs", "rounds"):
        fits.add_column(heading, no_wrap=True)
    fits.add_column("R2 of each response", overflow="fold")
    several = len({one.maneuver.flight for one in results}) > 1
    for one in results:
        maneuver, estimate = one.maneuver, one.estimate
        rounds = "failed" if estimate is None else str(estimate.iterations)
        if estimate is not None and not estimate.converged:
            rounds += ", not converged"
        fits.add_row(
            f"{maneuver.id} {maneuver.flight}" if several else maneuver.id,
            f"{maneuver.t_start:z.2f} - {maneuver.t_end:z.2f}",
            "+".join(maneuver.inputs) or "none",
            rounds,
            "  ".join(
                f"{name} {fit.r2:z.3f}" for name, fit in (estimate.fit if estimate else {}).items()
            ),
        )
    return fits


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


def _mean(value: CampaignValue | None) -> str:
    from gsapp.cli._console import format_value_and_bound

    return (
        ""
        if value is None
        else f"{' ±'.join(format_value_and_bound(value.mean, value.std))} {value.n:3d}"
    )


def _cell(estimate: Estimate | None, name: str) -> str | Text:
    from rich.text import Text

    from gsapp.cli._console import format_value_and_bound

    if estimate is None or name not in estimate.derivatives:
        return ""
    one = estimate.derivatives[name]
    if one.status == "held":
        return Text(f"held {one.value:z.4g}" if one.value else "held", "dim")
    if one.value is None or one.std is None:
        return Text(one.status, "dim")
    return " ±".join(format_value_and_bound(one.value, one.std, least=3))


def _sentences(outcome: RunOutcome) -> list[str]:
    """Return what is to be said, each sentence once, with the maneuvers it is about."""
    said: dict[str, list[str]] = {}
    for one in outcome.result.results:
        told = (one.failure,) if one.estimate is None else one.estimate.warnings
        if one.equation_error_estimate is not None:
            told = (
                *told,
                *_method_difference_text(one),
                *(f"{_BY_EQUATIONS}: {text}" for text in one.equation_error_estimate.warnings),
            )
        why = () if one.estimate is None else _unknown_reasons(one.estimate)
        # The maneuvers are named once, in front.
        own = f"maneuver {one.maneuver.id}: "
        for sentence in (*told, *why):
            said.setdefault(sentence.removeprefix(own), []).append(one.maneuver.id)
    remarks = dict.fromkeys((*outcome.remarks, *outcome.result.remarks))
    return [
        *remarks,
        *(
            f"maneuver{'s' if len(ids) > 1 else ''} {', '.join(ids)}: {sentence}"
            for sentence, ids in said.items()
        ),
    ]


def _unknown_reasons(estimate: Estimate) -> tuple[str, ...]:
    """Return each reason for which derivatives were not earned, once, with their names."""
    reasons: dict[str, list[str]] = {}
    for name, found in estimate.derivatives.items():
        if found.status in ("unknown", "not-identifiable") and found.why:
            reasons.setdefault(found.why, []).append(name)
    every = sum(len(names) for names in reasons.values())
    return tuple(
        f"{'no derivative' if len(names) == every > 1 and not estimate.free else ', '.join(names)}"
        f": {why}"
        for why, names in reasons.items()
        # Said already.
        if why not in estimate.warnings
    )


def _method_difference_text(one: ManeuverResult) -> tuple[str, ...]:
    """Return in a sentence where equation error lies apart from maximum likelihood."""
    from gsapp.identification.summary.method_comparison import compare_methods
    from gsapp.identification.summary.settings import SUMMARY

    names = [value.name for value in compare_methods(one) if value.differs]
    if not names:
        return (
            f"{_BY_EQUATIONS} agrees within {SUMMARY.significant_sigmas:z.0f} joint bounds in "
            "every derivative",
        )
    return (
        f"{_BY_EQUATIONS} lies more than {SUMMARY.significant_sigmas:z.0f} joint bounds off in "
        f"{', '.join(names)}; use the smaller bound",
    )
