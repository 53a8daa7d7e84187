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
    from gsapp.cli._calls import WrongCallError
    from gsapp.cli._processed import check_out, check_rate, load, new_names, selected, write
    from gsapp.flight import processing

    check_out(out)
    if rate is None and not low_pass:
        raise WrongCallError("nothing to do; give --rate HZ, --low-pass HZ, or both")
    check_rate(rate)
    names = new_names(rename)
    loaded = load(flight, channel_map, calibration)
    block = selected(loaded.block, channels, without, names)
    if rate is None:
        block = processing.low_pass(block, low_pass or 0.0)
    else:
        block = processing.resample(block, rate, corner=low_pass, kind=kind)
    write(block, out, units, json, [loaded])
