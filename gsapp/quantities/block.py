"""Blocks: stretches of samples, time first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities.channels import channel

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """Samples of several channels at common times.

    Raise ValueError if the shapes do not fit, or a channel is listed twice. Raise UnknownNameError
    if a channel is not in the vocabulary.
    """

    channels: tuple[str, ...]  # Channel ids, each in the vocabulary.
    times: FloatArray  # Shape (n,). Flight time in s, increasing.
    values: FloatArray
    """Shape (n, n_channels). SI units, radians; NaN where missing. Both arrays are float64 and
    read-only."""

    def __post_init__(self) -> None:
        times = np.array(self.times, dtype=np.float64)
        values = np.array(self.values, dtype=np.float64)
        channels = tuple(self.channels)
        if times.ndim != 1 or values.shape != (times.size, len(channels)):
            raise ValueError(
                f"a block of {len(channels)} channels needs times (n,) and values "
                f"(n, {len(channels)}), not {times.shape} and {values.shape}"
            )
        if len(set(channels)) != len(channels):
            raise ValueError(f"a channel is listed twice in {channels}")
        for channel_id in channels:
            channel(channel_id)
        times.setflags(write=False)
        values.setflags(write=False)
        object.__setattr__(self, "channels", channels)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    @classmethod
    def unchecked(cls, channels: tuple[str, ...], times: FloatArray, values: FloatArray) -> Block:
        """Make a block without copying or checking anything.

        For a producer of many small blocks that guarantees what the constructor would check:
        channels of the vocabulary, none twice, and float64 arrays of fitting shapes that nobody
        else writes to. The arrays become read-only.
        """
        block = object.__new__(cls)
        times.setflags(write=False)
        values.setflags(write=False)
        object.__setattr__(block, "channels", channels)
        object.__setattr__(block, "times", times)
        object.__setattr__(block, "values", values)
        return block

    def __len__(self) -> int:
        return int(self.times.size)

    def __contains__(self, channel_id: object) -> bool:
        return channel_id in self.channels

    def __getitem__(self, channel_id: str) -> FloatArray:
        """Return the samples of one channel, shape (n,)."""
        try:
            return self.values[:, self.channels.index(channel_id)]
        except ValueError:
            hint = did_you_mean(channel_id, self.channels, f"it has {', '.join(self.channels)}")
            raise UnknownNameError(f"this flight has no channel '{channel_id}'; {hint}") from None

    def in_memory(self) -> Block:
        """Return the block with its samples in memory (`StoredBlock` reads them)."""
        return self

    def select(self, channel_ids: Sequence[str]) -> Block:
        columns = [self[channel_id] for channel_id in channel_ids]
        values = np.column_stack(columns) if columns else np.empty((len(self), 0))
        return Block(channels=tuple(channel_ids), times=self.times, values=values)

    def between(self, start: float, stop: float) -> Block:
        """Return the samples with ``start <= time < stop`` (s)."""
        low, high = np.searchsorted(self.times, (start, stop), side="left")
        return Block(
            channels=self.channels, times=self.times[low:high], values=self.values[low:high]
        )

    @staticmethod
    def concatenate(blocks: Iterable[Block]) -> Block:
        """Join blocks of the same channels, in the order given."""
        parts = list(blocks)
        if not parts:
            raise ValueError("no block to join")
        if any(part.channels != parts[0].channels for part in parts):
            raise ValueError("blocks of different channels cannot be joined")
        return Block.unchecked(
            parts[0].channels,
            np.concatenate([part.times for part in parts]),
            np.concatenate([part.values for part in parts]),
        )


def join_blocks(blocks: Sequence[Block]) -> list[Block]:
    """Return blocks with those of the same channels that follow each other as one.

    What a consumer does with a block takes about the same time, however many samples it holds.
    """
    groups: list[list[Block]] = []
    newest: dict[tuple[str, ...], list[Block]] = {}
    for block in blocks:
        group = newest.get(block.channels)
        if group is not None and len(block) and block.times[0] > group[-1].times[-1]:
            group.append(block)
        elif len(block):
            newest[block.channels] = [block]
            groups.append(newest[block.channels])
    return [group[0] if len(group) == 1 else Block.concatenate(group) for group in groups]
