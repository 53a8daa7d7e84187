"""Commands that cut, join and resample what was measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FileUnits, FlightPath, JsonFile

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gsapp.flight.flight import Flight
    from gsapp.quantities import Block

TableFile = Annotated[
    Path,
    typer.Option(
        "--out", readable=False, metavar="FILE", help="File to write: .csv, .mat or .parquet"
    ),
]
ChannelList = Annotated[
    str | None, typer.Option(metavar="ID,ID,..", help="Keep only these channels, in this order")
]
WithoutList = Annotated[str | None, typer.Option(metavar="ID,ID,..", help="Drop these channels")]
RenameList = Annotated[
    list[str] | None, typer.Option(metavar="OLD=NEW", help="Rename a channel; repeatable")
]


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def cut(
    flight: FlightPath,
    out: TableFile,
    window: Annotated[
        list[str] | None,
        typer.Option(
            "--window",
            metavar="START:STOP",
            help="Seconds to keep; repeatable; either end may be empty",
        ),
    ] = None,
    channels: ChannelList = None,
    without: WithoutList = None,
    rename: RenameList = None,
    from_zero: Annotated[bool, typer.Option("--from-zero", help="Start times at 0")] = False,
    units: FileUnits = "us",
    json: JsonFile = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Cut windows of time, or channels, from a flight.

    Between two windows that do not touch a gap is left.

    Example: gsapp cut flights/a --window 120.5:131 --out doublet.csv

    Example: gsapp cut flights/a --window :60 --window 300: --without flap --out ends.mat

    Example: gsapp cut flights/a --channels alpha,q,de --rename q=q.2 --out pitch.csv
    """
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.flight.processing import cut_windows, parse_time_window, shift_time

    output_format(out)
    with as_usage_error():
        wanted = [parse_time_window(text) for text in window or ()]
    names = parse_renames(rename or ())
    loaded = load_samples(flight, channel_map, calibration)
    block = select_channels(loaded.block, channels, without, names)
    if wanted:
        block = cut_windows(block, wanted)
    if from_zero:
        block = shift_time(block, -float(block.times[0]))
    write_samples(block, out, units, json, [loaded])


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def merge(
    flights: Annotated[
        list[Path], typer.Argument(metavar="FLIGHT", readable=False, help="Two or more")
    ],
    out: TableFile,
    append: Annotated[bool, typer.Option("--append", help="Append instead of merging")] = False,
    pause: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="Gap between them with --append")
    ] = 10.0,
    shift: Annotated[
        list[str] | None,
        typer.Option(metavar="K:SECONDS", help="Add to the times of the K-th flight; repeatable"),
    ] = None,
    align: Annotated[
        bool, typer.Option("--align", help="Estimate the clock offset from common channels")
    ] = False,
    conflict: Annotated[
        Literal["first", "last", "both"],
        typer.Option(help="Which samples to keep for a common channel; both adds ID.2"),
    ] = "first",
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Sample rate of the result; default: the fastest"),
    ] = None,
    units: FileUnits = "us",
    json: JsonFile = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Merge records by time, or one after the other.

    Example: gsapp merge live.csv onboard.bin --align --conflict last --out whole.parquet

    Example: gsapp merge a.csv gps.csv --shift 2:-0.35 --out both.csv

    Example: gsapp merge flight-1 flight-2 --append --pause 60 --out day.csv
    """
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight.processing import append_records, merge_records, resample, shift_time

    output_format(out)
    if len(flights) < 2:
        raise CommandUsageError("merging needs two or more flights")
    if append and align:
        raise CommandUsageError("--append and --align exclude each other; give one")
    check_rate_option(rate)
    shifts = _shifts(shift or (), len(flights))
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


@takes_settings(MANEUVER_SETTINGS, "channel_map", "calibration")
def resample(
    flight: FlightPath,
    out: TableFile,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Samples per second; default: unchanged")
    ] = None,
    low_pass: Annotated[
        float | None,
        typer.Option(
            metavar="HZ",
            min=0.0,
            help="Corner of a zero-phase filter; 0.4 of a lower rate by default, 0 for none",
        ),
    ] = None,
    interpolation: Annotated[
        Literal["linear", "cubic"],
        typer.Option("--interpolation", help="Interpolation between samples"),
    ] = "linear",
    kind: Annotated[Literal["linear", "cubic"] | None, typer.Option("--kind", hidden=True)] = None,
    channels: ChannelList = None,
    without: WithoutList = None,
    rename: RenameList = None,
    units: FileUnits = "us",
    json: JsonFile = None,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Lay a flight on another rate, or filter it.

    The filter shifts no phase.

    Before decimation a zero-phase low-pass takes out what the new rate cannot hold. Gaps stay.

    Example: gsapp resample flights/a --rate 50 --out half.csv

    Example: gsapp resample flights/a --low-pass 5 --channels q,alpha --out smooth.mat

    Example: gsapp resample gps.csv --rate 100 --interpolation cubic --out gps100.csv
    """
    from gsapp.cli._usage_errors import CommandUsageError
    from gsapp.flight import processing

    output_format(out)
    if rate is None and not low_pass:
        raise CommandUsageError("nothing to do; give --rate HZ, --low-pass HZ, or both")
    check_rate_option(rate)
    names = parse_renames(rename or ())
    loaded = load_samples(flight, channel_map, calibration)
    block = select_channels(loaded.block, channels, without, names)
    if rate is None:
        block = processing.low_pass(block, low_pass or 0.0)
    else:
        block = processing.resample(block, rate, corner=low_pass, kind=kind or interpolation)
    write_samples(block, out, units, json, [loaded])


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
            f"{path.name}: {seconds:+.3f} s (correlation {found.correlation:.3f})"
        )
        moved.append(shift_time(block, seconds))
    return moved


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
    out : Path
        Its suffix says the format.
    units : {"us", "si", "base"}
        Of the columns.
    json : Path or None
        Where the answer for programs goes.
    flights : iterable of Flight
        What the block was made from.
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.flight.flight import calibration_json
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
        write_json(json, content)
        if is_stdout(json):
            return
    rate = f" at {1.0 / step:.6g} per s" if step > 0.0 else ""
    PlainConsole().print(
        f"{out}: {len(block)} samples of {len(block.channels)} channels, {start:.2f} to "
        f"{stop:.2f} s{rate}",
        soft_wrap=True,
    )
