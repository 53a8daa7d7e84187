"""Settings of the identification of linear models."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModelSettings:
    """Engineering choices, checked by `tests/bench/linear_models.py`."""

    min_duration: float = 1.0  # Stretches shorter than this (s) are left out.

    # Subspace identification.
    max_order: int = 40  # Order of a model at most.
    max_tried_order: int = 12  # Orders tried where none is given.
    ridge: float = 1e-9  # Share of the mean variance that keeps the projection solvable.
    subspace_rate: float = 50.0  # Hz: faster samples only lengthen the horizon.

    # Prediction error method.
    max_iterations: int = 40  # Gauss-Newton steps at most.
    cost_tolerance: float = 1e-5  # Relative fall of the cost below which it counts as converged.


LINEAR_MODELS: Final = LinearModelSettings()
