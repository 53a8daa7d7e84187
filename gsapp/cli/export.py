"""``gsapp export``: a flight for other programs."""

from __future__ import annotations

from pathlib import Path

from gsapp.cli._console import PlainConsole


def run(
    *,
    flight: Path,
    to: str,
    out: Path,
    channel_map: str | None = None,
    calibration: str | None = None,
    units: str = "us",
    json: Path | None = None,
) -> None:
    """Write a flight as one table.

    Parameters
    ----------
    flight : Path
        Folder or file.
    to : {"csv", "mat", "parquet"}
        The format.
    out : Path
        The file to write.
    channel_map : str, optional
        Name or path of a channel map.
    calibration : str, optional
        Certificates in place of those kept with the flight: a folder, or a shipped set.
    units : {"us", "si", "base"}
        Units of the columns.
    json : Path, optional
        Where to write for programs what was written, and what `gsapp replay` would; ``-`` for the
        screen, which then shows nothing else.

    Raises
    ------
    GroundStationError
        If the flight cannot be read, holds no sample, or the file cannot be written.
    """
    from gsapp.cli._flight_text import print_flight
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight.flight_loader import load_flight
    from gsapp.flight.summary import summarize_flight
    from gsapp.flight.writers import WRITERS, ColumnUnits, check_format, write_block
    from gsapp.foundation import FlightError

    check_format(to)
    ending = out.suffix.casefold().lstrip(".")
    if ending in WRITERS and ending != to:
        raise CommandUsageError(
            f"{out.name} has the ending of another format than --to {to}; make them agree"
        )
    ColumnUnits.from_channels((), units)
    console = PlainConsole(stderr=is_stdout(json))
    with console.status(f"reading {flight.name}"):
        loaded = load_flight(flight, channel_map=channel_map, certificates=calibration)
    if not len(loaded.block):
        raise FlightError(f"{flight} holds no samples, so that there is nothing to export")
    with console.status(f"writing {out.name}"):
        write_block(out, loaded.block, to, units)
    if not is_stdout(json):
        print_flight(console, loaded)
        console.print(f"written to {out}", highlight=False, soft_wrap=True)
    if json is not None:
        layout = ColumnUnits.from_channels(loaded.block.channels, units)
        written = {
            "file": str(out),
            "format": to,
            "rows": len(loaded.block),
            "units": {"time": "s", **dict(zip(layout.channels, layout.units, strict=True))},
        }
        write_json(json, format_json({**written, **summarize_flight(loaded)}))
