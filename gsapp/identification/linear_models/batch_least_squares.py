"""Batch least squares for a state-space model whose states are measured (7.2.1)-(7.2.11).

Both sides of x' = A x + B u pass the same zero-phase filter; every stretch has a constant of its
own, since its trim is not the next one's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from gsapp.dynamics.linearization import LinearModel
from gsapp.foundation import FlightError
from gsapp.identification.linear_models.signals import LinearModelSignals
from gsapp.identification.smoothing import build_smoother, select_cutoff
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchLeastSquaresResult:
    """A model with the uncertainty of its entries."""

    model: LinearModel  # Outputs are those of the signals.
    A_std: FloatArray
    B_std: FloatArray
    C_std: FloatArray
    D_std: FloatArray
    """Square roots of the diagonal of (7.2.7), with the effective number of samples that the filter
    leaves."""


def batch_least_squares(stretches: Sequence[LinearModelSignals]) -> BatchLeastSquaresResult:
    """Fit a model to measured states, inputs and outputs.

    `stretches`: each without a gap; states, inputs and outputs alike in all.

    Raises
    ------
    FlightError
        If there are fewer samples than unknowns, or an input never moves.
    """
    first = stretches[0]
    dt = first.dt
    cutoff = max(select_cutoff(one.states, dt) for one in stretches)
    filtering = build_smoother(dt, cutoff)
    n, m = first.states.shape[1], first.inputs.shape[1]
    left, right = [], []
    for one in stretches:
        known = filtering.valid_samples(np.zeros(len(one), dtype=bool))
        rates = filtering.smooth(filtering.differentiate(one.states))[known]
        beside = filtering.smooth(
            filtering.simpson_average(np.hstack([one.states, one.inputs, one.outputs]))
        )[known]
        # A constant of each stretch is taken out with its mean values.
        beside = beside - beside.mean(axis=0)
        right.append(beside[:, : n + m])
        left.append(np.hstack([rates - rates.mean(axis=0), beside[:, n + m :]]))
    X, Y = np.vstack(right), np.vstack(left)
    # Samples that the filter made alike count as one.
    effective = len(X) / filtering.stride
    if effective < 2 * (n + m) + len(stretches):
        raise FlightError(
            f"{len(X)} samples are too few for least squares with {n + m} unknowns in each row; "
            "give longer maneuvers, or more of them"
        )
    spread = X.std(axis=0)
    still = [name for name, s in zip((*first.state_names, *first.input_names), spread, strict=True)
             if not s > 0.0]  # fmt: skip
    if still:
        raise FlightError(
            f"{', '.join(still)} does not move in these maneuvers; give maneuvers with that input"
        )
    solution, _, rank, _ = linalg.lstsq(X, Y)
    if rank < n + m:
        names = ", ".join((*first.state_names, *first.input_names))
        raise FlightError(
            f"some of {names} move together in these maneuvers; their effects cannot be "
            "separated; give other or more maneuvers"
        )
    errors = Y - X @ solution
    mse = np.sum(errors**2, axis=0) / (len(X) * (1.0 - (n + m) / effective))
    inverse = np.linalg.inv(X.T @ X).diagonal() * len(X) / effective
    table, std = solution.T, np.sqrt(np.outer(mse, inverse))
    return BatchLeastSquaresResult(
        model=LinearModel(
            states=first.state_names,
            inputs=first.input_names,
            outputs=first.output_names,
            A=table[:n, :n], B=table[:n, n:], C=table[n:, :n], D=table[n:, n:],
        ),
        A_std=std[:n, :n], B_std=std[:n, n:], C_std=std[n:, :n], D_std=std[n:, n:],
    )  # fmt: skip
