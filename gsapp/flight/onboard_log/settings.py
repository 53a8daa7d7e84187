"""Settings of the time alignment of an on-board log with the live record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class LogAlignmentSettings:
    """Engineering choices, checked by `tests/flight/test_onboard_clock.py`."""

    window_duration: float = 10.0  # s: several periods of an aircraft of this size.
    smoothing: float = 0.3
    """s of smoothing of both before they are compared. The radio carries a few samples a second
    with straight lines between; smoothed, both hold the same. It is symmetric, so it moves
    nothing."""
    smoothing_periods: float = 2.0  # Or over so many samples of the radio, where it carries fewer.
    max_drift: float = 1e-3  # Of any clock: bad crystals do 200 ppm.
    drift_sigmas: float = 3.0  # Standard deviations from which on a drift is corrected.
    min_lag_std: float = 2e-4  # Seconds; no lag of a stretch is believed to be better than this.
    max_windows: int = 80  # Windows compared; those with the most motion.
    max_channels: int = 12  # Channels compared.
    min_valid_share: float = 0.6  # Share of the samples of a window that must be there.
    min_window_correlation: float = 0.9  # Correlation from which the lag of a window counts.
    min_agreeing_share: float = 0.5  # Share of the windows that must lie on one line.
    min_search: float = 0.5  # Seconds of lag searched about the coarse lag at least.
    outlier_sigmas: float = 4.0  # From the line: windows beyond are left out.
    iterations: int = 3  # Repetitions of the fit of the line without outliers.
    min_scatter_values: int = 6  # With fewer, bounds are taken as they are.
    min_scatter_ratio: float = 0.3  # Of scatter to bounds: smaller is chance.

    # Coarse lag.
    compared_channels: int = 4  # Channels compared for the coarse lag.
    min_overlap: float = 2.0  # Seconds that both records must share ...
    min_overlap_share: float = 0.2  # ... and the share of the shorter one.
    min_correlation: float = 0.8  # Correlation from which a coarse lag counts.

    # Merging.
    row_tolerance: float = 1e-6  # Of a row; nearer than that a sample is taken as it is.
    reported_offset: float = 5e-4  # Seconds; clocks that differ by less are said to agree.
    max_date_difference: float = 12 * 3600.0  # s: the zone of a clock may be wrong.


ALIGNMENT: Final = LogAlignmentSettings()
