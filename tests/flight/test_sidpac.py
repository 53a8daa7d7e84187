"""Flights for SIDPAC: columns, units and signs of the array fdata, written and read."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

import gsapp
from gsapp.aircraft import load_aircraft
from gsapp.flight.sidpac import write_sidpac
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from tests.cli.command_kit import gsapp as command

CHANNELS = ("V", "alpha", "q", "an", "de", "da", "qbar", "density", "throttle")


@pytest.fixture
def block():
    rng = np.random.default_rng(3)
    values = rng.normal(0.1, 0.02, (400, len(CHANNELS)))
    values[:, 0] += 30.0
    values[:, 3] += 9.8
    values[:, 6:8] += (560.0, 1.1)
    return Block(channels=CHANNELS, times=10.0 + np.arange(400) / 100.0, values=values)


def test_columns_have_the_units_and_signs_of_sidpac(tmp_path, block):
    aircraft = load_aircraft("b777")
    content = loadmat(write_sidpac(tmp_path / "f.mat", block, aircraft))
    fdata = content["fdata"]
    assert fdata.shape == (400, 90)
    np.testing.assert_allclose(content["t"][:, 0], np.arange(400) / 100.0, atol=1e-9)
    column = {number: fdata[:, number - 1] for number in range(1, 91)}  # as MATLAB counts
    np.testing.assert_allclose(column[1], block.times)
    np.testing.assert_allclose(column[2], block["V"] / 0.3048)
    np.testing.assert_allclose(column[4], np.degrees(block["alpha"]))
    np.testing.assert_allclose(column[6], np.degrees(block["q"]))
    np.testing.assert_allclose(column[13], -block["an"] / 9.80665)
    np.testing.assert_allclose(column[14], np.degrees(block["de"]))
    np.testing.assert_allclose(column[15], -np.degrees(block["da"]))
    np.testing.assert_allclose(column[27], block["qbar"] / 47.880258980)
    np.testing.assert_allclose(column[29], block["density"] / 515.378819, rtol=1e-6)
    np.testing.assert_allclose(column[48], aircraft.mass.mass / 14.59390294)
    np.testing.assert_allclose(column[50], aircraft.mass.iyy / 1.355817948)
    np.testing.assert_allclose(column[77], aircraft.geometry.wing_area / 0.3048**2)
    assert not any(column[number].any() for number in (3, 8, 16, 30, 38, 61))


def test_force_coefficients_by_its_columns_are_those_of_the_aircraft(tmp_path, block):
    """CZ = mass g a_z / (qbar S), as SIDPAC computes it from fdata."""
    aircraft = load_aircraft("b777")
    fdata = loadmat(write_sidpac(tmp_path / "f.mat", block, aircraft))["fdata"]
    CZ = 32.174 * fdata[:, 47] * fdata[:, 12] / (fdata[:, 26] * fdata[:, 76])
    own = -aircraft.mass.mass * block["an"] / (block["qbar"] * aircraft.geometry.wing_area)
    np.testing.assert_allclose(CZ, own, rtol=2e-5)


def test_the_command_writes_what_the_map_reads(tmp_path, block):
    gsapp.export(write_csv(tmp_path, block), tmp_path / "f.mat", to="sidpac")
    done = command(
        "export", tmp_path / "f.csv", "--to", "sidpac", "--out", tmp_path / "g.mat",
        "--aircraft", "b777",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert loadmat(tmp_path / "g.mat")["fdata"][0, 76] > 0.0
    for name in ("f.mat", "g.mat"):
        flight = gsapp.open(tmp_path / name, channel_map="sidpac")
        np.testing.assert_allclose(
            flight.to_numpy(CHANNELS, "base"), block.values, rtol=1e-9, atol=1e-9
        )
        np.testing.assert_allclose(flight.block.times, block.times, atol=1e-9)
        # Derived, but never the zeros of what was not measured.
        assert set(flight.block.channels) - {"Vc", "mass"} == set(CHANNELS)


def write_csv(tmp_path, block):
    from gsapp.flight.writers import write_flight_csv

    return write_flight_csv(tmp_path / "f.csv", block, "base")


def test_a_record_with_pauses_is_refused(tmp_path, block):
    times = np.where(np.arange(400) < 200, block.times, block.times + 5.0)
    with pytest.raises(FlightError, match="cut"):
        write_sidpac(tmp_path / "f.mat", Block(channels=CHANNELS, times=times, values=block.values))
    assert not (tmp_path / "f.mat").exists()


def test_an_array_with_too_few_columns_is_named(tmp_path):
    savemat(tmp_path / "old.mat", {"fdata": np.ones((100, 20)).cumsum(0)})
    with pytest.raises(ValueError, match=r"fdata\[26\].*\(100, 20\)"):
        gsapp.open(tmp_path / "old.mat", channel_map="sidpac")
