"""From rows of a live flight to a maneuver that estimators take."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.flight_rows import FlightRows
from gsapp.flight import Flight
from gsapp.flight.maneuvers.signals import RESPONSE_SIGNALS, SURFACES
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.quantities import Block

ESTIMATION_CHANNELS: Final = (
    *SURFACES, *RESPONSE_SIGNALS, "V", "phi", "theta", "psi", "qbar", "dynamic_pressure", "density",
    "static_pressure", "temperature", "throttle", "throttle_left", "throttle_right", "flap",
)  # fmt: skip
"""What estimates are made from, as far as a flight has it."""


def block_from_rows(rows: FlightRows) -> Block:
    """Return the channels of rows that hold anything and that estimates are made from."""
    there = [name for name in ESTIMATION_CHANNELS if np.isfinite(rows[name]).any()]
    values = np.column_stack([rows[name] for name in there]) if there else None
    return Block(
        channels=tuple(there),
        times=rows.times,
        values=np.empty((len(rows), 0)) if values is None else values,
    )


def maneuver_from_rows(
    rows: FlightRows,
    aircraft: Aircraft,
    t_start: float,
    t_end: float,
    *,
    id: str,  # noqa: A002 - as everywhere
    inputs: Sequence[str],
    mass: float,
) -> Maneuver:
    """Return a maneuver cut from rows as it will be cut from the record after the flight.

    Parameters
    ----------
    rows : FlightRows
        Some more on both sides help: channels are brought to their right time.
    t_start, t_end : float
        Flight time of its first and last sample, s.
    inputs : sequence of str
        Surfaces that were moved.
    mass : float
        kg.

    Raises
    ------
    FlightError
        If the rows hold nothing of it.
    """
    flight = Flight(name="this flight", path=Path(), block=block_from_rows(rows), sources={})
    return cut_maneuver(
        flight,
        aircraft,
        t_start,
        t_end,
        id=id,
        inputs=inputs,
        mass=np.full(len(rows), mass),
    )
