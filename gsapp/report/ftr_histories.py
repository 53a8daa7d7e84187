"""What FTR would have formed over the flights of a report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from gsapp.aircraft import Aircraft
from gsapp.flight import Flight
from gsapp.foundation import FlightError
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.ftr.maneuver_estimator import compute_ftr_history
from gsapp.report.settings import REPORT


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightEstimateHistory:
    """What FTR formed over one flight."""

    flight: str
    histories: Mapping[str, EstimateHistory] = field(default_factory=dict)
    why: str = ""
    """Why there is none, in words."""


def compute_ftr_histories(
    flights: Sequence[tuple[Flight, Aircraft]],
    *,
    most: int | None = REPORT.max_ftr_flights,
    doing: Callable[[str], object] | None = None,
) -> tuple[FlightEstimateHistory, ...]:
    """Let FTR listen to flights from take-off on.

    Parameters
    ----------
    most : int, optional
        Flights to listen to, from the first on; None for all.
    """
    found = []
    for flight, aircraft in flights[:most]:
        if doing is not None:
            doing(f"computing FTR over {flight.name}")
        try:
            ftr = compute_ftr_history(flight, aircraft)
        except FlightError as error:
            found.append(FlightEstimateHistory(flight=flight.name, why=str(error)))
            continue
        found.append(
            FlightEstimateHistory(
                flight=flight.name, histories={name: ftr.history(name) for name in ftr.names}
            )
        )
    return tuple(found)
