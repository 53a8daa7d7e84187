"""Gyros, accelerometers and pressures through the wizard, on the virtual bench."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from calibration.inertial import POSITIONS
from calibration.plan import CalibrationPlan, load_plan
from calibration.wizard import Action, Wizard, WizardView
from gsapp.dynamics.pilot.bench import BenchFault, VirtualBench

sys.path.insert(0, str(Path(__file__).parent))
from wizard_kit import Field

PLAN = load_plan("b777")


class Trial:
    """A person at the virtual bench who obeys."""

    def __init__(
        self, folder: Path, channels: list[str], *, faults: tuple[BenchFault, ...] = ()
    ) -> None:
        self.field = Field(folder, PLAN.of(channels))
        self.bench = VirtualBench(3, faults=faults)
        self.wizard: Wizard = self.field.begin().wizard
        self.keys = 0

    @property
    def view(self) -> WizardView:
        return self.wizard.view

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(max(round(seconds / 0.5), 1)):
            self.wizard.feed(self.bench.step(0.5))

    def press(self, kind: str, **details: object) -> None:
        """Press a key."""
        self.keys += 1
        self.wizard.act(Action(kind=kind, **details))  # type: ignore[arg-type]

    def obey(self) -> None:
        """Do the next thing that is asked."""
        view = self.view
        if view.phase == "gyro_turn":
            assert view.instrument is not None
            assert view.target is not None
            self.wait(2.0)
            self.wait(self.bench.turn(view.instrument.channel, view.target) + 2.0)
        elif view.phase == "accel_position":
            assert view.position is not None
            self.wait(self.bench.lie(view.position) + 4.5)
        elif view.phase == "pressure_zero":
            self.bench.cover()
            self.press("take")
            self.wait(4.5)
        elif view.phase == "pressure_blow":
            self.wait(self.bench.blow() + 1.0)
        else:
            self.wait(1.0)

    def until(self, *phases: str) -> WizardView:
        """Go on obeying until one of these pages comes."""
        for _ in range(60):
            if self.view.phase in phases:
                return self.view
            self.obey()
        raise AssertionError(self.view)


def test_gyros_go_by_themselves(tmp_path: Path) -> None:
    """A still period, a turn there and back: the certificate holds zero and scale of the truth."""
    trial = Trial(tmp_path, ["r"])
    view = trial.until("gyro_turn")
    assert (view.target, view.amount_goal, view.amount_unit) == (360.0, 360.0, "deg")
    before = trial.until("fit")
    # Rest and turns stand in the journal in full.
    trial.wizard = trial.field.resume().wizard
    assert trial.view.points == before.points
    assert trial.view.remarks == before.remarks
    assert trial.keys == 0
    trial.press("accept")
    assert trial.view.phase == "done"
    certificate = trial.field.store.in_force()["r"]
    zero, scale = trial.bench.gyros.zero[2], trial.bench.gyros.matrix[2, 2]
    assert certificate.volts(0.0) == pytest.approx(zero, abs=0.003)
    assert 1.0 / certificate.coefficients[1] == pytest.approx(scale, rel=0.005)
    assert [round(point.value) for point in certificate.points] == pytest.approx(
        [0, 30, -30], abs=3
    )


def test_a_restless_aircraft_gives_no_zero(tmp_path: Path) -> None:
    """While it is carried about nothing is taken; it is said after a while why not."""
    trial = Trial(tmp_path, ["p", "q", "r", "ax", "ay", "an"])
    trial.until("gyro_still")
    for _ in range(4):
        for position in ("x_up", "z_down"):
            trial.wait(trial.bench.lie(position))
    assert trial.view.phase == "gyro_still"
    assert trial.view.sentences[0].startswith("it does not come to rest: ")
    trial.wait(6.0)
    assert trial.view.phase == "gyro_turn"


def test_six_positions_in_any_order(tmp_path: Path) -> None:
    """Positions are known by the volts; the three certificates come out as the bench was drawn."""
    trial = Trial(tmp_path, ["ax", "ay", "an"])
    trial.until("accel_position")
    for position in POSITIONS[::-1]:
        assert trial.view.phase == "accel_position"
        trial.wait(trial.bench.lie(position) + 4.5)
    assert trial.view.phase == "fit"
    trial.press("repeat", index=5)
    assert trial.view.position == "z_down"
    view = trial.until("done")
    assert view.accepted == ("ax", "ay", "an")
    for index, channel in enumerate(("ax", "ay", "an")):
        certificate = trial.field.store.in_force()[channel]
        truth = trial.bench.accelerometers
        assert certificate.volts(0.0) == pytest.approx(truth.zero[index], abs=0.002)
        sensitivity = 1.0 / certificate.coefficients[1]
        assert sensitivity == pytest.approx(truth.matrix[index, index], rel=0.003)


def test_a_dead_gyro_stays_uncalibrated_beside_the_good_ones(tmp_path: Path) -> None:
    """What can be used is certified; what cannot is named, and waits for the crew's word."""
    dead = BenchFault(channel="q", kind="dead")
    trial = Trial(tmp_path, ["p", "q", "r"], faults=(dead,))
    trial.until("gyro_turn")
    for _ in range(2):
        trial.press("next")
    assert trial.view.instrument is PLAN["q"]
    # Turned, and nothing was seen.
    trial.press("take")
    assert "The q gyro did not answer to a turn" in trial.view.message
    for _ in range(2):
        trial.press("next")
    view = trial.view
    assert view.phase == "fit"
    trial.wait(5.0)
    assert trial.view.phase == "fit"
    trial.press("accept")
    assert trial.view.phase == "done"
    assert trial.view.accepted == ("p", "r")
    assert set(trial.field.store.in_force()) == {"p", "r"}
    assert "did not answer" in trial.field.store.skipped()["q"].reason
    trial.press("undo")
    assert trial.view.phase == "fit"
    assert trial.field.store.in_force() == {}
    assert trial.field.store.skipped() == {}


def test_pressures_take_one_key_and_the_fields_air(tmp_path: Path) -> None:
    """Covered by a key, blown green by itself; the barometer moves the static pressure."""
    trial = Trial(tmp_path, ["dynamic_pressure", "static_pressure"])
    trial.until("pressure_blow")
    view = trial.until("fit")
    assert "barometer" in view.sentences[0]
    air = trial.bench.weather
    trial.press("enter", pressure=air.pressure / 10.0, temperature=air.temperature)
    assert "not the pressure at a field" in trial.view.message
    trial.press("enter", pressure=air.pressure, temperature=air.temperature)
    view = trial.until("done")
    assert trial.keys == 3
    store = trial.field.store
    volts = trial.bench.pressures["static_pressure"].zero
    volts += trial.bench.pressures["static_pressure"].slope * air.pressure
    static = store.in_force()["static_pressure"]
    assert float(static.evaluate(volts)) == pytest.approx(air.pressure, abs=30.0)
    assert static.temperature == pytest.approx(air.temperature)
    dynamic = store.in_force()["dynamic_pressure"]
    zero = trial.bench.pressures["dynamic_pressure"].zero
    assert float(dynamic.evaluate(zero)) == pytest.approx(0.0, abs=3.0)


def test_a_plan_of_pressures_without_anything_to_start_from_is_refused(tmp_path: Path) -> None:
    """Their slopes are not measured at a field."""
    plan = PLAN.of(["dynamic_pressure"])
    bare = CalibrationPlan(name=plan.name, instruments=plan.instruments)
    with pytest.raises(ValueError, match="has no certificate whose slope could be kept"):
        Field(tmp_path, bare).begin()
