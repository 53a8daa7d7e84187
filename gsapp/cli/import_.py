"""``gsapp import``: a flight folder from the log of another program."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console


def run(*, file: Path, out: Path, channel_map: str | None = None) -> None:
    """Make a flight folder, and tell what is in it.

    Parameters
    ----------
    file : Path
        ``.tlog``, ``.bin``, ``.ulg``, ``.csv``, ``.mat`` or ``.parquet``.
    out : Path
        The new folder.
    channel_map : str, optional
        Name or path of a channel map.

    Raises
    ------
    GroundStationError
        If the file cannot be read or the folder cannot be made.
    """
    from gsapp.cli._flight_text import describe
    from gsapp.flight.importing import import_flight

    console = Console()
    with console.status(f"reading {file.name}"):
        flight = import_flight(file, out, channel_map=channel_map)
    describe(console, flight)
    console.print(f"written to {out}", highlight=False)
