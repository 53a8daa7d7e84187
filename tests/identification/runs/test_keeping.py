"""Runs kept: whole or not at all, whoever else writes, whoever is killed; and as they were."""

import json
import os
import random
import select
import shutil
import signal
import sqlite3
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.dynamics.model import load_model
from gsapp.flight.catalog import Catalog, ManeuverFilter, schema, search_maneuvers, search_runs
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.runs.request import (
    RunRequest,
    SelectedManeuver,
    request_from_json,
    request_json,
)
from gsapp.identification.runs.run_comparison import repeat_run
from gsapp.identification.runs.run_execution import RunOutcome, exclude_maneuvers, execute_run
from gsapp.identification.runs.run_store import (
    forget_run,
    load_run,
    recall_run,
    rename_run,
    save_run,
    stored_runs,
    update_run_means,
)

forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")


def test_a_kept_run_says_all_of_itself(outcome: RunOutcome, tmp_path: Path) -> None:
    with Catalog(tmp_path / "c.sqlite") as catalog:
        number = save_run(catalog, outcome)
        (back,) = stored_runs(catalog)
        fits = search_runs(catalog, kept=number)
        stored = search_maneuvers(catalog, ManeuverFilter(flight="a"))
    assert (back.number, back.name, back.label) == (number, "both", "both")
    assert back.request == outcome.request
    assert back.values == {name: one.value for name, one in outcome.summary.derivatives.items()}
    assert (back.inputs, back.versions) == (outcome.inputs, outcome.versions)
    assert (back.flights, back.maneuver_count) == (("a", "b"), 4)
    assert back.settings["model"] == "b777"
    assert [one.edges for one in fits] == [
        ((one.t_start, one.t_end),) for one in outcome.request.maneuvers
    ]
    for fit, one in zip(fits, outcome.result.results, strict=True):
        assert {name: found.value for name, found in fit.estimates.items()} == {
            name: found.value for name, found in one.estimate.derivatives.items()
        }
    assert [one.runs for one in stored] == [(1,), (2,)]


def test_a_run_is_renamed_forgotten_and_called_back(outcome: RunOutcome, tmp_path: Path) -> None:
    with Catalog(tmp_path / "c.sqlite") as catalog:
        first, second = save_run(catalog, outcome), save_run(catalog, replace(outcome, inputs=()))
        rename_run(catalog, second, "  without files ")
        assert [one.name for one in stored_runs(catalog)] == ["both", "without files"]
        assert load_run(catalog, second).request.label == "without files"
        forget_run(catalog, first)
        assert [one.number for one in stored_runs(catalog)] == [second]
        assert len(search_runs(catalog)) == 4
        assert all(len(one.runs) == 1 for one in search_maneuvers(catalog))
        for gone in (load_run, forget_run):
            with pytest.raises(UnknownNameError, match="no run 1"):
                gone(catalog, first)
        recall_run(catalog, first)
        assert [one.number for one in stored_runs(catalog)] == [first, second]
        assert len(search_runs(catalog)) == 8


def test_maneuvers_left_out_by_hand_are_kept_with_the_run(
    outcome: RunOutcome, tmp_path: Path
) -> None:
    with Catalog(tmp_path / "c.sqlite") as catalog:
        number = save_run(catalog, outcome)
        rename_run(catalog, number, "mine")
        before = load_run(catalog, number)
        update_run_means(catalog, replace(exclude_maneuvers(outcome, ["2:1"]), number=number))
        after = load_run(catalog, number)
        assert (after.label, after.created_at) == ("mine", before.created_at)
        assert after.values["Cm_q"].n == before.values["Cm_q"].n - 1
        assert after.values["Cl_p"] == before.values["Cl_p"]
        assert after.settings["left out of the means"] == "2:1"
        found = repeat_run(catalog, number)
        assert (found.is_identical, found.differences) == (True, ())
        assert found.outcome.summary.excluded_maneuvers == {"2:1"}
        update_run_means(catalog, replace(exclude_maneuvers(outcome, []), number=number))
        assert load_run(catalog, number).values == before.values
    with pytest.raises(UnknownNameError, match="no maneuver '3:1' to exclude"):
        execute_run(outcome.request.with_changes(without=("3:1",)))


def test_maneuvers_that_the_catalog_has_stay_as_they_are(
    outcome: RunOutcome, tmp_path: Path
) -> None:
    """A run of windows named by hand adds to a flight's maneuvers, and overrules none."""
    entry = outcome.flights[0]
    moved = replace(entry.maneuvers[0], t_start=20.0, t_end=30.0, note="another")
    standing = replace(entry, maneuvers=(moved, entry.maneuvers[1]), complete=True)
    with Catalog(tmp_path / "c.sqlite") as catalog:
        save_run(catalog, replace(outcome, flights=(standing, outcome.flights[1])))
        save_run(catalog, outcome)
        found = search_maneuvers(catalog, ManeuverFilter(flight="a"))
        told = [(one.maneuver.id, one.maneuver.note) for one in found]
        assert told == [("2", ""), ("1", "another")]
        # What was fitted from 0 to 6 s is not told of the maneuver that has its name.
        names = [one.maneuvers[0] for one in search_runs(catalog, kept=2)]
        assert names == [("a", "0:6"), ("a", "2"), ("b", "1"), ("b", "2")]


def test_other_certificates_and_damage_are_told(outcome: RunOutcome, tmp_path: Path) -> None:
    """Nothing is kept of a run with borrowed certificates; a later program's settings are named."""
    borrowed = replace(outcome, request=outcome.request.with_changes(calibration="b777"))
    with Catalog(tmp_path / "c.sqlite") as catalog:
        with pytest.raises(FlightError, match="own certificates"):
            save_run(catalog, borrowed)
        assert stored_runs(catalog) == ()
        number = save_run(catalog, outcome)
        ((text,),) = catalog.query("SELECT request FROM kept_runs")
        content = json.loads(text)
        content["gusts"] = True
        with catalog.transaction() as connection:
            connection.execute("UPDATE kept_runs SET request = ?", (json.dumps(content),))
        # The list still shows it.
        (found,) = stored_runs(catalog)
        with pytest.raises(FlightError, match="gusts"):
            _ = found.request
        with catalog.transaction() as connection:
            connection.execute("UPDATE kept_runs SET request = '{}'")
        with pytest.raises(FlightError, match="cannot be read"):
            _ = load_run(catalog, number).request


# --- settings through JSON ----------------------------------------------------------------------

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(min_value=0.0, exclude_min=True, allow_infinity=False)
VALUES = st.dictionaries(st.sampled_from(("Cm_q", "CN_0", "Cl_p")), NUMBERS)
NAMES = st.lists(st.sampled_from(("alpha", "q", "an")), unique=True).map(tuple)
SETTINGS = st.fixed_dictionaries(
    {},
    optional={
        "method": st.sampled_from(("ml", "ee", "ftr")),
        "free": st.none() | NAMES,
        "held": VALUES,
        "response_weights": st.none()
        | st.dictionaries(st.text(max_size=3), st.dictionaries(NAMES.map("+".join), POSITIVE)),
        "joint": st.booleans(),
        "responses": st.none() | NAMES,
        "biases": st.none() | NAMES,
        "time_shifts": NAMES,
        "known_model": st.none()
        | st.just(load_model("b777").with_effect("aero.Cm.alpha2", {"k": 0.1})),
        "start": VALUES,
        "priors": st.dictionaries(st.just("Cm_q"), st.tuples(NUMBERS, POSITIVE)),
        "noise": st.sampled_from(("diagonal", "full")),
        "stand_ins": VALUES,
        "bound_factor": st.none() | POSITIVE,
        "restart": POSITIVE,
    },
)
# On Windows a path is whole with its drive only.
FLIGHT = Path("/flights/campaign/a.csv").absolute()
MANEUVERS = st.lists(
    st.builds(
        SelectedManeuver, flight=st.just(FLIGHT), id=st.text(), t_start=NUMBERS, t_end=NUMBERS,
        inputs=NAMES,
    ),
    max_size=3,
).map(tuple)  # fmt: skip


@settings(max_examples=30, deadline=None)
@given(SETTINGS, MANEUVERS, st.text(max_size=5))
def test_every_setting_goes_through_json_exactly(
    chosen: dict[str, Any], maneuvers: tuple[SelectedManeuver, ...], label: str
) -> None:
    """Every float to the last bit, the model by its content, tuples as tuples, in their order."""
    asked = RunRequest(flights=(FLIGHT,), maneuvers=maneuvers, label=label, **chosen)
    folder = FLIGHT.parent
    text = json.dumps(request_json(asked, folder), allow_nan=False)
    back = request_from_json(json.loads(text), folder)
    assert back == asked
    assert list(back.held) == list(asked.held)
    for name in RunRequest.model_fields:
        assert type(getattr(back, name)) is type(getattr(asked, name)), name


def test_a_request_of_the_former_format_is_read() -> None:
    """Settings were nested by the part of the program that used them."""
    content = json.loads((Path(__file__).parent / "former_request.json").read_text("utf-8"))
    found = request_from_json(content, FLIGHT.parent)
    assert found.maneuver_windows == ("0:6",)
    assert found.response_weights == {"a": {"q": 3.0}}
    assert (found.weights, found.model, found.aircraft) == ("w.toml", "b777", "b777")
    assert found.known_model is not None
    assert found.known_model.derivative("CN_q") == 4.0
    assert found.held == {"CN_q": 5.0}
    assert (found.priors, found.bound_factor) == ({"Cm_q": (-20.0, 5.0)}, 10.0)
    assert (found.noise, found.axis, found.max_iterations) == ("full", "both", 7)


def test_flights_beside_the_catalog_move_with_it(outcome: RunOutcome) -> None:
    """Paths within the catalog's folder are found in another place; others stay where they are."""
    asked = outcome.request.with_changes(aircraft="b777")
    here = asked.flights[0].parent
    content = request_json(asked, here)
    assert request_from_json(content, here) == asked
    stick = Path("/media/stick").absolute()
    there = request_from_json(content, stick)
    assert there.flights == (stick / "a.csv", stick / "b.csv")
    assert {one.flight for one in there.maneuvers} == set(there.flights)
    assert there.aircraft == "b777"
    elsewhere = request_json(asked, Path("/media"))
    assert request_from_json(elsewhere, Path("/media/stick")).flights == asked.flights


# --- who is killed, who writes beside -----------------------------------------------------------


def whole(path: Path, outcome: RunOutcome) -> int:
    """Return how many runs a catalog holds, having seen that each is whole and nothing else."""
    fitted = [one.estimate for one in outcome.result.results if one.estimate is not None]
    wanted = (len(fitted), sum(len(one.derivatives) for one in fitted))
    connection = sqlite3.connect(path)
    try:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
        runs = connection.execute("SELECT count(*) FROM kept_runs").fetchone()[0]
        fits = connection.execute(
            """SELECT count(DISTINCT r.id), count(*) FROM runs r JOIN estimates e ON e.run = r.id
            GROUP BY r.kept"""
        ).fetchall()
        places = connection.execute("SELECT count(*) FROM run_maneuvers").fetchone()[0]
    finally:
        connection.close()
    assert fits == [wanted] * runs
    assert places == wanted[0] * runs
    return int(runs)


def forked(work: Callable[[], object]) -> int:
    # Control C must not reach the child before it can end by it.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    child = os.fork()
    if child:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        return child
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        work()
        os._exit(0)
    except BaseException:
        os._exit(1)


@pytest.mark.long
@forks
def test_a_process_killed_while_it_keeps_leaves_whole_runs(
    outcome: RunOutcome, tmp_path: Path
) -> None:
    """Killed at 30 moments, the catalog opens each time with every run whole or not there."""
    path = tmp_path / "c.sqlite"
    Catalog(path).close()
    chance = random.Random(7)
    amidst = before = 0
    for _ in range(30):
        reading, writing = os.pipe()

        def work(writing: int = writing) -> None:
            with Catalog(path) as catalog:
                while True:
                    os.write(writing, b"(")
                    save_run(catalog, outcome)
                    os.write(writing, b")")

        child = forked(work)
        assert select.select([reading], [], [], 20.0)[0]
        time.sleep(chance.uniform(0.0, 0.04))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(writing)
        said = os.read(reading, 1000)
        os.close(reading)
        now = whole(path, outcome)
        # A run that was said to be kept is there; one begun may be.
        assert now - before - said.count(b")") in (0, said.count(b"(") - said.count(b")"))
        amidst += said.endswith(b"(")
        before = now
    assert amidst > 15
    with Catalog(path) as catalog:
        assert len(stored_runs(catalog)) == before
        assert catalog.version == len(schema.MIGRATIONS)


@pytest.mark.long
@forks
def test_a_run_that_is_interrupted_leaves_nothing_half_done(
    outcome: RunOutcome, tmp_path: Path
) -> None:
    """Control C at 12 moments of reading, fitting and keeping: a whole run or none, no more."""
    folder = tmp_path / "flights"
    folder.mkdir()
    flights = tuple(Path(shutil.copy(one, folder)) for one in outcome.request.flights)
    asked = RunRequest(
        flights=flights, maneuver_windows=outcome.request.maneuver_windows, model="b777"
    )
    path = tmp_path / "c.sqlite"
    chance = random.Random(11)
    ended = 0

    def work() -> None:
        made = execute_run(asked)
        with Catalog(path) as catalog:
            save_run(catalog, made)

    for _ in range(12):
        child = forked(work)
        time.sleep(chance.uniform(0.0, 0.25))
        os.kill(child, signal.SIGINT)
        ended += os.waitpid(child, 0)[1] == 0
        assert sorted(one.name for one in folder.iterdir()) == ["a.csv", "b.csv"]
        if path.exists():
            with Catalog(path) as catalog:
                assert len(stored_runs(catalog)) in (ended, ended + 1)
            ended = whole(path, outcome)
    assert ended < 12


@forks
def test_two_processes_keep_at_once(outcome: RunOutcome, tmp_path: Path) -> None:
    path = tmp_path / "c.sqlite"

    def work() -> None:
        with Catalog(path) as catalog:
            for _ in range(6):
                save_run(catalog, outcome)

    for child in [forked(work), forked(work)]:
        assert os.waitpid(child, 0)[1] == 0
    assert whole(path, outcome) == 12
