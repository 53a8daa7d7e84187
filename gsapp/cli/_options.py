"""Arguments and options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
