"""Settings of bounds and of tests of residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualStatisticsSettings:
    """Engineering choices unless a source is named."""

    singular_tolerance: float = 1e-11  # Of the largest eigenvalue: smaller is rounding.
    min_own_variance_share: float = 1e-8  # Of a variance less that of a common offset.
    max_lags: int = 100  # Notes, section 7: 50 to 100 give bounds within 10 %.
    strong_correlation: float = 0.95  # Two parameters cannot be told apart beyond.

    # Whiteness.
    portmanteau_lags: int = 20  # Lags of the portmanteau test.
    low_frequency: float = 2.0  # Frequency, Hz, below which power is low-frequency.
    significance_level: float = 0.001  # Probability below which residuals are not white.
    min_samples: int = 20  # Samples that the test takes.

    # Turbulence.
    gust_band: tuple[float, float] = (0.5, 4.0)  # Frequencies of gusts, Hz.
    noise_frequency: float = 8.0  # Frequency, Hz, from which residuals are noise.
    min_force_coherence: float = 0.6  # Coherences from which gusts are found: of forces ...
    min_kinematic_coherence: float = 0.25  # ... and of kinematics.
    min_noise_ratio: float = 3.0  # Density in the band over that of the noise.
    taper_share: float = 0.3  # Share of a segment over which its ends fade in and out.
    min_segment_length: float = 3.0  # s: fewer have too few frequencies.
    min_frequencies: int = 10  # Frequencies in the band that the coherence takes.


STATISTICS: Final = ResidualStatisticsSettings()
