"""Linear models fitted on some maneuvers of a campaign and judged on the others."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError
from gsapp.identification.campaign import CampaignResult, CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.summary.linear_model_validation import validate_linear_models
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import fly

TRUTH = load_model("b777")
FEW = CampaignSettings(method="ee")
"""Quick: which method gives the derivatives does not matter here."""


@cache
def flown_once() -> tuple[Maneuver, ...]:
    kinds = zip(range(21, 29), ("lon", "lat") * 4, strict=True)
    return tuple(
        fly(seed, kind, dt=0.02, duration=4.0, model=TRUTH).maneuver for seed, kind in kinds
    )


def maneuvers(flights: int) -> tuple[Maneuver, ...]:
    found = []
    for place, one in enumerate(flown_once()):
        number = 1 if flights == 1 else 1 + place // 4
        name = f"{number}:M{place}" if flights > 1 else f"M{place}"
        found.append(replace(one, id=name, flight=f"flight {number}"))
    return tuple(found)


def campaign(flown: tuple[Maneuver, ...]) -> CampaignResult:
    return run_campaign(flown, FEW)


def with_channel(one: Maneuver, channel: str, factor: float) -> Maneuver:
    values = one.block.values.copy()
    values[:, one.block.channels.index(channel)] *= factor
    block = Block(channels=one.block.channels, times=one.block.times, values=values)
    return replace(one, block=block)


def test_the_last_flight_is_kept_out_and_nothing_of_it_is_in_the_models() -> None:
    """Models follow it within a few percent; another record of it leaves them the same, bit by bit.

    A gyro that shows half of the pitch rate there makes the error of q large: it is the flight
    that judges.
    """
    flown = maneuvers(2)
    found = validate_linear_models(campaign(flown))
    assert not found.remarks
    assert found.axes["lon"].validation_maneuvers == ("2:M4", "2:M6")
    assert found.axes["lat"].fitted_maneuvers == ("1:M1", "1:M3")
    assert found.axes["lat"].flights == ("flight 2",)
    for one in found.axes.values():
        assert set(one.errors) == {"bls", "subspace", "ml"}
        assert all(
            0.0 < error < 15.0 for errors in one.errors.values() for error in errors.values()
        )
    other = tuple(
        with_channel(one, "q", 0.5) if one.id[0] == "2" else one
        for one in flown
        if "de" in one.inputs
    )
    wrong = validate_linear_models(campaign(other))
    for name, model in found.axes["lon"].models.items():
        assert np.array_equal(model.model.A, wrong.axes["lon"].models[name].model.A)
        assert np.array_equal(model.model.B, wrong.axes["lon"].models[name].model.B)
    assert wrong.axes["lon"].errors["ml"]["q"] > 2.0 * found.axes["lon"].errors["ml"]["q"]


def test_the_flight_that_judges_can_be_named_and_judges_as_a_whole() -> None:
    """The cut asked for runs from its first to its last maneuver; a start of one's own helps.

    A flight that cannot be opened is said.
    """
    flown = tuple(one for one in maneuvers(2) if "de" in one.inputs and one.id != "1:M2")
    asked: list[tuple[str, float, float]] = []

    def cut(number: str, start: float, stop: float) -> Maneuver:
        asked.append((number, start, stop))
        return flown[0]

    def gone(*_: object) -> Maneuver:
        raise FlightError("the flight is gone")

    found = validate_linear_models(campaign(flown), keep_out=("1",), cut=cut).axes["lon"]
    assert found.validation_maneuvers == ("1:M0",)
    assert asked == [("1", flown[0].t_start, flown[0].t_end)]
    for name, errors in found.errors.items():
        ratios = np.array(
            [errors[key] / found.whole_flight_errors[name][key] for key in found.outputs]
        )
        # All outputs together, each in units of what it missed without.
        assert 0.0 < np.mean(ratios**2) < 1.0
    closed = validate_linear_models(campaign(flown), keep_out=("1",), cut=gone)
    assert not closed.axes["lon"].whole_flight_errors
    assert ["flight is gone" in one for one in closed.remarks] == [True]


def test_one_flight_is_judged_on_every_other_maneuver_of_each_kind() -> None:
    found = validate_linear_models(campaign(maneuvers(1)))
    assert found.axes["lon"].fitted_maneuvers == ("M0", "M4")
    assert found.axes["lon"].validation_maneuvers == ("M2", "M6")
    assert found.axes["lat"].validation_maneuvers == ("M3", "M7")
    assert found.axes["lat"].flights == ()
    trace = found.axes["lon"].traces[0]
    assert trace.measured.shape == trace.computed["bls"].shape == (trace.times.size, 3)
    assert trace.inputs.shape == (trace.times.size, 1)
    # The errors are those of the traces.
    measured = np.vstack([one.measured[:, 2] for one in found.axes["lon"].traces])
    computed = np.vstack([one.computed["bls"][:, 2] for one in found.axes["lon"].traces])
    error = 100.0 * np.sqrt(np.mean((measured - computed) ** 2)) / np.ptp(measured)
    assert found.axes["lon"].errors["bls"]["q"] == pytest.approx(error)


def test_what_was_left_out_by_hand_is_neither_fitted_nor_judged() -> None:
    found = validate_linear_models(campaign(maneuvers(2)), without=("1:M0", "2:M6", "1:M1", "1:M3"))
    assert (found.axes["lon"].fitted_maneuvers, found.axes["lon"].validation_maneuvers) == (
        ("1:M2",),
        ("2:M4",),
    )
    assert found.axes["lat"].fitted_maneuvers == ("2:M5",)


def test_a_single_maneuver_of_a_kind_is_told_and_not_judged() -> None:
    flown = tuple(one for one in maneuvers(1) if one.id not in ("M2", "M4", "M6"))
    found = validate_linear_models(campaign(flown))
    assert set(found.axes) == {"lat"}
    (said,) = found.remarks
    assert "second maneuver" in said
