"""Filter error: honest values in turbulence, those of output error in calm air."""

import numpy as np
import pytest

from gsapp.identification.filter_error.estimator import estimate
from gsapp.identification.maximum_likelihood import MLSettings
from gsapp.identification.maximum_likelihood import estimate as by_output_error
from gsapp.identification.results import Estimate
from tests.identification.virtual_maneuvers import AXES, Virtual, fly


def errors_over_bounds(found: Estimate, virtual: Virtual) -> np.ndarray:
    return np.array(
        [
            (one.value - virtual.truth[name]) / one.std
            for name, one in found.derivatives.items()
            if one.value is not None and one.std
        ]
    )


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_turbulence_errors_are_within_bounds_that_output_error_cannot_reach(kind: str) -> None:
    ratios = []
    for seed in (31, 32, 33):
        virtual = fly(seed, kind, gust=1.0, dt=0.02)
        settings = MLSettings(axis=AXES[kind])
        found = estimate([virtual.maneuver], settings)
        assert found.converged
        assert found.method == "fem"
        ratios.append(errors_over_bounds(found, virtual))
        plain = by_output_error([virtual.maneuver], settings)
        narrower = [
            one.std / plain.derivatives[name].std
            for name, one in found.derivatives.items()
            if one.std and plain.derivatives[name].std
        ]
        assert np.median(narrower) < 0.4
    together = np.concatenate(ratios)
    assert np.sqrt(np.mean(together**2)) < 1.5
    assert np.abs(together).max() < 4.5


def test_air_that_gusts_turn_is_told_from_air_that_does_not_turn() -> None:
    """Taken for air that does not turn, CN_alpha would be off by 18 bounds."""
    virtual = fly(4002, "lon", gust=1.0, dt=0.02, rotating=True)
    found = estimate([virtual.maneuver], MLSettings(axis="lon"))
    assert found.converged
    assert np.abs(errors_over_bounds(found, virtual)).max() < 3.5


def test_a_start_far_from_the_truth_leads_to_it() -> None:
    """Equation error begins with an unstable aircraft; values ended up to 20 bounds off."""
    virtual = fly(61005, "lon", gust=1.0, rotating=True)
    found = estimate([virtual.maneuver], MLSettings(axis="lon"))
    assert found.converged
    assert np.abs(errors_over_bounds(found, virtual)).max() < 3.0


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_in_calm_air_it_is_output_error(kind: str) -> None:
    virtual = fly(31, kind, dt=0.02)
    settings = MLSettings(axis=AXES[kind])
    found, plain = (one([virtual.maneuver], settings) for one in (estimate, by_output_error))
    for name in found.free:
        one, other = found.derivatives[name], plain.derivatives[name]
        assert one.std == pytest.approx(other.std, rel=0.5)
        assert abs(one.value - other.value) < 1.0 * other.std, name


def test_turbulence_is_reported_with_its_size() -> None:
    virtual = fly(31, "lon", gust=1.0, dt=0.02)
    found = estimate([virtual.maneuver], MLSettings(axis="lon"))
    (text,) = [one for one in found.warnings if "turbulence" in one]
    size = float(text.partition(": ")[2].split()[0])
    assert size == pytest.approx(1.0, rel=0.4)
