"""The search for a missing effect over all maneuvers so far, while the flight goes on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from gsapp.foundation import GroundStationError
from gsapp.session.monitor_settings import MONITORS

if TYPE_CHECKING:
    # The window starts without what estimates.
    from gsapp.discrepancy.results import DecidingExperiment, DiscrepancyResult
    from gsapp.identification.maneuver import Maneuver
    from gsapp.session.live_estimation.fit_workers import FitWorker


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveSearchRequest:
    """The maneuvers so far, in the order in which they were flown."""

    maneuvers: tuple[Maneuver, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSearchResult:
    """What a search over the maneuvers so far gave."""

    time: float  # Flight time of the last sample, s.
    maneuvers: int
    verdict: str = ""  # Empty where it could not be searched.
    why: str = ""
    evidence: Mapping[str, float]
    """Probability of each effect by its id, largest first: named ones, then what may be next."""
    named: tuple[str, ...] = ()
    """Also by the searches over the maneuvers before; see `confirm_names`."""
    unconfirmed: tuple[str, ...] = ()
    """Named by this search, not yet by those before."""
    titles: Mapping[str, str] = field(default_factory=dict)
    """Of the effects that this search named, by their ids."""
    experiment: DecidingExperiment | None = None
    """What to fly next, where effects cannot be told apart or do not show."""

    def to_json(self) -> dict[str, Any]:
        content = {one.name: getattr(self, one.name) for one in fields(self)}
        if self.experiment is not None:
            from gsapp.discrepancy.results import experiment_json

            content["experiment"] = experiment_json(self.experiment)
        return content


def run_search_request(request: LiveSearchRequest) -> LiveSearchResult:
    """Search as ``gsapp discrepancy`` does, the linear model fitted to the maneuvers.

    Values known before a flight are wrong by more than an effect shows.
    """
    from gsapp.discrepancy.investigation import Investigation
    from gsapp.discrepancy.settings import DiscrepancySettings

    maneuvers = request.maneuvers
    step = LiveSearchResult(
        time=max(float(one.block.times[-1]) for one in maneuvers), maneuvers=len(maneuvers),
        evidence={},
    )  # fmt: skip
    try:
        search = Investigation(maneuvers, maneuvers[0].aircraft, None)
        return _summarize(step, search.run(DiscrepancySettings()))
    except GroundStationError as error:
        return replace(step, why=str(error))


def _summarize(step: LiveSearchResult, found: DiscrepancyResult) -> LiveSearchResult:
    evidence: dict[str, float] = {}
    for one in found.effects:
        names = one.one_of or (one.effect,)
        evidence |= dict.fromkeys(names, one.confidence / len(names))
    ranking = found.steps[-1].ranking
    missing = _probability_of_any([one.score for one in ranking])
    for candidate in ranking:
        if candidate.effect not in evidence:
            evidence[candidate.effect] = missing * candidate.evidence
    named = [one for one in found.effects if one.named and not one.one_of]
    return replace(
        step,
        verdict=found.verdict,
        why=found.why,
        evidence=dict(sorted(evidence.items(), key=lambda item: item[1], reverse=True)),
        named=tuple(one.effect for one in named),
        titles={one.effect: one.title for one in named},
        experiment=found.experiment,
    )


def confirm_names(steps: Sequence[LiveSearchResult], step: LiveSearchResult) -> LiveSearchResult:
    """Name what a step names, early in a flight only if the searches before it named it too.

    A flight is searched after each maneuver, and each search is one more chance of a false name.
    As in group sequential tests (O'Brien and Fleming, Biometrics 35, 1979) early looks need more
    evidence: all searches, those of `steps`, over three further maneuvers.
    """

    def is_confirmed(name: str) -> bool:
        if step.maneuvers > MONITORS.early_search:
            return True
        for one in reversed(steps):
            if name in one.named:
                return True
            if name not in one.unconfirmed:
                return False
            if step.maneuvers - one.maneuvers >= MONITORS.search_confirmation:
                return True
        return False

    named = tuple(name for name in step.named if is_confirmed(name))
    unconfirmed = tuple(name for name in step.named if name not in named)
    return replace(step, named=named, unconfirmed=unconfirmed)


def _probability_of_any(scores: Sequence[float]) -> float:
    """Return how likely any candidate is, beside none, by the mean of their likelihood ratios."""
    if not scores:
        return 0.0
    top = max(scores)
    mean = top + math.log(sum(math.exp(one - top) for one in scores) / len(scores))
    return 1.0 / (1.0 + math.exp(-min(max(mean, -700.0), 700.0)))


class LiveSearch:
    """Searches after each maneuver; one search runs at a time, the next takes all that came."""

    def __init__(self, worker: FitWorker) -> None:
        self._worker = worker
        self._running: Future[LiveSearchResult] | None = None
        self._searched = 0
        self.enabled = True
        self.steps: tuple[LiveSearchResult, ...] = ()
        self.error_text = ""

    @property
    def is_running(self) -> bool:
        return self._running is not None

    def reset(self) -> None:
        if self._running is not None:
            self._running.cancel()
        self._running, self._searched, self.steps, self.error_text = None, 0, (), ""

    def close(self) -> None:
        self.reset()
        self._worker.close()

    def update(self, maneuvers: Sequence[Maneuver]) -> None:
        """Take in what was found, and begin the next search where maneuvers were added."""
        running = self._running
        if running is not None and running.done():
            self._running = None
            error = running.exception()
            self.error_text = "" if error is None else str(error) or type(error).__name__
            if error is None:
                self.steps = (*self.steps, confirm_names(self.steps, running.result()))
        if self._running is None and self.enabled and len(maneuvers) > self._searched:
            self._searched = len(maneuvers)
            try:
                self._running = self._worker.submit(LiveSearchRequest(maneuvers=tuple(maneuvers)))
            except (OSError, RuntimeError) as problem:
                # The flight goes on, whatever keeps a process from beginning.
                self.error_text = str(problem) or type(problem).__name__

    def finish(self, maneuvers: Sequence[Maneuver]) -> None:
        """Search all maneuvers of a flight that is over, and wait for that."""
        self.update(maneuvers)
        while self._running is not None:
            self._running.exception()
            self.update(maneuvers)

    def to_json(self) -> list[dict[str, Any]]:
        return [one.to_json() for one in self.steps]
