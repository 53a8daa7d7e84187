"""Maneuvers that hold too little, or lie: each gets its own clear answer, no unearned number."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import edited, fly

BASE = load_model("b777")


def lost(samples):
    return np.full_like(samples, np.nan)


@pytest.fixture(scope="module")
def lon():
    return fly(1, "lon", model=BASE)


@pytest.fixture(scope="module")
def lat():
    return fly(2, "lat", model=BASE)


def test_no_maneuver():
    with pytest.raises(FlightError, match="no maneuver"):
        estimate([], MLSettings(axis="lon"))


def test_ten_samples(lon):
    block = lon.maneuver.block
    short = Block(channels=block.channels, times=block.times[:10], values=block.values[:10])
    with pytest.raises(FlightError, match=r"10 samples.*widen"):
        estimate([replace(lon.maneuver, block=short)], MLSettings(axis="lon"))


def test_fewer_samples_than_unknowns_ask_for(lon):
    block = lon.maneuver.block
    short = Block(channels=block.channels, times=block.times[:275:5], values=block.values[:275:5])
    with pytest.raises(FlightError, match="15 unknowns"):
        estimate([replace(lon.maneuver, block=short)], MLSettings(axis="lon"))


def test_nothing_measured(lon):
    dead = edited(lon.maneuver, alpha=lost, q=lost, an=lost, ax=lost)
    with pytest.raises(FlightError, match="alpha"):
        estimate([dead], MLSettings(axis="lon"))


@pytest.mark.parametrize("mass", [0.0, -3.0, float("nan")])
def test_no_mass(lon, mass):
    with pytest.raises(FlightError, match="mass of"):
        estimate([replace(lon.maneuver, mass=mass)], MLSettings(axis="lon"))


def test_input_missing_wherever_it_matters(lon):
    def holes(samples):
        samples[np.arange(samples.size) % 40 < 20] = np.nan
        return samples

    with pytest.raises(FlightError, match="no stretch"):
        estimate([edited(lon.maneuver, de=holes)], MLSettings(axis="lon"))


def test_a_stuck_response_is_left_out_and_named(lon):
    found = estimate([edited(lon.maneuver, ax=lambda x: 0.0 * x + 0.3)], MLSettings(axis="lon"))
    assert "ax" not in found.fit
    assert any("ax stays at 0.3" in warning for warning in found.warnings)
    assert found.value("Cm_alpha") == pytest.approx(BASE.derivative("Cm_alpha"), rel=0.1)


def test_a_stuck_surface_gives_no_control_derivative(lat):
    found = estimate([edited(lat.maneuver, dr=lambda x: 0.0 * x + 0.01)], MLSettings(axis="lat"))
    for name in ("CY_dr", "Cl_dr", "Cn_dr"):
        assert found.derivatives[name].status == "unknown"
        assert found.derivatives[name].value is None
        assert "dr does not" in found.derivatives[name].why


def test_a_surface_that_shows_only_noise_has_not_moved(lat):
    noise = 0.05 * np.pi / 180.0 * np.random.default_rng(3).standard_normal(len(lat.maneuver.block))
    found = estimate([edited(lat.maneuver, dr=lambda _: 0.02 + noise)], MLSettings(axis="lat"))
    assert found.derivatives["Cn_dr"].status == "unknown"


def test_a_surface_that_was_not_measured(lat):
    found = estimate([edited(lat.maneuver, dr=lost)], MLSettings(axis="lat"))
    assert found.derivatives["Cn_dr"].value is None
    assert "not measured" in found.derivatives["Cn_dr"].why


def test_surfaces_that_move_as_one_are_not_told_apart(lat):
    linked = edited(lat.maneuver, da=lambda _: 2.0 * lat.maneuver.block["dr"])
    found = estimate([linked], MLSettings(axis="lat"))
    for name, other in (("Cn_da", "Cn_dr"), ("Cl_dr", "Cl_da")):
        assert found.derivatives[name].value is None
        assert found.derivatives[name].status == "not-identifiable"
        assert other in found.derivatives[name].confounded_with


def test_nothing_moves():
    still = fly(5, "lon", model=BASE, noise=1.0)
    quiet = 0.002 * np.random.default_rng(1).standard_normal((4, len(still.maneuver.block)))
    flat = edited(
        still.maneuver,
        de=lambda x: 0.0 * x - 0.01,
        alpha=lambda x: 0.0 * x + 0.06 + quiet[0],
        q=lambda x: 0.0 * x + quiet[1],
        an=lambda x: 0.0 * x + 9.8 + 10.0 * quiet[2],
        ax=lambda x: 0.0 * x + 0.5 + 10.0 * quiet[3],
        theta=lambda x: 0.0 * x + 0.06,
        V=lambda x: 0.0 * x + 30.0,
    )
    found = estimate([flat], MLSettings(axis="lon"))
    slopes = [name for name in found.free if not name.endswith("_0")]
    assert slopes == []


@pytest.mark.parametrize(
    ("channel", "words"), [("de", "elevator"), ("q", "pitch rate"), ("alpha", "angle of attack")]
)
def test_a_reversed_channel_is_named(lon, channel, words):
    found = estimate([edited(lon.maneuver, **{channel: lambda x: -x})], MLSettings(axis="lon"))
    signs = [warning for warning in found.warnings if "sign" in warning]
    assert signs
    assert words in signs[0]


def test_an_absurd_start_does_not_end_the_fit(lon):
    """A start that diverges is replaced by equation error's."""
    absurd = {"Cm_alpha": 3.0, "Cm_q": 30.0}
    found = estimate([lon.maneuver], MLSettings(axis="lon", start=absurd))
    assert found.converged
    assert found.value("Cm_alpha") == pytest.approx(BASE.derivative("Cm_alpha"), rel=0.05)


def test_a_model_that_diverges_says_so(lon):
    held = {"Cm_alpha": 30.0, "Cm_q": 60.0}
    with pytest.raises(FlightError, match="maneuver 1"):
        estimate([lon.maneuver], MLSettings(axis="lon", held=held))
