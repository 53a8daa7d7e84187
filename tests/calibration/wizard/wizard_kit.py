"""For the wizard's tests: potentiometers, a hand that moves them, and an operator who obeys."""

import datetime as dt
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from calibration.certificate_store import CertificateStore
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.wizard import CalibrationWizard, WizardAction, WizardView
from gsapp.quantities import Block

RATE = 50.0
STEP = 5.0 / 4096
FALLING = ("elevator_right", "beta")
"""Mounted so that their volts fall, as in the nominal certificates."""


class Clock:
    def __init__(self) -> None:
        self.time = dt.datetime(2026, 5, 12, 8, 0)  # noqa: DTZ001 - a field's local time

    def __call__(self) -> dt.datetime:
        self.time += dt.timedelta(seconds=1)
        return self.time


class Bench:
    """Instruments with slope, zero, curvature, slop and noise, sampled through 12 bits."""

    def __init__(self, plan: CalibrationPlan, seed: int = 1) -> None:
        self.plan = plan
        self.random = np.random.default_rng(seed)
        self.time = 0.0
        self.angle = dict.fromkeys(plan.channels, 0.0)
        self.shown = dict(self.angle)
        self.slope = {
            name: (-1.0 if name in FALLING else 1.0) * float(self.random.uniform(0.036, 0.044))
            for name in plan.channels
        }
        self.zero = {name: float(self.random.uniform(2.3, 2.7)) for name in plan.channels}
        self.curve = {name: float(self.random.uniform(-4e-5, 4e-5)) for name in plan.channels}
        self.slop = {name: float(self.random.uniform(0.3, 0.8)) for name in plan.channels}
        self.noise = dict.fromkeys(plan.channels, 0.001)
        self.supply = 5.0
        self.dead: set[str] = set()
        self.swapped: dict[str, str] = {}

    def volts(self, channel: str) -> float:
        source = self.swapped.get(channel, channel)
        x = self.shown[source]
        v = self.zero[channel] + self.slope[channel] * x + self.curve[channel] * x * x
        return v * self.supply / 5.0

    def step(self, channel: str, angles: np.ndarray) -> Block:
        """Lead an instrument along angles, one for each sample, and return what was sampled."""
        names = self.plan.channels
        values = np.empty((angles.size, len(names) + 1))
        for row, angle in enumerate(angles):
            self.angle[channel] = float(angle)
            half = 0.5 * self.slop[channel]
            self.shown[channel] = float(np.clip(self.shown[channel], angle - half, angle + half))
            for column, name in enumerate(names):
                values[row, column] = 1.3 if name in self.dead else self.volts(name)
        values[:, -1] = self.supply
        noise = [*(self.noise[name] for name in names), 0.001]
        values += self.random.normal(0.0, 1.0, values.shape) * noise
        values = np.clip(np.round(values / STEP), 0, 4095) * STEP
        times = self.time + (np.arange(angles.size) + 1) / RATE
        self.time = float(times[-1])
        channels = (*(f"{name}_volts" for name in names), "excitation")
        return Block(channels=channels, times=times, values=values)

    def move(self, channel: str, to: float, speed: float = 50.0) -> Iterator[Block]:
        begin = self.angle[channel]
        count = max(int(abs(to - begin) / speed * RATE), 5)
        yield from self._pieces(channel, np.linspace(begin, to, count + 1)[1:])

    def hold(self, channel: str, seconds: float) -> Iterator[Block]:
        count = int(seconds * RATE)
        phase = self.random.uniform(0.0, 6.0)
        tremor = 0.02 * np.sin(phase + 2 * np.pi * 1.5 * np.arange(count) / RATE)
        around = self.angle[channel]
        yield from self._pieces(channel, around + tremor)
        self.angle[channel] = around

    def _pieces(self, channel: str, angles: np.ndarray) -> Iterator[Block]:
        for at in range(0, angles.size, 5):
            yield self.step(channel, angles[at : at + 5])


def surface(channel: str, title: str, **changes: object) -> InstrumentPlan:
    content: dict[str, object] = {
        "channel": channel,
        "title": title,
        "kind": "surface",
        "unit": "deg",
        "settings": (-20.0, 0.0, 20.0),
        "check_settings": (-10.0, 0.0, 10.0),
        "travel": (-25.0, 25.0),
        "positive": "trailing edge down",
        "negative": "trailing edge up",
        "ratiometric": True,
    }
    return InstrumentPlan(**{**content, **changes})  # type: ignore[arg-type]


SMALL = CalibrationPlan(
    name="small",
    instruments=(
        surface("elevator_left", "Left elevator", partner="elevator_right"),
        surface("elevator_right", "Right elevator", partner="elevator_left"),
    ),
)
"""Two surfaces, three settings up and down each."""


class Operator:
    """Does what the wizard asks, and counts the keys."""

    def __init__(self, wizard: CalibrationWizard, bench: Bench, *, by_key: bool = False) -> None:
        self.wizard = wizard
        self.bench = bench
        self.by_key = by_key
        self.keys = 0
        self.views: list[WizardView] = []

    def press(self, kind: str, **details: object) -> WizardView:
        self.keys += 1
        self.wizard.act(WizardAction(kind=kind, **details))  # type: ignore[arg-type]
        return self.wizard.view

    def see(
        self, blocks: Iterator[Block], until: Callable[[WizardView], bool] | None = None
    ) -> bool:
        for block in blocks:
            self.wizard.feed(block)
            self.views.append(self.wizard.view)
            if until is not None and until(self.views[-1]):
                return True
        return False

    def wait(self, seconds: float, until: Callable[[WizardView], bool] | None = None) -> bool:
        channel = self.wizard.state.current_key or self.bench.plan.channels[0]
        return self.see(self.bench.hold(channel, seconds), until)

    def obey(self) -> None:
        """Do the next thing that is asked."""
        view = self.wizard.view
        if view.phase in ("begin", "fit"):
            assert self.wait(6.0, lambda now: now.phase != view.phase), view
            return
        channel = view.instrument.channel
        if view.phase == "sign":
            self.see(self.bench.move(channel, 15.0))
            assert self.wait(4.0, lambda now: now.phase != "sign"), self.wizard.view
            return
        assert view.target is not None
        if view.remaining[0].is_turning_point:
            past = view.target + (-3.0 if view.direction == "up" else 3.0)
            self.see(self.bench.move(channel, past))
            self.wait(0.3)
        elif abs(self.bench.angle[channel] - view.target) < 5.0:
            # It stands there already: away from it, so that it is come to once more.
            self.see(
                self.bench.move(channel, view.target + (-8.0 if view.direction == "up" else 8.0))
            )
        self.see(self.bench.move(channel, view.target))
        if self.by_key:
            self.wait(2.0, lambda now: now.tone == "steady")
            self.press("take")
        taken = len(view.points)
        assert self.by_key or self.wait(4.0, lambda now: len(now.points) > taken), self.wizard.view

    def until(self, done: Callable[[WizardView], bool]) -> WizardView:
        for _ in range(300):
            if done(self.wizard.view):
                return self.wizard.view
            self.obey()
        raise AssertionError(self.wizard.view)


class Field:
    """A folder, a clock, a bench: where wizards come and go."""

    def __init__(self, folder: Path, plan: CalibrationPlan = SMALL, seed: int = 1) -> None:
        self.plan = plan
        self.clock = Clock()
        self.bench = Bench(plan, seed)
        self.journal = folder / "wizard.jsonl"
        self.folder = folder / "certificates"

    @property
    def store(self) -> CertificateStore:
        return CertificateStore(self.folder, "small")

    def begin(self, *, by_key: bool = False, **options: object) -> Operator:
        wizard = CalibrationWizard(
            self.plan, self.store, self.journal, who="crew", now=self.clock, **options
        )  # type: ignore[arg-type]
        return Operator(wizard, self.bench, by_key=by_key)

    def resume(self) -> Operator:
        return Operator(
            CalibrationWizard.resume(self.journal, self.store, now=self.clock), self.bench
        )
