"""Flights under review: what a person corrects stands everywhere, and is taken back everywhere."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gsapp.aircraft import load_aircraft
from gsapp.cli.maneuvers import maneuvers
from gsapp.flight.catalog import Catalog, StoredVerdict, search_maneuvers, store_debrief
from gsapp.flight.flight_import import import_flight
from gsapp.flight.maneuvers import FlightManeuvers, collect_maneuvers
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.maneuver import open_flights_with_maneuvers
from gsapp.quantities.stored_block import StoredBlock
from gsapp.session.review import (
    Review,
    ReviewedFlight,
    open_reviewed_flight,
    save_maneuvers_to_catalog,
)
from tests.flight.maneuver_kit import EVERYTHING, make_flight


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("record") / "a.csv"
    return write_block(path, make_flight(EVERYTHING, seconds=125.0, rate=50.0).block, "csv", "us")


@pytest.fixture
def flight(record: Path, tmp_path: Path) -> ReviewedFlight:
    return open_reviewed_flight(Path(shutil.copy(record, tmp_path / "a.csv")))


@pytest.fixture(scope="module")
def unchanged(record: Path) -> ReviewedFlight:
    return open_reviewed_flight(record)


def test_samples_of_flights_under_review_lie_in_files(tmp_path: Path) -> None:
    """Memory does not grow with the flights; grades of new stretches are those in memory."""
    path = tmp_path / "flight.csv"
    write_block(path, make_flight(EVERYTHING, seconds=125.0).block, "csv")
    flight = open_reviewed_flight(path, aircraft="b777")
    block = flight.flight.block
    assert isinstance(block, StoredBlock)
    whole = ReviewedFlight(
        replace(flight.flight, block=block.in_memory()), flight.aircraft, detect(flight)
    )
    first = flight.maneuvers[0]
    start, stop = first.t_start + 0.5, first.t_end + 1.0
    assert flight.grade_segment("x", start, stop) == whole.grade_segment("x", start, stop)


def detect(flight: ReviewedFlight) -> FlightManeuvers:
    return collect_maneuvers(flight.flight, flight.aircraft, as_found=True)


def test_a_correction_stands_for_every_command(flight, tmp_path):
    """Edges, names, notes and grades of a person are what `maneuvers` and `estimate` work on."""
    first, second, third, *_ = flight.maneuvers
    flight.move(first.id, first.t_start + 0.507, first.t_end - 1.0)
    flight.rename(second.id, "aileron")
    flight.set_grade("aileron", "D", "a gust")
    merged = flight.merge([third.id, "4"])
    flight.remove("5")
    put = flight.add(64.0, 67.0)
    maneuvers(flights=[flight.path], json=tmp_path / "m.json")
    found = json.loads((tmp_path / "m.json").read_text())
    assert [one["id"] for one in found] == [first.id, put, "aileron", merged]
    # Snapped to a sample, whatever was asked for.
    assert found[0]["t_start"] == pytest.approx(first.t_start + 0.5)
    assert (found[2]["grade"], found[2]["reasons"]) == ("D", ["a gust"])
    assert (found[3]["t_start"], found[3]["inputs"]) == (third.t_start, ["da", "dr"])
    (flown,) = open_flights_with_maneuvers([flight.path])
    # What a person graded unfit stays out of a fit, as does what shows no input.
    assert [one.id for one in flown.maneuvers] == [
        one.id for one in flight.maneuvers if one.grade != "D"
    ]
    assert any("6 changes (manual)" in remark for remark in flown.remarks)


def test_corrections_come_along_into_a_flight_folder(flight, tmp_path):
    flight.remove("2")
    flight.annotate("3", "calm")
    import_flight(flight.path, tmp_path / "folder")
    again = open_reviewed_flight(tmp_path / "folder")
    assert [(one.id, one.note) for one in again.maneuvers] == [
        ("1", ""), ("3", "calm"), ("4", ""), ("5", ""),
    ]  # fmt: skip
    again.undo()
    # From here on each goes its own way.
    assert again["3"].note == ""
    assert open_reviewed_flight(flight.path)["3"].note == "calm"


def test_changes_are_taken_back_in_their_order_by_whoever_looks(flight):
    other = open_reviewed_flight(flight.path)
    before = flight.maneuvers
    flight.annotate("1", "calm")
    flight.remove("2", "3")
    assert not flight.can_redo
    assert other.poll()
    assert other.maneuvers == flight.maneuvers
    assert other.undo() == "remove 2, 3"
    assert other.undo() == "note on 1"
    assert other.undo() == ""
    assert flight.poll()
    assert flight.maneuvers == before
    assert flight.redo() == "note on 1"
    assert flight["1"].note == "calm"
    assert flight.is_edited("1")
    assert not flight.is_edited("2")


def test_looking_at_other_edges_changes_nothing(unchanged):
    one = unchanged.maneuvers[0]
    shorter = unchanged.preview_move("1", one.t_start, one.t_input_end + 0.2)
    assert shorter.grade > one.grade
    assert unchanged.maneuvers[0] == one
    assert not unchanged.can_undo


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda flight: flight.move("1", 60.0, 60.2), "too short"),
        (lambda flight: flight.move("1", 63.0, 60.0), "too short"),
        (lambda flight: flight.rename("1", "2:M4"), "are separators"),
        (lambda flight: flight.rename("1", "2"), "taken"),
        (lambda flight: flight.merge(["1"]), "two or more maneuvers"),
        (lambda flight: flight.remove("9"), "no maneuver '9'"),
    ],
)
def test_what_cannot_be_is_said_and_changes_nothing(unchanged, wrong, words):
    with pytest.raises((FlightError, UnknownNameError), match=words):
        wrong(unchanged)
    assert not unchanged.can_undo


def test_edges_stop_at_the_ends_of_the_record(flight):
    flight.move("5", 100.0, 900.0)
    assert flight["5"].t_end == flight.span[1]
    assert flight.overlapping(flight["5"]) == ("4",)


def test_a_campaign_numbers_its_flights_and_chooses_its_maneuvers(flight, tmp_path):
    review = Review()
    review.add(flight)
    assert [row.id for row in review.rows()] == ["1", "2", "3", "4", "5"]
    second = open_reviewed_flight(Path(shutil.copy(flight.path, tmp_path / "b.csv")))
    review.add(second)
    second.set_grade("2", "D")
    second.set_in_use("3", False)
    rows = {row.id: row for row in review.rows()}
    assert list(rows) == [f"{k}:{m}" for k in (1, 2) for m in range(1, 6)]
    unused = [name for name, row in rows.items() if not row.in_use]
    assert unused == ["2:2", "2:3"]
    second.set_in_use("2", True)
    chosen = review.select_maneuvers()
    assert [(one.flight.stem, one.id) for one in chosen if one.id in "23"] == [
        ("a", "2"), ("a", "3"), ("b", "2"),
    ]  # fmt: skip
    (one,) = review.select_maneuvers(["2:4"])
    assert (one.inputs, one.t_start) == (("da", "dr"), second["4"].t_start)
    # A decision stays with its maneuver under another name, and counts for every command.
    second.rename("3", "wild")
    again = open_reviewed_flight(second.path)
    review.add(again)
    assert len(review.flights) == 2
    assert not again.in_use(again["wild"])
    flown = open_flights_with_maneuvers([second.path])[0]
    assert [one.id for one in flown.maneuvers] == ["1", "2", "4", "5"]
    assert any("wild" in remark for remark in flown.remarks)
    again.set_in_use("wild", True)
    assert again["wild"].use is None
    again.undo()
    review.remove(flight)
    assert [row.id for row in review.rows()][2] == "wild"
    assert review.find_maneuver("wild") == (again, again["wild"])
    assert review.find_maneuver("1:2") is None


def test_the_catalog_follows_and_knows_what_the_pilot_was_told(flight, tmp_path):
    """The crew's grade is kept there, and goes when it is taken back; another person's stays."""
    catalog = tmp_path / "made" / "campaign.sqlite"

    def kept() -> dict[str, tuple[str, str]]:
        save_maneuvers_to_catalog(catalog, flight.flight, flight.maneuvers, load_aircraft("b777"))
        with Catalog(catalog) as opened:
            return {
                one.maneuver.id: (one.maneuver.grade, one.graded_by)
                for one in search_maneuvers(opened)
            }

    before = kept()
    assert {by for _, by in before.values()} == {"program"}
    flight.set_grade("2", "D", "wind")
    flight.remove("5")
    assert kept() == {
        name: ("D", "crew") if name == "2" else told for name, told in before.items() if name != "5"
    }
    flight.undo()
    flight.undo()
    assert kept() == before
    told = StoredVerdict(
        name="M1", t_input=60.0, t_end=63.0, surfaces=("de",), kind="doublet", V=30.0,
        result="too-small", advice="50 % larger",
    )  # fmt: skip
    with Catalog(catalog) as opened:
        store_debrief(opened, flight.flight, [told])
    again = open_reviewed_flight(flight.path, catalog=catalog)
    verdict = again.verdict(again["1"])
    assert verdict.advice == "50 % larger"
    assert again.verdict(again["2"]) is None


def test_flights_of_one_name_are_told_apart_by_their_folders(record, tmp_path):
    review, paths = Review(), []
    for place in ("stick/a", "disk/a", "disk/old"):
        folder = tmp_path / place
        folder.mkdir(parents=True)
        paths.append(Path(shutil.copy(record, folder / "a.csv")))
    first, second, third = (open_reviewed_flight(path) for path in paths)
    review.add(first)
    assert [review.title(first), review.rows()[0].flight] == ["a", "a"]
    review.add(second)
    review.add(third)
    titles = [review.title(one) for one in review.flights]
    assert titles == ["a (stick/a/a.csv)", "a (disk/a/a.csv)", "a (old/a.csv)"]
    assert {row.flight for row in review.rows()} == set(titles)
