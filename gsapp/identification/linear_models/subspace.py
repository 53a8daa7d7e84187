"""Subspace identification, in one step, and the prediction error method, by iteration.

The past-and-future scheme of Van Overschee and De Moor (N4SID, 1994), with the weights of
canonical variates: future outputs are projected along future inputs onto the past; the singular
values of that projection tell the order, its left singular vectors the observability matrix.
B, D and the starts of the records then follow by linear least squares on the simulated outputs
(Ljung, System Identification, section 10.6).

For the prediction error all entries of A, B, C, D, K and the starts of the records are free
(Ljung, chapter 7). Changes of the state's coordinates alter nothing, so the steps are those of
Levenberg and Marquardt, which do not move along such directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg

from gsapp.foundation import FlightError
from gsapp.identification.linear_models.signals import (
    LINEAR_MODELS,
    DiscreteModel,
    InputOutputRecord,
)
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SubspaceResult:
    """A model and what its order was chosen from."""

    model: DiscreteModel
    singular_values: FloatArray
    """Of the weighted projection, largest first: canonical correlations of past and future."""
    order: int
    initial_states: tuple[FloatArray, ...]
    """Shape (n_states,). State at the first sample of each record."""


def identify_subspace_model(
    records: Sequence[InputOutputRecord],
    dt: float,
    *,
    order: int | None = None,
    horizon: int | None = None,
) -> SubspaceResult:
    """Identify a discrete model.

    Parameters
    ----------
    records : sequence of InputOutputRecord
        Stretches of one aircraft; columns of the block Hankel matrices never span two.
    dt : float
        Sample time, s.
    order : int, optional
        Number of states; otherwise `select_order`.
    horizon : int, optional
        Samples of past, and of future; by default 0.4 s worth of samples, less where the records
        are short, and at least what the order needs.

    Raises
    ------
    FlightError
        If the records are too short for the order asked for.
    """
    p = records[0].outputs.shape[1]
    block = horizon or _horizon(records, dt, -(-(order or 4) // p) + 2)
    chosen = select_order(records, dt, block) if order is None else order
    highest = min(p * (block - 1), LINEAR_MODELS.max_order)
    if not 1 <= chosen <= highest:
        raise FlightError(
            f"order {chosen} does not suit a horizon of {block} samples; ask for 1 to {highest}"
        )
    projection = _Projection.of(records, block)
    A, C = projection.system(chosen)
    B, D, starts = fit_inputs_and_initial_states(records, A, C)
    model = DiscreteModel(A=A, B=B, C=C, D=D, K=np.zeros((chosen, p)), dt=dt)
    return SubspaceResult(
        model=model, singular_values=projection.singular_values, order=chosen, initial_states=starts
    )


def _horizon(records: Sequence[InputOutputRecord], dt: float, least: int) -> int:
    """Return the longest horizon up to 0.4 s that leaves two columns for each row."""
    width = records[0].inputs.shape[1] + records[0].outputs.shape[1]
    for block in range(max(round(0.4 / dt), least), least, -1):
        columns = sum(max(len(one) - 2 * block + 1, 0) for one in records if len(one) >= 4 * block)
        if columns >= 4 * block * width:
            return block
    return least


def select_order(records: Sequence[InputOutputRecord], dt: float, horizon: int) -> int:
    """Return the least order that simulates maneuvers it was not made from as well as any.

    Each half of the records is simulated, from rest, by models of the other half; an order counts
    as good as the best if its mean square error is within a twentieth of it. A single record is
    halved in time.
    """
    halves = _split_in_halves(records)
    costs = np.zeros(LINEAR_MODELS.max_tried_order)
    for one, other in (halves, halves[::-1]):
        projection = _Projection.of(one, horizon)
        spread = np.vstack([record.outputs for record in other]).std(axis=0)
        for order in range(1, LINEAR_MODELS.max_tried_order + 1):
            A, C = projection.system(order)
            B, D, _ = fit_inputs_and_initial_states(one, A, C)
            gain = np.zeros((order, C.shape[0]))
            model = DiscreteModel(A=A, B=B, C=C, D=D, K=gain, dt=dt)
            for record in other:
                miss = (record.outputs - model.simulate(record.inputs)) / spread
                costs[order - 1] += float(np.sum(miss**2))
    return int(np.flatnonzero(costs <= 1.05 * costs.min())[0]) + 1


def _split_in_halves(
    records: Sequence[InputOutputRecord],
) -> tuple[Sequence[InputOutputRecord], Sequence[InputOutputRecord]]:
    if len(records) > 1:
        return records[::2], records[1::2]
    only, middle = records[0], len(records[0]) // 2
    return tuple(
        (InputOutputRecord(inputs=only.inputs[rows], outputs=only.outputs[rows]),)
        for rows in (slice(0, middle), slice(middle, None))
    )  # type: ignore[return-value]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Projection:
    """The projection of future outputs onto the past, in its singular directions."""

    left: FloatArray  # Left singular vectors times the weight.
    singular_values: FloatArray
    width: int  # Number of outputs.

    @classmethod
    def of(cls, records: Sequence[InputOutputRecord], block: int) -> _Projection:
        m, p = records[0].inputs.shape[1], records[0].outputs.shape[1]
        usable = [one for one in records if len(one) >= 4 * block]
        columns = sum(len(one) - 2 * block + 1 for one in usable)
        if columns < 2 * block * (m + p) + 10:
            samples = sum(len(one) for one in records)
            raise FlightError(
                f"{samples} samples are too few for a subspace model with a horizon of {block} "
                "samples; give longer maneuvers, more of them, or a lower order"
            )
        U = np.hstack([_hankel(one.inputs, 2 * block) for one in usable])
        Y = np.hstack([_hankel(one.outputs, 2 * block) for one in usable])
        past = np.vstack([U[: m * block], Y[: p * block]])
        # LQ of everything: projections are then products of small triangles.
        stacked = np.vstack([U[m * block :], past, Y[p * block :]])
        triangle = linalg.qr(stacked.T, mode="r", overwrite_a=True)[0][: stacked.shape[0]].T
        nu, nw = m * block, past.shape[0]
        R22 = triangle[nu : nu + nw, nu : nu + nw]
        R32 = triangle[nu + nw :, nu : nu + nw]
        R33 = triangle[nu + nw :, nu + nw :]
        # Future outputs with future inputs taken out: signal from the past, and noise.
        oblique = R32 @ linalg.pinv(R22) @ R22
        spread = oblique @ oblique.T + R33 @ R33.T
        ridge = LINEAR_MODELS.ridge * np.trace(spread) / len(spread)
        weight = linalg.cholesky(spread + ridge * np.eye(len(spread)), lower=True)
        left, singular, _ = linalg.svd(linalg.solve_triangular(weight, oblique, lower=True))
        return cls(left=weight @ left, singular_values=singular, width=p)

    def system(self, order: int) -> tuple[FloatArray, FloatArray]:
        """Return A, made stable, and C of a model of that order."""
        observability = self.left[:, :order] * np.sqrt(self.singular_values[:order])
        p = self.width
        A = linalg.lstsq(observability[:-p], observability[p:])[0]
        return _stabilize(A), observability[:p]


def fit_inputs_and_initial_states(
    records: Sequence[InputOutputRecord], A: FloatArray, C: FloatArray
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, ...]]:
    """Return B, D and the start of each record that fit the outputs best, given A and C.

    The simulated outputs are linear in all three.
    """
    n, p = A.shape[0], C.shape[0]
    m = records[0].inputs.shape[1]
    shared = n * m + p * m
    normal = np.zeros((shared + n * len(records),) * 2)
    right = np.zeros(shared + n * len(records))
    for index, record in enumerate(records):
        count = len(record)
        # State responses to each input entering each state, and to each start.
        states = np.zeros((n, n * m + n))
        states[:, n * m :] = np.eye(n)
        table = np.zeros((count, p, shared + n))
        drive = np.zeros((n, n * m + n))
        for k in range(count):
            table[k, :, : n * m] = C @ states[:, : n * m]
            table[k, :, shared:] = C @ states[:, n * m :]
            for row in range(n):
                drive[row, row * m : (row + 1) * m] = record.inputs[k]
            states = A @ states + drive
        for row in range(p):
            table[:, row, n * m + row * m : n * m + (row + 1) * m] = record.inputs
        flat = table.reshape(count * p, -1)
        own = np.r_[0:shared, shared + index * n : shared + (index + 1) * n]
        normal[np.ix_(own, own)] += flat.T @ flat
        right[own] += flat.T @ record.outputs.ravel()
    scale = np.sqrt(np.maximum(normal.diagonal(), 1e-300))
    solved = linalg.lstsq(normal / scale[:, None] / scale, right / scale, cond=1e-12)[0] / scale
    B = solved[: n * m].reshape(n, m)
    D = solved[n * m : shared].reshape(p, m)
    starts = tuple(solved[shared + k * n : shared + (k + 1) * n] for k in range(len(records)))
    return B, D, starts


def _hankel(samples: FloatArray, rows: int) -> FloatArray:
    """Return block rows of successive samples, shape (rows * width, n - rows + 1)."""
    windows = np.lib.stride_tricks.sliding_window_view(samples, rows, axis=0)
    # (columns, width, rows) to (rows, width, columns)
    return np.ascontiguousarray(windows.transpose(2, 1, 0)).reshape(-1, windows.shape[0])


def _stabilize(A: FloatArray) -> FloatArray:
    """Pull poles on or outside the unit circle just inside."""
    values, vectors = np.linalg.eig(A)
    outside = np.abs(values) >= 1.0
    if not outside.any():
        return A
    values = np.where(outside, values / np.abs(values) * 0.9995, values)
    pulled: FloatArray = np.real(vectors @ np.diag(values) @ np.linalg.inv(vectors))
    return pulled


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
    for index, (record, start) in enumerate(zip(records, starts, strict=True)):
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
        own = np.r_[0:shared, shared + index * n : shared + (index + 1) * n]
        normal[np.ix_(own, own)] += flat.T @ flat
        gradient[own] += flat.T @ (errors * weight).ravel()
    return normal, gradient
