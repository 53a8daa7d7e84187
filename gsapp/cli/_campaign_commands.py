"""Commands on maneuvers of one or more flights, and on what was found from them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from gsapp.cli._commands import ESTIMATE_SETTINGS, MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FlightPath, JsonFile, Units

FlightPaths = Annotated[
    list[Path],
    typer.Argument(
        metavar="FLIGHT",
        readable=False,
        help="Flight folders, .csv, .tlog, .bin, .ulg, .mat, .parquet",
    ),
]
Dated = Annotated[
    bool,
    typer.Option("--date/--no-date", help="Include the date"),
]
CatalogFile = Annotated[
    Path | None,
    typer.Option(
        "--catalog", readable=False, metavar="FILE", help="Save the results in this catalog"
    ),
]


@takes_settings(MANEUVER_SETTINGS, "aircraft", "as_found", "channel_map", "calibration")
def maneuvers(
    flight: FlightPath,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Find the maneuvers of a flight and grade them.

    What was changed by hand counts.

    Example: gsapp maneuvers flights/2026-05-12-a --json maneuvers.json
    """
    from gsapp.cli import maneuvers as command

    command.run(flight=flight, json=json, catalog=catalog, **settings)


@takes_settings(MANEUVER_SETTINGS, "aircraft", "channel_map", "calibration")
def debrief(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT", readable=False, help="Without a flight: trends of the catalog"
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Prior model: a file, or the name of a shipped one; default: shipped for the "
            "aircraft",
        ),
    ] = None,
    cards: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help=(
                "Test cards to use instead of those of the flight: a file, or the name of a "
                "shipped set"
            ),
        ),
    ] = None,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
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
        flights=flights or [], model=model, cards=cards, catalog=catalog, json=json, **settings
    )  # fmt: skip


@takes_settings(ESTIMATE_SETTINGS)
def estimate(
    flights: FlightPaths,
    euler: Annotated[bool, typer.Option("--euler", hidden=True)] = False,
    catalog: CatalogFile = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Estimate stability and control derivatives, with bounds.

    The bounds are honest: they count that residuals are colored.

    Example: gsapp estimate flights/a flights/b --aircraft b777 --json derivatives.json

    Example: gsapp estimate flights/a --method ml --axis lon --weights table-6.2.7 --hold CN_q=5

    Example: gsapp estimate flights/a --catalog campaign.sqlite --label "weights of the source"

    Example: gsapp estimate doublet.csv --maneuver 2:12 --free Cm_alpha,Cm_q,Cm_de --model b777
    """
    from gsapp.cli import estimate as command

    if euler:
        settings["integration"] = "euler"
    command.run(flights=flights, catalog=catalog, json=json, **settings)


@takes_settings(
    ESTIMATE_SETTINGS, "aircraft", "method", "axis", "weights", "model", "joint",
    "maneuver_windows", "every_grade", "as_found", "channel_map", "calibration",
)  # fmt: skip
def report(
    flights: Annotated[
        list[Path],
        typer.Argument(
            metavar="FLIGHT|DIR",
            readable=False,
            help="Flights, or folders with flights",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            readable=False,
            help=".html or .pdf file; or a folder for both plus figures and results (CSV, "
            "MATLAB, JSON, models)",
        ),
    ],
    validate: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FLIGHT",
            readable=False,
            help="Flight to validate linear models on; repeatable; default: the last",
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    dated: Dated = True,
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Write the report on one flight or a campaign.

    It gives derivatives that can be defended.

    Example: gsapp report flights/e --aircraft b777 --out "flight E.pdf"

    Example: gsapp report flights --model b777 --out results
    """
    from gsapp.cli import report as command

    command.run(
        flights=flights, out=out, dated=dated, validate=validate or (), json=json, **settings
    )  # fmt: skip


@takes_settings(
    MANEUVER_SETTINGS, "aircraft", "maneuver_windows", "as_found", "channel_map", "calibration"
)
def compatibility(
    flights: FlightPaths,
    error: Annotated[
        list[str] | None,
        typer.Option(
            "--error",
            metavar="ID.KIND",
            help="Also estimate this error, such as q.scale or V.delay; repeatable",
        ),
    ] = None,
    free: Annotated[list[str] | None, typer.Option("--free", hidden=True)] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Check the instruments against one another.

    No aerodynamic model is needed.

    Rates, accelerations, flow angles and speed must follow from one motion: bias, scale factor
    and delay of each instrument, reversed axes, redundant sensors that disagree.

    Example: gsapp compatibility flights/2026-05-12-a --aircraft b777
    """
    from gsapp.cli import compatibility as command

    command.run(
        flights=flights, free=[*(error or ()), *(free or ())], json=json, **settings
    )  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "aircraft", "maneuver_windows", "channel_map", "calibration")
def terms(
    flights: FlightPaths,
    coefficient: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="CN, CA, CY, Cl, Cm or Cn; repeatable; all by default"),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Model whose effects are known"),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Choose the terms that each coefficient needs.

    They are linear ones, effects, and products without a name.

    Equation error, stepwise: a term enters if it is proven and predicts stretches of the record
    that were left out; it goes again if later ones make it superfluous.

    Example: gsapp terms flights/a flights/b --coefficient Cm --aircraft b777
    """
    from gsapp.cli import terms as command

    command.run(
        flights=flights, coefficient=coefficient or (), model=model, json=json, **settings
    )  # fmt: skip


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
        Literal["A", "B", "C", "D"], typer.Option(help="Exclude worse grades")
    ] = "D",
    where: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL=LEAST:MOST", help="Condition before the input, as 'V=90 ft/s:'"
        ),
    ] = None,
    note: Annotated[
        str | None,
        typer.Option(help="Text in the note"),
    ] = None,
    derivative: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Show every estimate of this derivative"),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Write the result as a table"),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
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


def runs(
    catalog: Annotated[
        Path, typer.Argument(metavar="CATALOG", readable=False, help="File of the campaign")
    ],
    what: Annotated[
        Literal["list", "show", "compare", "repeat", "report", "forget", "recall", "rename"],
        typer.Argument(help="Action"),
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
    units: Units = "us",  # noqa: ARG001  acts in its callback
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
        command.check_arguments(what, rest or (), out)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    command.run(
        catalog=catalog,
        what=what,
        rest=rest or (),
        out=out,
        dated=dated,
        json=json,
    )


@takes_settings(MANEUVER_SETTINGS, "aircraft", "as_found", "channel_map", "calibration")
def linear_models(
    flights: FlightPaths,
    validate: Annotated[
        Path,
        typer.Option(readable=False, metavar="FLIGHT", help="Flight to validate the models on"),
    ],
    model: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Model whose effects are known"),
    ] = None,
    order_lon: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the longitudinal subspace model")
    ] = "2",
    order_lat: Annotated[
        str, typer.Option(metavar="N|auto", help="Order of the lateral-directional subspace model")
    ] = "4",
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False, metavar="DIR", help="Write the models to this folder, one file each"
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Fit three linear models, and judge them on another flight.

    Batch least squares, subspace with prediction error, and maximum likelihood derivatives
    through appendix A; RMS error over range as in tables 7.4.1 and 7.4.2 of the source.

    Example: gsapp linear-models flights/a --validate flights/b --aircraft b777
    """
    from gsapp.cli import linear_models as command

    command.run(
        flights=flights, validate=validate, model=model, order_lon=order_lon, order_lat=order_lat,
        out=out, json=json, **settings,
    )  # fmt: skip


@takes_settings("gsapp.discrepancy.settings:DiscrepancySettings")
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
    list_: Annotated[bool, typer.Option("--list", help="List the effects and exit")] = False,
    catalog: Annotated[bool, typer.Option("--catalog", hidden=True)] = False,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MANEUVER",
            help="Plot all channels of this maneuver in the report; repeatable; default: worst "
            "held-out maneuver",
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Name and add the effect that a model lacks.

    Find where simulation and flight disagree, name the effect, add it, show the gap shrink.

    Example: gsapp discrepancy flights/a flights/b --aircraft b777 --model b777 --out missing

    Example: gsapp discrepancy flights/a --out missing --refuse aero.Cm.speed
    --held-out 3 --held-out 7

    Example: gsapp discrepancy --list
    """
    if list_ or catalog:
        from gsapp.cli._effect_catalog_text import run as list_effects

        list_effects(json=json)
        return
    if not flights or out is None:
        raise typer.BadParameter("give FLIGHT... and --out DIR, or --list")
    from gsapp.cli import discrepancy as command

    command.run(flights=flights, out=out, draw=draw or (), json=json, **settings)
