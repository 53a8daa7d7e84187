"""``gsapp estimate`` and ``gsapp linear-models`` from outside, on virtual flights."""

import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import get_args

import pytest
from scipy.io import loadmat
from typer.testing import CliRunner

from gsapp.aircraft import load_aircraft
from gsapp.cli.estimate import estimate
from gsapp.cli.main import app
from gsapp.cli.report import report
from gsapp.dynamics.model import load_model
from gsapp.flight.catalog import Catalog, search_runs
from gsapp.flight.maneuvers.input_shape import InputKind
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.runs.request import RunRequest
from gsapp.report.estimate_export import campaign_files
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.cli.command_kit import gsapp
from tests.identification.virtual_maneuvers import fly
from ui.review.review_jobs import EstimateJob, LinearModelsJob, ReviewJobHandler, RunReportJob

TRUTH = load_model("b777")


@pytest.fixture(scope="module")
def flights(
    tmp_path_factory: pytest.TempPathFactory, flown_short: Callable[[int], VirtualFlight]
) -> Path:
    folder = tmp_path_factory.mktemp("flights")
    for seed in (5, 6):
        write_block(folder / f"flight{seed}.csv", flown_short(seed).measured, "csv")
    return folder


def process(*arguments: object, seed: str = "0") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "gsapp.cli", *map(str, arguments)]
    return subprocess.run(
        command, capture_output=True, encoding="utf-8", check=False,
        env={**os.environ, "PYTHONHASHSEED": seed},
    )  # fmt: skip


def result_of(*arguments: object, folder: Path) -> dict:
    out = folder / "out.json"
    done = gsapp(*arguments, "--json", out)
    assert done.returncode == 0, done.stderr
    return json.loads(out.read_text(encoding="utf-8"))


def test_maximum_likelihood_of_two_flights_finds_the_truth(flights: Path, tmp_path: Path) -> None:
    """Means within four of their bounds, runs and settings in the catalog, fixed JSON keys."""
    content = result_of(
        "estimate", flights / "flight5.csv", flights / "flight6.csv", "--aircraft", "b777",
        "--catalog", tmp_path / "campaign.sqlite", folder=tmp_path,
    )  # fmt: skip
    assert content["method"] == "ml"
    assert content["joint"] is None
    assert [one["id"] for one in content["maneuvers"]] == ["1:1", "1:2", "2:1", "2:2"]
    for one in content["maneuvers"]:
        assert one["converged"]
        assert {"flight", "t_start", "t_end", "input", "derivatives", "cramer_rao", "fit"} <= set(
            one
        )
        assert all(
            {"rms", "rms_over_range_pct", "r2", "theil"} == set(f) for f in one["fit"].values()
        )
    campaign = content["campaign"]
    for name in (
        "CN_alpha",
        "Cm_alpha",
        "Cm_q",
        "Cm_de",
        "Cl_p",
        "Cl_da",
        "Cn_beta",
        "Cn_r",
        "Cn_dr",
    ):
        value = campaign[name]
        assert value["n"] == 2
        # Sensor errors of the day are systematic: four bounds, or four percent.
        miss = abs(value["mean"] - TRUTH.derivative(name))
        assert miss < max(4.0 * value["std"], 0.04 * abs(TRUTH.derivative(name))), name
    with Catalog(tmp_path / "campaign.sqlite") as store:
        runs = search_runs(store)
        assert len(runs) == 4
        assert runs[0].estimates
        assert runs[0].settings["method"] == "ml"


def test_catalog_is_searched_by_condition_and_derivative(flights: Path, tmp_path: Path) -> None:
    """Maneuvers of both flights by input and speed; estimates beside them; CSV and JSON."""
    catalog = tmp_path / "campaign.sqlite"
    for seed in (5, 6):
        flight = flights / f"flight{seed}.csv"
        done = gsapp("estimate", flight, "--catalog", catalog, "--axis", "lon")
        assert done.returncode == 0
        # The shipped aircraft gives no warning about itself.
        assert "the mass lies" not in done.stdout
    done = gsapp("catalog", catalog, "--inputs", "de", "--derivative", "Cm_de",
                 "--csv", tmp_path / "found.csv")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "2 maneuvers" in done.stdout
    assert done.stdout.count("ml -1.") == 2
    assert len((tmp_path / "found.csv").read_text(encoding="utf-8").splitlines()) == 3
    content = json.loads(gsapp("catalog", catalog, "--where", "V=500 ft/s:", "--json", "-").stdout)
    assert content == []
    content = json.loads(
        gsapp("catalog", catalog, "--where", "V=20 m/s:60 m/s", "--json", "-").stdout
    )
    assert [one["inputs"] for one in content] == [["de"], ["da", "dr"]] * 2
    assert content[0]["runs"][0]["derivatives"]["Cm_de"]["value"] < -1.0
    assert gsapp("catalog", catalog, "--inputs", "elevater").returncode == 2
    wrong = gsapp("catalog", catalog, "--where", "V")
    assert wrong.returncode == 2
    assert "CHANNEL=LEAST:MOST" in wrong.stderr
    wrong = gsapp("catalog", catalog, "--where", "V=90:100")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "unit" in wrong.stderr
    assert "no catalog" in gsapp("catalog", tmp_path / "none.sqlite").stderr
    # A slip is told, where an empty table would pass for a campaign without such maneuvers.
    for words, told in (
        (("--derivative", "Cm_dee"), "no estimate of 'Cm_dee'; did you mean 'Cm_de'"),
        (("--flight", "flight7"), "no flight 'flight7'; did you mean 'flight"),
        (("--kind", "dublet"), "'dublet' is not one of 'doublet'"),
    ):
        wrong = gsapp("catalog", catalog, *words)
        assert wrong.returncode != 0
        assert told in " ".join(wrong.stderr.split())


def test_every_shape_of_an_input_can_be_searched_for() -> None:
    for kind in (*get_args(InputKind), "none"):
        asked = CliRunner().invoke(app, ["catalog", "none.sqlite", "--kind", kind])
        assert isinstance(asked.exception, FlightError), asked.output


@pytest.mark.parametrize("method", ["ee", "ftr"])
def test_other_methods_give_the_same_shape(flights: Path, tmp_path: Path, method: str) -> None:
    # In flight 6 no gyro clips; FTR has no use for a lateral record with holes as short as this.
    content = result_of("estimate", flights / "flight6.csv", "--method", method, folder=tmp_path)
    assert content["method"] == method
    for name in ("Cm_de", "Cl_da", "Cn_dr"):
        found = content["campaign"][name]["mean"]
        assert found == pytest.approx(TRUTH.derivative(name), rel=0.1), name


def test_hold_free_weights_and_joint_do_what_they_say(flights: Path, tmp_path: Path) -> None:
    content = result_of(
        "estimate", flights / "flight5.csv", flights / "flight6.csv", "--axis", "lon",
        "--hold", "CN_q=5", "--weights", "table-6.2.7", "--joint", folder=tmp_path,
    )  # fmt: skip
    assert [one["input"] for one in content["maneuvers"]] == ["de", "de"]
    assert content["maneuvers"][0]["held"]["CN_q"] == 5.0
    assert "CN_q" not in content["campaign"]
    assert content["joint"]["derivatives"]["Cm_alpha"]["value"] == pytest.approx(
        TRUTH.derivative("Cm_alpha"), rel=0.1
    )
    assert content["joint"]["fits"][0]["maneuvers"] == ["1:1", "2:1"]
    forms = content["forms"]["joint"]["lon"]
    condition = forms["condition"]
    aircraft = load_aircraft("b777")
    expected = (
        content["joint"]["derivatives"]["Cm_alpha"]["value"]
        * condition["qbar"] * aircraft.geometry.wing_area * aircraft.geometry.chord
        / aircraft.mass.iyy
    )  # fmt: skip
    # The CG as flown lies next to the file's.
    assert forms["dimensional"]["M_alpha"]["value"] == pytest.approx(expected, rel=0.05)
    assert forms["dimensional"]["M_alpha"]["unit"] == "1/s^2"
    assert "short period" in {one["name"] for one in forms["state-space"]["modes"]}
    content = result_of(
        "estimate", flights / "flight5.csv", "--axis", "lon", "--free", "Cm_alpha,Cm_q,Cm_de,Cm_0",
        "--model", "b777", folder=tmp_path,
    )  # fmt: skip
    assert set(content["campaign"]) == {"Cm_alpha", "Cm_q", "Cm_de", "Cm_0"}
    assert content["maneuvers"][0]["held"]["CN_alpha"] == TRUTH.derivative("CN_alpha")


def test_why_instruments_cannot_be_compared_is_printed_once(flights: Path) -> None:
    done = gsapp("compatibility", flights / "flight5.csv", "--maneuver", "60:60.2")
    assert " ".join(done.stdout.split()).count("compare instruments") == 1


def test_engines_running_on_the_ground_are_no_maneuver(flights: Path) -> None:
    """Named by hand or not, nothing is estimated where nothing flew."""
    done = gsapp("estimate", flights / "flight5.csv", "--maneuver", "5:15")
    assert done.returncode == 1
    assert "not flown" in " ".join(done.stderr.split())


def test_instruments_are_not_blamed_for_windows_on_the_ground(
    flights: Path, tmp_path: Path
) -> None:
    flight = flights / "flight5.csv"
    done = gsapp("compatibility", flight, "--maneuver", "5:15")
    assert done.returncode == 1
    assert "maneuver 1" in " ".join(done.stderr.split())
    content = result_of(
        "compatibility", flight, "--maneuver", "5:15", "--maneuver", "39:46", folder=tmp_path
    )
    assert content["maneuvers"] == ["2"]


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (("--hold", "Cm_qq=1"), 2, "did you mean 'Cm_q'"),
        (("--hold", "Cm_q"), 2, "write NAME=VALUE"),
        (("--prior", "Cm_q=3"), 2, "write NAME=VALUE:STD"),
        (("--maneuver", "9000:9010"), 1, "no samples"),
        (("--maneuver", "5"), 2, "cannot be read"),
        (("--weights", "nosuch"), 1, "weights"),
        (("--aircraft", "nosuch"), 1, "aircraft"),
        (("--responses", "alpha,qq"), 2, "not one of the responses"),
    ],
)
def test_wrong_calls_get_one_sentence(
    flights: Path, arguments: tuple[str, ...], code: int, sentence: str
) -> None:
    """The remedy, no traceback; exit code 2 for words that no flight could fit, 1 for these."""
    done = gsapp("estimate", flights / "flight5.csv", *arguments)
    assert done.returncode == code
    assert sentence in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr


def test_terms_of_a_coefficient_are_chosen(flights: Path, tmp_path: Path) -> None:
    content = result_of(
        "terms", flights / "flight5.csv", flights / "flight6.csv", "--coefficient", "Cm",
        "--aircraft", "b777", folder=tmp_path,
    )  # fmt: skip
    found = content["coefficients"]["Cm"]
    assert found["beyond_linear"] == []
    for name in ("Cm_alpha", "Cm_q", "Cm_de"):
        assert found["terms"][name]["value"] == pytest.approx(TRUTH.derivative(name), rel=0.05)
    assert found["steps"]
    done = gsapp("terms", flights / "flight5.csv", "--coefficient", "CM")
    assert done.returncode == 2
    assert "'CM'" in " ".join(done.stderr.split())


def test_linear_models_are_not_judged_on_the_flight_they_are_fitted_to(
    flights: Path, tmp_path: Path
) -> None:
    """Its errors would flatter them, and the table says that another flight was flown."""
    flight = flights / "flight5.csv"
    done = gsapp("linear-models", flight, "--validate", flights / ".." / flights.name / flight.name,
                 "--aircraft", "b777", "--out", tmp_path / "models")  # fmt: skip
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "fitted to it" in done.stderr


def test_linear_models_are_fitted_on_one_flight_and_judged_on_another(
    flights: Path, tmp_path: Path
) -> None:
    """Three models for each axis with matrices, modes and error table; files can be read back."""
    content = result_of(
        "linear-models", flights / "flight5.csv", "--validate", flights / "flight6.csv",
        "--aircraft", "b777", "--out", tmp_path / "models", folder=tmp_path,
    )  # fmt: skip
    for axis, outputs in (("lon", ("an", "alpha", "q")), ("lat", ("ay", "beta", "p", "r"))):
        assert set(content[axis]) == {"bls", "subspace", "ml"}
        for name, one in content[axis].items():
            assert {"A", "B", "C", "D", "states", "modes"} <= set(one)
            for output in outputs:
                assert 0.0 < one["rms_over_range_pct"][output] < 40.0, (axis, name, output)
    model = load_linear_model(tmp_path / "models" / "ml-lat.toml").model()
    assert model.states == ("beta", "p", "r", "phi")


@pytest.mark.parametrize("name", ["B777", "Gull"])
def test_errors_of_the_source_stand_beside_its_own_aircraft_alone(
    flights: Path, tmp_path: Path, name: str
) -> None:
    shipped = files("gsapp.aircraft") / "files" / "b777.toml"
    own = tmp_path / "own.toml"
    own.write_text(
        shipped.read_text(encoding="utf-8").replace('name = "B777"', f'name = "{name}"'),
        encoding="utf-8",
    )
    done = gsapp("linear-models", flights / "flight5.csv", "--validate", flights / "flight6.csv",
                 "--aircraft", own)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert ("tables 7.4.1" in done.stdout) is (name == "B777")
    assert ("; 13.51" in done.stdout) is (name == "B777")


@pytest.mark.long
def test_a_report_is_complete_and_a_button_writes_the_same_page(
    flights: Path, tmp_path: Path
) -> None:
    """Page, PDF, pictures and results as files; truth in them.

    What the window's button starts writes the same page and the same files, in a process that
    orders its sets otherwise: the line of the date is the only one that differs.
    """
    out, again, told = tmp_path / "results", tmp_path / "again.html", tmp_path / "told.json"
    done = process(
        "report", flights, "--model", "b777", "--out", out, "--no-date", "--json", told, seed="7"
    )
    assert done.returncode == 0, done.stderr
    content = json.loads(told.read_text(encoding="utf-8"))
    assert {*map(Path, content.pop("written"))} >= {out / "report.html", out / "report.pdf"}
    assert content.pop("calibration")
    assert content.pop("instruments") == []
    assert content.pop("disagreement").keys() == content["campaign"].keys()
    assert content.pop("forms")
    assert content.items() <= json.loads((out / "campaign.json").read_text("utf-8")).items()
    assert done.stdout.lstrip().startswith("4 maneuvers")
    one = {path.name: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    for name in ("report.html", "report.pdf", "derivatives.csv", "values.csv", "campaign.json"):
        assert one[name]
    assert sum(name.endswith(".png") for name in one) >= 7
    bench = ReviewJobHandler(lambda _share, _words: None)
    paths = (flights / "flight5.csv", flights / "flight6.csv")
    run = bench.do(EstimateJob(request=RunRequest(flights=paths, model="b777")))
    linear = bench.do(LinearModelsJob(outcome=run))
    bench.do(RunReportJob(outcome=run, path=again, linear=linear))
    files = campaign_files(run, linear)
    assert len(files) == 8
    assert {name: one[name] for name in files} == files
    page = one["report.html"].decode()
    lines = again.read_text(encoding="utf-8").splitlines()
    dated = [line for line in lines if line.startswith('<p class="written">')]
    assert len(dated) == 1
    assert [line for line in lines if line not in dated] == page.splitlines()
    for text in ("Validity", "Estimates in flight", "short period", "flight5",
                  "validated on 1 maneuver of flight6 not used in the fit"):  # fmt: skip
        assert text in page
    assert "http" not in re.sub(r"data:[^\"]*", "", page)
    model = load_model(out / "model.toml")
    assert model.parent == "b777"
    assert model.derivative("Cm_de") == pytest.approx(TRUTH.derivative("Cm_de"), rel=0.04)
    mat = loadmat(out / "derivatives.mat", simplify_cells=True)
    assert mat["derivatives"]["Cm_de"]["mean"] == model.derivative("Cm_de")
    assert mat["linear_lat"]["A"].shape == (4, 4)
    linear = load_linear_model(out / "linear-lon.toml").model()
    assert linear.states == ("alpha", "V", "q", "theta")
    judged = json.loads(one["linear-models.json"])
    assert judged["lon"]["ml"]["judged_on"] == ["2:1"]


def test_wrong_calls_of_a_report_get_one_sentence(flights: Path, tmp_path: Path) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    for options, text in (
        ({"flights": [flights], "out": tmp_path / "report.docx"}, "ends in .html or .pdf"),
        ({"flights": [empty], "out": tmp_path / "out"}, "holds no flight"),
        ({"flights": [flights / "none.csv"], "out": tmp_path / "out"}, "there is no flight"),
        (
            {"flights": [flights], "out": tmp_path / "out", "validate": [empty]},
            "not among the flights",
        ),
    ):
        with pytest.raises(GroundStationError, match=text):
            report(**options)
    assert [path.name for path in tmp_path.iterdir()] == ["empty"]
    done = gsapp("report", empty, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) <= 2


def test_methods_stand_beside_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each method has a column with its mean, and contradictions are named."""
    monkeypatch.setenv("COLUMNS", "200")
    rough = fly(70, "lon", gust=1.0, dt=0.02).maneuver
    flight = write_block(tmp_path / "gusty.csv", rough.block, "csv")
    out = tmp_path / "out.json"
    estimate(flights=[flight], aircraft="b777", maneuver_windows=["0:10"], json=out)
    shown = capsys.readouterr().out
    (maneuver,) = json.loads(out.read_text(encoding="utf-8"))["maneuvers"]
    own = maneuver["derivatives"]
    others = {key: one["derivatives"] for key, one in maneuver["comparisons"].items()}
    assert others.keys() >= {"ee", "ftr"}
    (row,) = [line for line in shown.splitlines() if line.strip().startswith("Cm_q")]
    for derivatives in (own, *others.values()):
        assert f"{derivatives['Cm_q']['value']:.4f}" in row
    text = " ".join(shown.split())
    assert "turbulence" in text
    apart = [
        name
        for name, one in own.items()
        if not name.endswith("_0")
        and one["value"] is not None
        and abs(one["value"] - others["ee"][name]["value"])
        > 3.0 * math.hypot(one["std"], others["ee"][name]["std"])
    ]
    assert ("ML and equation error contradict each other" in text) == bool(apart)
