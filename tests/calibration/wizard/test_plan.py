"""Calibration plans: the shipped one, and all mistakes of a file told at once."""

from pathlib import Path

import pytest

from calibration.plan import load_calibration_plan
from gsapp.aircraft import load_aircraft
from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.quantities import channel
from gsapp.quantities.constants import DEGREE

GOOD = """\
name = "test"

[[instruments]]
channel = "rudder"
title = "Rudder"
kind = "surface"
unit = "deg"
settings = ["-0.2 rad", "0 deg", "10 deg"]
check_settings = ["-5 deg", "0 deg", "5 deg"]
travel = ["-30 deg", "30 deg"]
positive = "trailing edge left"
negative = "trailing edge right"
"""


def test_the_shipped_plan_fits_the_shipped_aircraft() -> None:
    """Seven by hand with five settings each, travel as in the aircraft file, then the others."""
    plan = load_calibration_plan("b777")
    hand = [one for one in plan.instruments if one.is_angle_sensor]
    assert [len(one.settings) for one in hand] == [5] * 7
    assert plan.channels[7:] == (
        *("p", "q", "r", "ax", "ay", "an"),
        *("dynamic_pressure", "static_pressure"),
    )
    controls = load_aircraft("b777").controls
    groups = {"elevator": "de", "aileron": "da", "rudder": "dr"}
    for one in hand:
        # Each setting can be passed and come back to: that is how slop is seen at the ends.
        assert one.travel[0] < one.settings[0] < one.settings[-1] < one.travel[1]
        name = groups.get(one.channel.partition("_")[0])
        if name is not None:
            travel = getattr(controls, name).travel
            assert travel is not None
            assert one.travel == pytest.approx([limit / DEGREE for limit in travel])


@pytest.mark.parametrize("name", ["elevator_left", "aileron_left", "aileron_right", "rudder"])
def test_positive_means_what_the_vocabulary_says(name: str) -> None:
    assert channel(name).description == f"Positive {load_calibration_plan('b777')[name].positive}"


def test_settings_are_told_as_they_are_read_off(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(GOOD, encoding="utf-8")
    rudder = load_calibration_plan(path)["rudder"]
    assert rudder.settings == pytest.approx((-11.4591559026, 0.0, 10.0))
    assert rudder.format_setting(-12.0) == "12 deg trailing edge right"
    assert rudder.format_setting(0.0) == "0 deg"
    assert rudder.positive_motion_text == "Move the rudder trailing edge left"
    with pytest.raises(UnknownNameError, match="'beta'; it has rudder"):
        load_calibration_plan(path)["beta"]


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    """Each with its key path, what is wrong, and what to write instead."""
    path = tmp_path / "plan.toml"
    path.write_text(
        'nominal = "nowhere"\n'
        + GOOD.replace('"10 deg"]', '"-10 deg"]', 1)
        + """\

[[instruments]]
channel = "rudder"
kind = "surface"
unit = "kg"
settings = ["0 deg"]
check_settings = ["0 deg"]

[[instruments]]
channel = "ruder"
kind = "vane"
unit = "deg"
settings = ["-10 deg", "0 deg", "10 deg"]
check_settings = ["-10 deg", "0 deg", "10 deg"]
positive = "up"
negative = "down"
partner = "elevator"

[[instruments]]
channel = "ax"
kind = "gyro"
unit = "g"

[[instruments]]
channel = "ay"
kind = "accelerometer"
unit = "g"
""",
        encoding="utf-8",
    )
    with pytest.raises(FileProblemsError) as raised:
        load_calibration_plan(path)
    told = [(problem.where, problem.what, problem.remedy) for problem in raised.value.problems]
    assert all(remedy for _, _, remedy in told)
    wheres = {where for where, _, _ in told}
    assert wheres == {
        "instruments[0].settings",
        "instruments[1].channel",
        "instruments[1].unit",
        "instruments[1].settings",
        "instruments[1].check_settings",
        "instruments[1].positive",
        "instruments[1].negative",
        "instruments[2].channel",
        "instruments[2].partner",
        "instruments[3].kind",
        "instruments",
        "nominal",
    }
    remedies = {where: remedy for where, _, remedy in told}
    assert "rudder" in remedies["instruments[2].channel"]


def test_an_unknown_plan_names_those_that_there_are() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'b777'"):
        load_calibration_plan("b77")


def test_the_example_in_the_documentation_loads(tmp_path: Path) -> None:
    """The section of the page on files holds a complete plan."""
    page = Path(__file__).parents[3] / "docs" / "reference" / "files.md"
    example = page.read_text(encoding="utf-8").split("```toml calibration-plan\n")[1]
    path = tmp_path / "plan.toml"
    path.write_text(example.split("```")[0], encoding="utf-8")
    plan = load_calibration_plan(path)
    assert plan.channels == ("rudder", "r")
    assert plan["rudder"].setting_error == pytest.approx(0.15)
    assert plan["r"].turn == pytest.approx(360.0)
