"""``gsapp discrepancy``: find where model and flight disagree, name it, add it, show it shrink."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.aircraft import Aircraft
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.discrepancy.settings import DiscrepancySettings
    from gsapp.identification.maneuver import Maneuver
    from gsapp.report.provenance import Provenance

MODEL_FILE, RESULT_FILE = "model.toml", "discrepancy.json"
"""Files in the folder beside the report and its figures."""


def run(
    *,
    flights: Sequence[Path],
    out: Path,
    draw: Sequence[str] = (),
    json: Path | None = None,
    **settings: Any,
) -> None:
    """Search for what a model lacks and write the answer.

    Parameters
    ----------
    flights : sequence of Path
    out : Path
        Folder for the revised model, the report, its figures and the JSON. Of what stands there
        already only files of the same names are replaced, all at once when everything is done.
    draw : sequence of str
        Ids of the maneuvers that the report draws in full; by default the worst of those kept out.
    json : Path, optional
        Where the answer for programs goes, besides the folder.
    **settings
        Fields of `gsapp.discrepancy.settings.DiscrepancySettings`.

    Raises
    ------
    GroundStationError
        If a file or name is wrong, or these maneuvers do not suffice.
    """
    from gsapp.cli._aircraft_text import print_aircraft_warnings
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._discrepancy_text import print_discrepancy
    from gsapp.cli._flight_text import calibration_sentences
    from gsapp.cli._flown_flights import load_flown_flights
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error, check_windows
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.results import discrepancy_json
    from gsapp.discrepancy.search_checks import check_model_match, record_remarks
    from gsapp.discrepancy.settings import DiscrepancySettings
    from gsapp.dynamics.model import load_model
    from gsapp.flight.maneuvers import uncalibrated_text
    from gsapp.foundation import FlightError
    from gsapp.identification.maneuver_extraction import no_maneuvers_text
    from gsapp.report.discrepancy_provenance import search_provenance

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
    _check_maneuvers(maneuvers, request.held_out or (), draw)
    if model is not None:
        check_model_match(model, maneuvers)
    try:
        found = _search(console, Investigation(maneuvers, own, model), request)
    except FlightError as error:
        causes = (words for one in flown for words in uncalibrated_text(one.flight))
        raise FlightError("; ".join(dict.fromkeys((str(error), *causes)))) from error
    remarks = (
        *calibration_sentences(one.flight for one in flown),
        *record_remarks(maneuvers, own),
    )
    found = replace(found, warnings=tuple(dict.fromkeys((*found.warnings, *remarks))))
    provenance = search_provenance(flights, request)
    with console.status("writing the report"), _atomic_folder(out) as part:
        _fill(part, found, out, own, provenance, draw)
    if json is not None:
        write_json(json, format_json(discrepancy_json(found, model=out / MODEL_FILE)))
    print_aircraft_warnings(console, [flown[0].file_aircraft])
    for one in flown:
        for remark in one.remarks:
            if remark not in one.flight.calibration_remarks:  # stands among the warnings
                print_sentence(console, f"{one.flight.name}: {remark}", "yellow")
    print_discrepancy(console, found)
    console.print(
        f"The model, the report and its figures are in {out}", highlight=False,
        soft_wrap=True,
    )  # fmt: skip


# --- before the search --------------------------------------------------------------------------


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


# --- the search ---------------------------------------------------------------------------------


def _search(
    console: Console, investigation: Investigation, settings: DiscrepancySettings
) -> DiscrepancyResult:
    from rich.progress import BarColumn, Progress, TaskProgressColumn
    from rich.progress import TimeRemainingColumn as TimeLeft

    from gsapp.cli._console import description_column
    from gsapp.discrepancy.settings import SearchProgress as Done

    columns = (description_column(), BarColumn(), TaskProgressColumn(), TimeLeft())
    shown = console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=not shown) as bar:
        task = bar.add_task("preparing", total=1.0)

        def show(done: Done) -> None:
            bar.update(task, completed=done.share, description=done.activity)

        return investigation.run(settings, progress=show)


# --- what is written ----------------------------------------------------------------------------


def _fill(
    folder: Path,
    found: DiscrepancyResult,
    out: Path,
    aircraft: Aircraft,
    provenance: Provenance,
    draw: Sequence[str],
) -> None:
    """Write everything into a folder that will stand at `out`."""
    from gsapp.cli._json_output import format_json
    from gsapp.discrepancy.results import discrepancy_json
    from gsapp.dynamics.model import save_model
    from gsapp.flight.info import local_timestamp
    from gsapp.foundation import write_atomically
    from gsapp.report.discrepancy_report import write_discrepancy_report

    save_model(found.model, folder / MODEL_FILE)
    write_atomically(
        folder / RESULT_FILE, format_json(discrepancy_json(found, model=out / MODEL_FILE))
    )
    write_discrepancy_report(
        found, folder, aircraft=aircraft.name, provenance=provenance, units=DISPLAY_UNITS.get(),
        overlays=draw or None, written=local_timestamp(),
    )  # fmt: skip


@contextlib.contextmanager
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
