"""FTR over a whole recorded flight: how its values form from take-off on."""

from __future__ import annotations

import math

from gsapp.aircraft import Aircraft
from gsapp.flight import Flight
from gsapp.foundation import FlightError
from gsapp.identification.deflections import reconstruct_deflections
from gsapp.identification.ftr.online_regression import FTR
from gsapp.identification.ftr.settings import FTR_ALGORITHM
from gsapp.identification.maneuver import mass_over_flight
from gsapp.quantities import Block


def compute_ftr_history(flight: Flight, aircraft: Aircraft) -> FTR:
    """Return an FTR that has listened to a flight from its first to its last sample.

    Raises
    ------
    FlightError
        If there are too few samples a second, or none at all.
    """
    block = reconstruct_deflections(flight.block, aircraft)
    if len(block) < 2 or not math.isfinite(flight.rate):
        raise FlightError(f"the flight '{flight.name}' contains too few samples for FTR")
    heard = FTR(
        aircraft,
        rate=flight.rate,
        origin=float(block.times[0]),
        mass=float(mass_over_flight(flight, aircraft)[0]),
    )
    for start in range(0, len(block), FTR_ALGORITHM.chunk_samples):
        piece = slice(start, start + FTR_ALGORITHM.chunk_samples)
        heard.feed(
            Block(channels=block.channels, times=block.times[piece], values=block.values[piece])
        )
        heard.process_step()
    heard.finish()
    return heard
