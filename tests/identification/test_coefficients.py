"""Coefficients reconstructed from motion are those that made the motion."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.equations import RigidBody, angular_accelerations
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_COEFFICIENTS
from gsapp.identification.coefficients import moments_from_rates, reconstruct_coefficients
from gsapp.identification.motion import measured_motion
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import edited, fly, without

AIRCRAFT = load_aircraft("b777")
TRUTH = load_model("b777")


@cache
def flown(axis, *effects):
    model = TRUTH
    for effect in effects:
        model = model.with_effect(effect)
    return fly(0, axis, noise=0.0, model=model).maneuver


def true_coefficients(maneuver, model=TRUTH):
    motion = measured_motion(maneuver)
    equations = FlightModel(AIRCRAFT, model)
    totals = equations.evaluate(tuple(motion.states.T), tuple(motion.inputs.T))
    return totals.coefficients


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_every_coefficient_at_every_sample(axis):
    maneuver = flown(axis)
    found = reconstruct_coefficients(maneuver, cutoff=5.0)
    true_ones = true_coefficients(maneuver)
    for name in AXIS_COEFFICIENTS[axis]:
        true = true_ones[name]
        expected = found.smooth(np.broadcast_to(true, found.times.shape))
        counts = found.valid_samples(name)
        assert counts.sum() > 900
        error = found.value(name)[counts] - expected[counts]
        assert np.sqrt(np.mean(error**2)) < 1e-3 * np.ptp(expected)
        # Where a surface starts with a jerk, between two samples, it may be more.
        assert np.abs(error).max() < 1e-2 * np.ptp(expected)
    assert axis == "lat" or found.value("CX")[500] == -found.value("CA")[500]


_NUMBERS = st.floats(-2.0, 2.0)


@settings(max_examples=40, deadline=None)
@given(st.tuples(*[_NUMBERS] * 6))
def test_moments_are_the_inverse_of_the_equations(numbers):
    p, q, r, L, M, N = numbers
    body = RigidBody(mass=20.0, ixx=7.0, iyy=8.6, izz=9.4, ixz=0.4)
    spin = angular_accelerations(p, q, r, L, M, N, body)
    np.testing.assert_allclose(moments_from_rates((p, q, r), spin, body), (L, M, N), atol=1e-10)


def test_effects_of_a_model_are_taken_out():
    model = TRUTH.with_effect("aero.Cm.alpha2").with_effect("aero.Cm.alphadot")
    model = model.with_effect("mass.cg.x")
    maneuver = flown("lon", "aero.Cm.alpha2", "aero.Cm.alphadot", "mass.cg.x")
    linear = true_coefficients(maneuver)["Cm"]
    found = reconstruct_coefficients(maneuver, model=model)
    blind = reconstruct_coefficients(maneuver)
    counts = found.valid_samples("Cm")
    expected = found.smooth(linear)[counts]
    right = np.abs(found.value("Cm")[counts] - expected).max()
    wrong = np.abs(blind.value("Cm")[counts] - expected).max()
    assert right < 2e-2 * np.ptp(expected)
    assert wrong > 5.0 * right


def test_missing_samples_do_not_count_and_long_gaps_block_their_neighbors():
    maneuver = flown("lon")
    q = maneuver.block["q"].copy()
    q[300:302] = q[500:520] = np.nan
    found = reconstruct_coefficients(edited(maneuver, q=q), cutoff=5.0)
    good = found.valid_samples("Cm")
    reach = found.smoother.half_width
    assert good[299]
    assert not good[300:302].any()
    assert good[302]
    assert not good[500 - reach : 520 + reach].any()
    # The elevator itself was there all the time.
    assert found.variable_valid["de"][500:520].all()


def test_a_pause_of_the_record_is_not_smoothed_over():
    maneuver = flown("lon")
    times = maneuver.block.times.copy()
    times[400:] += 30.0
    block = Block(channels=maneuver.block.channels, times=times, values=maneuver.block.values)
    found = reconstruct_coefficients(replace(maneuver, block=block), cutoff=5.0)
    reach = found.smoother.half_width
    assert not found.valid_samples("Cm")[400 - reach : 400 + reach - 1].any()
    assert found.valid_samples("Cm")[400 + reach :].any()


def test_clipped_samples_do_not_count():
    maneuver = flown("lat")
    clipped = np.zeros(len(maneuver.block), dtype=bool)
    clipped[200:230] = True
    found = reconstruct_coefficients(replace(maneuver, clipped={"p": clipped}), cutoff=5.0)
    assert not found.valid_samples("Cl")[200:230].any()
    assert not found.variable_valid["p_hat"][200:230].any()


def test_a_missing_or_stuck_instrument_is_named():
    maneuver = flown("lon")
    assert "an was not" in reconstruct_coefficients(without(maneuver, "an")).missing["CN"]
    found = reconstruct_coefficients(edited(maneuver, q=0.1))
    assert "stuck" in found.missing["Cm"]
    assert not found.valid_samples("Cm").any()


def test_a_vane_that_is_missing_is_replaced_by_integration():
    maneuver = flown("lat")
    found = reconstruct_coefficients(without(maneuver, "beta"))
    assert found.integrated == {"beta"}
    true = measured_motion(maneuver).state("beta")
    difference = found.variables["beta"] - true
    drift = np.polynomial.Polynomial.fit(found.times, difference, 1)(found.times)
    assert np.std(difference - drift) < 0.01 * np.ptp(true)


def test_no_mass_is_refused():
    with pytest.raises(FlightError, match="mass of 0 kg"):
        reconstruct_coefficients(replace(flown("lon"), mass=0.0))
