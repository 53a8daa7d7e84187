"""``gsapp cut``: windows of time, some of the channels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def run(
    *,
    flight: Path,
    windows: Sequence[str],
    out: Path,
    channels: str | None = None,
    without: str | None = None,
    rename: Sequence[str] = (),
    from_zero: bool = False,
    units: str = "us",
    channel_map: str | None = None,
    calibration: str | None = None,
    json: Path | None = None,
) -> None:
    """Cut windows from a flight.

    Parameters
    ----------
    flight : Path
    windows : sequence of str
        Each ``START:STOP`` in s; none keeps the whole time.
    out : Path
        Its suffix says the format.
    channels, without : str, optional
        Ids to keep, or to leave out, with commas between.
    rename : sequence of str
        Each ``OLD=NEW``.
    from_zero : bool
        Whether times are to begin at zero.
    units : {"us", "si", "base"}
        Of the columns written.
    channel_map : str, optional
    calibration : str, optional
        Certificates in place of those kept with the flight: a folder, or a shipped set.
    json : Path, optional

    Raises
    ------
    GroundStationError
        If something cannot be read, does not exist, or cannot be written.
    """
    from gsapp.cli._table_processing import (
        load_samples,
        output_format,
        parse_renames,
        select_channels,
        write_samples,
    )
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight.processing import cut_windows, parse_time_window, shift_time

    output_format(out)
    with as_usage_error():
        wanted = [parse_time_window(text) for text in windows]
    names = parse_renames(rename)
    loaded = load_samples(flight, channel_map, calibration)
    block = select_channels(loaded.block, channels, without, names)
    if wanted:
        block = cut_windows(block, wanted)
    if from_zero:
        block = shift_time(block, -float(block.times[0]))
    write_samples(block, out, units, json, [loaded])
