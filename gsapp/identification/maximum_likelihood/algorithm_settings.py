"""Settings of the output-error algorithm that nobody sets by hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class MLAlgorithmSettings:
    """Engineering choices, checked by `tests/bench/likelihood.py`, unless a source is named."""

    # Problem.
    max_input_gap: float = 0.1
    """An input missing for longer than this (s) ends a segment: nobody knows where it went."""
    min_segment_duration: float = 0.5
    """Segments shorter than this (s) tell less than their initial states ask; they are left out."""
    airspeed_cutoff: float = 3.0  # Hz: airspeed of an aircraft cannot change faster.
    initial_state_samples: int = 5  # Samples whose mean starts the initial state.
    min_peak_to_noise: float = 9.0
    """Peak-to-peak of smoothed white noise over its deviation stays below this in a long record."""

    # Gauss-Newton and Levenberg-Marquardt.
    eigenvalue_tolerance: float = 1e-11
    """Eigenvalues of the scaled Hessian below this share of the largest count as zero."""
    acceptable_tolerance: float = 1e-4
    """Seanor's |dJ/J|: a fit that cannot get further, but this far, has converged."""
    cost_rounding: float = 1e-8
    """Changes of the cost below this share drown in its rounding; steps are then taken unseen."""
    max_halvings: int = 4  # Halvings of a step.
    dampings: tuple[float, float, float, float, float] = (1e-3, 1e-2, 1e-1, 1.0, 10.0)
    """Levenberg-Marquardt damping, tried in turn."""
    single_thread_size: float = 2e5
    """Multiplications of a matrix product up to which BLAS stays on one thread."""
    noise_floor: float = 1e-7
    """Residuals below this share of the measured signal are rounding, not noise."""

    # Trajectories.
    max_newton_iterations: int = 12  # Newton iterations of a trajectory.
    newton_tolerance: float = 3e-6
    """A Newton correction smaller than this (of 1, or of the state) leaves an error of its
    square."""
    chord_tolerance: float = 1e-10
    """The same with a Jacobian that is not renewed: the error falls only in proportion."""
    divergence_limit: float = 1e4  # States beyond this (SI, radians) have left all bounds.

    # Judging a fit.
    colored_power_ratio: float = 4.0
    """Power at low frequency over that of white noise from which on the crew is told."""
    min_response_r2: float = 0.5
    """R2 of a response below which the crew is told not to believe the values of a maneuver."""
    r2_averaging: float = 0.1
    """Seconds of which samples are averaged for that: so noise alone does not lower R2."""
    bad_fit_power_ratio: float = 20.0
    """Power of residuals at low frequency over that of white noise from which on a fit is bad."""


ML_ALGORITHM: Final = MLAlgorithmSettings()
