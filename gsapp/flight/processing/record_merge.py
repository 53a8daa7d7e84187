"""Several records made one: beside each other, or one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from gsapp.flight.processing.resample_filter import resample
from gsapp.flight.uniform_grid import median_step, overlay_on_grid
from gsapp.foundation import FlightError
from gsapp.quantities import Block

Conflict = Literal["first", "last", "both"]
"""Which record wins where two have the same channel; ``both`` keeps the second as ``.2``."""


def shift_time(block: Block, seconds: float) -> Block:
    """Return a block with a time added to its own."""
    return Block(channels=block.channels, times=block.times + seconds, values=block.values)


def merge_records(
    blocks: Sequence[Block], *, conflict: Conflict = "first", rate: float | None = None
) -> Block:
    """Merge records of one flight by time.

    Parameters
    ----------
    conflict : {"first", "last", "both"}
        Where two have a channel, the winner's samples count and the other fills its holes; or
        both are kept, the later ones as a second sensor.
    rate : float, optional
        Of the result, Hz; by default that of the quickest record.

    Raises
    ------
    FlightError
        If there is nothing to merge.
    """
    if not any(len(block) for block in blocks):
        raise FlightError("the flights contain no samples; nothing to merge")
    if rate is None:
        rate = max(1.0 / median_step(block.times) for block in blocks if len(block) > 1)
    on_grid = [resample(block, rate, corner=0.0) for block in blocks]
    if conflict == "both":
        on_grid = _number_repeated_channels(on_grid)
    merged = overlay_on_grid(on_grid if conflict == "last" else on_grid[::-1], rate)
    return merged.select(list(dict.fromkeys(n for block in on_grid for n in block.channels)))


def append_records(blocks: Sequence[Block], *, pause: float = 10.0) -> Block:
    """Put records one after the other, a pause without samples between them.

    Parameters
    ----------
    blocks : sequence of Block
        Of the same channels or not; what one lacks is missing there.
    pause : float
        Between the last sample of one and the first of the next, s.

    Raises
    ------
    FlightError
        If there is nothing to append.
    """
    filled = [block for block in blocks if len(block)]
    if not filled:
        raise FlightError("the flights contain no samples; nothing to append")
    rate = 1.0 / median_step(filled[0].times)
    parts: list[Block] = []
    end = None
    for block in filled:
        moved = block if end is None else shift_time(block, end + pause - float(block.times[0]))
        parts.append(resample(moved, rate, corner=0.0))
        end = float(moved.times[-1])
    return overlay_on_grid(parts, rate)


def _number_repeated_channels(blocks: Sequence[Block]) -> list[Block]:
    """Give each repetition of a channel the next free number."""
    taken: set[str] = set()
    renamed: list[Block] = []
    for block in blocks:
        names = []
        for name in block.channels:
            base, number, new = name.partition(".")[0], 1, name
            while new in taken:
                number += 1
                new = f"{base}.{number}"
            taken.add(new)
            names.append(new)
        renamed.append(Block(channels=tuple(names), times=block.times, values=block.values))
    return renamed
