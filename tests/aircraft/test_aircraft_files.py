"""The shipped aircraft is the source's; files with mistakes name all of them."""

from pathlib import Path

import pytest

from gsapp.aircraft import (
    SHIPPED_AIRCRAFT,
    load_aircraft,
    shipped_aircraft,
    write_sensor_values,
)
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError

MINIMAL = """
[geometry]
wing_area = "11.33 ft^2"
span = "8.92 ft"
chord = "1.41 ft"
[mass]
mass = "1.45 slug"
ixx = "5.20 slug ft^2"
iyy = "6.34 slug ft^2"
izz = "6.97 slug ft^2"
ixz = "0.28 slug ft^2"
"""


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "aircraft.toml"
    path.write_text(text)
    return path


def test_the_shipped_aircraft_has_the_values_of_the_source() -> None:
    aircraft = load_aircraft("b777")
    assert shipped_aircraft() == ("b777",)
    # Tables 3.2.1 and 6.2.1 in SI, converted by hand.
    assert aircraft.geometry.wing_area == pytest.approx(11.33 * 0.09290304)
    assert aircraft.mass.mass == pytest.approx(1.45 * 14.59390294, rel=1e-8)
    assert aircraft.mass.iyy == pytest.approx(6.34 * 1.3558179483, rel=1e-8)
    aspect_ratio = aircraft.geometry.span**2 / aircraft.geometry.wing_area
    assert aspect_ratio == pytest.approx(7.02, abs=0.01)
    assert len(aircraft.propulsion.position) == 2


def test_the_suspicious_inertias_of_the_source_are_warned_about() -> None:
    (warning,) = load_aircraft("b777").warnings()
    # (Ixx + Iyy - Izz)/2m is 1.26 ft rms.
    assert "0.38 m" in warning


def test_a_minimal_file_is_enough_and_sensors_sit_at_the_cg(tmp_path: Path) -> None:
    aircraft = load_aircraft(write(tmp_path, MINIMAL))
    assert aircraft.sensors.alpha_vane.position == (0.0, 0.0, 0.0)
    assert aircraft.controls.de.kind == "position"


def test_one_engine_needs_no_list(tmp_path: Path) -> None:
    text = MINIMAL + '[propulsion]\nmax_thrust = "24 lbf"\nposition = ["1 ft", "0 ft", "0 ft"]\n'
    assert load_aircraft(write(tmp_path, text)).propulsion.position == ((0.3048, 0.0, 0.0),)


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    text = (
        MINIMAL.replace('"11.33 ft^2"', '"11.33 ft"')
        .replace("ixx", "ixxx")
        .replace('"8.92 ft"', '"-8.92 ft"')
        .replace('"1.41 ft"', "1.41")
        + '[controls.de]\nkind = "guess"\n[sensors.vane]\nposition = ["1 ft", "0 ft", "0 ft"]\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        load_aircraft(write(tmp_path, text))
    found = "\n".join(str(problem) for problem in caught.value.problems)
    for part in (
        "geometry.wing_area: 'ft' is not a unit of area",
        "geometry.span: it must be greater than zero; measure it",
        "geometry.chord: 1.41 has no unit",
        "mass.ixx: is missing",
        "mass.ixxx: is not a known key; did you mean 'ixx'?",
        "controls.de.kind: input should be 'position', 'servo' or 'command'",
        "sensors.vane: is not a known key; did you mean",
    ):
        assert part in found


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("6.97 slug", "16.97 slug", "izz exceeds the sum"),
        ("0.28 slug", "7.28 slug", "physically impossible"),
        ("1.45 slug", "0 slug", "greater than zero"),
    ],
)
def test_masses_that_no_body_can_have(
    tmp_path: Path, before: str, after: str, message: str
) -> None:
    with pytest.raises(FileProblemsError, match=message):
        load_aircraft(write(tmp_path, MINIMAL.replace(before, after)))


def test_an_unknown_name_proposes_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'b777'"):
        load_aircraft("b77")


def test_values_of_sensors_are_written_and_all_else_is_kept(tmp_path: Path) -> None:
    text = MINIMAL + '# as bought\n[sensors.beta_vane]\nposition = ["1 ft", "0 ft", "-2 in"]\n'
    path = write(tmp_path, text)
    write_sensor_values(
        path,
        {
            "alpha_vane": {"x": 1.25, "bias": 0.01, "upwash": 1.1},
            "beta_vane": {"x": 0.5},
            "accelerometer": {"y": -0.25},
        },
    )
    sensors = load_aircraft(path).sensors
    assert sensors.alpha_vane.position == pytest.approx((1.25, 0.0, 0.0))
    assert sensors.alpha_vane.bias == pytest.approx(0.01, abs=1e-5)
    assert sensors.alpha_vane.upwash == pytest.approx(1.1)
    assert sensors.beta_vane.position == pytest.approx((0.5, 0.0, -2 * 0.0254))
    assert sensors.accelerometer.position == pytest.approx((0.0, -0.25, 0.0))
    assert path.read_text().startswith(MINIMAL + "# as bought\n")


def test_a_shipped_aircraft_is_never_written() -> None:
    before = SHIPPED_AIRCRAFT.find("b777").read_text()
    with pytest.raises(FlightError, match="--aircraft FILE"):
        write_sensor_values(SHIPPED_AIRCRAFT.find("b777"), {"alpha_vane": {"x": 1.0}})
    assert SHIPPED_AIRCRAFT.find("b777").read_text() == before
