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
    """What FTR formed over one flight.

    Attributes
    ----------
    flight : str
        Its name.
    histories : mapping of str to EstimateHistory
        By derivative; empty where it could not listen.
    why : str
        Why it could not, in words.
    """

    flight: str
    histories: Mapping[str, EstimateHistory] = field(default_factory=dict)
    why: str = ""


def compute_ftr_histories(
    flights: Sequence[tuple[Flight, Aircraft]],
    *,
    most: int | None = REPORT.max_ftr_flights,
    doing: Callable[[str], object] | None = None,
) -> tuple[FlightEstimateHistory, ...]:
    """Let FTR listen to flights from take-off on.

    Parameters
    ----------
    flights : sequence of (Flight, Aircraft)
        Each with the aircraft as it flew it.
    most : int, optional
        Flights to listen to, from the first on; None for all.
    doing : callable, optional
        Told what is being done, in words, before each flight.
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
