"""The catalog: what is stored comes back, whoever else writes, whatever happened to the file."""

import csv
import io
import sqlite3
import subprocess
import sys
import tempfile
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight.catalog import (
    Catalog,
    EstimationRun,
    ManeuverFilter,
    StoredEstimate,
    StoredModel,
    find_maneuvers,
    list_flights,
    load_maneuvers,
    maneuvers_csv,
    schema,
    search_maneuvers,
    search_runs,
    store_flight,
    store_grade,
    store_maneuvers,
    store_model,
    store_run,
)
from gsapp.flight.info import FlightInfo
from gsapp.flight.maneuvers import detect_maneuvers
from gsapp.foundation import FlightError, UnknownNameError
from tests.flight.maneuver_kit import EVERYTHING, all_rows, make_flight

FLIGHT = replace(make_flight(EVERYTHING, seconds=125.0), name="2003-05-12-a")
OTHER = replace(
    FLIGHT,
    name="2003-05-13-b",
    info=FlightInfo(date=datetime(2003, 5, 13, tzinfo=UTC), takeoff_weight="205 N", notes="windy"),
)
FOUND = detect_maneuvers(FLIGHT, load_aircraft("b777"))
EARNED = StoredEstimate(value=-0.34, std=0.01, cramer_rao=0.004)
UNEARNED = StoredEstimate(
    value=None, status="not-identifiable", confounded_with=("Cm_q",), why="they look alike"
)


@pytest.fixture
def catalog(tmp_path):
    with Catalog(tmp_path / "campaign.sqlite") as opened:
        store_maneuvers(opened, FLIGHT, FOUND, aircraft="B777")
        yield opened


def ids(found):
    return [(one.flight, one.maneuver.id) for one in found]


def test_maneuvers_come_back_as_they_were(catalog):
    stored = search_maneuvers(catalog)
    assert [one.maneuver.to_record() for one in stored] == [one.to_record() for one in FOUND]
    assert {one.graded_by for one in stored} == {"program"}
    # The second of trim before the input, not the maneuver itself.
    condition = stored[0].conditions["V"]
    assert condition.mean == pytest.approx(FOUND[0].V, abs=0.02)
    assert condition.minimum < condition.mean < condition.maximum
    assert stored[0].conditions["throttle"].mean == pytest.approx(0.5, abs=0.01)


def test_maneuvers_are_found_by_airframe_and_date(catalog):
    assert OTHER.info is not None
    for name, day in (("SN 3", 13), ("SN 4", 20)):
        info = OTHER.info.model_copy(
            update={"airframe": name, "date": datetime(2003, 5, day, 12, tzinfo=UTC)}
        )
        store_maneuvers(catalog, replace(OTHER, name=name, info=info), FOUND[:1], aircraft="B777")

    def flights(**wanted):
        return [one.flight for one in search_maneuvers(catalog, ManeuverFilter(**wanted))]

    assert flights(airframe="SN 3") == ["SN 3"]
    # A flight without an airframe is of the aircraft itself.
    assert set(flights(airframe="B777")) == {"2003-05-12-a"}
    assert len(flights(aircraft="B777")) == len(FOUND) + 2
    assert flights(since="2003-05-14") == ["SN 4"]
    assert flights(until="2003-05-13") == ["SN 3"]
    assert flights(since="2003-05", until="2003-05") == ["SN 3", "SN 4"]
    assert flights(until="2003-04") == []


def test_row_ids_load_as_many_as_wanted_in_their_order(catalog):
    numbers = find_maneuvers(catalog, ManeuverFilter())
    assert len(numbers) == len(FOUND)
    two = load_maneuvers(catalog, numbers[1::-1])
    assert [one.maneuver.id for one in two] == [FOUND[1].id, FOUND[0].id]


def test_mach_and_reynolds_number_and_wing_loading_are_conditions(tmp_path):
    """At 30 m/s and sea level: the aircraft's chord and area, sound and viscosity from tables."""
    plane = load_aircraft("b777")
    info = FlightInfo(takeoff_weight="200 N", weather={"temperature": "15 degC"})
    block = FLIGHT.block
    ground = block.channels.index("altitude")
    values = np.where(np.arange(len(block.channels)) == ground, 0.0, block.values)
    sea_level = replace(block, values=values)
    flight = replace(FLIGHT, block=sea_level, info=info)
    with Catalog(tmp_path / "c.sqlite") as opened:
        store_maneuvers(opened, flight, FOUND[:1], aircraft=plane)
        (stored,) = search_maneuvers(opened)
        found = {name: one.mean for name, one in stored.conditions.items()}
        V = found["V"]
        assert found["mach"] == pytest.approx(V / 340.29, rel=1e-4)
        reynolds = 1.225 * V * plane.geometry.chord / 1.7894e-5
        assert found["reynolds"] == pytest.approx(reynolds, rel=1e-3)
        assert found["wing_loading"] == pytest.approx(200.0 / plane.geometry.wing_area)
        wanted = {"mach": (0.05, None), "wing_loading": (None, 1e4)}
        assert len(search_maneuvers(opened, ManeuverFilter(conditions=wanted))) == 1
        assert search_maneuvers(opened, ManeuverFilter(conditions={"mach": (0.5, None)})) == ()


def test_maneuvers_are_found_by_flight_input_kind_condition_and_grade(catalog):
    store_maneuvers(catalog, OTHER, FOUND[:2])
    assert len(search_maneuvers(catalog)) == len(FOUND) + 2
    assert ids(search_maneuvers(catalog, ManeuverFilter(flight="2003-05-13-b"))) == [
        ("2003-05-13-b", "1"),
        ("2003-05-13-b", "2"),
    ]
    assert ids(search_maneuvers(catalog, ManeuverFilter(inputs=["dr", "da"]))) == [
        ("2003-05-12-a", "4")
    ]
    assert ids(search_maneuvers(catalog, ManeuverFilter(kind="3-2-1-1"))) == [("2003-05-12-a", "5")]
    assert len(search_maneuvers(catalog, ManeuverFilter(conditions={"V": (29.0, 31.0)}))) == 7
    assert search_maneuvers(catalog, ManeuverFilter(conditions={"V": (None, 20.0)})) == ()
    assert search_maneuvers(catalog, ManeuverFilter(conditions={"flap": (None, None)})) == ()
    store_grade(catalog, "2003-05-12-a", "1", "D", ["pilot sneezed"], by="A. Pilot")
    assert ("2003-05-12-a", "1") not in ids(
        search_maneuvers(catalog, ManeuverFilter(worst_grade="C"))
    )
    with pytest.raises(FlightError, match="no grade 'E'"):
        search_maneuvers(catalog, ManeuverFilter(worst_grade="E"))


def test_a_persons_grade_stands_when_the_flight_is_stored_again(catalog):
    store_grade(catalog, FLIGHT.name, "1", "D", ["pilot sneezed"], by="A. Pilot")
    store_maneuvers(catalog, FLIGHT, FOUND)
    first = search_maneuvers(catalog)[0]
    assert (first.maneuver.grade, first.maneuver.reasons) == ("D", ("pilot sneezed",))
    assert first.graded_by == "A. Pilot"
    # Storing the same again adds nothing to the history.
    assert catalog.query("SELECT count(*) FROM grades")[0][0] == len(FOUND) + 1


def test_what_is_no_longer_found_stays_as_the_origin_of_estimates(catalog):
    number = store_run(
        catalog,
        EstimationRun(
            method="ml", axis="lon", maneuvers=((FLIGHT.name, "1"),), estimates={"Cm_alpha": EARNED}
        ),
    )
    store_maneuvers(catalog, FLIGHT, FOUND[1:])
    assert "1" not in [one.maneuver.id for one in search_maneuvers(catalog)]
    (run,) = search_runs(catalog, derivative="Cm_alpha")
    assert (run.id, run.maneuvers) == (number, ((FLIGHT.name, "1"),))
    # Found again, it stands again.
    store_maneuvers(catalog, FLIGHT, FOUND)
    assert search_maneuvers(catalog)[0].runs == (number,)


def test_runs_keep_settings_estimates_and_the_edges_of_their_time(catalog):
    store_model(catalog, StoredModel(name="b777-2", content="name = 'x'", parent="b777"))
    run = EstimationRun(
        method="ml",
        axis="lon",
        maneuvers=((FLIGHT.name, "1"), (FLIGHT.name, "5")),
        estimates={"Cm_alpha": EARNED, "Cm_q": UNEARNED},
        settings={"weights": {"q": 8.0}, "lags": 50},
        fit={"q": {"rms": 0.01}},
        model="b777-2",
        iterations=6,
        warnings=("residuals are colored",),
        made_at="2026-01-01T00:00:00+00:00",
    )
    number = store_run(catalog, run)
    moved = replace(FOUND[0], t_end=FOUND[0].t_end - 1.0)
    store_maneuvers(catalog, FLIGHT, (moved, *FOUND[1:]))
    (back,) = search_runs(catalog, method="ml", axis="lon", flight=FLIGHT.name)
    edges = tuple((one.t_start, one.t_end) for one in (FOUND[0], FOUND[4]))
    assert back == replace(run, id=number, edges=edges)
    assert search_runs(catalog, derivative="Cm_q") == ()
    assert search_runs(catalog, axis="lat") == ()


def test_a_run_of_unknown_origin_leaves_nothing_behind(catalog):
    plain = EstimationRun(method="ml", axis="lon", maneuvers=(), estimates={})
    for changes, text in (
        ({"maneuvers": (("x", "1"),)}, "no flight 'x'"),
        ({"maneuvers": ((FLIGHT.name, "77"),), "estimates": {"a": EARNED}}, "no maneuver '77'"),
        ({"model": "m"}, "no model 'm'"),
    ):
        with pytest.raises(UnknownNameError, match=text):
            store_run(catalog, replace(plain, **changes))
    with pytest.raises(FlightError, match="cannot hold"):
        store_run(catalog, replace(plain, settings={"x": float("nan")}))
    assert search_runs(catalog) == ()
    assert catalog.query("SELECT count(*) FROM run_maneuvers")[0][0] == 0


def test_models_and_flights(catalog):
    store_model(catalog, StoredModel(name="m", content="a = 1", evidence="better by half"))
    store_model(catalog, StoredModel(name="m", content="a = 2", evidence="better still"))
    (model,) = catalog.query("SELECT * FROM models")
    assert (model["content"], model["evidence"]) == ("a = 2", "better still")
    store_flight(catalog, OTHER, aircraft="B777")
    # Dated flights first.
    assert list_flights(catalog) == ("2003-05-13-b", "2003-05-12-a")
    (row,) = catalog.query("SELECT * FROM flights WHERE name = ?", (OTHER.name,))
    assert (row["takeoff_weight"], row["notes"]) == (205.0, "windy")


def test_a_flight_taken_out_takes_its_rows_along(catalog):
    with catalog.transaction() as connection:
        connection.execute("DELETE FROM flights WHERE name = ?", (FLIGHT.name,))
    for table in ("maneuvers", "inputs", "conditions", "grades"):
        assert all_rows(catalog)[table] == []
    with pytest.raises(FlightError, match="rejects"), catalog.transaction() as connection:
        connection.execute("INSERT INTO inputs (maneuver, surface) VALUES (99, 'de')")


def test_a_search_becomes_a_table(catalog):
    found = list(csv.DictReader(io.StringIO(maneuvers_csv(search_maneuvers(catalog)))))
    assert found[3]["inputs"] == "da+dr"
    assert float(found[0]["V"]) == pytest.approx(30.0, abs=0.2)


def test_a_failure_in_between_changes_nothing(catalog):
    before = all_rows(catalog)
    broken = replace(FOUND[1], t_end=FOUND[1].t_start)
    with pytest.raises(FlightError, match="rejects"):
        store_maneuvers(catalog, FLIGHT, (FOUND[0], broken))
    assert all_rows(catalog) == before


WRITER = """
import sys
from dataclasses import replace
from tests.flight.maneuver_kit import make_flight
from gsapp.flight.catalog import Catalog, search_maneuvers, store_maneuvers
from gsapp.flight.maneuvers import DetectedManeuver
flight = make_flight(seconds=3.0, ground=0.0)
one = DetectedManeuver(id="1", t_start=0.0, t_end=2.0, inputs=("de",), kind="doublet",
                    amplitude=0.1, grade="A")
with Catalog(sys.argv[1]) as catalog:
    for k in range(5):
        store_maneuvers(catalog, replace(flight, name=f"{sys.argv[2]}-{k}"), [one])
        search_maneuvers(catalog)
"""


def test_two_programs_fill_one_catalog_at_once(tmp_path):
    path = tmp_path / "shared.sqlite"
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path), name], stderr=subprocess.PIPE, text=True
        )
        for name in ("one", "two")
    ]
    for program in programs:
        assert program.wait(60) == 0, program.stderr.read() if program.stderr else ""
    for program in programs:
        if program.stderr:
            program.stderr.close()
    with Catalog(path) as catalog:
        assert len(search_maneuvers(catalog)) == 10
        assert catalog.query("PRAGMA integrity_check")[0][0] == "ok"
        assert catalog.query("PRAGMA foreign_key_check") == []


def test_a_reader_does_not_wait_for_a_writer(tmp_path, catalog):
    with Catalog(catalog.path) as reader, catalog.transaction() as connection:
        connection.execute("DELETE FROM flights")
        assert len(search_maneuvers(reader)) == len(FOUND)


# Files that are none -------------------------------------------------------------------


def refused(path: Path, text: str) -> None:
    before = path.read_bytes() if path.is_file() else b""
    with pytest.raises(FlightError, match=text):
        Catalog(path)
    if path.is_file():
        assert path.read_bytes() == before


def test_a_file_of_another_kind_is_refused_and_left_alone(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("these are notes and no catalog " * 40)
    refused(text, "damaged or not a catalog")
    foreign = tmp_path / "photos.sqlite"
    connection = sqlite3.connect(foreign)
    connection.execute("CREATE TABLE photos (id INTEGER)")
    connection.commit()
    connection.close()
    refused(foreign, "database of another program")
    refused(tmp_path, "is a folder")
    refused(tmp_path / "absent" / "c.sqlite", "no folder")


def test_a_damaged_catalog_gets_one_sentence(tmp_path):
    path = tmp_path / "c.sqlite"
    with Catalog(path) as made:
        store_maneuvers(made, FLIGHT, FOUND)
        made.query("PRAGMA wal_checkpoint(TRUNCATE)")
        made.query("PRAGMA journal_mode = DELETE")
    data = bytearray(path.read_bytes())
    # All pages but the first, which tells that it is a catalog.
    data[4096:] = b"\xa5" * (len(data) - 4096)
    path.write_bytes(bytes(data))
    with pytest.raises(FlightError, match="damaged"), Catalog(path) as opened:
        search_maneuvers(opened)
    cut = tmp_path / "cut.sqlite"
    cut.write_bytes(bytes(data[:3000]))
    with pytest.raises(FlightError, match="damaged"), Catalog(cut) as opened:
        search_maneuvers(opened)


_READS_ONLY = """
import os, sys
from gsapp.flight.catalog import Catalog, search_maneuvers, store_maneuvers
from gsapp.foundation import FlightError
if os.getuid() == 0:
    os.setgid(65534); os.setuid(65534)
try:
    with Catalog(sys.argv[1]) as opened:
        found = search_maneuvers(opened)
        print(*(one.maneuver.id for one in found))
        with opened.transaction() as connection:
            connection.execute("DELETE FROM maneuvers")
except FlightError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
@pytest.mark.parametrize("left", [False, True], ids=["closed", "with a log left"])
def test_a_catalog_that_may_not_be_written_is_read(left):
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        path = place / "c.sqlite"
        with Catalog(path) as made:
            store_maneuvers(made, FLIGHT, FOUND)
            log = place / "c.sqlite-wal"
            written = log.read_bytes()
        if left:
            log.write_bytes(written)
        try:
            for one in place.iterdir():
                one.chmod(0o444)
            place.chmod(0o555)
            done = subprocess.run(
                [sys.executable, "-c", _READS_ONLY, str(path)],
                capture_output=True, text=True, timeout=240,
            )  # fmt: skip
        finally:
            place.chmod(0o755)
    lines = done.stdout.splitlines()
    if not left:
        assert lines[0].split() == [one.id for one in FOUND], done.stderr
    assert "cannot be used" in lines[-1], done.stderr
    assert "permissions" in lines[-1]
    assert len(lines) == (1 if left else 2)


def test_a_newer_catalog_is_not_touched(tmp_path):
    path = tmp_path / "c.sqlite"
    with Catalog(path) as made:
        made.query(f"PRAGMA user_version = {len(schema.MIGRATIONS) + 3}")
    with pytest.raises(FlightError, match="newer version"):
        Catalog(path)


def test_an_older_catalog_is_brought_up_to_date_with_its_content(tmp_path, monkeypatch):
    """A further step runs once, on a filled file, whole or not at all."""
    path = tmp_path / "c.sqlite"
    with Catalog(path) as made:
        store_maneuvers(made, FLIGHT, FOUND)
    step = ("ALTER TABLE flights ADD COLUMN pilot TEXT", "UPDATE flights SET pilot = 'nobody'")
    monkeypatch.setattr(schema, "MIGRATIONS", (*schema.MIGRATIONS, (*step, "NONSENSE")))
    with pytest.raises(FlightError, match="is damaged"):
        Catalog(path)
    monkeypatch.setattr(schema, "MIGRATIONS", (*schema.MIGRATIONS[:-1], step))
    with Catalog(path) as opened:
        assert opened.version == len(schema.MIGRATIONS)
        assert opened.query("SELECT pilot FROM flights")[0]["pilot"] == "nobody"
        assert len(search_maneuvers(opened)) == len(FOUND)
    with Catalog(path) as again:
        assert again.version == len(schema.MIGRATIONS)


def test_a_catalog_that_does_not_fit_on_the_disk_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fill(self: Catalog) -> None:
        self._connection.execute("PRAGMA max_page_count = 1")
        self._connection.execute("CREATE TABLE first (number INTEGER)")
        self._connection.execute("CREATE TABLE second (number INTEGER)")

    monkeypatch.setattr(Catalog, "_migrate", fill)
    with pytest.raises(FlightError, match="disk is full"):
        Catalog(tmp_path / "campaign.sqlite")
    assert list(tmp_path.iterdir()) == []
