"""Limits within which flight cards and records are plausible, and settings of resampling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightDataSettings:
    """Engineering choices unless a source is named."""

    # Flight card.
    max_throw: float = 1.5  # No transmitter gives more than this share of the usual throw.
    max_weight_change: float = 0.15  # Share between flights (Seanor table 6.2.3: 3 %).
    max_fuel_ratio: float = 1.3  # Tanks hold little more than the aircraft file's fuel.
    scales_tolerance: float = 0.02  # Share, of the weight on the card to the scales.
    cg_tolerance: float = 0.5e-3  # A CG that moves less than this, m, has not moved.
    cg_shift_tolerance: float = 2e-3  # m in a flight: as well as scales tell the CG.
    mass_tolerance: float = 1e-3  # Share: mass or inertia has not changed.

    # Test cards.
    step_range: tuple[float, float] = (0.05, 30.0)  # Width of a step, s.
    max_amplitude: float = 45.0 * DEGREE  # Of an input, rad.
    max_repeats: int = 50  # Of a card.

    # Records.
    catalog_timeout: float = 15.0  # s to wait for another program that writes the catalog.
    same_clock_tolerance: float = 0.1  # s between readings of one clock.
    max_filled_gap: float = 60.0
    """Seconds without samples that are filled with missing rows. A longer pause, such as the
    night between two flights in one record, keeps one missing row at either end and costs no
    memory."""
    max_sample_rate: float = 20_000.0  # Hz: nothing on such an aircraft is faster.
    max_clock_jump: float = 1.0  # Seconds by which a stamp may be off its neighbors ...
    clock_neighbors: int = 5  # ... so many of which tell where it should be.

    # Resampling and filtering.
    max_gap_periods: float = 2.5  # Sample periods: a longer spacing is a gap.
    filter_order: int = 4  # Order of the Butterworth filter, run forward and backward.
    decimation_cutoff: float = 0.4  # Over the new rate; Nyquist would be 0.5.


FLIGHT_DATA: Final = FlightDataSettings()
