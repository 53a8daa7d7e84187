"""Bounds that allow for what the aircraft file does not know well."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.aircraft import Accuracy, load_aircraft
from gsapp.dynamics.signal_terms import apply_lag
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.record_preparation import interpolate_air_data
from gsapp.identification.results import Estimate
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import Virtual, edited, every_tenth_sample, fly

EXACT = load_aircraft("b777").accuracy


@pytest.fixture(scope="module")
def lateral() -> Virtual:
    return fly(21, "lat")


def _with(maneuver: Maneuver, **accuracy: float | str) -> Maneuver:
    """Return a maneuver of an aircraft that is known exactly but for what is named."""
    stated = EXACT.model_copy(
        update={name: getattr(Accuracy(**{name: std}), name) for name, std in accuracy.items()}
    )
    return replace(maneuver, aircraft=maneuver.aircraft.model_copy(update={"accuracy": stated}))


def _estimate(maneuver: Maneuver, method: str) -> Estimate:
    (result,) = run_campaign([maneuver], CampaignSettings(method=method)).results
    assert result.estimate is not None
    return result.estimate


@pytest.mark.parametrize("method", ["ee", "ml", "ftr"])
def test_an_uncertain_mass_scales_the_forces_alone(lateral: Virtual, method: str) -> None:
    """Side force is mass times acceleration; moments rest on the inertia."""
    plain = _estimate(lateral.maneuver, method)
    wide = _estimate(_with(lateral.maneuver, mass=0.03), method)
    for name in ("CY_beta", "CY_dr"):
        one, other = plain.derivatives[name], wide.derivatives[name]
        assert other.value == one.value
        assert other.offset == pytest.approx(0.03 * abs(one.value), rel=0.2)
        assert other.std == pytest.approx(np.hypot(one.std, other.offset), rel=1e-9)
    said = [one for one in wide.warnings if "mass" in one and "CY_beta" in one]
    assert bool(said) == (wide.derivatives["CY_beta"].offset > plain.derivatives["CY_beta"].std)
    assert wide.derivatives["Cl_da"].std == pytest.approx(plain.derivatives["Cl_da"].std, rel=0.02)


@pytest.mark.parametrize("method", ["ee", "ml"])
def test_bounds_hold_where_a_gyro_is_late(lateral: Virtual, method: str) -> None:
    """A lag of 30 ms in the roll rate halves no derivative without the bound saying so."""
    late = edited(lateral.maneuver, p=lambda samples: apply_lag(samples, 0.03, 0.01))
    true = lateral.truth["Cl_p"]
    trusting = _estimate(late, method).derivatives["Cl_p"]
    allowing = _estimate(_with(late, delay="15 ms"), method).derivatives["Cl_p"]
    assert abs(trusting.value - true) > 5.0 * trusting.std
    assert abs(allowing.value - true) < 3.0 * allowing.std


def test_the_common_part_does_not_shrink_in_a_mean(lateral: Virtual) -> None:
    maneuver = _with(lateral.maneuver, mass=0.05)
    others = [replace(maneuver, id=str(number)) for number in range(4)]
    found = run_campaign(others, CampaignSettings(method="ee")).values["CY_beta"]
    assert found.std > 0.05 * abs(found.mean)


def test_what_a_file_does_not_state_is_typical(lateral: Virtual) -> None:
    """Bounds allow for it, and it is said; the virtual aircraft is known exactly."""
    aircraft = load_aircraft("b777")
    assert aircraft.states_accuracy
    assert not any(EXACT.model_dump().values())
    silent = aircraft.model_copy(update={"accuracy": Accuracy()})
    silent.model_fields_set.discard("accuracy")
    maneuver = replace(lateral.maneuver, aircraft=silent)
    exact, typical = (
        run_campaign([one], CampaignSettings(method="ee")) for one in (lateral.maneuver, maneuver)
    )
    assert len(typical.remarks) == len(exact.remarks) + 1
    for name, one in exact.values.items():
        other = typical.values[name]
        assert other.mean == one.mean
        assert other.std > one.std
        assert other.noise == pytest.approx(one.noise)


def test_filter_error_allows_for_what_maximum_likelihood_does() -> None:
    """It takes too long to be repeated; what a late gyro does is much the same."""
    flown = fly(23, "lat", gust=0.3)
    maneuver = _with(flown.maneuver, delay="15 ms")
    (result,) = run_campaign([maneuver], CampaignSettings()).results
    assert result.estimate is not None
    assert result.estimate.method == "fem"
    calm = result.comparisons["ml"]
    for name in ("Cl_p", "Cl_da"):
        shared = result.estimate.derivatives[name].offset
        assert shared == calm.derivatives[name].offset > 0.0


def test_air_data_in_bursts_are_bridged() -> None:
    """Up to half a second; what changes quickly is left as it came."""
    times = np.arange(400) * 0.01
    speed = 30.0 + times
    seen = (np.arange(400) % 25 < 5) & ~((times > 2.0) & (times < 3.0))
    values = np.column_stack([np.where(seen, speed, np.nan), np.where(seen, times, np.nan)])
    found = interpolate_air_data(Block(channels=("V", "alpha"), times=times, values=values))
    assert np.allclose(found["V"][:200], speed[:200])
    assert np.isnan(found["V"][(times > 2.05) & (times < 2.95)]).all()
    assert np.array_equal(found["alpha"], values[:, 1], equal_nan=True)


def test_bounds_allow_for_steps_between_slow_samples() -> None:
    """A doublet of 0.3 s at 10 samples a second: each edge is known to a tenth of its width."""
    allowing, trusting = [], []
    for seed in range(56000, 56008):
        virtual = fly(seed, "lon", duration=8.0)
        found = _estimate(every_tenth_sample(virtual.maneuver), "ml").derivatives["Cm_de"]
        error = found.value - virtual.truth["Cm_de"]
        assert found.offset == 0.0  # Another maneuver has other instants.
        allowing.append(error / found.std)
        trusting.append(error / found.cramer_rao)
    assert np.sqrt(np.mean(np.square(allowing))) < 1.5
    assert np.sqrt(np.mean(np.square(trusting))) > 1.8
