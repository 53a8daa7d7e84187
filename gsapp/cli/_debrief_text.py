"""Verdicts, the score by card and trends on the screen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend
    from gsapp.flight.catalog import CardScore

_COLORS = {"good": "green", "unclear": "yellow"}


def print_cues(console: Console, debrief: Debrief) -> None:
    """Print in a few lines what the crew was told."""
    gone = sum(event.kind == "trim" and event.state == "go" for event in debrief.events)
    heard = sum(bool(one.text) for one in debrief.announcements)
    console.print(
        f"{_count(gone, 'GO')}, {_count(heard, 'sentence')} spoken, "
        f"{_count(len(debrief.maneuvers), 'verdict')}",
        highlight=False,
    )
    for one in debrief.maneuvers:
        print_sentence(console, _sentence(one))


def print_debrief(console: Console, debrief: Debrief) -> None:
    """Print every input with its verdict, and the score by card."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from gsapp.cli._tables import print_unwrapped
    from gsapp.quantities import channel, from_si

    speed = channel("V").display_unit(DISPLAY_UNITS.get())

    table = Table(
        title=f"{debrief.flight}: {_count(len(debrief.maneuvers), 'input')}",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    for heading in (
        "id",
        "at [s]",
        "inputs",
        "kind",
        f"V [{speed}]",
        "GO",
        "card",
        "verdict",
        "grade",
    ):
        table.add_column(heading)
    for one in debrief.maneuvers:
        verdict = one.verdict
        table.add_row(
            verdict.id,
            f"{verdict.t_input:z.1f}",
            "+".join(verdict.surfaces),
            verdict.kind,
            "" if verdict.V is None else f"{from_si(verdict.V, speed, 'speed'):z.0f}",
            "yes" if one.go_at is not None else "no",
            verdict.card,
            Text(verdict.result, _COLORS.get(verdict.result, "red")),
            verdict.grade or "",
        )
    print_unwrapped(console, table)
    for one in debrief.maneuvers:
        print_sentence(console, f"{one.verdict.id}: {_sizes(one)}; {one.verdict.advice}")
    print_score(console, debrief.cards, debrief.score)
    for words in debrief.limitations:
        print_sentence(console, words, "dim")


def print_score(console: Console, cards: Sequence[CardScore], score: float | None) -> None:
    """Print how the test cards were flown; nothing without cards."""
    if score is None:
        return
    for card in cards:
        print_sentence(
            console,
            f"{card.card}: {card.good} of {card.requested} good, {card.flown} flown  {card.title}",
        )
    console.print(f"score: {100.0 * score:z.0f} % of the card set", highlight=False)


def print_trends(console: Console, found: Sequence[FlightTrend]) -> None:
    """Print one line for each flight."""
    from rich import box
    from rich.table import Table

    from gsapp.cli._tables import print_unwrapped
    from gsapp.quantities import SURFACE_NAMES

    table = Table(
        title="from flight to flight", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False
    )
    for heading in ("flight", "inputs", "good", "score", "without GO", "s each"):
        table.add_column(heading, no_wrap=True)
    for one in found:
        table.add_row(
            one.flight,
            str(one.inputs),
            f"{100.0 * one.share_good:z.0f} %",
            "" if one.score is None else f"{100.0 * one.score:z.0f} %",
            str(one.without_go),
            "" if one.seconds_each is None else f"{one.seconds_each:z.0f}",
        )
    print_unwrapped(console, table)
    for one in found:
        told = [f"{SURFACE_NAMES[name]} {share:z.2f}" for name, share in one.amplitudes.items()]
        sizes = f"{', '.join(told)} of the target" if told else "no target"
        worst = max(one.trim_errors, key=lambda name: one.trim_errors[name], default="")
        off = (
            f"; began with {worst} {one.trim_errors[worst]:z.1f} of its tolerance" if worst else ""
        )
        print_sentence(console, f"{one.flight}: {sizes}{off}")


def _sizes(one: EvaluatedManeuver) -> str:
    from gsapp.quantities import SURFACE_NAMES
    from gsapp.quantities.constants import DEGREE

    wanted = {} if one.target_input is None else one.target_input.amplitudes
    told = []
    for name, size in one.verdict.amplitudes.items():
        asked = ""
        if name in wanted:
            low, best, high = (
                f"{angle / DEGREE:z.1f}"
                for angle in (wanted[name].low, wanted[name].best, wanted[name].high)
            )
            asked = f" (target {best}, {low} to {high})"
        told.append(f"{SURFACE_NAMES[name]} {size / DEGREE:z.1f} deg{asked}")
    return ", ".join(told)


def _sentence(one: EvaluatedManeuver) -> str:
    verdict = one.verdict
    card = f" (card {verdict.card})" if verdict.card else ""
    inputs = "+".join(verdict.surfaces)
    return (
        f"{verdict.given_at:9.2f} s  {verdict.id:4} {inputs} {verdict.kind}: {verdict.advice}{card}"
    )


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
