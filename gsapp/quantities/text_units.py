"""Values with their units inside sentences, in the system of units that the reader chose.

Results keep their sentences in SI, as they keep their values; who shows one converts it here. So
does who shows what was worded in another system of units: a cue of a flight, a source. What stands
in quotes was typed like that, and stays.
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
    """Return a sentence with its values in the units of a system.

    Parameters
    ----------
    system : {"US", "SI"}

    Examples
    --------
    >>> in_units("V below 26.2 m/s", "US")
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
