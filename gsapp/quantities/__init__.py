"""The vocabulary: channels, units, and blocks of samples."""

from gsapp.quantities.block import Block, BoolArray, FloatArray
from gsapp.quantities.channels import (
    CHANNELS,
    CIRCULAR_CHANNELS,
    INSTRUMENTS,
    STEPWISE_CHANNELS,
    SURFACE_NAMES,
    ChannelSpec,
    base_id,
    channel,
    name_in_text,
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
from gsapp.quantities.text_units import convert_text_units, convert_value_and_std
from gsapp.quantities.units import (
    QUANTITIES,
    Quantity,
    Values,
    from_si,
    normalize_unit,
    parse_quantity,
    to_si,
)

__all__ = [
    "CHANNELS",
    "CIRCULAR_CHANNELS",
    "INSTRUMENTS",
    "QUANTITIES",
    "STEPWISE_CHANNELS",
    "SURFACE_NAMES",
    "TRACE_COLORS",
    "Block",
    "BoolArray",
    "ChannelSpec",
    "FloatArray",
    "Quantity",
    "Values",
    "base_id",
    "channel",
    "clock_text",
    "convert_text_units",
    "convert_value_and_std",
    "from_si",
    "name_in_text",
    "normalize_unit",
    "parse_quantity",
    "symbol_markup",
    "symbol_parts",
    "symbol_text",
    "to_si",
    "trace_color",
    "typeset",
    "unit_text",
]
