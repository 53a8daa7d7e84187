"""A certificate on one page, and a folder of them at a glance."""

import json
import re
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from calibration import (
    Certificate,
    certificate_paths,
    load_certificate,
    load_certificates,
    write_certificate,
)
from calibration.certificate_store import (
    CertificateStore,
    evaluate_certificate,
    load_certificate_overview,
)
from calibration.certificate_toml import SHIPPED_CERTIFICATES_FOLDER
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.points import DIRECTION_TEXT
from gsapp.cli.calibration_commands import calibrate as calibrate_command
from gsapp.cli.calibration_commands import certificates as certificates_command
from gsapp.foundation import GroundStationError, UnknownNameError
from gsapp.report.certificate_report import (
    certificate_document,
    draw_certificate,
    write_certificate_report,
)
from gsapp.report.palette import PRINT_PALETTE


def moved(former: Certificate, by: float, stamp: datetime) -> Certificate:
    points = [replace(point, value=point.value + by) for point in former.points]
    return create_certificate(
        fit_calibration(points, travel=(-35.0, 35.0)), points, channel_id=former.channel,
        unit=former.unit, who="B. Jones", stamp=stamp, excitation_voltage=5.0, ratiometric=True,
        temperature=289.15, instrument=former.instrument,
    )  # fmt: skip


@pytest.fixture(scope="module")
def rudder() -> Certificate:
    return load_certificates("b777")["rudder"]


@pytest.fixture(scope="module")
def again(rudder: Certificate) -> Certificate:
    return moved(rudder, 0.9, rudder.stamp + timedelta(days=30))


def test_the_page_is_one_page_of_paper(rudder: Certificate, again: Certificate, tmp_path: Path):
    file = write_certificate(replace(again, notes="words " * 40), tmp_path / "rudder.toml")
    standing = evaluate_certificate(replace(again, notes="words " * 40), file, rudder)
    page = write_certificate_report(standing, tmp_path / "rudder.pdf").read_bytes()
    assert page.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", page)) == 1


def test_the_page_for_a_browser_needs_nothing_else_and_says_who_when_and_how_good(
    rudder: Certificate, again: Certificate, tmp_path: Path
) -> None:
    file = write_certificate(again, tmp_path / "rudder.toml")
    path = write_certificate_report(
        evaluate_certificate(again, file, rudder), tmp_path / "rudder.html"
    )
    page = path.read_text(encoding="utf-8")
    assert not re.findall(r"(?:src|href)=\"(?!data:)", page)
    assert page.count("data:image/png;base64,") == 1
    for text in (
        "Rudder surface", "B. Jones", "2003-06-13 08:35:00", "61 degF", "5.000 V",
        "Positive trailing edge left", "Since 2003-05-14", "more than the points explain",
        f"{100 * again.quality.coverage:.0f} %",
        f"{again.quality.uncertainty:.2f} deg", f"{again.quality.hysteresis:.2f} ±",
    ):  # fmt: skip
        assert text in page, text
    for point in again.points:
        assert f"{point.volts:.4f}" in page


def test_what_is_drawn_are_the_points_the_band_and_the_drift(
    rudder: Certificate, again: Certificate, tmp_path: Path
) -> None:
    figure = Figure(figsize=(7.1, 2.6))
    draw_certificate(figure, evaluate_certificate(again, tmp_path / "rudder.toml", rudder))
    curve, residuals = figure.axes
    lines = {line.get_label(): line for line in residuals.lines}
    for direction in ("up", "down"):
        taken = sorted(
            (p.volts, p.value - np.polyval(again.coefficients[::-1], p.volts))
            for p in again.points
            if p.direction == direction
        )
        drawn = lines[DIRECTION_TEXT[direction]]
        np.testing.assert_allclose(np.column_stack(drawn.get_data()), taken, atol=1e-9)
    (band,) = residuals.collections
    highest = band.get_paths()[0].vertices[:, 1].max()
    assert highest == pytest.approx(again.quality.uncertainty)
    former = np.asarray(lines["certificate of 2003-05-14"].get_ydata())
    assert np.median(former) == pytest.approx(-0.9, abs=0.1)
    drawn = np.vstack([line.get_xydata() for line in curve.lines if line.get_marker() != "None"])
    assert len(drawn) == len(again.points)


def test_an_instrument_without_branches_or_quality_has_its_page_too(tmp_path: Path) -> None:
    bare = replace(
        load_certificates("b777")["temperature"], points=(), quality=None, temperature=None,
        excitation_voltage=None,
    )  # fmt: skip
    document = certificate_document(evaluate_certificate(bare, tmp_path / "absent.toml"))
    assert [section.title for section in document.sections] == ["Quality"]
    facts = dict(document.facts)
    assert "temperature not noted" in facts["Taken"]
    assert "±" not in document.sections[0].parts[0].text


def test_a_report_of_another_ending_is_refused(rudder: Certificate, tmp_path: Path) -> None:
    with pytest.raises(GroundStationError, match=r"\.html or \.pdf"):
        write_certificate_report(
            evaluate_certificate(rudder, tmp_path / "x.toml"), tmp_path / "rudder.doc"
        )


def test_calibrate_writes_the_page_beside_the_certificate(
    rudder: Certificate, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "\n".join(f"{p.value},{p.volts},{p.direction}" for p in rudder.points)
    (tmp_path / "points.csv").write_text(f"angle [deg],volts [V],direction\n{rows}\n")
    former = write_certificate(rudder, tmp_path / "former.toml")
    calibrate_command(
        points=tmp_path / "points.csv", channel="rudder", out=tmp_path / "new.toml", who="C. Poe",
        former=[former], report=tmp_path / "new.html",
    )  # fmt: skip
    capsys.readouterr()
    page = (tmp_path / "new.html").read_text(encoding="utf-8")
    assert "C. Poe" in page
    assert "Dashed" in page


def test_a_store_is_listed_with_age_quality_drift_and_what_was_skipped(
    rudder: Certificate, again: Certificate, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = CertificateStore(tmp_path, "B777 no. 1")
    now = datetime.now().replace(microsecond=0)  # noqa: DTZ005
    store.put_in_force(rudder)
    store.put_in_force(moved(rudder, 0.9, now - timedelta(hours=5)))
    store.put_in_force(load_certificates("b777")["alpha"])
    store.mark_uncalibrated("beta", "vane broken", "B. Jones", now)
    folder = store.in_force_folder
    certificates_command(
        folder=str(folder), report=tmp_path / "pages", page="html", json=tmp_path / "list.json"
    )
    screen = capsys.readouterr().out
    assert re.search(r"rudder .* 1 of 1 (today|yesterday) .* 30 .*\+0\.9 !", screen)
    assert "vane broken" in screen
    told = json.loads((tmp_path / "list.json").read_text())
    alpha, listed = told["certificates"]
    assert (alpha["channel"], alpha["former"]) == ("alpha", None)
    assert (alpha["status"]["state"], listed["status"]["state"]) == ("caution", "good")
    assert told["status"]["words"] == "1 uncalibrated"
    assert listed["age"] == pytest.approx(5 * 3600, abs=120)
    assert listed["former"]["zero"] == pytest.approx(np.deg2rad(0.9), abs=1e-3)
    assert listed["former"]["significant"]
    assert listed["quality"]["hysteresis"] == pytest.approx(
        np.deg2rad(load_certificate_overview(folder).in_force[1].quality.hysteresis)
    )
    assert [one["channel"] for one in told["uncalibrated"]] == ["beta"]
    assert sorted(path.name for path in (tmp_path / "pages").iterdir()) == [
        "alpha.html", "rudder.html",
    ]  # fmt: skip


def test_a_flight_folder_and_a_set_are_listed_too(tmp_path: Path) -> None:
    kept = tmp_path / "flight" / "calibration"
    kept.mkdir(parents=True)
    (tmp_path / "flight" / "flight.toml").write_text('name = "a"\n')
    for path in certificate_paths("b777")[:2]:
        (kept / path.name).write_bytes(path.read_bytes())
    found = load_certificate_overview(tmp_path / "flight", former="b777")
    assert [one.certificate.channel for one in found.in_force] == ["aileron_left", "aileron_right"]
    assert not any(one.drift.significant for one in found.in_force)
    with pytest.raises(UnknownNameError):
        load_certificate_overview(tmp_path)


@pytest.mark.parametrize("name", ["rudder", "elevator_left", "aileron_right"])
def test_points_have_the_color_of_their_channel(name: str) -> None:
    file = SHIPPED_CERTIFICATES_FOLDER / "b777" / f"{name}.toml"
    figure = Figure()
    draw_certificate(figure, evaluate_certificate(load_certificate(file), file))
    points = [
        line for chart in figure.axes for line in chart.lines if line.get_marker() in ("^", "v")
    ]
    assert {line.get_color() for line in points} == {PRINT_PALETTE.channel(name)}
    assert {line.get_marker() for line in points} == {"^", "v"}
