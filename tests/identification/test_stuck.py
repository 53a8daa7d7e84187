"""Stuck channels, surfaces that nobody saw, wrong signs, ten samples: alike for every method."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification import equation_error, ftr
from gsapp.identification.axes import Axis
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import MLSettings
from gsapp.identification.maximum_likelihood import estimate as ml_estimate
from gsapp.identification.results import Estimate
from gsapp.quantities import Block, FloatArray
from tests.identification.virtual_maneuvers import fly

Method = Callable[[Maneuver, Axis], Estimate]
MEASURED_MOTION: dict[str, Method] = {
    "ee": lambda maneuver, axis: equation_error.estimate([maneuver], axis),
    "ftr": lambda maneuver, axis: ftr.estimate([maneuver], axis),
}
"""Methods that take the motion as it was measured."""


def flown(axis: str, *, still: tuple[str, ...] = ()) -> Maneuver:
    return fly(61, axis, still=still, dt=0.02).maneuver


def edited(maneuver: Maneuver, **changes: Callable[[FloatArray], FloatArray]) -> Maneuver:
    block = maneuver.block
    columns = [
        changes[name](block[name].copy()) if name in changes else block[name]
        for name in block.channels
    ]
    values = np.column_stack(columns)
    return replace(maneuver, block=Block(channels=block.channels, times=block.times, values=values))


def at(value: float) -> Callable[[FloatArray], FloatArray]:
    return lambda samples: np.full_like(samples, value)


@pytest.mark.parametrize("method", MEASURED_MOTION)
@pytest.mark.parametrize(
    ("channel", "axis", "lost"),
    [("q", "lon", ("CN_de", "Cm_de", "Cm_alpha")), ("p", "lat", ("Cl_da", "Cn_beta", "CY_dr"))],
)
def test_a_stuck_gyro_earns_no_number(
    method: str, channel: str, axis: Axis, lost: tuple[str, ...]
) -> None:
    """What it stands beside in an equation is bent with it: neither has a number."""
    maneuver = edited(flown(axis), **{channel: at(0.0)})
    found = MEASURED_MOTION[method](maneuver, axis)
    assert any(f"{channel} stays at 0" in one for one in found.warnings)
    assert {name: found.value(name) for name in lost} == dict.fromkeys(lost)


@pytest.mark.parametrize("method", MEASURED_MOTION)
@pytest.mark.parametrize(
    ("channel", "axis", "words"),
    [
        ("de", "lon", "elevator (de)"),
        ("q", "lon", "pitch rate (q)"),
        ("da", "lat", "aileron (da)"),
        ("dr", "lat", "rudder (dr)"),
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
    maneuver = replace(edited(flown("lat"), dr=at(value)), inputs=("da",))
    found = ml_estimate([maneuver], MLSettings(axis="lat"))
    assert all(one.value is None for one in found.derivatives.values() if one.status != "held")
    (said,) = {one.why for one in found.derivatives.values() if "dr" in one.why}
    assert said in found.warnings
    assert said.startswith("dr stays at" if record == "stuck" else "the rudder (dr)")
    answered = ml_estimate([maneuver], MLSettings(axis="lat", stand_ins={"dr": 0.01}))
    assert answered.value("Cl_da") is not None


def test_a_rudder_that_rested_takes_nothing() -> None:
    virtual = fly(61, "lat", still=("dr",), dt=0.02)
    maneuver = edited(virtual.maneuver, dr=at(0.0))
    found = ml_estimate([maneuver], MLSettings(axis="lat"))
    for name in ("Cl_p", "Cl_da", "Cn_beta"):
        one = found.derivatives[name]
        assert abs(one.value - virtual.truth[name]) < 4.0 * one.std


@pytest.mark.parametrize("method", MEASURED_MOTION)
def test_a_stuck_rudder_takes_every_number_where_no_residuals_tell(method: str) -> None:
    maneuver = replace(edited(flown("lat"), dr=at(0.01)), inputs=("da",))
    found = MEASURED_MOTION[method](maneuver, "lat")
    assert not found.free
    assert not any(one.status == "estimated" for one in found.derivatives.values())
    (said,) = [one for one in found.warnings if "--stand-in dr=0" in one]
    assert said.startswith("dr stays")
    assert not any("appears wrong" in one for one in found.warnings)


@pytest.mark.parametrize("method", MEASURED_MOTION)
def test_ten_samples_are_too_few_for_every_method(method: str) -> None:
    block = flown("lon").block
    short = Block(channels=block.channels, times=block.times[:10], values=block.values[:10])
    with pytest.raises(FlightError, match="10 samples"):
        MEASURED_MOTION[method](replace(flown("lon"), block=short), "lon")


def test_a_maneuver_left_out_says_why_where_nothing_else_is_left() -> None:
    maneuver = replace(edited(flown("lon"), de=at(0.02)), inputs=("da",))
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
