"""Flight plans: the shipped ones hold what a flight of the crew held; mistakes are named."""

from pathlib import Path

import numpy as np
import pytest

from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.virtual.flight_plan import (
    INPUT_SHAPES,
    FlightPlan,
    PilotLimits,
    PlannedManeuver,
    load_flight_plan,
)
from gsapp.virtual.sticks import StickInput


def test_the_default_plan_is_a_flight_of_the_crew() -> None:
    plan = load_flight_plan("default")
    assert plan.engines.running == 80.0
    throttles = {run_up.throttle for run_up in plan.engines.run_ups}
    assert {0.0, 0.5, 1.0} <= throttles
    assert 1 <= len(plan.range_check.pulses) <= 2
    assert 9 <= len(plan.maneuvers) <= 13
    flown = {maneuver.inputs for maneuver in plan.maneuvers}
    assert {("de",), ("da",), ("dr",), ("da", "dr")} <= flown
    assert plan.pattern.leg == 10.0


def test_every_mistake_in_a_plan_is_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(
        'name = "x"\n[pattern]\nheight = "260 kg"\nhight = 3\n'
        '[[maneuvers]]\ninputs = ["da", "dr"]\nstick = [0.3]\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        load_flight_plan(path)
    text = str(caught.value)
    assert "pattern.height" in text
    assert "hight" in text
    assert "'height'" in text
    assert "maneuvers[0]" in text
    assert "2 inputs and 1 sizes" in text


def test_an_unknown_plan_names_the_shipped_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"default.*short"):
        load_flight_plan("defualt")


def _input(maneuver: PlannedManeuver, seed: int) -> StickInput:
    return StickInput(maneuver, FlightPlan().human, np.random.default_rng(seed))


def test_inputs_vary_as_a_hand_does_and_repeat_with_the_seed() -> None:
    maneuver = PlannedManeuver.model_validate({"inputs": ["de"], "stick": [0.3], "step": "0.4 s"})
    one, again, other = _input(maneuver, 1), _input(maneuver, 1), _input(maneuver, 2)
    times = np.arange(0.0, 2.0, 0.01)
    sticks = [[stick.at(time)["de"] for time in times] for stick in (one, again, other)]
    assert sticks[0] == sticks[1]
    assert sticks[0] != sticks[2]
    assert max(sticks[0]) > 0.15
    assert min(sticks[0]) < -0.15
    assert abs(sticks[0][-1]) < 0.06, "the stick comes back, nearly"
    assert one.duration != other.duration


def test_a_perfect_hand_flies_the_shape_exactly() -> None:
    perfect = PilotLimits(size_error=0.0, timing_error=0.0, residual=0.0)
    maneuver = PlannedManeuver.model_validate(
        {"inputs": ["dr"], "shape": "3-2-1-1", "stick": [0.2], "step": "0.3 s"}
    )
    stick = StickInput(maneuver, perfect, np.random.default_rng(0))
    middles = [stick.at(0.3 * number + 0.15)["dr"] for number in range(8)]
    assert middles == pytest.approx([0.2 * unit for unit in INPUT_SHAPES["3-2-1-1"]] + [0.0])
    assert stick.duration == pytest.approx(2.1)
