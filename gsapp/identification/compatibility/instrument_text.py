"""Numbers and names as a crew says them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gsapp.identification.compatibility.settings import ACCELERATION_CHANNELS, RATE_CHANNELS
from gsapp.quantities import channel
from gsapp.quantities.constants import DEGREE, GRAVITY

_SHORT = {"ax": "a_x", "ay": "a_y", "an": "a_n"}


def channel_title(name: str) -> str:
    """Return a channel as spoken of: ``a_y``, ``beta``."""
    return _SHORT.get(name, name)


def join_names(names: Sequence[str]) -> str:
    """Return ``a``, ``a and b``, or ``a, b and c``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _display_unit(name: str) -> tuple[float, str]:
    """Return what a value of a channel is divided by to be shown, and its unit."""
    base = name.partition(".")[0]
    if base in RATE_CHANNELS:
        return DEGREE, "deg/s"
    if base in ACCELERATION_CHANNELS:
        return GRAVITY, "g"
    unit = channel(base).unit
    return (DEGREE, "deg") if unit == "rad" else (1.0, unit)


def format_quantity(name: str, value: float) -> str:
    """Return a value of a channel with its unit: degrees, g, m/s."""
    divisor, unit = _display_unit(name)
    return f"{value / divisor:.2g} {unit}"


def format_error(parameter: str, value: float) -> str:
    """Return the value of an error, ``alpha.delay``, with its unit."""
    name, _, kind = parameter.partition(".")
    if kind == "scale":
        return f"{value:.3g}"
    if kind == "position":
        return f"{value:.2g} m"
    return f"{1e3 * value:z.0f} ms" if kind == "delay" else format_quantity(name, value)


def format_error_with_bound(parameter: str, value: float, std: float) -> tuple[str, str]:
    """Return the value of an error and its bound, both with two digits of the bound."""
    name, _, kind = parameter.partition(".")
    units = {"scale": (1.0, ""), "delay": (1e-3, "ms"), "position": (1.0, "m")}
    divisor, unit = units.get(kind) or _display_unit(name)
    std /= divisor
    digits = max(0, 1 - math.floor(math.log10(std))) if 0.0 < std < math.inf else 3
    value_text, std_text = f"{value / divisor:z.{digits}f}", f"{std:.{digits}f}"
    return f"{value_text} {unit}".rstrip(), f"{std_text} {unit}".rstrip()
