"""``gsapp onboard``: the on-board log in the place of the live record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.flight import Flight
    from gsapp.telemetry.log_download import DownloadState, LogEntry

_NO_LOG = "This flight has no on-board log; give one with --log or fetch it with --link."


def run(
    *, flight: Path, log: Path | None = None, use: str | None = None, json: Path | None = None
) -> None:
    """Put a log in force, take it out, or tell how it stands.

    Parameters
    ----------
    flight : Path
        A flight folder.
    log : Path, optional
        Put this file in force.
    use : str, optional
        Put a log of the folder in force; ``none`` takes it out.
    json : Path, optional
        Where to write for programs; ``-`` for the screen.

    Raises
    ------
    GroundStationError
        If the log does not belong to the flight, or something cannot be read or written.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._json_output import is_stdout
    from gsapp.flight.flight_loader import load_flight
    from gsapp.flight.folder import FlightFolder
    from gsapp.flight.onboard_log.log_storage import activate_log, install_log

    console = PlainConsole(stderr=is_stdout(json))
    former, remark = None, ""
    with console.status(f"reading {flight}"):
        if log is not None:
            placed = install_log(flight, log)
            opened, former, remark = placed.flight, placed.previous_name, placed.remark
        elif use is not None:
            opened = activate_log(flight, "" if use == "none" else use)
        else:
            opened = load_flight(FlightFolder.open(flight).path)
    _print_status(console, opened, former, remark, json)


def fetch(
    *, flight: Path, link: str, number: int | None, listing: bool, json: Path | None = None
) -> None:
    """Fetch the log from the autopilot and put it in force.

    Parameters
    ----------
    flight : Path
        A flight folder.
    link : str
        The LINK; empty for the one that records into the flight.
    number : int, optional
        Of the log; by default the one begun nearest the flight.
    listing : bool
        Whether to list the logs only.
    json : Path, optional
        As for `run`.

    Raises
    ------
    GroundStationError
        If nothing answers, what came is no log of the flight, or it cannot be kept.
    KeyboardInterrupt
        If it was broken off; what came is kept for the next time.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight.onboard_log.log_storage import install_log
    from gsapp.telemetry.log_download import LogFetcher, parse_log_link

    console = PlainConsole(stderr=is_stdout(json))
    if link:
        with as_usage_error():
            parse_log_link(link)
    with _shown(console) as tell, LogFetcher(flight, link, tell=tell) as fetcher:
        if listing:
            entries = fetcher.list_logs()
            fetched = None
        else:
            entry = fetcher.select(number)
            fetched = fetcher.fetch(entry) if entry is not None else None
    if listing:
        _list(console, entries)
        if json is not None:
            write_json(json, format_json([_entry_json(entry) for entry in entries]))
        return
    if fetched is None:
        return
    with console.status("comparing it with the live record"):
        placed = install_log(flight, fetched.path, begun=fetched.start_time)
    fetched.path.unlink(missing_ok=True)
    _print_status(console, placed.flight, placed.previous_name, placed.remark, json)


def _shown(console: Console) -> Any:
    import contextlib

    from rich.progress import (
        BarColumn,
        DownloadColumn,
        Progress,
        TimeRemainingColumn,
        TransferSpeedColumn,
    )

    from gsapp.cli._console import description_column

    @contextlib.contextmanager
    def shown() -> Any:
        with Progress(
            description_column(), BarColumn(), DownloadColumn(),
            TransferSpeedColumn(), TimeRemainingColumn(), console=console, transient=True,
        ) as bar:  # fmt: skip
            task = bar.add_task("listening", total=None)

            def tell(state: DownloadState) -> None:
                bar.update(
                    task,
                    description=state.phase,
                    total=state.size or None,
                    completed=state.received_bytes,
                )

            yield tell

    return shown()


def _print_status(
    console: Console, flight: Flight, former: str | None, remark: str, json: Path | None
) -> None:
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.flight.folder import FlightFolder
    from gsapp.flight.onboard_log.log_storage import list_logs

    def say(words: str) -> None:
        console.print(words, highlight=False, soft_wrap=True)

    logs = list_logs(FlightFolder.open(flight.path))
    state = flight.onboard
    if not is_stdout(json):
        said = state.remark() if state is not None else _NO_LOG
        say(f"{flight.name}: {said}")
        if remark:
            say(remark)
        if former is not None and (state is None or former != state.file):
            say(f"To go back: gsapp onboard {flight.path} --use {former or 'none'}")
        others = [name for name in logs if state is None or name != state.file]
        if others and former is None:
            say(f"Also in the folder, not in use: {', '.join(others)}")
    if json is not None:
        write_json(
            json,
            format_json(
                {
                    "flight": str(flight.path),
                    "onboard": state.to_json() if state is not None else None,
                    "former": former,
                    "logs": list(logs),
                    "remark": remark,
                }
            ),
        )


def _list(console: Console, entries: tuple[LogEntry, ...]) -> None:
    from datetime import UTC, datetime

    for entry in entries:
        begun = (
            f"{datetime.fromtimestamp(entry.time_utc, UTC):%Y-%m-%d %H:%M} UTC"
            if entry.time_utc
            else "at an unknown time"
        )
        console.print(f"log {entry.id}: {entry.size / 1e6:.2f} MB, begun {begun}", highlight=False)
    if not entries:
        console.print("The autopilot holds no log.")


def _entry_json(entry: LogEntry) -> dict[str, Any]:
    return {"number": entry.id, "size": entry.size, "begun": entry.time_utc or None}
