"""Renaming and leaving out channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gsapp.foundation import FlightError
from gsapp.quantities import Block, channel


def rename_channels(block: Block, names: Mapping[str, str]) -> Block:
    """Give channels other ids of the vocabulary.

    Parameters
    ----------
    names : mapping of str to str
        Old id to new id. Two may be swapped.

    Raises
    ------
    UnknownNameError
        If the block lacks an old id, or the vocabulary a new one.
    FlightError
        If two channels would have one id, or the new one measures another quantity.
    """
    for old, new in names.items():
        block[old]
        if channel(old).quantity != channel(new).quantity:
            raise FlightError(
                f"{old} measures {channel(old).quantity} and {new} {channel(new).quantity}; "
                "rename it to a channel of the same quantity"
            )
    renamed = tuple(names.get(name, name) for name in block.channels)
    if len(set(renamed)) != len(renamed):
        double = next(name for name in renamed if renamed.count(name) > 1)
        raise FlightError(
            f"after renaming two channels would be called {double}; rename the other one too, "
            f"to {double}.2 for a second sensor"
        )
    return Block(channels=renamed, times=block.times, values=block.values)


def drop_channels(block: Block, names: Sequence[str]) -> Block:
    """Leave channels out.

    Raises
    ------
    UnknownNameError
        If the block lacks one of them.
    """
    for name in names:
        block[name]
    return block.select([name for name in block.channels if name not in names])
