"""``gsapp replay``: a recorded flight on the road of a live one."""

from __future__ import annotations

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
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.session.feeds import parse_speed

    in_window = not headless and json is None
    speed = speed or ("1" if in_window else "max")
    with as_usage_error():
        times = parse_speed(speed)
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
    from gsapp.session.replay_runner import run_replay
    from gsapp.session.session import Session

    console = PlainConsole(stderr=is_stdout(json))
    session = Session.replay(
        flight,
        channel_map=channel_map,
        certificates=calibration,
        speed=times,
        workers=InlineFitWorker(),
        search_worker=InlineFitWorker(run_search_request) if search else None,
    )
    try:
        print_aircraft_warnings(console, [session.aircraft])
        with console.progress(TaskProgressColumn(), TimeRemainingColumn()) as progress:
            task = progress.add_task(f"replaying {session.name}", total=1.0)
            run_replay(session, lambda share: progress.update(task, completed=share))
        print_summary(session, console, json)
    finally:
        session.close()


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
