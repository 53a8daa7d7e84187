"""Proves that errors of mass, inertia and CG are offered for the values that they move, alone."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.mass_patterns import MovedValues, mass_errors
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.identification.maneuver import Maneuver
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver
from tests.identification.virtual_maneuvers import fly

SIZES = {
    "mass.mass.error": ("mass", 0.06),
    "mass.inertia.ixx": ("ixx", 0.08),
    "mass.inertia.iyy": ("iyy", -0.07),
    "mass.inertia.izz": ("izz", 0.08),
    "mass.inertia.ixz": ("ixz", 0.06),
}
"""Field of the aircraft file, and by what share (of ixx for ixz) it is wrong."""


def _heavier(field: str, share: float) -> Aircraft:
    mass = AIRCRAFT.mass
    reference = mass.ixx if field == "ixz" else getattr(mass, field)
    changed = mass.model_copy(update={field: getattr(mass, field) + share * reference})
    return AIRCRAFT.model_copy(update={"mass": changed})


def _moved(field: str, share: float) -> MovedValues:
    """Return the values that an estimate with the file's mass properties finds, but for noise."""
    true, file = _heavier(field, share).mass, AIRCRAFT.mass
    matrices = [np.array([[one.ixx, -one.ixz], [-one.ixz, one.izz]]) for one in (file, true)]
    ratio = matrices[0] @ np.linalg.inv(matrices[1])
    names = tuple(name for name in TRUTH.derivatives if not name.endswith("_0"))
    before = {name: TRUTH.derivative(name) for name in names}
    after = dict(before)
    for name in names:
        coefficient, _, regressor = name.partition("_")
        pair = np.array([TRUTH.derivative(f"{one}_{regressor}") for one in ("Cl", "Cn")])
        if coefficient in ("Cl", "Cn"):
            after[name] = float((ratio @ pair)[("Cl", "Cn").index(coefficient)])
        elif coefficient == "Cm":
            after[name] *= file.iyy / true.iyy
        else:
            after[name] *= file.mass / true.mass
    std = 0.01 * np.abs([*before.values()]) + 1e-4
    return MovedValues(
        names=names,
        before=np.array([*before.values()]),
        after=np.array([*after.values()]),
        covariance=np.diag(std**2),
    )


@pytest.mark.parametrize("effect", SIZES)
def test_each_mass_property_is_offered_for_its_own_pattern(effect: str) -> None:
    """And no other one, from the equations of motion, not from the patterns."""
    field, share = SIZES[effect]
    found = mass_errors(_moved(field, share), AIRCRAFT)
    assert [one.effects for one in found] == [(effect,)]
    said = float(found[0].why.split("of ")[1].split(" %")[0])
    assert said == pytest.approx(100.0 * share, rel=0.15)


def test_nothing_is_offered_where_one_value_moved_or_none() -> None:
    still = _moved("mass", 0.0)
    assert mass_errors(still, AIRCRAFT) == ()
    one = still.names.index("Cn_r")
    after = still.after.copy()
    after[one] *= 1.4
    assert mass_errors(replace(still, after=after), AIRCRAFT) == ()


def test_derivatives_that_an_effect_redefined_offer_no_center_of_gravity() -> None:
    """With Cm curved in alpha, Cm_alpha is the slope elsewhere: no CG moved."""
    still = _moved("mass", 0.0)
    shift = 0.03
    after = still.after.copy()
    for index, name in enumerate(still.names):
        if name.startswith("Cm_"):
            force = f"CN_{name.partition('_')[2]}"
            after[index] -= shift * TRUTH.derivative(force)
    moved = replace(still, after=after)
    assert ("mass.cg.x",) in [one.effects for one in mass_errors(moved, AIRCRAFT)]
    assert mass_errors(moved, AIRCRAFT, ("Cm",)) == ()


def _flown(seed: int, aircraft: Aircraft) -> Maneuver:
    like = maneuver(seed, "lat", duration=5.0)
    true = fly(seed, "lat", duration=5.0, dt=0.02, noise=0.0, model=TRUTH, aircraft=aircraft)
    plain = fly(seed, "lat", duration=5.0, dt=0.02, noise=0.0, model=TRUTH, aircraft=AIRCRAFT)
    values = like.block.values - plain.maneuver.block.values + true.maneuver.block.values
    return replace(like, block=replace(like.block, values=values))


def test_a_product_of_inertia_is_offered_in_a_search() -> None:
    """0.28 slug ft^2 more than the file says: yawing derivatives move as rolling ones do."""
    aircraft = _heavier("ixz", 0.28 / 5.2)
    flown = [_flown(seed, aircraft) for seed in range(1, 7)]
    found = Investigation(flown, AIRCRAFT, TRUTH).run(DiscrepancySettings(held_out=("2",)))
    assert found.verdict == "values-wrong"
    assert found.alternatives[0].effects == ("mass.inertia.ixz",)
