"""The search for a missing effect on the screen: the story in four steps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from gsapp.cli._options import UNITS
from gsapp.cli._screen import say
from gsapp.cli._tables import print_whole

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from gsapp.discrepancy.results import Discrepancy, Step

_NUMBERS = 40
"""Characters that the numbers of a ranking take, with what is between columns."""
_PLACES, _CANDIDATES = 5, 5
"""Most places of disagreement and candidates of a round on the screen; all are in the files."""


def describe(console: Console, found: Discrepancy) -> None:
    """Tell what was found.

    Parameters
    ----------
    console : Console
    found : Discrepancy
    """
    from gsapp.report.discrepancy_words import HEADLINES

    _find(console, found)
    _name(console, found)
    _add(console, found)
    _show(console, found)
    say(console, f"\n{HEADLINES[found.verdict]}", "bold")
    say(console, found.why)
    for sentence in found.warnings:
        say(console, sentence, "yellow")


def _find(console: Console, found: Discrepancy) -> None:
    from gsapp.report.discrepancy_words import disagreement_words

    say(console, "1. Find: where do simulation and flight disagree?", "bold")
    for remark in found.instruments:
        style = "" if remark.consistent else "yellow"
        say(console, f"Instruments: {remark.words}", style)
    _map(console, found)
    for one in found.disagreements[:_PLACES]:
        say(console, disagreement_words(one))
    more = len(found.disagreements) - _PLACES
    if more > 0:
        say(console, f"{more} more such places are in the report.")
    if not found.disagreements:
        say(console, "At no single place clearly beyond the noise.")


def _map(console: Console, found: Discrepancy) -> None:
    """Print what each coefficient lacks in each maneuver, in units of the noise."""
    import numpy as np

    from gsapp.quantities import channel
    from gsapp.report.discrepancy_words import channel_map

    say(console, "missing part of each coefficient, 1 = noise alone; * kept out", "italic")
    table = _table()
    table.add_column("maneuver", no_wrap=True)
    for name in (*found.coefficients, "worst channel"):
        table.add_column(name, justify="right", no_wrap=True)
    channels = np.nan_to_num(channel_map(found, 0), nan=-1.0)
    for place, view in enumerate(found.maneuvers):
        row = found.steps[0].map[place]
        cells = [f"{value:z.1f}" if np.isfinite(value) else "-" for value in row]
        worst = int(np.argmax(channels[place]))
        cells.append(f"{channel(found.channels[worst]).symbol} {channels[place, worst]:z.1f}")
        table.add_row(f"{view.id} {view.kind}{' *' if view.held_out else ''}", *cells)
    print_whole(console, table)


def _name(console: Console, found: Discrepancy) -> None:
    from gsapp.report.discrepancy_words import effect_words, gust_words

    say(console, "\n2. Name: what is missing?", "bold")
    for number, step in enumerate(found.steps, start=1):
        if step.ranking:
            last = step is found.steps[-1]
            title = f"round {number}: " + ("not proven" if last else "candidates, best first")
            say(console, title, "italic")
            console.print(_ranking(step, console.width))
    for effect in found.effects:
        say(console, effect_words(effect, UNITS.get()))
        if effect.runner_up:
            say(
                console,
                f"Next best was {effect.runner_up}, {effect.margin:z.1f} behind in log-likelihood.",
            )
    for other in found.alternatives:
        say(console, f"These flights would look the same with {' and '.join(other.effects)}")
        say(console, f"  {other.title}: {other.why}")
        if other.fly:
            say(console, f"  What would tell: {other.fly}")
    if gust_words(found):
        say(console, gust_words(found))
    if not found.effects and not found.alternatives:
        say(console, "No effect was named.")


def _ranking(step: Step, width: int) -> Table:

    from gsapp.report.discrepancy_words import gain_words, share_words

    shown = step.ranking[:_CANDIDATES]
    names = max((len(one.effect) for one in shown), default=0)
    table = _table()
    table.add_column("effect", no_wrap=True)
    # What stands in words gives way; the numbers do not.
    table.add_column("in words", no_wrap=True, max_width=max(10, width - names - _NUMBERS))
    for heading in ("gain", "evidence", "left out"):
        table.add_column(heading, justify="right", no_wrap=True)
    for one in shown:
        table.add_row(
            one.effect,
            one.title,
            f"{one.score:z.1f}",
            share_words(one.evidence),
            gain_words(one.held_out),
        )
    return table


def _add(console: Console, found: Discrepancy) -> None:
    from gsapp.report.discrepancy_words import moved_words, parameter_rows, with_spread

    say(console, "\n3. Add: the model with the effect", "bold")
    for effect in found.effects:
        say(console, f"{effect.effect}: {effect.equation}")
    rows = parameter_rows(found.effects, UNITS.get())
    if rows:
        console.print(_filled(("effect", "parameter", "value", "unit"), rows))
    if found.values:
        changed = [
            (name, f"{one.before:z.4g}", with_spread(one.after, one.std), moved_words(one))
            for name, one in found.values.items()
        ]
        headings = ("derivative", "before", "after", "moved, in std")
        say(console, "values that moved beyond their bounds", "italic")
        console.print(_filled(headings, changed))
    if not rows and not found.values:
        say(console, "Nothing was added.")


def _show(console: Console, found: Discrepancy) -> None:
    from gsapp.report.discrepancy_words import closed_words, rms_rows

    say(console, "\n4. Show: does the gap shrink?", "bold")
    if found.gap.channels:
        headings: tuple[str, ...] = ("channel", "RMS before", "after", "noise")
        rows: list[tuple[str, ...]] = [*rms_rows(found.gap, UNITS.get())]
        if len(found.steps) == 1:
            headings = ("channel", "RMS", "noise")
            rows = [(row[0], row[1], row[3]) for row in rows]
        where = f"maneuver{'s' if len(found.gap.on) != 1 else ''} {', '.join(found.gap.on)}"
        say(console, f"measured less computed, {where}", "italic")
        console.print(_filled(headings, rows))
    if len(found.steps) > 1:
        falls = ", ".join(
            f"{step.misfit:z.2f} with {step.added or 'values refitted'}" for step in found.steps[1:]
        )
        say(
            console,
            f"Misfit of all channels, 1 = noise: {found.steps[0].misfit:z.2f} before, {falls}.",
        )
    say(console, closed_words(found))


def _filled(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Return a table whose first column is a name and whose others are numbers."""
    table = _table()
    for place, heading in enumerate(headings):
        table.add_column(heading, justify="right" if place else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


def _table() -> Table:
    from rich import box
    from rich.table import Table

    return Table(box=box.SIMPLE_HEAD, pad_edge=False)
