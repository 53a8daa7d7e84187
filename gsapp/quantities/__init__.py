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
from gsapp.quantities.notation import (
    TRACE_COLORS,
    clock_text,
    symbol_markup,
    symbol_parts,
    symbol_text,
    trace_color,
    typeset,
    unit_text,
)
from gsapp.quantities.sentences import in_units, size_in
from gsapp.quantities.units import QUANTITIES, Quantity, from_si, normalize_unit, parse, to_si

__all__ = [
    "CHANNELS",
    "CIRCULAR",
    "INSTRUMENTS",
    "QUANTITIES",
    "STEPWISE",
    "TRACE_COLORS",
    "Block",
    "BoolArray",
    "ChannelSpec",
    "FloatArray",
    "Quantity",
    "base_id",
    "channel",
    "clock_text",
    "from_si",
    "in_units",
    "normalize_unit",
    "parse",
    "size_in",
    "symbol_markup",
    "symbol_parts",
    "symbol_text",
    "to_si",
    "trace_color",
    "typeset",
    "unit_text",
]
