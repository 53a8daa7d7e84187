"""The search for a missing effect on the screen: the story in four steps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from rich.table import Table

    from gsapp.cli._console import PlainConsole
    from gsapp.discrepancy.results import DiscrepancyResult, ModelStep

_NUMBERS = 40
"""Characters that the numbers of a ranking take, with what is between columns."""
_PLACES, _CANDIDATES = 5, 5
"""Most places of disagreement and candidates of a round on the screen; all are in the files."""


def print_discrepancy(console: PlainConsole, found: DiscrepancyResult) -> None:
    """Tell what was found."""
    from gsapp.report.discrepancy_text import HEADLINES, experiment_text

    _find(console, found)
    _name(console, found)
    _add(console, found)
    _show(console, found)
    console.print_sentence(f"\n{HEADLINES[found.verdict]}", "bold")
    console.print_sentence(found.why)
    if found.experiment is not None:
        console.print_sentence(experiment_text(found.experiment, DISPLAY_UNITS.get()))
    for sentence in found.warnings:
        console.print_sentence(sentence, "yellow")


def _find(console: PlainConsole, found: DiscrepancyResult) -> None:
    from gsapp.report.discrepancy_text import disagreement_sentence

    console.print_sentence("1. Find: where do simulation and flight disagree?", "bold")
    for remark in found.instruments:
        style = "" if remark.consistent else "yellow"
        console.print_sentence(f"Instruments: {remark.words}", style)
    _map(console, found)
    for one in found.disagreements[:_PLACES]:
        console.print_sentence(disagreement_sentence(one))
    more = len(found.disagreements) - _PLACES
    if more > 0:
        console.print_sentence(f"{more} more are in the report.")
    if not found.disagreements:
        console.print_sentence("No single disagreement exceeds the noise.")


def _map(console: PlainConsole, found: DiscrepancyResult) -> None:
    """Print what each coefficient lacks in each maneuver, in units of the noise."""
    import numpy as np

    from gsapp.quantities import channel
    from gsapp.report.discrepancy_text import residual_map

    console.print_sentence("residual of each coefficient, 1 = noise floor; * held out", "italic")
    table = console.create_table()
    table.add_column("maneuver", no_wrap=True)
    for name in (*found.coefficients, "worst channel"):
        table.add_column(name, justify="right", no_wrap=True)
    channels = np.nan_to_num(residual_map(found, 0), nan=-1.0)
    for index, view in enumerate(found.maneuvers):
        row = found.steps[0].coefficient_map[index]
        cells = [f"{value:z.1f}" if np.isfinite(value) else "-" for value in row]
        worst = int(np.argmax(channels[index]))
        cells.append(f"{channel(found.channels[worst]).symbol} {channels[index, worst]:z.1f}")
        table.add_row(f"{view.id} {view.kind}{' *' if view.held_out else ''}", *cells)
    console.print_unwrapped(table)


def _name(console: PlainConsole, found: DiscrepancyResult) -> None:
    from gsapp.report.discrepancy_text import alternative_groups, disturbance_text, effect_text

    console.print_sentence("\n2. Name: which effect is missing?", "bold")
    for number, step in enumerate(found.steps, start=1):
        if step.ranking:
            last = step is found.steps[-1]
            title = f"round {number}: " + ("not proven" if last else "candidates, best first")
            console.print_sentence(title, "italic")
            console.print(_ranking(console, step))
    for effect in found.effects:
        console.print_sentence(effect_text(effect, DISPLAY_UNITS.get()))
        if effect.runner_up:
            console.print_sentence(f"Second: {effect.margin_text()}.")
    for group in alternative_groups(found):
        names = ", ".join(" and ".join(other.effects) for other in group)
        console.print_sentence(f"These flights look the same with: {names}")
        for other in group:
            console.print_sentence(f"  {other.title}: {other.why}")
            if other.fly:
                console.print_sentence(f"    To distinguish, fly: {other.fly}")
    if disturbance_text(found):
        console.print_sentence(disturbance_text(found))
    if not found.effects and not found.alternatives:
        console.print_sentence("No effect was named.")


def _ranking(console: PlainConsole, step: ModelStep) -> Table:

    from gsapp.report.discrepancy_text import gain_text, probability_text

    shown = step.ranking[:_CANDIDATES]
    names = max((len(one.effect) for one in shown), default=0)
    table = console.create_table()
    table.add_column("effect", no_wrap=True)
    # What stands in words gives way; the numbers do not.
    table.add_column("in words", no_wrap=True, max_width=max(10, console.width - names - _NUMBERS))
    for heading in ("gain", "evidence", "held out"):
        table.add_column(heading, justify="right", no_wrap=True)
    for one in shown:
        table.add_row(
            one.effect,
            one.title,
            f"{one.score:z.1f}",
            probability_text(one.evidence),
            gain_text(one.held_out),
        )
    return table


def _add(console: PlainConsole, found: DiscrepancyResult) -> None:
    from gsapp.report.discrepancy_text import change_text, parameter_rows, value_with_std

    console.print_sentence("\n3. Add: the model with the effect", "bold")
    for effect in found.effects:
        console.print_sentence(f"{effect.effect}: {effect.equation}")
    for structure in found.structures:
        console.print_sentence(f"found, not understood: {structure.equation}")
    rows = parameter_rows(found.effects, DISPLAY_UNITS.get())
    if rows:
        console.print(_filled(console, ("effect", "parameter", "value", "unit"), rows))
    if found.values:
        changed = [
            (name, f"{one.before:z.4g}", value_with_std(one.after, one.std), change_text(one))
            for name, one in found.values.items()
        ]
        headings = ("derivative", "before", "after", "moved, in std")
        console.print_sentence("values that moved beyond their bounds", "italic")
        console.print(_filled(console, headings, changed))
    if not rows and not found.values:
        console.print_sentence("No effect was added.")


def _show(console: PlainConsole, found: DiscrepancyResult) -> None:
    from gsapp.report.discrepancy_text import closed_gap_text, residual_remarks, rms_rows

    console.print_sentence("\n4. Show: does the gap shrink?", "bold")
    if found.gap.channels:
        headings: tuple[str, ...] = ("channel", "RMS before", "after", "noise")
        rows: list[tuple[str, ...]] = [*rms_rows(found.gap, DISPLAY_UNITS.get())]
        if len(found.steps) == 1:
            headings = ("channel", "RMS", "noise")
            rows = [(row[0], row[1], row[3]) for row in rows]
        where = f"maneuver{'s' if len(found.gap.on) != 1 else ''} {', '.join(found.gap.on)}"
        console.print_sentence(f"residual, {where}", "italic")
        console.print(_filled(console, headings, rows))
        for remark in residual_remarks(found):
            console.print_sentence(remark)
    if len(found.steps) > 1:
        falls = ", ".join(
            f"{step.misfit:z.2f} with {step.added or 'values refitted'}" for step in found.steps[1:]
        )
        console.print_sentence(
            f"Residual of all channels, 1 = noise floor: {found.steps[0].misfit:z.2f} before, "
            f"{falls}."
        )
    console.print_sentence(closed_gap_text(found))


def _filled(console: PlainConsole, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Return a table whose first column is a name and whose others are numbers."""
    table = console.create_table()
    for index, heading in enumerate(headings):
        table.add_column(heading, justify="right" if index else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table
