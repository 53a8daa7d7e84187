"""``gsapp import``: a flight folder from the log of another program."""

from __future__ import annotations

from pathlib import Path

from gsapp.cli._screen import Screen


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
    from gsapp.cli._flight_text import describe
    from gsapp.cli._results import on_screen, result_text, write_result
    from gsapp.flight.importing import import_flight
    from gsapp.flight.summary import summarize

    console = Screen(stderr=on_screen(json))
    with console.status(f"reading {file.name}"):
        flight = import_flight(file, out, channel_map=channel_map)
    if not on_screen(json):
        describe(console, flight)
        console.print(f"written to {out}", highlight=False, soft_wrap=True)
    if json is not None:
        write_result(json, result_text({"flight": str(out), **summarize(flight)}))
