"""Drift between certificates, and the three-point check, held against known shifts."""

import datetime as dt
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calibration import CalibrationError, CalibrationPoint, Certificate, load_certificates
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.drift import check_certificate, compute_drift
from tests.calibration.potentiometer_kit import quick_sweep

STAMP = dt.datetime(2026, 5, 12, 8, 31)  # noqa: DTZ001 - a field's local time
SEEDS = range(4)


@cache
def former_of(seed: int) -> Certificate:
    return certificate(points_of(seed))


def certificate(points: Sequence[CalibrationPoint], **more: object) -> Certificate:
    made = fit_calibration(points)
    return create_certificate(
        made, points, channel_id="rudder", unit="deg", who="crew", stamp=STAMP, **more
    )


def points_of(
    seed: int, *, zero: float = 0.0, slope: float = 0.0, again: int = 0
) -> list[CalibrationPoint]:
    taken = quick_sweep(seed, "rudder")
    drawn = taken.points(0.06, seed + 1000 * again)
    return [replace(one, value=(1.0 + slope) * one.value + zero) for one in drawn]


def three(points: Sequence[CalibrationPoint]) -> list[CalibrationPoint]:
    return [points[1], points[2], points[3]]


@pytest.mark.parametrize(("zero", "slope"), [(0.0, 0.0), (0.8, 0.0), (-0.8, 0.0), (0.0, 0.06)])
def test_drift_is_found_where_it_is_and_nowhere_else(zero: float, slope: float) -> None:
    within, significant = [], []
    for seed in SEEDS:
        former = former_of(seed)
        drift = compute_drift(certificate(points_of(seed, zero=zero, slope=slope, again=1)), former)
        significant.append(drift.significant)
        within.append(abs(drift.zero - zero) < drift.zero_uncertainty)
        within.append(abs(drift.slope - slope) < drift.slope_uncertainty)
        assert "2026-05-12 08:31" in drift.sentence
    assert np.mean(within) >= 0.85
    assert np.mean(significant) == 1.0 if zero or slope else np.mean(significant) <= 0.1


def test_three_points_tell_whether_the_certificate_holds() -> None:
    held, failed = 0, 0
    for seed in SEEDS:
        in_force = former_of(seed)
        held += check_certificate(in_force, three(points_of(seed, again=1))).passed
        moved = check_certificate(in_force, three(points_of(seed, zero=1.0, again=1)))
        failed += not moved.passed
        assert moved.zero == pytest.approx(1.0, abs=0.3)
        assert moved.largest > 0.7
        assert "calibrate again" in moved.sentence
    assert held == len(SEEDS)
    assert failed == len(SEEDS)


def test_the_side_from_which_a_check_was_made_is_allowed_for() -> None:
    """Three points upward lie half a loop off the curve, and that is no shift of zero.

    Where the direction was not noted the same points say less, not something else.
    """
    points = [
        CalibrationPoint(volts=(value + 50.0 - side) / 20.0, value=value, direction=name)
        for side, name in ((1.0, "up"), (-1.0, "down"))
        for value in (-20.0, -10.0, 0.0, 10.0, 20.0)
    ]
    errors = np.random.default_rng(1).normal(0.0, 0.02, len(points))
    points = [replace(p, value=p.value + float(e)) for p, e in zip(points, errors, strict=True)]
    in_force = certificate(points)
    upward = check_certificate(in_force, three(points))
    assert upward.passed
    assert abs(upward.zero) < 0.05
    unknown = check_certificate(
        in_force, [replace(one, direction="single") for one in three(points)]
    )
    assert unknown.zero_uncertainty > 5.0 * upward.zero_uncertainty
    assert unknown.passed


def straight(low: float, high: float) -> list[CalibrationPoint]:
    values = np.linspace(low, high, 9)
    errors = np.random.default_rng(1).normal(0.0, 1e-4, values.size)
    return [
        CalibrationPoint(volts=(value + 100.0) / 50.0, value=value + error)
        for value, error in zip(values.tolist(), errors.tolist(), strict=True)
    ]


@pytest.mark.parametrize(("low", "told_at"), [(-20.0, 0.0), (20.0, 40.0), (-60.0, -40.0)])
def test_a_shift_is_told_at_zero_or_in_the_middle_where_zero_is_out_of_reach(
    low: float, told_at: float
) -> None:
    points = straight(low, low + 40.0)
    grown = [replace(one, value=1.1 * one.value + 0.3) for one in points]
    drift = compute_drift(certificate(grown), certificate(points))
    assert drift.slope == pytest.approx(0.1, abs=1e-3)
    assert drift.zero == pytest.approx(0.1 * told_at + 0.3, abs=1e-2)
    assert drift.significant


def test_a_check_tells_how_far_each_point_lies_off() -> None:
    in_force = certificate(straight(-20.0, 20.0))
    places = straight(-18.0, 18.0)[::3]
    off = (0.3, -0.5, 0.1)
    points = [replace(one, value=one.value + d) for one, d in zip(places, off, strict=True)]
    found = check_certificate(in_force, points)
    assert found.off == pytest.approx(off, abs=1e-3)
    assert found.largest == pytest.approx(0.5, abs=1e-3)
    low, high = in_force.range
    for beyond, counts in ((0.09, True), (0.11, False)):
        for volts in (low - beyond * (high - low), high + beyond * (high - low)):
            more = check_certificate(in_force, [*points, CalibrationPoint(volts=volts, value=70.0)])
            assert (more.zero != found.zero) == counts
            assert len(more.off) == 4


def test_supplies_are_referred_to_each_other() -> None:
    points = points_of(2)
    former = certificate(points, excitation_voltage=5.0, ratiometric=True)
    sagged = [replace(one, volts=0.96 * one.volts) for one in points]
    new = certificate(sagged, excitation_voltage=4.8, ratiometric=True)
    drift = compute_drift(new, former)
    assert drift.zero == pytest.approx(0.0, abs=1e-6)
    assert not drift.significant


def test_certificates_without_points_can_be_compared_with() -> None:
    former = replace(certificate(points_of(4)), points=(), quality=None)
    drift = compute_drift(certificate(points_of(4, zero=1.0, again=1)), former)
    assert drift.significant
    assert drift.zero == pytest.approx(1.0, abs=0.2)
    shipped = load_certificates("b777")["rudder"]
    assert compute_drift(certificate(points_of(4)), shipped).significant


def test_what_cannot_be_compared_says_why() -> None:
    made = certificate(points_of(1))
    with pytest.raises(CalibrationError, match="same channel"):
        compute_drift(made, load_certificates("b777")["alpha"])
    with pytest.raises(CalibrationError, match="two settings"):
        check_certificate(made, made.points[:1])
    with pytest.raises(CalibrationError, match="range"):
        check_certificate(made, [replace(one, volts=one.volts + 20.0) for one in made.points])
    bare = replace(made, points=(), quality=None)
    with pytest.raises(CalibrationError, match="third setting"):
        check_certificate(bare, made.points[:2])
