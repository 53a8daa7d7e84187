"""A straight instrument's certificate holds the figures that its zero and sensitivity give."""

from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.adc import ADC_RESOLUTION
from calibration.inertial.straight_line import StraightLineCalibration
from calibration.points import CalibrationPoint

VOLTS = np.array([0.5, 2.4, 3.0, 4.6])
SCALES = st.floats(0.02, 2.0).flatmap(lambda size: st.sampled_from([size, -size]))


@settings(max_examples=20)
@given(zero=st.floats(2.0, 3.0), sensitivity=SCALES, unsure=st.tuples(*[st.floats(1e-4, 0.05)] * 3))
def test_every_figure_is_that_of_the_line(
    zero: float, sensitivity: float, unsure: tuple[float, float, float]
) -> None:
    """Whatever the sign of the sensitivity; the range holds all points."""
    zero_uncertainty, sensitivity_uncertainty, noise = unsure
    line = StraightLineCalibration(
        zero=zero, zero_uncertainty=zero_uncertainty, sensitivity=sensitivity,
        sensitivity_uncertainty=sensitivity_uncertainty, noise=noise, range=(1.0, 4.0),
    )  # fmt: skip
    values = (VOLTS - zero) / sensitivity
    off = np.array([0.0, 0.01, -0.03, 0.02])
    points = [
        CalibrationPoint(value=float(value), volts=float(volts), direction="up")
        for value, volts in zip(values + off, VOLTS, strict=True)
    ]
    made = line.certificate(
        "p", "rad/s", points, who="Ann", stamp=datetime(2026, 5, 12, tzinfo=UTC),
        temperature=None, instrument="", notes="",
    )  # fmt: skip
    assert made.evaluate(VOLTS) == pytest.approx(values)
    assert made.range == (0.5, 4.6)
    assert made.max_residual == made.quality.max_residual == pytest.approx(0.03)
    assert made.rms_residual == made.quality.rms == pytest.approx(np.sqrt(np.mean(off**2)))
    assert made.quality.linearity == 0.0
    assert made.quality.resolution == pytest.approx(ADC_RESOLUTION / abs(sensitivity))
    assert made.quality.covered == pytest.approx((min(values + off), max(values + off)))
    places = np.array(made.quality.uncertainty_volts)
    assert (places[0], places[-1]) == made.range
    # The sum of squares of the module, in volts.
    squares = (
        zero_uncertainty**2
        + ((places - zero) / sensitivity * sensitivity_uncertainty) ** 2
        + (1.96 * noise) ** 2
        + (ADC_RESOLUTION / 2.0) ** 2
    )
    assert made.quality.half_widths == pytest.approx(np.sqrt(squares) / abs(sensitivity))
