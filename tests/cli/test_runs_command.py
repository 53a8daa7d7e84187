"""``gsapp estimate --catalog`` keeps runs; ``gsapp runs`` lists, compares, repeats them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gsapp.cli._console import MEAN_HEADINGS, format_value_and_bound, mean_cells
from gsapp.cli.main import app
from gsapp.foundation import FlightError, GroundStationError, UnknownNameError
from gsapp.identification.campaign import CampaignValue
from tests.identification.runs_kit import WINDOWS, write_flights


def gsapp(*arguments: object) -> str:
    done = CliRunner().invoke(
        app, [str(one) for one in arguments], catch_exceptions=False, env={"COLUMNS": "120"}
    )
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    flights = write_flights(folder)
    catalog = folder / "campaign.sqlite"
    windows = [word for window in WINDOWS for word in ("--maneuver", window)]
    common = ("estimate", *flights, *windows, "--model", "b777", "--catalog", catalog)
    kept = gsapp(*common, "--label", "all free", "--json", folder / "estimate.json")
    assert kept.rstrip().endswith(f"kept as run 1 in {catalog}")
    assert all(heading in kept for heading in ("mean", "bound", "disagreement"))
    assert "mass lies" not in kept  # the shipped aircraft is not doubted
    gsapp(*common, "--hold", "CN_q=5", "--weights", "table-6.2.7")
    return catalog


def test_runs_are_listed_and_shown(campaign: Path) -> None:
    listed = gsapp("runs", campaign)
    assert "2 runs" in listed
    assert "all free" in listed
    assert "Cm_alpha" in listed
    shown = gsapp("runs", campaign, "show", 2)
    assert "CN_q 5" in shown
    content = json.loads(gsapp("runs", campaign, "show", 2, "--json", "-"))
    assert content["settings"]["held"] == "CN_q 5"
    assert [one["id"] for one in content["maneuvers"]] == ["1", "2", "1", "2"]
    assert [one["role"] for one in content["inputs"]] == [
        "flight", "flight", "aircraft", "model", "weights",
    ]  # fmt: skip
    first, second = json.loads(gsapp("runs", campaign, "--json", "-"))
    assert (first["number"], first["label"], first["flights"]) == (1, "all free", ["a", "b"])
    assert "CN_q" in first["values"]
    assert "CN_q" not in second["values"]


def test_a_kept_run_shows_the_means_of_its_estimate(campaign: Path) -> None:
    estimated = json.loads((campaign.parent / "estimate.json").read_text(encoding="utf-8"))
    assert (
        json.loads(gsapp("runs", campaign, "show", 1, "--json", "-"))["campaign"]
        == (estimated["campaign"])
    )
    compared = json.loads(gsapp("runs", campaign, "compare", 1, 2, "--json", "-"))["values"]
    assert {one["name"]: one["one"] for one in compared if one["one"]} == estimated["campaign"]
    means = {name: mean_cells(CampaignValue(**one)) for name, one in estimated["campaign"].items()}
    for text in (gsapp("runs", campaign, "show", 1), gsapp("runs", campaign, "compare", 1, 2)):
        assert all(heading in text for heading in MEAN_HEADINGS)
        rows = [line.split() for line in text.splitlines()]
        for name, cells in means.items():
            assert any(row[:5] == [name, *cells] for row in rows), name


def test_two_runs_are_compared(campaign: Path) -> None:
    """What was asked for otherwise, and each value with the difference in joint bounds."""
    said = gsapp("runs", campaign, "compare", 1, 2)
    assert "from the residuals" in said
    assert "single value" in said
    content = json.loads(gsapp("runs", campaign, "compare", 1, 2, "--json", "-"))
    assert [one["name"] for one in content["settings"]] == ["held", "weights"]
    values = {one["name"]: one for one in content["values"]}
    assert values["CN_q"]["other"] is None
    assert values["Cm_de"]["difference"] == pytest.approx(
        values["Cm_de"]["other"]["mean"] - values["Cm_de"]["one"]["mean"]
    )


def test_another_process_repeats_a_run_to_the_last_bit(campaign: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", "runs", str(campaign), "repeat", "2", "--json", "-"],
        capture_output=True, encoding="utf-8", check=False,
        env={**os.environ, "PYTHONHASHSEED": "77"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    assert (content["same"], content["differences"]) == (True, [])
    assert [one["id"] for one in content["maneuvers"]] == ["1:1", "1:2", "2:1", "2:2"]
    assert "run 2" in done.stderr


def test_a_run_is_renamed_forgotten_and_called_back(campaign: Path) -> None:
    assert "named 'held'" in gsapp("runs", campaign, "rename", 2, "held")
    said = gsapp("runs", campaign, "forget", 2)
    assert "recall 2" in " ".join(said.split())
    assert "1 run" in gsapp("runs", campaign)
    gsapp("runs", campaign, "recall", 2)
    assert "held" in gsapp("runs", campaign)


@pytest.mark.parametrize(
    "words",
    [
        ("frob",),
        ("show",),
        ("compare", "1"),
        ("show", "x"),
        ("forget", "1", "2"),
        ("report", "1"),
        ("show", "1", "--out", "x"),
    ],
)
def test_wrong_calls_are_told_with_the_right_one(campaign: Path, words: tuple[str, ...]) -> None:
    done = CliRunner().invoke(app, ["runs", str(campaign), *words])
    assert done.exit_code == 2
    assert "gsapp runs CATALOG" in done.output or "'list', 'show'" in done.output


def test_what_is_not_there_is_told(campaign: Path, tmp_path: Path) -> None:
    with pytest.raises(FlightError, match="--catalog"):
        gsapp("runs", tmp_path / "none.sqlite")
    with pytest.raises(UnknownNameError, match="no run 9"):
        gsapp("runs", campaign, "show", 9)
    with pytest.raises(GroundStationError, match=r"\.html or \.pdf"):
        gsapp("runs", campaign, "report", 1, "--out", tmp_path / "page.docx")


def test_what_cannot_be_kept_is_told_before_the_work(campaign: Path, tmp_path: Path) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_text("no catalog " * 100, encoding="utf-8")
    for place, text in ((notes, "not a catalog"), (tmp_path / "x" / "c.sqlite", "no folder")):
        with pytest.raises(FlightError, match=text):
            gsapp("estimate", tmp_path / "none.csv", "--catalog", place)


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [
        (-22.97391, 0.10781, ("-22.9739", "0.1078")),
        (0.0149608, 0.0000291, ("0.014961", "0.000029")),
        (-0.00000042, 0.0000037, ("-0.0000004", "0.0000037")),
        (0.5, 0.0, ("0.50000000", "0.00000000")),
    ],
)
def test_a_small_bound_keeps_two_digits(value: float, std: float, shown: tuple[str, str]) -> None:
    assert format_value_and_bound(value, std) == shown
