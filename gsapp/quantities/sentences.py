"""Values with their units inside sentences, in the system of units that the reader chose.

Results keep their sentences in SI, as they keep their values; who shows one converts it here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from gsapp.quantities.constants import DEGREE
from gsapp.quantities.units import from_si, to_si

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
}
"""Quantity and US customary unit of each metric unit that a sentence may hold.

Temperatures are not among them: a sentence does not tell a temperature from a difference.
"""

_NUMBER = r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
_VALUE: Final = re.compile(
    rf"(?<![\w.])(?P<numbers>{_NUMBER}(?:(?: to | ± ){_NUMBER})?) "
    rf"(?P<unit>{'|'.join(re.escape(unit) for unit in _US)})(?![\w/^*²³·-])"
)


def in_units(sentence: str, system: str) -> str:
    """Return a sentence with its metric values in the units of a system.

    Parameters
    ----------
    sentence : str
        Values in SI.
    system : {"US", "SI"}

    Examples
    --------
    >>> in_units("V below 26.2 m/s", "US")
    'V below 86.0 ft/s'
    """
    if system != "US":
        return sentence
    return _VALUE.sub(_converted, sentence)


def size_in(value: float, std: float, unit: str, system: str) -> tuple[float, float, str]:
    """Return an SI value, its standard deviation and its unit in the units of a system.

    Angles are in degrees in both; what has no other unit stays as it is.
    """
    if unit in ("rad", "rad/s"):
        return value / DEGREE, std / DEGREE, unit.replace("rad", "deg")
    if system != "US" or unit not in _US:
        return value, std, unit
    quantity, wanted = _US[unit]
    return from_si(value, wanted, quantity), from_si(std, wanted, quantity), wanted


def _converted(match: re.Match[str]) -> str:
    unit = match["unit"]
    numbers = re.sub(_NUMBER, lambda number: _number(number[0], unit), match["numbers"])
    return f"{numbers} {_US[unit][1]}"


def _number(text: str, unit: str) -> str:
    """Return a number in the other unit, with as many digits that count."""
    quantity, wanted = _US[unit]
    plain = text.replace("−", "-")
    value = from_si(to_si(float(plain), unit, quantity), wanted, quantity)
    digits = len(plain.partition("e")[0].strip("+-").replace(".", "").lstrip("0"))
    size = math.floor(math.log10(abs(value))) if value else 0
    shown = f"{value:.{min(max(max(digits, 2) - 1 - size, 0), 9)}f}"
    shown = f"+{shown}" if text.startswith("+") and value >= 0.0 else shown
    return shown.replace("-", "−") if "−" in text else shown
