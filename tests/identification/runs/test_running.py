"""A run: the maneuvers asked for with exactly their edges, flights kept open, cancel."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.flight.events import EventLog, events_path
from gsapp.flight.maneuvers import ManeuverEditLog, collect_maneuvers
from gsapp.foundation import FlightError
from gsapp.identification.campaign import CanceledError
from gsapp.identification.runs.inputs import FlightCache, flight_open_requests
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import SAME_SAMPLES_TEXT, RunOutcome, execute_run


def test_the_outcome_asks_for_the_same_again(outcome: RunOutcome) -> None:
    """Its request names every maneuver; run once more it gives the same numbers to the last bit."""
    assert [one.id for one in outcome.request.maneuvers] == ["1", "2", "1", "2"]
    assert [one.maneuver.id for one in outcome.result.results] == ["1:1", "1:2", "2:1", "2:2"]
    assert outcome.request.known_model is not None
    again = execute_run(outcome.request)
    assert again.request == outcome.request
    assert again.result.values == outcome.result.values
    for one, other in zip(outcome.result.results, again.result.results, strict=True):
        assert one.estimate.derivatives == other.estimate.derivatives
        assert np.array_equal(one.estimate.covariance, other.estimate.covariance)


def test_edges_inputs_and_order_are_those_asked_for(outcome: RunOutcome) -> None:
    first, second, *_ = outcome.request.maneuvers
    moved = replace(first, t_start=0.5, t_end=5.5, kind="by hand")
    found = execute_run(outcome.request.with_changes(maneuvers=(second, moved)))
    ids = [one.maneuver.id for one in found.result.results]
    assert ids == ["1:2", "1:1"]
    cut = found.result.results[1].maneuver
    assert (cut.t_start, cut.t_end) == pytest.approx((0.5, 5.5))
    assert (cut.inputs, cut.kind) == (first.inputs, "by hand")
    assert found.request.maneuvers == (second, moved)
    # A catalog is told of the maneuver as it was used, graded anew.
    stored = {one.id: one for one in found.flights[0].maneuvers}
    assert (stored["1"].t_start, stored["1"].t_end) == pytest.approx((0.5, 5.5))
    assert stored["2"] == second.found
    # The second flight went in with none of its maneuvers.
    assert [len(one.maneuvers) for one in found.flights] == [2, 0]


def test_flights_stay_open_until_their_files_change(outcome: RunOutcome, tmp_path: Path) -> None:
    path = Path(shutil.copy(outcome.request.flights[0], tmp_path))
    request = RunRequest(flights=(path,), maneuver_windows=("0:6", "8:14"))
    shelf, said = FlightCache(), []
    execute_run(request, flights=shelf, doing=said.append)
    assert len(said) == 2
    assert said[0] == "reading a.csv"
    (opening,) = flight_open_requests(request)
    opened = shelf.open(opening).opened
    execute_run(request, flights=shelf, doing=said.append)
    assert len(said) == 2
    log = EventLog(events_path(path))
    book = ManeuverEditLog(log, collect_maneuvers(opened.flight, opened.aircraft).maneuvers)
    book.record(book.maneuver_list.annotate("1", "bumpy"))
    execute_run(request.with_changes(maneuver_windows=()), flights=shelf, doing=said.append)
    assert said[2:] == ["looking for maneuvers in a.csv"]
    assert shelf.open(opening).opened is opened
    os.utime(path, ns=(1, 1))
    execute_run(request, flights=shelf, doing=said.append)
    assert said[3:] == said[:2]


def test_changes_by_hand_count_in_the_next_run(outcome: RunOutcome, tmp_path: Path) -> None:
    path = Path(shutil.copy(outcome.request.flights[0], tmp_path))
    shelf = FlightCache()
    request = RunRequest(flights=(path,))
    (opening,) = flight_open_requests(request)
    opened = shelf.open(opening).opened
    found = shelf.detected_maneuvers(opening).maneuvers
    log = ManeuverEditLog(EventLog(events_path(path)), found)
    name = found[0].id

    def assess(name: str, start: float, stop: float) -> object:
        return replace(found[0], id=name, t_start=start, t_end=stop)

    log.record(log.maneuver_list.move(name, assess, t_end=found[0].t_end - 1.0))
    used = execute_run(request, flights=shelf).request.maneuvers
    assert used[0].t_end == pytest.approx(found[0].t_end - 1.0)
    used = execute_run(request.with_changes(as_found=True), flights=shelf).request.maneuvers
    assert used[0].t_end == found[0].t_end
    assert shelf.open(opening).opened is opened


def test_a_stop_leaves_nothing(outcome: RunOutcome, tmp_path: Path) -> None:
    path = Path(shutil.copy(outcome.request.flights[0], tmp_path))
    request = RunRequest(flights=(path,), maneuver_windows=("0:6", "8:14"), model="b777")
    before = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*")}
    shelf = FlightCache()
    for stop_at in range(3):
        with pytest.raises(CanceledError):
            execute_run(request, flights=shelf, progress=lambda done, *_, last=stop_at: done < last)
    assert {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*")} == before


def test_what_cannot_be_is_told_in_a_sentence(outcome: RunOutcome, tmp_path: Path) -> None:
    with pytest.raises(FlightError, match="no flight"):
        execute_run(RunRequest(flights=()))
    strange = replace(outcome.request.maneuvers[0], flight=tmp_path / "c.csv")
    with pytest.raises(FlightError, match=r"c\.csv cannot be used: it is not among"):
        execute_run(outcome.request.with_changes(maneuvers=(strange,)))


def test_a_copy_of_a_flight_is_told_not_to_count_as_another(
    outcome: RunOutcome, tmp_path: Path
) -> None:
    """Its scatter is nothing new; the bounds of the means would shrink all the same."""
    assert not [one for one in outcome.remarks if one.startswith(SAME_SAMPLES_TEXT)]
    first, second = outcome.request.flights
    copy = Path(shutil.copy(first, tmp_path / "copy.csv"))
    found = execute_run(
        RunRequest(
            flights=(first, second, copy),
            maneuver_windows=("1:0:6", "2:0:6", "3:0:6"),
            model="b777",
        )
    )
    (told,) = [one for one in found.remarks if one.startswith(SAME_SAMPLES_TEXT)]
    assert "flights 1 and 3" in told
