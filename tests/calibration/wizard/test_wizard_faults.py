"""The wizard names what is wrong with an instrument, on the virtual bench."""

from pathlib import Path

import pytest

from calibration.plan import load_calibration_plan
from calibration.wizard import WizardAction
from gsapp.virtual.bench import BenchFault, VirtualBench
from tests.calibration.wizard.bench_crew import BenchCrew

PLAN = load_calibration_plan("b777").select_kinds(("surface", "vane"))


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("dead", 1), ("reversed", 1), ("swapped", 5), ("noisy", 1), ("clipped", 5)],
)
def test_each_fault_is_named_and_nothing_else(tmp_path: Path, kind: str, seed: int) -> None:
    channel, other = ("elevator_left", "rudder") if seed == 1 else ("alpha", "beta")
    swapped = other if kind == "swapped" else ""
    fault = BenchFault(channel=channel, kind=kind, other=swapped)  # type: ignore[arg-type]
    crew = BenchCrew(tmp_path, PLAN, VirtualBench(seed, faults=[fault]))
    crew.try_out(channel)
    assert crew.named == [(kind, channel, swapped)]
    view = crew.view
    assert view.faults[0].sentence in view.problems
    assert view.tone in ("error", "taken")
    assert {"skip", "abort", "open"} <= view.available_actions


def test_a_sound_instrument_has_no_fault(tmp_path: Path) -> None:
    crew = BenchCrew(tmp_path, PLAN, VirtualBench(1))
    crew.try_out("elevator_left")
    assert crew.named == []
    assert crew.view.phase == "points"


def test_a_reversed_instrument_is_calibrated_on_the_crews_word(tmp_path: Path) -> None:
    fault = BenchFault(channel="rudder", kind="reversed")
    crew = BenchCrew(tmp_path, PLAN, VirtualBench(2, faults=[fault]))
    crew.wizard.act(WizardAction(kind="open", channel="rudder"))
    crew.wait(0.6)
    crew.set("rudder", 15.0)
    assert "opposite direction" in crew.view.prompt
    crew.wizard.act(WizardAction(kind="confirm_sign", yes=False))
    assert "trailing edge left" in crew.view.prompt
    assert crew.view.phase == "sign"
    # On the way back the volts go as they should on the way there: no proof of anything.
    crew.set("rudder", 0.0)
    assert crew.view.phase == "sign"
    crew.set("rudder", 15.0)
    crew.wizard.act(WizardAction(kind="confirm_sign", yes=True))
    view = crew.view
    assert view.phase == "points"
    assert "volts fall" in view.message


def test_without_any_volts_it_waits_and_says_so(tmp_path: Path) -> None:
    crew = BenchCrew(tmp_path, PLAN, VirtualBench(2))
    crew.wizard.act(WizardAction(kind="open", channel="rudder"))
    block = crew.bench.step(3.0)
    kept = [name for name in block.channels if name != "rudder_volts"]
    crew.wizard.feed(block.select(kept))
    view = crew.view
    assert view.reading.state == "absent"
    assert ["no voltage" in one for one in view.problems] == [True]
    crew.wizard.act(WizardAction(kind="take"))
    assert crew.view.tone == "error"
    assert crew.view.phase == "sign"
