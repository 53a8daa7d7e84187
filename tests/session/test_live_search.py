"""A missing effect is searched for after each maneuver, over all that were flown so far."""

from concurrent.futures import Future
from dataclasses import replace
from typing import Any

from gsapp.identification.maneuver import Maneuver
from gsapp.session.live_estimation.fit_workers import InlineFitWorker, ProcessFitWorker
from gsapp.session.live_estimation.live_search import (
    LiveSearch,
    LiveSearchRequest,
    LiveSearchResult,
    confirm_names,
    run_search_request,
)
from gsapp.session.monitor_settings import MONITORS
from tests.discrepancy.core_kit import TRUTH, maneuver

HIDDEN = "aero.Cm.alpha2"
MODEL = TRUTH.with_effect(HIDDEN, {"Cm_alpha2": -6.0})


def flown(count: int, flight: str = "live") -> list[Maneuver]:
    return [
        maneuver(seed, ("lon", "lat")[seed % 2], duration=4.0, model=MODEL, flight=flight)
        for seed in range(1, count + 1)
    ]


def test_evidence_grows_with_the_maneuvers_until_the_effect_is_named() -> None:
    """Too few maneuvers are said to be that; then what is hidden is the likeliest, and named."""
    search = LiveSearch(InlineFitWorker(run_search_request))
    whole = flown(10)
    for count in (1, 4, 6, 7, 10):
        search.update(whole[:count])
        search.update(whole[:count])
    few, some, _, _, all_ = search.steps
    assert [one.maneuvers for one in search.steps] == [1, 4, 6, 7, 10]
    assert not few.verdict
    assert few.why
    assert not few.evidence
    assert all_.named == (HIDDEN,)
    assert next(iter(all_.evidence)) == HIDDEN
    assert some.evidence.get(HIDDEN, 0.0) <= all_.evidence[HIDDEN]
    assert all(0.0 <= share <= 1.0 for one in search.steps for share in one.evidence.values())
    assert all_.time == whole[-1].block.times[-1]
    assert [one["maneuvers"] for one in search.to_json()] == [1, 4, 6, 7, 10]
    search.close()


class Held:
    """A worker whose answers come when the test says so."""

    def __init__(self) -> None:
        self.asked: list[LiveSearchRequest] = []
        self.running: list[Future[Any]] = []

    def submit(self, request: Any) -> Future[Any]:
        self.asked.append(request)
        self.running.append(Future())
        return self.running[-1]

    def close(self) -> None: ...


def _step(count: int) -> LiveSearchResult:
    return LiveSearchResult(time=0.0, maneuvers=count, verdict="model-adequate", evidence={})


def test_one_search_runs_at_a_time_and_the_next_takes_all_that_came() -> None:
    worker = Held()
    search = LiveSearch(worker)
    whole = flown(3)
    for count in (1, 2, 3):
        search.update(whole[:count])
    assert [len(one.maneuvers) for one in worker.asked] == [1]
    worker.running[0].set_result(_step(1))
    search.update(whole)
    assert [len(one.maneuvers) for one in worker.asked] == [1, 3]
    worker.running[1].set_exception(RuntimeError("no memory"))
    search.update(whole)
    assert search.error_text == "no memory"
    assert [one.maneuvers for one in search.steps] == [1]
    search.enabled = False
    search.update([*whole, *flown(1, "more")])
    assert len(worker.asked) == 2
    search.enabled = True
    search.update([*whole, *flown(1, "more")])
    assert len(worker.asked) == 3
    search.reset()
    assert not search.is_running
    assert not search.steps


def test_an_early_name_needs_the_searches_over_three_further_maneuvers() -> None:
    """One that leaves it out begins the count anew; a name that was confirmed stays one."""
    worker = Held()
    search = LiveSearch(worker)
    names = [("a",), ("a",), (), ("a",), ("a", "b"), ("a",), ("a", "b"), ("a", "b")]
    whole = flown(len(names))
    for count, named in enumerate(names, start=1):
        search.update(whole[:count])
        worker.running[-1].set_result(replace(_step(count), named=named))
    search.update(whole)
    assert [one.named for one in search.steps] == [(), (), (), (), (), (), ("a",), ("a",)]
    unconfirmed = [("a",), ("a",), (), ("a",), ("a", "b"), ("a",), ("b",), ("b",)]
    assert [one.unconfirmed for one in search.steps] == unconfirmed


def test_a_late_search_names_at_once() -> None:
    early = replace(_step(MONITORS.early_search), named=("a",))
    assert confirm_names((), early).unconfirmed == ("a",)
    late = replace(_step(MONITORS.early_search + 1), named=("a",))
    assert confirm_names((), late).named == ("a",)


def test_a_search_runs_in_a_process_of_its_own() -> None:
    search = LiveSearch(ProcessFitWorker(run_search_request))
    search.finish(flown(2))
    (step,) = search.steps
    assert step.maneuvers == 2
    assert "too few" in step.why
    search.close()
