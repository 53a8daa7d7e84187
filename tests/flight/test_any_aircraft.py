"""Records of aircraft that are built and measured otherwise than the one that ships."""

from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight import load_flight
from gsapp.flight.maneuvers import detect_maneuvers, run_detector
from gsapp.identification.maneuver import cut_maneuver, open_flight
from gsapp.quantities.constants import DEGREE
from tests.flight.maneuver_kit import Input, changed, make_flight

AIRCRAFT = """name = "stranger"
[geometry]
wing_area = "1.05 m^2"
span = "2.7 m"
chord = "0.43 m"
[mass]
mass = "21 kg"
ixx = "7 kg m^2"
iyy = "8.6 kg m^2"
izz = "9.5 kg m^2"
ixz = "0.4 kg m^2"
"""
INPUTS = (Input(at=20.0, surface="de"), Input(at=34.0, surface="dr", size=10.0))
HALVES = {
    "elevators": {
        "elevator_left": {"de": 1.0}, "elevator_right": {"de": 1.0},
        "aileron_left": {"da": 1.0}, "aileron_right": {"da": 1.0}, "rudder": {"dr": 1.0},
    },
    "V-tail": {
        "ruddervator_left": {"de": 1.0, "dr": 1.0}, "ruddervator_right": {"de": 1.0, "dr": -1.0},
        "da": {"da": 1.0},
    },
    "elevons": {
        "elevon_left": {"de": 1.0, "da": 1.0}, "elevon_right": {"de": 1.0, "da": -1.0},
        "dr": {"dr": 1.0},
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def aircraft(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("aircraft") / "aircraft.toml"
    path.write_text(AIRCRAFT)
    return path


@pytest.fixture(scope="module")
def flown():
    return make_flight(INPUTS, seconds=48.0, ground=0.0, without=("throttle",))


@pytest.mark.parametrize("tail", HALVES)
def test_surfaces_measured_one_by_one_move_the_combined_ones(
    flown, aircraft: Path, tail, tmp_path: Path
) -> None:
    """From a table: what is detected, and the deflections that estimates take."""
    block = flown.block
    columns = {"time [s]": block.times}
    for name in ("p", "q", "r"):
        columns[f"{name} [rad/s]"] = block[name]
    columns |= {"V [m/s]": block["V"], "an [m/s^2]": block["an"]}
    for part, shares in HALVES[tail].items():
        columns[f"{part} [rad]"] = sum(share * block[name] for name, share in shares.items())
    path = tmp_path / "flight.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",",
               header=",".join(columns), comments="")  # fmt: skip
    flight = load_flight(path)
    for name in ("de", "da", "dr"):
        np.testing.assert_allclose(flight.block[name], block[name], atol=1e-12)
    assert tail == "V-tail" or flight.sources["de"].kind == "derived"
    opened = open_flight(path, aircraft=str(aircraft))
    first, second = detect_maneuvers(opened.flight, opened.aircraft)
    assert (first.inputs, second.inputs) == (("de",), ("dr",))
    maneuver = cut_maneuver(
        flight, opened.aircraft, first.t_start, first.t_end, id="1", inputs=("de",), kind="doublet"
    )
    assert np.ptp(maneuver.samples("de")) > 9.0 * DEGREE


def test_steps_of_a_coarse_converter_are_no_moves(flown, aircraft: Path) -> None:
    """Half a degree and two degrees a second: the trim wanders by one step."""
    step = {"de": 0.5, "da": 0.5, "dr": 0.5, "p": 2.0, "q": 2.0, "r": 2.0, "alpha": 0.5}
    wander = 0.3 * np.sin(2.5 * flown.block.times)
    coarse = changed(
        flown,
        **{
            name: np.round(flown.block[name] / DEGREE / size + wander) * size * DEGREE
            for name, size in step.items()
        },
    )
    found = detect_maneuvers(coarse, load_aircraft(aircraft))
    assert [one.inputs for one in found] == [("de",), ("dr",)]
    assert all(one.t_end - one.t_start > 4.5 for one in found)
    noise = run_detector(coarse, load_aircraft(aircraft)).noise
    assert noise.step["de"] == pytest.approx(0.5 * DEGREE)
    assert noise.least_move("de", 7.0) == pytest.approx(0.75 * DEGREE)


def test_ten_samples_a_second_are_enough_for_a_doublet(aircraft: Path) -> None:
    slow = make_flight(INPUTS, seconds=48.0, ground=0.0, rate=10.0, without=("throttle",))
    found = detect_maneuvers(slow, load_aircraft(aircraft))
    assert [one.inputs for one in found] == [("de",), ("dr",)]
    assert all(one.grade != "D" for one in found)
