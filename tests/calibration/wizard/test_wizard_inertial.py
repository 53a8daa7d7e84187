"""Gyros, accelerometers and pressures through the wizard, on the virtual bench."""

from pathlib import Path

import pytest

from calibration.inertial.accelerometers import POSITIONS
from calibration.plan import CalibrationPlan, load_calibration_plan
from gsapp.virtual.bench import BenchFault, VirtualBench
from tests.calibration.wizard.bench_crew import BenchCrew
from tests.calibration.wizard.wizard_kit import Field

PLAN = load_calibration_plan("b777")


def crew_of(folder: Path, channels: list[str], *faults: BenchFault) -> BenchCrew:
    return BenchCrew(folder, PLAN.select_channels(channels), VirtualBench(3, faults=faults))


def test_gyros_go_by_themselves(tmp_path: Path) -> None:
    crew = crew_of(tmp_path, ["r"])
    view = crew.until("gyro_turn")
    assert (view.target, view.amount_goal, view.amount_unit) == (360.0, 360.0, "deg")
    before = crew.until("fit")
    # Rest and turns stand in the journal in full.
    crew.wizard = crew.field.resume().wizard
    assert crew.view.points == before.points
    assert crew.view.remarks == before.remarks
    assert crew.keys == 0
    crew.press("accept")
    assert crew.view.phase == "done"
    certificate = crew.field.store.in_force()["r"]
    zero, scale = crew.bench.gyros.zero[2], crew.bench.gyros.matrix[2, 2]
    assert certificate.volts(0.0) == pytest.approx(zero, abs=0.003)
    assert 1.0 / certificate.coefficients[1] == pytest.approx(scale, rel=0.005)
    assert [round(point.value) for point in certificate.points] == pytest.approx(
        [0, 30, -30], abs=3
    )


def test_a_restless_aircraft_gives_no_zero(tmp_path: Path) -> None:
    crew = crew_of(tmp_path, ["p", "q", "r", "ax", "ay", "an"])
    crew.until("gyro_still")
    for _ in range(4):
        for position in ("x_up", "z_down"):
            crew.wait(crew.bench.move_to_position(position))
    assert crew.view.phase == "gyro_still"
    assert len(crew.view.problems) == 1
    crew.wait(6.0)
    assert crew.view.phase == "gyro_turn"


def test_six_positions_in_any_order(tmp_path: Path) -> None:
    crew = crew_of(tmp_path, ["ax", "ay", "an"])
    crew.until("accel_position")
    for position in POSITIONS[::-1]:
        assert crew.view.phase == "accel_position"
        crew.wait(crew.bench.move_to_position(position) + 4.5)
    assert crew.view.phase == "fit"
    crew.press("repeat", index=5)
    assert crew.view.position == "z_down"
    view = crew.until("done")
    assert view.accepted == ("ax", "ay", "an")
    for index, channel in enumerate(("ax", "ay", "an")):
        certificate = crew.field.store.in_force()[channel]
        truth = crew.bench.accelerometers
        assert certificate.volts(0.0) == pytest.approx(truth.zero[index], abs=0.002)
        sensitivity = 1.0 / certificate.coefficients[1]
        assert sensitivity == pytest.approx(truth.matrix[index, index], rel=0.003)


def test_a_dead_gyro_stays_uncalibrated_beside_the_good_ones(tmp_path: Path) -> None:
    dead = BenchFault(channel="q", kind="dead")
    crew = crew_of(tmp_path, ["p", "q", "r"], dead)
    crew.until("gyro_turn")
    for _ in range(2):
        crew.press("next")
    assert crew.view.instrument is PLAN["q"]
    # Turned, and nothing was seen.
    crew.press("take")
    assert "q gyro" in crew.view.message
    for _ in range(2):
        crew.press("next")
    view = crew.view
    assert view.phase == "fit"
    crew.wait(5.0)
    assert crew.view.phase == "fit"
    crew.press("accept")
    assert crew.view.phase == "done"
    assert crew.view.accepted == ("p", "r")
    assert set(crew.field.store.in_force()) == {"p", "r"}
    assert "did not respond" in crew.field.store.skipped_channels()["q"].reason
    crew.press("undo")
    assert crew.view.phase == "fit"
    assert crew.field.store.in_force() == {}
    assert crew.field.store.skipped_channels() == {}


def test_pressures_take_one_key_and_the_fields_air(tmp_path: Path) -> None:
    crew = crew_of(tmp_path, ["dynamic_pressure", "static_pressure"])
    crew.until("pressure_blow")
    view = crew.until("fit")
    assert "barometer" in view.problems[0]
    air = crew.bench.weather
    crew.press("enter", pressure=air.pressure / 10.0, temperature=air.temperature)
    assert "barometer" in crew.view.message
    crew.press("enter", pressure=air.pressure, temperature=air.temperature)
    view = crew.until("done")
    assert crew.keys == 3
    store = crew.field.store
    volts = crew.bench.pressures["static_pressure"].zero
    volts += crew.bench.pressures["static_pressure"].slope * air.pressure
    static = store.in_force()["static_pressure"]
    assert float(static.evaluate(volts)) == pytest.approx(air.pressure, abs=30.0)
    assert static.temperature == pytest.approx(air.temperature)
    dynamic = store.in_force()["dynamic_pressure"]
    zero = crew.bench.pressures["dynamic_pressure"].zero
    assert float(dynamic.evaluate(zero)) == pytest.approx(0.0, abs=3.0)


def test_a_forgotten_cover_is_asked_for_again(tmp_path: Path) -> None:
    """The key alone gives no zero in wind; pressed again it does, and what it is worth is said."""
    crew = crew_of(tmp_path, ["dynamic_pressure", "static_pressure"])
    crew.until("pressure_zero")
    crew.press("take")
    crew.wait(4.5)
    assert "check the cover" not in crew.view.prompt
    crew.wait(6.0)
    assert "check the cover" in crew.view.prompt
    crew.wait(20.0)
    assert crew.view.phase == "pressure_zero"
    crew.press("take")
    while crew.view.phase == "pressure_zero":
        crew.wait(1.0)
        assert crew.bench.time < 120.0
    crew.wizard = crew.field.resume().wizard
    view = crew.until("fit")
    assert any("wind" in doubt for doubt in view.problems)
    crew.wait(6.0)
    assert crew.view.phase == "fit", "such a zero is not accepted by itself"
    crew.press("accept")
    certificate = crew.field.store.in_force()["dynamic_pressure"]
    assert float(certificate.uncertainty(certificate.volts(0.0))) > 5.0
    # Covered, the same key is enough.
    covered = crew_of(tmp_path / "covered", ["dynamic_pressure", "static_pressure"])
    covered.until("pressure_zero")
    covered.bench.cover()
    covered.press("take")
    covered.wait(5.5)
    assert covered.view.phase == "pressure_blow"


def test_a_plan_of_pressures_without_anything_to_start_from_is_refused(tmp_path: Path) -> None:
    plan = PLAN.select_channels(["dynamic_pressure"])
    bare = CalibrationPlan(name=plan.name, instruments=plan.instruments)
    with pytest.raises(ValueError, match="slope"):
        Field(tmp_path, bare).begin()
