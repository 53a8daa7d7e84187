"""``gsapp replay``: a recorded flight on the road of a live one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, FlightPath, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.decoding.health import LinkReport
    from gsapp.session.session import Session

_MOST_ALARMS = 20


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def replay(
    flight: FlightPath,
    speed: Annotated[
        str | None,
        typer.Option(metavar="X|max", help="Times real time; 1 in the window, max headless"),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Print a summary instead")] = False,
    search: Annotated[
        bool,
        typer.Option(
            "--search",
            help="Search for a missing effect after each maneuver; the JSON tells what was found "
            "when; headless",
        ),
    ] = False,
    share: Annotated[
        str | None,
        typer.Option(
            metavar="http:HOST:PORT",
            help="Show the pilot's page and strips in browsers; headless, at speed 1. A flight "
            "that is being recorded is followed to its end",
        ),
    ] = None,
    share_open: Annotated[
        bool, typer.Option("--share-open", help="Other computers need no key for the page")
    ] = False,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Replay a flight in the window, or sum it up without one.

    Without a window it goes as fast as it can.

    Example: gsapp replay flights/2026-05-12-a --headless --json summary.json
    """
    from gsapp.cli._console import PlainConsole, is_stdout
    from gsapp.cli._flight_text import print_aircraft_warnings
    from gsapp.cli._usage_errors import CommandUsageError, as_usage_error
    from gsapp.session.feeds import parse_speed

    in_window = not headless and json is None
    speed = speed or ("1" if in_window or share is not None else "max")
    with as_usage_error():
        times = parse_speed(speed)
    if share is not None and in_window:
        raise CommandUsageError("--share needs --headless; the window shares by its REC tile")
    if in_window:
        from gsapp.flight.flight_loader import check_flight_exists
        from ui.app import run_window

        check_flight_exists(flight)
        raise typer.Exit(
            run_window(flight=flight, speed=speed, channel_map=channel_map, calibration=calibration)
        )
    from rich.progress import TaskProgressColumn, TimeRemainingColumn

    from gsapp.session.live_estimation.fit_workers import InlineFitWorker
    from gsapp.session.live_estimation.live_search import run_search_request
    from gsapp.session.replay_runner import follow_recording, run_replay
    from gsapp.session.session import Session
    from gsapp.telemetry.recorder_control import find_recorder

    console = PlainConsole(stderr=is_stdout(json))
    is_live = share is not None and flight.is_dir() and find_recorder(flight) is not None
    workers = InlineFitWorker()
    search_worker = InlineFitWorker(run_search_request) if search else None
    session = (
        Session.follow(
            flight, channel_map=channel_map, certificates=calibration, workers=workers,
            search_worker=search_worker,
        )
        if is_live
        else Session.replay(
            flight, channel_map=channel_map, certificates=calibration, speed=times,
            workers=workers, search_worker=search_worker,
        )
    )  # fmt: skip
    try:
        print_aircraft_warnings(console, [session.aircraft])
        with _shared_page(session, share, share_open, console) as publish:
            if is_live:
                follow_recording(session, publish)
            else:
                with console.progress(TaskProgressColumn(), TimeRemainingColumn()) as progress:
                    task = progress.add_task(f"replaying {session.name}", total=1.0)

                    def tell(done: float) -> None:
                        progress.update(task, completed=done)
                        publish()

                    run_replay(session, tell)
        print_summary(session, console, json)
    finally:
        session.close()


@contextmanager
def _shared_page(
    session: Session, link: str | None, is_open: bool, console: PlainConsole
) -> Iterator[Callable[[], None]]:
    """Serve the page of a session; yields what is to be called again and again meanwhile."""
    if link is None:
        yield lambda: None
        return
    # The only command that shows what the window shows.
    from ui.web_page.page_frame import PageFrameBuilder
    from ui.web_page.page_publisher import PagePublisher
    from ui.web_page.page_server import PageServer

    session.crew_cues.set_units(DISPLAY_UNITS.get())
    builder = PageFrameBuilder(lambda: session, units=DISPLAY_UNITS.get)
    server = PageServer(link, is_open=is_open)
    try:
        console.print(f"Page for browsers: {server.url}", soft_wrap=True)
        yield PagePublisher(server, builder).publish_due
    finally:
        server.close()


def print_summary(session: Session, console: PlainConsole, json: Path | None) -> None:
    """Print what a replay that has ended showed, and write it for programs."""
    from gsapp.cli._console import is_stdout, write_json
    from gsapp.cli._flight_text import print_flight
    from gsapp.cli.debrief import print_cues

    whole = session.flight()
    debrief = session.crew_cues.debrief()
    if json is not None:
        write_json(json, summary_json(session))
    if not is_stdout(json):
        print_flight(console, whole)
        _print_alarms(session, console)
        if debrief is not None:
            print_cues(console, debrief)
        if json is not None:
            console.print(f"written to {json}", soft_wrap=True)


def summary_json(session: Session) -> dict[str, Any]:
    """Return what a replay that has ended showed, for programs; see `summarize`.

    Among ``events`` are the alarms: kind ``alarm``, a sentence, the key, the severity, onset and
    end (s; the end is null where the cause stayed), and whether the crew acknowledged it.
    ``cues`` are all changes of what the crew was told, and the spoken words, by time;
    ``verdicts`` those on its inputs; ``estimates`` the derivatives that it gave, by FTR and by
    maximum likelihood maneuver by maneuver; ``searches`` what each search for a missing effect
    gave, where they were asked for. ``flown`` is the MAVLink system that the channels come
    from, and whether somebody chose it; null for lines of text. ``senders`` and ``messages`` tell
    what came over the link: frames lost, doubled and late by sender; frames, frames per second of
    the whole record, and the delay of the last one (s, over the quickest of the last minutes) by
    message.
    """
    from gsapp.flight.events import sort_events
    from gsapp.flight.summary import events_json, summarize_flight
    from gsapp.session.alarm_log import alarm_events

    whole = session.flight()
    summary = summarize_flight(whole, session.aircraft)
    summary["events"] = events_json(
        sort_events((*whole.events, *alarm_events(session.alarm_registry)))
    )
    summary |= _link_json(session.link_report(), whole.duration)
    debrief = session.crew_cues.debrief()
    if debrief is not None:
        summary["cues"] = debrief.cues_json()
        summary["verdicts"] = [one.to_json() for one in debrief.maneuvers]
    if session.estimates is not None:
        summary["estimates"] = session.estimates.to_json()
        if session.estimates.search is not None:
            summary["searches"] = session.estimates.search.to_json()
    return summary


def _link_json(report: LinkReport | None, duration: float) -> dict[str, Any]:
    """Return what came over the link by sender and by message; empty lists where it was none."""
    senders = () if report is None else report.senders
    messages = () if report is None else report.messages
    return {
        "flown": None
        if report is None or report.system is None
        else {
            "system": report.system,
            "component": None if report.flown is None else report.flown.component,
            "address": "" if report.flown is None else report.flown.address,
            "chosen": report.is_system_selected,
        },
        "senders": [
            {
                "system": one.system, "component": one.component, "good": one.good,
                "unknown": one.unknown, "lost": one.lost, "duplicates": one.duplicates,
                "reordered": one.reordered,
            }
            for one in senders
        ],
        "rejected": [
            {
                "system": one.system, "address": one.address, "reason": one.reason,
                "count": one.count,
            }
            for one in (() if report is None else report.rejected)
        ],
        "messages": [
            {
                "system": one.system, "component": one.component, "name": one.name,
                "count": one.count, "rate": one.count / duration if duration > 0.0 else None,
                "delay": one.delay,
            }
            for one in messages
        ],
    }  # fmt: skip


def _print_alarms(session: Session, console: PlainConsole) -> None:
    alarms = session.alarm_registry.episodes
    if not alarms:
        return
    console.print(f"{len(alarms)} alarm{'' if len(alarms) == 1 else 's'}")
    for one in alarms[:_MOST_ALARMS]:
        when = "" if one.onset is None else f"{one.onset:9.2f} s  "
        console.print_sentence(
            f"{when}{one.severity.name.lower():8} {one.message_text(DISPLAY_UNITS.get())}"
        )
    if len(alarms) > _MOST_ALARMS:
        console.print(f"and {len(alarms) - _MOST_ALARMS} more")
