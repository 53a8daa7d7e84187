"""Proves the whole search on blind cases: truth flown by JSBSim, the program gets flights only.

The small set of `tests/bench/discrepancy.py`: twelve of its sixteen maneuvers, recorded at 50 Hz,
on plans and seeds that it does not report. The benchmark also flies still air and propulsion.
"""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("jsbsim", reason="truth is flown by JSBSim, which is not installed")

from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import DiscrepancyResult
from gsapp.discrepancy.settings import DiscrepancySettings
from tests.discrepancy.blind.answering import closed_gap
from tests.discrepancy.blind.cases import AIRFRAMES, Case, hidden
from tests.discrepancy.blind.flying import FlownCase, fly_case
from tests.discrepancy.blind.instruments import NOISE
from tests.discrepancy.blind.judging import is_named
from tests.discrepancy.blind.plan import PLAN

pytestmark = pytest.mark.long

SEED = 70
MANEUVERS = ("1", "3", "4", "5", "7", "8", "9", "10", "12", "13", "14", "16")


def prepared(case: Case) -> tuple[FlownCase, Investigation]:
    flown = fly_case(case, [one for one in PLAN if one.id in MANEUVERS])
    return flown, Investigation(flown.maneuvers, flown.aircraft, flown.model)


def answered(case: Case) -> tuple[FlownCase, DiscrepancyResult]:
    flown, search = prepared(case)
    return flown, search.run(DiscrepancySettings())


def nothing(kind: str, **how: object) -> Case:
    return Case(id=kind, group="nothing", kind=kind, plan=SEED, seed=SEED, rate=50, **how)  # type: ignore[arg-type]


def one(effect: str, size: float, **how: object) -> Case:
    return hidden(effect, size, plan=SEED, seed=SEED, rate=50, **how)


def gaps(flown: FlownCase, found: DiscrepancyResult) -> tuple[float, float]:
    """Return how far computed channels are from the noiseless truth, before and after.

    Sums of squares in units of noise, of the maneuvers kept out.
    """
    sums = [0.0, 0.0]
    for view in found.maneuvers:
        if not view.held_out:
            continue
        for column, name in enumerate(view.channels):
            truth = flown.steady[view.id][name]
            size = NOISE.get(name, 0.1)
            for index, computed in enumerate((view.computed[0], view.computed[-1])):
                sums[index] += float(np.sum(((computed[:, column] - truth) / size) ** 2))
    return sums[0], sums[1]


def test_gusts_are_a_disturbance_not_an_effect() -> None:
    _, found = answered(nothing("gusts", gust=0.3))
    assert found.verdict == "model-adequate"
    assert found.effects == ()
    assert 0.15 < found.disturbance["gust"] < 0.6
    assert "urbulence" in found.why
    # Residuals of coefficients are full of gusts; none of them is a place to look at.
    assert found.disagreements == ()


def test_wrong_values_are_no_effect() -> None:
    flown, found = answered(nothing("wrong", baseline="wrong"))
    assert found.verdict == "values-wrong"
    assert found.effects == ()
    assert {"Cm_alpha", "CN_alpha"} <= set(found.values)
    for name in ("Cm_alpha", "CN_alpha", "Cn_beta", "Cl_p"):
        changed = found.values[name]
        assert abs(changed.after - flown.truth[name]) < 5.0 * changed.std
        assert abs(changed.after - flown.truth[name]) < abs(changed.before - flown.truth[name])


def test_a_hidden_effect_is_named_sized_and_closes_the_gap() -> None:
    """First, alone, within 10 % of its size.

    By the truth it closes what the hidden effect itself would close, and no effect closes nothing.
    """
    case = one("aero.Cm.alpha2", -2.0)
    flown, search = prepared(case)
    found = search.run(DiscrepancySettings())
    assert found.verdict == "effects-found"
    (effect,) = found.effects
    assert effect.effect == case.kind
    assert found.ranking[0].effect == case.kind
    assert 0.9 < effect.confidence <= 0.95
    assert found.disagreements[0].coefficient == "Cm"
    value, std = next(iter(effect.parameters.values()))
    (true,) = flown.effects.values()
    assert value == pytest.approx(true, rel=0.1)
    assert abs(value - true) < 5.0 * std
    before, after = gaps(flown, found)
    assert after < 0.2 * before
    assert found.gap.closed > 0.9
    assert closed_gap(search, flown, found) == pytest.approx(1.0, abs=0.05)
    assert closed_gap(search, flown, replace(found, effects=())) == 0.0
    assert not set(found.gap.on) & {one.id for one in found.maneuvers if not one.held_out}


def test_what_is_in_no_catalog_gets_no_name() -> None:
    effect = "outside.Cl.da_abs_beta"
    case = Case(
        id=effect, group="outside", kind=effect, effects={effect: 2.0}, plan=SEED, seed=SEED,
        rate=50, verdicts=("unexplained",),
    )  # fmt: skip
    _, found = answered(case)
    assert found.verdict == "unexplained"
    assert not any(is_named(one.effect) for one in found.effects)
    assert found.ranking[0].effect.startswith("unnamed.Cl.")
    assert found.disagreements[0].coefficient == "Cl"
    assert "not understood" in found.why


def test_play_of_a_degree_is_named_with_its_size() -> None:
    """As wide as play of a worn linkage: no column at zero play sees it."""
    case = hidden("control.elevator.backlash", 0.0175, plan=SEED, seed=SEED)
    _, found = answered(case)
    assert found.verdict == "effects-found"
    (effect,) = (one for one in found.effects if one.named)
    assert effect.effect == "control.elevator.backlash"
    assert effect.parameters["slop"][0] == pytest.approx(0.0175, rel=0.1)


def test_what_another_aircraft_has_of_its_own_silences_nothing() -> None:
    """JSBSim's T-37: drag bends at zero sideslip, which no effect of the catalog does."""
    _, found = answered(one("aero.Cn.beta3", 2.5, airframe="T37"))
    assert "unnamed.CA.absbeta" in [one.effect for one in found.effects]
    named = {one.effect: one for one in found.effects if one.named}
    assert named["aero.Cn.beta3"].parameters["Cn_beta3"][0] == pytest.approx(2.5, rel=0.2)
    assert not set(named) - {*AIRFRAMES["T37"], "aero.Cn.beta3"}
