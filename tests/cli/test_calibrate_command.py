"""``gsapp calibrate``: from a file of points to a certificate; every slip told with its line."""

import json
from pathlib import Path

import numpy as np
import pytest

from calibration import load_certificate
from calibration.points_file import load_points
from gsapp.cli.calibration_commands import calibrate
from gsapp.foundation import FileProblemsError, GroundStationError
from gsapp.quantities.constants import DEGREE
from tests.calibration.potentiometer_kit import Sweep, quick_sweep

HEADING = "angle [deg],volts [V],direction"


def write(path: Path, taken: Sweep, *, shift: float = 0.0) -> Path:
    rows = [
        f"{point.value:g},{point.volts + shift:.5f},{point.direction}" for point in taken.points()
    ]
    path.write_text("\n".join([HEADING, *rows]) + "\n")
    return path


@pytest.fixture
def points(tmp_path: Path) -> Path:
    return write(tmp_path / "points.csv", quick_sweep(7, "elevator_left"))


def test_points_become_a_certificate(
    points: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "day" / "elevator_left.toml"
    calibrate(
        points=points, channel="elevator_left", out=out, excitation=5.0, travel="-25:25",
        who="B. Jones", temperature=16.0,
    )  # fmt: skip
    made = load_certificate(out)
    assert (made.channel, made.unit, made.who) == ("elevator_left", "deg", "B. Jones")
    assert made.temperature == pytest.approx(289.15)
    assert (made.excitation_voltage, made.ratiometric) == (5.0, True)
    assert made.quality.coverage == pytest.approx(0.8)
    taken = quick_sweep(7, "elevator_left")
    sides = np.where(np.array(taken.directions) == "up", 1.0, -1.0)
    shafts = taken.true - 0.5 * sides * taken.potentiometer.play
    np.testing.assert_allclose(made.evaluate(taken.volts) / DEGREE, shafts, atol=0.25)
    shown = capsys.readouterr().out
    for text in ("hysteresis, width", "80 % of the travel", "straight line", str(out)):
        assert text in shown
    assert "note:" not in shown


def test_programs_get_si_units(
    points: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "c.toml"
    calibrate(points=points, channel="elevator_left", out=out, degree=1, json=Path("-"))
    found = json.loads(capsys.readouterr().out)
    made = load_certificate(out)
    assert found["degree"] == 1
    np.testing.assert_allclose(found["coefficients"], made.si_coefficients)
    assert found["quality"]["hysteresis"] == pytest.approx(made.hysteresis * DEGREE)
    assert found["quality"]["covered"] == pytest.approx([-20.0 * DEGREE, 20.0 * DEGREE])
    assert found["quality"]["coverage"] is None
    assert found["range"] == list(made.range)
    assert len(found["residuals"]) == 10
    assert ["--who" in one for one in found["remarks"]] == [True]


def test_drift_against_former_certificates_is_told(
    points: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    former = tmp_path / "former.toml"
    calibrate(points=points, channel="elevator_left", out=former, who="crew")
    moved = write(tmp_path / "moved.csv", quick_sweep(7, "elevator_left"), shift=0.05)
    capsys.readouterr()
    out, result = tmp_path / "new.toml", tmp_path / "new.json"
    calibrate(
        points=moved, channel="elevator_left", out=out, who="crew", former=(former, former),
        json=result,
    )  # fmt: skip
    shown = capsys.readouterr().out
    assert shown.count("former.toml: since") == 2
    assert "points explain" in shown
    found = json.loads(result.read_text())["former"]
    slope = load_certificate(former).end_slopes[0]
    assert found[0]["significant"] is True
    assert found[0]["zero"] == pytest.approx(-0.05 * slope, rel=0.1)


def test_the_supply_may_be_measured_at_each_point(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    supplies = (5.0, 4.9, 4.8, 4.7)
    rows = [
        f"{20 * v - 50:g},{1e3 * v * supply / 4.85:.6f},{supply:g}"
        for v, supply in zip((1.0, 2.0, 3.0, 4.0), supplies, strict=True)
    ]
    lines = ["\ufeffrudder [deg],volts [mV],excitation [V]", "", *rows]
    path.write_text("\n".join(lines), encoding="utf-8")
    found = load_points(path, "rudder")
    assert found.excitation == pytest.approx(4.85)
    assert [point.volts for point in found.points] == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert {point.direction for point in found.points} == {"single"}
    assert found.lines == (3, 4, 5, 6)


def test_directions_are_read_as_pages_and_certificates_write_them(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    words = ("increasing", "Decreasing", "up", "down", "")
    rows = [f"{index},{index}.5,{direction}" for index, direction in enumerate(words)]
    path.write_text("\n".join([HEADING, *rows]))
    directions = [point.direction for point in load_points(path, "rudder").points]
    assert directions == ["up", "down", "up", "down", "single"]


@pytest.mark.parametrize(
    ("text", "where", "what", "remedy"),
    [
        ("", "line 1", "is empty", HEADING),
        ("angle [deg],volts [V],dirction\n", "line 1", "'dirction'", "direction"),
        ("angle,volts [V]\n", "line 1", "no unit", "angle [deg]"),
        ("angle [deg],volts [psi]\n", "line 1", "psi", "V"),
        ("angle [deg],angle [deg],volts [V]\n", "line 1", "two columns", "keep one"),
        ("angle [deg],direction\n", "line 1", "volts [V]", "heading"),
        (f"{HEADING}\n-20,1.5,up\n", "line 2", "1 points", "at least two"),
        (f"{HEADING}\n-20,1.5,up\n\n20,x,up\n", "line 4", "'x'", "decimal point"),
        (f"{HEADING}\n-20,1.5,up\n20,nan,up\n", "line 3", "'nan'", "decimal point"),
        (f"{HEADING}\n-20,1.5,up\n20,3500,up\n", "line 3", "3500 V", "unit"),
        (f"{HEADING}\n-20,1.5,up\n200,3.5,up\n", "line 3", "200 deg", "unit"),
        (f"{HEADING}\n-20,1.5,up\n20,3.5,left\n", "line 3", "'left'", "increasing, decreasing"),
        (f"{HEADING}\n-20,1.5,up\n20,3,5,up\n", "line 3", "4 cells", "decimal point"),
        (f'{HEADING}\n-20,"1.5,up\n', "line 2", "not CSV", "quotation"),
        (f"{HEADING}\n-20,1.5,\xfc\n".encode("latin-1"), "byte 40", "UTF-8", "UTF-8"),
    ],
)
def test_every_slip_has_its_line_and_a_remedy(
    tmp_path: Path, text: str | bytes, where: str, what: str, remedy: str
) -> None:
    path, out = tmp_path / "p.csv", tmp_path / "c.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(FileProblemsError) as caught:
        calibrate(points=path, channel="elevator_left", out=out)
    problem = caught.value.problems[0]
    assert problem.where == where
    assert what in problem.what
    assert remedy in problem.remedy
    assert not out.exists()


def test_all_slips_are_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    path.write_text(f"{HEADING}\na,1,up\n1,b,up\n1,1,c\n")
    with pytest.raises(FileProblemsError) as caught:
        load_points(path, "rudder")
    assert [problem.where for problem in caught.value.problems] == ["line 2", "line 3", "line 4"]


@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"channel": "elevator"}, GroundStationError, "elevator"),
        ({"points": Path("absent.csv")}, FileProblemsError, "cannot be read"),
        ({"travel": "25"}, GroundStationError, "LOW:HIGH"),
        ({"travel": "25:-25"}, GroundStationError, "LOW:HIGH"),
        ({"excitation": 5000.0}, GroundStationError, "in volts"),
        ({"former": (Path("absent.toml"),)}, FileProblemsError, "absent.toml"),
        ({"out": Path(__file__) / "c.toml"}, GroundStationError, "cannot be written"),
    ],
)
def test_a_wrong_call_says_why(
    points: Path, tmp_path: Path, more: dict[str, object], error: type[Exception], words: str
) -> None:
    call: dict[str, object] = {
        "points": points, "channel": "elevator_left", "out": tmp_path / "c.toml",
    }  # fmt: skip
    with pytest.raises(error, match=words):
        calibrate(**(call | more))  # type: ignore[arg-type]
    assert not (tmp_path / "c.toml").exists()


def test_remarks_reach_the_screen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "p.csv"
    path.write_text("angle [deg],volts [V]\n-5,2.2\n0,2.5\n5,2.8\n")
    calibrate(points=path, channel="rudder", out=tmp_path / "c.toml", travel="-30:30")
    shown = capsys.readouterr().out
    for text in ("hysteresis was not measured", "only 17 % of the travel", "add --who"):
        assert text in shown
