"""Runs and verdicts in the catalog, and catalogs of older programs, which lose nothing.

The files in ``catalogs`` were written by the programs of their time.
"""

import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight.catalog import (
    CampaignRun,
    CardScore,
    Catalog,
    EstimationRun,
    FlightEntry,
    StoredEstimate,
    StoredVerdict,
    add_entry,
    delete_campaign_run,
    get_campaign_run,
    list_campaign_runs,
    list_card_scores,
    restore_campaign_run,
    schema,
    search_maneuvers,
    search_runs,
    search_verdicts,
    set_campaign_run_label,
    store_campaign_run,
    store_debrief,
    store_entry,
    store_grade,
    store_maneuvers,
    store_run,
)
from gsapp.flight.maneuvers import detect_maneuvers
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError
from tests.flight.maneuver_kit import EVERYTHING, all_rows, make_flight

FLIGHT = replace(make_flight(EVERYTHING, seconds=125.0), name="2003-05-12-a")
FOUND = detect_maneuvers(FLIGHT, load_aircraft("b777"))
ENTRY = FlightEntry.from_flight(FLIGHT, FOUND, aircraft="B777")
RECORD = CampaignRun(
    label="all of them",
    method="ml",
    axis="both",
    aircraft="B777",
    flights=(FLIGHT.name,),
    request={"flights": ["a.csv"], "settings": {"held": {"CN_q": 0.1 + 0.2}}},
    settings={"held": "CN_q 0.3"},
    inputs=(
        InputFile(role="flight", name="a", sha256="12", parts={"raw.tlog": "34"}),
        InputFile(role="aircraft", name="b777", sha256="56"),
    ),
    versions={"numpy": "2.4"},
    result={"values": {"Cm_q": {"mean": -20.5, "std": 0.1}}},
    made_at="2026-01-01T00:00:00+00:00",
)
FIT = EstimationRun(
    method="ml", axis="lon", maneuvers=((FLIGHT.name, "1"),), edges=((58.5, 63.25),),
    estimates={"Cm_q": StoredEstimate(value=-20.5, std=0.1)}, made_at="2026-01-01",
)  # fmt: skip


@pytest.fixture
def catalog(tmp_path: Path):
    with Catalog(tmp_path / "c.sqlite") as opened:
        store_entry(opened, ENTRY)
        yield opened


def test_a_record_comes_back_as_it_was(catalog: Catalog) -> None:
    number = store_campaign_run(catalog, RECORD)
    store_run(catalog, replace(FIT, campaign_run_id=number))
    assert get_campaign_run(catalog, number) == replace(RECORD, number=number)
    (fit,) = search_runs(catalog, kept=number)
    assert fit == replace(FIT, id=1, campaign_run_id=number)
    set_campaign_run_label(catalog, number, "others")
    assert list_campaign_runs(catalog) == (replace(RECORD, number=number, label="others"),)
    with pytest.raises(UnknownNameError, match="no run 7"):
        get_campaign_run(catalog, 7)
    with pytest.raises(UnknownNameError, match="no run 7"):
        restore_campaign_run(catalog, 7)


def test_what_is_forgotten_is_nowhere_until_it_is_called_back(catalog: Catalog) -> None:
    store_run(catalog, FIT)
    number = store_campaign_run(catalog, RECORD)
    store_run(catalog, replace(FIT, campaign_run_id=number))
    delete_campaign_run(catalog, number)
    assert list_campaign_runs(catalog) == ()
    assert [one.id for one in search_runs(catalog, derivative="Cm_q")] == [1]
    assert search_maneuvers(catalog)[0].runs == (1,)
    restore_campaign_run(catalog, number)
    assert search_maneuvers(catalog)[0].runs == (1, 2)


def test_a_damaged_record_is_named(catalog: Catalog) -> None:
    store_campaign_run(catalog, RECORD)
    with catalog.transaction() as connection:
        connection.execute("UPDATE kept_runs SET inputs = '[{]'")
    with pytest.raises(FlightError, match=r"run 1 .* damaged"):
        list_campaign_runs(catalog)


def test_maneuvers_are_added_beside_those_that_stand(catalog: Catalog) -> None:
    first = FOUND[0]
    known = replace(first, note="not to be seen", t_end=first.t_end - 0.5)
    elsewhere = replace(FOUND[1], t_start=5.0, t_end=9.5)
    new = replace(FOUND[2], id="by hand")
    entry = FlightEntry.from_flight(FLIGHT, (known, elsewhere, new), complete=False)
    names = add_entry(catalog, entry)
    assert names == ("1", "5:9.5", "by hand")
    assert add_entry(catalog, entry) == names
    found = {one.maneuver.id: one.maneuver for one in search_maneuvers(catalog)}
    assert found["1"] == first
    assert found["2"] == FOUND[1]
    assert found["by hand"].t_start == new.t_start
    assert "5:9.5" not in found
    store_run(catalog, replace(FIT, maneuvers=((FLIGHT.name, "5:9.5"),), edges=((5.0, 9.5),)))
    assert search_runs(catalog)[0].maneuvers == ((FLIGHT.name, "5:9.5"),)


def test_a_transaction_within_another_is_part_of_it(catalog: Catalog) -> None:
    before = all_rows(catalog)

    def store(maneuver: str) -> None:
        with catalog.transaction():
            number = store_campaign_run(catalog, RECORD)
            store_run(catalog, replace(FIT, campaign_run_id=number))
            store_run(
                catalog, replace(FIT, campaign_run_id=number, maneuvers=((FLIGHT.name, maneuver),))
            )

    with pytest.raises(UnknownNameError, match="no maneuver '77'"):
        store("77")
    assert all_rows(catalog) == before
    store("2")
    assert len(search_runs(catalog, kept=1)) == 2


SCORES = (
    CardScore(card="E1", title="Elevator doublet", good=1, flown=2, requested=3),
    CardScore(card="A1", title="Aileron doublet", good=0, flown=0, requested=1),
)


def verdict(number: int, time: float, result: str = "good", **facts: object) -> StoredVerdict:
    return replace(
        StoredVerdict(
            name=f"M{number}", t_input=time, t_end=time + 4.0, surfaces=("da", "dr"),
            kind="doublet", V=30.5, result=result, advice=f"{result}: again", card="C1",
            is_counted=result == "good", record={"curves": {"times": [0.0, 0.04]}},
        ),
        **facts,
    )  # fmt: skip


def test_verdicts_come_back_with_the_maneuver_found_there_and_its_grade(tmp_path: Path) -> None:
    """The one grade of a maneuver, whoever gave it, stands beside what was said in flight."""
    first, second = FOUND[0], FOUND[2]
    said = (
        verdict(1, first.t_input),
        verdict(2, second.t_input + 0.05, "too-small"),
        verdict(3, FOUND[-1].t_end + 20.0, "invalid", V=None),
    )
    with Catalog(tmp_path / "c.sqlite") as catalog:
        store_debrief(catalog, FLIGHT, said, SCORES, aircraft="B777")
        assert [one.maneuver for one in search_verdicts(catalog)] == ["", "", ""]
        store_maneuvers(catalog, FLIGHT, FOUND)
        store_grade(catalog, FLIGHT.name, second.id, "D", ["I saw a gust"], by="Ann")
        back = search_verdicts(catalog)
        assert [replace(one, flight="", maneuver="", grade="", graded_by="") for one in back] == [
            *said
        ]
        assert [one.maneuver for one in back] == [first.id, second.id, ""]
        assert [(one.grade, one.graded_by) for one in back] == [
            (first.grade, "program"), ("D", "Ann"), ("", ""),
        ]  # fmt: skip
        assert list_card_scores(catalog, FLIGHT.name) == SCORES
        by_maneuver = {one.maneuver.id: one.verdict for one in search_maneuvers(catalog)}
        assert by_maneuver[first.id] == "good"
        assert by_maneuver[second.id] == "too-small"
        assert by_maneuver[FOUND[1].id] == ""
        assert [one.name for one in search_verdicts(catalog, result="invalid")] == ["M3"]
        assert search_verdicts(catalog, card="E1") == ()


def test_verdicts_of_an_older_catalog_have_their_present_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The program called them `spoiled` once; other texts of a verdict stay."""
    path = tmp_path / "c.sqlite"
    old = verdict(
        1, 5.0, "spoiled", advice="spoiled: rudder moved too",
        record={"verdict": {"result": "spoiled", "findings": [{"result": "spoiled"}]}},
    )  # fmt: skip
    with monkeypatch.context() as patched:
        patched.setattr(schema, "MIGRATIONS", schema.MIGRATIONS[:4])
        with Catalog(path) as catalog:
            store_debrief(catalog, FLIGHT, (old, verdict(2, 9.0)), SCORES)
    with Catalog(path) as catalog:
        first, second = search_verdicts(catalog)
    assert (first.result, second.result) == ("invalid", "good")
    assert first.record == {"verdict": {"result": "invalid", "findings": [{"result": "invalid"}]}}
    assert first.advice == old.advice


def test_a_second_debrief_takes_the_place_of_the_first(tmp_path: Path) -> None:
    other = replace(FLIGHT, name="2003-05-13-b")
    with Catalog(tmp_path / "c.sqlite") as catalog:
        store_debrief(catalog, FLIGHT, [verdict(1, 10.0), verdict(2, 20.0)], SCORES)
        store_debrief(catalog, other, [verdict(1, 15.0)], SCORES[:1])
        store_debrief(catalog, FLIGHT, [verdict(1, 11.0, "too-large")], ())
        assert [(one.flight, one.result) for one in search_verdicts(catalog)] == [
            (FLIGHT.name, "too-large"), (other.name, "good"),
        ]  # fmt: skip
        assert list_card_scores(catalog, FLIGHT.name) == ()
        assert list_card_scores(catalog, other.name) == SCORES[:1]


def test_a_debrief_is_stored_whole_or_not_at_all(tmp_path: Path) -> None:
    with Catalog(tmp_path / "c.sqlite") as catalog:
        store_debrief(catalog, FLIGHT, [verdict(1, 10.0)], SCORES)
        for wrong in (verdict(1, 20.0), verdict(2, 20.0, record={"x": float("nan")})):
            with pytest.raises(FlightError):
                store_debrief(catalog, FLIGHT, [verdict(1, 12.0), wrong], ())
        assert [one.t_input for one in search_verdicts(catalog)] == [10.0]
        assert list_card_scores(catalog, FLIGHT.name) == SCORES


def test_a_catalog_from_before_the_verdicts_takes_them_up(tmp_path: Path) -> None:
    path = tmp_path / "old.sqlite"
    with made_from(OLD[0], path) as plain:
        tables = {row[0] for row in plain.execute("SELECT name FROM sqlite_master")}
        assert "verdicts" not in tables
    with Catalog(path) as catalog:
        assert catalog.version == len(schema.MIGRATIONS) > 1
        kept = search_maneuvers(catalog)
        assert {one.verdict for one in kept} == {""}
        store_debrief(catalog, FLIGHT, [verdict(1, kept[0].maneuver.t_input)], SCORES)
        assert search_maneuvers(catalog)[0].verdict == "good"
        assert len(all_rows(catalog)["verdicts"]) == 1


OLD = sorted((Path(__file__).parent / "catalogs").glob("version*.sql"))
FIRST_RUN = CampaignRun(
    label="first", method="ml", axis="lon", aircraft="B777", flights=("2003-05-12-a",), request={},
    settings={}, inputs=(), versions={}, result={},
)  # fmt: skip


def made_from(script: Path, path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path)
    connection.executescript(script.read_text(encoding="utf-8"))
    return connection


def content(connection: sqlite3.Connection) -> dict[str, list[tuple[object, ...]]]:
    names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
    found = {}
    for (name,) in names:
        cursor = connection.execute(f"SELECT * FROM {name} ORDER BY rowid")  # noqa: S608
        columns = tuple(column[0] for column in cursor.description)
        found[name] = [columns, *cursor.fetchall()]
    return found


def test_every_former_version_is_tried() -> None:
    assert [one.stem for one in OLD] == [
        f"version{number}" for number in range(1, len(schema.MIGRATIONS))
    ]


@pytest.mark.parametrize("script", OLD, ids=[one.stem for one in OLD])
def test_an_old_catalog_keeps_its_content(script: Path, tmp_path: Path) -> None:
    """Row by row all that was there is there, searches give it, and runs can be kept."""
    path = tmp_path / "old.sqlite"
    connection = made_from(script, path)
    before = content(connection)
    assert connection.execute("PRAGMA user_version").fetchone()[0] < len(schema.MIGRATIONS)
    connection.close()
    with Catalog(path) as catalog:
        assert catalog.version == len(schema.MIGRATIONS)
        first, second, third = search_maneuvers(catalog)
        assert [one.runs for one in (first, second, third)] == [(1,), (2,), ()]
        assert (second.maneuver.grade, second.graded_by) == ("D", "A. Pilot")
        assert [one.campaign_run_id for one in search_runs(catalog)] == [None, None]
        assert search_runs(catalog)[1].estimates["Cm_alpha"].value == -0.34 - 0.02
        if "verdicts" in before:
            assert first.verdict == "good"
            assert [one.result for one in search_verdicts(catalog)] == ["good"]
        assert list_campaign_runs(catalog) == ()
        catalog.query("PRAGMA wal_checkpoint(TRUNCATE)")
    connection = sqlite3.connect(path)
    after = content(connection)
    connection.close()
    for table, (columns, *rows) in before.items():
        now, *present = after[table]
        assert now[: len(columns)] == columns
        assert [row[: len(columns)] for row in present] == rows, table
    with Catalog(path) as catalog:
        number = store_campaign_run(catalog, FIRST_RUN)
        store_run(
            catalog,
            EstimationRun(
                method="ml",
                axis="lon",
                maneuvers=(("2003-05-12-a", "1"),),
                estimates={},
                campaign_run_id=number,
            ),
        )
        assert [one.id for one in search_runs(catalog, kept=number)] == [3]


@pytest.mark.parametrize("script", OLD, ids=[one.stem for one in OLD])
def test_an_old_catalog_becomes_the_same_as_a_new_one(script: Path, tmp_path: Path) -> None:
    """No step was changed after its release: tables, indices and rules are those of a new file."""
    made_from(script, tmp_path / "old.sqlite").close()
    found = []
    for name in ("old", "new"):
        with Catalog(tmp_path / f"{name}.sqlite") as catalog:
            rows = catalog.query("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL")
            found.append({row["name"]: row["sql"] for row in rows})
    assert found[0] == found[1]
