"""``gsapp maneuvers``: the maneuvers of flights, found and graded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import (
    DISPLAY_UNITS,
    CatalogFile,
    FlightPaths,
    JsonFile,
    On,
    Units,
    open_workers,
)

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.catalog import FlightEntry
    from gsapp.flight.flight import Flight
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.flight.maneuvers import DetectedManeuver, FlightManeuvers

_GRADE_COLORS = {"A": "green", "B": "green", "C": "yellow", "D": "red"}
_CARD_COLORS = {"done": "green", "begun": "yellow", "open": "red"}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Survey:
    """What is printed of a flight and kept of it."""

    entry: FlightEntry
    found: FlightManeuvers
    calibration: tuple[str, ...]
    aircraft_warnings: tuple[str, ...]
    remarks: tuple[str, ...]
    assumed: str
    """Where nobody said which aircraft flew it: which one is taken, in words."""


def _survey(
    path: Path, settings: ManeuverSettings, doing: Callable[[str], object] = lambda _: None
) -> _Survey:
    from gsapp.aircraft import file_warnings
    from gsapp.flight.catalog import FlightEntry
    from gsapp.flight.flight import calibration_sentences
    from gsapp.flight.read_settings import assumed_aircraft_text
    from gsapp.session.graded_maneuvers import find_graded_maneuvers

    graded = find_graded_maneuvers(path, settings, doing=doing)
    flight, aircraft, found = graded.flight, graded.aircraft, graded.found
    is_known = graded.is_aircraft_known
    return _Survey(
        entry=FlightEntry.from_flight(flight, found.maneuvers, aircraft=aircraft),
        found=found,
        calibration=calibration_sentences([flight]),
        aircraft_warnings=tuple(f"{aircraft.name}: {text}" for text in file_warnings(aircraft)),
        remarks=_remarks(flight, found),
        assumed="" if is_known else assumed_aircraft_text(flight.name, flight.info),
    )


def _survey_or_failure(path: Path, settings: ManeuverSettings) -> _Survey | str:
    from gsapp.foundation import GroundStationError

    try:
        return _survey(path, settings)
    except GroundStationError as error:
        return str(error)


@takes_settings(MANEUVER_SETTINGS, "aircraft", "as_found", "channel_map", "calibration")
def maneuvers(
    flights: FlightPaths,
    on: On = None,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    aircraft: str | None = None,
    as_found: bool = False,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Find the maneuvers of flights and grade them.

    What was changed by hand counts.

    Example: gsapp maneuvers flights/2026-05-12-a --json maneuvers.json

    Example: gsapp maneuvers flights/* --on local --catalog campaign.sqlite
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import check_catalog
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.foundation import FlightError

    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    settings = ManeuverSettings(
        aircraft=aircraft or "",
        as_found=as_found,
        channel_map=channel_map or "",
        calibration=calibration or "",
    )
    surveys = _surveys(console, flights, settings, on)
    if catalog is not None:
        _store(catalog, surveys)
    content = [_json(path, one) for path, one in zip(flights, surveys, strict=True)]
    write_json(json, content if len(flights) > 1 else content[0]["maneuvers"])
    _print(console, flights, surveys, brief=is_stdout(json))
    if not is_stdout(json):
        for file in (json, catalog):
            if file is not None:
                console.print(f"written to {file}", soft_wrap=True)
    failed = sum(isinstance(one, str) for one in surveys)
    if failed:
        raise FlightError(f"{failed} of {len(flights)} flights could not be searched")


def _json(path: Path, survey: _Survey | str) -> dict[str, Any]:
    if isinstance(survey, str):
        return {"flight": path.name, "maneuvers": [], "failure": survey}
    found = survey.found.maneuvers
    return {"flight": survey.entry.name, "maneuvers": [one.to_json() for one in found]}


def _print(
    console: PlainConsole, flights: Sequence[Path], surveys: Sequence[_Survey | str], *, brief: bool
) -> None:
    found = [one for one in surveys if not isinstance(one, str)]
    sentences = [text for one in found for text in one.calibration]
    if not brief:
        sentences += dict.fromkeys(text for one in found for text in one.aircraft_warnings)
    for sentence in sentences:
        console.print_sentence(sentence, "yellow")
    for path, survey in zip(flights, surveys, strict=True):
        if isinstance(survey, str):
            console.print_sentence(f"{path.name}: {survey}", "bold red")
        elif not brief:
            _describe(console, survey)
            if survey.assumed:
                console.print_sentence(survey.assumed, "yellow")
            print_card_status(console, path, survey.found.maneuvers)


def _surveys(
    console: PlainConsole, flights: Sequence[Path], settings: ManeuverSettings, on: str | None
) -> list[_Survey | str]:
    """Return what was found in each flight; of several, why one could not be searched."""
    from gsapp.foundation import FlightError
    from gsapp.foundation.executors import WorkerLostError, map_tasks

    with open_workers(on) as pool, console.status("reading") as status:
        if len(flights) == 1 and pool is None:
            return [_survey(flights[0], settings, status.update)]

        def paths() -> Iterator[Path]:
            for number, path in enumerate(flights, start=1):
                status.update(f"reading {path.name} ({number} of {len(flights)})")
                yield path

        work = partial(_survey_or_failure, settings=settings)
        found = [
            str(one) if isinstance(one, WorkerLostError) else one
            for one in map_tasks(pool, work, paths())
        ]
    if len(found) == 1 and isinstance(found[0], str):
        raise FlightError(found[0])
    return found


def _store(catalog: Path, surveys: Sequence[_Survey | str]) -> None:
    from gsapp.flight.catalog import Catalog, store_entry

    with Catalog(catalog) as store:
        for one in surveys:
            if not isinstance(one, str):
                store_entry(store, one.entry)


def _remarks(flight: Flight, found: FlightManeuvers) -> tuple[str, ...]:
    from gsapp.flight.maneuvers import explain_no_maneuvers, surface_remarks, uncalibrated_text

    if found.maneuvers:
        return (*found.remarks, *uncalibrated_text(flight))
    return (
        f"no maneuver was found: {explain_no_maneuvers(flight)}; name one with --maneuver "
        "START:STOP where a command takes it",
        *(one for one in found.remarks if one not in surface_remarks(flight)),
    )


def _describe(console: PlainConsole, survey: _Survey) -> None:
    from rich.text import Text

    from gsapp.flight.maneuvers import GRADED_BY_CREW, GRADES
    from gsapp.quantities import channel, to_si
    from gsapp.quantities.constants import DEGREE

    speed = channel("V").display_unit(DISPLAY_UNITS.get())

    found = survey.found
    count = len(found.maneuvers)
    numbers = ("start [s]", "end [s]", "size [deg]", f"V [{speed}]", "alpha [deg]")
    table = console.create_table(
        f"{survey.entry.name}: {count} maneuver{'' if count == 1 else 's'}",
        ("id", *numbers[:2], "inputs", "kind", *numbers[2:], "grade"),
        right=numbers,
    )
    for one in found.maneuvers:
        table.add_row(
            one.id,
            f"{one.t_start:z.2f}",
            f"{one.t_end:z.2f}",
            "+".join(one.inputs) or "none",
            one.kind,
            f"{_shown(one.amplitude, 0.01)} %"
            if one.inputs == ("throttle",)
            else _shown(one.amplitude, DEGREE),
            _shown(one.V, to_si(1.0, speed, "speed")),
            _shown(one.alpha, DEGREE),
            Text.assemble(
                (one.grade, _GRADE_COLORS[one.grade]),
                " (manual)" if one.graded_by == GRADED_BY_CREW else "",
            ),
        )
    console.print_unwrapped(table)
    for one in found.maneuvers:
        if one.use is not None:
            text = "used in estimates" if one.use else "left out of estimates"
            console.print(f"{one.id}: {text}, by hand")
        if one.note:
            console.print_sentence(f"{one.id}: {one.note}")
        if one.reasons:
            console.print_sentence(f"{one.id}: {'; '.join(one.reasons)}")
    told = [
        *(f"{grade}: {text}" for grade, text in GRADES.items() if found.maneuvers),
        f"airborne detection by {found.airborne_criterion}; noise from {found.noise.source}",
    ]
    for sentence in told:
        console.print_sentence(sentence, "dim")
    for sentence in survey.remarks:
        console.print_sentence(sentence, "yellow")


def _shown(value: float | None, unit: float) -> str:
    return "" if value is None else f"{value / unit:z.1f}"


def print_card_status(
    console: PlainConsole, flight: Path, maneuvers: Sequence[DetectedManeuver]
) -> None:
    """Print how the test cards kept with a flight stand; nothing where it has none.

    Raises
    ------
    FileProblemsError
        If the cards hold mistakes.
    """
    from rich.text import Text

    from gsapp.flight.cards import match_cards
    from gsapp.flight.folder import FlightFolder

    cards = FlightFolder(path=flight).cards() if flight.is_dir() else None
    if cards is None:
        return
    flown = match_cards(cards, maneuvers)
    title = f"test cards {cards.name}".rstrip()
    table = console.create_table(title, ("card", "what", "flown", "state"))
    for one in flown.cards:
        table.add_row(
            one.card.id,
            one.card.display_title,
            f"{one.good_count} of {one.card.repeats}",
            Text(one.state, _CARD_COLORS[one.state]),
        )
    console.print_unwrapped(table)
    remarks = [
        f"{one.card.id}: maneuver {attempt.maneuver.id} not counted: {'; '.join(attempt.reasons)}"
        for one in flown.cards
        for attempt in one.attempts
        if not attempt.is_counted
    ]
    if flown.unplanned:
        remarks.append(f"not on a card: {', '.join(one.id for one in flown.unplanned)}")
    for sentence in remarks:
        console.print_sentence(sentence)
