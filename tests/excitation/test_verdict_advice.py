"""What is said of an input can be followed; and what is no input gets no verdict."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.test_points.point import TargetInput, ToleranceBand
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from tests.excitation.verdict_kit import FlownInput, wanted_of, watched
from tests.virtual.inputs import fly_input

CALM = {
    "kind": "doublet", "width": 0.58, "balance": 1.0, "bank": 0.0, "speed_off": 0.0,
    "roll_rate": 0.0, "pitch_rate": 0.0, "meddling": (), "hands_off": 5.0, "left_over": 0.0,
    "turbulence": 0.0, "noise": 1.0, "speed": 30.48, "start": (0.0,) * 6, "approach": 4.0,
    "still": 1.2, "attitude": True,
}  # fmt: skip


@lru_cache(maxsize=2)
def _flown(*surfaces: str) -> FlownInput:
    sizes = {"de": 4.0 * DEGREE, "da": 3.0 * DEGREE, "dr": 4.0 * DEGREE}
    chosen = {name: sizes[name] for name in surfaces}
    return fly_input(5000, surfaces=surfaces, amplitudes=chosen, ground=6.0, **CALM)


def _verdicts(flown: FlownInput, measured: Block, wanted: TargetInput) -> tuple[InputVerdict, ...]:
    assert flown.ground is not None
    return watched(flown, flown.ground, measured, wanted=wanted)


def _with(block: Block, name: str, values: np.ndarray | float) -> Block:
    changed = np.array(block.values)
    changed[:, block.channels.index(name)] = values
    return replace(block, values=changed)


@pytest.mark.parametrize(
    ("low", "high", "result", "says"),
    [(1.02, 1.5, "too-small", "10 % larger"), (0.5, 0.98, "too-large", "10 % smaller")],
)
def test_a_size_that_was_wrong_is_to_change(
    low: float, high: float, result: str, says: str
) -> None:
    flown = _flown("de")
    size = _verdicts(flown, flown.measured, wanted_of(flown))[0].amplitudes["de"]
    best = low if result == "too-small" else high
    asked = replace(
        wanted_of(flown),
        amplitudes={"de": ToleranceBand(low=low * size, best=best * size, high=high * size)},
        source="card",
    )
    (verdict,) = _verdicts(flown, flown.measured, asked)
    assert verdict.result == result
    assert says in verdict.advice
    factor = verdict.findings[0].factor
    assert abs(factor - 1.0) > 0.05


def test_one_position_of_the_rate_switch_is_advised_for_both_surfaces() -> None:
    """A little aileron and much rudder: each alone would be told at another rate."""
    flown = _flown("da", "dr")
    asked = wanted_of(flown)
    bands = {
        "da": ToleranceBand(low=5.0 * DEGREE, best=6.0 * DEGREE, high=9.0 * DEGREE),
        "dr": ToleranceBand(low=12.0 * DEGREE, best=15.0 * DEGREE, high=20.0 * DEGREE),
    }
    (verdict,) = _verdicts(flown, flown.measured, replace(asked, amplitudes=bands))
    words = [one.words for one in verdict.findings if one.result == "too-small"]
    assert len(words) == 2
    assert all(one.endswith("high rate") for one in words)


def test_what_moves_the_sticks_in_a_turn_is_no_input() -> None:
    flown = _flown("de")
    wanted = wanted_of(flown)
    leaning = _verdicts(flown, _with(flown.measured, "phi", 20.0 * DEGREE), wanted)
    assert [one.result for one in leaning] == ["not-trimmed"]
    assert not _verdicts(flown, _with(flown.measured, "phi", 40.0 * DEGREE), wanted)
    # Without attitude the turn shows in the rate of yaw: 12 deg/s at 100 ft/s.
    kept = [name for name in flown.measured.channels if name not in ("phi", "theta", "psi")]
    turning = _with(flown.measured, "r", flown.measured["r"] + 12.0 * DEGREE).select(kept)
    assert not _verdicts(flown, turning, wanted)


def test_what_moves_the_sticks_in_the_flare_is_no_input() -> None:
    flown = _flown("de")
    low = _with(flown.measured, "height", float(np.median(flown.ground["height"])) + 5.0)
    assert len(_verdicts(flown, flown.measured, wanted_of(flown))) == 1
    assert not _verdicts(flown, low, wanted_of(flown))
