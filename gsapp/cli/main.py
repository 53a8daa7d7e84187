"""The commands. Each imports what it needs when it runs, so that ``--help`` is quick."""

from __future__ import annotations

import sys
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Literal

import typer

from gsapp.cli._commands import Commands

app = Commands(
    add_completion=False,
    pretty_exceptions_enable=False,
    # Plain help is twice as quick as the colored one.
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Ground station for flight-testing remotely piloted research aircraft. "
    "Without a command it opens the window.",
)

# `readable=False`: what cannot be read is told by the command, in one sentence, with exit code 1.
FlightPath = Annotated[
    Path,
    typer.Argument(
        metavar="FLIGHT",
        readable=False,
        help="Flight folder, .csv, .tlog, .bin, .ulg, .mat, .parquet",
    ),
]
JsonFile = Annotated[
    Path | None,
    typer.Option(
        "--json",
        metavar="FILE",
        readable=False,
        help="Write the result for programs; - for the screen",
    ),
]
MapName = Annotated[
    str | None,
    typer.Option("--map", metavar="MAP", help="Channel map: a file, or the name of a shipped one"),
]
OtherCertificates = Annotated[
    str | None,
    typer.Option(
        "--calibration",
        metavar="FOLDER|NAME",
        help="Certificates in place of those kept with the flight: a folder, or a shipped set",
    ),
]


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(version("gsapp-ground-station"))
        raise typer.Exit


@app.callback(invoke_without_command=True)
def window(
    context: typer.Context,
    version: Annotated[  # noqa: ARG001  acts in its callback
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show it")
    ] = False,
) -> None:
    """Open the ground station window when no command is given."""
    if context.invoked_subcommand is None:
        from ui.app import run_window

        raise typer.Exit(run_window())


@app.command()
def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Without a window")] = False,
    out: Annotated[
        Path,
        typer.Option(readable=False, metavar="DIR", help="Where the flight and its pictures go"),
    ] = Path("demo-flight"),
    seed: Annotated[int, typer.Option(min=0, help="Another seed is another flight")] = 1,
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


@app.command()
def fly(
    to: Annotated[
        str | None,
        typer.Option(metavar="LINK", help="Send over this link, as the aircraft's box would"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="FLIGHT", help="Write a flight folder instead, without waiting"
        ),
    ] = None,
    plan: Annotated[
        str, typer.Option(metavar="FILE", help="Plan: a file, or the name of a shipped one")
    ] = ("default"),
    hide: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ID[:PARAM=VALUE,..]", help="Add an effect that the model lacks; repeatable"
        ),
    ] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL:KIND[:PARAM=VALUE,..]",
            help="Break an instrument: dropout, stuck or clip; on the bench dead, reversed, "
            "swapped:with=CHANNEL, noisy or clipped; repeatable",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same flight")] = 0,
    speed: Annotated[float, typer.Option(metavar="X", help="Times real time")] = 1.0,
    thin: Annotated[bool, typer.Option("--thin", help="Fit a 57,600-baud radio")] = False,
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
    attitude: Annotated[bool, typer.Option(help="Whether the box sends an attitude")] = True,
    position: Annotated[bool, typer.Option(help="Whether the box sends a position")] = False,
    onboard: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="FILE", help="Where a thin flight keeps its full record"
        ),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write the true motion as a Flight CSV"),
    ] = None,
    bench: Annotated[
        bool, typer.Option("--bench", help="Stay on the ground, to be calibrated; see --control")
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            metavar="udpin:HOST:PORT|-",
            help="On the bench, obey lines from this port, or as typed (-): 'elevator_left 10' "
            "(deg), 'turn p 45', 'lie z_down', 'pitot covered', 'pitot blow', 'help'",
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
        from gsapp.cli import bench as on_the_ground

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


@app.command()
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
        typer.Option(help="Send a sign of life every second; without it over udpout only"),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(metavar="X", help="Times real time, where LINK is a FLIGHT"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Record all that comes over a link, until Ctrl-C.

    LINK is one of udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT,
    serial:PATH:BAUD, text:PATH:BAUD, virtual, or a FLIGHT.

    Example: gsapp record serial:/dev/ttyUSB0:57600 --map b777-thin --out flights/2026-05-12-a
    """
    from gsapp.cli import record as command

    command.run(
        link=link, out=out, channel_map=channel_map, aircraft=aircraft, calibration=calibration,
        heartbeat=heartbeat, speed=speed, json=json,
    )  # fmt: skip


@app.command()
def replay(
    flight: FlightPath,
    speed: Annotated[
        str | None,
        typer.Option(metavar="X|max", help="Times real time; 1 in the window, max headless"),
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Print a summary instead")] = False,
    json: JsonFile = None,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
) -> None:
    """Replay a flight in the window, or sum it up without one.

    Without a window it goes as fast as it can.

    Example: gsapp replay flights/2026-05-12-a --headless --json summary.json
    """
    if not headless and json is None:
        from gsapp.cli._calls import wrong_call
        from gsapp.session.feeds import parse_speed
        from ui.app import run_window

        with wrong_call():
            parse_speed(speed or "1")

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


@app.command("import")
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
    json: JsonFile = None,
) -> None:
    """Make a flight folder from the log of another program.

    Example: gsapp import 00000042.BIN --map ardupilot-log --out flights/other
    """
    from gsapp.cli import import_ as command

    command.run(file=file, channel_map=channel_map, out=out, json=json)


@app.command()
def onboard(
    flight: Annotated[Path, typer.Argument(metavar="FLIGHT", readable=False, help="Its folder")],
    log: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="Put this log in force: .tlog, .bin, .ulg, .csv, .mat or .parquet",
        ),
    ] = None,
    link: Annotated[
        str | None,
        typer.Option(metavar="LINK", help="Fetch the log from the autopilot, landed and disarmed"),
    ] = None,
    fetch: Annotated[
        bool, typer.Option("--fetch", help="The same, over the link that records into FLIGHT")
    ] = False,
    number: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=0, help="Of the autopilot's logs; by default the flight's, by date"
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the autopilot's logs only")] = False,
    use: Annotated[
        str | None,
        typer.Option(metavar="NAME|none", help="Put a log of the folder in force, or take it out"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Let the on-board log replace what came over the radio.

    Without an option it is told how it stands.

    The log is aligned with the live record by what both show, offset and drift of its clock, and
    refused where they do not match. Flight time stays, and with it marks, grades and edges of
    maneuvers. A fetch that was broken off goes on where it was. The former log stays in the
    folder.

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


@app.command()
def export(
    flight: FlightPath,
    to: Annotated[Literal["csv", "mat", "parquet"], typer.Option(help="Format")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="File to write")],
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    units: Annotated[
        Literal["us", "si", "base"],
        typer.Option(help="Units: us ft/s, deg, g; si m/s, deg, g; base m/s, rad, m/s^2"),
    ] = "us",
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


FlightPaths = Annotated[
    list[Path],
    typer.Argument(
        metavar="FLIGHT",
        readable=False,
        help="Flight folders, .csv, .tlog, .bin, .ulg, .mat, .parquet",
    ),
]
AircraftName = Annotated[
    str | None,
    typer.Option(
        "--aircraft",
        metavar="FILE",
        help="Aircraft: a file, or the name of a shipped one; else the copy in the flight folder",
    ),
]
ManeuverList = Annotated[
    list[str] | None,
    typer.Option(
        "--maneuver",
        metavar="START:STOP",
        help="Seconds, in place of what would be found; K:START:STOP for the K-th flight; "
        "repeatable",
    ),
]
AsFound = Annotated[
    bool, typer.Option("--as-found", help="Leave out what was changed by hand in the review")
]
EveryGrade = Annotated[
    bool,
    typer.Option("--every-grade", help="Keep maneuvers graded unfit (D)"),
]
Method = Annotated[
    Literal["ml", "ee", "ftr"],
    typer.Option(help="Maximum likelihood, equation error, or Fourier transform regression"),
]
Axis = Annotated[
    Literal["lon", "lat", "both"],
    typer.Option(help="Use maneuvers of one axis only; both: each by the surfaces it moved"),
]
Joint = Annotated[
    bool,
    typer.Option("--joint", help="Fit all maneuvers of an axis together, too"),
]
Dated = Annotated[
    bool,
    typer.Option("--date/--no-date", help="Say when it was written"),
]
CatalogFile = Annotated[
    Path | None,
    typer.Option(
        "--catalog", readable=False, metavar="FILE", help="Keep the results in this catalog"
    ),
]


@app.command()
def maneuvers(
    flight: FlightPath,
    aircraft: AircraftName = None,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    as_found: AsFound = False,
    catalog: CatalogFile = None,
    json: JsonFile = None,
) -> None:
    """Find the maneuvers of a flight and grade them.

    What was changed by hand counts.

    Example: gsapp maneuvers flights/2026-05-12-a --json maneuvers.json
    """
    from gsapp.cli import maneuvers as command

    command.run(
        flight=flight,
        aircraft=aircraft,
        channel_map=channel_map,
        calibration=calibration,
        as_found=as_found,
        json=json,
        catalog=catalog,
    )


@app.command()
def debrief(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT", readable=False, help="Without any, the trends of the catalog"
        ),
    ] = None,
    aircraft: AircraftName = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What is known of the aerodynamics: a model file, or the name of a shipped one; "
            "by default the one shipped for the aircraft",
        ),
    ] = None,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    cards: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Test cards in place of the flight's own: a file, or the name of a shipped set",
        ),
    ] = None,
    catalog: CatalogFile = None,
    json: JsonFile = None,
) -> None:
    """Tell what every input of a flight was worth.

    Also how the test cards were flown, and trends from flight to flight.

    Verdicts are those that the pilot heard in flight: too small, too large, not trimmed, spoiled,
    good, and what to do next time. With a catalog they are kept beside the grades of the
    maneuvers, and its flights are compared.

    Example: gsapp debrief flights/2026-05-12-a --catalog campaign.sqlite

    Example: gsapp debrief --catalog campaign.sqlite
    """
    from gsapp.cli import debrief as command

    command.run(
        flights=flights or [], aircraft=aircraft, model=model, channel_map=channel_map,
        calibration=calibration, cards=cards, catalog=catalog, json=json,
    )  # fmt: skip


@app.command()
def estimate(
    flights: FlightPaths,
    aircraft: AircraftName = None,
    method: Method = "ml",
    axis: Axis = "both",
    six_degrees: Annotated[
        bool, typer.Option("--six-degrees", help="Fit all six degrees of freedom together")
    ] = False,
    weights: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Weights of the responses, such as the shipped table-6.2.7; "
            "by default the noise is estimated",
        ),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Hold a derivative; repeatable"),
    ] = None,
    free: Annotated[
        str | None,
        typer.Option(metavar="NAME,..", help="Estimate these alone; the model's values elsewhere"),
    ] = None,
    prior: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE:STD", help="A-priori value; repeatable"),
    ] = None,
    stand_in: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="SI constant for what was not measured, as V=30; repeatable"
        ),
    ] = None,
    states: Annotated[
        str | None,
        typer.Option(metavar="ID,..", help="Active states; the others come from measurement"),
    ] = None,
    responses: Annotated[
        str | None,
        typer.Option(metavar="ID,..", help="Responses compared with measurement"),
    ] = None,
    biases: Annotated[
        str | None,
        typer.Option(metavar="ID,..", help="Responses whose sensor bias is free"),
    ] = None,
    scales: Annotated[
        str | None,
        typer.Option(metavar="ID,..", help="Responses whose scale factor is free"),
    ] = None,
    shifts: Annotated[
        str | None,
        typer.Option(metavar="ID,..", help="Responses whose time shift is free"),
    ] = None,
    euler: Annotated[
        bool, typer.Option("--euler", help="Integrate by Euler's rule, not Runge and Kutta's")
    ] = False,
    bound_factor: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="Multiply the Cramer-Rao bounds in place of the correction for colored "
            "residuals; the source: 10",
        ),
    ] = None,
    joint: Joint = False,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Model: its effects are known, its values held where not free"
        ),
    ] = None,
    maneuver: ManeuverList = None,
    every_grade: EveryGrade = False,
    as_found: AsFound = False,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    catalog: CatalogFile = None,
    label: Annotated[
        str, typer.Option(metavar="TEXT", help="What the run is called in the catalog")
    ] = "",
    json: JsonFile = None,
) -> None:
    """Estimate stability and control derivatives, with bounds.

    The bounds are honest: they count that residuals are colored.

    Example: gsapp estimate flights/a flights/b --aircraft b777 --json derivatives.json

    Example: gsapp estimate flights/a --method ml --axis lon --weights table-6.2.7 --hold CN_q=5

    Example: gsapp estimate flights/a --catalog campaign.sqlite --label "weights of the source"

    Example: gsapp estimate doublet.csv --maneuver 2:12 --free Cm_alpha,Cm_q,Cm_de --model b777
    """
    from gsapp.cli import estimate as command

    command.run(
        flights=flights, aircraft=aircraft, method=method, axis=axis, six_degrees=six_degrees,
        weights=weights, hold=hold or (), free=free, prior=prior or (), stand_in=stand_in or (),
        states=states, responses=responses, biases=biases, scales=scales, shifts=shifts,
        euler=euler, bound_factor=bound_factor, joint=joint, model=model,
        maneuver=maneuver or (), every_grade=every_grade, as_found=as_found,
        channel_map=channel_map, calibration=calibration, catalog=catalog, label=label, json=json,
    )  # fmt: skip


@app.command()
def report(
    flights: Annotated[
        list[Path],
        typer.Argument(
            metavar="FLIGHT|DIR",
            readable=False,
            help="Flights, or folders that hold some",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            readable=False,
            help="A .html or .pdf file; or a folder for both, all pictures, and the results as "
            "CSV, MATLAB, JSON, model and linear models",
        ),
    ],
    aircraft: AircraftName = None,
    method: Method = "ml",
    axis: Axis = "both",
    weights: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Weights of the responses; by default the noise counts"),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What was known before: its effects count, its values are drawn beside and held "
            "where not free",
        ),
    ] = None,
    joint: Joint = False,
    maneuver: ManeuverList = None,
    every_grade: EveryGrade = False,
    as_found: AsFound = False,
    validate: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FLIGHT",
            readable=False,
            help="One of the flights, to judge linear models on; repeatable; by default the last",
        ),
    ] = None,
    units: Annotated[Literal["US", "SI"], typer.Option(help="Of pictures and tables")] = "US",
    dated: Dated = True,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Write the report on one flight or a campaign.

    It gives derivatives that can be defended.

    Example: gsapp report flights/e --aircraft b777 --out "flight E.pdf"

    Example: gsapp report flights --model b777 --out results
    """
    from gsapp.cli import report as command

    command.run(
        flights=flights, out=out, aircraft=aircraft, method=method, axis=axis, weights=weights,
        model=model, joint=joint, maneuver=maneuver or (), every_grade=every_grade,
        as_found=as_found, units=units, dated=dated, channel_map=channel_map,
        calibration=calibration, validate=validate or (), json=json,
    )  # fmt: skip


@app.command()
def compatibility(
    flights: FlightPaths,
    aircraft: AircraftName = None,
    maneuver: ManeuverList = None,
    as_found: AsFound = False,
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ID.KIND", help="Estimate this error, too, as q.scale or V.delay; repeatable"
        ),
    ] = None,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Check the instruments against one another.

    No aerodynamic model is needed.

    Rates, accelerations, flow angles and speed must follow from one motion: bias, scale factor
    and delay of each instrument, reversed axes, redundant sensors that disagree.

    Example: gsapp compatibility flights/2026-05-12-a --aircraft b777
    """
    from gsapp.cli import compatibility as command

    command.run(
        flights=flights, aircraft=aircraft, maneuver=maneuver or (), as_found=as_found,
        free=free or (), channel_map=channel_map, calibration=calibration, json=json,
    )  # fmt: skip


@app.command()
def terms(
    flights: FlightPaths,
    coefficient: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="CN, CA, CY, Cl, Cm or Cn; repeatable; all by default"),
    ] = None,
    aircraft: AircraftName = None,
    model: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A model whose effects are taken as known"),
    ] = None,
    maneuver: ManeuverList = None,
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Choose the terms that each coefficient needs.

    They are linear ones, effects, and products without a name.

    Equation error, stepwise: a term enters if it is proven and predicts stretches of the record
    that were left out; it goes again if later ones make it superfluous.

    Example: gsapp terms flights/a flights/b --coefficient Cm --aircraft b777
    """
    from gsapp.cli import terms as command

    command.run(
        flights=flights, coefficient=coefficient or (), aircraft=aircraft, model=model,
        maneuver=maneuver or (), channel_map=channel_map, calibration=calibration, json=json,
    )  # fmt: skip


@app.command()
def catalog(
    file: Annotated[
        Path, typer.Argument(metavar="CATALOG", readable=False, help="As --catalog wrote it")
    ],
    flight: Annotated[str | None, typer.Option(help="Of this flight")] = None,
    inputs: Annotated[
        str | None,
        typer.Option(metavar="da+dr", help="Exactly these surfaces moved"),
    ] = None,
    kind: Annotated[
        Literal["doublet", "3-2-1-1", "pulse", "multistep", "sweep", "retrim", "none"] | None,
        typer.Option(help="Shape of the input"),
    ] = None,
    worst_grade: Annotated[
        Literal["A", "B", "C", "D"], typer.Option(help="Leave worse ones out")
    ] = "D",
    where: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL=LEAST:MOST", help="Condition before the input, as 'V=90 ft/s:'"
        ),
    ] = None,
    note: Annotated[
        str | None,
        typer.Option(help="Words that stand in the note"),
    ] = None,
    derivative: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Show every estimate of this derivative"),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write what was found as a table"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Search the maneuvers and estimates of a campaign.

    Example: gsapp catalog campaign.sqlite --inputs da+dr --where "V=90 ft/s:110 ft/s"
    """
    from gsapp.cli import catalog as command

    command.run(
        catalog=file, flight=flight, inputs=inputs, kind=kind, worst_grade=worst_grade,
        where=where or (), note=note, derivative=derivative, csv=csv, json=json,
    )  # fmt: skip


@app.command()
def runs(
    catalog: Annotated[
        Path, typer.Argument(metavar="CATALOG", readable=False, help="File of the campaign")
    ],
    what: Annotated[
        Literal["list", "show", "compare", "repeat", "report", "forget", "recall", "rename"],
        typer.Argument(help="What to do with the runs in it"),
    ] = "list",
    rest: Annotated[
        list[str] | None,
        typer.Argument(metavar="N|LABEL", help="Numbers of runs; a label"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="PLACE",
            help="Of the report: a .html or .pdf file, or a folder",
        ),
    ] = None,
    units: Annotated[Literal["US", "SI"], typer.Option(help="Of the report")] = "US",
    dated: Dated = True,
    json: JsonFile = None,
) -> None:
    """List the runs kept in a catalog, compare or repeat them.

    They can also be shown, reported, renamed, forgotten and recalled.

    A run that is repeated uses the same maneuvers with the same edges and settings; it gives the
    same numbers to the last bit, or you are told what has changed.

    Example: gsapp runs campaign.sqlite

    Example: gsapp runs campaign.sqlite compare 3 5

    Example: gsapp runs campaign.sqlite repeat 3

    Example: gsapp runs campaign.sqlite report 3 --out results
    """
    from gsapp.cli import runs as command

    try:
        command.check(what, rest or (), out)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    command.run(
        catalog=catalog, what=what, rest=rest or (), out=out, units=units, dated=dated, json=json
    )


@app.command("linear-models")
def linear_models(
    flights: FlightPaths,
    validate: Annotated[
        Path,
        typer.Option(readable=False, metavar="FLIGHT", help="Flight that the models are judged on"),
    ],
    aircraft: AircraftName = None,
    model: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A model whose effects are taken as known"),
    ] = None,
    order_lon: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the longitudinal subspace model")
    ] = "2",
    order_lat: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the lateral-directional one")
    ] = "4",
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    as_found: AsFound = False,
    out: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="DIR", help="Write the models here, one file each"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Fit three linear models, and judge them on another flight.

    Batch least squares, subspace with prediction error, and maximum likelihood derivatives
    through appendix A; RMS error over range as in tables 7.4.1 and 7.4.2 of the source.

    Example: gsapp linear-models flights/a --validate flights/b --aircraft b777
    """
    from gsapp.cli import linear_models as command

    command.run(
        flights=flights, validate=validate, aircraft=aircraft, model=model,
        order_lon=order_lon, order_lat=order_lat, channel_map=channel_map,
        calibration=calibration, as_found=as_found, out=out, json=json,
    )  # fmt: skip


@app.command()
def discrepancy(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT",
            readable=False,
            help="Flight folders, .csv, .tlog, .bin, .ulg, .mat, .parquet",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="DIR",
            help="Folder for the revised model, report.html, report.pdf, figures, discrepancy.json",
        ),
    ] = None,
    aircraft: AircraftName = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="The model to be judged: a file, or the name of a shipped one; without it the "
            "linear build-up is fitted",
        ),
    ] = None,
    catalog: Annotated[
        bool, typer.Option("--catalog", help="List the effects that can be named, and stop")
    ] = False,
    maneuver: ManeuverList = None,
    every_grade: EveryGrade = False,
    as_found: AsFound = False,
    refuse: Annotated[
        list[str] | None,
        typer.Option(metavar="ID", help="Never name this effect; repeatable"),
    ] = None,
    force: Annotated[
        list[str] | None,
        typer.Option(metavar="ID", help="Put this effect in, whatever the evidence; repeatable"),
    ] = None,
    held_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MANEUVER",
            help="Keep this maneuver out of naming and fitting; repeatable; by default one of each "
            "kind, about a quarter",
        ),
    ] = None,
    most_effects: Annotated[
        int, typer.Option(metavar="N", min=0, help="Stop after so many effects")
    ] = 4,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MANEUVER",
            help="Draw this maneuver in full in the report; repeatable; by default the worst of "
            "those kept out",
        ),
    ] = None,
    units: Annotated[
        Literal["us", "si"], typer.Option(help="Units on the screen and in the report")
    ] = "us",
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Name and add the effect that a model lacks.

    Find where simulation and flight disagree, name the effect, add it, show the gap shrink.

    Example: gsapp discrepancy flights/a flights/b --aircraft b777 --model b777 --out missing

    Example: gsapp discrepancy flights/a --out missing --refuse aero.Cm.speed
    --held-out 3 --held-out 7

    Example: gsapp discrepancy --catalog
    """
    if catalog:
        from gsapp.cli._effects_text import run as list_effects

        list_effects(json=json)
        return
    if not flights or out is None:
        raise typer.BadParameter("give FLIGHT... and --out DIR, or --catalog")
    from gsapp.cli import discrepancy as command

    command.run(
        flights=flights, out=out, aircraft=aircraft, model=model, maneuver=maneuver or (),
        every_grade=every_grade, as_found=as_found, refuse=refuse or (), force=force or (),
        held_out=held_out or (), most_effects=most_effects, draw=draw or (), units=units,
        channel_map=channel_map, calibration=calibration, json=json,
    )  # fmt: skip


TableFile = Annotated[
    Path,
    typer.Option(
        "--out", readable=False, metavar="FILE", help="File to write: .csv, .mat or .parquet"
    ),
]
ChannelList = Annotated[
    str | None,
    typer.Option(metavar="ID,ID,..", help="Keep these channels only, in this order"),
]
WithoutList = Annotated[
    str | None,
    typer.Option(metavar="ID,ID,..", help="Leave these channels out"),
]
RenameList = Annotated[
    list[str] | None,
    typer.Option(metavar="OLD=NEW", help="Give a channel another id; repeatable"),
]
WrittenUnits = Annotated[
    Literal["us", "si", "base"],
    typer.Option(help="Units: us ft/s, deg, g; si m/s, deg, g; base m/s, rad, m/s^2"),
]


@app.command()
def cut(
    flight: FlightPath,
    out: TableFile,
    window: Annotated[
        list[str] | None,
        typer.Option(
            "--window",
            metavar="START:STOP",
            help="Seconds to keep; repeatable; either end may be empty",
        ),
    ] = None,
    channels: ChannelList = None,
    without: WithoutList = None,
    rename: RenameList = None,
    from_zero: Annotated[bool, typer.Option("--from-zero", help="Let times begin at 0")] = False,
    units: WrittenUnits = "us",
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Cut windows of time, or channels, from a flight.

    Between two windows that do not touch a gap is left.

    Example: gsapp cut flights/a --window 120.5:131 --out doublet.csv

    Example: gsapp cut flights/a --window :60 --window 300: --without flap --out ends.mat

    Example: gsapp cut flights/a --channels alpha,q,de --rename q=q.2 --out pitch.csv
    """
    from gsapp.cli import cut as command

    command.run(
        flight=flight, windows=window or (), out=out, channels=channels, without=without,
        rename=rename or (), from_zero=from_zero, units=units, channel_map=channel_map,
        calibration=calibration, json=json,
    )  # fmt: skip


@app.command()
def merge(
    flights: Annotated[
        list[Path], typer.Argument(metavar="FLIGHT", readable=False, help="Two or more")
    ],
    out: TableFile,
    append: Annotated[
        bool, typer.Option("--append", help="One after the other instead of beside each other")
    ] = False,
    pause: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="Between them with --append")
    ] = 10.0,
    shift: Annotated[
        list[str] | None,
        typer.Option(metavar="K:SECONDS", help="Add to the times of the K-th flight; repeatable"),
    ] = None,
    align: Annotated[
        bool,
        typer.Option("--align", help="Find how the clocks differ, from channels in common"),
    ] = False,
    conflict: Annotated[
        Literal["first", "last", "both"],
        typer.Option(help="Whose samples count where two have the same channel; both adds ID.2"),
    ] = "first",
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Of the result; by default that of the quickest"),
    ] = None,
    units: WrittenUnits = "us",
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Merge records by time, or one after the other.

    Example: gsapp merge live.csv onboard.bin --align --conflict last --out whole.parquet

    Example: gsapp merge a.csv gps.csv --shift 2:-0.35 --out both.csv

    Example: gsapp merge flight-1 flight-2 --append --pause 60 --out day.csv
    """
    from gsapp.cli import merge as command

    command.run(
        flights=flights, out=out, append=append, pause=pause, shift=shift or (), align=align,
        conflict=conflict, rate=rate, units=units, channel_map=channel_map,
        calibration=calibration, json=json,
    )  # fmt: skip


@app.command()
def resample(
    flight: FlightPath,
    out: TableFile,
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Samples per second; without it the rate stays"),
    ] = None,
    low_pass: Annotated[
        float | None,
        typer.Option(
            metavar="HZ",
            min=0.0,
            help="Corner of a zero-phase filter; 0.4 of a lower rate by default, 0 for none",
        ),
    ] = None,
    kind: Annotated[
        Literal["linear", "cubic"], typer.Option(help="Interpolation between samples")
    ] = "linear",
    channels: ChannelList = None,
    without: WithoutList = None,
    rename: RenameList = None,
    units: WrittenUnits = "us",
    channel_map: MapName = None,
    calibration: OtherCertificates = None,
    json: JsonFile = None,
) -> None:
    """Lay a flight on another rate, or filter it.

    The filter shifts no phase.

    Before decimation a zero-phase low-pass takes out what the new rate cannot hold. Gaps stay.

    Example: gsapp resample flights/a --rate 50 --out half.csv

    Example: gsapp resample flights/a --low-pass 5 --channels q,alpha --out smooth.mat

    Example: gsapp resample gps.csv --rate 100 --kind cubic --out gps100.csv
    """
    from gsapp.cli import resample as command

    command.run(
        flight=flight, out=out, rate=rate, low_pass=low_pass, kind=kind, channels=channels,
        without=without, rename=rename or (), units=units, channel_map=channel_map,
        calibration=calibration, json=json,
    )  # fmt: skip


@app.command()
def calibrate(
    points: Annotated[
        Path,
        typer.Argument(
            metavar="POINTS.csv",
            readable=False,
            help="Columns: angle [deg], volts [V], direction (up or down); excitation [V] if known",
        ),
    ],
    channel: Annotated[str, typer.Option(metavar="ID", help="Such as elevator_left")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="Certificate to write")],
    degree: Annotated[
        int | None,
        typer.Option(min=1, max=3, help="Of the curve; without it the points decide"),
    ] = None,
    excitation: Annotated[
        float | None,
        typer.Option(metavar="V", help="Supply of an instrument whose volts follow it"),
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="Of the surface, in the unit of the points"),
    ] = None,
    who: Annotated[str, typer.Option(help="Who took the readings")] = "",
    temperature: Annotated[
        float | None,
        typer.Option(metavar="DEGC", help="Of the surroundings"),
    ] = None,
    former: Annotated[
        list[Path] | None,
        typer.Option(
            readable=False, metavar="FILE", help="Certificate to compare with; repeatable"
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Page with the curves: .html or .pdf"),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Turn calibration points into a certificate.

    It holds the curve that they deserve, and how good it is.

    Example: gsapp calibrate points.csv --channel elevator_left --out calibration/elevator_left.toml

    Example: gsapp calibrate points.csv --channel rudder --out new.toml --excitation 5
    --travel -30:30 --who "B. Jones" --temperature 16 --former old.toml
    """
    from gsapp.cli import calibrate as command

    command.run(
        points=points, channel=channel, out=out, degree=degree, excitation=excitation,
        travel=travel, who=who, temperature=temperature, former=former or (), report=report,
        json=json,
    )  # fmt: skip


@app.command()
def certificates(
    folder: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER|NAME",
            help="Folder of certificates, of an aircraft's, of a flight; or a shipped set",
        ),
    ],
    former: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER|NAME",
            help="Certificates to compare with; by default those before in an aircraft's history",
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="DIR", help="Write a page with the curves of each one here"
        ),
    ] = None,
    page: Annotated[Literal["pdf", "html"], typer.Option("--format", help="Of the pages")] = "pdf",
    json: JsonFile = None,
) -> None:
    """List the certificates in force: age, quality, drift.

    Example: gsapp certificates flights/2026-05-12-a --report pages
    """
    from gsapp.cli import certificates as command

    command.run(folder=folder, former=former, report=report, page=page, json=json)


@app.command()
def inertia(
    swings: Annotated[
        Path,
        typer.Argument(metavar="SWINGS.toml", readable=False, help="Times and distances of swings"),
    ],
    unit: Annotated[str, typer.Option(help="Of the values on the screen")] = "slug ft^2",
    json: JsonFile = None,
) -> None:
    """Find moments of inertia from pendulum swings.

    Each comes with its uncertainty.

    Example: gsapp inertia swings.toml --unit "kg m^2"
    """
    from gsapp.cli import inertia as command

    command.run(swings=swings, unit=unit, json=json)


_LONGEST_NAME = 200


def main() -> None:
    """Run the command line; exit code 0 = done, 1 = failed with a message, 2 = wrong call."""
    _print_anything()
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        sentence = _sentence(error)
        if sentence is None:
            raise
        from gsapp.cli._calls import WrongCallError

        if isinstance(error, WrongCallError):
            sys.stderr.write(f"gsapp: {sentence}\n")
            sys.exit(2)
        sys.exit(f"gsapp: {sentence}")


def _print_anything() -> None:
    """Let no character end the program: Windows hands over pipes and files in its old code pages.

    What goes there is UTF-8, as every file of this program; a terminal shows what it can.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            encoding = None if stream.isatty() else "utf-8"
            stream.reconfigure(encoding=encoding, errors="replace")


def _sentence(error: Exception) -> str | None:
    """Return what to tell the user; None for an error that nobody foresaw."""
    from gsapp.foundation import GroundStationError  # not needed for --help

    if isinstance(error, GroundStationError):
        return str(error)
    if isinstance(error, UnicodeEncodeError) and error.reason == "surrogates not allowed":
        return (
            "the name of a file or folder among those of this call is not UTF-8, so that it cannot "
            "be written down; rename it"
        )
    if isinstance(error, OSError):
        from gsapp.foundation.refusals import remedy

        said = error.strerror or str(error)
        if error.filename is None:
            # A name is missing where what was printed could not be written.
            return f"{said}; {remedy(error)}" if error.errno else said
        name = str(error.filename)
        shown = name if len(name) <= _LONGEST_NAME else f"{name[:40]}...{name[-40:]}"
        return f"{shown}: {said}; {remedy(error)}"
    return None
