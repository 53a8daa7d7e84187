"""A flight that lost its nose: dead instruments are taken as not measured, and bounds say so."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from virtual_maneuvers import Virtual, fly

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.flight import Flight
from gsapp.flight.maneuvers.dead import AIRSPEED, dead_instruments
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.identification.stand_ins import campaign_stand_ins
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE

AIRCRAFT = load_aircraft("b777")
MODEL = load_model("b777")


def dead_nose(one: Virtual) -> Block:
    """Return a maneuver as broken wires record it: vanes at their ends, no dynamic pressure."""
    block = one.maneuver.block
    random = np.random.default_rng(1)
    values = np.array(block.values)
    for name, end in (("alpha", -30.0 * DEGREE), ("beta", 30.0 * DEGREE), ("V", 0.0)):
        column = block.channels.index(name)
        noise = 0.02 * DEGREE if name != "V" else 0.0
        values[:, column] = end + noise * random.standard_normal(len(block))
    return Block(channels=block.channels, times=block.times, values=values)


def cut(block: Block, inputs: tuple[str, ...] = ("da", "dr")) -> Maneuver:
    flight = Flight(name="B", path=Path("B"), block=block, sources={})
    start, stop = float(block.times[0]), float(block.times[-1])
    return cut_maneuver(flight, AIRCRAFT, start, stop, id="1", inputs=inputs)


def test_dead_instruments_are_left_out_and_told() -> None:
    """A whole nose, or nothing: a sound maneuver keeps every channel, short clipping too."""
    one = fly(2, "lat", model=MODEL)
    sound = cut(one.maneuver.block)
    assert set(one.maneuver.block.channels) <= set(sound.block.channels)
    assert sound.remarks == ()
    lost = cut(dead_nose(one))
    assert not {"alpha", "beta", *AIRSPEED} & set(lost.block.channels)
    assert {"p", "q", "r", "ay", "da", "dr"} <= set(lost.block.channels)
    assert lost.remarks == (
        "alpha, beta and airspeed were dead, at the end of the range, beyond it or the same "
        "throughout: taken as not measured",
    )
    half = np.where(np.arange(100) < 80, 30.0 * DEGREE, 0.0)
    assert not dead_instruments(
        lambda name: half if name == "beta" else np.full(100, np.nan), AIRCRAFT
    )


def test_a_blocked_pitot_is_no_airspeed() -> None:
    """One dynamic pressure to the last bit: every coefficient would go with its inverse."""
    block = fly(2, "lat", model=MODEL).maneuver.block
    kept = [name for name in block.channels if name not in AIRSPEED]
    blocked = Block(
        channels=(*kept, "dynamic_pressure"),
        times=block.times,
        values=np.column_stack((block.select(kept).values, np.full(len(block), 400.0))),
    )
    found = cut(blocked)
    assert not set(AIRSPEED) & set(found.block.channels)
    assert found.remarks[0].startswith("airspeed was dead")


def test_means_of_the_others_stand_in_and_the_bounds_hold_their_error() -> None:
    """Roll and yaw of flights without a nose: truth within two bounds as often as it should be."""
    sound = [
        replace(fly(seed, "lat", model=MODEL).maneuver, id=str(seed), flight="A")
        for seed in (1, 2, 3)
    ]
    known = campaign_stand_ins(sound)
    speeds = [float(one.samples("V")[:100].mean()) for one in sound]
    assert known["V"].value == pytest.approx(np.mean(speeds), rel=0.01)
    assert set(known) == {"V", "alpha"}
    inside, wider = [], []
    for seed in range(10, 16):
        lost = replace(cut(dead_nose(fly(seed, "lat", model=MODEL))), id=f"B{seed}")
        result = run_campaign([*sound, lost], CampaignSettings())
        estimate = result.results[-1].estimate
        assert estimate is not None
        for name, found in estimate.derivatives.items():
            if found.value is None or not found.std or name.endswith("_0"):
                continue
            inside.append(abs(found.value - MODEL.derivative(name)) <= 2.0 * found.std)
            wider.append(found.std > 1.5 * (found.cramer_rao or 0.0))
        assert any("error in the airspeed that stands in" in text for text in estimate.warnings)
    assert len(inside) > 20
    assert np.mean(inside) >= 0.85
    assert np.mean(wider) > 0.5


def test_without_others_the_aircraft_file_suggests_them() -> None:
    """Cruise speed and the middle of the linear range, as uncertain as such a guess is."""
    lost = cut(dead_nose(fly(2, "lat", model=MODEL)))
    known = campaign_stand_ins([lost])
    low, high = AIRCRAFT.limits.alpha_linear
    assert known["alpha"].value == pytest.approx(0.5 * (low + high))
    assert known["V"].value == pytest.approx(100 * 0.3048, rel=0.01)
    assert known["V"].std == pytest.approx(0.1 * known["V"].value)
    assert campaign_stand_ins([]) == {}
