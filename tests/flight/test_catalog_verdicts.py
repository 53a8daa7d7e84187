"""Verdicts in the catalog: kept beside the grades, and old catalogs take them up."""

import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight.catalog import (
    CardScore,
    Catalog,
    StoredVerdict,
    export_catalog,
    list_card_scores,
    schema,
    search_maneuvers,
    search_verdicts,
    store_debrief,
    store_grade,
    store_maneuvers,
)
from gsapp.flight.maneuvers import detect_maneuvers
from gsapp.foundation import FlightError
from tests.flight.maneuver_kit import EVERYTHING, make_flight

FLIGHT = replace(make_flight(EVERYTHING, seconds=125.0), name="2003-05-12-a")
FOUND = detect_maneuvers(FLIGHT, load_aircraft("b777"))
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
        verdict(3, FOUND[-1].t_end + 20.0, "spoiled", V=None),
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
        assert [one.name for one in search_verdicts(catalog, result="spoiled")] == ["M3"]
        assert search_verdicts(catalog, card="E1") == ()


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


def test_a_catalog_from_before_the_verdicts_takes_them_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "old.sqlite"
    with monkeypatch.context() as before:
        before.setattr(schema, "MIGRATIONS", schema.MIGRATIONS[:1])
        with Catalog(path) as old:
            # As the program of then wrote it: its search knew of no verdicts.
            store_maneuvers(old, FLIGHT, FOUND, aircraft="B777")
            assert old.version == 1
    with sqlite3.connect(path) as plain:
        tables = {row[0] for row in plain.execute("SELECT name FROM sqlite_master")}
        assert "verdicts" not in tables
    with Catalog(path) as catalog:
        assert catalog.version == len(schema.MIGRATIONS) > 1
        kept = search_maneuvers(catalog)
        assert [one.maneuver.to_record() for one in kept] == [one.to_record() for one in FOUND]
        assert {one.verdict for one in kept} == {""}
        store_debrief(catalog, FLIGHT, [verdict(1, FOUND[0].t_input)], SCORES)
        assert search_maneuvers(catalog)[0].verdict == "good"
        assert len(export_catalog(catalog)["tables"]["verdicts"]) == 1
