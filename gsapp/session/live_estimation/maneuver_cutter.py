"""A maneuver cut from a flight that is still being watched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.flight import Flight
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.info import FlightInfo
from gsapp.identification.maneuver import Maneuver, cut_maneuver, mass_over_flight
from gsapp.identification.maneuver_extraction import correct_for_burned_fuel
from gsapp.quantities import Block
from gsapp.session.sample_history import SampleHistory

_AROUND: Final = 1.0
"""Seconds beside a maneuver that bringing late channels to their time may reach into."""
_BURNS: Final = "throttle"
"""Channel by which fuel burns."""


class ManeuverCutter:
    """Cuts maneuvers from a session's history, as `cut_maneuver` does from a whole flight.

    Parameters
    ----------
    aircraft : Aircraft
        Of the file; what the flight card says of the day is seen to.
    info : callable
        Returns the flight card as it is now; None without one.
    """

    def __init__(
        self,
        history: SampleHistory,
        aircraft: Aircraft,
        info: Callable[[], FlightInfo | None],
        name: str,
    ) -> None:
        self._history = history
        self._aircraft = aircraft
        self._info = info
        self._name = name

    def __call__(self, verdict: InputVerdict) -> Maneuver:
        """Cut the maneuver that a verdict is about.

        Raises
        ------
        FlightError
            If there are no samples of it.
        """
        info = self._info()
        carded = apply_flight_info(self._aircraft, info)
        block = self._history.block(
            self._history.channels, verdict.t_start - _AROUND, verdict.t_end + _AROUND
        )
        flight = self._part(block, info)
        return correct_for_burned_fuel(
            cut_maneuver(
                flight, carded.aircraft, verdict.t_start, verdict.t_end, id=verdict.id,
                inputs=tuple(sorted(verdict.surfaces, key=("de", "da", "dr").index)),
                kind=verdict.kind,
                mass=np.full(len(block), self._mass_at(verdict.t_input, carded.aircraft, info)),
            ),
            carded,
        )  # fmt: skip

    def _part(self, block: Block, info: FlightInfo | None) -> Flight:
        return Flight(name=self._name, path=Path(self._name), block=block, sources={}, info=info)

    def _mass_at(self, time: float, aircraft: Aircraft, info: FlightInfo | None) -> float:
        """Return the mass that is left by what was burned so far, kg."""
        history = self._history
        channels = (_BURNS,) if history.has(_BURNS) else ()
        # The vehicle's clock may have run for long before anything was recorded.
        before = history.block(channels, time if history.start is None else history.start, time)
        if not len(before):
            return aircraft.mass.mass
        return float(mass_over_flight(self._part(before, info), aircraft)[-1])
