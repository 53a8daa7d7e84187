"""``gsapp discrepancy``: find where model and flight disagree, name it, add it, show it shrink."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import takes_settings
from gsapp.cli._options import DISPLAY_UNITS, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.cli._console import PlainConsole
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgress
    from gsapp.identification.maneuver import Maneuver
    from gsapp.report.provenance import Provenance

MODEL_FILE, RESULT_FILE, CARDS_FILE = "model.toml", "discrepancy.json", "cards.toml"
"""Files in the folder beside the report and its figures."""


@takes_settings("gsapp.discrepancy.settings:DiscrepancySettings")
def discrepancy(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT",
            readable=False,
            help="Flight folders, .tlog, .bin, .log, .ulg, .csv, .asc, .mat, .parquet",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="DIR",
            help="Folder for the revised model, report.html, report.pdf, figures, "
            "discrepancy.json; cards.toml with the maneuver that decides, if any",
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the effects and exit")] = False,
    catalog: Annotated[bool, typer.Option("--catalog", hidden=True)] = False,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MANEUVER",
            help="Plot all channels of this maneuver in the report; repeatable; default: worst "
            "held-out maneuver",
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Name and add the effect that a model lacks.

    Find where simulation and flight disagree, name the effect, add it, show the gap shrink.

    Example: gsapp discrepancy flights/a flights/b --aircraft b777 --model b777 --out missing

    Example: gsapp discrepancy flights/a --out missing --refuse aero.Cm.speed
    --held-out 3 --held-out 7

    Example: gsapp discrepancy --list
    """
    if list_ or catalog:
        from gsapp.cli._effect_catalog_text import list_effects

        list_effects(json)
        return
    if not flights or out is None:
        raise typer.BadParameter("give FLIGHT... and --out DIR, or --list")
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._discrepancy_text import print_discrepancy
    from gsapp.cli._flight_text import (
        calibration_sentences,
        load_flown_flights,
        print_aircraft_warnings,
    )
    from gsapp.cli._usage_errors import as_usage_error, check_windows
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.results import discrepancy_json
    from gsapp.discrepancy.search_checks import check_model_match, record_remarks
    from gsapp.discrepancy.settings import DiscrepancySettings
    from gsapp.dynamics.model import load_model
    from gsapp.flight.maneuvers import uncalibrated_text
    from gsapp.foundation import FlightError
    from gsapp.identification.maneuver import no_maneuvers_text
    from gsapp.report.provenance import search_provenance

    console = PlainConsole(stderr=is_stdout(json))
    _check_output_folder(out)
    with as_usage_error():
        request = DiscrepancySettings(check_instruments=True, **settings)
        _check_effects((*request.refused, *request.forced))
    check_windows(request.maneuver_windows, flights)
    model = load_model(request.model) if request.model else None
    flown = load_flown_flights(flights, request, console)
    own = flown[0].aircraft
    maneuvers = [one for flight in flown for one in flight.maneuvers]
    if not maneuvers:
        raise FlightError(
            f"no maneuver to compare model and flight by: {no_maneuvers_text(flown)}; name windows "
            "of the flight with --maneuver START:STOP, or fly doublets"
        )
    _check_maneuvers(maneuvers, request.held_out or (), draw or ())
    if model is not None:
        check_model_match(model, maneuvers)
    try:
        found = _search(console, Investigation(maneuvers, own, model), request)
    except FlightError as error:
        causes = (text for one in flown for text in uncalibrated_text(one.flight))
        raise FlightError("; ".join(dict.fromkeys((str(error), *causes)))) from error
    remarks = (*calibration_sentences(one.flight for one in flown), *record_remarks(maneuvers, own))
    found = replace(found, warnings=tuple(dict.fromkeys((*found.warnings, *remarks))))
    provenance = search_provenance(flights, request)
    with console.status("writing the report"), _atomic_folder(out) as part:
        _fill(part, found, out, own, provenance, draw or ())
    write_json(json, discrepancy_json(found, model=out / MODEL_FILE))
    print_aircraft_warnings(console, [flown[0].file_aircraft])
    for one in flown:
        for remark in one.remarks:
            if remark not in one.flight.calibration_remarks:  # stands among the warnings
                console.print_sentence(f"{one.flight.name}: {remark}", "yellow")
    print_discrepancy(console, found)
    cards = "" if found.experiment is None else ", the test cards"
    console.print(f"The model{cards}, the report and its figures are in {out}", soft_wrap=True)


def _check_output_folder(out: Path) -> None:
    """Raise unless the folder can be written: said before the search, not after it."""
    from gsapp.foundation import GroundStationError
    from gsapp.foundation.errors import format_os_error

    if out.exists() and not out.is_dir():
        raise GroundStationError(f"{out} is a file; choose a folder for the answer")
    there = next((one for one in (out, *out.absolute().parents) if one.is_dir()), Path())
    try:
        Path(tempfile.mkdtemp(prefix=".gsapp-", dir=there)).rmdir()
    except OSError as error:
        raise GroundStationError(
            format_os_error(out, error, "choose a folder with write permission")
        ) from error


def _check_effects(names: Sequence[str]) -> None:
    """Raise if an effect that is refused or forced is not in the catalog."""
    from gsapp.discrepancy.effect_catalog import find_effect

    for name in names:
        # Structure without a name is found, not listed; it may be refused by what it was called.
        if not name.startswith("unnamed."):
            find_effect(name)


def _check_maneuvers(
    maneuvers: Sequence[Maneuver], held_out: Sequence[str], draw: Sequence[str]
) -> None:
    """Raise if one that was asked for by its id is not among them."""
    from gsapp.foundation import UnknownNameError

    known = [one.id for one in maneuvers]
    for option, names in (("--held-out", held_out), ("--draw", draw)):
        for name in names:
            if name not in known:
                raise UnknownNameError(
                    f"{option}: there is no maneuver '{name}'; there are {', '.join(known)}"
                )


def _search(
    console: PlainConsole, investigation: Investigation, settings: DiscrepancySettings
) -> DiscrepancyResult:
    from rich.progress import TaskProgressColumn, TimeRemainingColumn

    columns = (TaskProgressColumn(), TimeRemainingColumn())
    with console.progress(*columns, disable=not console.is_terminal) as bar:
        task = bar.add_task("preparing", total=1.0)

        def show(done: SearchProgress) -> None:
            bar.update(task, completed=done.share, description=done.activity)

        return investigation.run(settings, progress=show)


def _fill(
    folder: Path,
    found: DiscrepancyResult,
    out: Path,
    aircraft: Aircraft,
    provenance: Provenance,
    draw: Sequence[str],
) -> None:
    """Write everything into a folder that will stand at `out`."""
    from gsapp.cli._console import format_json
    from gsapp.discrepancy.results import discrepancy_json
    from gsapp.dynamics.model import save_model
    from gsapp.flight.cards import save_cards
    from gsapp.flight.info import local_timestamp
    from gsapp.foundation import write_atomically
    from gsapp.report.discrepancy_report import write_discrepancy_report

    save_model(found.model, folder / MODEL_FILE)
    if found.experiment is not None:
        save_cards(folder / CARDS_FILE, found.experiment.card_set(aircraft.name))
    write_atomically(
        folder / RESULT_FILE, format_json(discrepancy_json(found, model=out / MODEL_FILE))
    )
    write_discrepancy_report(
        found, folder, aircraft=aircraft.name, provenance=provenance, units=DISPLAY_UNITS.get(),
        overlays=draw or None, written=local_timestamp(),
    )  # fmt: skip


@contextmanager
def _atomic_folder(out: Path) -> Iterator[Path]:
    """Give a folder to fill; what is in it stands at `out` when all is done, or not at all."""
    from gsapp.foundation.files import create_sibling_folder, move_into_place

    out.parent.mkdir(parents=True, exist_ok=True)
    part = create_sibling_folder(out)
    try:
        yield part
        if not out.exists():
            move_into_place(part, out)
            return
        for new in part.iterdir():
            old = out / new.name
            if old.is_dir():
                shutil.rmtree(old)
            move_into_place(new, old)
    finally:
        shutil.rmtree(part, ignore_errors=True)
