"""Curves chosen on evidence, and what is said about them, held against known potentiometers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration import CalibrationError, CalibrationPoint
from calibration.curve_selection import fit_calibration
from calibration.polynomial_fit import CalibrationReadings
from calibration.quality import collect_remarks
from gsapp.quantities import FloatArray
from tests.calibration.potentiometer_kit import quick_sweep, recovered

SEEDS = range(20)
CHANNELS = ("elevator_left", "elevator_right", "rudder", "alpha")


def points_on(
    curve: tuple[float, ...], *, width: float = 0.6, error: float = 0.03, seed: int = 0
) -> list[CalibrationPoint]:
    random = np.random.default_rng(seed)
    volts = np.linspace(1.0, 4.0, 9)
    values = np.polynomial.polynomial.polyval(volts, curve)
    return [
        CalibrationPoint(
            volts=float(v),
            value=float(value + side * 0.5 * width + random.normal(0.0, error)),
            direction="up" if side > 0.0 else "down",
        )
        for side in (1.0, -1.0)
        for v, value in zip(volts, values, strict=True)
    ]


@pytest.mark.parametrize(
    ("curve", "degree"),
    [
        ((-50.0, 20.0), 1),
        ((-50.0, 20.0, 0.9), 2),
        ((50.0, -20.0, -0.9), 2),
        ((-40.0, 10.0, -1.5, 0.9), 3),
    ],
)
def test_the_points_choose_the_curve(curve: tuple[float, ...], degree: int) -> None:
    """A straight, a bent and an S-shaped instrument get the curve that they have.

    A higher degree may be luck now and then; a lower one would be blind.
    """
    chosen = []
    for seed in range(6):
        made = fit_calibration(points_on(curve, seed=seed))
        chosen.append(made.degree)
        volts = np.linspace(1.0, 4.0, 31)
        np.testing.assert_allclose(
            made.value(volts), np.polynomial.polynomial.polyval(volts, curve), atol=0.1
        )
    assert min(chosen) == degree
    assert chosen.count(degree) >= 5


def test_a_degree_that_was_asked_for_is_taken() -> None:
    points = points_on((-50.0, 20.0, 0.9))
    for degree in (1, 2, 3):
        made = fit_calibration(points, degree=degree)
        assert made.degree == made.quality.degree == degree
        assert set(made.losses) == {1, 2, 3}


def test_recovered_angles_lie_within_the_stated_uncertainty() -> None:
    inside, close = [], []
    for seed in SEEDS:
        taken = quick_sweep(seed, CHANNELS[seed % 4])
        made = fit_calibration(taken.points())
        errors, widths = recovered(made, taken.potentiometer, seed)
        inside.append(np.mean(np.abs(errors) < widths))
        close.append(np.mean(widths))
    assert np.mean(inside) >= 0.95
    # And not by stating anything: half a degree is what play and protractor amount to.
    assert np.mean(close) < 0.6


def test_hysteresis_is_within_a_tenth_of_the_truth() -> None:
    for passed in (3.0, 0.0):
        for seed in SEEDS[:10]:
            taken = quick_sweep(seed, CHANNELS[seed % 3], passed=passed)
            quality = fit_calibration(taken.points(0.0)).quality
            assert quality.hysteresis == pytest.approx(taken.potentiometer.play, rel=0.1)


def test_the_bound_of_the_hysteresis_is_honest() -> None:
    inside = []
    for seed in range(20):
        taken = quick_sweep(seed, "rudder")
        quality = fit_calibration(taken.points(0.1, seed)).quality
        off = abs(quality.hysteresis - taken.potentiometer.play)
        inside.append(off < quality.hysteresis_uncertainty)
    assert np.mean(inside) >= 0.9


def test_more_points_make_hysteresis_surer_and_not_larger() -> None:
    widths = []
    for count in (5, 25):
        settings = tuple(np.linspace(-20.0, 20.0, count))
        sweeps = [quick_sweep(seed, "rudder", settings) for seed in range(4)]
        found = [fit_calibration(one.points(0.15, seed)).quality for seed, one in enumerate(sweeps)]
        widths.append(np.mean([one.hysteresis_uncertainty for one in found]))
        plays = [one.potentiometer.play for one in sweeps]
        assert np.mean([one.hysteresis for one in found]) == pytest.approx(np.mean(plays), abs=0.1)
    assert widths[1] < 0.5 * widths[0]


def test_an_outlier_is_pointed_out_and_nothing_else() -> None:
    alarms = 0
    for seed in range(6):
        points = quick_sweep(seed, "elevator_left").points()
        alarms += len(fit_calibration(points).quality.outliers)
        wrong = (3 * seed) % len(points)
        points[wrong] = replace(points[wrong], value=points[wrong].value + 3.0)
        assert wrong in fit_calibration(points).quality.outliers, seed
    assert alarms <= 1


def test_two_outliers_do_not_hide_each_other() -> None:
    points = points_on((-50.0, 20.0, 0.9))
    for at in (3, 12):
        points[at] = replace(points[at], value=points[at].value + 1.5)
    assert sorted(fit_calibration(points).quality.outliers) == [3, 12]


def test_hysteresis_is_not_known_from_one_direction() -> None:
    points = [one for one in points_on((-50.0, 20.0)) if one.direction == "up"]
    made = fit_calibration(points)
    assert made.quality.hysteresis is None
    assert made.fit.hysteresis == 0.0
    assert any(
        "in both directions" in sentence for sentence in collect_remarks(made, points, "deg")
    )


def test_up_and_down_noted_the_wrong_way_round_is_remarked() -> None:
    swapped = {"up": "down", "down": "up"}
    points = [
        replace(one, direction=swapped[one.direction])  # type: ignore[arg-type]
        for one in points_on((-50.0, 20.0))
    ]
    made = fit_calibration(points)
    assert any("in reverse" in sentence for sentence in collect_remarks(made, points, "deg"))
    assert not collect_remarks(fit_calibration(points_on((-50.0, 20.0))), points, "deg")


@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_points_are_taken_for_what_they_are(count: int) -> None:
    volts = np.linspace(1.0, 4.0, count)
    points = [CalibrationPoint(volts=float(v), value=20.0 * float(v) - 50.0) for v in volts]
    made = fit_calibration(points)
    assert made.degree == 1
    np.testing.assert_allclose(made.fit.coefficients, (-50.0, 20.0), atol=1e-9)
    if count == 2:
        assert made.quality.scatter is None
        assert made.quality.uncertainty is None
        assert np.isnan(made.uncertainty(2.0))
        assert any("uncertainty" in sentence for sentence in collect_remarks(made, points, "deg"))


def test_what_allows_no_curve_is_refused() -> None:
    with pytest.raises(CalibrationError, match="2 different"):
        fit_calibration([CalibrationPoint(volts=1.0, value=x) for x in (0.0, 1.0)])
    with pytest.raises(CalibrationError, match="same value"):
        fit_calibration([CalibrationPoint(volts=v, value=3.0) for v in (1.0, 2.0)])
    hill = [CalibrationPoint(volts=v, value=-((v - 2.0) ** 2)) for v in (0.0, 1.0, 2.0, 3.5, 5.0)]
    with pytest.raises(CalibrationError, match="turns back"):
        fit_calibration(hill, degree=2)
    with pytest.raises(CalibrationError, match="degree 4"):
        fit_calibration(hill, degree=4)
    assert fit_calibration(hill).degree == 1


def test_a_setting_error_known_beforehand_counts() -> None:
    points = points_on((-50.0, 20.0), error=0.001)[::2]
    alone, with_it = fit_calibration(points), fit_calibration(points, setting_error=0.2)
    assert alone.quality.scatter < 0.01 < 0.1 < with_it.quality.scatter


def test_the_turns_count_as_noted_where_they_agree() -> None:
    agreed = CalibrationReadings.from_points(quick_sweep(3, "rudder").points(0.0))
    assert np.count_nonzero(agreed.side == 0.0) == 0
    between = CalibrationReadings.from_points(quick_sweep(3, "rudder", passed=0.0).points(0.0))
    assert np.flatnonzero(between.side == 0.0).tolist() == [0, 5]


plausible = st.builds(
    lambda seed, width, error: points_on((-50.0, 20.0, 0.9), width=width, error=error, seed=seed),
    st.integers(0, 10**6),
    st.floats(0.1, 2.0),
    st.floats(0.01, 0.3),
)


def widths_of(points: list[CalibrationPoint], volts: FloatArray) -> FloatArray:
    return fit_calibration(points).uncertainty(volts)


@given(points=plausible, order=st.randoms(use_true_random=False))
@settings(max_examples=5, deadline=None)
def test_the_order_of_points_does_not_matter(points: list[CalibrationPoint], order: object) -> None:
    shuffled = list(points)
    order.shuffle(shuffled)  # type: ignore[attr-defined]
    one, other = fit_calibration(points), fit_calibration(shuffled)
    assert one.degree == other.degree
    np.testing.assert_allclose(one.fit.coefficients, other.fit.coefficients, rtol=1e-6)
    assert one.quality.hysteresis == pytest.approx(other.quality.hysteresis, abs=1e-9)


@given(points=plausible, factor=st.sampled_from([-1.0, np.pi / 180.0, 60.0]))
@settings(max_examples=5, deadline=None)
def test_units_and_signs_do_not_matter(points: list[CalibrationPoint], factor: float) -> None:
    other_way = {"up": "down", "down": "up"}
    scaled = [
        replace(
            one,
            value=factor * one.value,
            direction=one.direction if factor > 0.0 else other_way[one.direction],  # type: ignore[arg-type]
        )
        for one in points
    ]
    one, other = fit_calibration(points), fit_calibration(scaled)
    volts = np.linspace(1.0, 4.0, 7)
    np.testing.assert_allclose(other.value(volts), factor * one.value(volts), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(
        other.uncertainty(volts), abs(factor) * one.uncertainty(volts), rtol=1e-6
    )


@given(points=plausible)
@settings(max_examples=5, deadline=None)
def test_the_half_width_is_never_less_than_half_the_loop(points: list[CalibrationPoint]) -> None:
    made = fit_calibration(points)
    low, high = made.quality.uncertainty_volts[0], made.quality.uncertainty_volts[-1]
    inside = np.linspace(low, high, 21)
    assert np.all(made.uncertainty(inside) > 0.45 * made.quality.hysteresis)
    for beyond in (low - 0.01, high + 0.01):
        assert np.isnan(made.uncertainty(beyond))
        assert np.isnan(made.value(beyond))
