"""``gsapp runs``: the runs kept in a catalog, listed, shown, compared, repeated, forgotten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.catalog import Catalog
    from gsapp.identification.campaign import CampaignProgressCallback
    from gsapp.identification.runs.inputs import StatusCallback
    from gsapp.identification.runs.run_store import StoredRun

RunsAction = Literal["list", "show", "compare", "repeat", "report", "forget", "recall", "rename"]

REQUIRED_ARGUMENTS: dict[RunsAction, str] = {
    "list": "",
    "show": "N",
    "compare": "N M",
    "repeat": "N",
    "report": "N --out PLACE",
    "forget": "N",
    "recall": "N",
    "rename": "N LABEL",
}
"""What is typed after each word: numbers of runs, and a label."""


def check_arguments(what: RunsAction, rest: Sequence[str], out: Path | None) -> None:
    """Raise `ValueError`, with the right call in words, where it cannot be what was meant."""
    typed, _, place = REQUIRED_ARGUMENTS[what].partition("--out")
    needed = typed.split()
    numbers = rest[: needed.count("N") + needed.count("M")]
    fits = len(rest) == len(needed) and all(number.isdecimal() for number in numbers)
    if not fits or bool(place) != (out is not None):
        raise ValueError(f"write: gsapp runs CATALOG {what} {REQUIRED_ARGUMENTS[what]}".rstrip())


def run(
    *,
    catalog: Path,
    what: RunsAction = "list",
    rest: Sequence[str] = (),
    out: Path | None = None,
    dated: bool = True,
    json: Path | None = None,
) -> None:
    """Do what was asked with the runs of a catalog.

    Parameters
    ----------
    catalog : Path
    what : str
    rest : sequence of str
        As `check_arguments` lets through.
    out : Path, optional
        Where the report of a run goes.
    dated : bool
        Whether it says when it was written.
    json : Path, optional
        Where the result for programs goes.

    Raises
    ------
    GroundStationError
        If there is no such catalog or run, or a run cannot be done again.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flight_text import check_is_catalog
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.flight.catalog import Catalog

    check_is_catalog(catalog, "gsapp estimate --catalog makes one")
    console = PlainConsole(stderr=is_stdout(json), highlight=False)
    with Catalog(catalog) as store:
        if out is not None:
            content = _report(console, store, int(rest[0]), out, dated)
        else:
            content = _ACTIONS[what](console, store, rest)
    if json is not None:
        write_json(json, format_json(content))


def _list(console: Console, store: Catalog, _: Sequence[str]) -> Any:
    from gsapp.cli._runs_text import print_runs
    from gsapp.identification.runs.run_store import stored_runs

    found = stored_runs(store)
    print_runs(console, found)
    return [_brief(one) for one in found]


def _show(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.cli._runs_text import print_run
    from gsapp.identification.runs.run_store import load_run

    found = load_run(store, int(rest[0]))
    print_run(console, found)
    return {
        **_brief(found),
        "settings": dict(found.settings),
        "maneuvers": [
            {
                "flight": str(one.flight),
                "id": one.id,
                "t_start": one.t_start,
                "t_end": one.t_end,
                "inputs": list(one.inputs),
            }
            for one in found.request.maneuvers
        ],
        "failures": dict(found.failures),
        "inputs": [
            {"role": one.role, "name": one.name, "sha256": one.sha256} for one in found.inputs
        ],
        "versions": dict(found.versions),
        "remarks": list(found.remarks),
    }


def _compare(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from dataclasses import asdict

    from gsapp.cli._runs_text import print_run_comparison
    from gsapp.identification.runs.run_comparison import compare_runs
    from gsapp.identification.runs.run_store import load_run

    found = compare_runs(
        load_run(store, int(rest[0])), load_run(store, int(rest[1])), means="campaign"
    )
    print_run_comparison(console, found)
    return {
        **asdict(found),
        "values": [{**asdict(one), "differs": one.differs} for one in found.values],
    }


def _repeat(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.cli._progress_bar import run_with_progress_bar
    from gsapp.cli._runs_text import print_repeat_result
    from gsapp.identification.estimate_json import campaign_json
    from gsapp.identification.runs.run_comparison import repeat_run

    number = int(rest[0])
    found = run_with_progress_bar(
        console, lambda doing, step: repeat_run(store, number, doing=doing, progress=step)
    )
    print_repeat_result(console, number, found)
    return {
        "same": found.is_identical,
        "differences": list(found.differences),
        **campaign_json(found.outcome.result),
    }


def _report(
    console: Console,
    store: Catalog,
    number: int,
    out: Path,
    dated: bool,
) -> Any:
    """Repeat a run, and write its report."""
    from dataclasses import replace

    from gsapp.cli._progress_bar import run_with_progress_bar
    from gsapp.cli._runs_text import print_repeat_result
    from gsapp.flight.info import local_timestamp
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.run_comparison import RepeatedRun, repeat_run
    from gsapp.report.campaign_report import write_campaign_report
    from gsapp.report.document_writer import check_report_path

    check_report_path(out)
    shelf = FlightCache()

    def work(
        doing: StatusCallback, step: CampaignProgressCallback
    ) -> tuple[RepeatedRun, tuple[Path, ...]]:
        found = repeat_run(store, number, flights=shelf, doing=doing, progress=step)
        written = write_campaign_report(
            replace(found.outcome, number=number), out, units=DISPLAY_UNITS.get(),
            written=local_timestamp() if dated else None, flights=shelf, progress=step,
        )  # fmt: skip
        return found, written

    found, written = run_with_progress_bar(console, work)
    print_repeat_result(console, number, found)
    place = out if out.is_dir() else written[0]
    console.print(f"written to {place}", soft_wrap=True)
    return {
        "same": found.is_identical,
        "differences": list(found.differences),
        "written": [str(path) for path in written],
    }


def _forget(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.run_store import forget_run

    forget_run(store, int(rest[0]))
    console.print(
        f"run {rest[0]} was deleted; 'gsapp runs {store.path} recall {rest[0]}' restores it",
        soft_wrap=True,
    )  # fmt: skip
    return _list_json(store)


def _recall(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.run_store import recall_run

    recall_run(store, int(rest[0]))
    console.print(f"run {rest[0]} is restored")
    return _list_json(store)


def _rename(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.run_store import rename_run

    rename_run(store, int(rest[0]), rest[1])
    console.print(f"run {rest[0]} is named '{rest[1].strip()}'", soft_wrap=True)
    return _list_json(store)


def _list_json(store: Catalog) -> list[dict[str, Any]]:
    from gsapp.identification.runs.run_store import stored_runs

    return [_brief(one) for one in stored_runs(store)]


def _brief(one: StoredRun) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "number": one.number,
        "label": one.label,
        "when": one.created_at.isoformat(),
        "method": one.method,
        "axis": one.axis,
        "aircraft": one.aircraft,
        "flights": list(one.flights),
        "maneuver_count": one.maneuver_count,
        "bounds_ratio": one.bounds_ratio,
        "wild": list(one.outlying_maneuvers),
        "values": {name: asdict(value) for name, value in one.values.items()},
        "campaign": {name: asdict(value) for name, value in one.campaign.items()},
    }


_ACTIONS = {
    "list": _list,
    "show": _show,
    "compare": _compare,
    "repeat": _repeat,
    "forget": _forget,
    "recall": _recall,
    "rename": _rename,
}
