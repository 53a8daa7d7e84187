"""People at the virtual bench who do what the wizard asks, and count the keys they press."""

from pathlib import Path

from calibration.plan import CalibrationPlan
from calibration.wizard import CalibrationWizard, WizardAction, WizardView
from gsapp.virtual.bench import VirtualBench
from tests.calibration.wizard.wizard_kit import Field


class BenchCrew:
    """A crew, a virtual bench, and a wizard."""

    def __init__(self, folder: Path, plan: CalibrationPlan, bench: VirtualBench) -> None:
        self.field = Field(folder, plan)
        self.bench = bench
        self.wizard: CalibrationWizard = self.field.begin().wizard
        self.keys = 0
        self.named: list[tuple[str, str, str]] = []

    @property
    def view(self) -> WizardView:
        return self.wizard.view

    def press(self, kind: str, **details: object) -> WizardView:
        self.keys += 1
        self.wizard.act(WizardAction(kind=kind, **details))  # type: ignore[arg-type]
        return self.view

    def wait(self, seconds: float) -> None:
        for _ in range(max(round(seconds / 0.2), 1)):
            self.wizard.feed(self.bench.step(0.2))
            for fault in self.view.faults:
                told = (fault.kind, fault.channel, fault.swapped_with)
                if told not in self.named:
                    self.named.append(told)

    def set(self, channel: str, angle: float, hold: float = 2.0) -> None:
        self.wait(self.bench.set_angle(channel, angle) + hold)

    def obey(self) -> None:
        """Do the next thing that is asked."""
        view = self.view
        channel = "" if view.instrument is None else view.instrument.channel
        if view.phase == "sign":
            self.set(channel, 15.0)
        elif view.phase == "points":
            assert view.target is not None
            if view.remaining[0].is_turning_point:
                past = view.target + (-4.0 if view.direction == "up" else 4.0)
                self.set(channel, past, hold=0.6)
            self.set(channel, view.target, hold=0.6)
            # Held until the wizard says that it was taken, or something else.
            for _ in range(10):
                if len(self.view.points) > len(view.points):
                    break
                self.wait(0.2)
        elif view.phase == "gyro_turn":
            assert view.target is not None
            self.wait(2.0)
            self.wait(self.bench.rotate(channel, view.target) + 2.0)
        elif view.phase == "accel_position":
            assert view.position is not None
            self.wait(self.bench.move_to_position(view.position) + 4.5)
        elif view.phase == "pressure_zero":
            self.bench.cover()
            self.press("take")
            self.wait(5.5)
        elif view.phase == "pressure_blow":
            self.wait(self.bench.blow() + 1.0)
        else:
            self.wait(0.6)

    def finish(self) -> None:
        looks = 0
        for _ in range(600):
            if self.view.phase == "done":
                return
            key = self.wizard.state.current_key
            self.obey()
            same = self.view.phase == "fit" and self.wizard.state.current_key == key
            looks = looks + 1 if same else 0
            if looks > 10:
                self.press("accept")
        raise AssertionError(self.view)

    def until(self, *phases: str, tries: int = 60) -> WizardView:
        for _ in range(tries):
            if self.view.phase in phases:
                return self.view
            self.obey()
        raise AssertionError(self.view)

    def try_out(self, channel: str) -> None:
        self.wizard.act(WizardAction(kind="open", channel=channel))
        self.wait(0.6)
        self.set(channel, 15.0)
        if not self.named and self.wizard.phase == "sign":
            # Moved, and nothing happens: the key says that it was moved.
            self.press("take")
            self.wait(1.0)
        for angle in (-24.0, -20.0, 24.0):
            if not self.named:
                self.set(channel, angle)
