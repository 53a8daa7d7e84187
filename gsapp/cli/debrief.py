"""``gsapp debrief``: what each input of a flight was worth, and what becomes better."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, CatalogFile, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend
    from gsapp.flight.catalog import CardScore, Catalog
    from gsapp.session import Session

_COLORS = {"good": "green", "unclear": "yellow"}


@takes_settings(MANEUVER_SETTINGS, "aircraft", "channel_map", "calibration")
def debrief(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT", readable=False, help="Without a flight: trends of the catalog"
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Prior model: a file, or the name of a shipped one; default: shipped for the "
            "aircraft",
        ),
    ] = None,
    cards: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help=(
                "Test cards to use instead of those of the flight: a file, or the name of a "
                "shipped set"
            ),
        ),
    ] = None,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    aircraft: str | None = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Tell what every input of a flight was worth.

    Also how the test cards were flown, and trends from flight to flight.

    Verdicts are those that the pilot heard in flight: too small, too large, not trimmed, invalid,
    good, and what to do next time. With a catalog they are kept beside the grades of the
    maneuvers, and its flights are compared.

    Example: gsapp debrief flights/2026-05-12-a --catalog campaign.sqlite

    Example: gsapp debrief --catalog campaign.sqlite
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import CommandUsageError, check_catalog, check_is_catalog
    from gsapp.excitation.debrief import compute_flight_trend
    from gsapp.flight.catalog import Catalog
    from gsapp.session.replay_runner import replay_to_end

    if not flights and catalog is None:
        raise CommandUsageError("nothing to debrief; name a flight, or a --catalog")
    if not flights and catalog is not None:
        check_is_catalog(catalog, "name a flight, or a catalog with flights")
    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    debriefs: list[Debrief] = []
    for path in flights or ():
        with console.status(f"judging {path.name}"):
            session = replay_to_end(path, aircraft, model, channel_map, calibration, cards)
        with contextlib.closing(session):
            debriefs.append(_debrief_of(session))
            if catalog is not None:
                _store(catalog, session, debriefs[-1])
    if catalog is not None:
        with Catalog(catalog) as store:
            found = _trends(store)
    else:
        found = tuple(
            compute_flight_trend(one.flight, one.maneuvers, one.cards) for one in debriefs
        )
    result = {
        "flights": [one.to_json() for one in debriefs],
        "trends": [one.to_json() for one in found],
    }
    write_json(json, result)
    if not is_stdout(json):
        for one in debriefs:
            print_debrief(console, one)
        if len(found) > 1 or not debriefs:
            print_trends(console, found)
        for written in (json, catalog if flights else None):
            if written is not None:
                console.print(f"written to {written}", soft_wrap=True)


def _debrief_of(session: Session) -> Debrief:
    from gsapp.foundation import FlightError

    debrief = session.crew_cues.debrief()
    if debrief is None:
        raise FlightError(f"{session.path} was replayed without cues; nothing to evaluate")
    return debrief


def _store(catalog: Path, session: Session, debrief: Debrief) -> None:
    from gsapp.flight.catalog import Catalog, store_debrief

    name = "" if session.aircraft is None else session.aircraft.name
    with Catalog(catalog) as store:
        store_debrief(
            store, session.flight(), debrief.to_stored_verdicts(), debrief.cards, aircraft=name
        )


def _trends(catalog: Catalog) -> tuple[FlightTrend, ...]:
    from gsapp.excitation.debrief import compute_trends
    from gsapp.flight.catalog import list_card_scores, search_verdicts

    verdicts = search_verdicts(catalog)
    flights = dict.fromkeys(one.flight for one in verdicts)
    return compute_trends(verdicts, {name: list_card_scores(catalog, name) for name in flights})


def print_cues(console: PlainConsole, debrief: Debrief) -> None:
    """Print in a few lines what the crew was told."""
    gone = sum(event.kind == "trim" and event.state == "go" for event in debrief.events)
    heard = sum(bool(one.text) for one in debrief.announcements)
    console.print(
        f"{_count(gone, 'GO')}, {_count(heard, 'sentence')} spoken, "
        f"{_count(len(debrief.maneuvers), 'verdict')}"
    )
    for one in debrief.maneuvers:
        console.print_sentence(_sentence(one))


def print_debrief(console: PlainConsole, debrief: Debrief) -> None:
    """Print every input with its verdict, and the score by card."""
    from rich.text import Text

    from gsapp.quantities import channel, from_si

    speed = channel("V").display_unit(DISPLAY_UNITS.get())

    columns = ("id", "at [s]", "inputs", "kind", f"V [{speed}]", "GO", "card", "verdict", "grade")
    table = console.create_table(
        f"{debrief.flight}: {_count(len(debrief.maneuvers), 'input')}", columns
    )
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
    console.print_unwrapped(table)
    for one in debrief.maneuvers:
        console.print_sentence(f"{one.verdict.id}: {_sizes(one)}; {one.verdict.advice}")
    print_score(console, debrief.cards, debrief.score)
    for text in debrief.limitations:
        console.print_sentence(text, "dim")


def print_score(console: PlainConsole, cards: Sequence[CardScore], score: float | None) -> None:
    """Print how the test cards were flown; nothing without cards."""
    if score is None:
        return
    for card in cards:
        console.print_sentence(
            f"{card.card}: {card.good} of {card.requested} good, {card.flown} flown  {card.title}"
        )
    console.print(f"score: {100.0 * score:z.0f} % of the card set")


def print_trends(console: PlainConsole, found: Sequence[FlightTrend]) -> None:
    """Print one line for each flight."""
    from gsapp.quantities import SURFACE_NAMES

    columns = ("flight", "inputs", "good", "score", "without GO", "s each")
    table = console.create_table("from flight to flight", columns)
    for one in found:
        table.add_row(
            one.flight,
            str(one.inputs),
            f"{100.0 * one.share_good:z.0f} %",
            "" if one.score is None else f"{100.0 * one.score:z.0f} %",
            str(one.without_go),
            "" if one.seconds_each is None else f"{one.seconds_each:z.0f}",
        )
    console.print_unwrapped(table)
    for one in found:
        parts = [f"{SURFACE_NAMES[name]} {share:z.2f}" for name, share in one.amplitudes.items()]
        sizes = f"{', '.join(parts)} of the target" if parts else "no target"
        worst = max(one.trim_errors, key=lambda name: one.trim_errors[name], default="")
        off = (
            f"; began with {worst} {one.trim_errors[worst]:z.1f} of its tolerance" if worst else ""
        )
        console.print_sentence(f"{one.flight}: {sizes}{off}")


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
