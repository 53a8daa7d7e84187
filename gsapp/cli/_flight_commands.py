"""Commands on one flight: fly it, record it, show it, take it in and give it out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gsapp.cli._options import CalibrationName, FileUnits, FlightPath, JsonFile, MapName, Units


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


def fly(
    to: Annotated[
        str | None,
        typer.Option(metavar="LINK", help="Transmit over this link"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FLIGHT", help="Write a flight folder at full speed"),
    ] = None,
    plan: Annotated[
        str, typer.Option(metavar="FILE", help="Plan: a file, or the name of a shipped one")
    ] = ("default"),
    hide: Annotated[
        list[str] | None,
        typer.Option(metavar="ID[:PARAM=VALUE,..]", help="Add a hidden effect; repeatable"),
    ] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL:KIND[:PARAM=VALUE,..]",
            help="Instrument fault: dropout, stuck or clip; on the bench dead, reversed, "
            "swapped:with=CHANNEL, noisy or clipped; repeatable",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same flight")] = 0,
    speed: Annotated[float, typer.Option(metavar="X", help="Times real time")] = 1.0,
    thin: Annotated[
        bool, typer.Option("--thin", help="Limit the data to a 57,600-baud radio")
    ] = False,
    aircraft: Annotated[
        str, typer.Option(metavar="FILE", help="Aircraft: a file, or the name of a shipped one")
    ] = "b777",
    model: Annotated[
        str, typer.Option(metavar="FILE", help="Model: a file, or the name of a shipped one")
    ] = "b777",
    turbulence: Annotated[
        float | None,
        typer.Option(metavar="M/S", min=0.0, help="Standard deviation of the gusts"),
    ] = None,
    attitude: Annotated[bool, typer.Option(help="Send attitude")] = True,
    position: Annotated[bool, typer.Option(help="Send position")] = False,
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
    airborne: Annotated[
        bool, typer.Option("--airborne", help="With --sticks, begin in the air, in the pattern")
    ] = False,
    json: JsonFile = None,
) -> None:
    """Fly the virtual aircraft, or calibrate it on the ground.

    Example: gsapp fly --to udpout:127.0.0.1:14550 --plan short

    Example: gsapp fly --to udpout:127.0.0.1:14550 --sticks --airborne --turbulence 0.3

    Example: gsapp fly --bench --to udpout:127.0.0.1:14550 --control - --fault rudder:reversed
    """
    if bench:
        if to is None or out is not None:
            raise typer.BadParameter("the bench sends over a link; give --to LINK, no --out")
        given = {
            "--plan": plan != "default", "--hide": hide, "--model": model != "b777",
            "--turbulence": turbulence is not None, "--position": position,
            "--onboard": onboard is not None, "--truth": truth is not None,
            "--sticks": sticks, "--airborne": airborne, "--json": json is not None,
        }  # fmt: skip
        if needless := [option for option, is_given in given.items() if is_given]:
            raise typer.BadParameter(f"the bench does not fly; leave out {', '.join(needless)}")
        from gsapp.cli import fly_bench as on_the_ground

        on_the_ground.run(
            to=to, seed=seed, faults=tuple(fault or ()), speed=speed, thin=thin,
            aircraft=aircraft, control=control,
        )  # fmt: skip
        return
    if (to is None) == (out is None):
        raise typer.BadParameter("give either --to LINK or --out FLIGHT")
    if control is not None:
        raise typer.BadParameter("--control belongs to --bench")
    if onboard is not None and (to is None or not thin):
        raise typer.BadParameter(
            "--onboard belongs to --thin --to LINK; the folder of --out holds its record itself"
        )
    if sticks and (to is None or onboard is not None):
        raise typer.BadParameter("--sticks fly over a link; give --to LINK, no --onboard")
    if airborne and not sticks:
        raise typer.BadParameter("--airborne belongs to --sticks")
    from gsapp.cli import fly as command

    command.run(
        to=to, out=out, plan=plan, hide=tuple(hide or ()), faults=tuple(fault or ()),
        seed=seed, speed=speed, thin=thin, aircraft=aircraft, model=model,
        turbulence=turbulence, attitude=attitude, position=position, onboard=onboard, truth=truth,
        sticks=sticks, airborne=airborne, json=json,
    )  # fmt: skip


def record(
    link: Annotated[str, typer.Argument(metavar="LINK")],
    out: Annotated[
        Path, typer.Option(readable=False, metavar="FLIGHT", help="Flight folder to write")
    ],
    channel_map: MapName = None,
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
) -> None:
    """Record all that comes over a link, until Ctrl-C.

    LINK is one of {links}.

    Example: gsapp record serial:/dev/ttyUSB0:57600 --map b777-thin --out flights/2026-05-12-a
    """
    from gsapp.cli import record as command

    command.run(
        link=link, out=out, channel_map=channel_map, aircraft=aircraft, calibration=calibration,
        heartbeat=heartbeat, speed=speed, append=append, json=json,
    )  # fmt: skip


def replay(
    flight: FlightPath,
    speed: Annotated[
        str | None,
        typer.Option(metavar="X|max", help="Times real time; 1 in the window, max headless"),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Print a summary instead")] = False,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    channel_map: MapName = None,
    calibration: CalibrationName = None,
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

        raise typer.Exit(
            run_window(
                flight=flight, speed=speed or "1", channel_map=channel_map, calibration=calibration
            )
        )
    from gsapp.cli import replay as command

    command.run(
        flight=flight,
        speed=speed or "max",
        json=json,
        channel_map=channel_map,
        calibration=calibration,
    )


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
    channel_map: MapName = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
) -> None:
    """Make a flight folder from the log of another program.

    Example: gsapp import 00000042.BIN --map ardupilot-log --out flights/other
    """
    from gsapp.cli import import_ as command

    command.run(file=file, channel_map=channel_map, out=out, json=json)


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


def export(
    flight: FlightPath,
    to: Annotated[Literal["csv", "mat", "parquet"], typer.Option(help="Format")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="File to write")],
    channel_map: MapName = None,
    calibration: CalibrationName = None,
    units: FileUnits = "us",
    json: JsonFile = None,
) -> None:
    """Write a flight for other programs.

    Example: gsapp export flights/2026-05-12-a --to mat --out flight.mat
    """
    from gsapp.cli import export as command

    command.run(
        flight=flight,
        to=to,
        out=out,
        channel_map=channel_map,
        calibration=calibration,
        units=units,
        json=json,
    )
