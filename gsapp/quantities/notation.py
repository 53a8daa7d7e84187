"""How quantities appear on screen and on paper: symbols, colors, flight time.

Figures and tables on screen typeset a symbol (δe, α, Cmα with subscripts where the widget has
them); text and files write its id (`de`, `alpha`, `Cm_alpha`).
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Mapping
from typing import Final

from gsapp.foundation import UnknownNameError
from gsapp.quantities.channels import base_id, channel

_GREEK: Final[Mapping[str, str]] = {
    "alpha": "α", "beta": "β", "delta": "δ", "phi": "φ", "theta": "θ", "psi": "ψ", "chi": "χ",
    "rho": "ρ", "qbar": "q\N{COMBINING MACRON}",
}  # fmt: skip
_SUFFIXES: Final[Mapping[str, str]] = {
    "alpha": "α", "beta": "β", "de": "δe", "da": "δa", "dr": "δr", "0": "0",
    "p": "p", "q": "q", "r": "r", "V": "V", "alpha2": "α²", "beta2": "β²",
    "alphadot": "α\N{COMBINING DOT ABOVE}", "betadot": "β\N{COMBINING DOT ABOVE}",
}  # fmt: skip
_COEFFICIENT: Final = re.compile(r"C([XYZNALDlmn])(?:_(\w+))?")

_DERIVATIVE: Final = re.compile(r"\bC[XYZNALDlmn]_[A-Za-z0-9]+\b")

TRACE_COLORS: Final = ("blue", "purple", "rust", "ink", "sky", "olive")
"""Names of the trace colors, in the order in which charts use them for further lines: the
Okabe-Ito set without its orange and green, which would pass for states."""
_AXIS_COLORS: Final[Mapping[str, str]] = {
    **dict.fromkeys(
        ("de", "elevator_left", "elevator_right", "stick_pitch", "alpha", "q", "theta", "an", "ax",
         "CN", "CA", "CX", "CZ", "CL", "CD", "Cm"), "blue"),
    **dict.fromkeys(("da", "aileron_left", "aileron_right", "stick_roll", "p", "phi", "Cl"),
                    "purple"),
    **dict.fromkeys(("dr", "rudder", "stick_yaw", "beta", "r", "psi", "track", "ay", "CY", "Cn"),
                    "rust"),
}  # fmt: skip
_GROUP_COLORS: Final[Mapping[str, str]] = {"Air data": "sky", "Propulsion": "olive"}
_UNIT_MARKS: Final = (
    ("^2", "²"),
    ("^3", "³"),
    ("degC", "°C"),
    ("degF", "°F"),
    ("deg", "°"),
    ("*", "·"),
)
_DERIVED: Final = re.compile(r"_(volts|command)$")


def trace_color(name: str) -> str:
    """Return the trace color of a channel, a coefficient or a derivative, the same in every figure.

    Pitch is blue, roll purple, yaw rust, air data sky blue, propulsion olive, the rest ink.
    """
    match = _COEFFICIENT.fullmatch(name)
    base = f"C{match[1]}" if match else _DERIVED.sub("", base_id(name))
    if base in _AXIS_COLORS:
        return _AXIS_COLORS[base]
    try:
        return _GROUP_COLORS.get(channel(base).group, "ink")
    except UnknownNameError:
        return "ink"


def symbol_parts(symbol: str) -> tuple[str, str, str]:
    """Return letter, subscript and rest: ``delta_e left`` gives ``δ``, ``e``, `` left``.

    The symbol of a channel, or the name of a coefficient or a derivative: ``Cm_alpha`` gives
    ``C``, ``mα``. Any other name has neither subscript nor rest.
    """
    match = _COEFFICIENT.fullmatch(symbol)
    if match is not None:
        suffix = match[2] or ""
        if suffix and suffix not in _SUFFIXES:
            return symbol, "", ""
        return "C", match[1] + _SUFFIXES.get(suffix, ""), ""
    if "." in symbol:
        return symbol, "", ""
    head, blank, rest = symbol.partition(" ")
    base, _, below = head.partition("_")
    if below == "dot":
        base, below = _GREEK.get(base, base) + "\N{COMBINING DOT ABOVE}", ""
    return _GREEK.get(base, base), below, blank + rest


def symbol_text(symbol: str) -> str:
    """Return a symbol in Unicode: ``δe left``, ``ax``, ``Cmα``."""
    return "".join(symbol_parts(symbol))


def unit_text(unit: str) -> str:
    """Return a unit as it is shown: ``lbf/ft^2`` as ``lbf/ft²``, ``deg/s`` as ``°/s``."""
    for plain, shown in _UNIT_MARKS:
        unit = unit.replace(plain, shown)
    return unit


def symbol_markup(symbol: str) -> str:
    """Return a symbol as rich text, with its subscript."""
    base, below, rest = map(html.escape, symbol_parts(symbol))
    return f"{base}<sub>{below}</sub>{rest}" if below else base + rest


def typeset(text: str) -> str:
    """Return a text with the names of derivatives as symbols: ``Cm_alpha`` becomes ``Cmα``."""
    return _DERIVATIVE.sub(lambda found: symbol_text(found[0]), text)


def clock_text(seconds: float | None, *, decimals: int = 0) -> str:
    """Return flight time as ``04:07``, ``1:04:07``, or with one decimal ``04:07.3``."""
    if seconds is None or not math.isfinite(seconds):
        return "–"
    scale = 10**decimals
    # Truncated, as clocks are: 59.96 s is not yet a minute.
    ticks = int(abs(seconds) * scale + 1e-6)
    whole, part = divmod(ticks, scale)
    minutes, second = divmod(whole, 60)
    hours, minute = divmod(minutes, 60)
    text = f"{hours}:{minute:02d}:{second:02d}" if hours else f"{minute:02d}:{second:02d}"
    if decimals:
        text += f".{part:0{decimals}d}"
    return f"−{text}" if seconds < 0 and ticks else text
