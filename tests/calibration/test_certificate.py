"""Certificates: the curve and its inverse, the fit, the files and their mistakes."""

import datetime as dt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration import (
    CalibrationPoint,
    Certificate,
    load_certificate,
    load_certificates,
    shipped_certificate_sets,
    write_certificate,
)
from calibration.curve_selection import create_certificate, fit_calibration
from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.quantities import INSTRUMENTS

DEG = np.pi / 180.0
STAMP = dt.datetime(2003, 5, 14, 8, 30)  # noqa: DTZ001 - a field's local time


def curve(degree: int, falling: bool = False) -> Certificate:
    volts = np.linspace(0.4, 4.6, 9)
    shape = (-50 + 20 * volts, 0.8 * volts**2, 0.15 * volts**3)
    values = sum(shape[:degree]) * (-1.0 if falling else 1.0)
    points = [CalibrationPoint(volts=v, value=x) for v, x in zip(volts, values, strict=True)]
    return create_certificate(
        fit_calibration(points, degree=degree), points, channel_id="alpha", unit="deg", who="test",
        stamp=STAMP, excitation_voltage=5.0, ratiometric=True,
    )  # fmt: skip


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("falling", [False, True])
@given(volts=st.lists(st.floats(-1.0, 6.0), min_size=1, max_size=20))
@settings(max_examples=25, deadline=None)
def test_the_inverse_gives_the_volts_back(degree: int, falling: bool, volts: list[float]) -> None:
    certificate = curve(degree, falling)
    back = certificate.volts(certificate.evaluate(volts))
    np.testing.assert_allclose(back, volts, atol=1e-9, rtol=0)


@pytest.mark.parametrize("channel_id", INSTRUMENTS)
def test_shipped_certificates_invert(channel_id: str) -> None:
    certificate = load_certificates("b777")[channel_id]
    volts = np.linspace(0.0, 5.0, 4096)
    np.testing.assert_allclose(certificate.volts(certificate.evaluate(volts)), volts, atol=1e-9)
    steps = np.diff(certificate.evaluate(volts))
    assert np.all(steps > 0) or np.all(steps < 0)
    assert certificate.stamp.microsecond == 0


def test_the_shipped_set_is_the_whole_box() -> None:
    assert set(load_certificates("b777")) == set(INSTRUMENTS)
    assert "b777" in shipped_certificate_sets()


def test_source_facts() -> None:
    """Gyros, accelerometers and transducers follow the source's figures (section 3.5)."""
    box = load_certificates("b777")
    for rate in "pqr":
        np.testing.assert_allclose(box[rate].evaluate([0.5, 2.5, 4.5]), [-90 * DEG, 0, 90 * DEG],
                                   atol=1e-12)  # fmt: skip
    for axis, zero, per_g in (("ax", 2.556, 0.510), ("ay", 2.546, 0.511), ("an", 2.534, 0.497)):
        np.testing.assert_allclose(box[axis].volts([0.0, 9.80665]), [zero, zero + per_g])
    np.testing.assert_allclose(box["static_pressure"].evaluate(4.75), 15 * 6894.757, rtol=1e-6)
    np.testing.assert_allclose(box["dynamic_pressure"].evaluate(4.75), 10 * 249.089, rtol=1e-4)
    np.testing.assert_allclose(
        box["temperature"].evaluate(box["temperature"].volts(293.15)), 293.15
    )


def test_surfaces_show_hysteresis() -> None:
    certificate = load_certificates("b777")["elevator_left"]
    assert {point.direction for point in certificate.points} == {"up", "down"}
    assert 0.2 < certificate.hysteresis < 1.0
    assert certificate.unit == "deg"
    assert certificate.ratiometric


def test_a_fit_knows_its_hysteresis_and_residuals() -> None:
    """Branches 0.6 deg apart around a straight line: the line comes out, and 0.6 as the width."""
    volts = np.linspace(1, 4, 7)
    points = [
        CalibrationPoint(volts=v, value=10 * v + shift, direction=direction)
        for direction, shift in (("up", 0.3), ("down", -0.3))
        for v in volts
    ]
    fit = fit_calibration(points, degree=1).fit
    np.testing.assert_allclose(fit.coefficients, [0, 10], atol=1e-12)
    assert fit.hysteresis == pytest.approx(0.6)
    assert fit.max_residual == pytest.approx(0.3)
    assert fit.rms == pytest.approx(0.3 * np.sqrt(14 / 12))


def test_extrapolation_is_flagged_and_straight() -> None:
    certificate = curve(3)
    low, high = certificate.range
    volts = np.array([low - 0.2, low, 2.0, high, high + 0.1, high + 0.2, np.nan])
    assert certificate.extrapolated(volts).tolist() == [
        True,
        False,
        False,
        False,
        True,
        True,
        False,
    ]
    values = certificate.evaluate(volts)
    assert values[5] - values[4] == pytest.approx(values[4] - values[3])
    assert np.isnan(values[6])


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("falling", [False, True])
def test_a_curve_knows_between_which_values_it_was_drawn(degree: int, falling: bool) -> None:
    certificate = curve(degree, falling)
    assert certificate.degree == degree
    low, high = certificate.value_range
    assert low < high
    assert {low, high} == set(certificate.evaluate(certificate.range).tolist())
    room = 1e-6 * (high - low)
    assert certificate.padded_value_range == pytest.approx((low - room, high + room), rel=1e-9)
    least = 0.5 * room
    values = [low - 1e-3 * (high - low), low - least, 0.5 * (low + high), high + least,
              high + 1e-3 * (high - low), np.nan]  # fmt: skip
    assert certificate.out_of_range(values).tolist() == [True, False, False, False, True, False]


def test_a_supply_that_sagged_is_corrected() -> None:
    certificate = curve(2)
    value = 3.0 * DEG
    volts = certificate.volts(value)
    assert certificate.volts(value, 4.8) == pytest.approx(volts * 0.96)
    assert certificate.evaluate(volts * 0.96, 4.8) == pytest.approx(value)
    # A dead or absurd reading of the supply must not bend the channel.
    for bad in (0.0, 40.0, np.nan):
        assert certificate.evaluate(volts, bad) == pytest.approx(value)


@pytest.mark.parametrize("channel_id", ["elevator_left", "q", "temperature", "throttle"])
def test_a_written_certificate_reads_back_exactly(channel_id: str, tmp_path: Path) -> None:
    original = load_certificates("b777")[channel_id]
    again = load_certificate(write_certificate(original, tmp_path / "c.toml"))
    for name in (
        "channel", "unit", "coefficients", "range", "points", "stamp", "who", "temperature",
        "excitation_voltage", "ratiometric", "instrument", "notes", "si_coefficients",
    ):  # fmt: skip
        assert getattr(again, name) == getattr(original, name), name


GOOD = """
channel = "rudder"
unit = "deg"
who = "crew"
stamp = 2003-05-14T08:31:00
[fit]
coefficients = ["-50 deg", "20 deg/V"]
range = ["1 V", "4 V"]
[[points]]
volts = "1000 mV"
value = "-0.5235987755982988 rad"
direction = "up"
"""


def test_points_may_use_any_unit_of_the_channel(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text(GOOD)
    point = load_certificate(path).points[0]
    assert point.volts == 1.0
    assert point.value == pytest.approx(-30.0)


@pytest.mark.parametrize(
    ("old", "new", "where", "words"),
    [
        ('"rudder"', '"ruder"', "channel", "rudder"),
        ('unit = "deg"', 'unit = "psi"', "unit", "angle"),
        ("20 deg/V", "20 deg", "fit.coefficients[1]", "deg/V"),
        ("20 deg/V", "0 deg/V", "fit.coefficients", "flat"),
        ('"1 V", "4 V"', '"4 V", "1 V"', "fit.range", "swap"),
        ('"1 V", "4 V"', '"2 V", "4 V"', "points[0].volts", "outside"),
        ("rad", "psi", "points[0].value", "psi"),
        ('"up"', '"left"', "points[0].direction", "up"),
        ("08:31:00", "08:31:00.5", "stamp", "second"),
        ("[fit]", "ratiometric = true\n[fit]", "excitation_voltage", "supply"),
        ("who", "whom", "whom", "who"),
    ],
)
def test_every_mistake_has_a_place_and_a_remedy(
    tmp_path: Path, old: str, new: str, where: str, words: str
) -> None:
    path = tmp_path / "c.toml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(FileProblemsError) as caught:
        load_certificate(path)
    problem = {p.where: p for p in caught.value.problems}[where]
    assert words in f"{problem.what} {problem.remedy}"


def test_folders(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="b777"):
        load_certificates("nowhere")
    with pytest.raises(UnknownNameError, match="no calibration certificate"):
        load_certificates(tmp_path)
    (tmp_path / "a.toml").write_text(GOOD)
    assert set(load_certificates(tmp_path)) == {"rudder"}
    (tmp_path / "b.toml").write_text(GOOD)
    with pytest.raises(FileProblemsError, match=r"a\.toml"):
        load_certificates(tmp_path)
