"""The derivatives of a flight being watched: FTR as it listens, and the fits of its maneuvers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.aircraft.config import MassProperties
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.flight import Flight
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.info import FlightInfo
from gsapp.foundation import FlightError
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.ftr import FTR
from gsapp.identification.maneuver import (
    Maneuver,
    correct_for_burned_fuel,
    cut_maneuver,
    fuel_flow,
    takeoff_mass,
)
from gsapp.quantities import Block
from gsapp.session.live_estimation.estimate_table import EstimateRow, build_estimate_rows
from gsapp.session.live_estimation.fit_workers import FitWorker
from gsapp.session.live_estimation.live_search import LiveSearch
from gsapp.session.live_estimation.maneuver_fits import FitUpdate, ManeuverFits
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.sample_history import SampleHistory

_BURNS: Final = "throttle"
"""Channel by which fuel burns."""


class ManeuverCutter:
    """Cuts maneuvers from a session's history, as `cut_maneuver` does from a whole flight.

    Parameters
    ----------
    aircraft : Aircraft
        Of the file; what the flight card says of the day is seen to.
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
        # Start of the history that fuel was counted from, time up to which it was, and kg.
        self._counted_from: float | None = None
        self._counted_to = -math.inf
        self._burned = 0.0

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
            self._history.channels,
            verdict.t_start - MONITORS.maneuver_margin,
            verdict.t_end + MONITORS.maneuver_margin,
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
        """Return the mass that is left by what was burned so far, kg.

        By the throttle alone: what was left after landing says nothing of the time between.
        """
        mass, fuel = takeoff_mass(aircraft, info)
        if aircraft.mass.fuel_flow_full == 0.0:
            return mass
        return mass - min(self._count_fuel(time, aircraft.mass), fuel)

    def _count_fuel(self, time: float, properties: MassProperties) -> float:
        """Return the fuel burned by a time, kg; only what is new since the last is read."""
        history = self._history
        if history.start is None:
            return 0.0
        if history.start != self._counted_from or time < self._counted_to:
            # The vehicle's clock may have run for long before anything was recorded.
            self._counted_from = self._counted_to = history.start
            self._burned = 0.0
        channels = (_BURNS,) if history.has(_BURNS) else ()
        block = history.block(channels, self._counted_to, time)
        if len(block):
            throttle = block[_BURNS] if channels else np.zeros(len(block))
            self._burned += float(np.trapezoid(fuel_flow(throttle, properties), block.times))
            self._counted_to = float(block.times[-1])
        return self._burned


class EstimateMonitor:
    """A consumer of a session's feed.

    Attributes
    ----------
    search : LiveSearch or None
        The search for a missing effect; None without a worker for it.
    error_text : str
        Why FTR does not listen, in words; empty if it does.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        model: Model | None,
        history: SampleHistory,
        info: Callable[[], FlightInfo | None],
        name: str,
        verdicts: Callable[[], Sequence[InputVerdict]],
        workers: FitWorker,
        search_worker: FitWorker | None = None,
    ) -> None:
        self.search = None if search_worker is None else LiveSearch(search_worker)
        self._model = model
        self._history = history
        self._verdicts = verdicts
        self.fits = ManeuverFits(ManeuverCutter(history, aircraft, info, name), model, workers)
        self.error_text = ""
        self._newest_time = (
            self._processed_time
        ) = -math.inf  # Flight time of the newest sample, and as of a step.
        self._ftr: FTR | None = None
        try:
            carded = apply_flight_info(aircraft, info())
            self._ftr = FTR(carded.aircraft, rate=history.rate, mass=carded.aircraft.mass.mass)
        except FlightError as error:
            self.error_text = str(error)

    # --- the consumer of a feed -----------------------------------------------------------------

    def feed(self, block: Block) -> None:
        if self._ftr is not None and len(block):
            self._ftr.feed(block)
            self._newest_time = max(self._newest_time, float(block.times[-1]))

    def process_step(self) -> None:
        """Let FTR take in what came, at most once an `estimate_interval`: it is cheaper so."""
        if (
            self._ftr is not None
            and self._newest_time >= self._processed_time + MONITORS.estimate_interval
        ):
            self._processed_time = self._newest_time
            self._ftr.process_step()

    def reset(self) -> None:
        self._newest_time = self._processed_time = -math.inf
        if self._ftr is not None:
            self._ftr.reset()
        self.fits.reset()
        if self.search is not None:
            self.search.reset()

    def finish(self, *, wait: bool = True) -> None:
        """Take in what was held back, and ask for the last fits; the flight is over."""
        if self._ftr is not None:
            self._ftr.finish()
        self.fits.update(self._verdicts(), None)
        if wait:
            self.fits.wait()
            if self.search is not None:
                self.search.finish(self._fitted)

    def close(self) -> None:
        self.fits.close()
        if self.search is not None:
            self.search.close()

    def switch_search(self, enabled: bool) -> None:
        """Begin or end searching for a missing effect; what was found stays."""
        if self.search is not None:
            self.search.enabled = enabled

    # --- what it shows --------------------------------------------------------------------------

    def update(self, now: float | None) -> tuple[FitUpdate, ...]:
        """Ask for the fits that are due at a flight time (s), and take in those that came."""
        if now is None:
            return ()
        changes = self.fits.update(self._verdicts(), now)
        if self.search is not None:
            self.search.update(self._fitted)
        return changes

    @property
    def _fitted(self) -> list[Maneuver]:
        return [one.maneuver for one in self.result.results]

    def to_json(self) -> dict[str, Any]:
        """Return every derivative as it stands, for programs: FTR's, and those of the fits.

        ``{"ftr": {name: {"value", "std"}}, "maneuvers": {id: {name: {"value", "std"}}}}``, per
        radian; None where not earned.
        """
        ftr = {} if self._ftr is None else self._ftr.estimates()
        return {
            "ftr": {name: {"value": one.value, "std": one.std} for name, one in ftr.items()},
            "maneuvers": {
                one.maneuver.id: {
                    name: {"value": found.value, "std": found.std}
                    for name, found in one.estimate.derivatives.items()
                    if found.status != "held"
                }
                for one in self.result.results
                if one.estimate is not None
            },
        }

    @property
    def result(self) -> CampaignResult:
        return self.fits.result

    def rows(self) -> tuple[EstimateRow, ...]:
        """Return the derivatives as they stand."""
        if self._ftr is None:
            return ()
        verdicts = self._verdicts()
        return build_estimate_rows(
            self._ftr.estimates(),
            {
                name: self._ftr.history(name, max_points=MONITORS.max_history_points)
                for name in self._ftr.names
            },
            self.result,
            self._model,
            since=verdicts[-1].t_start if verdicts else None,
        )
