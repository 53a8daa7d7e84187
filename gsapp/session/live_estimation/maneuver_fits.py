"""Every maneuver of a flight fitted a moment after it ended, while the flight goes on."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.temporary_arrays import MemmapStore
from gsapp.identification.campaign import (
    CampaignResult,
    CampaignSettings,
    ManeuverResult,
    campaign_values,
    run_campaign,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.session.monitor_settings import MONITORS

if TYPE_CHECKING:
    from gsapp.session.live_estimation.fit_workers import FitWorker

UNUSABLE_VERDICTS: Final = ("invalid", "unclear")
"""Verdicts whose maneuvers are not fitted: nobody knows what moved the aircraft."""
CutManeuver = Callable[[InputVerdict], Maneuver]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitRequest:
    """What is to be fitted."""

    maneuver: Maneuver
    model: Model | None
    """Values known before: held where the maneuver does not free them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitResponse:
    """What came of it."""

    result: ManeuverResult
    seconds: float
    """That it took; says nothing of the flight."""


def run_fit_request(request: FitRequest) -> FitResponse:
    """Fit one maneuver as ``gsapp estimate`` does."""
    started = time.perf_counter()
    settings = CampaignSettings(known_model=request.model)
    try:
        (result,) = run_campaign([request.maneuver], settings).results
    except GroundStationError as error:
        result = ManeuverResult(maneuver=request.maneuver, estimate=None, failure=str(error))
    return FitResponse(result=result, seconds=time.perf_counter() - started)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitUpdate:
    """What changed since somebody looked last."""

    maneuver: str
    failure: str = ""
    """Why there is none, in words; empty if there is one."""


class ManeuverFits:
    """Fits maneuvers as verdicts come in; what it gives depends on the flight alone."""

    def __init__(self, cut: CutManeuver, model: Model | None, workers: FitWorker) -> None:
        self._cut = cut
        self._settings = CampaignSettings(known_model=model)
        self._model = model
        self._workers = workers
        self._forget()

    def _forget(self) -> None:
        self._waiting: list[InputVerdict] = []
        self._seen = 0
        self._running: dict[str, Future[FitResponse]] = {}
        self._asked: dict[str, FitRequest] = {}
        self._tries: dict[str, int] = {}
        self._order: list[str] = []
        self._found: dict[str, ManeuverResult] = {}
        self._store = MemmapStore()
        self._failures: dict[str, str] = {}
        self._result: CampaignResult | None = None

    def reset(self) -> None:
        for one in self._running.values():
            one.cancel()
        self._forget()

    def close(self) -> None:
        self.reset()
        self._workers.close()

    def update(self, verdicts: Sequence[InputVerdict], now: float | None) -> tuple[FitUpdate, ...]:
        """Ask for the fits that are due, and take in those that came."""
        self._waiting += verdicts[self._seen :]
        self._seen = len(verdicts)
        while self._waiting and (
            now is None or now >= self._waiting[0].t_end + MONITORS.maneuver_delay
        ):
            self._ask(self._waiting.pop(0))
        return tuple(self._taken())

    def wait(self) -> tuple[FitUpdate, ...]:
        """Wait for the fits under way, and take them in."""
        news: list[FitUpdate] = []
        while self._running:
            for one in self._running.values():
                one.exception()
            news += self._taken()
        return tuple(news)

    def _ask(self, verdict: InputVerdict) -> None:
        if verdict.result in UNUSABLE_VERDICTS:
            return
        self._order.append(verdict.id)
        try:
            maneuver = self._cut(verdict)
        except FlightError as error:
            self._failures[verdict.id] = str(error)
            return
        self._asked[verdict.id] = FitRequest(maneuver=maneuver, model=self._model)
        self._begin(verdict.id)

    def _begin(self, name: str) -> None:
        self._tries[name] = self._tries.get(name, 0) + 1
        try:
            self._running[name] = self._workers.submit(self._asked[name])
        except (OSError, RuntimeError) as error:
            # The flight goes on, whatever keeps a process from beginning.
            # What the system says may be pages; its last line says what was wrong.
            said = (str(error).strip().splitlines() or [type(error).__name__])[-1]
            self._failures[name] = f"no fit process could be started ({said.strip()})"

    def _taken(self) -> list[FitUpdate]:
        news = []
        for name in [name for name, one in self._running.items() if one.done()]:
            done = self._running.pop(name)
            error = done.exception()
            if isinstance(error, BrokenProcessPool) and self._tries[name] < MONITORS.max_attempts:
                self._begin(name)
                continue
            del self._asked[name]  # The result has its own copy of the maneuver.
            if error is not None:
                self._failures[name] = f"the fit failed ({error or type(error).__name__})"
            else:
                self._found[name] = self._store.store(done.result().result)
                self._result = None
                self._failures.pop(name, None)
                if self._found[name].failure:
                    self._failures[name] = self._found[name].failure
            news.append(FitUpdate(maneuver=name, failure=self._failures.get(name, "")))
        return news

    # --- what was found -------------------------------------------------------------------------

    @property
    def pending(self) -> int:
        return len(self._running)

    @property
    def failures(self) -> dict[str, str]:
        """Return why maneuvers could not be fitted, in words, by maneuver."""
        return dict(self._failures)

    @property
    def result(self) -> CampaignResult:
        """Return the fits so far, in the order in which the maneuvers were flown.

        The same object until another fit comes.
        """
        if self._result is None:
            results = tuple(self._found[name] for name in self._order if name in self._found)
            self._result = CampaignResult(
                settings=self._settings,
                results=results,
                values=campaign_values([one.estimate for one in results]),
            )
        return self._result
