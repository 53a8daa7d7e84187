"""``gsapp runs``: the runs kept in a catalog, listed, shown, compared, repeated, forgotten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gsapp.cli._options import DISPLAY_UNITS, Dated, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.campaign import CampaignProgressCallback
    from gsapp.identification.maneuver import StatusCallback
    from gsapp.identification.runs.run_comparison import RepeatedRun, RunComparison
    from gsapp.identification.runs.run_store import StoredRun

_REQUIRED_ARGUMENTS = {
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
_SHOWN = ("Cm_alpha", "Cm_q", "Cl_p", "Cn_beta")
"""Derivatives that a list of runs is told apart by, where the line has room for them."""
_WIDE = 110
"""Characters of a line that has."""


def runs(
    catalog: Annotated[
        Path, typer.Argument(metavar="CATALOG", readable=False, help="File of the campaign")
    ],
    what: Annotated[
        Literal["list", "show", "compare", "repeat", "report", "forget", "recall", "rename"],
        typer.Argument(help="Action"),
    ] = "list",
    rest: Annotated[
        list[str] | None, typer.Argument(metavar="N|LABEL", help="Numbers of runs; a label")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="PLACE", help="Of the report: a .html or .pdf file, or a folder"
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    dated: Dated = True,
    json: JsonFile = None,
) -> None:
    """List the runs kept in a catalog, compare or repeat them.

    They can also be shown, reported, renamed, forgotten and recalled.

    A run that is repeated uses the same maneuvers with the same edges and settings; it gives the
    same numbers to the last bit, or you are told what has changed.

    Example: gsapp runs campaign.sqlite

    Example: gsapp runs campaign.sqlite compare 3 5

    Example: gsapp runs campaign.sqlite repeat 3

    Example: gsapp runs campaign.sqlite report 3 --out results
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import check_is_catalog
    from gsapp.flight.catalog import Catalog

    typed = rest or []
    _check_arguments(what, typed, out)
    check_is_catalog(catalog, "gsapp estimate --catalog makes one")
    console = PlainConsole(stderr=is_stdout(json))
    with Catalog(catalog) as store:
        if what == "list":
            content = _list(console, store)
        elif what == "show":
            content = _show(console, store, int(typed[0]))
        elif what == "compare":
            content = _compare(console, store, int(typed[0]), int(typed[1]))
        elif what in ("repeat", "report"):
            content = _repeat(console, store, int(typed[0]), out, dated)
        else:
            content = _change(console, store, what, typed)
    write_json(json, content)


def _check_arguments(what: str, rest: Sequence[str], out: Path | None) -> None:
    """Raise, with the right call in words, where it cannot be what was meant."""
    typed, _, place = _REQUIRED_ARGUMENTS[what].partition("--out")
    needed = typed.split()
    numbers = rest[: needed.count("N") + needed.count("M")]
    fits = len(rest) == len(needed) and all(number.isdecimal() for number in numbers)
    if not fits or bool(place) != (out is not None):
        raise typer.BadParameter(
            f"write: gsapp runs CATALOG {what} {_REQUIRED_ARGUMENTS[what]}".rstrip()
        )


def _list(console: PlainConsole, store: Catalog) -> Any:
    from gsapp.identification.runs.run_store import stored_runs

    found = stored_runs(store)
    _print_runs(console, found)
    return [_brief(one) for one in found]


def _show(console: PlainConsole, store: Catalog, number: int) -> Any:
    from gsapp.identification.runs.run_store import load_run

    found = load_run(store, number)
    _print_run(console, found)
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


def _compare(console: PlainConsole, store: Catalog, number: int, other: int) -> Any:
    from dataclasses import asdict

    from gsapp.identification.estimate_json import value_json
    from gsapp.identification.runs.run_comparison import compare_runs
    from gsapp.identification.runs.run_store import load_run

    found = compare_runs(load_run(store, number), load_run(store, other), means="campaign")
    _print_run_comparison(console, found)
    return {
        **asdict(found),
        "values": [
            {
                **asdict(one),
                "one": None if one.one is None else value_json(one.one),
                "other": None if one.other is None else value_json(one.other),
                "differs": one.differs,
            }
            for one in found.values
        ],
    }


def _repeat(
    console: PlainConsole, store: Catalog, number: int, out: Path | None, dated: bool
) -> Any:
    """Repeat a run, and write its report where one is asked for."""
    from dataclasses import replace

    from gsapp.flight.info import local_timestamp
    from gsapp.identification.estimate_json import campaign_json
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.run_comparison import repeat_run
    from gsapp.report.campaign_report import write_campaign_report
    from gsapp.report.document_writer import check_report_path

    if out is not None:
        check_report_path(out)
    flight_cache = FlightCache()

    def work(
        doing: StatusCallback, step: CampaignProgressCallback
    ) -> tuple[RepeatedRun, tuple[Path, ...]]:
        found = repeat_run(store, number, flights=flight_cache, doing=doing, progress=step)
        if out is None:
            return found, ()
        return found, write_campaign_report(
            replace(found.outcome, number=number), out, units=DISPLAY_UNITS.get(),
            written=local_timestamp() if dated else None, flights=flight_cache, progress=step,
        )  # fmt: skip

    found, written = console.run_with_progress_bar(work)
    console.print(
        f"run {number} is reproduced to the last bit"
        if found.is_identical
        else f"run {number} gives different values",
        style="" if found.is_identical else "bold",
    )
    for sentence in found.differences:
        console.print_sentence(sentence, "yellow")
    content = {"same": found.is_identical, "differences": list(found.differences)}
    if out is None:
        return content | campaign_json(found.outcome.result)
    console.print(f"written to {out if out.is_dir() else written[0]}", soft_wrap=True)
    return content | {"written": [str(path) for path in written]}


def _change(console: PlainConsole, store: Catalog, what: str, typed: Sequence[str]) -> Any:
    """Forget, recall or rename a run; return the list of runs."""
    from gsapp.identification.runs import run_store

    number = int(typed[0])
    if what == "forget":
        run_store.forget_run(store, number)
        text = f"was deleted; 'gsapp runs {store.path} recall {number}' restores it"
    elif what == "recall":
        run_store.recall_run(store, number)
        text = "is restored"
    else:
        run_store.rename_run(store, number, typed[1])
        text = f"is named '{typed[1].strip()}'"
    console.print(f"run {typed[0]} {text}", soft_wrap=True)
    return [_brief(one) for one in run_store.stored_runs(store)]


def _brief(one: StoredRun) -> dict[str, Any]:
    from gsapp.identification.estimate_json import value_json

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
        "values": {name: value_json(value) for name, value in one.values.items()},
        "campaign": {name: value_json(value) for name, value in one.campaign.items()},
    }


def _print_runs(console: PlainConsole, runs: Sequence[StoredRun]) -> None:
    """Print a line for each run."""
    wide = console.width >= _WIDE
    shown = [name for name in _SHOWN if wide and any(name in one.campaign for one in runs)]
    numbers = ("flights", "maneuvers", *shown)
    table = console.create_table(
        f"{len(runs)} run{'' if len(runs) == 1 else 's'}",
        ("run", "when", "method", "axis", *numbers, "label"),
        right=numbers,
    )
    for one in runs:
        table.add_row(
            str(one.number),
            f"{one.created_at.astimezone():%Y-%m-%d %H:%M}",
            one.method,
            one.axis,
            str(len(one.flights)),
            str(one.maneuver_count),
            *(f"{one.campaign[name].mean:z.4g}" if name in one.campaign else "" for name in shown),
            one.label,
        )
    console.print_unwrapped(table)


def _print_run(console: PlainConsole, one: StoredRun) -> None:
    """Print all of a run: settings, values, files, versions, remarks."""
    from gsapp.cli._console import MEAN_HEADINGS, MEAN_LEGEND, mean_cells

    table = console.create_table(
        f"{one.name}: {one.maneuver_count} maneuvers, {', '.join(one.flights)}",
        ("", *MEAN_HEADINGS),
        right=MEAN_HEADINGS,
    )
    for name, value in one.campaign.items():
        table.add_row(name, *mean_cells(value))
    console.print_unwrapped(table)
    console.print_sentence(MEAN_LEGEND, "dim")
    for heading, rows in (
        ("settings", list(one.settings.items())),
        ("files", [(f"{file.role} {file.name}", file.sha256) for file in one.inputs]),
        ("versions", list(one.versions.items())),
    ):
        listed = console.create_table("")
        listed.add_column(heading, overflow="fold")
        listed.add_column("", overflow="fold")
        for name, text in rows:
            listed.add_row(name, text)
        console.print(listed)
    remarks = [f"maneuver {name} could not be fitted: {why}" for name, why in one.failures.items()]
    for sentence in (*remarks, *one.remarks):
        console.print_sentence(sentence, "yellow")


def _print_run_comparison(console: PlainConsole, found: RunComparison) -> None:
    """Print what differs between two runs, and their values beside each other."""
    from gsapp.cli._console import MEAN_HEADINGS, MEAN_LEGEND, mean_cells

    asked = console.create_table("request")
    for heading in ("", found.one, found.other):
        asked.add_column(heading, overflow="fold")
    for setting in found.settings:
        asked.add_row(setting.name, setting.one, setting.other)
    console.print(asked if found.settings else "the requests are equal")
    for sentence in found.versions:
        console.print_sentence(sentence, "yellow")
    own = [f"{run}\n{heading}" for run in (found.one, found.other) for heading in MEAN_HEADINGS]
    own += ["difference", "in bounds"]
    table = console.create_table(
        "per radian; difference in joint bounds", ("", *own, ""), right=own
    )
    for one in found.values:
        table.add_row(
            one.name,
            *mean_cells(one.one),
            *mean_cells(one.other),
            "" if one.difference is None else f"{one.difference:+z.2g}",
            "single value" if one.in_bounds is None else f"{one.in_bounds:+z.2f}",
            "differs" if one.in_bounds is not None and one.differs else "",
        )
    console.print_unwrapped(table)
    console.print_sentence(MEAN_LEGEND, "dim")
