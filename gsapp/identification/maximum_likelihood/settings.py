"""What a maximum likelihood fit is told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from pydantic import Field, NonNegativeFloat

from gsapp.dynamics.model import Model
from gsapp.identification.axes import Axis
from gsapp.identification.estimate_settings import FitSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class MLAlgorithmSettings:
    """Engineering choices, checked by `tests/bench/likelihood.py`, unless a source is named."""

    # Problem.
    max_input_gap: float = 0.1  # s: a longer gap in an input ends a segment.
    min_segment_duration: float = 0.5  # s: shorter ones only fix initial states.
    airspeed_cutoff: float = 3.0  # Hz: airspeed of an aircraft cannot change faster.
    initial_state_samples: int = 5  # Samples whose mean starts the initial state.
    min_peak_to_noise: float = 9.0  # Of smoothed white noise in a long record: less.

    # Gauss-Newton and Levenberg-Marquardt.
    repeat_tolerance: float = 1e-3
    """Promised decrease of |dJ/J| below which a fit to a slightly changed record takes one step:
    derivatives change by what they should within 0.5 %."""
    eigenvalue_tolerance: float = 1e-11  # Of the largest: smaller count as zero.
    acceptable_tolerance: float = 1e-4  # Seanor's |dJ/J|: converged if nothing helps.
    cost_rounding: float = 1e-8  # Relative rounding of the cost: steps go unchecked.
    max_halvings: int = 4  # Halvings of a step.
    dampings: tuple[float, float, float, float, float] = (1e-3, 1e-2, 1e-1, 1.0, 10.0)
    """Levenberg-Marquardt damping, in turn."""
    single_thread_size: float = 2e5  # Multiplications up to which BLAS uses one thread.
    noise_floor: float = 1e-7  # Of the signal: smaller residuals are rounding.

    # Trajectories.
    max_newton_iterations: int = 12  # Newton iterations of a trajectory.
    newton_tolerance: float = 3e-6  # Correction that leaves an error of its square.
    chord_tolerance: float = 1e-10  # The same with a constant Jacobian: linear convergence.
    divergence_limit: float = 1e4  # States beyond this (SI, radians) have left all bounds.

    # Judging a fit.
    colored_power_ratio: float = 4.0  # Low frequency over white noise: a warning.
    min_response_r2: float = 0.5  # Of a response: a warning below.
    r2_averaging: float = 0.1  # s of averaging for R2: noise alone does not lower it.
    bad_fit_power_ratio: float = 20.0  # Low frequency over white noise: a bad fit.
    min_samples_per_unknown: int = 2  # Each sample has several responses.


ML_ALGORITHM: Final = MLAlgorithmSettings()


class MLSettings(FitSettings):
    """Settings of a maximum likelihood (output error) fit."""

    axis: Axis
    model: Model | None = Field(
        None,
        description="Gives the effects beyond the linear build-up, and values of derivatives that "
        "are not free.",
    )
    weights: Mapping[str, NonNegativeFloat] | None = Field(
        None,
        description="Weight of each response (SI; diagonal of W1). By default the noise "
        "covariance is estimated from the residuals, for each maneuver its own, and iterated.",
    )
    joint_weights: Mapping[str, Mapping[str, NonNegativeFloat]] | None = Field(
        None, description="The same by maneuver id; comes before `weights`."
    )

    def with_stand_ins(self, values: Mapping[str, float]) -> MLSettings:
        """Return settings with constants for further channels; those of the settings count."""
        return self.with_changes(stand_ins={**values, **self.stand_ins})


@dataclass(frozen=True, slots=True, kw_only=True)
class FitProgress:
    """How far a fit has come."""

    iteration: int
    cost: float  # Mean square of the weighted residuals, over that at the start.
    change: float  # Share of the cost that the last step promised to take off.


FitProgressCallback = Callable[[FitProgress], bool | None]
"""Called after every iteration; returning False stops the fit where it is."""
