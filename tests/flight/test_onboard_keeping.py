"""An on-board log goes into a flight whole or not at all, and all that was noted stays."""

import json
import shutil
import subprocess
import sys
import time
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.cli.flight_files import onboard
from gsapp.flight.events import Event, read_events
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.maneuvers import (
    ManeuverAssessor,
    ManeuverEditLog,
    collect_maneuvers,
    run_detector,
)
from gsapp.flight.onboard_log.log_storage import activate_log, install_log, list_logs
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification.runs.request import RunRequest, SelectedManeuver
from gsapp.identification.runs.run_execution import execute_run
from gsapp.quantities import Block
from tests.flight.box_kit import box_tlog
from tests.flight.onboard_kit import BEGUN_US, fly_thin

OFFSET, DRIFT = 3.7, 400e-6
"""Ten times what a crystal does, since the flight is ten times shorter than a real one."""


@pytest.fixture(scope="module")
def thin(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thin")
    log = folder / "box.tlog"
    return fly_thin(folder / "f", log, seconds=49.0, offset=OFFSET, drift=DRIFT), log


@pytest.fixture
def flight(thin, tmp_path):
    folder, log = thin
    shutil.copytree(folder.path, tmp_path / "f")
    return FlightFolder.open(tmp_path / "f"), log


def listing(folder):
    return {
        str(path.relative_to(folder.path)): path.read_bytes()
        for path in folder.path.rglob("*")
        if path.is_file() and "cache" not in path.parts
    }


def test_what_was_noted_before_stands_after_the_log_has_come(flight):
    """Marks, verdicts, edges by hand, grades by hand, certificates: all stay where they were.

    The motion under them is the same within a sample, and what is estimated has better bounds.
    """
    folder, log = flight
    aircraft = load_aircraft("b777")
    before = load_flight(folder.path)
    detector = run_detector(before, aircraft)
    found = detector.finish()
    assert [one.inputs for one in found] == [("de",)]
    edits = ManeuverEditLog(folder.events, found)
    assess = ManeuverAssessor(before, aircraft, detector.noise).assess
    name = found[0].id
    start, stop = found[0].t_start + 0.2, found[0].t_end + 0.3
    edits.record(edits.maneuver_list.move(name, assess, t_start=start, t_end=stop))
    edits.record(edits.maneuver_list.regrade(name, "B", assess, "gusty, said the pilot"))
    folder.events.append(Event(kind="mark", text="doublet", time=start + 1.0))
    folder.events.append(
        Event(kind="verdict", text="good", time=stop, data={"id": name, "t_input": start + 1.0})
    )
    noted = read_events(folder.path / "events.jsonl").events
    (edited,) = collect_maneuvers(load_flight(folder.path), aircraft).maneuvers

    placed = install_log(folder.path, log)

    after = placed.flight
    assert after.onboard.in_place
    clock = after.onboard.clock
    assert clock.drifts
    assert abs(clock.drift - DRIFT) < 4.0 * clock.drift_std
    assert clock.drift_std < 60e-6
    assert read_events(folder.path / "events.jsonl").events == noted
    (now,) = collect_maneuvers(after, aircraft).maneuvers
    assert (now.id, now.grade, now.reasons, now.graded_by) == (
        edited.id, "B", ("gusty, said the pilot",), "crew",
    )  # fmt: skip
    step = 1.0 / after.rate
    assert abs(now.t_start - edited.t_start) <= step + 1e-9
    assert abs(now.t_end - edited.t_end) <= step + 1e-9
    # Between its edges is the same motion: a sample early or late it fits worse.
    live, full = (one.block.between(now.t_start, now.t_end) for one in (before, after))
    for channel in ("q", "de"):
        apart = [
            np.square(np.interp(full.times + late, live.times, live[channel]) - full[channel]).sum()
            for late in (-step, 0.0, step)
        ]
        assert apart[1] == min(apart), channel
    # The certificates in force are the flight's own, applied to the volts of the log.
    assert after.certificates.to_json() == before.certificates.to_json()
    assert after.sources["q"].calibrated
    assert after.sources["q"].source.startswith("on-board log: ")

    def bounds(as_it_is):
        chosen = SelectedManeuver(
            flight=as_it_is, id=now.id, t_start=now.t_start, t_end=now.t_end, inputs=("de",)
        )
        outcome = execute_run(RunRequest(flights=(as_it_is,), maneuvers=(chosen,), axis="lon"))
        (result,) = outcome.result.results
        derivatives = result.estimate.derivatives
        return {key: one.std for key, one in derivatives.items() if one.std is not None}

    with_log = bounds(folder.path)
    activate_log(folder.path, "")
    live_only = bounds(folder.path)
    shared = [key for key in ("Cm_alpha", "Cm_q", "Cm_de", "CN_alpha") if key in live_only]
    assert len(shared) >= 3
    assert all(with_log[key] < 0.8 * live_only[key] for key in shared), (with_log, live_only)


def test_the_command_tells_and_takes_back(flight, tmp_path, capsys):
    """A log, then another, then the former one again, then none: by commands, told in JSON."""
    folder, log = flight
    live = load_flight(folder.path)
    text = tmp_path / "said.json"

    def told(**options):
        onboard(flight=folder.path, json=text, **options)
        return json.loads(text.read_text())

    assert told()["onboard"] is None
    first = told(log=log)
    assert (first["onboard"]["file"], first["former"]) == ("box.tlog", "")
    assert first["onboard"]["clock"]["offset"] == pytest.approx(OFFSET, abs=0.03)
    said_first = capsys.readouterr().out
    assert "ppm (standard deviation" in said_first
    assert "To go back: " in said_first
    assert told(log=log)["onboard"] == first["onboard"]
    assert "To go back: " not in capsys.readouterr().out  # to where it stands already
    # The data box wrote columns as well, in engineering units.
    full = load_flight(folder.path)
    block = full.block.between(5.0, 50.0)
    names = ("q", "p", "r", "alpha", "de", "da", "dr", "qbar")
    csv = tmp_path / "box.csv"
    columns = np.stack([block[name] for name in names], axis=1)
    write_flight_csv(csv, Block(channels=names, times=block.times - 2.0, values=columns), "si")
    second = told(log=csv)
    assert (second["onboard"]["file"], second["former"]) == ("box.csv", "box.tlog")
    assert second["onboard"]["clock"]["offset"] == pytest.approx(2.0, abs=0.005)
    assert second["logs"] == ["box.csv", "box.tlog"] == list(list_logs(folder))
    assert told(use="box.tlog")["onboard"] == first["onboard"]
    assert told(use="none")["onboard"] is None
    again = load_flight(folder.path)
    assert np.array_equal(again.block.values, live.block.values, equal_nan=True)
    with pytest.raises(FlightError, match=r"box\.csv, box\.tlog"):
        activate_log(folder.path, "other.bin")


def test_a_log_of_another_flight_changes_nothing(flight, tmp_path):
    folder, log = flight
    install_log(folder.path, log)
    before = listing(folder)
    other = tmp_path / "other.tlog"
    random = np.random.default_rng(2).normal(size=6000).cumsum()
    other.write_bytes(box_tlog(50.0, motion=lambda time: np.sin(random[int(time * 100)])))
    begun = datetime.fromtimestamp(BEGUN_US / 1e6, UTC) + timedelta(days=3)
    with pytest.raises(FlightError, match="2025-10-12"):
        install_log(folder.path, other, begun=begun)
    with pytest.raises(FlightError, match="live record itself"):
        install_log(folder.path, folder.tlog_file)
    table = tmp_path / "points.csv"
    table.write_text("angle [deg],volts [V]\n1,2\n")
    with pytest.raises(FlightError) as caught:
        install_log(folder.path, table)
    assert str(caught.value).count(str(table)) == 2  # by its name, and not by that of a copy
    assert "incoming" not in str(caught.value)
    torn = tmp_path / "1.bin"
    torn.write_bytes(b"no log at all" * 30)
    for wrong in (torn, tmp_path / "missing.bin", tmp_path, tmp_path / "x.pdf"):
        with pytest.raises(GroundStationError):
            install_log(folder.path, wrong)
    assert listing(folder) == before
    assert sorted(path.name for path in folder.cache_folder.iterdir()) == ["engineering.npz"]


def test_killed_in_the_midst_the_flight_stands(flight):
    folder, log = flight
    before = listing(folder)
    code = (
        "import sys; from gsapp.flight.onboard_log.log_storage import install_log; "
        "install_log(*sys.argv[1:])"
    )
    incoming = folder.cache_folder / "incoming"
    child = subprocess.Popen([sys.executable, "-c", code, str(folder.path), str(log)])
    deadline = time.monotonic() + 60.0
    while not incoming.exists() and child.poll() is None and time.monotonic() < deadline:
        time.sleep(0.002)
    time.sleep(0.05)
    child.kill()
    assert child.wait() != 0  # in the midst, not at its end
    assert listing(folder) == before
    assert load_flight(folder.path).onboard is None
    assert install_log(folder.path, log).flight.onboard.in_place
    assert sorted(path.name for path in folder.cache_folder.iterdir()) == ["engineering.npz"]


def test_names_that_are_taken_stay(flight, tmp_path):
    folder, log = flight
    live = folder.tlog_file.read_bytes()
    named = tmp_path / "raw.tlog"
    shutil.copy(log, named)
    assert install_log(folder.path, named).flight.onboard.file == "onboard.tlog"
    assert install_log(folder.path, named).flight.onboard.file == "onboard.tlog"
    shorter = tmp_path / "onboard.tlog"
    shorter.write_bytes(log.read_bytes()[: -(1 << 18)])
    placed = install_log(folder.path, shorter)
    assert (placed.flight.onboard.file, placed.previous_name) == ("onboard-2.tlog", "onboard.tlog")
    assert folder.tlog_file.read_bytes() == live
    empty = FlightFolder.create(tmp_path / "empty")
    with pytest.raises(FlightError, match="no live record"):
        install_log(empty.path, named)
