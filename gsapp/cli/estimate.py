"""``gsapp estimate``: derivatives with bounds from the maneuvers of flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import ESTIMATE_SETTINGS, takes_settings
from gsapp.cli._options import CatalogFile, FlightPaths, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from gsapp.cli._console import PlainConsole
    from gsapp.identification.campaign import CampaignResult, ManeuverResult
    from gsapp.identification.results import Estimate
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary import DerivativeSummary

_FIXED, _EACH, _METHOD = 71, 22, 15
"""Characters that the means take, each column of a maneuver's own, and each other method."""


@takes_settings(ESTIMATE_SETTINGS)
def estimate(
    flights: FlightPaths,
    euler: Annotated[bool, typer.Option("--euler", hidden=True)] = False,
    update_aircraft: Annotated[
        bool,
        typer.Option(
            "--update-aircraft",
            help="Write what was found of the vanes into the aircraft file",
        ),
    ] = False,
    form: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORM",
            help="Also print the derivatives as CL-CD, CX-CZ, dimensional, dimensional-vane (flow "
            "angles at the vanes) or state-space (A, B, modes); repeatable",
        ),
    ] = None,
    on: On = None,
    dataset: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FOLDER",
            help="Also write derivatives and samples of the maneuvers as Parquet, by flight",
        ),
    ] = None,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Estimate stability and control derivatives, with bounds.

    The bounds are honest: they count that residuals are colored.

    Example: gsapp estimate flights/a flights/b --aircraft b777 --json derivatives.json

    Example: gsapp estimate flights/a --method ml --axis lon --weights table-6.2.7 --hold CN_q=5

    Example: gsapp estimate flights/a --form dimensional-vane --form state-space

    Example: gsapp estimate flights/a --catalog campaign.sqlite --label "weights of the source"

    Example: gsapp estimate flights/* --on local --json derivatives.json

    Example: gsapp estimate flights/* --dataset campaign

    Example: gsapp estimate doublet.csv --maneuver 2:12 --free Cm_alpha,Cm_q,Cm_de --model b777
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error, check_catalog, check_windows
    from gsapp.dynamics.model import load_model
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.request import RunRequest, check_names
    from gsapp.identification.runs.run_execution import check_fitted, execute_run
    from gsapp.identification.runs.run_store import save_run
    from gsapp.report.campaign_dataset import check_dataset_folder, write_campaign_dataset
    from gsapp.report.estimate_export import outcome_json

    _check_forms(form or ())
    console = PlainConsole(stderr=is_stdout(json))
    if euler:
        settings["integration"] = "euler"
    with as_usage_error():
        request = RunRequest(flights=tuple(flights), **settings)
    check_catalog(catalog, request.calibration or None)
    if catalog is not None and (catalog.exists() or not catalog.parent.is_dir()):
        # What cannot be kept is told before the work; a new file is made after it.
        Catalog(catalog).close()
    if dataset is not None:
        check_dataset_folder(dataset)
    check_windows(request.maneuver_windows, flights)
    known = load_model(request.model) if request.model else None
    with as_usage_error():
        check_names(request, known)
    with open_workers(on) as pool:
        outcome = console.run_with_progress_bar(
            lambda doing, step: execute_run(
                request, doing=doing, progress=step, pool=pool, keep_samples=False
            )
        )
    kept = ""
    if catalog is not None:
        with Catalog(catalog) as store:
            kept = f"kept as run {save_run(store, outcome)} in {catalog}"
    if json is not None:
        write_json(json, outcome_json(outcome))
    print_outcome(console, outcome)
    if form:
        _print_forms(console, outcome, form)
    check_fitted(outcome)
    if dataset is not None:
        with console.status("writing the dataset"):
            write_campaign_dataset(outcome, dataset)
        console.print(f"written to {dataset}", soft_wrap=True)
    if update_aircraft:
        _update_aircraft(console, outcome)
    if json is not None and not is_stdout(json):
        console.print(f"written to {json}", soft_wrap=True)
    if kept:
        console.print(kept, soft_wrap=True)


def _check_forms(wanted: Sequence[str]) -> None:
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.foundation.name_suggestions import did_you_mean
    from gsapp.identification.summary.derivative_forms import FORM_TITLES

    for name in wanted:
        if name not in FORM_TITLES:
            hint = did_you_mean(name, FORM_TITLES, f"there are {', '.join(FORM_TITLES)}")
            raise CommandUsageError(f"there is no form '{name}'; {hint}")


def _update_aircraft(console: PlainConsole, outcome: RunOutcome) -> None:
    from gsapp.identification.runs.run_execution import accept_instruments

    if not outcome.sensor_values:
        console.print("the instruments are as the aircraft file says; it stays as it is")
        return
    for path in accept_instruments(outcome):
        console.print(f"instruments updated in {path}", soft_wrap=True)


def print_outcome(console: PlainConsole, outcome: RunOutcome) -> None:
    """Print the derivatives, how well each maneuver was fitted, and what is to be said."""
    from gsapp.report.estimate_text import outcome_remarks

    results = outcome.result.results
    console.print_unwrapped(_values(console, outcome))
    console.print_sentence(_LEGEND, "dim")
    console.print_unwrapped(_fits(console, results))
    for sentence in outcome_remarks(outcome):
        console.print_sentence(sentence, "yellow")


_HEADINGS = ("mean", "bound", "noise", "systematic", "disagreement", "n")
_LEGEND = (
    "bound: standard error of the mean. Its parts: noise; systematic, errors of instruments and "
    "aircraft file that all maneuvers share; and disagreement of maneuvers or methods beyond their "
    "own bounds"
)


def _print_forms(console: PlainConsole, outcome: RunOutcome, wanted: Sequence[str]) -> None:
    """Print the means, and each joint fit, in other forms."""
    from gsapp.cli._options import DISPLAY_UNITS
    from gsapp.report.form_text import campaign_form_tables

    units = DISPLAY_UNITS.get()
    for table in campaign_form_tables(outcome.result, outcome.summary, units, wanted):
        shown = console.create_table(table.title, table.columns, right=table.columns[1:3])
        for row in table.rows:
            shown.add_row(*row)
        console.print_unwrapped(shown)


def _values(console: PlainConsole, outcome: RunOutcome) -> Table:
    """Return means by each method, and what each maneuver gave where a line has room for it."""
    from gsapp.identification.methods import short_method_title

    result = outcome.result
    results = result.results
    others = dict.fromkeys(method for one in results for method in one.comparisons)
    taken = _FIXED + _METHOD * len(others)
    wide = taken + _EACH * len(results) <= console.width
    used = {one.estimate.method for one in results if one.estimate is not None}
    in_gusts = ", in gusts by filter error" if used - {result.settings.method} else ""
    table = console.create_table(
        title=f"{short_method_title(result.settings.method)}{in_gusts}: {len(results)} "
        f"maneuver{'' if len(results) == 1 else 's'}, per radian"
    )
    table.add_column("", no_wrap=True)
    headings = [*_HEADINGS, *(short_method_title(method) for method in others)]
    headings += [
        f"{one.maneuver.id} {'+'.join(one.maneuver.inputs) or 'none'}" for one in results if wide
    ]
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for name in _rows(result):
        summary = outcome.summary.derivatives.get(name)
        cells: list[str | Text] = [*_mean_cells(summary)]
        cells += [_method_cell(summary, method) for method in others]
        cells += [_cell(one.estimate, name) for one in results if wide]
        table.add_row(name, *cells)
    return table


def _mean_cells(summary: DerivativeSummary | None) -> tuple[str, ...]:
    from gsapp.cli._console import format_value_and_bound

    if summary is None:
        return ("unknown", *[""] * (len(_HEADINGS) - 1))
    value = summary.value
    mean, std = format_value_and_bound(value.mean, value.std)
    parts = (
        format_value_and_bound(part, value.std)[0] if part else ""
        for part in (value.noise, value.systematic, value.disagreement)
    )
    return mean, std, *parts, str(value.n)


def _method_cell(summary: DerivativeSummary | None, method: str) -> str | Text:
    from rich.text import Text

    from gsapp.cli._console import format_value_and_bound

    comparison = None if summary is None else summary.comparison
    if comparison is None or method not in comparison.values:
        return ""
    text = format_value_and_bound(*comparison.values[method])[0]
    return Text(text, "yellow") if method in comparison.contradictions else text


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
    order = {name: index for index, name in enumerate(derivative_names())}
    return sorted(names, key=lambda name: order.get(name, len(order)))


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
