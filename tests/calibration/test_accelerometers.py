"""Accelerometers in six positions: zero, scale, misalignment, verdicts, certificates."""

import math
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from calibration import CalibrationError, load_certificate, write_certificate
from calibration.inertial.accelerometers import (
    ACCELEROMETERS,
    POSITIONS,
    PositionReading,
    SixPositionResult,
    calibrate_accelerometers,
    recognize_position,
    specific_force,
)
from calibration.inertial.straight_line import factory_calibrations
from calibration.rest_detection import RestPeriod
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY
from gsapp.virtual.bench import VirtualBench, parse_bench_fault
from tests.calibration.ground_crew import STAMP, six_work


def reading(position: str, volts: FloatArray) -> PositionReading:
    named = MappingProxyType(dict(zip(ACCELEROMETERS, volts.tolist(), strict=True)))
    small = MappingProxyType(dict.fromkeys(ACCELEROMETERS, 1e-4))
    at_rest = RestPeriod(start=0.0, end=5.0, volts=named, std=small, uncertainty=small)
    return PositionReading(position=position, rest=at_rest)


def exact(zero: FloatArray, matrix: FloatArray, tilts: FloatArray) -> list[PositionReading]:
    readings = []
    for position, (one, other) in zip(POSITIONS, np.radians(tilts), strict=True):
        force = np.array(list(specific_force(position).values()))
        axis = int(np.argmax(np.abs(force)))
        leaning = [index for index in range(3) if index != axis]
        force[axis] *= math.sqrt(1.0 - math.sin(one) ** 2 - math.sin(other) ** 2)
        force[leaning] = math.sin(one), math.sin(other)
        readings.append(reading(position, zero + matrix @ force))
    return readings


def nominal() -> tuple[FloatArray, FloatArray]:
    figures = [factory_calibrations()[name] for name in ACCELEROMETERS]
    return np.array([f.zero for f in figures]), np.diag([f.sensitivity for f in figures])


def test_the_factory_figures_are_those_of_the_source() -> None:
    """Zero-g volts and V/g of table 3.5.3."""
    figures = factory_calibrations()
    for name, zero, sensitivity in (
        ("ax", 2.556, 0.510),
        ("ay", 2.546, 0.511),
        ("an", 2.534, 0.497),
    ):
        assert figures[name].zero == pytest.approx(zero)
        assert figures[name].sensitivity == pytest.approx(sensitivity)


@pytest.mark.parametrize("seed", range(3))
def test_six_positions_on_the_bench_recover_the_truth(seed: int, tmp_path: Path) -> None:
    bench = VirtualBench(100 + seed)
    found = six_work(bench)
    assert not found.issue
    for index, name in enumerate(ACCELEROMETERS):
        fit, truth = found.fits[name], bench.accelerometers
        k = truth.matrix[index, index]
        assert abs(fit.zero - truth.zero[index]) < 2.0 * fit.zero_uncertainty
        assert abs(fit.sensitivity - k) < 2.0 * fit.sensitivity_uncertainty
        for other in fit.cross:
            lean = truth.matrix[index, ACCELEROMETERS.index(other)] / k
            error = fit.cross[other] - math.degrees(math.atan(lean))
            assert abs(error) < 2.0 * fit.cross_uncertainty[other]
        assert fit.zero_uncertainty < 0.003 * k, "better than 3 mg"
        assert fit.sensitivity_uncertainty < 0.005 * k
        certificate = found.certificate(name, who="crew", stamp=STAMP)
        read = load_certificate(write_certificate(certificate, tmp_path / f"{name}.toml"))
        forces = np.array([-3.0, 0.0, 1.0, 3.0])
        shown = read.evaluate(truth.zero[index] + k * forces) / GRAVITY
        bounds = read.uncertainty(truth.zero[index] + k * forces) / GRAVITY
        assert np.all(np.abs(shown - forces) < bounds)
        assert np.all(bounds < 0.02), "5 mg of noise and 0.1 % of scale"
        assert len(read.points) == 6


def test_tilt_does_not_reach_zero_and_scale() -> None:
    """An aircraft laid badly by 2 deg: zero to 1 mg, scale to 0.2 %; a plain fit errs by 10 mg."""
    zero, matrix = nominal()
    tilts = np.array([[2, 1], [-1, 2], [1.5, -2], [2, 2], [-2, 0.5], [1, 1.5]])
    readings = exact(zero, matrix, tilts)
    found = calibrate_accelerometers(readings)
    level = np.column_stack(
        [np.ones(6), [list(specific_force(r.position).values()) for r in readings]]
    )
    volts = np.array([list(r.rest.volts.values()) for r in readings])
    plain = np.linalg.lstsq(level, volts, rcond=None)[0][0]
    for index, name in enumerate(ACCELEROMETERS):
        k = matrix[index, index]
        assert abs(found.fits[name].zero - zero[index]) < 1e-3 * k
        assert abs(found.fits[name].sensitivity / k - 1.0) < 2e-3
    assert np.max(np.abs(plain - zero) / np.diag(matrix)) > 0.010


def test_misalignment_is_found_where_the_aircraft_lies_well() -> None:
    zero, matrix = nominal()
    matrix[0, 2] = matrix[0, 0] * math.tan(math.radians(2.0))
    found = calibrate_accelerometers(exact(zero, matrix, np.zeros((6, 2))), laying_error=0.1)
    assert found.fits["ax"].cross["an"] == pytest.approx(2.0, abs=0.1)
    assert found.fits["ax"].cross["ay"] == pytest.approx(0.0, abs=0.1)
    assert found.fits["ay"].cross["ax"] == pytest.approx(0.0, abs=0.1)
    assert found.fits["ax"].cross_uncertainty["an"] < 0.2
    assert found.fits["ax"].verdict.passed


def test_a_position_that_does_not_fit_is_named() -> None:
    zero, matrix = nominal()
    tilts = np.zeros((6, 2))
    tilts[POSITIONS.index("x_up"), 1] = 20.0
    found = calibrate_accelerometers(exact(zero, matrix, tilts))
    assert "'nose straight up'" in found.issue


def test_every_position_is_recognized_and_none_between() -> None:
    zero, matrix = nominal()
    for one in exact(zero, matrix, np.full((6, 2), 5.0)):
        assert recognize_position(one.rest.volts) == one.position
    between = zero + matrix @ np.array([0.7, 0.0, 0.7])
    assert recognize_position(dict(zip(ACCELEROMETERS, between, strict=True))) is None


def with_fault(fault: str) -> SixPositionResult:
    return six_work(VirtualBench(11, faults=[parse_bench_fault(fault)]))


@pytest.mark.parametrize(
    ("fault", "kinds"),
    [
        ("ay:dead", {"ay": "dead"}),
        ("an:reversed", {"an": "reversed"}),
        ("ax:swapped:with=ay", {"ax": "swapped", "ay": "swapped"}),
    ],
)
def test_what_is_wrong_is_named(fault: str, kinds: dict[str, str]) -> None:
    found = with_fault(fault)
    for name, fit in found.fits.items():
        expected = kinds.get(name)
        assert fit.verdict.kind == expected if expected else fit.verdict.usable
        if expected in ("dead", "swapped"):
            with pytest.raises(CalibrationError, match=name):
                found.certificate(name, who="crew", stamp=STAMP)


def test_a_missing_position_is_named() -> None:
    zero, matrix = nominal()
    readings = exact(zero, matrix, np.zeros((6, 2)))
    with pytest.raises(CalibrationError, match="nose straight down"):
        calibrate_accelerometers([r for r in readings if r.position != "x_down"])


def test_reading_a_position_again_gains_certainty() -> None:
    zero, matrix = nominal()
    readings = exact(zero, matrix, np.zeros((6, 2)))
    once, twice = (
        calibrate_accelerometers(readings),
        calibrate_accelerometers([*readings, *map(replace, readings)]),
    )
    ratio = twice.fits["ay"].cross_uncertainty["ax"] / once.fits["ay"].cross_uncertainty["ax"]
    assert ratio == pytest.approx(1.0 / math.sqrt(2.0), rel=0.02)
