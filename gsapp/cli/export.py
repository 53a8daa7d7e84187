"""``gsapp export``: a flight for other programs."""

from __future__ import annotations

from pathlib import Path

from gsapp.cli._screen import Screen


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
    from gsapp.cli._calls import WrongCallError
    from gsapp.cli._flight_text import describe
    from gsapp.cli._results import on_screen, result_text, write_result
    from gsapp.flight.loading import load_flight
    from gsapp.flight.summary import summarize
    from gsapp.flight.writers import WRITERS, Layout, check_format, write_block
    from gsapp.foundation import FlightError

    check_format(to)
    ending = out.suffix.casefold().lstrip(".")
    if ending in WRITERS and ending != to:
        raise WrongCallError(
            f"{out.name} ends as a file of another format than --to {to}; let the two agree"
        )
    Layout.of((), units)
    console = Screen(stderr=on_screen(json))
    with console.status(f"reading {flight.name}"):
        loaded = load_flight(flight, channel_map=channel_map, certificates=calibration)
    if not len(loaded.block):
        raise FlightError(f"{flight} holds no samples, so that there is nothing to export")
    with console.status(f"writing {out.name}"):
        write_block(out, loaded.block, to, units)
    if not on_screen(json):
        describe(console, loaded)
        console.print(f"written to {out}", highlight=False, soft_wrap=True)
    if json is not None:
        layout = Layout.of(loaded.block.channels, units)
        written = {
            "file": str(out),
            "format": to,
            "rows": len(loaded.block),
            "units": {"time": "s", **dict(zip(layout.channels, layout.units, strict=True))},
        }
        write_result(json, result_text({**written, **summarize(loaded)}))
