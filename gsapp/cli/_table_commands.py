"""Commands that cut, join and resample what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FileUnits, FlightPath, JsonFile

TableFile = Annotated[
    Path,
    typer.Option(
        "--out", readable=False, metavar="FILE", help="File to write: .csv, .mat or .parquet"
    ),
]
ChannelList = Annotated[
    str | None,
    typer.Option(metavar="ID,ID,..", help="Keep only these channels, in this order"),
]
WithoutList = Annotated[
    str | None,
    typer.Option(metavar="ID,ID,..", help="Drop these channels"),
]
RenameList = Annotated[
    list[str] | None,
    typer.Option(metavar="OLD=NEW", help="Rename a channel; repeatable"),
]


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
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
    from_zero: Annotated[bool, typer.Option("--from-zero", help="Start times at 0")] = False,
    units: FileUnits = "us",
    json: JsonFile = None,
    **settings: Any,
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
        rename=rename or (), from_zero=from_zero, units=units, json=json, **settings,
    )  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def merge(
    flights: Annotated[
        list[Path], typer.Argument(metavar="FLIGHT", readable=False, help="Two or more")
    ],
    out: TableFile,
    append: Annotated[bool, typer.Option("--append", help="Append instead of merging")] = False,
    pause: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="Gap between them with --append")
    ] = 10.0,
    shift: Annotated[
        list[str] | None,
        typer.Option(metavar="K:SECONDS", help="Add to the times of the K-th flight; repeatable"),
    ] = None,
    align: Annotated[
        bool,
        typer.Option("--align", help="Estimate the clock offset from common channels"),
    ] = False,
    conflict: Annotated[
        Literal["first", "last", "both"],
        typer.Option(help="Which samples to keep for a common channel; both adds ID.2"),
    ] = "first",
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Sample rate of the result; default: the fastest"),
    ] = None,
    units: FileUnits = "us",
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Merge records by time, or one after the other.

    Example: gsapp merge live.csv onboard.bin --align --conflict last --out whole.parquet

    Example: gsapp merge a.csv gps.csv --shift 2:-0.35 --out both.csv

    Example: gsapp merge flight-1 flight-2 --append --pause 60 --out day.csv
    """
    from gsapp.cli import merge as command

    command.run(
        flights=flights, out=out, append=append, pause=pause, shift=shift or (), align=align,
        conflict=conflict, rate=rate, units=units, json=json, **settings,
    )  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def resample(
    flight: FlightPath,
    out: TableFile,
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Samples per second; default: unchanged"),
    ] = None,
    low_pass: Annotated[
        float | None,
        typer.Option(
            metavar="HZ",
            min=0.0,
            help="Corner of a zero-phase filter; 0.4 of a lower rate by default, 0 for none",
        ),
    ] = None,
    interpolation: Annotated[
        Literal["linear", "cubic"],
        typer.Option("--interpolation", help="Interpolation between samples"),
    ] = "linear",
    kind: Annotated[Literal["linear", "cubic"] | None, typer.Option("--kind", hidden=True)] = None,
    channels: ChannelList = None,
    without: WithoutList = None,
    rename: RenameList = None,
    units: FileUnits = "us",
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Lay a flight on another rate, or filter it.

    The filter shifts no phase.

    Before decimation a zero-phase low-pass takes out what the new rate cannot hold. Gaps stay.

    Example: gsapp resample flights/a --rate 50 --out half.csv

    Example: gsapp resample flights/a --low-pass 5 --channels q,alpha --out smooth.mat

    Example: gsapp resample gps.csv --rate 100 --interpolation cubic --out gps100.csv
    """
    from gsapp.cli import resample as command

    command.run(
        flight=flight, out=out, rate=rate, low_pass=low_pass, kind=kind or interpolation,
        channels=channels, without=without, rename=rename or (), units=units, json=json, **settings,
    )  # fmt: skip
