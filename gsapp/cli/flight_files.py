"""Commands on the files of a flight: import, on-board log, export."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FileUnits, FlightPath, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.flight import Flight
    from gsapp.telemetry.log_download import DownloadState, LogEntry

_NO_LOG = "This flight has no on-board log; give one with --log or fetch it with --link."


@takes_settings(MANEUVER_SETTINGS, "channel_map")
def import_(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE",
            readable=False,
            help=".tlog, .bin, .log, .ulg, .csv, .asc, .mat or .parquet",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            readable=False,
            metavar="FLIGHT",
            help="Flight folder to write; of several files, the folder for their flight folders",
        ),
    ],
    on: On = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    channel_map: str | None = None,
) -> None:
    """Make flight folders from the logs of another program.

    Of several files each becomes a flight folder of its name. A .mat file with a structure or
    matrix for each of several flights becomes a folder of flight folders.

    Example: gsapp import 00000042.BIN --map ardupilot-log --out flights/other

    Example: gsapp import logs/*.BIN --map ardupilot-log --out flights --on local
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_flight, print_flights
    from gsapp.flight.flight_import import import_flight, import_flights
    from gsapp.flight.summary import summarize_flight

    console = PlainConsole(stderr=is_stdout(json))
    if len(files) > 1:
        _import_each(console, files, out, channel_map, on, json)
        return
    (file,) = files
    with console.status(f"reading {file.name}"):
        several, remarks = import_flights(file, out, channel_map=channel_map)
        flight = import_flight(file, out, channel_map=channel_map) if not several else several[0]
    if several:
        if not is_stdout(json):
            print_flights(console, several, remarks)
            console.print(f"written to {out}", soft_wrap=True)
        flights = [{"flight": str(one.path), **summarize_flight(one)} for one in several]
        write_json(json, {"flights": flights, "remarks": list(remarks)})
        return
    if not is_stdout(json):
        print_flight(console, flight)
        console.print(f"written to {out}", soft_wrap=True)
    write_json(json, {"flight": str(out), **summarize_flight(flight)})


_Imported = list[dict[str, Any]] | str
"""What a program reads of the flights of a file; why it could not be imported, in words."""


def _import_each(
    console: PlainConsole,
    files: Sequence[Path],
    out: Path,
    channel_map: str | None,
    on: str | None,
    json: Path | None,
) -> None:
    """Make a flight folder of each file in a folder; those that fail are named."""
    from gsapp.cli._console import is_stdout, write_json
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.foundation import FlightError
    from gsapp.foundation.executors import WorkerLostError, map_tasks

    names = [file.stem for file in files]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise CommandUsageError(
            f"two files are called '{twice}', and would have one folder; import them separately"
        )
    if out.exists() and not out.is_dir():
        raise FlightError(f"{out} is a file; name a folder for the flights")
    with open_workers(on) as pool, console.status("reading") as status:

        def paths() -> Iterator[Path]:
            for number, file in enumerate(files, start=1):
                status.update(f"reading {file.name} ({number} of {len(files)})")
                yield file

        found = map_tasks(pool, partial(_import_one, out, channel_map), paths())
        results = [str(one) if isinstance(one, WorkerLostError) else one for one in found]
    table = console.create_table("", ("flight", "s", "channels"), right=("s",))
    content: list[dict[str, Any]] = []
    for file, result in zip(files, results, strict=True):
        own = [{"file": str(file), "failure": result}] if isinstance(result, str) else result
        content += own
        for one in () if isinstance(result, str) else own:
            table.add_row(one["flight"], f"{one['duration']:z.1f}", ", ".join(one["channels"]))
    if not is_stdout(json):
        console.print(table)
    failed = [(file, one) for file, one in zip(files, results, strict=True) if isinstance(one, str)]
    for file, text in failed:
        console.print_sentence(f"{file.name}: {text}", "bold red")
    write_json(json, {"flights": content, "remarks": []})
    if failed:
        raise FlightError(f"{len(failed)} of {len(files)} files could not be imported")


def _import_one(out: Path, channel_map: str | None, file: Path) -> _Imported:
    from gsapp.flight.flight_import import import_flight, import_flights
    from gsapp.flight.summary import summarize_flight
    from gsapp.foundation import GroundStationError

    place = out / file.stem
    try:
        several, _ = import_flights(file, place, channel_map=channel_map)
        flights = several or (import_flight(file, place, channel_map=channel_map),)
        return [{"flight": str(one.path), **summarize_flight(one)} for one in flights]
    except GroundStationError as error:
        return str(error)


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration", "aircraft")
def export(
    flight: FlightPath,
    to: Annotated[
        Literal["csv", "mat", "parquet", "sidpac"],
        typer.Option(help="Format; sidpac: .mat with the array fdata of SIDPAC"),
    ],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="File to write")],
    units: FileUnits = "us",
    native: Annotated[
        bool, typer.Option("--native", help="Every sample at its own time, none resampled")
    ] = False,
    raw: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIELD", help="Also this field of the record: ATT.DesRoll, NKF1.*; repeat"
        ),
    ] = None,
    json: JsonFile = None,
    channel_map: str | None = None,
    calibration: str | None = None,
    aircraft: str | None = None,
) -> None:
    """Write a flight for other programs.

    With --native a row is written for each time at which any channel has a sample; cells of the
    others are empty.

    Example: gsapp export flights/2026-05-12-a --to csv --native --raw "NKF1.*" --out raw.csv

    Example: gsapp export flights/2026-05-12-a --to mat --out flight.mat

    Example: gsapp export flights/2026-05-12-a --to sidpac --out fdata.mat
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_flight
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight.flight_export import SIDPAC, check_export, export_flight
    from gsapp.flight.flight_loader import load_flight
    from gsapp.flight.summary import summarize_flight
    from gsapp.flight.writers import ColumnUnits

    with as_usage_error():
        check_export(out, to, units)
    console = PlainConsole(stderr=is_stdout(json))
    with console.status(f"reading {flight.name}"):
        loaded = load_flight(
            flight,
            channel_map=channel_map,
            certificates=calibration,
            aircraft=aircraft,
            raw=raw or (),
            native=native,
        )
    with console.status(f"writing {out.name}"):
        export_flight(loaded, out, to, units, aircraft)
    if not is_stdout(json):
        print_flight(console, loaded)
        console.print(f"written to {out}", soft_wrap=True)
    if json is not None:
        channels = () if to == SIDPAC else loaded.block.channels
        layout = ColumnUnits.from_channels(channels, units)
        written = {
            "file": str(out),
            "format": to,
            "rows": len(loaded.block),
            "units": {"time": "s", **dict(zip(layout.channels, layout.units, strict=True))},
        }
        write_json(json, {**written, **summarize_flight(loaded)})


def onboard(
    flight: Annotated[Path, typer.Argument(metavar="FLIGHT", readable=False, help="Its folder")],
    log: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="Use this on-board log: .tlog, .bin, .log, .ulg, .csv, .mat or .parquet",
        ),
    ] = None,
    link: Annotated[
        str | None,
        typer.Option(
            metavar="LINK", help="Download the log from the autopilot, landed and disarmed"
        ),
    ] = None,
    fetch: Annotated[
        bool, typer.Option("--fetch", help="Download over the link that records FLIGHT")
    ] = False,
    signing_key: Annotated[
        str, typer.Option(metavar="FILE", help="MAVLink signing key, for --link")
    ] = "",
    number: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=0,
            help="Log number on the autopilot; default: by the date of the flight",
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the autopilot's logs only")] = False,
    use: Annotated[
        str | None, typer.Option(metavar="NAME|none", help="Use a log in the folder, or none")
    ] = None,
    json: JsonFile = None,
) -> None:
    """Let the on-board log replace what came over the radio.

    Without options, shows which log is in force.

    The log is aligned with the live record (offset and drift of its clock) and refused where the
    two do not match. Flight time, marks, grades and edges of maneuvers do not change. An
    interrupted fetch resumes. The former log stays in the folder.

    Example: gsapp onboard flights/2026-05-12-a --log /media/card/00000017.BIN

    Example: gsapp onboard flights/2026-05-12-a --link serial:/dev/ttyACM0:115200

    Example: gsapp onboard flights/2026-05-12-a --use none
    """
    from gsapp.cli._console import PlainConsole, is_stdout
    from gsapp.flight.flight_loader import load_flight
    from gsapp.flight.folder import FlightFolder
    from gsapp.flight.onboard_log.log_storage import activate_log, install_log

    chosen = [log is not None, link is not None or fetch, use is not None]
    if sum(chosen) > 1:
        raise typer.BadParameter("give one of --log, --link or --fetch, --use")
    if signing_key and link is None:
        raise typer.BadParameter("--signing-key goes with --link")
    if (number is not None or list_) and not chosen[1]:
        raise typer.BadParameter("--number and --list go with --link or --fetch")
    console = PlainConsole(stderr=is_stdout(json))
    if chosen[1]:
        _fetch_log(console, flight, link or "", signing_key, number, list_, json)
        return
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


def _fetch_log(
    console: PlainConsole,
    flight: Path,
    link: str,
    signing_key: str,
    number: int | None,
    listing: bool,
    json: Path | None,
) -> None:
    """Fetch the log from the autopilot and put it in force; what came is kept for the next time."""
    from gsapp.cli._console import write_json
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight.onboard_log.log_storage import install_log
    from gsapp.telemetry.log_download import LogFetcher, parse_log_link

    if link:
        with as_usage_error():
            parse_log_link(link)
    with (
        _download_progress(console) as tell,
        LogFetcher(flight, link, signing_key=signing_key, tell=tell) as fetcher,
    ):
        if listing:
            entries = fetcher.list_logs()
            fetched = None
        else:
            entry = fetcher.select(number)
            fetched = fetcher.fetch(entry) if entry is not None else None
    if listing:
        _list(console, entries)
        write_json(
            json,
            [
                {"number": one.id, "size": one.size, "begun": one.time_utc or None}
                for one in entries
            ],
        )
        return
    if fetched is None:
        return
    with console.status("comparing it with the live record"):
        placed = install_log(flight, fetched.path, begun=fetched.start_time)
    fetched.path.unlink(missing_ok=True)
    _print_status(console, placed.flight, placed.previous_name, placed.remark, json)


@contextmanager
def _download_progress(console: PlainConsole) -> Iterator[Callable[[DownloadState], None]]:
    from rich.progress import DownloadColumn, TimeRemainingColumn, TransferSpeedColumn

    with console.progress(DownloadColumn(), TransferSpeedColumn(), TimeRemainingColumn()) as bar:
        task = bar.add_task("listening", total=None)

        def tell(state: DownloadState) -> None:
            bar.update(
                task,
                description=state.phase,
                total=state.size or None,
                completed=state.received_bytes,
            )

        yield tell


def _print_status(
    console: PlainConsole, flight: Flight, former: str | None, remark: str, json: Path | None
) -> None:
    from gsapp.cli._console import is_stdout, write_json
    from gsapp.flight.folder import FlightFolder
    from gsapp.flight.onboard_log.log_storage import list_logs

    def say(text: str) -> None:
        console.print(text, soft_wrap=True)

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
    write_json(
        json,
        {
            "flight": str(flight.path),
            "onboard": state.to_json() if state is not None else None,
            "former": former,
            "logs": list(logs),
            "remark": remark,
        },
    )


def _list(console: PlainConsole, entries: tuple[LogEntry, ...]) -> None:
    from datetime import UTC, datetime

    for entry in entries:
        begun = (
            f"{datetime.fromtimestamp(entry.time_utc, UTC):%Y-%m-%d %H:%M} UTC"
            if entry.time_utc
            else "at an unknown time"
        )
        console.print(f"log {entry.id}: {entry.size / 1e6:.2f} MB, begun {begun}")
    if not entries:
        console.print("The autopilot holds no log.")
