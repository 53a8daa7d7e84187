"""How quantities appear on screen and on paper: symbols, colors, flight time.

Figures and tables on screen typeset a symbol (δe, α, Cmα with subscripts where the widget has
them); text and files write its id (`de`, `alpha`, `Cm_alpha`). Results keep their sentences in SI
as they keep their values; who shows one converts the values in it, but not what stands in quotes.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Mapping
from typing import Final

from gsapp.foundation import UnknownNameError
from gsapp.quantities.channels import base_id, channel
from gsapp.quantities.constants import DEGREE
from gsapp.quantities.units import from_si, to_si

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
        ("de", "elevator_left", "elevator_right", "ruddervator_left", "ruddervator_right",
         "elevon_left", "elevon_right", "stick_pitch", "alpha", "q", "theta", "an", "ax",
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


_US: Final[Mapping[str, tuple[str, str]]] = {
    "m/s^2": ("acceleration", "ft/s^2"),
    "m/s": ("speed", "ft/s"),
    "km": ("length", "mi"),
    "mm": ("length", "in"),
    "m": ("length", "ft"),
    "kg/m^3": ("density", "slug/ft^3"),
    "kg*m^2": ("inertia", "slug*ft^2"),
    "kg": ("mass", "lb"),
    "N*m": ("moment", "lbf*ft"),
    "N": ("force", "lbf"),
    "hPa": ("pressure", "inHg"),
    "kPa": ("pressure", "psi"),
    "Pa": ("pressure", "lbf/ft^2"),
    "degC": ("temperature", "degF"),
}
"""Quantity and US customary unit of each metric unit that a sentence may hold.

A difference of temperatures is written in K, which stays.
"""
_SI: Final[Mapping[str, tuple[str, str]]] = {
    customary: (quantity, metric)
    for metric, (quantity, customary) in _US.items()
    # "3 in 5 maneuvers" is no length.
    if customary != "in"
}
_OTHER: Final = {"US": _US, "SI": _SI}
"""For each system what is converted into it."""

_NUMBER = r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def _values(units: Mapping[str, object]) -> re.Pattern[str]:
    names = "|".join(re.escape(unit) for unit in sorted(units, key=len, reverse=True))
    return re.compile(
        rf"(?<![\w.'\"+−-])(?P<numbers>{_NUMBER}(?:(?: to | ± ){_NUMBER})?) "
        rf"(?P<unit>{names})(?![\w/^*²³·-])"
    )


_VALUES: Final = {system: _values(units) for system, units in _OTHER.items()}


def convert_text_units(sentence: str, system: str) -> str:
    """Return a sentence with its values in the units of a system, ``US`` or ``SI``.

    Examples
    --------
    >>> convert_text_units("V below 26.2 m/s", "US")
    'V below 86.0 ft/s'
    """
    units = _OTHER[system]

    def converted(match: re.Match[str]) -> str:
        unit = match["unit"]
        quantity, wanted = units[unit]
        zero = 0.0
        shown = []
        for part in re.split(r"( to | ± )", match["numbers"]):
            if part in (" to ", " ± "):
                # A spread has no offset, as temperatures have.
                zero = _convert(0.0, unit, quantity, wanted) if part == " ± " else 0.0
                shown.append(part)
            else:
                value = _convert(float(part.replace("−", "-")), unit, quantity, wanted)
                shown.append(_with_digits(value - zero, part))
        return f"{''.join(shown)} {wanted}"

    return _VALUES[system].sub(converted, sentence)


def convert_value_and_std(
    value: float, std: float, unit: str, system: str
) -> tuple[float, float, str]:
    """Return an SI value, its standard deviation and its unit in the units of a system.

    Angles are in degrees in both; what has no other unit stays as it is.
    """
    if unit in ("rad", "rad/s"):
        return value / DEGREE, std / DEGREE, unit.replace("rad", "deg")
    if system != "US" or unit not in _US:
        return value, std, unit
    quantity, wanted = _US[unit]
    return from_si(value, wanted, quantity), from_si(std, wanted, quantity), wanted


def _convert(value: float, unit: str, quantity: str, wanted: str) -> float:
    return from_si(to_si(value, unit, quantity), wanted, quantity)


def _with_digits(value: float, text: str) -> str:
    """Return a converted number with as many digits that count as the text it comes from."""
    plain = text.partition("e")[0].strip("+-−").replace(".", "").lstrip("0")
    size = math.floor(math.log10(abs(value))) if value else 0
    shown = f"{value:.{min(max(max(len(plain), 2) - 1 - size, 0), 9)}f}"
    shown = f"+{shown}" if text.startswith("+") and value >= 0.0 else shown
    return shown.replace("-", "−") if "−" in text else shown
