"""Instruments that showed nothing but the end of their range, or nothing new: not measured.

A vane with a broken wire stands at one end for the whole maneuver. What the others measured is
worth as much as if it had never been mounted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.clipping import at_range_end, instrument_ranges
from gsapp.flight.maneuvers.signals import SURFACES
from gsapp.quantities import FloatArray

AIRSPEED: Final = ("V", "Vc", "qbar", "dynamic_pressure")
"""Channels that all come from the one probe."""

_SHARE: Final = 0.95
"""Share of a maneuver's samples at the end of the range from which an instrument is dead."""
_BEYOND_TRAVEL: Final = 0.5
"""Share of its travel that no surface ever goes beyond it: what reads more is a broken wire."""
_NO_SPEED: Final = 0.3
"""An aircraft that answers to its surfaces flies faster than this share of its stall speed."""
_FEWEST: Final = 20
_SAME: Final = 1e-9
"""Share of its size that a value may change by, brought to another time, and still be the same."""


def dead_instruments(
    samples: Callable[[str], FloatArray], aircraft: Aircraft
) -> dict[str, tuple[str, ...]]:
    """Return the instruments that were dead over a maneuver.

    Parameters
    ----------
    samples : callable
        Gives the samples (SI) of a channel within the maneuver, missing ones as NaN or left out;
        empty or all NaN for a channel that there is not.
    aircraft : Aircraft

    Returns
    -------
    dict of str to tuple of str
        In words what it is, and its channels: ``{"alpha": ("alpha",), "airspeed": AIRSPEED}``.
    """
    found: dict[str, tuple[str, ...]] = {}
    for name, limits in instrument_ranges(aircraft).items():
        values = _present(samples(name))
        if values.size >= _FEWEST and at_range_end(values, limits).mean() >= _SHARE:
            found[name] = (name,)
    for name, (low, high) in _travels(aircraft).items():
        values = _present(samples(name))
        beyond = _BEYOND_TRAVEL * (high - low)
        gone = (values < low - beyond) | (values > high + beyond)
        if values.size >= _FEWEST and gone.mean() >= _SHARE:
            found[name] = (name,)
    speed = _present(samples("V"))
    if speed.size >= _FEWEST and float(speed.max()) < _NO_SPEED * aircraft.limits.stall_speed:
        found["airspeed"] = AIRSPEED
    pressure = _present(samples("dynamic_pressure"))
    if pressure.size >= _FEWEST and np.ptp(pressure) <= _SAME * np.abs(pressure).max():
        # No maneuver is flown at one speed to the last bit: the tube is blocked, the sensor stuck.
        found["airspeed"] = AIRSPEED
    return found


def _travels(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return how far each surface goes, rad."""
    return {name: getattr(aircraft.controls, name).travel for name in SURFACES}


def dead_words(instruments: dict[str, tuple[str, ...]]) -> str:
    """Return a sentence on what was dead; empty for nothing."""
    if not instruments:
        return ""
    *first, last = instruments
    listed = f"{', '.join(first)} and {last}" if first else last
    return (
        f"{listed} {'were' if first else 'was'} dead, at the end of the range, beyond it or the "
        "same throughout: taken as not measured"
    )


def _present(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]
