"""The signals that the detection looks at, whichever channels a flight has for them."""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.decoding import air_data
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.quantities import Block, FloatArray

SURFACES: Final = ("de", "da", "dr")
RATES: Final = ("p", "q", "r")
ANSWERS: Final = ("alpha", "beta", *RATES, "ax", "ay", "an")
"""What answers to an input, and may clip."""

SIGNALS: Final = (*SURFACES, *ANSWERS, "V", "altitude", "throttle", "rpm")
"""Columns of what `signals_of` returns."""

COLUMN: Final = {name: place for place, name in enumerate(SIGNALS)}

HALVES: Final = {
    "de": ("elevator_left", "elevator_right"),
    "da": ("aileron_left", "aileron_right"),
}
"""The channels that a combined surface is made of."""
_WHOLE: Final = ("rudder", "rudder")
"""One that has no halves, in the place of both."""


def signals_of(block: Block) -> FloatArray:
    """Return the signals of a block, row by row.

    Each row depends on its own samples only, so that pieces give what the whole gives.

    Parameters
    ----------
    block : Block

    Returns
    -------
    ndarray, shape (n, len(SIGNALS))
        SI; NaN where neither the channel nor a stand-in has a sample. A surface that was not
        measured is taken from its halves, or else from what the receiver asked of the servo;
        airspeed and altitude from pressures.
    """
    taken = np.empty((len(block), len(SIGNALS)))
    for name in SURFACES:
        taken[:, COLUMN[name]] = _surface(block, name)
    for name in ANSWERS:
        taken[:, COLUMN[name]] = _first(block, name)
    taken[:, COLUMN["V"]] = _airspeed(block)
    taken[:, COLUMN["altitude"]] = _altitude(block)
    taken[:, COLUMN["rpm"]] = _first(block, "rpm_left", "rpm_right")
    taken[:, COLUMN["throttle"]] = _first(block, "throttle", "throttle_left", "throttle_right")
    # What no number can be is as good as missing.
    taken[np.isinf(taken)] = np.nan
    return taken


def _first(block: Block, *names: str) -> FloatArray:
    """Return, sample by sample, the first of these channels that has one."""
    found: FloatArray | None = None
    for name in names:
        if name not in block:
            continue
        if found is None:
            found = block[name]
        elif (gone := np.isnan(found)).any():
            found = np.where(gone, block[name], found)
    return np.full(len(block), np.nan) if found is None else found


def _surface(block: Block, name: str) -> FloatArray:
    found = _first(block, name)
    if not np.isnan(found).any():
        return found
    left, right = (_first(block, half) for half in HALVES.get(name, _WHOLE))
    for stand_in in (0.5 * (left + right), left, right, _first(block, f"{name}_command")):
        found = np.where(np.isnan(found), stand_in, found)
    return found


def _airspeed(block: Block) -> FloatArray:
    found = _first(block, "V")
    if not np.isnan(found).any():
        return found
    qbar = _first(block, "qbar", "dynamic_pressure")
    static, temperature = _first(block, "static_pressure"), _first(block, "temperature")
    rho = air_data.density(static, temperature)
    rho = np.where(np.isnan(rho), SEA_LEVEL_DENSITY, rho)
    found = np.where(np.isnan(found), air_data.true_airspeed(qbar, rho), found)
    return np.where(np.isnan(found), _first(block, "Vc"), found)


def _altitude(block: Block) -> FloatArray:
    found = _first(block, "altitude", "height")
    if not np.isnan(found).any():
        return found
    from_pressure = air_data.altitude(_first(block, "static_pressure"))
    return np.where(np.isnan(found), from_pressure, found)
