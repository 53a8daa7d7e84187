"""Commands on one flight: fly it, record it, show it, take it in and give it out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FileUnits, FlightPath, JsonFile, Units

_FLIGHT_OPTIONS = (
    "--plan", "--hide", "--model", "--turbulence", "--position", "--onboard", "--truth",
    "--sticks", "--airborne", "--json",
)  # fmt: skip
"""What the bench has no use for."""


def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Without a window")] = False,
    out: Annotated[
        Path,
        typer.Option(readable=False, metavar="DIR", help="Output folder"),
    ] = Path("demo-flight"),
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the flight")] = 1,
    speed: Annotated[
        float | None,
        typer.Option(metavar="X", help="Times real time; 1 with a window, 4 without"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Do the whole job once, on virtual flights.

    Stream, record, replay, estimate, report, review.

    Example: gsapp demo --headless --out demo-flight
    """
    from gsapp.cli import demo as command

    command.run(headless=headless, out=out, seed=seed, speed=speed, json=json)


@takes_settings("gsapp.virtual.downlink.flight_settings:FlightSettings")
def fly(
    to: Annotated[
        str | None,
        typer.Option(metavar="LINK", help="Transmit over this link"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FLIGHT", help="Write a flight folder at full speed"),
    ] = None,
    speed: Annotated[float, typer.Option(metavar="X", help="Times real time")] = 1.0,
    onboard: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="File for the full on-board record of a thin flight",
        ),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write the true motion as a Flight CSV"),
    ] = None,
    bench: Annotated[
        bool,
        typer.Option("--bench", help="Bench mode on the ground, for calibration; see --control"),
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            metavar="udpin:HOST:PORT|-",
            help="Bench commands from this port, or from standard input (-): 'elevator_left "
            "10' (deg), 'turn p 45', 'lie z_down', 'pitot covered', 'pitot blow', 'help'",
        ),
    ] = None,
    sticks: Annotated[
        bool,
        typer.Option(
            "--sticks",
            help="Fly it yourself by lines on the standard input: 'take', 'sticks PITCH ROLL YAW "
            "[THROTTLE]' (-1 to 1: pulled, right, right; throttle 0 to 1) at least every 2 s, "
            "'size 0.5', 'rate low', 'click throttle 0.05', 'give', 'land', 'help'; the built-in "
            "pilot flies whenever you do not",
        ),
    ] = False,
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Fly the virtual aircraft, or calibrate it on the ground.

    Example: gsapp fly --to udpout:127.0.0.1:14550 --plan short

    Example: gsapp fly --to udpout:127.0.0.1:14550 --sticks --airborne --turbulence 0.3

    Example: gsapp fly --bench --to udpout:127.0.0.1:14550 --control - --fault rudder:reversed
    """
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.foundation.settings import command_arguments
    from gsapp.virtual.downlink.flight_settings import FlightSettings

    with as_usage_error():
        chosen = FlightSettings(**settings)
    if bench:
        if to is None or out is not None:
            raise typer.BadParameter("the bench sends over a link; give --to LINK, no --out")
        given = {
            **dict.fromkeys(command_arguments(chosen), True), "--onboard": onboard is not None,
            "--truth": truth is not None, "--sticks": sticks, "--json": json is not None,
        }  # fmt: skip
        if needless := [one for one in _FLIGHT_OPTIONS if given.get(one)]:
            raise typer.BadParameter(f"the bench does not fly; leave out {', '.join(needless)}")
        from gsapp.cli import fly_bench as on_the_ground

        on_the_ground.run(to=to, speed=speed, control=control, settings=chosen)
        return
    if (to is None) == (out is None):
        raise typer.BadParameter("give either --to LINK or --out FLIGHT")
    if control is not None:
        raise typer.BadParameter("--control belongs to --bench")
    if onboard is not None and (to is None or not chosen.thin):
        raise typer.BadParameter(
            "--onboard belongs to --thin --to LINK; the folder of --out holds its record itself"
        )
    if sticks and (to is None or onboard is not None):
        raise typer.BadParameter("--sticks fly over a link; give --to LINK, no --onboard")
    if chosen.airborne and not sticks:
        raise typer.BadParameter("--airborne belongs to --sticks")
    from gsapp.cli import fly as command

    command.run(
        to=to, out=out, speed=speed, onboard=onboard, truth=truth, sticks=sticks, json=json,
        **settings,
    )  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "channel_map")
def record(
    link: Annotated[str, typer.Argument(metavar="LINK")],
    out: Annotated[
        Path, typer.Option(readable=False, metavar="FLIGHT", help="Flight folder to write")
    ],
    aircraft: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Aircraft: a file, or the name of a shipped one"),
    ] = None,
    calibration: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Certificates: a folder, or the name of a shipped set"),
    ] = None,
    heartbeat: Annotated[
        bool | None,
        typer.Option(help="Send a heartbeat every second; default: over udpout only"),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(metavar="X", help="Times real time, where LINK is a FLIGHT"),
    ] = None,
    append: Annotated[
        bool, typer.Option("--continue", help="Append to a flight that is already finished")
    ] = False,
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Record all that comes over a link, until Ctrl-C.

    LINK is one of {links}.

    Example: gsapp record serial:/dev/ttyUSB0:57600 --map b777-thin --out flights/2026-05-12-a
    """
    from gsapp.cli import record as command

    command.run(
        link=link, out=out, aircraft=aircraft, calibration=calibration, heartbeat=heartbeat,
        speed=speed, append=append, json=json, **settings,
    )  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def replay(
    flight: FlightPath,
    speed: Annotated[
        str | None,
        typer.Option(metavar="X|max", help="Times real time; 1 in the window, max headless"),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Print a summary instead")] = False,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Replay a flight in the window, or sum it up without one.

    Without a window it goes as fast as it can.

    Example: gsapp replay flights/2026-05-12-a --headless --json summary.json
    """
    if not headless and json is None:
        from gsapp.cli._usage_errors import as_usage_error
        from gsapp.flight.flight_loader import check_flight_exists
        from gsapp.session.feeds import parse_speed
        from ui.app import run_window

        with as_usage_error():
            parse_speed(speed or "1")
        check_flight_exists(flight)

        raise typer.Exit(run_window(flight=flight, speed=speed or "1", **settings))
    from gsapp.cli import replay as command

    command.run(flight=flight, speed=speed or "max", json=json, **settings)


@takes_settings(MANEUVER_SETTINGS, "channel_map")
def import_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", readable=False, help=".tlog, .bin, .ulg, .csv, .mat or .parquet"
        ),
    ],
    out: Annotated[
        Path, typer.Option(readable=False, metavar="FLIGHT", help="Flight folder to write")
    ],
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Make a flight folder from the log of another program.

    Example: gsapp import 00000042.BIN --map ardupilot-log --out flights/other
    """
    from gsapp.cli import import_ as command

    command.run(file=file, out=out, json=json, **settings)


def onboard(
    flight: Annotated[Path, typer.Argument(metavar="FLIGHT", readable=False, help="Its folder")],
    log: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="Use this on-board log: .tlog, .bin, .ulg, .csv, .mat or .parquet",
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
        str | None,
        typer.Option(metavar="NAME|none", help="Use a log in the folder, or none"),
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
    chosen = [log is not None, link is not None or fetch, use is not None]
    if sum(chosen) > 1:
        raise typer.BadParameter("give one of --log, --link or --fetch, --use")
    if (number is not None or list_) and not chosen[1]:
        raise typer.BadParameter("--number and --list go with --link or --fetch")
    from gsapp.cli import onboard as command

    if chosen[1]:
        command.fetch(flight=flight, link=link or "", number=number, listing=list_, json=json)
    else:
        command.run(flight=flight, log=log, use=use, json=json)


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def export(
    flight: FlightPath,
    to: Annotated[Literal["csv", "mat", "parquet"], typer.Option(help="Format")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="File to write")],
    units: FileUnits = "us",
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Write a flight for other programs.

    Example: gsapp export flights/2026-05-12-a --to mat --out flight.mat
    """
    from gsapp.cli import export as command

    command.run(flight=flight, to=to, out=out, units=units, json=json, **settings)
