"""``gsapp resample``: another rate, a zero-phase filter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal


def run(
    *,
    flight: Path,
    out: Path,
    rate: float | None = None,
    low_pass: float | None = None,
    kind: Literal["linear", "cubic"] = "linear",
    channels: str | None = None,
    without: str | None = None,
    rename: Sequence[str] = (),
    units: str = "us",
    channel_map: str | None = None,
    calibration: str | None = None,
    json: Path | None = None,
) -> None:
    """Resample or filter a flight.

    Parameters
    ----------
    flight : Path
    out : Path
        Its suffix says the format.
    rate : float, optional
        Samples per second; without it the rate stays.
    low_pass : float, optional
        Corner of a zero-phase low-pass, Hz. Decimation without it takes 0.4 of the new rate; 0
        turns that off.
    kind : {"linear", "cubic"}
    channels, without, rename, units, channel_map, calibration, json
        As for `gsapp.cli.cut.run`.

    Raises
    ------
    GroundStationError
        If something cannot be read, does not fit the rate, or cannot be written.
    """
    from gsapp.cli._table_processing import (
        check_rate_option,
        load_samples,
        output_format,
        parse_renames,
        select_channels,
        write_samples,
    )
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight import processing

    output_format(out)
    if rate is None and not low_pass:
        raise CommandUsageError("nothing to do; give --rate HZ, --low-pass HZ, or both")
    check_rate_option(rate)
    names = parse_renames(rename)
    loaded = load_samples(flight, channel_map, calibration)
    block = select_channels(loaded.block, channels, without, names)
    if rate is None:
        block = processing.low_pass(block, low_pass or 0.0)
    else:
        block = processing.resample(block, rate, corner=low_pass, kind=kind)
    write_samples(block, out, units, json, [loaded])
