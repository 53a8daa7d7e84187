"""What is said of a calibration: figures known by hand, kept in the file and read back."""

import datetime as dt
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibration import (
    CalibrationPoint,
    Certificate,
    load_certificate,
    load_certificates,
    write_certificate,
)
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.polynomial_fit import CalibrationReadings, fit_with_hysteresis
from calibration.quality import compute_half_widths, linearity
from gsapp.foundation import FileProblemsError
from gsapp.quantities.constants import DEGREE
from tests.calibration.potentiometer_kit import quick_sweep

STAMP = dt.datetime(2026, 5, 12, 8, 31)  # noqa: DTZ001 - a field's local time


def certificate(seed: int = 1, **more: object) -> Certificate:
    points = quick_sweep(seed, "elevator_left").points()
    made = fit_calibration(points, travel=(-25.0, 25.0))
    return create_certificate(
        made, points, channel_id="elevator_left", unit="deg", who="crew", stamp=STAMP,
        excitation_voltage=5.0, ratiometric=True, **more,
    )  # fmt: skip


def test_linearity_is_the_distance_from_the_best_line() -> None:
    x = np.linspace(-1.0, 1.0, 201)
    assert linearity(3.0 * x + 7.0) == pytest.approx(0.0, abs=1e-9)
    assert linearity(5.0 * x + 1.0 - x**2) == pytest.approx(0.5, abs=1e-4)
    # Chebyshev: of all cubics with this leading part 4x^3 - 3x stays nearest to zero.
    assert linearity(4.0 * x**3 + 11.0 * x) == pytest.approx(1.0, abs=1e-3)


def test_resolution_coverage_and_return_to_zero_are_by_hand() -> None:
    """20 deg/V, 12 bits over 5 V, settings to 20 of 25 deg, and a loop of half a degree."""
    points = [
        CalibrationPoint(volts=(value + 50.0 - side * 0.25) / 20.0, value=value, direction=name)
        for side, name in ((1.0, "up"), (-1.0, "down"))
        for value in (-20.0, -10.0, 0.0, 10.0, 20.0)
    ]
    quality = fit_calibration(points, travel=(-25.0, 25.0)).quality
    assert quality.resolution == pytest.approx(20.0 * 5.0 / 4096)
    assert quality.coverage == pytest.approx(0.8)
    assert quality.covered == (-20.0, 20.0)
    assert quality.return_to_zero == pytest.approx(0.5)
    assert quality.hysteresis == pytest.approx(0.5)
    assert quality.linearity == pytest.approx(0.0, abs=1e-9)
    shifted = [replace(one, value=one.value + 5.0) for one in points]
    assert fit_calibration(shifted).quality.return_to_zero is None
    assert fit_calibration(shifted).quality.coverage is None


def test_the_half_width_holds_ninety_five_of_a_hundred_samples() -> None:
    """Drawn from what it is made of (either branch, scatter by Student), 95 % lie within."""
    random = np.random.default_rng(3)
    for seed in (1, 2, 3):
        readings = CalibrationReadings.from_points(quick_sweep(seed, "rudder").points())
        fit = fit_with_hysteresis(readings, 2)
        volts = np.array([float(np.mean(readings.volts))])
        width = compute_half_widths(fit, volts, 0.0)[0]
        std = np.sqrt(0.5 * (fit.variance(volts, 1.0) + fit.variance(volts, -1.0)))[0]
        errors = random.choice([-0.5, 0.5], 40000) * fit.hysteresis
        errors += std * random.standard_t(fit.degrees_of_freedom, 40000)
        assert np.mean(np.abs(errors) < width) == pytest.approx(0.95, abs=0.005)


def test_the_file_keeps_the_quality(tmp_path: Path) -> None:
    made = certificate(temperature=289.15)
    again = load_certificate(write_certificate(made, tmp_path / "c.toml"))
    assert made.quality is not None
    assert again.quality is not None
    for name in (
        "linearity", "scatter", "hysteresis", "hysteresis_uncertainty", "return_to_zero",
        "resolution", "covered", "travel", "uncertainty_volts", "half_widths", "coverage", "degree",
    ):  # fmt: skip
        assert getattr(again.quality, name) == pytest.approx(
            getattr(made.quality, name), rel=1e-5
        ), name
    assert again.points == tuple(
        replace(one, noise=float(f"{one.noise:.3g}")) for one in made.points
    )
    volts = np.array([*made.range, 2.4, made.range[0] - 0.01, made.range[1] + 0.01])
    widths = again.uncertainty(volts)
    assert np.isfinite(widths).tolist() == [True, True, True, False, False]
    np.testing.assert_allclose(widths, made.uncertainty(volts), rtol=1e-5)
    assert np.all(widths[:3] > 0.5 * made.quality.hysteresis * DEGREE)
    # Written a second time nothing changes any more.
    once = (tmp_path / "c.toml").read_text()
    assert write_certificate(again, tmp_path / "d.toml").read_text() == once


def test_a_supply_that_sagged_leaves_the_uncertainty_where_it_was() -> None:
    made = certificate()
    assert made.uncertainty(2.4 * 0.96, 4.8) == pytest.approx(float(made.uncertainty(2.4)))


def test_the_range_in_values_tells_what_is_extrapolated() -> None:
    """Values within `value_range` come from volts within the range, and no others."""
    for made in (certificate(), load_certificates("b777")["beta"]):
        low, high = made.value_range
        volts = np.linspace(0.0, 5.0, 501)
        values = made.evaluate(volts)
        np.testing.assert_array_equal(
            made.extrapolated(volts), (values < low - 1e-12) | (values > high + 1e-12)
        )


def test_older_files_load_and_claim_nothing() -> None:
    for made in load_certificates("b777").values():
        assert made.quality is None
        assert np.isnan(made.uncertainty(np.mean(made.range)))


@pytest.mark.parametrize(
    ("old", "new", "where", "words"),
    [
        ('"-25.0 deg", "25.0 deg"', '"25 deg", "-25 deg"', "quality.travel", "swap"),
        ('"-25.0 deg"', '"-25.0 psi"', "quality.travel[0]", "psi"),
        ("linearity", "linearty", "quality.linearty", "linearity"),
        ("half_width = [", 'half_width = ["1 V", ', "quality.uncertainty.half_width[0]", "deg"),
        (
            "half_width = [",
            'half_width = ["1 deg", ',
            "quality.uncertainty",
            "number of half widths",
        ),
        ("resolution", "# resolution", "quality.resolution", "missing"),
    ],
)
def test_mistakes_in_the_quality_have_a_place_and_a_remedy(
    tmp_path: Path, old: str, new: str, where: str, words: str
) -> None:
    path = write_certificate(certificate(), tmp_path / "c.toml")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FileProblemsError) as caught:
        load_certificate(path)
    problem = {p.where: p for p in caught.value.problems}[where]
    assert words in f"{problem.what} {problem.remedy}"


def test_numbers_of_arrays_are_written_as_numbers(tmp_path: Path) -> None:
    volts = np.linspace(1.0, 4.0, 5)
    points = [CalibrationPoint(volts=v, value=x) for v, x in zip(volts, 20 * volts, strict=True)]
    made = create_certificate(
        fit_calibration(points), points, channel_id="rudder", unit="deg", who="crew", stamp=STAMP
    )
    assert load_certificate(write_certificate(made, tmp_path / "c.toml")).points[4].value == 80.0
