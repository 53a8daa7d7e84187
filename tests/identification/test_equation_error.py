"""Equation error and stepwise regression on virtual maneuvers whose derivatives are known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.effects.unnamed_terms import unnamed_ids
from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError
from gsapp.identification import ftr
from gsapp.identification.axes import axis_derivatives, free_derivatives
from gsapp.identification.campaign import campaign_values
from gsapp.identification.coefficients import smooth_coefficients
from gsapp.identification.equation_error import estimate, estimate_start_values
from gsapp.identification.equation_error.estimator import DELAYED_CHANNELS, estimate_relative_delay
from gsapp.identification.equation_error.stepwise_regression import (
    TermSelection,
    candidate_terms,
    select_terms,
)
from gsapp.quantities import Block
from gsapp.quantities.constants import GRAVITY
from tests.identification.virtual_maneuvers import NOISE, edited, fly, without

TRUTH = load_model("b777")
BIASES = ("CN_0", "CY_0")  # the virtual accelerometers have biases of their own
LEVELS = ("CN_0", "CA_0", "CY_0")  # their bounds allow for such biases
FLIGHTS, TIMES_EACH = 5, 8


@cache
def quiet(axis, seed=0):
    return fly(seed, axis, noise=0.0, model=TRUTH).maneuver


def noisy(maneuver, seed, color=0.0):
    random = np.random.default_rng(seed)
    columns = {}
    for name, size in NOISE.items():
        if name in maneuver.block.channels:
            noise = random.standard_normal(len(maneuver.block) + 200)
            if color and name not in ("de", "da", "dr", "V"):
                noise = lfilter([np.sqrt(1.0 - color**2)], [1.0, -color], noise)
            columns[name] = maneuver.block[name] + size * noise[200:]
    return edited(maneuver, **columns)


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_without_noise_the_truth_is_found(axis):
    found = estimate([quiet(axis)], axis)
    for name, one in found.derivatives.items():
        if name not in BIASES:
            assert one.status == "estimated"
            assert one.value == pytest.approx(TRUTH.derivative(name), rel=1e-2, abs=6e-3)
    assert min(fit.r2 for fit in found.fit.values()) > 0.999


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_coefficients_are_shown_as_measured_and_as_the_derivatives_compute_them(axis):
    """Proves that both follow each other where the values are right, and part where they are not.

    What is shown gives the quality of fit that is reported; held values count in full.
    """
    maneuver = noisy(quiet(axis), 3)
    doubled = {"lon": "Cm_de", "lat": "Cl_da"}[axis]
    coefficient = doubled.partition("_")[0]
    found = estimate([maneuver], axis)
    (shown,) = found.histories
    assert shown.channels == tuple(found.fit)
    for name, measured, computed in zip(
        shown.channels, shown.measured.T, shown.computed.T, strict=True
    ):
        counts = np.isfinite(measured)
        assert counts.mean() > 0.9
        left = np.var((measured - computed)[counts]) / np.var(measured[counts])
        assert 1.0 - left == pytest.approx(found.fit[name].r2, abs=0.005)
    wrong = estimate([maneuver], axis, held={doubled: 2.0 * TRUTH.derivative(doubled)})
    index = shown.channels.index(coefficient)
    gaps = [
        np.nanstd((one.measured - one.computed)[:, index]) for one in (shown, wrong.histories[0])
    ]
    assert gaps[1] > 2.0 * gaps[0]
    np.testing.assert_array_equal(shown.measured[:, index], wrong.histories[0].measured[:, index])


@pytest.mark.long
@pytest.mark.parametrize("color", [0.0, 0.9])
@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_errors_are_as_large_as_the_bounds_say(axis, color):
    """Proves the bounds, and that noise in the regressors bends nothing, white and colored.

    Over 40 maneuvers the error over its bound has an rms near 1 for every derivative, and its
    mean is what chance leaves. (The same over 400 maneuvers each: 0.83 to 1.26.)
    """
    errors = {name: [] for name in axis_derivatives(axis) if name not in LEVELS}
    for flight in range(FLIGHTS):
        for repeat in range(TIMES_EACH):
            maneuver = noisy(quiet(axis, flight), 100 * flight + repeat, color)
            found = estimate([maneuver], axis, delays={})
            for name, collected in errors.items():
                one = found.derivatives[name]
                assert one.status == "estimated"
                collected.append((one.value - TRUTH.derivative(name)) / one.std)
    rms = {name: np.sqrt(np.mean(np.square(x))) for name, x in errors.items()}
    assert all(0.6 < value < 1.5 for value in rms.values()), rms
    assert 0.8 < np.sqrt(np.mean(np.square(list(rms.values())))) < 1.25
    means = {name: np.mean(x) for name, x in errors.items()}
    assert all(abs(value) < 0.5 for value in means.values()), means


@pytest.mark.parametrize("axis", ["lon", "lat"])
def test_levels_of_forces_allow_for_the_zero_of_their_accelerometer(axis):
    found = estimate([quiet(axis)], axis)
    for name in LEVELS:
        if name in found.derivatives:
            one = found.derivatives[name]
            assert abs(one.value - TRUTH.derivative(name)) < 2.0 * one.std
            index = found.free.index(name)
            assert one.std == pytest.approx(np.sqrt(found.covariance[index, index]))
            assert one.std > 5.0 * one.cramer_rao


@pytest.mark.parametrize("method", [estimate, ftr.estimate])
def test_a_zero_does_not_shrink_with_the_number_of_maneuvers(method):
    wrong = 0.02 * GRAVITY
    found = []
    for seed in range(9):
        flown = noisy(quiet("lon", seed % 3), seed)
        found.append(method([edited(flown, an=flown.block["an"] + wrong)], "lon"))
    alone = found[0].derivatives["CN_0"]
    mean, slope = (campaign_values(found)[name] for name in ("CN_0", "CN_alpha"))
    assert mean.n == slope.n == len(found)
    assert abs(mean.mean - TRUTH.derivative("CN_0")) > 2.0 * alone.std / np.sqrt(mean.n)
    assert abs(mean.mean - TRUTH.derivative("CN_0")) < 2.0 * mean.std
    stds = np.array([one.derivatives["CN_alpha"].std for one in found])
    assert slope.std == pytest.approx(np.sum(stds**-2.0) ** -0.5)


def test_the_uncorrected_bound_is_smaller_than_the_honest_one():
    found = estimate([noisy(quiet("lon"), 1, 0.9)], "lon")
    for one in found.derivatives.values():
        assert 0.0 < one.cramer_rao < one.std


def test_several_maneuvers_make_one_better_estimate():
    alone = estimate([noisy(quiet("lat", 0), 1)], "lat")
    together = estimate([noisy(quiet("lat", seed), seed) for seed in range(4)], "lat")
    assert together.maneuvers == ("0", "1", "2", "3")
    for name in ("Cl_p", "Cl_da", "Cn_beta", "Cn_dr", "CY_beta"):
        one = together.derivatives[name]
        assert one.std < 0.8 * alone.derivatives[name].std
        assert abs(one.value - TRUTH.derivative(name)) < 4.0 * one.std
    assert together.covariance.shape == (18, 18)
    assert together.free == tuple(axis_derivatives("lat"))


def test_dropouts_and_clipping_are_left_out():
    maneuver = noisy(quiet("lon"), 3)
    random = np.random.default_rng(1)
    alpha, q = maneuver.block["alpha"].copy(), maneuver.block["q"].copy()
    alpha[random.random(alpha.size) < 0.03] = np.nan
    q[550:600] = np.nan
    limit = np.quantile(np.abs(q[np.isfinite(q)]), 0.97)
    clipped = np.abs(q) > limit
    q = np.clip(q, -limit, limit)
    damaged = replace(edited(maneuver, alpha=alpha, q=q), clipped={"q": clipped})
    found = estimate([damaged], "lon")
    for name in ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"):
        one = found.derivatives[name]
        assert abs(one.value - TRUTH.derivative(name)) < 4.0 * one.std
    whole = estimate([maneuver], "lon")
    assert found.fit["Cm"].samples < whole.fit["Cm"].samples


def test_a_surface_that_did_not_move_stays_unknown():
    maneuver = quiet("lat")
    rudder = np.full(len(maneuver.block), 0.01)
    found = estimate([noisy(edited(maneuver, dr=rudder), 1)], "lat")
    for name in ("CY_dr", "Cl_dr", "Cn_dr"):
        one = found.derivatives[name]
        assert (one.value, one.std, one.status) == (None, None, "unknown")
        assert "rudder hardly moved" in one.why
    assert found.derivatives["Cl_da"].status == "estimated"


def test_two_surfaces_that_move_as_one_cannot_be_told_apart():
    maneuver = quiet("lat")
    found = estimate([noisy(edited(maneuver, dr=0.5 * maneuver.block["da"]), 1)], "lat")
    for one, other in (("Cn_da", "Cn_dr"), ("Cn_dr", "Cn_da")):
        derivative = found.derivatives[one]
        assert derivative.status == "not-identifiable"
        assert derivative.value is None
        assert other in derivative.confounded_with
        assert other in derivative.why
    assert "Cn_da" not in found.free


def test_what_is_withheld_widens_what_stays():
    """In a rudder doublet roll rate and sideslip move alike; Cl_p goes, and Cl_r bears its share.

    Without that share Cl_r is 8 bounds off on average.
    """
    errors = []
    for seed in (7000, 7001, 7002, 7003):
        virtual = fly(seed, "lat", dt=0.02, still=("da",))
        found = estimate([virtual.maneuver], "lat")
        one = found.derivatives["Cl_r"]
        if found.derivatives["Cl_p"].status == "not-identifiable":
            errors.append((one.value - virtual.truth["Cl_r"]) / one.std)
            assert one.std == pytest.approx(
                found.covariance[found.free.index("Cl_r"), found.free.index("Cl_r")] ** 0.5
            )
            assert one.std > 3.0 * one.cramer_rao
    assert len(errors) > 1
    assert max(map(abs, errors)) < 3.0


def test_central_differences_without_smoothing_find_the_same():
    virtual = fly(2, "lat", dt=0.02)
    smoothed, plain = (
        estimate([virtual.maneuver], "lat", cutoff=cutoff) for cutoff in (None, np.inf)
    )
    for name in ("Cl_p", "Cl_da", "Cn_beta", "Cn_dr"):
        one, other = smoothed.derivatives[name], plain.derivatives[name]
        assert one.value != other.value
        assert other.value == pytest.approx(virtual.truth[name], abs=3.0 * other.std)
        # Noise that is not smoothed away widens the bound.
        assert other.std > one.std


def test_what_is_free_follows_the_input():
    maneuver = replace(noisy(quiet("lat"), 1), inputs=("da",))
    found = estimate([maneuver], "lat", held={"Cn_dr": -0.0661, "Cl_dr": 0.0127})
    assert found.derivatives["CY_dr"].status == "unknown"
    # The rudder moved all the same: what it did is not put down to the rest.
    assert any("rudder also moved" in text for text in found.warnings)
    force = found.derivatives["CY_beta"]
    assert abs(force.value - TRUTH.derivative("CY_beta")) < 4.0 * force.std
    assert found.derivatives["Cn_dr"].status == "held"
    assert found.derivatives["Cn_dr"].value == -0.0661
    held = found.derivatives["Cn_beta"]
    assert abs(held.value - TRUTH.derivative("Cn_beta")) < 4.0 * held.std


def test_without_a_sideslip_vane_the_slopes_are_still_found():
    found = estimate([without(noisy(quiet("lat"), 1), "beta")], "lat")
    for name in ("Cl_beta", "Cn_beta", "Cl_p", "Cn_r", "Cl_da", "Cn_dr"):
        one = found.derivatives[name]
        assert abs(one.value - TRUTH.derivative(name)) < 4.0 * one.std
    assert found.derivatives["Cn_0"].status == "unknown"
    assert "offset" in found.derivatives["Cn_0"].why
    assert any("beta" in text for text in found.warnings)
    # What the integrated sideslip drifts is left open in what is shown, too.
    (shown,) = found.histories
    left = np.nanvar(shown.measured - shown.computed, axis=0) / np.nanvar(shown.measured, axis=0)
    assert (left < 0.1).all()


def test_what_cannot_be_replaced_makes_its_coefficient_unknown():
    found = estimate([without(noisy(quiet("lat"), 1), "r")], "lat")
    assert {one.value for one in found.derivatives.values()} == {None}
    assert "yaw rate" in found.derivatives["Cn_r"].why
    assert "yaw rate" in found.derivatives["CY_beta"].why
    assert not found.converged


def test_nothing_to_learn_from_is_said():
    maneuver = quiet("lon")
    channels, times, values = maneuver.block.channels, maneuver.block.times, maneuver.block.values
    short = replace(maneuver, block=Block(channels=channels, times=times[:10], values=values[:10]))
    still = replace(
        maneuver,
        block=Block(channels=channels, times=times, values=np.tile(values[:1], (len(times), 1))),
    )
    dead = edited(maneuver, an=np.nan, ax=np.nan, q=np.nan)
    for one in (still, dead):
        found = estimate([one], "lon")
        assert not found.free
        assert "no derivative" in found.message
        assert all(item.why for item in found.derivatives.values())
    with pytest.raises(FlightError, match="10 samples; at least 40"):
        estimate([short], "lon")
    with pytest.raises(FlightError, match="no maneuver"):
        estimate([], "lon")


def test_start_values_are_near_and_quick_about_it():
    maneuver = noisy(quiet("lat"), 1)
    names = free_derivatives("lat", ("da", "dr"))
    start = estimate_start_values([maneuver], names)
    assert list(start) == list(names)
    for name in ("Cl_p", "Cl_da", "Cn_beta", "Cn_dr"):
        assert start[name] == pytest.approx(TRUTH.derivative(name), rel=0.15)
    still = edited(maneuver, dr=0.0)
    assert "Cn_dr" not in estimate_start_values([still], names)
    blind = estimate_start_values([without(maneuver, "beta")], names)
    assert blind["Cn_beta"] == pytest.approx(TRUTH.derivative("Cn_beta"), rel=0.15)


def late(maneuver, delay):
    times = maneuver.block.times
    return edited(
        maneuver,
        **{
            name: np.interp(times - delay, times, maneuver.block[name]) for name in DELAYED_CHANNELS
        },
    )


def test_a_filter_before_the_converter_is_noticed_and_undone():
    maneuvers = [noisy(late(quiet("lat", seed), 0.008), seed) for seed in range(3)]
    delay, bound = estimate_relative_delay(smooth_coefficients(maneuvers), "lat", ("da", "dr"))
    assert abs(delay - 0.008) < 4.0 * bound
    assert bound < 0.002
    bent = estimate(maneuvers, "lat")
    assert any("late against" in text for text in bent.warnings)
    undone = estimate(maneuvers, "lat", delays="estimate")
    for name in ("Cl_p", "Cl_da", "Cn_r"):
        truth = TRUTH.derivative(name)
        one = undone.derivatives[name]
        assert abs(one.value - truth) < 4.0 * one.std
    assert abs(bent.value("Cl_p") - TRUTH.derivative("Cl_p")) > 0.05
    assert undone.nuisance["0.shift.surfaces"][0] == pytest.approx(delay)


@cache
def flown(axis, effect):
    model = TRUTH.with_effect(effect) if effect else TRUTH
    return tuple(fly(seed, axis, noise=0.3, model=model).maneuver for seed in range(3))


@pytest.mark.parametrize(
    ("axis", "coefficients"), [("lon", ("CN", "CA", "Cm")), ("lat", ("CY", "Cl", "Cn"))]
)
def test_a_linear_aircraft_needs_no_more(axis, coefficients):
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
    found = select_terms(flown("lon", ""), "Cm", keep_linear=False)
    assert {"Cm_alpha", "Cm_q", "Cm_de"} <= set(found.values)
    assert found.steps[0].action == "added"


def test_the_pool_holds_no_term_twice():
    pool = candidate_terms("Cm", load_aircraft("b777"))
    assert {"Cm_alpha", "aero.Cm.alpha2", "aero.Cm.alpha_de", "unnamed.Cm.de2"} <= set(pool)
    # One id for one term: what the search calls it.
    searched = unnamed_ids(throttle=False, flap=False)
    assert {"unnamed.Cm.q2", "unnamed.Cm.q_de"} <= set(pool) & set(searched)
    assert "unnamed.Cm.alpha2" not in pool
    assert "aero.Cm.memory" not in pool


def test_an_alpha_derivative_beside_other_terms_in_alpha_is_no_slope() -> None:
    """Proves that Cm_alpha > 0 at zero is no alarm where alpha^2 or a stall goes with it."""
    values = {"Cm_0": (0.0, 0.1), "Cm_alpha": (0.4, 0.01), "Cm_q": (-20.0, 1.0)}
    for beside, judged in (
        ("aero.Cm.alpha2", False),
        ("aero.Cm.stall", False),
        ("aero.Cm.speed", True),
    ):
        found = TermSelection(
            coefficient="Cm", values={**values, beside: (-1.0, 0.1)}, steps=(), unexcited=(),
            r2=0.9, shapes={},
        )  # fmt: skip
        assert ("Cm_alpha" in found.slopes) == judged
        assert "Cm_q" in found.slopes
