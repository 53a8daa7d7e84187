"""Proves that a search tells a boom from a late vane, and names both vanes by one effect.

The shipped model flies six maneuvers of four seconds; the vanes stand further ahead than the
aircraft file says.
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
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver

AHEAD = 2.0
"""m."""


def _shown(one: Maneuver, ahead: float, names: tuple[str, ...]) -> FloatArray:
    """Return what the vanes show of a motion, shape (n, 2); `ahead`, m, of the aircraft file."""
    model = TRUTH.with_effect("sensor.boom.x", {"x": ahead})
    state = [one.samples(name) for name in ("V", *names, "p", "q", "r", "phi", "theta", "psi")]
    inputs = [np.zeros(len(state[0]))] * 6 + [np.full(len(state[0]), size) for size in (1.2, 20.0)]
    found = OutputModel(FlightModel(AIRCRAFT, model), names).values(tuple(state), tuple(inputs))
    return np.column_stack(found)


def _with_boom(seed: int) -> Maneuver:
    kind, names = ("lon", "lat")[seed % 2], ("alpha", "beta")
    flown = maneuver(seed, kind, duration=4.0)
    exact = maneuver(seed, kind, duration=4.0, noise=0.0)
    values = flown.block.values.copy()
    columns = [flown.block.channels.index(name) for name in names]
    values[:, columns] += _shown(exact, AHEAD, names) - _shown(exact, 0.0, names)
    block = Block(channels=flown.block.channels, times=flown.block.times, values=values)
    return replace(flown, block=block)


@pytest.fixture(scope="module")
def answer() -> DiscrepancyResult:
    flown = [_with_boom(seed) for seed in range(1, 7)]
    return Investigation(flown, AIRCRAFT, TRUTH).run(DiscrepancySettings(held_out=("2", "5")))


def test_the_boom_is_named_and_closes_the_gap(answer: DiscrepancyResult) -> None:
    assert answer.verdict == "effects-found"
    assert [one.effect for one in answer.effects] == ["sensor.boom.x"]
    value, std = answer.effects[0].parameters["x"]
    assert abs(value - AHEAD) < 3.5 * std
    assert std < 0.1 * AHEAD
    assert answer.gap.closed == pytest.approx(1.0, abs=0.1)


def test_what_looks_like_a_position_comes_with_the_maneuver_that_parts_them() -> None:
    for vane in ("alpha", "beta"):
        guidance = effect_guidance(f"sensor.{vane}_vane.x")
        assert {f"sensor.{vane}.delay", f"sensor.{vane}.lag"} < set(guidance.mistaken_for)
        assert "turn" in guidance.separated_by
        assert "upwash" in guidance.separated_by
