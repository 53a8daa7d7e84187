"""Runs: exactly what was asked for, done again to the last bit, two beside each other."""

import contextlib
import gc
import math
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.dynamics.model import load_model, save_model
from gsapp.flight import Flight
from gsapp.flight.catalog import Catalog
from gsapp.flight.events import EventLog, events_path
from gsapp.flight.maneuvers import ManeuverEditLog, collect_maneuvers
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.executors import WorkerPool
from gsapp.identification.campaign import CanceledError
from gsapp.identification.estimate_json import campaign_json
from gsapp.identification.runs.inputs import FlightCache, flight_open_requests
from gsapp.identification.runs.request import RunRequest, describe_settings, setting_differences
from gsapp.identification.runs.run_comparison import SettingDifference, compare_runs, repeat_run
from gsapp.identification.runs.run_execution import SAME_SAMPLES_TEXT, RunOutcome, execute_run
from gsapp.identification.runs.run_store import load_run, save_run
from gsapp.quantities.stored_block import StoredBlock


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


@pytest.mark.parametrize("address", ["", "local:2"])
def test_without_samples_the_numbers_are_the_same(outcome: RunOutcome, address: str) -> None:
    """Neither flights nor samples nor histories stay in memory; a pool changes no bit."""
    gc.collect()
    before = {id(one) for one in gc.get_objects() if isinstance(one, Flight)}
    request = outcome.request.with_changes(joint=True)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(WorkerPool(address)) if address else None
        found = execute_run(request, pool=pool, keep_samples=False)
    kept = execute_run(request)
    assert campaign_json(found.result) == campaign_json(kept.result)
    assert (found.summary.derivatives.keys(), found.models.keys()) == (
        kept.summary.derivatives.keys(),
        kept.models.keys(),
    )
    for axis, model in kept.models.items():
        assert np.array_equal(model.A, found.models[axis].A)
    for one, other in zip(found.result.results, kept.result.results, strict=True):
        assert isinstance(one.maneuver.block, StoredBlock)
        assert one.estimate.histories == ()
        assert other.estimate.histories
        assert np.array_equal(
            one.maneuver.block.values, other.maneuver.block.values, equal_nan=True
        )
    gc.collect()
    after = {id(one) for one in gc.get_objects() if isinstance(one, Flight)}
    assert after <= before


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
    flight_cache, said = FlightCache(), []

    def note(text: str) -> None:
        if path.name in text:
            said.append(text)

    execute_run(request, flights=flight_cache, doing=note)
    assert len(said) == 2
    assert said[0] == "reading a.csv"
    (opening,) = flight_open_requests(request)
    opened = flight_cache.open(opening).opened
    assert isinstance(opened.flight.block, StoredBlock)  # many are open: not in memory
    execute_run(request, flights=flight_cache, doing=note)
    assert len(said) == 2
    log = EventLog(events_path(path))
    book = ManeuverEditLog(log, collect_maneuvers(opened.flight, opened.aircraft).maneuvers)
    book.record(book.maneuver_list.annotate("1", "bumpy"))
    execute_run(request.with_changes(maneuver_windows=()), flights=flight_cache, doing=note)
    assert said[2:] == ["looking for maneuvers in a.csv"]
    assert flight_cache.open(opening).opened is opened
    os.utime(path, ns=(1, 1))
    execute_run(request, flights=flight_cache, doing=note)
    assert said[3:] == said[:2]


def test_changes_by_hand_count_in_the_next_run(outcome: RunOutcome, tmp_path: Path) -> None:
    path = Path(shutil.copy(outcome.request.flights[0], tmp_path))
    flight_cache = FlightCache()
    request = RunRequest(flights=(path,))
    (opening,) = flight_open_requests(request)
    opened = flight_cache.open(opening).opened
    found = flight_cache.detected_maneuvers(opening).maneuvers
    log = ManeuverEditLog(EventLog(events_path(path)), found)
    name = found[0].id

    def assess(name: str, start: float, stop: float) -> object:
        return replace(found[0], id=name, t_start=start, t_end=stop)

    log.record(log.maneuver_list.move(name, assess, t_end=found[0].t_end - 1.0))
    used = execute_run(request, flights=flight_cache).request.maneuvers
    assert used[0].t_end == pytest.approx(found[0].t_end - 1.0)
    used = execute_run(request.with_changes(as_found=True), flights=flight_cache).request.maneuvers
    assert used[0].t_end == found[0].t_end
    assert flight_cache.open(opening).opened is opened


def test_a_stop_leaves_nothing(outcome: RunOutcome, tmp_path: Path) -> None:
    path = Path(shutil.copy(outcome.request.flights[0], tmp_path))
    request = RunRequest(flights=(path,), maneuver_windows=("0:6", "8:14"), model="b777")
    before = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*")}
    flight_cache = FlightCache()
    for stop_at in range(3):
        with pytest.raises(CanceledError):
            execute_run(
                request, flights=flight_cache, progress=lambda done, *_, last=stop_at: done < last
            )
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


@pytest.fixture
def campaign(tmp_path: Path, flight_files: tuple[Path, Path]) -> Path:
    folder = tmp_path / "campaign"
    folder.mkdir()
    path = Path(shutil.copy(flight_files[0], folder))
    with Catalog(folder / "c.sqlite") as catalog:
        request = RunRequest(flights=(path,), maneuver_windows=("0:6",), joint=True)
        save_run(catalog, execute_run(request))
    return folder


def test_a_repeat_is_the_same_to_the_last_bit_in_another_place_too(
    campaign: Path, tmp_path: Path
) -> None:
    with Catalog(campaign / "c.sqlite") as catalog:
        found = repeat_run(catalog, 1)
    assert (found.is_identical, found.differences) == (True, ())
    moved = campaign.rename(tmp_path / "elsewhere")
    with Catalog(moved / "c.sqlite") as catalog:
        found = repeat_run(catalog, 1)
    assert found.is_identical
    assert found.outcome.request.flights == (moved / "a.csv",)
    assert found.differences == ()


def test_one_bit_is_a_difference(campaign: Path) -> None:
    with Catalog(campaign / "c.sqlite") as catalog:
        (row,) = catalog.query("SELECT std FROM estimates WHERE run = 1 AND name = 'Cm_q'")
        with catalog.transaction() as connection:
            connection.execute(
                "UPDATE estimates SET std = ? WHERE run = 1 AND name = 'Cm_q'",
                (math.nextafter(row["std"], 1e9),),
            )
        found = repeat_run(catalog, 1)
    assert not found.is_identical
    assert len(found.differences) == 2
    assert "Cm_q" in found.differences[0]


def test_what_changed_since_is_named(campaign: Path) -> None:
    path = campaign / "a.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    column = lines[0].split(",").index("q [deg/s]")
    for place in range(100, 130):
        cells = lines[place].split(",")
        cells[column] = str(float(cells[column]) + 2.0)
        lines[place] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with Catalog(campaign / "c.sqlite") as catalog:
        with catalog.transaction() as connection:
            connection.execute(
                "UPDATE kept_runs SET versions = json_set(versions, '$.numpy', '1.0')"
            )
        found = repeat_run(catalog, 1)
    assert not found.is_identical
    assert found.differences[0] == f"{path} has changed"
    assert found.differences[1].startswith("numpy was 1.0")
    assert found.differences[2].startswith("maneuver 1: ")
    assert " more" in found.differences[2]
    path.unlink()
    gone = pytest.raises(GroundStationError, match=r"a\.csv")
    with Catalog(campaign / "c.sqlite") as catalog, gone:
        repeat_run(catalog, 1)


def test_marks_and_notes_change_no_run(campaign: Path) -> None:
    (campaign / "a.csv.events.jsonl").write_text('{"kind": "mark"}\n', encoding="utf-8")
    with Catalog(campaign / "c.sqlite") as catalog:
        assert repeat_run(catalog, 1).differences == ()


def test_a_model_that_is_gone_is_remembered(campaign: Path) -> None:
    file = save_model(load_model("b777").with_derivatives({"CN_q": 4.0}), campaign / "own.toml")
    asked = RunRequest(
        flights=(campaign / "a.csv",), maneuver_windows=("0:6",), model=str(file),
        free=("Cm_alpha", "Cm_q", "Cm_de", "Cm_0"),
    )  # fmt: skip
    with Catalog(campaign / "c.sqlite") as catalog:
        made = execute_run(asked)
        assert [one.role for one in made.inputs] == ["flight", "aircraft", "model"]
        number = save_run(catalog, made)
        file.unlink()
        found = repeat_run(catalog, number)
    assert (found.is_identical, found.differences) == (True, ())
    model = found.outcome.result.settings.known_model
    assert model is not None
    assert model.derivative("CN_q") == 4.0


def test_two_runs_beside_each_other(campaign: Path, outcome: RunOutcome) -> None:
    """Settings that differ in words, maneuvers of one only, values in joint bounds."""
    other = execute_run(outcome.request.with_changes(label="held", held={"CN_q": 5.0}))
    with Catalog(campaign / "c.sqlite") as catalog:
        one, two = (load_run(catalog, save_run(catalog, made)) for made in (outcome, other))
        found = compare_runs(one, two)
        assert (found.one, found.other) == ("both", "held")
        assert found.settings == (SettingDifference(name="held", one="none", other="CN_q 5"),)
        values = {row.name: row for row in found.values}
        assert values["CN_q"].other is None
        assert values["CN_q"].differs
        row = values["Cm_de"]
        assert row.difference == row.other.mean - row.one.mean
        joint = math.sqrt(row.one.std**2 + row.other.std**2)
        assert row.in_bounds == pytest.approx((row.other.mean - row.one.mean) / joint)
        assert compare_runs(one, one).settings == ()
        # Another part of the flight.
        settings = {row.name: row for row in compare_runs(load_run(catalog, 1), one).settings}
        assert settings["flights"].other == "a, b"
        assert settings["maneuver 1 of b.csv"].one == "not used"
        assert settings["all maneuvers jointly"].one == "yes"


def test_settings_that_look_alike_are_told_apart(outcome: RunOutcome) -> None:
    def asked(value: float) -> RunRequest:
        return outcome.request.with_changes(start={"Cm_q": value})

    one, other = asked(-20.0), asked(math.nextafter(-20.0, 0.0))
    assert describe_settings(one) == describe_settings(other)
    ((name, first, second),) = setting_differences(one, other)
    assert name == "start values"
    assert (first, second) == ("Cm_q -20", "Cm_q -19.999999999999996")
