"""``gsapp merge``: several records made one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from gsapp.quantities import Block


def run(
    *,
    flights: Sequence[Path],
    out: Path,
    append: bool = False,
    pause: float = 10.0,
    shift: Sequence[str] = (),
    align: bool = False,
    conflict: Literal["first", "last", "both"] = "first",
    rate: float | None = None,
    units: str = "us",
    channel_map: str | None = None,
    calibration: str | None = None,
    json: Path | None = None,
) -> None:
    """Merge flights.

    Parameters
    ----------
    flights : sequence of Path
        Two or more.
    out : Path
        Its suffix says the format.
    append : bool
        Whether to put them one after the other, with `pause` seconds between.
    pause : float
    shift : sequence of str
        Each ``K:SECONDS``: added to the times of the K-th flight, counted from 1.
    align : bool
        Whether to find how the clocks of the others differ from the first's, by comparing
        channels that they have in common.
    conflict : {"first", "last", "both"}
        Which record wins where two have the same channel.
    rate : float, optional
        Of the result, Hz.
    units, channel_map, calibration, json
        As for `gsapp.cli.cut.run`.

    Raises
    ------
    GroundStationError
        If something cannot be read, aligned or written.
    """
    from gsapp.cli._table_processing import (
        check_rate_option,
        load_samples,
        output_format,
        write_samples,
    )
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight.processing import append_records, merge_records, resample, shift_time

    output_format(out)
    if len(flights) < 2:
        raise CommandUsageError("merging needs two or more flights")
    if append and align:
        raise CommandUsageError("--append and --align exclude each other; give one")
    check_rate_option(rate)
    shifts = _shifts(shift, len(flights))
    loaded = [load_samples(path, channel_map, calibration) for path in flights]
    blocks = [each.block for each in loaded]
    for number, seconds in shifts.items():
        blocks[number - 1] = shift_time(blocks[number - 1], seconds)
    if rate is not None:
        blocks = [resample(block, rate) for block in blocks]
    if align:
        blocks = _aligned(blocks, flights, rate)
    merged = (
        append_records(blocks, pause=pause)
        if append
        else merge_records(blocks, conflict=conflict, rate=rate)
    )
    write_samples(merged, out, units, json, loaded)


def _shifts(texts: Sequence[str], count: int) -> dict[int, float]:
    from gsapp.cli._usage_errors import CommandUsageError

    found: dict[int, float] = {}
    for text in texts:
        number, colon, seconds = text.partition(":")
        try:
            found[int(number)] = float(seconds)
        except ValueError:
            colon = ""
        if not colon or not 1 <= int(number) <= count:
            raise CommandUsageError(
                f"'{text}' is not a shift; write K:SECONDS with K from 1 to {count}, such as "
                "2:-0.35"
            )
    return found


def _aligned(blocks: Sequence[Block], flights: Sequence[Path], rate: float | None) -> list[Block]:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.onboard_log.clock_alignment import estimate_record_lag
    from gsapp.flight.processing import resample, shift_time
    from gsapp.flight.uniform_grid import median_step
    from gsapp.foundation import FlightError

    common = rate or max(1.0 / median_step(block.times) for block in blocks)
    first = resample(blocks[0], common, corner=0.0)
    moved = [blocks[0]]
    for block, path in zip(blocks[1:], flights[1:], strict=True):
        found = estimate_record_lag(first, resample(block, common, corner=0.0), common)
        if found is None:
            raise FlightError(
                f"{path} could not be aligned with {flights[0]}: no common channel correlates; "
                "give the offset with --shift"
            )
        seconds = found.rows / common
        PlainConsole(stderr=True).print(
            f"{path.name}: {seconds:+.3f} s (correlation {found.correlation:.3f})", highlight=False
        )
        moved.append(shift_time(block, seconds))
    return moved
