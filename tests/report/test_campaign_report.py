"""The report on a run: what it says, and that its files hold what it says."""

import csv
import io
import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.io import loadmat

from gsapp.dynamics.model import load_model
from gsapp.identification.campaign import CanceledError
from gsapp.identification.linear_models.linear_model_files import load_linear_model
from gsapp.identification.runs.run_execution import exclude_maneuvers
from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
from gsapp.identification.summary.method_comparison import compare_methods
from gsapp.report.campaign_report import write_campaign_report
from gsapp.report.document import Document, DocumentTable, Paragraph
from gsapp.report.estimate_export import campaign_files, file_names
from gsapp.report.estimate_report import CampaignReportData, estimate_document
from gsapp.report.ftr_histories import FlightEstimateHistory
from gsapp.report.linear_report import linear_model_figure
from gsapp.report.linear_text import compare_linear_models
from tests.report.campaign_kit import TRUTH, WILD, gusty, outcome, together, unearned


@pytest.fixture(scope="module")
def compared() -> LinearModelValidation:
    return compare_linear_models(outcome())


def words_of(document: Document) -> str:
    found = [document.title, document.written, *(f"{one}: {two}" for one, two in document.facts)]
    for section in document.sections:
        found.append(section.title)
        for part in section.parts:
            if isinstance(part, Paragraph):
                found.append(part.text)
            elif isinstance(part, DocumentTable):
                found += [part.caption, " ".join(part.columns), *map(" ".join, part.rows)]
            else:
                found.append(part.caption)
    return "\n".join(found)


def test_the_report_says_what_a_supervisor_asks(compared: LinearModelValidation) -> None:
    heard = (FlightEstimateHistory(flight="A", why="there are too few samples"),)
    said = words_of(
        estimate_document(
            CampaignReportData(outcome=outcome(), ftr_histories=heard, linear=compared), units="SI"
        )
    )
    for text in (
        "Derivatives of the B777",
        f"Maneuver {WILD} is an outlier",
        "and by what the maneuvers scatter beyond their bounds",
        "times their bounds",
        "times the plain Cramer-Rao bounds",
        "validated on 2 maneuvers of B",
        "RMS error over range, percent, of the longitudinal models",
        "ML, appendix A",
        "short period",
        "Residuals: number of fits with white residuals",
        "A: FTR not computed: there are too few samples",
        "By moved surfaces",
    ):
        assert text in said, text
    assert "Written" not in said


def test_a_kept_run_stands_in_the_line_of_the_date_and_nowhere_else(
    compared: LinearModelValidation,
) -> None:
    when = datetime(2026, 5, 12, 9, 30, tzinfo=UTC)
    every = [
        words_of(
            estimate_document(
                CampaignReportData(outcome=replace(outcome(), number=number), linear=compared),
                written=when,
            )
        ).splitlines()
        for number in (None, 3)
    ]
    (differing,) = [pair for pair in zip(*every, strict=True) if pair[0] != pair[1]]
    assert differing == ("2026-05-12 09:30", "2026-05-12 09:30; run 3 of the catalog")


def test_what_was_not_earned_is_listed_with_its_reason() -> None:
    run = unearned()
    compared = compare_linear_models(run)
    said = words_of(estimate_document(CampaignReportData(outcome=run, linear=compared)))
    assert "Not estimated" in said
    assert "CN_q unknown" in said
    assert "no linear longitudinal" in said


def test_a_fit_of_all_together_stands_beside_the_means(compared: LinearModelValidation) -> None:
    run = together()
    said = words_of(estimate_document(CampaignReportData(outcome=run, linear=compared)))
    assert "jointly" in said
    (fit,) = run.result.joint
    found = fit.derivatives["Cm_de"]
    mean = run.summary.derivatives["Cm_de"].value
    assert found.std is not None
    apart = (found.value - mean.mean) / np.hypot(found.std, mean.std)
    assert f"Cm_de {found.value:.4f} {found.std:.4f} {mean.mean:.4f} {apart:+.1f}" in said
    assert "4 maneuvers jointly (longitudinal)" in said


def test_every_method_stands_in_the_report_and_gusty_maneuvers_are_named() -> None:
    run = gusty()
    document = estimate_document(CampaignReportData(outcome=run, linear=LinearModelValidation()))
    said = words_of(document)
    assert "1 maneuver (M1)" in said
    assert "Maneuver M1 of A by each method" in said
    (value,) = [one for one in compare_methods(run.result.results[0]) if one.name == "Cm_q"]
    shown, bound = value.values["ee"]
    assert f"{shown:.2f} {bound:.2f} {value.difference('ee'):+.1f}" in said


def test_pictures_have_names_of_their_own(compared: LinearModelValidation) -> None:
    """A page finds each picture by its name: two of one name would show one of them twice."""
    document = estimate_document(CampaignReportData(outcome=outcome(), linear=compared))
    names = [one.name for one in document.figures]
    assert len(names) == len(set(names)) > 8


def test_what_was_left_out_by_hand_is_said_and_marked(compared: LinearModelValidation) -> None:
    """In words, in the table of values, and in the JSON; the mean is that of the others."""
    without = exclude_maneuvers(outcome(), [WILD])
    said = words_of(estimate_document(CampaignReportData(outcome=without, linear=compared)))
    assert f"({WILD})" in said
    assert "is an outlier" not in said
    files = campaign_files(without, compared)
    rows = list(csv.DictReader(io.StringIO(files["values.csv"].decode())))
    out = {(row["maneuver"], row["left_out"]) for row in rows if row["derivative"] == "Cm_de"}
    assert (WILD, "1") in out
    assert ("1:M1", "0") in out
    content = json.loads(files["campaign.json"])
    assert content["left_out_by_hand"] == [WILD]
    assert content["campaign"]["Cm_de"]["n"] == 5


def test_every_file_can_be_read_back(compared: LinearModelValidation, tmp_path: Path) -> None:
    run = outcome()
    files = campaign_files(run, compared)
    assert set(files) == set(file_names(run, compared)) == {
        "derivatives.csv", "values.csv", "derivatives.mat", "campaign.json", "model.toml",
        "linear-lon.toml", "linear-models.json",
    }  # fmt: skip
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    mean = run.summary.derivatives["Cm_de"].value.mean
    assert mean == pytest.approx(TRUTH.derivative("Cm_de"), rel=0.02)
    rows = list(csv.DictReader(io.StringIO(files["derivatives.csv"].decode())))
    assert {row["derivative"]: float(row["mean"]) for row in rows}["Cm_de"] == mean
    mat = loadmat(tmp_path / "derivatives.mat", simplify_cells=True)
    assert mat["derivatives"]["Cm_de"]["mean"] == mean
    assert np.array_equal(mat["linear_lon"]["A"], run.models["lon"].A)
    assert json.loads(files["campaign.json"])["campaign"]["Cm_de"]["mean"] == mean
    model = load_model(tmp_path / "model.toml")
    assert (model.derivative("Cm_de"), model.parent) == (mean, "b777")
    linear = load_linear_model(tmp_path / "linear-lon.toml").model()
    assert np.allclose(linear.A, run.models["lon"].A, rtol=1e-12)
    judged = json.loads(files["linear-models.json"])
    assert judged["lon"]["bls"]["judged_on"] == [WILD, "2:M6"]
    assert judged["lon"]["ml"]["by_maneuver_pct"]["q"] == compared.axes["lon"].errors["ml"]["q"]
    assert judged["lat"] is None


def test_a_report_that_is_stopped_leaves_nothing(
    compared: LinearModelValidation, tmp_path: Path
) -> None:
    told: list[str] = []

    def step(done: int, total: int, what: str) -> bool:
        told.append(what)
        return done < total and "pages" not in what

    small = exclude_maneuvers(outcome(), [one.maneuver.id for one in outcome().result.results[1:]])
    with pytest.raises(CanceledError):
        write_campaign_report(
            small, tmp_path / "out.pdf", ftr_histories=(), linear=compared, progress=step
        )
    assert told[-1] == "laying out the pages"
    with pytest.raises(CanceledError):
        write_campaign_report(
            small, tmp_path / "out", ftr_histories=(), linear=compared, progress=lambda *_: False
        )
    assert not list(tmp_path.iterdir())


def test_linear_models_are_drawn_with_the_numbers_shown(compared: LinearModelValidation) -> None:
    picture = linear_model_figure(compared.axes["lon"], units="SI")
    figure = Figure(figsize=(7, picture.height))
    picture.draw(figure)
    charts = figure.get_axes()
    assert len(charts) == 4 * 2
    assert {chart.get_gid() for chart in charts} == {f"maneuver:{WILD}", "maneuver:2:M6"}
    measured, *computed = charts[2].get_lines()
    assert measured.get_linestyle() == "-"
    assert [line.get_linestyle() for line in computed] == ["--"] * 3
    assert picture.numbers is not None
    table = picture.numbers()
    assert table.columns[:4] == ("maneuver", "time [s]", "de [deg]", "an [g] measured")
    shown = np.array([float(row[3]) for row in table.rows if row[0] == WILD])
    assert np.array_equal(shown, measured.get_ydata())


def test_the_flights_that_judge_must_be_among_those_of_the_report() -> None:
    for flights, text in (
        ((Path("C"),), "not among the flights"),
        ((Path("A"), Path("B")), "fewer"),
    ):
        with pytest.raises(ValueError, match=text):
            compare_linear_models(outcome(), flights)
