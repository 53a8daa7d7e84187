"""``gsapp runs``: the runs kept in a catalog, listed, shown, compared, repeated, forgotten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gsapp.cli._options import UNITS

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.catalog import Catalog
    from gsapp.identification.campaign import Step
    from gsapp.identification.runs.choosing import Doing
    from gsapp.identification.runs.keeping import KeptRun

What = Literal["list", "show", "compare", "repeat", "report", "forget", "recall", "rename"]

NEEDED: dict[What, str] = {
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


def check(what: What, rest: Sequence[str], out: Path | None) -> None:
    """Raise `ValueError`, with the right call in words, where it cannot be what was meant."""
    typed, _, place = NEEDED[what].partition("--out")
    needed = typed.split()
    numbers = rest[: needed.count("N") + needed.count("M")]
    fits = len(rest) == len(needed) and all(number.isdecimal() for number in numbers)
    if not fits or bool(place) != (out is not None):
        raise ValueError(f"write: gsapp runs CATALOG {what} {NEEDED[what]}".rstrip())


def run(
    *,
    catalog: Path,
    what: What = "list",
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
        As `check` lets through.
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
    from gsapp.cli._flight_text import check_is_catalog
    from gsapp.cli._results import on_screen, result_text, write_result
    from gsapp.cli._screen import Screen
    from gsapp.flight.catalog import Catalog

    check_is_catalog(catalog, "gsapp estimate --catalog makes one")
    console = Screen(stderr=on_screen(json), highlight=False)
    with Catalog(catalog) as store:
        if out is not None:
            content = _report(console, store, int(rest[0]), out, dated)
        else:
            content = _DO[what](console, store, rest)
    if json is not None:
        write_result(json, result_text(content))


def _list(console: Console, store: Catalog, _: Sequence[str]) -> Any:
    from gsapp.cli._runs_text import tell_list
    from gsapp.identification.runs.keeping import kept_runs

    found = kept_runs(store)
    tell_list(console, found)
    return [_brief(one) for one in found]


def _show(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.cli._runs_text import tell_run
    from gsapp.identification.runs.keeping import kept

    found = kept(store, int(rest[0]))
    tell_run(console, found)
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

    from gsapp.cli._runs_text import tell_comparison
    from gsapp.identification.runs.comparing import compare
    from gsapp.identification.runs.keeping import kept

    found = compare(kept(store, int(rest[0])), kept(store, int(rest[1])), means="campaign")
    tell_comparison(console, found)
    return {
        **asdict(found),
        "values": [{**asdict(one), "differs": one.differs} for one in found.values],
    }


def _repeat(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.cli._running import with_bar
    from gsapp.cli._runs_text import tell_repeated
    from gsapp.identification.estimate_json import campaign_json
    from gsapp.identification.runs.repeating import repeat

    number = int(rest[0])
    found = with_bar(console, lambda doing, step: repeat(store, number, doing=doing, progress=step))
    tell_repeated(console, number, found)
    return {
        "same": found.same,
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

    from gsapp.cli._running import with_bar
    from gsapp.cli._runs_text import tell_repeated
    from gsapp.flight.info import now
    from gsapp.identification.runs.repeating import Repeated, repeat
    from gsapp.identification.runs.shelf import FlightShelf
    from gsapp.report.campaign_writing import write_campaign_report
    from gsapp.report.writing import check_place

    check_place(out)
    shelf = FlightShelf()

    def work(doing: Doing, step: Step) -> tuple[Repeated, tuple[Path, ...]]:
        found = repeat(store, number, flights=shelf, doing=doing, progress=step)
        written = write_campaign_report(
            replace(found.outcome, number=number), out, units=UNITS.get(),
            written=now() if dated else None, flights=shelf, progress=step,
        )  # fmt: skip
        return found, written

    found, written = with_bar(console, work)
    tell_repeated(console, number, found)
    place = out if out.is_dir() else written[0]
    console.print(f"written to {place}", soft_wrap=True)
    return {
        "same": found.same,
        "differences": list(found.differences),
        "written": [str(path) for path in written],
    }


def _forget(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.keeping import forget

    forget(store, int(rest[0]))
    console.print(
        f"run {rest[0]} is forgotten; 'gsapp runs {store.path} recall {rest[0]}' brings it back",
        soft_wrap=True,
    )  # fmt: skip
    return _list_json(store)


def _recall(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.keeping import recall

    recall(store, int(rest[0]))
    console.print(f"run {rest[0]} is back")
    return _list_json(store)


def _rename(console: Console, store: Catalog, rest: Sequence[str]) -> Any:
    from gsapp.identification.runs.keeping import rename

    rename(store, int(rest[0]), rest[1])
    console.print(f"run {rest[0]} is called '{rest[1].strip()}'", soft_wrap=True)
    return _list_json(store)


def _list_json(store: Catalog) -> list[dict[str, Any]]:
    from gsapp.identification.runs.keeping import kept_runs

    return [_brief(one) for one in kept_runs(store)]


def _brief(one: KeptRun) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "number": one.number,
        "label": one.label,
        "when": one.when.isoformat(),
        "method": one.method,
        "axis": one.axis,
        "aircraft": one.aircraft,
        "flights": list(one.flights),
        "maneuver_count": one.maneuver_count,
        "bounds_ratio": one.bounds_ratio,
        "wild": list(one.wild),
        "values": {name: asdict(value) for name, value in one.values.items()},
        "campaign": {name: asdict(value) for name, value in one.campaign.items()},
    }


_DO = {
    "list": _list,
    "show": _show,
    "compare": _compare,
    "repeat": _repeat,
    "forget": _forget,
    "recall": _recall,
    "rename": _rename,
}
