"""Settings of the Kalman filter core and of tuning its noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterErrorSettings:
    """Engineering choices, checked by `tests/bench/discrepancy.py`."""

    # Linearization.
    bias_reference_speed: float = 30.0  # m/s, at which the zero of airspeed is given.
    min_speed: float = 5.0  # Airspeed (m/s) below which no pressure is believed.
    block_duration: float = 0.04  # Length of a block, s.
    state_scales: tuple[float, ...] = (1.0, 0.01, 0.01, 0.05, 0.05, 0.05, 0.02, 0.02)
    """Sizes (SI) that make the states comparable: V, alpha, beta, p, q, r, phi, theta."""
    gust_scales: tuple[float, float, float] = (1.0, 0.01, 0.01)  # The same of gusts.
    rotation_scale: float = 0.05  # The same of rotation of the air, rad/s.
    reading_scale: float = 0.02  # The same of what a delayed instrument shows.
    min_valid_share: float = 0.6  # Of the samples of a channel in a block.
    max_delay: float = 0.08  # s for which a deviation is followed to a delayed channel.
    oversampling: int = 4  # Samples in the place of one, for the response of a lag.
    relative_step: float = 1e-3  # Step of a numerical derivative over the size of its parameter.

    # Steady-state filter.
    max_banded_columns: int = 6  # Columns up to which the banded solver is the faster one.
    max_doublings: int = 40  # Doublings of the Riccati recursion at most.
    covariance_tolerance: float = 1e-15  # Relative change by the last doubling.
    residual_tolerance: float = 1e-9  # Relative error of the equation, else a pencil.
    min_intensity: float = 1e-9  # Process noise of every state, scales squared per second.
    ridge: float = 1e-11  # Share of the diagonal: keeps the solution finite.
    min_information_share: float = 1e-7  # Of a column's square, given the others.

    # Noise.
    white_share: float = 0.02  # White noise of a colored channel over its step variance.
    initial_gust_intensity: float = 0.1  # Intensities that a fit starts from: of gusts ...
    initial_rotation_intensity: float = 0.1  # of rotation of the air ...
    initial_moment_intensity: float = 0.01  # ... and of moments.
    max_motion_frequency: float = 12.0  # Frequency above which no aircraft of this size moves, Hz.
    min_frequencies: int = 50  # Frequencies above `max_motion_frequency` that tell the noise.
    min_samples: int = 10  # Differences of samples that tell the noise.
    max_white_correlation: float = 0.35  # Correlation below which noise counts as white.
    max_noise_step: float = 6.0  # Factor by which one round may change a noise.
    increase_exponent: float = 0.6  # Exponent of the ratio by which an intensity rises ...
    decrease_exponent: float = 2.0  # ... and falls.
    intensity_bounds: tuple[float, float] = (1e-9, 100.0)  # Bounds of the intensities.
    skipped_blocks: int = 5  # Blocks at the start, which the initial state has used up.
    noise_rounds: int = 3  # Rounds of noise to each pass of a fit.
    converged_step: float = 0.3  # Largest move in standard deviations: converged.
    correlation_updates: int = 4  # Updates of the correlation of colored noise.
    correlation_tolerance: float = 0.12  # Change of that correlation below which it has settled.
    min_correlation: float = 0.05  # Sample to sample, of colored noise: at least ...
    max_correlation: float = 0.97  # ... and at most.
    aic_penalty: float = 2.0  # Fall of the cost for one more noise parameter (Akaike).

    # Estimation of derivatives. It begins with gusts that explain what moves vanes and
    # accelerometers; begun with moments or with air that turns by itself, it can end in these.
    start_gust_intensity: float = 1.0
    start_gradient_intensity: float = 1e-3  # Of pitch and yaw of the air beyond gusts' gradients.
    start_moment_intensity: float = 1e-3
    long_roll: float = 3.0  # `NoiseModel.roll_length` that is tried beside 1.
    max_passes: int = 30  # Passes at most.
    min_passes: int = 3  # Passes before values may count as settled ...
    max_halvings: int = 6  # Of a step that raises the deviance ...
    allowed_rise: float = 4.0  # ... by more than this.
    settled_step: float = 0.02  # ... with the largest move below this, in standard deviations,
    remaining_falls: float = 4.0  # Falls of the deviance like the last that are still to come.
    settled_noise: float = 0.1  # and the intensity of gusts changing by less than this share;
    negligible_gust: float = 1e-5  # below this it does not matter.
    prediction_rounds: int = 3  # In which the motion follows the filter, values known.
    turbulence_lead: float = 3.0  # s of turbulence before a planned maneuver.
    min_reported_gust: float = 0.02  # Gusts, m/s, and rotation of the air, rad/s, that are said.
    min_reported_rotation: float = 0.002


FILTER_ERROR: Final = FilterErrorSettings()
