"""Limits within which flight cards and records are plausible; resampling, and clocks of logs."""

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
    min_grid_rate: float = 0.01  # Hz, of columns.
    max_time: float = 1e11  # s: three thousand years.
    max_id_length: int = 64  # Letters of the id of a mark.
    max_idle_rows: float = 8.0  # Rows of a file from sample to sample of its quickest channel.
    usual_values_per_record: float = 1e4  # On the grid; heartbeats alone need fewer.
    max_values_per_record: float = 1e5  # On the grid: a record about every 20 s.
    min_sparse_values: float = 5e6  # Fewer are always read.
    max_clock_jump: float = 1.0  # Seconds by which a stamp may be off its neighbors ...
    clock_neighbors: int = 5  # ... so many of which tell where it should be.
    max_late_stamps: float = 0.02  # Share of the samples that may be set aside as out of order.
    max_stamp_offset: float = 10.0
    """Seconds by which a stamp may be off those of other messages beside it in a log: slow
    messages are stamped when they were sent last."""
    max_pause: float = 3600.0  # s: no single sample is taken so long before or after all others.
    clock_window: int = 15  # Records beside one another, most of which tell the board's time.

    # Resampling and filtering.
    max_gap_periods: float = 2.5  # Sample periods: a longer spacing is a gap.
    filter_order: int = 4  # Order of the Butterworth filter, run forward and backward.
    decimation_cutoff: float = 0.4  # Over the new rate; Nyquist would be 0.5.


FLIGHT_DATA: Final = FlightDataSettings()


@dataclass(frozen=True, slots=True, kw_only=True)
class LogAlignmentSettings:
    """Engineering choices, checked by `tests/flight/test_onboot_clock.py`."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class ReaderProcessSettings:
    """Limits of a process that reads a foreign file."""

    limit_mb: int = 512  # Of numbers: two hours of 90 channels at 100 Hz.
    size_ratio: int = 4  # Numbers over file that are accepted: measured flights shrink to a half.
    memory_ratio: int = 3  # Memory of the process over the limit of numbers ...
    memory_base_mb: int = 512  # ... and what the libraries take themselves, MB.
    start_timeout: float = 60.0  # s for Python and libraries on a slow disk.
    quiet_timeout: float = 60.0  # s without progress in a small file, as on a busy computer ...
    slow_disk_rate: float = 2e6  # ... and bytes per second of a large one.
    cpu_time: float = 30.0  # s of work, after which the system ends a process that hangs.
    poll_interval: float = 0.05  # s between two reports.


READER_PROCESS: Final = ReaderProcessSettings()
