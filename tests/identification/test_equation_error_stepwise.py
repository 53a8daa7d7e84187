"""Terms that the data prove: found where they are, not where they are not."""

from functools import cache

import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.identification.equation_error.stepwise_regression import candidate_terms, select_terms
from tests.identification.virtual_maneuvers import fly

TRUTH = load_model("b777")


@cache
def flown(axis, effect):
    model = TRUTH.with_effect(effect) if effect else TRUTH
    return tuple(fly(seed, axis, noise=0.3, model=model).maneuver for seed in range(3))


@pytest.mark.parametrize(
    ("axis", "coefficients"), [("lon", ("CN", "CA", "Cm")), ("lat", ("CY", "Cl", "Cn"))]
)
def test_a_linear_aircraft_needs_no_more(axis, coefficients):
    """Proves that colored residuals of a linear aircraft are not taken for an effect."""
    for coefficient in coefficients:
        found = select_terms(flown(axis, ""), coefficient)
        assert found.beyond_linear == ()
        assert found.r2 > 0.9
        assert all(step.action == "refused" for step in found.steps)


@pytest.mark.parametrize(
    ("axis", "coefficient", "effect"),
    [
        ("lon", "Cm", "aero.Cm.alpha2"),
        ("lon", "Cm", "aero.Cm.alpha_de"),
        ("lat", "Cl", "aero.Cl.alpha_beta"),
    ],
)
def test_an_effect_is_chosen_with_its_size(axis, coefficient, effect):
    """Proves that the missing term is the one added, with its value within its bound."""
    found = select_terms(flown(axis, effect), coefficient)
    assert found.beyond_linear == (effect,)
    value, std = found.values[effect]
    truth = TRUTH.with_effect(effect).effects[0].values(load_aircraft("b777"))[0]
    assert abs(value - truth) < 4.0 * std + 0.1 * abs(truth)
    first = found.steps[0]
    assert (first.action, first.term) == ("added", effect)
    assert first.partial_f > 20.0
    assert "prediction" in first.why
    assert all(step.why for step in found.steps)


def test_from_nothing_the_linear_terms_come_first():
    """Proves forward selection without the linear terms given: Cm takes its own three."""
    found = select_terms(flown("lon", ""), "Cm", keep_linear=False)
    assert {"Cm_alpha", "Cm_q", "Cm_de"} <= set(found.values)
    assert found.steps[0].action == "added"


def test_the_pool_holds_no_term_twice():
    """Proves that catalog effects stand under their own names only."""
    pool = candidate_terms("Cm", load_aircraft("b777"))
    assert {"Cm_alpha", "aero.Cm.alpha2", "aero.Cm.alpha_de", "unnamed.Cm.de2"} <= set(pool)
    assert "unnamed.Cm.alpha2" not in pool
    assert "aero.Cm.memory" not in pool
