"""Catalogs of older programs open, are brought up to date, and lose nothing.

The files in ``catalogs`` were written by the programs of their time.
"""

import sqlite3
from pathlib import Path

import pytest

from gsapp.flight.catalog import (
    CampaignRun,
    Catalog,
    EstimationRun,
    get_model,
    get_weights,
    list_campaign_runs,
    schema,
    search_maneuvers,
    search_runs,
    search_verdicts,
    store_campaign_run,
    store_run,
)

OLD = sorted((Path(__file__).parent / "catalogs").glob("version*.sql"))
RECORD = CampaignRun(
    label="first", method="ml", axis="lon", aircraft="B777", flights=("2003-05-12-a",), request={},
    settings={}, inputs=(), versions={}, result={},
)  # fmt: skip


def made(script: Path, path: Path) -> sqlite3.Connection:
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
    connection = made(script, path)
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
        assert get_weights(catalog, "2003-05-12-a") == {"alpha": 5.0, "q": 8.0}
        assert get_model(catalog, "b777-2").evidence == "better by half"
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
        number = store_campaign_run(catalog, RECORD)
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
    made(script, tmp_path / "old.sqlite").close()
    found = []
    for name in ("old", "new"):
        with Catalog(tmp_path / f"{name}.sqlite") as catalog:
            rows = catalog.query("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL")
            found.append({row["name"]: row["sql"] for row in rows})
    assert found[0] == found[1]
