"""Numbers and names as a crew says them."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.identification.compatibility.settings import ACCELERATIONS, RATES
from gsapp.quantities import channel
from gsapp.quantities.constants import DEGREE, GRAVITY

_SHORT = {"ax": "a_x", "ay": "a_y", "an": "a_n"}


def title(name: str) -> str:
    """Return a channel as spoken of: ``a_y``, ``beta``."""
    return _SHORT.get(name, name)


def listed(names: Sequence[str]) -> str:
    """Return ``a``, ``a and b``, or ``a, b and c``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def quantity(name: str, value: float) -> str:
    """Return a value of a channel with its unit: degrees, g, m/s."""
    base = name.partition(".")[0]
    if base in RATES:
        return f"{value / DEGREE:.2g} deg/s"
    if base in ACCELERATIONS:
        return f"{value / GRAVITY:.2g} g"
    spec = channel(base)
    if spec.unit == "rad":
        return f"{value / DEGREE:.2g} deg"
    return f"{value:.2g} {spec.unit}"


def error_quantity(parameter: str, value: float) -> str:
    """Return the value of an error, ``alpha.delay``, with its unit."""
    name, _, kind = parameter.partition(".")
    if kind == "scale":
        return f"{value:.3g}"
    return f"{1e3 * value:z.0f} ms" if kind == "delay" else quantity(name, value)
