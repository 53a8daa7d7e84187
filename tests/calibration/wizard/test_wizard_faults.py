"""The wizard names what is wrong with an instrument, on the virtual bench."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from calibration.plan import load_plan
from calibration.wizard import Action, Wizard
from gsapp.dynamics.pilot.bench import BenchFault, VirtualBench

sys.path.insert(0, str(Path(__file__).parent))
from wizard_kit import Field

PLAN = load_plan("b777").only(("surface", "vane"))


class Trial:
    """A person who moves one instrument of the virtual bench, and what the wizard names."""

    def __init__(self, folder: Path, channel: str, bench: VirtualBench) -> None:
        self.channel = channel
        self.bench = bench
        self.wizard: Wizard = Field(folder, PLAN).begin().wizard
        self.wizard.act(Action(kind="open", channel=channel))
        self.named: list[tuple[str, str]] = []

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / 0.2)):
            self.wizard.feed(self.bench.step(0.2))
            for fault in self.wizard.view.faults:
                assert fault.channel == self.channel
                assert fault.sentence in self.wizard.view.sentences
                if (fault.kind, fault.other) not in self.named:
                    self.named.append((fault.kind, fault.other))

    def lead(self, angle: float) -> None:
        """Set the instrument and hold it."""
        self.wait(self.bench.set_angle(self.channel, angle) + 2.0)

    def go_through(self) -> None:
        """Prove the sign, then go to both ends, as far as the wizard lets it."""
        self.wait(0.6)
        self.lead(15.0)
        if not self.named and self.wizard.phase == "sign":
            # Moved, and nothing happens: the key says that it was moved.
            self.wizard.act(Action(kind="take"))
            self.wait(1.0)
        if not self.named:
            assert self.wizard.phase == "points"
            self.lead(-24.0)
            self.lead(-20.0)
            self.lead(24.0)


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("dead", 1), ("dead", 5), ("reversed", 1), ("swapped", 5), ("noisy", 1), ("clipped", 5)],
)
def test_each_fault_is_named_and_nothing_else(tmp_path: Path, kind: str, seed: int) -> None:
    """Moved as asked, a faulty instrument is called what it is, before any point is wasted."""
    channel, other = ("elevator_left", "rudder") if seed == 1 else ("alpha", "beta")
    swapped = other if kind == "swapped" else ""
    fault = BenchFault(channel=channel, kind=kind, other=swapped)  # type: ignore[arg-type]
    trial = Trial(tmp_path, channel, VirtualBench(seed, faults=[fault]))
    trial.go_through()
    assert trial.named == [(kind, swapped)]
    view = trial.wizard.view
    assert view.tone in ("error", "taken")
    assert {"skip", "abort", "open"} <= view.can


def test_a_sound_instrument_has_no_fault(tmp_path: Path) -> None:
    """No false alarm, and the points are taken on the way."""
    trial = Trial(tmp_path, "elevator_left", VirtualBench(1))
    trial.go_through()
    assert trial.named == []
    assert trial.wizard.view.phase == "points"


def test_a_reversed_instrument_is_calibrated_on_the_crews_word(tmp_path: Path) -> None:
    """It asks, and takes yes for an answer: somebody may have turned the potentiometer round."""
    fault = BenchFault(channel="rudder", kind="reversed")
    trial = Trial(tmp_path, "rudder", VirtualBench(2, faults=[fault]))
    trial.wait(0.6)
    trial.lead(15.0)
    assert "other way than expected" in trial.wizard.view.prompt
    trial.wizard.act(Action(kind="confirm_sign", yes=False))
    assert "Move the rudder trailing edge left" in trial.wizard.view.prompt
    assert trial.wizard.view.phase == "sign"
    # On the way back the volts go as they should on the way there: no proof of anything.
    trial.lead(0.0)
    assert trial.wizard.view.phase == "sign"
    trial.lead(15.0)
    trial.wizard.act(Action(kind="confirm_sign", yes=True))
    view = trial.wizard.view
    assert view.phase == "points"
    assert "volts fall with trailing edge left" in view.message


def test_without_any_volts_it_waits_and_says_so(tmp_path: Path) -> None:
    """A channel that the link does not carry: no sign, no point, one sentence."""
    trial = Trial(tmp_path, "rudder", VirtualBench(2))
    block = trial.bench.step(3.0)
    kept = [name for name in block.channels if name != "rudder_volts"]
    trial.wizard.feed(block.select(kept))
    view = trial.wizard.view
    assert view.reading is not None
    assert view.reading.state == "absent"
    assert view.sentences == ("Rudder: no volts come; look at its plug and at the channel map",)
    trial.wizard.act(Action(kind="take"))
    assert trial.wizard.view.tone == "error"
    assert trial.wizard.view.phase == "sign"
