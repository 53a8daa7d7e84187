"""Runs over a campaign in the catalog, and transactions within one another."""

from dataclasses import replace
from pathlib import Path

import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight.catalog import (
    CampaignRun,
    Catalog,
    EstimationRun,
    FlightEntry,
    StoredEstimate,
    add_entry,
    delete_campaign_run,
    export_catalog,
    get_campaign_run,
    list_campaign_runs,
    restore_campaign_run,
    search_maneuvers,
    search_runs,
    set_campaign_run_label,
    store_campaign_run,
    store_entry,
    store_run,
)
from gsapp.flight.maneuvers import detect_maneuvers
from gsapp.flight.provenance import InputFile
from gsapp.foundation import FlightError, UnknownNameError
from tests.flight.maneuver_kit import EVERYTHING, make_flight

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
    before = export_catalog(catalog)

    def store(maneuver: str) -> None:
        with catalog.transaction():
            number = store_campaign_run(catalog, RECORD)
            store_run(catalog, replace(FIT, campaign_run_id=number))
            store_run(
                catalog, replace(FIT, campaign_run_id=number, maneuvers=((FLIGHT.name, maneuver),))
            )

    with pytest.raises(UnknownNameError, match="no maneuver '77'"):
        store("77")
    assert export_catalog(catalog) == before
    store("2")
    assert len(search_runs(catalog, kept=1)) == 2
