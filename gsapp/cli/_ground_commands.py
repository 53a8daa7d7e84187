"""Commands on what is measured on the ground: calibrations and inertia."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gsapp.cli._options import JsonFile, Units


def calibrate(
    points: Annotated[
        Path,
        typer.Argument(
            metavar="POINTS.csv",
            readable=False,
            help="CSV with columns angle [deg], volts [V], direction (increasing or "
            "decreasing), optional excitation [V]",
        ),
    ],
    channel: Annotated[str, typer.Option(metavar="ID", help="Channel, such as elevator_left")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="Certificate to write")],
    degree: Annotated[
        int | None,
        typer.Option(min=1, max=3, help="Order of the fit; default: automatic"),
    ] = None,
    excitation: Annotated[
        float | None,
        typer.Option(metavar="V", help="Supply voltage of a ratiometric instrument"),
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="Travel of the surface, in the unit of the points"),
    ] = None,
    who: Annotated[str, typer.Option(help="Name of the person who took the readings")] = "",
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
        typer.Option(readable=False, metavar="FILE", help="Report with the curves: .html or .pdf"),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
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
        typer.Option(readable=False, metavar="DIR", help="Folder for a report of each certificate"),
    ] = None,
    page: Annotated[Literal["pdf", "html"], typer.Option("--format", help="Of the pages")] = "pdf",
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
) -> None:
    """List the certificates in force: age, quality, drift.

    Example: gsapp certificates flights/2026-05-12-a --report pages
    """
    from gsapp.cli import certificates as command

    command.run(folder=folder, former=former, report=report, page=page, json=json)


def inertia(
    swings: Annotated[
        Path,
        typer.Argument(metavar="SWINGS.toml", readable=False, help="Times and distances of swings"),
    ],
    unit: Annotated[str, typer.Option(help="Units on the screen")] = "slug ft^2",
    json: JsonFile = None,
) -> None:
    """Find moments of inertia from pendulum swings.

    Each comes with its uncertainty.

    Example: gsapp inertia swings.toml --unit "kg m^2"
    """
    from gsapp.cli import inertia as command

    command.run(swings=swings, unit=unit, json=json)
