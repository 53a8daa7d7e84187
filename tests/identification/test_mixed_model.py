"""The mixed model recovers what fleets were made of over many seeds; statsmodels agrees."""

import warnings

import numpy as np
import pytest

from gsapp.foundation import FlightError
from gsapp.identification.fleet.mixed_model import fit_mixed_model
from tests.identification.fleet_kit import CENTER, SLOPE, VALUE, make_fleet

SEEDS = range(1000, 1060)


def fit(fleet):
    return fit_mixed_model(
        fleet.values, fleet.stds, {"mach": fleet.mach}, fleet.airframes, fleet.flights
    )


def test_intervals_cover_the_truth_and_spreads_are_found() -> None:
    """Of 60 fleets; 95 % intervals cover in 53 or more with a chance of 0.998."""
    covered, spreads, own = np.zeros(2), [], []
    for seed in SEEDS:
        fleet = make_fleet(seed)
        found = fit(fleet)
        assert found.converged
        truth = VALUE + SLOPE * (found.reference["mach"] - CENTER)
        slope = found.slopes["mach"]
        covered += (
            found.intercept.low <= truth <= found.intercept.high,
            slope.low <= SLOPE <= slope.high,
        )
        spreads.append((found.intercept_std, found.slope_std, found.flight_std, found.residual_std))
        for name, line in found.groups.items():
            a, b = fleet.own[name]
            right = truth + a + b * (found.reference["mach"] - CENTER)
            own.append((line.intercept - right) / line.intercept_std)
            own.append((line.slope - SLOPE - b) / line.slope_std)
    assert (covered >= 53).all()
    middle = np.median(spreads, axis=0)
    np.testing.assert_allclose(middle, (0.05, 0.4, 0.02, 0.01), rtol=0.25)
    # A group's own line does not count that the spreads are estimates themselves.
    assert 0.85 < np.sqrt(np.mean(np.square(own))) < 1.2


def test_one_flight_with_many_maneuvers_does_not_narrow_the_bound() -> None:
    """What a flight has in common stays in the bound, whatever number of maneuvers it has."""
    few = fit(make_fleet(7, airframes=1, flights=12, maneuvers=2, of_airframes=(0.0, 0.0)))
    many = fit(make_fleet(7, airframes=1, flights=12, maneuvers=40, of_airframes=(0.0, 0.0)))
    assert many.flight_std == pytest.approx(0.02, rel=0.5)
    assert many.intercept.std > 0.7 * many.flight_std / np.sqrt(12)
    assert few.intercept_std == many.intercept_std == 0.0
    assert many.intercept.freedom < 12


def test_a_condition_that_each_airframe_has_only_once_counts_airframes() -> None:
    """The loading differs between airframes alone: the slope has as many values as airframes."""
    covered = 0
    for seed in SEEDS:
        fleet = make_fleet(seed, airframes=8, of_airframes=(0.05, 0.0))
        random = np.random.default_rng(seed)
        loading = dict(zip(dict.fromkeys(fleet.airframes), random.uniform(0, 1, 8), strict=True))
        x = np.array([loading[name] for name in fleet.airframes])
        values = fleet.values - SLOPE * (fleet.mach - CENTER)
        found = fit_mixed_model(values, fleet.stds, {"x": x}, fleet.airframes, fleet.flights)
        assert found.slopes["x"].freedom == 6
        assert found.slope_std is None
        covered += found.slopes["x"].low <= 0.0 <= found.slopes["x"].high
    assert covered >= 53


def test_two_airframes_have_one_slope() -> None:
    found = fit(make_fleet(3, airframes=2))
    assert found.slope_std is None
    assert found.groups["SN 0"].slope == found.groups["SN 1"].slope
    assert found.intercept.freedom == 1


@pytest.mark.parametrize("seed", range(2000, 2006))
def test_it_agrees_with_statsmodels(seed: int) -> None:
    """Without bounds and flights both fit the same model."""
    formula = pytest.importorskip(
        "statsmodels.regression.mixed_linear_model", reason="statsmodels is not installed"
    )
    fleet = make_fleet(seed, bound=0.0, of_flights=0.0, of_maneuvers=0.03)
    count = len(fleet.values)
    own = fit_mixed_model(
        fleet.values, np.zeros(count), {"mach": fleet.mach}, fleet.airframes,
        [str(place) for place in range(count)],
    )  # fmt: skip
    design = np.column_stack([np.ones(count), fleet.mach - fleet.mach.mean()])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = formula.MixedLM(fleet.values, design, groups=fleet.airframes, exog_re=design).fit(
            reml=True, method=["lbfgs", "powell"]
        )
    assert own.log_likelihood == pytest.approx(other.llf, abs=1e-3)
    effects = (own.intercept, own.slopes["mach"])
    assert [one.value for one in effects] == pytest.approx(list(other.fe_params), rel=1e-3)
    assert [one.std for one in effects] == pytest.approx(list(other.bse_fe), rel=1e-2)
    assert own.residual_std == pytest.approx(np.sqrt(other.scale), rel=1e-3)
    for name, line in own.groups.items():
        mine = (line.intercept - own.intercept.value, line.slope - own.slopes["mach"].value)
        assert mine == pytest.approx(list(other.random_effects[name]), abs=1e-3)


def test_a_constant_condition_and_too_few_values_are_named() -> None:
    fleet = make_fleet(1)
    one = np.ones(len(fleet.values))
    with pytest.raises(FlightError, match="the same in all"):
        fit_mixed_model(fleet.values, fleet.stds, {"V": one}, fleet.airframes, fleet.flights)
    both = {"mach": fleet.mach, "V": 340.0 * fleet.mach}
    with pytest.raises(FlightError, match="change together"):
        fit_mixed_model(fleet.values, fleet.stds, both, fleet.airframes, fleet.flights)
    with pytest.raises(FlightError, match="too few"):
        fit_mixed_model(
            fleet.values[:3], fleet.stds[:3], {"mach": fleet.mach[:3]}, fleet.airframes[:3],
            fleet.flights[:3],
        )  # fmt: skip
