"""Kept runs on the screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from gsapp.cli._console import print_sentence
from gsapp.cli._tables import print_unwrapped
from gsapp.cli._value_format import MEAN_HEADINGS, MEAN_LEGEND, mean_cells

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from gsapp.identification.campaign import CampaignValue
    from gsapp.identification.runs.run_comparison import RepeatedRun, RunComparison
    from gsapp.identification.runs.run_store import StoredRun

_SHOWN = ("Cm_alpha", "Cm_q", "Cl_p", "Cn_beta")
"""Derivatives that a list of runs is told apart by, where the line has room for them."""
_WIDE = 110
"""Characters of a line that has."""


def print_runs(console: Console, runs: Sequence[StoredRun]) -> None:
    """Print a line for each run."""
    table = _table(f"{len(runs)} run{'' if len(runs) == 1 else 's'}")
    for heading in ("run", "when", "method", "axis"):
        table.add_column(heading, no_wrap=True)
    for heading in ("flights", "maneuvers"):
        table.add_column(heading, justify="right", no_wrap=True)
    wide = console.width >= _WIDE
    shown = [name for name in _SHOWN if wide and any(name in one.campaign for one in runs)]
    for name in shown:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("label", overflow="ellipsis", no_wrap=True)
    for one in runs:
        table.add_row(
            str(one.number),
            f"{one.created_at.astimezone():%Y-%m-%d %H:%M}",
            one.method,
            one.axis,
            str(len(one.flights)),
            str(one.maneuver_count),
            *(_value(one.campaign, name) for name in shown),
            one.label,
        )
    print_unwrapped(console, table)


def print_run(console: Console, one: StoredRun) -> None:
    """Print all of a run: settings, values, files, versions, remarks."""
    table = _table(f"{one.name}: {one.maneuver_count} maneuvers, {', '.join(one.flights)}")
    for heading in ("", *MEAN_HEADINGS):
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    for name, value in one.campaign.items():
        table.add_row(name, *mean_cells(value))
    print_unwrapped(console, table)
    print_sentence(console, MEAN_LEGEND, "dim")
    for heading, rows in (
        ("settings", [(name, words) for name, words in one.settings.items()]),
        ("files", [(f"{file.role} {file.name}", file.sha256) for file in one.inputs]),
        ("versions", [(name, version) for name, version in one.versions.items()]),
    ):
        listed = _table("")
        listed.add_column(heading, overflow="fold")
        listed.add_column("", overflow="fold")
        for name, words in rows:
            listed.add_row(name, words)
        console.print(listed)
    said = [f"maneuver {name} could not be fitted: {why}" for name, why in one.failures.items()]
    for sentence in (*said, *one.remarks):
        print_sentence(console, sentence, "yellow")


def print_run_comparison(console: Console, found: RunComparison) -> None:
    """Print what differs between two runs, and their values beside each other."""
    asked = _table("request")
    for heading in ("", found.one, found.other):
        asked.add_column(heading, overflow="fold")
    for setting in found.settings:
        asked.add_row(setting.name, setting.one, setting.other)
    console.print(asked if found.settings else "the requests are equal")
    for sentence in found.versions:
        print_sentence(console, sentence, "yellow")
    table = _table("per radian; difference in joint bounds")
    own = [f"{run}\n{heading}" for run in (found.one, found.other) for heading in MEAN_HEADINGS]
    for heading in ("", *own, "difference", "in bounds", ""):
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    for one in found.values:
        table.add_row(
            one.name,
            *_cells(one.one),
            *_cells(one.other),
            "" if one.difference is None else f"{one.difference:+z.2g}",
            "single value" if one.in_bounds is None else f"{one.in_bounds:+z.2f}",
            "differs" if one.in_bounds is not None and one.differs else "",
        )
    print_unwrapped(console, table)
    print_sentence(console, MEAN_LEGEND, "dim")


def print_repeat_result(console: Console, number: int, found: RepeatedRun) -> None:
    """Print whether a run gave the same again, and what differs."""
    console.print(
        f"run {number} is reproduced to the last bit"
        if found.is_identical
        else f"run {number} gives different values",
        style="" if found.is_identical else "bold",
    )
    for sentence in found.differences:
        print_sentence(console, sentence, "yellow")


def _table(title: str) -> Table:
    from rich import box
    from rich.table import Table

    return Table(title=title or None, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)


def _value(values: Mapping[str, CampaignValue], name: str) -> str:
    return f"{values[name].mean:z.4g}" if name in values else ""


def _cells(value: CampaignValue | None) -> list[str]:
    return ["unknown", "", "", ""] if value is None else mean_cells(value)
