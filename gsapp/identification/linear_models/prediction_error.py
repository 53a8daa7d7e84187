"""Prediction error method: a state-space model refined until its predictions fit best.

All entries of A, B, C, D, K and the starts of the records are free (Ljung, System Identification,
chapter 7). Changes of the state's coordinates alter nothing, so the steps are those of Levenberg
and Marquardt, which do not move along such directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg

from gsapp.identification.linear_models.signals import (
    LINEAR_MODELS,
    DiscreteModel,
    InputOutputRecord,
)
from gsapp.quantities import FloatArray

IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PredictionErrorResult:
    """A refined model."""

    model: DiscreteModel
    initial_states: tuple[FloatArray, ...]  # Shape (n_states,).
    cost_before: float
    cost: float
    """Mean square of the scaled prediction errors."""
    iterations: int
    converged: bool


def refine_by_prediction_error(
    records: Sequence[InputOutputRecord],
    model: DiscreteModel,
    starts: Sequence[FloatArray],
    *,
    innovations: bool = False,
) -> PredictionErrorResult:
    """Refine a model.

    Parameters
    ----------
    model : DiscreteModel
        Where to start from, such as
        `gsapp.identification.linear_models.subspace.identify_subspace_model` gives.
    starts : sequence of ndarray
        State at the first sample of each record.
    innovations : bool
        Whether K is free, for noise that enters the states. Without it the simulated outputs are
        fitted, which is what a model that is to simulate needs.

    Returns
    -------
    PredictionErrorResult
        Stable, and no worse than the start.
    """
    weight = 1.0 / np.maximum(_output_scale(records), 1e-300)
    current, own_starts = model, [np.array(one) for one in starts]
    cost = before = _cost(records, current, own_starts, weight)
    damping, rounds, converged = 1e-3, 0, False
    while rounds < LINEAR_MODELS.max_iterations and not converged:
        rounds += 1
        normal, gradient = _normal_equations(records, current, own_starts, weight, innovations)
        scale = np.sqrt(np.maximum(normal.diagonal(), 1e-12 * normal.diagonal().max()))
        scaled, slope = normal / scale[:, None] / scale, gradient / scale
        improved = False
        for _ in range(8):
            step = linalg.solve(
                scaled + damping * np.eye(len(scaled)), slope, assume_a="pos"
            ) / scale  # fmt: skip
            trial, trial_starts = _apply_step(current, own_starts, step, innovations)
            value = _cost(records, trial, trial_starts, weight)
            if value < cost:
                converged = cost - value < LINEAR_MODELS.cost_tolerance * cost
                current, own_starts, cost = trial, trial_starts, value
                damping, improved = max(damping / 5.0, 1e-9), True
                break
            damping *= 5.0
        if not improved:
            converged = True
    return PredictionErrorResult(
        model=current, initial_states=tuple(own_starts), cost_before=before, cost=cost,
        iterations=rounds, converged=converged,
    )  # fmt: skip


def _output_scale(records: Sequence[InputOutputRecord]) -> FloatArray:
    outputs = np.vstack([record.outputs for record in records])
    return np.asarray(outputs.std(axis=0), dtype=np.float64)


def _cost(
    records: Sequence[InputOutputRecord],
    model: DiscreteModel,
    starts: Sequence[FloatArray],
    weight: FloatArray,
) -> float:
    """Return the mean square of the scaled errors; infinite for an unstable predictor."""
    closed = model.A - model.K @ model.C
    if max(np.abs(np.linalg.eigvals(closed)).max(), np.abs(np.linalg.eigvals(model.A)).max()) >= 1:
        return float("inf")
    total, count = 0.0, 0
    for record, start in zip(records, starts, strict=True):
        error = (record.outputs - model.predict(record, start)) * weight
        total += float(np.sum(error * error))
        count += error.size
    return total / count


def _block_sizes(model: DiscreteModel, innovations: bool) -> tuple[int, ...]:
    n, m, p = model.order, model.B.shape[1], model.C.shape[0]
    return n * n, n * m, p * n, p * m, n * p if innovations else 0


def _apply_step(
    model: DiscreteModel, starts: Sequence[FloatArray], step: FloatArray, innovations: bool
) -> tuple[DiscreteModel, list[FloatArray]]:
    parts = np.split(step, np.cumsum(_block_sizes(model, innovations)))
    A, B, C, D, K = (part.reshape(-1) for part in parts[:5])
    moved = replace(
        model,
        A=model.A + A.reshape(model.A.shape),
        B=model.B + B.reshape(model.B.shape),
        C=model.C + C.reshape(model.C.shape),
        D=model.D + D.reshape(model.D.shape),
        K=model.K + K.reshape(model.K.shape) if innovations else model.K,
    )
    shifts = parts[5].reshape(len(starts), model.order)
    return moved, [start + shift for start, shift in zip(starts, shifts, strict=True)]


class _EntryIndices(NamedTuple):
    """Where the entries of each matrix stand: rows and columns of a table of slopes.

    An entry (i, j) of A, B or K moves state i as x, u or e number j does; one of C or D moves
    output i.
    """

    A: tuple[IndexArray, IndexArray]
    B: tuple[IndexArray, IndexArray]
    C: tuple[IndexArray, IndexArray]
    D: tuple[IndexArray, IndexArray]
    K: tuple[IndexArray, IndexArray]

    @classmethod
    def of(cls, model: DiscreteModel, innovations: bool) -> _EntryIndices:
        n, m, p = model.order, model.B.shape[1], model.C.shape[0]
        sizes = _block_sizes(model, innovations)
        first = np.concatenate(([0], np.cumsum(sizes)))
        shapes = ((n, n), (n, m), (p, n), (p, m), (n if innovations else 0, p))
        return cls(
            *(
                (np.repeat(np.arange(rows), columns), start + np.arange(rows * columns))
                for (rows, columns), start in zip(shapes, first[:5], strict=True)
            )
        )


def _normal_equations(
    records: Sequence[InputOutputRecord],
    model: DiscreteModel,
    starts: Sequence[FloatArray],
    weight: FloatArray,
    innovations: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return the Gauss-Newton matrix and right side over all free entries."""
    n, p = model.order, model.C.shape[0]
    shared = sum(_block_sizes(model, innovations))
    places = _EntryIndices.of(model, innovations)
    closed = model.A - model.K @ model.C
    feedback = bool(model.K.any())
    normal = np.zeros((shared + n * len(records),) * 2)
    gradient = np.zeros(normal.shape[0])
    for number, (record, start) in enumerate(zip(records, starts, strict=True)):
        count = len(record)
        slopes = np.zeros((n, shared + n))
        slopes[:, shared:] = np.eye(n)
        direct = np.zeros((p, shared + n))
        state = start
        table = np.empty((count, p, shared + n))
        errors = np.empty((count, p))
        for k in range(count):
            u = record.inputs[k]
            error = record.outputs[k] - model.C @ state - model.D @ u
            direct[places.C] = np.tile(state, p)
            direct[places.D] = np.tile(u, p)
            errors[k] = error
            table[k] = model.C @ slopes + direct
            slopes = closed @ slopes
            slopes[places.A] += np.tile(state, n)
            slopes[places.B] += np.tile(u, n)
            if feedback:
                # C and D act on the state through the error, too.
                slopes -= model.K @ direct
            if innovations:
                slopes[places.K] += np.tile(error, n)
            state = model.A @ state + model.B @ u + model.K @ error
        flat = (table * weight[:, None]).reshape(count * p, -1)
        own = np.r_[0:shared, shared + number * n : shared + (number + 1) * n]
        normal[np.ix_(own, own)] += flat.T @ flat
        gradient[own] += flat.T @ (errors * weight).ravel()
    return normal, gradient
