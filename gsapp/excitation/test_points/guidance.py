"""Towards a test point, in a few words: "3 ft/s slow: a little power"."""

from __future__ import annotations

import math
from typing import Final

from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.trim_cue import TrimDeviation

DEADBAND_SHARE: Final = 0.5
"""Share of the tolerance within which nothing is said: advice must not chase noise."""

_FAR = 2.0
"""Tolerances beyond which the throttle that holds the point is said with the advice."""


def guidance_text(
    point: TestPoint | None,
    *,
    speed: float | None,
    alpha: float | None,
    system: str = "US",
) -> str:
    """Return short advice towards a test point; empty where there is nothing to say.

    Parameters
    ----------
    speed, alpha : float or None
        Now, m/s, rad; None or NaN where not measured. Speed counts; at 1 g it fixes alpha, so
        alpha speaks where no speed is measured or asked for, and once the speed is right.
    system : {"US", "SI"}
    """
    if point is None:
        return ""
    fast = _deviation(speed, point.speed)
    steep = _deviation(alpha, point.alpha)
    if fast is not None and abs(fast) > DEADBAND_SHARE * point.speed_tolerance:
        share = abs(fast) / point.speed_tolerance
        words = TrimDeviation(
            quantity="speed", amount=fast, tolerance_ratio=share, channel="V"
        ).format_text(system)
        return f"{words}: {_throttle_advice(fast < 0.0, share > _FAR, point.throttle)}"
    if steep is not None:
        share = abs(steep) / point.alpha_tolerance
        words = TrimDeviation(
            quantity="alpha", amount=steep, tolerance_ratio=share, channel="alpha"
        ).format_text(system)
        if fast is not None and share > 1.0:
            # The speed is right, so the load is not 1 g: in a turn that is as it should be.
            return words
        if fast is None and share > DEADBAND_SHARE:
            return f"{words}: {_throttle_advice(steep > 0.0, share > _FAR, point.throttle)}"
    return ""


def _deviation(value: float | None, wanted: float | None) -> float | None:
    if value is None or wanted is None or not math.isfinite(value):
        return None
    return value - wanted


def _throttle_advice(more: bool, far: bool, throttle: float | None) -> str:
    if not far or throttle is None:
        return "a little power" if more else "ease the throttle"
    return f"{'power' if more else 'throttle back'}, then {100.0 * throttle:.0f} %"
