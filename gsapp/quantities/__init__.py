"""The vocabulary: channels, units, and blocks of samples."""

from gsapp.quantities.block import Block, BoolArray, FloatArray
from gsapp.quantities.channels import (
    CHANNELS,
    CIRCULAR,
    INSTRUMENTS,
    STEPWISE,
    ChannelSpec,
    base_id,
    channel,
)
from gsapp.quantities.units import QUANTITIES, Quantity, from_si, normalize_unit, parse, to_si

__all__ = [
    "CHANNELS",
    "CIRCULAR",
    "INSTRUMENTS",
    "QUANTITIES",
    "STEPWISE",
    "Block",
    "BoolArray",
    "ChannelSpec",
    "FloatArray",
    "Quantity",
    "base_id",
    "channel",
    "from_si",
    "normalize_unit",
    "parse",
    "to_si",
]
