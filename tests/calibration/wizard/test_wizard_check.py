"""The check of three points between flights: quick, by itself, and not deceived."""

import datetime as dt
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibration import Certificate
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.plan import InstrumentPlan, load_calibration_plan
from calibration.points import CalibrationPoint, Direction
from gsapp.virtual.bench import Potentiometer, VirtualBench
from gsapp.virtual.settings import VIRTUAL
from tests.calibration.wizard.bench_crew import BenchCrew
from tests.calibration.wizard.wizard_kit import SMALL, Field, Operator

SUPPLY = 4.9
MORNING = dt.datetime(2026, 5, 12, 7, 0)  # noqa: DTZ001 - a field's local time


def certified(
    instrument: InstrumentPlan, truth: Potentiometer, random: np.random.Generator
) -> Certificate:
    points = []
    ways: tuple[tuple[Direction, float], ...] = (("up", -0.5), ("down", 0.5))
    for way, side in ways:
        for value in instrument.settings:
            shaft = value + random.normal(0.0, VIRTUAL.angle_setting_std) + side * truth.play
            volts = float(truth.volts(shaft, SUPPLY))
            points.append(CalibrationPoint(volts=volts, value=value, direction=way))
    made = fit_calibration(points, travel=instrument.travel, setting_error=instrument.setting_error)
    return create_certificate(
        made, points, channel_id=instrument.channel, unit="deg", who="crew", stamp=MORNING,
        excitation_voltage=SUPPLY, ratiometric=True,
    )  # fmt: skip


def test_a_whole_aircraft_is_checked_in_a_minute(tmp_path: Path) -> None:
    """Seven instruments between two flights, hands included: a minute, and no key.

    (One certificate in a hundred is doubted by chance: those are counted by the bench, over many
    aircraft. In this one there is none.)
    """
    plan = load_calibration_plan("b777").select_kinds(("surface", "vane"))
    bench = VirtualBench(8)
    crew = BenchCrew(tmp_path, plan, bench)
    random = np.random.default_rng(8)
    for name in plan.channels:
        truth = bench.potentiometers[name]
        crew.field.store.put_in_force(certified(plan[name], truth, random))
    crew.wizard = crew.field.begin(mode="check").wizard
    crew.finish()
    assert all(one.passed for one in crew.view.accepted_checks.values())
    assert tuple(crew.view.accepted_checks) == plan.channels
    assert "All certificates valid" in crew.view.prompt
    assert crew.keys == 0
    assert bench.time < 60.0


def checking(folder: Path) -> Operator:
    field = Field(folder)
    field.begin().until(lambda now: now.phase == "done")
    crew = field.begin(mode="check")
    view = crew.until(lambda now: now.phase == "points")
    assert (view.target, view.direction) == (-10.0, "single")
    return crew


def test_the_check_names_the_surface_and_takes_it_from_either_side(tmp_path: Path) -> None:
    crew = checking(tmp_path)
    assert crew.wizard.view.spoken == "Left elevator: 10 up"
    crew.see(crew.bench.move("elevator_left", 5.0))
    for setting, way in ((-10.0, "down"), (0.0, "up"), (10.0, "up")):
        crew.see(crew.bench.move("elevator_left", setting))
        before = len(crew.wizard.view.points)
        assert crew.wait(1.0, lambda now, before=before: len(now.points) > before)
        assert crew.wizard.view.points[-1].direction == way
    # The play between the two ways is no shift.
    check = crew.wizard.view.check_result
    assert check.passed
    assert check.zero == pytest.approx(0.0, abs=0.1)


def test_a_hand_that_looks_for_its_mark_has_time(tmp_path: Path) -> None:
    crew = checking(tmp_path)
    crew.see(crew.bench.move("elevator_left", 5.0))
    crew.see(crew.bench.move("elevator_left", -8.0))
    assert not crew.wait(0.9, lambda now: now.points != ())
    crew.see(crew.bench.move("elevator_left", -10.0, speed=5.0))
    assert crew.wait(0.9, lambda now: now.points != ())


def test_a_certificate_of_one_way_is_checked_that_way(tmp_path: Path) -> None:
    field = Field(tmp_path)
    crew = field.begin()
    crew.until(lambda now: len(now.points) == 3)
    for _ in SMALL.instruments[0].settings:
        crew.press("next")
    view = crew.until(lambda now: now.accepted != ())
    crew = field.begin(mode="check")
    view = crew.until(lambda now: now.phase == "points")
    assert [(one.value, one.direction) for one in view.remaining] == [
        (-10.0, "up"), (0.0, "up"), (10.0, "up"),
    ]  # fmt: skip
    crew.see(crew.bench.move("elevator_left", -14.0))
    crew.wait(2.0)
    assert "Past it" in crew.wizard.view.prompt
    # A program that is started anew asks the same.
    assert field.resume().wizard.view.remaining == view.remaining


def test_the_check_takes_three_points_and_tells_a_shift(tmp_path: Path) -> None:
    """Before the second flight: what holds passes without a key, a moved horn is found and told."""
    field = Field(tmp_path)
    field.begin().until(lambda now: now.phase == "done")
    stamps = {name: one.stamp for name, one in field.store.in_force().items()}
    field.bench.zero["elevator_right"] += 0.06 * np.sign(field.bench.slope["elevator_right"])
    crew = field.begin(mode="check")
    start = field.bench.time
    view = crew.until(lambda now: now.phase == "fit" and now.accepted != ())
    assert not crew.wait(4.0, lambda now: now.phase != "fit")
    view = crew.wizard.view
    assert view.accepted == ("elevator_left",)
    assert view.instrument is SMALL.instruments[1]
    assert not view.check_result.passed
    shift = -0.06 / abs(field.bench.slope["elevator_right"])
    assert view.check_result.zero == pytest.approx(shift, abs=0.3)
    assert view.residuals == pytest.approx([shift] * 3, abs=0.5)
    assert field.bench.time - start < 35.0
    assert crew.keys == 0
    crew.press("accept")
    assert crew.wizard.view.phase == "done"
    assert {name: one.stamp for name, one in field.store.in_force().items()} == stamps
    assert len(field.store.checks("elevator_left")) == 1
    assert {name: one.passed for name, one in crew.wizard.view.accepted_checks.items()} == {
        "elevator_left": True,
        "elevator_right": False,
    }
    kept = field.store.last_check("elevator_right")
    assert (kept.result, kept.who) == (crew.wizard.view.accepted_checks["elevator_right"], "crew")
    # Taken back, it counts no more, also for a program that is started anew; then once again.
    crew.press("undo")
    assert field.store.last_check("elevator_right") is None
    crew = field.resume()
    crew.press("accept")
    assert field.store.last_check("elevator_right") is not None
    # It says nothing of a certificate that was made since.
    field.store.put_in_force(replace(field.store.in_force()["elevator_right"], stamp=field.clock()))
    assert field.store.last_check("elevator_right") is None


def test_a_pause_beside_the_setting_is_no_point_of_a_check(tmp_path: Path) -> None:
    """The certificate tells that it rests elsewhere; a key takes it all the same.

    Taken for the setting, such a rest is a shift of the zero that never was.
    """
    field = Field(tmp_path)
    field.begin().until(lambda now: now.phase == "done")
    crew = field.begin(mode="check")
    view = crew.until(lambda now: now.phase == "points")
    assert view.target == -10.0
    for beside, text in ((-14.0, "at about 14 deg"), (-6.0, "at about 6 deg")):
        crew.see(field.bench.move("elevator_left", beside))
        crew.wait(4.0)
        assert crew.wizard.view.points == ()
        assert text in crew.wizard.view.prompt
    crew.see(field.bench.move("elevator_left", -10.0))
    assert crew.wait(4.0, lambda now: len(now.points) == 1)
    crew.press("repeat", index=0)
    crew.see(field.bench.move("elevator_left", -14.0))
    crew.wait(2.0)
    assert len(crew.press("take").points) == 1
