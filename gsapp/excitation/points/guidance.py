"""Towards a test point, in a few words: "3 ft/s slow: a little power"."""

from __future__ import annotations

import math
from typing import Final

from gsapp.excitation.points.point import TestPoint
from gsapp.quantities import channel, from_si

NEAR_ENOUGH: Final = 0.5
"""Share of the tolerance within which nothing is said: advice must not chase noise."""

_FAR = 2.0
"""Tolerances beyond which the throttle that holds the point is said with the advice."""
_HEIGHT_ROOM = 15.0
"""Above or below the point's height, m, before a word is lost about it."""


def guidance(
    point: TestPoint | None,
    *,
    speed: float | None,
    alpha: float | None,
    height: float | None = None,
    system: str = "US",
) -> str:
    """Return short advice towards a test point; empty where there is nothing to say.

    Parameters
    ----------
    point : TestPoint or None
    speed, alpha, height : float or None
        Now, m/s, rad, m above the field; None or NaN where not measured. Speed counts; at 1 g
        it fixes alpha, so alpha speaks where no speed is measured or asked for, and once the
        speed is right.
    system : {"US", "SI"}
    """
    if point is None:
        return ""
    fast = _off(speed, point.speed)
    steep = _off(alpha, point.alpha)
    if fast is not None and abs(fast) > NEAR_ENOUGH * point.speed_tolerance:
        far = abs(fast) > _FAR * point.speed_tolerance
        words = f"{_amount(fast, 'V', system)} {'fast' if fast > 0.0 else 'slow'}"
        return f"{words}: {_power(fast < 0.0, far, point.throttle)}"
    if steep is not None and abs(steep) > max(NEAR_ENOUGH, 1.0 if fast is not None else 0.0) * (
        point.alpha_tolerance
    ):
        words = f"alpha {_amount(steep, 'alpha', system)} {'high' if steep > 0.0 else 'low'}"
        if fast is not None:
            # The speed is right: the load is not 1 g.
            return f"{words}: {'ease the stick' if steep > 0.0 else 'level off gently'}"
        far = abs(steep) > _FAR * point.alpha_tolerance
        return f"{words}: {_power(steep > 0.0, far, point.throttle)}"
    high = _off(height, point.height)
    if high is not None and abs(high) > _HEIGHT_ROOM:
        return f"{_amount(high, 'height', system)} {'high' if high > 0.0 else 'low'}"
    return ""


def _off(value: float | None, wanted: float | None) -> float | None:
    if value is None or wanted is None or not math.isfinite(value):
        return None
    return value - wanted


def _power(more: bool, far: bool, throttle: float | None) -> str:
    """Return what to do with the throttle."""
    if not far or throttle is None:
        return "a little power" if more else "ease the throttle"
    return f"{'power' if more else 'throttle back'}, then {100.0 * throttle:.0f} %"


def _amount(value: float, name: str, system: str) -> str:
    spec = channel(name)
    unit = spec.display_unit(system)
    return f"{abs(from_si(value, unit, spec.quantity)):.0f} {unit}"
