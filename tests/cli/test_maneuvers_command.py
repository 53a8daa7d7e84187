"""``gsapp maneuvers`` prints for people, writes the fixed JSON, and fills a catalog."""

import io
import json
from contextlib import redirect_stdout
from math import radians
from pathlib import Path
from types import SimpleNamespace

import pytest

from gsapp.cli.catalog import catalog as search
from gsapp.cli.debrief import _sizes, debrief
from gsapp.cli.maneuvers import maneuvers
from gsapp.cli.runs import runs
from gsapp.flight.catalog import Catalog, ManeuverFilter, search_maneuvers
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError, GroundStationError
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from tests.flight.maneuver_kit import EVERYTHING, Input, make_flight

FIELDS = [
    "id", "t_start", "t_end", "inputs", "kind", "amplitude", "grade", "reasons", "V", "alpha",
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("flights")
    made = make_flight(EVERYTHING, seconds=120.0, rate=50.0).block
    write_block(place / "whole.csv", made, "csv", "us")
    short = make_flight([Input(at=3.0, surface="de")], ground=0.0, seconds=12.0, steering=0.0)
    write_block(place / "short.csv", short.block, "csv", "us")
    write_block(place / "blind.csv", made.select(["p", "q", "r", "V"]), "csv", "us")
    return place


@pytest.fixture(scope="module")
def listed(folder: Path) -> tuple[str, Path, Path]:
    """Return what was printed of the whole flight, its JSON, and the catalog with it."""
    out, catalog = folder / "m.json", folder / "campaign.sqlite"
    shown = io.StringIO()
    with redirect_stdout(shown):
        maneuvers(flights=[folder / "whole.csv"], aircraft="b777", json=out, catalog=catalog)
    return shown.getvalue(), out, catalog


def test_the_list_is_printed_and_written(listed):
    shown, out, catalog = listed
    assert "whole: 5 maneuvers" in shown
    assert "airspeed" in shown
    found = json.loads(out.read_text())
    assert [one["inputs"] for one in found] == [["de"], ["da"], ["dr"], ["da", "dr"], ["de"]]
    assert all(list(one) == FIELDS for one in found)
    # SI and radians, whatever the file was written in.
    assert found[0]["amplitude"] == pytest.approx(5.0 * DEGREE, rel=0.15)
    assert found[0]["V"] == pytest.approx(30.0, abs=0.5)
    assert found[0]["t_start"] == pytest.approx(59.0, abs=0.2)
    with Catalog(catalog) as opened:
        stored = search_maneuvers(opened, ManeuverFilter(flight="whole"))
    assert [one.maneuver.to_json() for one in stored] == found


def test_no_maneuver_is_an_a_that_the_debrief_does_not_call_good(folder, listed, tmp_path):
    debrief(flights=[folder / "whole.csv"], aircraft="b777", json=tmp_path / "d.json")
    found = json.loads(listed[1].read_text())
    judged = json.loads((tmp_path / "d.json").read_text())["flights"][0]["maneuvers"]
    results = set()
    for verdict in judged:
        (one,) = [one for one in found if one["t_start"] <= verdict["t_input"] < one["t_end"]]
        results.add(verdict["result"])
        assert one["grade"] >= verdict["grade"]
        assert verdict["result"] == "good" or one["grade"] != "A"
        assert verdict["result"] == "good" or one["reasons"]
    assert results - {"good"}


def test_json_alone_on_the_screen(folder, capsys):
    maneuvers(flights=[folder / "short.csv"], json=Path("-"))
    shown = capsys.readouterr()
    (one,) = json.loads(shown.out)
    # Shorter than a minute with one maneuver: taken whole.
    assert (one["t_start"], one["t_end"]) == (0.0, pytest.approx(11.99))
    assert one["inputs"] == ["de"]


def test_an_aircraft_that_does_not_exist_is_told(folder):
    with pytest.raises(GroundStationError, match="no-such-aircraft"):
        maneuvers(flights=[folder / "whole.csv"], aircraft="no-such-aircraft")


@pytest.mark.parametrize(
    ("name", "words"), [("blind.csv", "no samples of a surface"), ("absent.csv", "absent.csv")]
)
def test_what_cannot_be_searched_says_why(folder, tmp_path, name, words):
    catalog = tmp_path / "c.sqlite"
    with pytest.raises(GroundStationError, match=words):
        maneuvers(flights=[folder / name], catalog=catalog)
    assert not catalog.exists()


def test_a_flight_without_maneuvers_says_so(folder, tmp_path, capsys):
    quiet = make_flight(seconds=70.0, rate=50.0).block
    path = tmp_path / "quiet.csv"
    write_block(
        path, Block(channels=quiet.channels, times=quiet.times, values=quiet.values), "csv", "us"
    )
    maneuvers(flights=[path], json=tmp_path / "m.json")
    assert "no maneuver" in capsys.readouterr().out
    assert json.loads((tmp_path / "m.json").read_text()) == []


@pytest.mark.parametrize("there", [False, True])
def test_what_is_no_catalog_is_told_so(tmp_path: Path, there: bool) -> None:
    path = tmp_path / "campaign"
    if there:
        path.mkdir()
    text = "is a folder; name the file" if there else "there is no catalog"
    for ask in (
        lambda: search(file=path),
        lambda: runs(catalog=path),
        lambda: debrief(flights=[], catalog=path),
    ):
        with pytest.raises(FlightError, match=text):
            ask()


def test_an_input_stands_beside_its_target_and_the_band_that_is_good() -> None:
    band = SimpleNamespace(low=radians(1.5), best=radians(9.3), high=radians(15.5))
    judged = SimpleNamespace(
        verdict=SimpleNamespace(amplitudes={"dr": radians(14.6), "da": radians(2.0)}),
        target_input=SimpleNamespace(amplitudes={"dr": band}),
    )
    assert _sizes(judged) == "rudder 14.6 deg (target 9.3, 1.5 to 15.5), aileron 2.0 deg"
