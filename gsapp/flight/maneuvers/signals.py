"""The signals that the detection looks at, whichever channels a flight has for them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from gsapp.decoding import air_data
from gsapp.decoding.derived_channels import SURFACE_DERIVATIONS
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.quantities import Block, FloatArray

SURFACES: Final = ("de", "da", "dr")
LEVERS: Final = ("flap", "throttle")
"""What is moved by levers: slower, and not brought back to a trim."""
CONTROLS: Final = (*SURFACES, *LEVERS)
RATES: Final = ("p", "q", "r")
RESPONSE_SIGNALS: Final = ("alpha", "beta", *RATES, "ax", "ay", "an")
"""What answers to an input, and may clip."""

SIGNALS: Final = (*SURFACES, *RESPONSE_SIGNALS, "V", "altitude", "throttle", "rpm", "flap")
"""Columns of what `extract_signals` returns."""

SIGNAL_COLUMNS: Final = {name: place for place, name in enumerate(SIGNALS)}

SURFACE_PARTS: Final = {
    surface: tuple(
        dict.fromkeys(
            name for one in SURFACE_DERIVATIONS if one.output == surface for name in one.inputs
        )
    )
    for surface in SURFACES
}
"""The channels that a combined surface may be made of."""
SURFACE_PAIRS: Final[Mapping[tuple[str, ...], tuple[str, ...]]] = {
    one.inputs: tuple(two.output for two in SURFACE_DERIVATIONS if two.inputs == one.inputs)
    for one in SURFACE_DERIVATIONS
    if len(one.inputs) == 2
}
"""The combined surfaces that two halves move."""


def extract_signals(block: Block) -> FloatArray:
    """Return the signals of a block, SI, shape (n, len(SIGNALS)).

    Each row depends on its own samples only, so that pieces give what the whole gives. NaN where
    neither the channel nor a stand-in has a sample. A surface that was not measured is taken from
    its halves, or else from what the receiver asked of the servo; airspeed and altitude from
    pressures.
    """
    taken = np.empty((len(block), len(SIGNALS)))
    for name in SURFACES:
        taken[:, SIGNAL_COLUMNS[name]] = _surface(block, name)
    for name in RESPONSE_SIGNALS:
        taken[:, SIGNAL_COLUMNS[name]] = _first_available(block, name)
    taken[:, SIGNAL_COLUMNS["V"]] = _airspeed(block)
    taken[:, SIGNAL_COLUMNS["altitude"]] = _altitude(block)
    taken[:, SIGNAL_COLUMNS["rpm"]] = _first_available(block, "rpm_left", "rpm_right")
    taken[:, SIGNAL_COLUMNS["throttle"]] = _throttle(block)
    taken[:, SIGNAL_COLUMNS["flap"]] = _first_available(block, "flap")
    # What no number can be is as good as missing.
    taken[np.isinf(taken)] = np.nan
    return taken


def _first_available(block: Block, *names: str) -> FloatArray:
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
    found = _first_available(block, name)
    if not np.isnan(found).any():
        return found
    for one in SURFACE_DERIVATIONS:
        if one.output == name and not set(one.inputs).isdisjoint(block.channels):
            parts = [_first_available(block, part) for part in one.inputs]
            # One half of two that move alike stands in for both.
            alike = SURFACE_PAIRS.get(one.inputs, (name,)) == (name,)
            for stand_in in (one.compute(*parts), *(parts if alike else ())):
                found = np.where(np.isnan(found), stand_in, found)
    return np.where(np.isnan(found), _first_available(block, f"{name}_command"), found)


def _throttle(block: Block) -> FloatArray:
    """Return the throttle, of several engines their mean."""
    both = 0.5 * (
        _first_available(block, "throttle_left") + _first_available(block, "throttle_right")
    )
    found = _first_available(block, "throttle")
    found = np.where(np.isnan(found), both, found)
    one = _first_available(block, "throttle_left", "throttle_right")
    return np.where(np.isnan(found), one, found)


def _airspeed(block: Block) -> FloatArray:
    found = _first_available(block, "V")
    if not np.isnan(found).any():
        return found
    qbar = _first_available(block, "qbar", "dynamic_pressure")
    static, temperature = (
        _first_available(block, "static_pressure"),
        _first_available(block, "temperature"),
    )
    rho = air_data.density(static, temperature)
    rho = np.where(np.isnan(rho), SEA_LEVEL_DENSITY, rho)
    found = np.where(np.isnan(found), air_data.true_airspeed(qbar, rho), found)
    return np.where(np.isnan(found), _first_available(block, "Vc"), found)


def _altitude(block: Block) -> FloatArray:
    found = _first_available(block, "altitude", "height")
    if not np.isnan(found).any():
        return found
    from_pressure = air_data.altitude(_first_available(block, "static_pressure"))
    return np.where(np.isnan(found), from_pressure, found)
