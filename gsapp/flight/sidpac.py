"""Flights for SIDPAC (Klein and Morelli): the array `fdata` in its standard columns, in US units.

Columns: E. A. Morelli, *System IDentification Programs for AirCraft (SIDPAC)*, AIAA-2002-4704, and
the comments of its functions. The channel map ``sidpac`` reads such files.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray, channel, from_si

_WIDTH: Final = 90
_COLUMNS: Final = (
    (2, "V", "ft/s", 1.0), (3, "beta", "deg", 1.0), (4, "alpha", "deg", 1.0),
    (5, "p", "deg/s", 1.0), (6, "q", "deg/s", 1.0), (7, "r", "deg/s", 1.0),
    (8, "phi", "deg", 1.0), (9, "theta", "deg", 1.0), (10, "psi", "deg", 1.0),
    (11, "ax", "g", 1.0), (12, "ay", "g", 1.0), (13, "an", "g", -1.0),
    (14, "de", "deg", 1.0), (15, "da", "deg", -1.0), (16, "dr", "deg", 1.0),
    (27, "qbar", "lbf/ft^2", 1.0), (29, "density", "slug/ft^3", 1.0), (30, "altitude", "ft", 1.0),
    (34, "throttle", "", 1.0), (38, "thrust", "lbf", 1.0), (48, "mass", "slug", 1.0),
)  # fmt: skip
"""Column as MATLAB counts it, channel, unit, sign: a_z is positive down, and the aileron positive
where it rolls to the left (right trailing edge down)."""


def write_sidpac(path: Path | str, block: Block, aircraft: Aircraft | None = None) -> Path:
    """Write a block as a ``.mat`` file with `fdata`, shape (n, 90), and `t`, atomically.

    What was not measured is 0, as SIDPAC has it; a missing sample is NaN.

    Parameters
    ----------
    block : Block
        On an even grid.
    aircraft : Aircraft, optional
        That flew: mass, inertia and geometry.

    Raises
    ------
    FlightError
        If the times are not even.
    """
    from scipy.io import savemat  # a tenth of a second

    steps = np.diff(block.times)
    if not steps.size or np.ptp(steps) > 0.01 * float(np.median(steps)):
        raise FlightError(
            "SIDPAC needs even times, and this record has pauses; cut it with 'gsapp cut'"
        )
    fdata = np.zeros((len(block), _WIDTH))
    fdata[:, 0] = block.times
    if aircraft is not None:
        for column, value in _constants(aircraft).items():
            fdata[:, column - 1] = value
    for column, name, unit, sign in _COLUMNS:
        if name in block:
            fdata[:, column - 1] = sign * _converted(block[name], name, unit)
    content = {"fdata": fdata, "t": (block.times - block.times[0])[:, np.newaxis]}
    with atomic_flight_file(path) as temporary, temporary.open("wb") as stream:
        savemat(stream, content, do_compression=True)
    return Path(path)


def _converted(values: FloatArray, name: str, unit: str) -> FloatArray:
    return from_si(values, unit, channel(name).quantity)


def _constants(aircraft: Aircraft) -> dict[int, float]:
    """Return mass, inertia and geometry by column: slug, slug ft^2, ft^2, ft."""
    mass, geometry = aircraft.mass, aircraft.geometry
    inertia = (mass.ixx, mass.iyy, mass.izz, mass.ixz)
    return {
        48: from_si(mass.mass, "slug", "mass"),
        **{49 + place: from_si(one, "slug*ft^2", "inertia") for place, one in enumerate(inertia)},
        77: from_si(geometry.wing_area, "ft^2", "area"),
        78: from_si(geometry.span, "ft", "length"),
        79: from_si(geometry.chord, "ft", "length"),
    }
