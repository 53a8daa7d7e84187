"""Approaches to the stall that JSBSim flies: its shape, its terms, its name, and where it is not.

The separation of the flow is written once more in `tests.discrepancy.blind.engine`.
"""

from __future__ import annotations

import numpy as np
import pytest

from gsapp.discrepancy.candidates import screen_stall
from gsapp.discrepancy.effect_catalog import excluded_effects
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.search_checks import highest_alpha
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.model import Model
from gsapp.identification.equation_error.stepwise_regression import select_terms
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.motion_linearization import create_maneuver_record
from tests.discrepancy.blind.cases import Case
from tests.discrepancy.blind.engine import Stall
from tests.discrepancy.blind.flying import FlownCase, fly_case
from tests.discrepancy.blind.plan import PLAN, STALL_APPROACHES, Planned

SIZES = {"aero.CN.stall": -4.6, "aero.Cm.stall": -0.15}
PLAN_SEED = 102
TRUE = Stall.of_plan(PLAN_SEED)


def flown_with(effects: dict[str, float], planned: tuple[Planned, ...]) -> FlownCase:
    return fly_case(
        Case(id="stall", group="hidden", effects=effects, plan=PLAN_SEED, seed=5), planned
    )


@pytest.fixture(scope="module")
def stalled() -> FlownCase:
    return flown_with(SIZES, (PLAN[0], *STALL_APPROACHES[:3]))


def test_a_stall_shows_without_a_model(stalled: FlownCase) -> None:
    found = screen_stall(Model(), stalled.maneuvers, stalled.aircraft)
    assert not found.is_known
    assert {*found.proven} == {*SIZES}
    shape = found.shape
    assert shape["a1"] == pytest.approx(TRUE.a1, rel=0.15)
    # The vane's zero error moves it.
    assert shape["alpha_star"] == pytest.approx(TRUE.alpha_star, abs=0.02)
    assert shape["tau1"] == pytest.approx(TRUE.tau1, abs=0.08)
    assert shape["tau2"] == pytest.approx(TRUE.tau2, abs=0.08)
    model = Model().with_effect("aero.CN.stall", {"CN_stall": SIZES["aero.CN.stall"], "a1": 17.0})
    found = screen_stall(model, stalled.maneuvers, stalled.aircraft)
    assert found.is_known
    assert found.shape["a1"] == 17.0
    assert "aero.CN.stall" not in found.proven


@pytest.mark.parametrize("coefficient", ["CN", "Cm"])
def test_a_stall_wins_over_powers_of_alpha(stalled: FlownCase, coefficient: str) -> None:
    found = select_terms(stalled.maneuvers, coefficient)
    effect = f"aero.{coefficient}.stall"
    assert (found.steps[0].action, found.steps[0].term) == ("added", effect)
    assert not {f"aero.{coefficient}.alpha2"} & set(found.beyond_linear)
    assert len(found.beyond_linear) <= 3
    assert found.values[effect][0] == pytest.approx(SIZES[effect], rel=0.2)
    assert found.shapes[effect]["alpha_star"] == pytest.approx(TRUE.alpha_star, abs=0.02)
    alpha = f"{coefficient}_alpha"
    assert found.values[alpha][0] == pytest.approx(stalled.truth[alpha], rel=0.15)


def test_a_curve_in_alpha_is_no_stall() -> None:
    """Proves that the same pulls with alpha^2 hidden give alpha^2, in both coefficients."""
    curved = flown_with(
        {"aero.CN.alpha2": -5.0, "aero.Cm.alpha2": -1.5}, (PLAN[0], *STALL_APPROACHES[:2])
    )
    for coefficient in ("CN", "Cm"):
        found = select_terms(curved.maneuvers, coefficient)
        assert f"aero.{coefficient}.alpha2" in found.beyond_linear
        assert f"aero.{coefficient}.stall" not in found.beyond_linear


def test_what_stays_in_the_linear_range_shows_no_stall(stalled: FlownCase) -> None:
    gentle = stalled.maneuvers[:1]
    top = highest_alpha(gentle)
    assert top is not None
    assert top < stalled.aircraft.limits.alpha_linear[1]
    channels = gentle[0].block.channels
    reasons = excluded_effects(stalled.aircraft, channels, highest_alpha=top)
    assert "beyond the linear range" in reasons["aero.CN.stall"]
    top = highest_alpha(stalled.maneuvers)
    assert "aero.CN.stall" not in excluded_effects(stalled.aircraft, channels, highest_alpha=top)
    found = select_terms(gentle, "CN")
    assert "aero.CN.stall" in found.unexcited
    assert "aero.CN.stall" not in found.values


def test_one_flow_separates_for_all_coefficients(stalled: FlownCase) -> None:
    """Proves that a held stall follows the free one, in value and in what a parameter changes."""
    model = Model(derivatives=stalled.truth)
    for effect, size in SIZES.items():
        name = effect.removeprefix("aero.").replace(".", "_")
        model = model.with_effect(effect, {name: size})
    records = [create_maneuver_record(stalled.maneuvers[1])]
    free = ("CN_alpha", "aero.CN.stall.alpha_star", "aero.Cm.stall.Cm_stall")
    fit = FilterErrorFit.create(records, model, free)
    assert fit.shared_parameters() == {"aero.Cm.stall.alpha_star": "aero.CN.stall.alpha_star"}
    fit.values["aero.CN.stall.alpha_star"] = 0.2
    effects = {one.id: one.parameters for one in fit.revised_model().effects}
    assert effects["aero.Cm.stall"]["alpha_star"] == 0.2
    fit.linearize()
    one = fit.maneuvers[0]
    columns = dict(
        zip(fit.free, fit.model_columns(one, one.current_filter.linearization), strict=True)
    )
    assert [entry.target for entry in columns["aero.CN.stall.alpha_star"]] == [
        "free.aero.CN.stall.alpha_star",
        "free.aero.Cm.stall.alpha_star",
    ]


@pytest.mark.long
@pytest.mark.parametrize("gust", [0.0, 0.3])
def test_the_stall_is_named_first_and_its_numbers_lie_within_their_bounds(gust: float) -> None:
    case = Case(id="stall", group="hidden", effects=SIZES, plan=PLAN_SEED, seed=5, gust=gust)
    flown = fly_case(case, (*PLAN[:8], *STALL_APPROACHES))
    found = Investigation(flown.maneuvers, flown.aircraft).run(DiscrepancySettings())
    assert found.verdict == "effects-found"
    assert {one.effect for one in found.effects} == set(SIZES)
    assert found.gap.closed is not None
    assert found.gap.closed > 0.9
    truth = {**SIZES, "a1": TRUE.a1, "alpha_star": TRUE.alpha_star, "tau1": TRUE.tau1}
    truth["tau2"] = TRUE.tau2
    for one in found.effects:
        for name, (value, std) in one.parameters.items():
            wanted = truth.get(name, SIZES[one.effect])
            assert abs(value - wanted) < 4.0 * std + 0.01 * abs(wanted), name
    assert np.sign(found.model.derivative("Cm_alpha")) == -1.0
