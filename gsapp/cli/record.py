"""``gsapp record LINK --out FLIGHT``: record until interrupted."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import takes_settings
from gsapp.cli._options import JsonFile

if TYPE_CHECKING:
    from gsapp.telemetry.recorder_status import RecorderStatus

_FIRST_DIAGNOSIS = 5.0
"""Seconds without anything useful before it is said what is wrong with the link."""


@takes_settings("gsapp.telemetry.recording_settings:RecordingSettings")
def record(
    link: Annotated[str, typer.Argument(metavar="LINK")],
    out: Annotated[
        Path, typer.Option(readable=False, metavar="FLIGHT", help="Flight folder to write")
    ],
    json: JsonFile = None,
    **values: Any,
) -> None:
    """Record all that comes over a link, until Ctrl-C.

    LINK is one of {links}.

    Example: gsapp record serial:/dev/ttyUSB0:57600 --map b777-thin --out flights/2026-05-12-a
    """
    import threading

    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_aircraft_warnings
    from gsapp.cli._usage_errors import CommandUsageError, as_usage_error, check_speed
    from gsapp.foundation import GroundStationError
    from gsapp.foundation.process_control import on_termination_signal
    from gsapp.telemetry.link_registry import kind_of, parse_link
    from gsapp.telemetry.recorder_folder import (
        check_not_finished,
        record_state,
        rollback_on_failure,
    )
    from gsapp.telemetry.recorder_process import create_stop_handler, record_link
    from gsapp.telemetry.recorder_status import HEARTBEAT_END
    from gsapp.telemetry.recording_settings import RecordingSettings
    from gsapp.telemetry.stream_server import ShareRequest

    console = PlainConsole(stderr=is_stdout(json))

    def say(words: str) -> None:
        # Words that nobody reads any more must not end the record.
        with contextlib.suppress(OSError, SystemExit):
            console.print(words, soft_wrap=True)

    stop, give_up = threading.Event(), threading.Event()
    printer = _StatusPrinter(say, f"Recording {link} into {out}; Ctrl-C ends it.")
    # Before anything is made.
    with as_usage_error():
        settings = RecordingSettings(**values)
        speed = settings.speed
        check_speed(speed)
        kind = kind_of(parse_link(link))
    if speed is not None and kind.is_physical:
        raise CommandUsageError(
            f"only a flight or the virtual aircraft has a speed; leave out --speed for '{link}'"
        )
    if settings.listen_only and settings.heartbeat:
        raise CommandUsageError("--listen-only sends no heartbeat; leave out --heartbeat")
    settings = settings.with_changes(channel_map=settings.channel_map or kind.channel_map)
    _check_other_flight(link, out)
    if not settings.append:
        check_not_finished(out, "name a new folder, or append to it with --continue")
    if record_state(out) == "interrupted":
        say(f"The recorder of {out} ended unexpectedly; continuing its flight.")
    options = {} if speed is None else {"speed": speed}
    with on_termination_signal(create_stop_handler(stop, give_up)), rollback_on_failure(out):
        folder = settings.prepare_folder(out, link, tell=say)
        print_aircraft_warnings(console, [folder.aircraft()])
        status = record_link(
            link, out, heartbeat=settings.heartbeat, listen_only=settings.listen_only,
            signing_key=settings.signing_key,
            shares=ShareRequest(
                links=settings.share, is_open=settings.share_open, key_file=settings.share_key,
                takes_notes=settings.share_notes,
            ),
            stop=stop, give_up=give_up, on_status=printer.print_news, **options,
        )  # fmt: skip
    seconds = (status.updated_us - status.started_us) / 1e6
    frames, lines = status.frames - status.unwritten_frames, status.lines - status.unwritten_lines
    where = f" into {status.folder}" if status.moved_from else ""
    say(
        f"Recorded {frames} frames, {lines} lines and {status.residue_bytes} other bytes in "
        f"{seconds:.0f} s{where}."
    )
    for share in status.shares:
        dropped = f", {share.dropped_bytes} were not taken" if share.dropped_bytes else ""
        say(f"Shared {share.sent_bytes} bytes over {share.link}{dropped}.")
    if status.heartbeats:
        say(HEARTBEAT_END)
    write_json(json, status.model_dump(mode="json"))
    if status.dropped_bytes:
        raise GroundStationError(
            f"{status.unwritten_frames} of {status.frames} frames and {status.unwritten_lines} "
            f"of {status.lines} lines ({status.dropped_bytes} bytes) were not written: the disk "
            f"of {status.folder} failed or the folder was removed"
        )
    if status.moved_from:
        raise GroundStationError(
            f"{out} was removed, renamed or made read-only during the recording: {frames} of "
            f"{status.frames} frames and {lines} of {status.lines} lines reached the disk; the "
            f"flight is in {status.folder}"
        )


def _check_other_flight(link: str, out: Path) -> None:
    """Raise where a recorded flight would be played into itself, and never be what it was."""
    from gsapp.foundation import GroundStationError

    with contextlib.suppress(OSError, ValueError):
        played = Path(link)
        if out.samefile(played if played.is_dir() else played.parent) and played.exists():
            raise GroundStationError(
                f"{out} is the flight being replayed; record into another folder"
            )


class _StatusPrinter:
    """Says how the link fares whenever that changes, and everything else once."""

    def __init__(self, say: Callable[[str], None], beginning: str) -> None:
        self._say = say
        self._beginning = beginning
        self._link = ""
        self._shares: list[str] = []
        self._told: set[str] = set()
        self._problem = ""
        self._due = _FIRST_DIAGNOSIS

    def print_news(self, status: RecorderStatus) -> None:
        """Say what is new; only a link that could be opened has a status."""
        if self._beginning:
            self._say(self._beginning)
            self._beginning = ""
        if status.state == "recording" and status.source_state != self._link:
            self._link = status.source_state
            self._say(self._link)
        shares = [share.describe() for share in status.shares]
        if status.state == "recording" and shares != self._shares:
            for text in (one for one in shares if one not in self._shares):
                self._say(text)
            self._shares = shares
        self._diagnose(status)
        for sentence in (*status.notes, *status.warnings, status.error):
            # The numbers in a warning change all the time.
            key = re.sub(r"[\d.]+", "", sentence)
            if sentence and key not in self._told:
                self._told.add(key)
                self._say(sentence)

    def _diagnose(self, status: RecorderStatus) -> None:
        """Say what is wrong with a link that brings nothing useful, at growing intervals."""
        from gsapp.telemetry.link_diagnosis import diagnose_link

        seconds = (status.updated_us - status.started_us) / 1e6
        if status.state != "recording" or seconds < _FIRST_DIAGNOSIS:
            return
        found = diagnose_link(status)
        problem = "" if found is None else found.problem
        # A link that is not open says so itself, whenever that changes.
        if problem not in ("", "closed") and (problem != self._problem or seconds >= self._due):
            self._say(str(found))
            self._due = 2.0 * seconds
        self._problem = problem
