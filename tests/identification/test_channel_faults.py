"""Dead, stuck and reversed channels, surfaces that nobody saw: alike for every method."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.flight import Flight
from gsapp.flight.maneuvers.dead_instruments import AIRSPEED, find_dead_instruments
from gsapp.foundation import FlightError
from gsapp.identification import equation_error, ftr
from gsapp.identification.axes import Axis
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.channel_faults import unmeasured_surfaces
from gsapp.identification.estimate_corrections import campaign_assumed_constants
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.identification.maximum_likelihood import MLSettings
from gsapp.identification.maximum_likelihood import estimate as ml_estimate
from gsapp.identification.results import Estimate
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from tests.identification.virtual_maneuvers import Virtual, edited, fly

AIRCRAFT = load_aircraft("b777")
MODEL = load_model("b777")


def dead_nose(one: Virtual) -> Block:
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
    one = fly(2, "lat", model=MODEL)
    sound = cut(one.maneuver.block)
    assert set(one.maneuver.block.channels) <= set(sound.block.channels)
    assert sound.remarks == ()
    lost = cut(dead_nose(one))
    assert not {"alpha", "beta", *AIRSPEED} & set(lost.block.channels)
    assert {"p", "q", "r", "ay", "da", "dr"} <= set(lost.block.channels)
    assert ["alpha, beta and airspeed" in one for one in lost.remarks] == [True]
    half = np.where(np.arange(100) < 80, 30.0 * DEGREE, 0.0)
    assert not find_dead_instruments(
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
    assert found.remarks[0].startswith("airspeed was faulty")


@pytest.mark.long
def test_means_of_the_others_stand_in_and_the_bounds_hold_their_error() -> None:
    sound = [
        replace(fly(seed, "lat", model=MODEL).maneuver, id=str(seed), flight="A")
        for seed in (1, 2, 3)
    ]
    known = campaign_assumed_constants(sound)
    speeds = [float(one.samples("V")[:100].mean()) for one in sound]
    assert known["V"].value == pytest.approx(np.mean(speeds), rel=0.01)
    assert set(known) == {"V", "alpha"}
    inside, wider = [], []
    lost = [
        replace(cut(dead_nose(fly(seed, "lat", model=MODEL))), id=f"B{seed}")
        for seed in range(10, 16)
    ]
    for result in run_campaign([*sound, *lost], CampaignSettings()).results[len(sound) :]:
        estimate = result.estimate
        for name, found in estimate.derivatives.items():
            if found.value is None or not found.std or name.endswith("_0"):
                continue
            inside.append(abs(found.value - MODEL.derivative(name)) <= 2.0 * found.std)
            wider.append(found.std > 1.5 * (found.cramer_rao or 0.0))
        assert any("airspeed" in text for text in estimate.warnings)
    assert len(inside) > 20
    assert np.mean(inside) >= 0.85
    assert np.mean(wider) > 0.5


def test_without_others_the_aircraft_file_suggests_them() -> None:
    lost = cut(dead_nose(fly(2, "lat", model=MODEL)))
    known = campaign_assumed_constants([lost])
    low, high = AIRCRAFT.limits.alpha_linear
    assert known["alpha"].value == pytest.approx(0.5 * (low + high))
    assert known["V"].value == pytest.approx(100 * 0.3048, rel=0.01)
    assert known["V"].std == pytest.approx(0.1 * known["V"].value)
    assert campaign_assumed_constants([]) == {}


def flickering(samples: np.ndarray, step: float) -> np.ndarray:
    random = np.random.default_rng(5)
    counts = random.integers(0, 2, len(samples)) - 1e-3 * random.standard_normal(len(samples))
    return np.asarray(samples[0] + step * counts)


def changed(block: Block, **columns: np.ndarray) -> Block:
    kept = [name for name in block.channels if name not in columns]
    return Block(
        channels=(*kept, *columns),
        times=block.times,
        values=np.column_stack((block.select(kept).values, *columns.values())),
    )


@pytest.mark.parametrize("method", ["ml", "ee"])
def test_a_vane_stuck_on_a_flickering_count_is_as_good_as_none(method: Literal["ml", "ee"]) -> None:
    """Taken as measured it gave equation error a Cl_p of a tenth of its size."""
    block = fly(2, "lat", model=MODEL).maneuver.block
    stuck = cut(changed(block, beta=flickering(block["beta"], 0.025 * DEGREE)))
    assert "beta" not in stuck.block.channels
    assert stuck.remarks[0].startswith("beta was faulty")
    none = cut(block.select([name for name in block.channels if name != "beta"]))
    found, usual = (
        run_campaign([one], CampaignSettings(method=method)).results[0].estimate
        for one in (stuck, none)
    )
    assert found.value("Cl_da") is not None
    assert found.derivatives == usual.derivatives


def test_a_surface_of_which_one_half_is_stuck_is_not_measured() -> None:
    """Its mean shows half of what was flown, so each of its derivatives would be doubled."""
    block = fly(2, "lon", model=MODEL).maneuver.block
    moved, stuck = block["de"], flickering(block["de"], 0.02 * DEGREE)
    half = changed(block, elevator_left=stuck, elevator_right=moved, de=0.5 * (stuck + moved))
    lost = cut(half, ("de",))
    assert not {"de", "elevator_left"} & set(lost.block.channels)
    assert lost.remarks[0].startswith("elevator_left was faulty")
    whole = cut(changed(block, elevator_left=moved, elevator_right=moved), ("de",))
    assert {"de", "elevator_left"} <= set(whole.block.channels)


def test_a_rudder_at_rest_with_its_noise_is_no_stuck_one() -> None:
    block = fly(61, "lat", model=MODEL, still=("dr",)).maneuver.block
    noise = AIRCRAFT.sensors.surfaces.noise
    alive = noise * np.random.default_rng(3).standard_normal(len(block))
    for record, seen in ((alive, True), (flickering(alive, 0.5 * noise), False)):
        maneuver = cut(changed(block, dr=record), ("da",))
        assert (not [name for name, _ in unmeasured_surfaces(maneuver, "lat")]) is seen


Method = Callable[[Maneuver, Axis], Estimate]
MEASURED_MOTION: dict[str, Method] = {
    "ee": lambda maneuver, axis: equation_error.estimate([maneuver], axis),
    "ftr": lambda maneuver, axis: ftr.estimate([maneuver], axis),
}
"""Methods that take the motion as it was measured."""


def flown(axis: str, *, still: tuple[str, ...] = ()) -> Maneuver:
    return fly(61, axis, still=still, dt=0.02).maneuver


@pytest.mark.parametrize("method", MEASURED_MOTION)
@pytest.mark.parametrize(
    ("channel", "axis", "lost"),
    [("q", "lon", ("CN_de", "Cm_de", "Cm_alpha")), ("p", "lat", ("Cl_da", "Cn_beta", "CY_dr"))],
)
def test_a_stuck_gyro_earns_no_number(
    method: str, channel: str, axis: Axis, lost: tuple[str, ...]
) -> None:
    """What it stands beside in an equation is bent with it: neither has a number."""
    maneuver = edited(flown(axis), **{channel: 0.0})
    found = MEASURED_MOTION[method](maneuver, axis)
    assert any(f"{channel} stays at 0" in one for one in found.warnings)
    assert {name: found.value(name) for name in lost} == dict.fromkeys(lost)


@pytest.mark.parametrize("method", MEASURED_MOTION)
@pytest.mark.parametrize(
    ("channel", "axis", "words"),
    [
        ("de", "lon", "elevator (de)"),
        ("alpha", "lon", "angle of attack (alpha)"),
        ("q", "lon", "pitch rate (q)"),
        ("an", "lon", "normal acceleration (an)"),
        ("da", "lat", "aileron (da)"),
        ("dr", "lat", "rudder (dr)"),
        ("p", "lat", "roll rate (p)"),
        ("ay", "lat", "side acceleration (ay)"),
        ("beta", "lat", "sideslip (beta)"),
        ("r", "lat", "yaw rate (r)"),
    ],
)
def test_every_method_names_a_reversed_channel(
    method: str, channel: str, axis: Axis, words: str
) -> None:
    good, bad = (
        MEASURED_MOTION[method](one, axis).warnings
        for one in (flown(axis), edited(flown(axis), **{channel: np.negative}))
    )
    assert not any("appears wrong" in one for one in good)
    assert [one for one in bad if f"the sign of {words} appears wrong" in one]


@pytest.mark.parametrize("record", ["stuck", "lost"])
def test_a_rudder_that_moved_unseen_takes_every_number_with_it(record: str) -> None:
    value = 0.01 if record == "stuck" else np.nan
    maneuver = replace(edited(flown("lat"), dr=value), inputs=("da",))
    found = ml_estimate([maneuver], MLSettings(axis="lat"))
    assert all(one.value is None for one in found.derivatives.values() if one.status != "held")
    (said,) = {one.why for one in found.derivatives.values() if "dr" in one.why}
    assert said in found.warnings
    assert said.startswith("dr stays at" if record == "stuck" else "the rudder (dr)")
    answered = ml_estimate([maneuver], MLSettings(axis="lat", stand_ins={"dr": 0.01}))
    assert answered.value("Cl_da") is not None


def test_a_rudder_that_rested_takes_nothing() -> None:
    virtual = fly(61, "lat", still=("dr",), dt=0.02)
    maneuver = edited(virtual.maneuver, dr=0.0)
    found = ml_estimate([maneuver], MLSettings(axis="lat"))
    for name in ("Cl_p", "Cl_da", "Cn_beta"):
        one = found.derivatives[name]
        assert abs(one.value - virtual.truth[name]) < 4.0 * one.std


@pytest.mark.parametrize("method", MEASURED_MOTION)
def test_a_stuck_rudder_takes_every_number_where_no_residuals_tell(method: str) -> None:
    maneuver = replace(edited(flown("lat"), dr=0.01), inputs=("da",))
    found = MEASURED_MOTION[method](maneuver, "lat")
    assert not found.free
    assert not any(one.status == "estimated" for one in found.derivatives.values())
    (said,) = [one for one in found.warnings if "--stand-in dr=0" in one]
    assert said.startswith("dr stays")
    assert not any("appears wrong" in one for one in found.warnings)


def test_a_maneuver_left_out_says_why_where_nothing_else_is_left() -> None:
    maneuver = replace(edited(flown("lon"), de=0.02), inputs=("da",))
    with pytest.raises(FlightError, match="axis lon: de stays"):
        run_campaign([maneuver], CampaignSettings(axis="lon"))


@pytest.mark.parametrize("method", ["ml", "ee", "ftr"])
def test_rest_is_said_in_one_sentence(method: Literal["ml", "ee", "ftr"]) -> None:
    virtual = fly(61, "lon", still=("de",), dt=0.02)
    rest = replace(virtual.maneuver, inputs=())
    (one,) = run_campaign([rest], CampaignSettings(method=method, axis="lon")).results
    assert one.estimate.warnings[0].startswith("no surface moved")
    assert {"CN_q", "CN_de", "Cm_q", "Cm_de"}.isdisjoint(one.estimate.free)
    for name in one.estimate.free:
        found = one.estimate.derivatives[name]
        assert abs(found.value - virtual.truth[name]) < 4.0 * found.std
