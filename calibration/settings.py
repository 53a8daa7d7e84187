"""Settings of calibration curves, of their quality and of reading volts at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

FIT_ORDER_TITLES: Final = {1: "straight line", 2: "quadratic", 3: "cubic"}


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationSettings:
    """Engineering choices, checked by `tests/bench/calibrations.py`."""

    # Curve.
    max_loss_ratio: float = 0.9  # A higher degree must bring the loss down to this share of it.
    outlier_significance: float = 0.02  # How often points without any outlier have one pointed out.
    drift_significance: float = 0.01  # How often a shift is found where there is none.
    same_setting_share: float = 0.1  # Of the mean spacing: closer settings are the same one.
    turn_point_significance: float = 0.2  # Below it, turn points do not count as noted.
    prior_degrees_of_freedom: float = 4.0  # Points that a setting error known beforehand is worth.
    max_degree: int = max(FIT_ORDER_TITLES)  # Degree of a curve at most.
    uncertainty_points: int = 9  # Where along the curve its uncertainty is written down.
    confidence: float = 0.95  # Confidence level of bounds.
    line_points: int = 9  # Points of a straight line in its certificate.
    min_coverage: float = 0.6  # Share of the travel below which a calibration is remarked upon.
    range_tolerance: float = 1e-6  # Share of the calibrated range that counts as its end.

    # Settings of a plan.
    min_settings: int = 3  # Settings that a calibration takes.
    check_settings: int = 3  # Settings of a check.
    volts_range: tuple[float, float] = (-15.0, 15.0)  # Volts that a converter may read ...
    supply_range: tuple[float, float] = (0.5, 30.0)  # ... and that may supply a potentiometer.

    # Faults.
    min_response_counts: float = 40.0  # Movement of a potentiometer, ADC counts: about 1 deg.
    fault_noise_counts: float = 10.0  # Sample-to-sample noise of a bad contact, ADC counts.
    fault_clipped_share: float = 0.05  # Share of samples at the end of the ADC range: clipped.
    min_fault_samples: int = 8  # Fewer samples show no movement.

    # Rest.
    rest_block: float = 0.5  # Length of a block, s.
    min_block_samples: int = 5  # Samples that a block must have of each instrument.
    max_blocks: int = 240  # Blocks kept: two minutes of rest.

    # Volts.
    evaluation_period: float = 0.1  # How often the state is judged, s.
    averaging: float = 0.7  # Seconds at rest that a reading is averaged over.
    window_segments: int = 5  # Parts of the window whose means are compared.
    still_counts: float = 4.0  # Largest difference of the means at rest, ADC counts.
    noisy_counts: float = 10.0  # Standard deviation of a noisy instrument, ADC counts.
    clipped_share: float = 0.2  # Share of samples at the end of the ADC range: clipped.
    min_window_samples: int = 5  # Samples needed; a slow link lets the window grow ...
    max_window_factor: float = 3.0  # ... by up to this factor.
    max_gap: float = 0.5  # Seconds without a sample after which everything before is forgotten.


CALIBRATION: Final = CalibrationSettings()
