"""Degrees in the pilot's language: shares of the stick and the position of the rate switch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from gsapp.aircraft import Aircraft, Control
from gsapp.excitation.settings import INPUTS
from gsapp.quantities.constants import DEGREE

STICK_SHARES: Final = {
    "tenth of": 0.1,
    "quarter": 0.25,
    "third of": 1.0 / 3.0,
    "half": 0.5,
    "two thirds": 2.0 / 3.0,
    "three quarters": 0.75,
    "full": 1.0,
}
"""What pilots call shares of a stick's way."""

STICK_NAMES: Final = {"de": "stick", "da": "stick", "dr": "rudder"}
"""What moves each surface, as it is said."""


_FACTORS: Final = {
    **{f"{-change} % smaller": 1.0 + change / 100 for change in (-75, -65, -50, -35, -25, -10)},
    **{f"{change} % larger": 1.0 + change / 100 for change in (10, 25, 35, 50)},
    "twice as large": 2.0,
    "three times as large": 3.0,
    "four times as large": 4.0,
}
"""As finely as a pilot can follow."""


def format_sticks(
    aircraft: Aircraft | None,
    amplitudes: Mapping[str, float],
    *,
    rate_switch: float | None = None,
) -> dict[str, str]:
    """Return the words for surfaces that move in one input: one position of the switch for all.

    `rate_switch` is as measured: 1 high, 0 low; None or NaN where it is not known. A known position
    stays where the deflections can be flown with it. Without an aircraft degrees stay.
    """
    if aircraft is None:
        return {name: _format_degrees(size) for name, size in amplitudes.items()}
    high = needs_high_rate(aircraft, amplitudes, rate_switch=rate_switch)
    return {name: _stick_text(aircraft, name, size, high) for name, size in amplitudes.items()}


def needs_high_rate(
    aircraft: Aircraft, amplitudes: Mapping[str, float], *, rate_switch: float | None = None
) -> bool:
    """Return whether the rate switch should be high for these deflections.

    Arguments as for `format_sticks`.
    """
    shares = {
        high: [_share(aircraft, name, size, high) for name, size in amplitudes.items()]
        for high in (True, False)
    }
    if rate_switch is not None and math.isfinite(rate_switch):
        now = rate_switch > 0.5
        if all(INPUTS.stick_range[0] <= share <= INPUTS.stick_range[1] for share in shares[now]):
            return now
    return min(
        shares,
        key=lambda high: (
            sum(_outside(share, INPUTS.good_stick_range) for share in shares[high]),
            sum(abs(share - 0.5) for share in shares[high]),
        ),
    )


def _stick_text(aircraft: Aircraft, surface: str, amplitude: float, high: bool) -> str:
    share, lever = _share(aircraft, surface, amplitude, high), STICK_NAMES[surface]
    if not math.isfinite(share):
        return _format_degrees(amplitude)
    control: Control = getattr(aircraft.controls, surface)
    alike = math.isclose(control.full_stick_high, control.full_stick_low, rel_tol=0.02)
    rate = "" if alike else f", {'high' if high else 'low'} rate"
    if share > INPUTS.max_stick:
        return f"full {lever}{rate}, and more than that"
    return f"{format_share(share)} {lever}{rate}"


def _format_degrees(amplitude: float) -> str:
    return f"{abs(amplitude) / DEGREE:.2g} deg"


def _share(aircraft: Aircraft, surface: str, amplitude: float, high: bool) -> float:
    control: Control = getattr(aircraft.controls, surface)
    way = abs(control.full_stick_high if high else control.full_stick_low)
    return abs(amplitude) / way if way > 0.0 else math.inf


def format_share(share: float) -> str:
    """Return the nearest share that pilots have a word for: "two thirds"."""
    return min(STICK_SHARES, key=lambda text: abs(STICK_SHARES[text] - share))


def format_amplitude_change(factor: float) -> str:
    """Return by how much an amplitude should change: "50 % larger", "twice as large".

    10 % is the least.
    """
    if not factor > 0.0 or factor > INPUTS.max_change:
        return "much larger"
    if factor < INPUTS.min_change:
        return "much smaller"
    return min(_FACTORS, key=lambda text: abs(math.log(_FACTORS[text] / factor)))


def format_width_change(width: float, wanted: float) -> str:
    """Return how long a step (s) should be: "quicker: 0.4 s each way"."""
    way = f"{wanted:.1f} s each way" if wanted >= 0.095 else f"{wanted:.2f} s each way"
    if abs(width / wanted - 1.0) < INPUTS.width_tolerance:
        return way
    return f"{'quicker' if width > wanted else 'hold longer'}: {way}"


def _outside(share: float, limits: tuple[float, float]) -> float:
    return max(limits[0] - share, share - limits[1], 0.0)
