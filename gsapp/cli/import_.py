"""``gsapp import``: a flight folder from the log of another program."""

from __future__ import annotations

from pathlib import Path

from gsapp.cli._console import PlainConsole


def run(*, file: Path, out: Path, channel_map: str | None = None, json: Path | None = None) -> None:
    """Make a flight folder, and tell what is in it.

    Parameters
    ----------
    file : Path
        ``.tlog``, ``.bin``, ``.ulg``, ``.csv``, ``.mat`` or ``.parquet``.
    out : Path
        The new folder.
    channel_map : str, optional
        Name or path of a channel map.
    json : Path, optional
        Where to write for programs what `gsapp replay` would, and the folder; ``-`` for the
        screen, which then shows nothing else.

    Raises
    ------
    GroundStationError
        If the file cannot be read or the folder cannot be made.
    """
    from gsapp.cli._flight_text import print_flight
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.flight.flight_import import import_flight
    from gsapp.flight.summary import summarize_flight

    console = PlainConsole(stderr=is_stdout(json))
    with console.status(f"reading {file.name}"):
        flight = import_flight(file, out, channel_map=channel_map)
    if not is_stdout(json):
        print_flight(console, flight)
        console.print(f"written to {out}", highlight=False, soft_wrap=True)
    if json is not None:
        write_json(json, format_json({"flight": str(out), **summarize_flight(flight)}))
