"""Limits of judgment in reports, apart from their layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSettings:
    """Engineering choices."""

    # Values.
    consistent_ratio: tuple[float, float] = (0.7, 1.4)  # Scatter over bounds: consistent.
    well_known_percent: float = 10.0  # Percent to which a derivative is well known.
    error_bar_sigmas: float = 2.0  # Half the length of a bar, in bounds: 95 %.
    high_correlation: float = 0.9  # Derivatives can hardly be told apart.
    max_pairs: int = 20  # Pairs of derivatives that are listed as hardly told apart.
    max_fits: int = 12  # Maneuvers drawn in full, the worst first; the table lists all.
    max_ftr_flights: int = 4  # Flights that FTR listens to for a report: one picture each.
    clear_sigmas: float = 5.0  # Standard deviations from which an effect cannot be overlooked.
    neutral_time_constant: float = 1000.0  # s: longer neither dies nor grows in flight.
    linear_axis_margin: float = 0.25  # Of the measured range; beyond, a model leaves.
    online_axis_margin: float = 6.0  # Bounds above and below the last value that a chart shows.


REPORT: Final = ReportSettings()
