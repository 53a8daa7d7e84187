"""Limits within which flight cards and records are plausible, and settings of resampling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightDataSettings:
    """Engineering choices unless a source is named."""

    # Flight card.
    max_throw: float = 1.5  # No transmitter gives more than this share of the usual throw.
    max_weight_change: float = 0.15
    """Weights of one aircraft differ by less than this share between flights (Seanor
    table 6.2.3: 3 %)."""
    max_fuel_ratio: float = 1.3  # Tanks hold little more than the aircraft file's fuel.
    scales_tolerance: float = 0.02
    """Share by which the weight on the card may differ from the sum of the scales."""
    cg_tolerance: float = 0.5e-3  # A CG that moves less than this, m, has not moved.
    cg_shift_tolerance: float = 2e-3
    """A CG that wanders less than this in a flight, m, stays within what scales tell of it."""
    mass_tolerance: float = 1e-3
    """A mass or inertia that changes by less than this share has not changed."""

    # Records.
    same_clock_tolerance: float = 0.1
    """Seconds within which two readings of one clock agree, however late their messages came."""
    max_filled_gap: float = 60.0
    """Seconds without any sample that are still filled with missing rows. A longer pause, such as
    the night between two flights in one record, keeps one missing row at either end and costs no
    memory in between."""
    max_sample_rate: float = 20_000.0
    """Samples per second that nothing on such an aircraft reaches."""
    max_clock_jump: float = 1.0  # Seconds by which a stamp may be off its neighbors ...
    clock_neighbors: int = 5  # ... so many of which tell where it should be.

    # Resampling and filtering.
    max_gap_periods: float = 2.5
    """Samples farther apart than so many of their own periods have a gap between them."""
    filter_order: int = 4  # Order of the Butterworth filter, run forward and backward.
    decimation_cutoff: float = 0.4
    """Corner of the filter before decimation, over the new rate; 0.5 would be half of it."""


FLIGHT_DATA: Final = FlightDataSettings()
