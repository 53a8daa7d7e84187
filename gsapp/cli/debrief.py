"""``gsapp debrief``: what each input of a flight was worth, and what becomes better."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief, FlightTrend
    from gsapp.flight.catalog import Catalog
    from gsapp.session import Session


def run(
    *,
    flights: Sequence[Path],
    aircraft: str | None = None,
    model: str | None = None,
    channel_map: str | None = None,
    calibration: str | None = None,
    cards: str | None = None,
    catalog: Path | None = None,
    json: Path | None = None,
) -> None:
    """Judge recorded flights as they would have been judged in flight; tell trends.

    Parameters
    ----------
    flights : sequence of Path
        Folders or files; none for those that the catalog holds.
    aircraft, model : str, optional
        Names or paths; by default the flight's own aircraft, else ``b777``, and the model
        shipped for it.
    channel_map : str, optional
        Name or path.
    calibration : str, optional
        Certificates in place of those kept with the flight: a folder, or a shipped set.
    cards : str, optional
        Test cards in place of the flight's own: a file, or the name of a shipped set.
    catalog : Path, optional
        Where the debriefs are kept, and whose flights make the trends.
    json : Path, optional
        Where to write the result for programs; ``-`` for the screen.

    Raises
    ------
    GroundStationError
        If a flight cannot be read, a file cannot be written, or there is nothing to debrief.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._debrief_text import print_debrief, print_trends
    from gsapp.cli._flight_text import check_catalog, check_is_catalog
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.excitation.debrief import compute_flight_trend
    from gsapp.flight.catalog import Catalog

    if not flights and catalog is None:
        raise CommandUsageError("nothing to debrief; name a flight, or a --catalog")
    if not flights and catalog is not None:
        check_is_catalog(catalog, "name a flight, or a catalog with flights")
    console = PlainConsole(stderr=is_stdout(json))
    check_catalog(catalog, calibration)
    debriefs: list[Debrief] = []
    for path in flights:
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
    if json is not None:
        result = {
            "flights": [one.to_json() for one in debriefs],
            "trends": [one.to_json() for one in found],
        }
        write_json(json, format_json(result))
    if not is_stdout(json):
        for one in debriefs:
            print_debrief(console, one)
        if len(found) > 1 or not debriefs:
            print_trends(console, found)
        for written in (json, catalog if flights else None):
            if written is not None:
                console.print(f"written to {written}", highlight=False, soft_wrap=True)


def replay_to_end(
    path: Path,
    aircraft: str | None,
    model: str | None,
    channel_map: str | None,
    calibration: str | None,
    cards: str | None,
) -> Session:
    """Replay a flight to its end."""
    from gsapp.flight.read_settings import DEFAULT_AIRCRAFT, FlightReadSettings
    from gsapp.session import UNLIMITED_SPEED, Session
    from gsapp.session.replay_runner import run_replay

    flown = FlightReadSettings.load(path, aircraft=aircraft).aircraft
    session = Session.replay(
        path, speed=UNLIMITED_SPEED, channel_map=channel_map, certificates=calibration,
        aircraft=flown or DEFAULT_AIRCRAFT, model=model, cards=cards,
    )  # fmt: skip
    try:
        run_replay(session)
    except BaseException:
        session.close()
        raise
    return session


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
