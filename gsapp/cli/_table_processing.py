"""Reading, writing and telling of flights that a command changes."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gsapp.flight.flight import Flight
    from gsapp.quantities import Block


def load_samples(path: Path, channel_map: str | None, calibration: str | None) -> Flight:
    """Open a flight that holds samples, and say whose certificates it is read with.

    Raises
    ------
    GroundStationError
        If it cannot be read or holds none.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flight_text import print_calibration
    from gsapp.flight.flight_loader import load_flight
    from gsapp.foundation import FlightError

    flight = load_flight(path, channel_map=channel_map, certificates=calibration)
    if not len(flight.block):
        raise FlightError(f"{path} holds no samples")
    print_calibration(PlainConsole(stderr=True), [flight])
    return flight


def check_rate_option(rate: float | None) -> None:
    """Raise `CommandUsageError` where there can be no such rate, samples per second."""
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight import processing

    if rate is not None:
        with as_usage_error():
            processing.check_sample_rate(rate)


def parse_renames(rename: Iterable[str]) -> dict[str, str]:
    """Return what each ``--rename OLD=NEW`` says, by the old id.

    Raises
    ------
    CommandUsageError
        If one says no such thing, or no channel can be called so.
    """
    from gsapp.cli._usage_errors import CommandUsageError, as_usage_error
    from gsapp.quantities import channel

    names: dict[str, str] = {}
    for text in rename:
        old, equals, new = (part.strip() for part in text.partition("="))
        if not equals or not old or not new:
            raise CommandUsageError(f"'{text}' is not a renaming; write OLD=NEW, such as q=q.2")
        with as_usage_error():
            channel(new)
        names[old] = new
    return names


def select_channels(
    block: Block, channels: str | None, without: str | None, names: Mapping[str, str]
) -> Block:
    """Apply ``--channels``, ``--without`` and the new names to a block."""
    from gsapp.flight.processing import drop_channels, rename_channels

    if channels:
        block = block.select([name.strip() for name in channels.split(",")])
    if without:
        block = drop_channels(block, [name.strip() for name in without.split(",")])
    return rename_channels(block, names) if names else block


def output_format(out: Path) -> str:
    """Return the format that a file's name asks for.

    Raises
    ------
    CommandUsageError
        If there is no such format.
    """
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight.writers import WRITERS

    suffix = out.suffix.lower().lstrip(".")
    if suffix not in WRITERS:
        raise CommandUsageError(
            f"{out.name} does not say the format; end the name in .csv, .mat or .parquet "
            "(gsapp import makes a flight folder of such a file)"
        )
    return suffix


def write_samples(
    block: Block, out: Path, units: str, json: Path | None, flights: Iterable[Flight]
) -> None:
    """Write a block in the format that the name asks for, and tell what was written.

    Parameters
    ----------
    block : Block
    out : Path
        Its suffix says the format.
    units : {"us", "si", "base"}
        Of the columns.
    json : Path or None
        Where the answer for programs goes.
    flights : iterable of Flight
        What the block was made from.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flight_text import calibration_json
    from gsapp.cli._json_output import is_stdout, write_json
    from gsapp.flight.uniform_grid import median_step
    from gsapp.flight.writers import write_block

    write_block(out, block, output_format(out), units)
    step = median_step(block.times)
    start, stop = (float(block.times[0]), float(block.times[-1])) if len(block) else (0.0, 0.0)
    if json is not None:
        content = {
            "out": str(out), "samples": len(block), "t_start": start, "t_end": stop,
            "rate": 1.0 / step if step > 0.0 else None, "channels": list(block.channels),
            "calibration": calibration_json(flights),
        }  # fmt: skip
        write_json(json, json_module.dumps(content, indent=1) + "\n")
        if is_stdout(json):
            return
    rate = f" at {1.0 / step:.6g} per s" if step > 0.0 else ""
    PlainConsole().print(
        f"{out}: {len(block)} samples of {len(block.channels)} channels, {start:.2f} to "
        f"{stop:.2f} s{rate}",
        highlight=False,
        soft_wrap=True,
    )
