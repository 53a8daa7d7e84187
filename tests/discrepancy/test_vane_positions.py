"""Proves that a search tells a boom from a late vane, and names both vanes by one effect.

The shipped model flies six maneuvers of four seconds; the vanes stand further ahead than the
aircraft file says. An accelerometer that stands to one side comes before what looks like it.
"""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import DiscrepancyResult
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.terms import effect_guidance
from gsapp.identification.filter_error.motion_linearization import create_maneuver_record
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver

AHEAD, BESIDE = 2.0, 0.2
"""m."""


def _shown(one: Maneuver, place: str, distance: float, names: tuple[str, ...]) -> FloatArray:
    """Return what instruments show of a motion, shape (n, n_names).

    `place`: the instrument and the axis along which it stands `distance` (m) from where the
    aircraft file says.
    """
    model = TRUTH.with_effect(f"sensor.{place}", {place[-1]: distance})
    motion = create_maneuver_record(one).motion
    outputs = OutputModel(FlightModel(AIRCRAFT, model), names)
    return np.column_stack(outputs.values(tuple(motion.states.T), tuple(motion.inputs.T)))


def _displaced(seed: int, place: str, distance: float, names: tuple[str, ...]) -> Maneuver:
    kind = ("lon", "lat")[seed % 2]
    flown = maneuver(seed, kind, duration=4.0)
    exact = maneuver(seed, kind, duration=4.0, noise=0.0)
    values = flown.block.values.copy()
    columns = [flown.block.channels.index(name) for name in names]
    values[:, columns] += _shown(exact, place, distance, names) - _shown(exact, place, 0.0, names)
    block = Block(channels=flown.block.channels, times=flown.block.times, values=values)
    return replace(flown, block=block)


@pytest.fixture(scope="module")
def answer() -> DiscrepancyResult:
    flown = [_displaced(seed, "boom.x", AHEAD, ("alpha", "beta")) for seed in range(1, 7)]
    return Investigation(flown, AIRCRAFT, TRUTH).run(DiscrepancySettings(held_out=("2", "5")))


def test_the_boom_is_named_and_closes_the_gap(answer: DiscrepancyResult) -> None:
    assert answer.verdict == "effects-found"
    assert [one.effect for one in answer.effects] == ["sensor.boom.x"]
    value, std = answer.effects[0].parameters["x"]
    assert abs(value - AHEAD) < 3.5 * std
    assert std < 0.1 * AHEAD
    assert answer.gap.closed == pytest.approx(1.0, abs=0.1)


def test_an_accelerometer_to_one_side_is_no_lift_of_the_ailerons() -> None:
    names = ("ax", "ay", "an")
    flown = [_displaced(seed, "accelerometer.y", BESIDE, names) for seed in range(1, 7)]
    found = Investigation(flown, AIRCRAFT, TRUTH).run(
        DiscrepancySettings(held_out=("2", "5"), most_effects=1)
    )
    assert [one.effect for one in found.effects] == ["sensor.accelerometer.y"]
    value, std = found.effects[0].parameters["y"]
    assert abs(value - BESIDE) < 3.5 * std
    assert std < 0.1 * BESIDE


def test_what_looks_like_a_position_comes_with_the_maneuver_that_parts_them() -> None:
    for vane in ("alpha", "beta"):
        guidance = effect_guidance(f"sensor.{vane}_vane.x")
        assert {f"sensor.{vane}.delay", f"sensor.{vane}.lag"} < set(guidance.mistaken_for)
        assert "turn" in guidance.separated_by
        assert "upwash" in guidance.separated_by
