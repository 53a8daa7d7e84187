"""Trajectories and sensitivities of a segment, all samples at once.

The discretized equations x[k+1] = F_k(x[k]) (one Runge-Kutta or Euler step per sample) are solved
for all k together by Newton's method: F_k and its exact derivative Phi_k come from whole arrays,
and the correction from the block-bidiagonal system

    dx[k+1] - Phi_k dx[k] = F_k(x[k]) - x[k+1]

as one banded triangular solve. Started from the last iterate plus what its sensitivities promise,
one or two rounds reach the solution to rounding, the same as stepping through time does. The
sensitivities S[k+1] = Phi_k S[k] + Gamma_k are one more such solve with many right-hand sides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np
from scipy.linalg.lapack import dtbtrs

from gsapp.identification.maximum_likelihood.kernels import Forcing, Gradient, Kernel
from gsapp.identification.maximum_likelihood.settings import ML_ALGORITHM
from gsapp.quantities import FloatArray

IntegrationMethod = Literal["rk4", "euler"]
_Result = TypeVar("_Result", bound=tuple[Any, ...])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SegmentForcing:
    """Drives of one segment: at the samples, and halfway between them (inputs averaged)."""

    samples: Forcing
    halfway: Forcing

    @property
    def at_step_start(self) -> Forcing:
        return self.samples.select_instants(slice(0, -1))

    @property
    def at_step_end(self) -> Forcing:
        return self.samples.select_instants(slice(1, None))


def build_segment_forcing(
    kernel: Kernel,
    states: FloatArray,
    inputs: FloatArray,
    by_path: FloatArray | None,
    values: FloatArray,
) -> SegmentForcing:
    """Return the drives for measured states (9, n) and inputs (8, n), straight between samples."""

    def halfway(row: FloatArray) -> FloatArray:
        middle: FloatArray = 0.5 * (row[..., 1:] + row[..., :-1])
        return middle

    between = None if by_path is None else halfway(by_path)
    return SegmentForcing(
        samples=kernel.build_forcing(states, inputs, by_path, values),
        halfway=kernel.build_forcing(halfway(states), halfway(inputs), between, values),
    )


def _multiply_matrices(A: FloatArray, B: FloatArray) -> FloatArray:
    """Return the products A_k B_k of matrices with time last: (i, j, n), (j, m, n) -> (i, m, n)."""
    rows, inner, count = A.shape
    if rows * inner <= 16:
        out = np.empty((rows, B.shape[1], count))
        part = np.empty(B.shape[1:])
        for i in range(rows):
            np.multiply(A[i, 0], B[0], out=out[i])
            for j in range(1, inner):
                np.multiply(A[i, j], B[j], out=part)
                out[i] += part
        return out
    first = np.ascontiguousarray(A.transpose(2, 0, 1))
    second = np.ascontiguousarray(B.transpose(2, 0, 1))
    return np.ascontiguousarray((first @ second).transpose(1, 2, 0))


def _step_jacobians(
    slopes: Sequence[FloatArray], h: float
) -> tuple[FloatArray, list[FloatArray | None]]:
    """Return Phi, and by what the gradients of each stage enter the step (None: the unit matrix).

    A Runge-Kutta step is x + h/6 (k1 + 2 k2 + 2 k3 + k4). Gone through from its end, with a_s the
    slopes of the rates at stage s, what stage s adds to k_s enters the bracket times

        P4 = I,  P3 = 2 I + h P4 a4,  P2 = 2 I + h/2 P3 a3,  P1 = I + h/2 P2 a2,

    so that Phi = I + h/6 sum P_s a_s and Gamma = h/6 sum P_s g_s with the gradients g_s.
    """
    unit = np.eye(len(slopes[0]))[:, :, None]
    if len(slopes) == 1:
        return unit + h * slopes[0], [None]
    a1, a2, a3, a4 = slopes
    P3 = 2.0 * unit + h * a4
    third = _multiply_matrices(P3, a3)
    P2 = 2.0 * unit + 0.5 * h * third
    second = _multiply_matrices(P2, a2)
    P1 = unit + 0.5 * h * second
    Phi: FloatArray = unit + h / 6.0 * (_multiply_matrices(P1, a1) + second + third + a4)
    return Phi, [P1, P2, P3, None]


def _accumulate_gradient(carrier: FloatArray | None, gradient: Gradient, total: FloatArray) -> None:
    """Add a carrier (None: the unit matrix) times a gradient to a total."""
    if isinstance(gradient, np.ndarray):
        total += gradient if carrier is None else _multiply_matrices(carrier, gradient)
        return
    for columns, factors, basis in gradient:
        if carrier is None:
            for row, factor in factors:
                total[row, columns] += factor * basis
            continue
        (row, factor), *others = factors
        carried = carrier[:, row] * factor
        for row, factor in others:
            carried += carrier[:, row] * factor
        for state, one in enumerate(carried):
            total[state, columns] += one * basis


class TrajectorySolver:
    """Steps, trajectories and sensitivities with one kernel."""

    def __init__(self, kernel: Kernel, integration: IntegrationMethod) -> None:
        self.kernel = kernel
        self._integration = integration

    # --- one step -------------------------------------------------------------------------------

    def _step(
        self, drives: SegmentForcing, x: FloatArray, h: float, values: FloatArray
    ) -> FloatArray:
        """Return F_k(x_k) for x of shape (n_states, n - 1)."""
        rates = self.kernel.rates
        k1 = rates(drives.at_step_start, x, values)
        if self._integration == "euler":
            return x + h * k1
        k2 = rates(drives.halfway, x + 0.5 * h * k1, values)
        k3 = rates(drives.halfway, x + 0.5 * h * k2, values)
        k4 = rates(drives.at_step_end, x + h * k3, values)
        stepped: FloatArray = x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        return stepped

    def _stages(
        self,
        evaluate: Callable[[Forcing, FloatArray, FloatArray], _Result],
        drives: SegmentForcing,
        x: FloatArray,
        h: float,
        values: FloatArray,
    ) -> list[_Result]:
        """Return what a method of the kernel, rates first, gives at every stage of the steps."""
        found = [evaluate(drives.at_step_start, x, values)]
        if self._integration == "rk4":
            halfway, after = drives.halfway, drives.at_step_end
            for drive, reach in ((halfway, 0.5 * h), (halfway, 0.5 * h), (after, h)):
                found.append(evaluate(drive, x + reach * found[-1][0], values))
        return found

    def _step_slopes(
        self, drives: SegmentForcing, x: FloatArray, h: float, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return F_k and Phi_k, shape (n_states, n_states, n - 1)."""
        stages = self._stages(self.kernel.jacobian, drives, x, h, values)
        Phi, _ = _step_jacobians([f_x for _, f_x in stages], h)
        rates = [f for f, _ in stages]
        if len(rates) == 1:
            return x + h * rates[0], Phi
        k1, k2, k3, k4 = rates
        return x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4), Phi

    def _step_gradients(
        self, drives: SegmentForcing, x: FloatArray, h: float, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return Phi_k and Gamma_k, shape (n_states, n_free, n - 1)."""
        stages = self._stages(self.kernel.gradients, drives, x, h, values)
        Phi, carriers = _step_jacobians([f_x for _, f_x, _ in stages], h)
        Gamma = np.zeros((len(x), len(self.kernel.free), x.shape[1]))
        for carrier, (_, _, gradient) in zip(carriers, stages, strict=True):
            _accumulate_gradient(carrier, gradient, Gamma)
        Gamma *= h / (1.0 if len(stages) == 1 else 6.0)
        return Phi, Gamma

    # --- trajectories ---------------------------------------------------------------------------

    def trajectory(
        self,
        drives: SegmentForcing,
        h: float,
        values: FloatArray,
        start: FloatArray,
        guess: FloatArray,
        *,
        Phi: FloatArray | None = None,
        at_any_rate: bool = False,
    ) -> FloatArray | None:
        """Return the states at all samples, shape (n_states, n); None where the model diverges.

        Parameters
        ----------
        drives : SegmentForcing
            What moves the equations besides their states.
        h : float
            Sample time, s.
        values : ndarray, shape (n_parameters,)
            Parameters of the equations.
        start : ndarray, shape (n_states,)
            At the first sample.
        guess : ndarray, shape (n_states, n)
        Phi : ndarray, shape (n_states, n_states, n - 1), optional
            Derivatives of the steps near by. Where exact ones are dear, these do instead.
        at_any_rate : bool
            Step through time, slowly, where Newton's method fails.
        """
        with np.errstate(all="ignore"):
            found = None
            if Phi is not None and self.kernel.jacobian_is_expensive:
                found = self._newton(drives, h, values, start, guess, Phi)
            if found is None:
                found = self._newton(drives, h, values, start, guess, None)
            if found is None and at_any_rate:
                found = self._in_sequence(drives, h, values, start)
        return found

    def _newton(
        self,
        drives: SegmentForcing,
        h: float,
        values: FloatArray,
        start: FloatArray,
        guess: FloatArray,
        near: FloatArray | None,
    ) -> FloatArray | None:
        """Return the trajectory by Newton's method, with exact slopes or those near by."""
        x = guess.copy()
        # With exact slopes a correction leaves its square, else a small share of itself.
        settled = ML_ALGORITHM.newton_tolerance if near is None else ML_ALGORITHM.chord_tolerance
        for _ in range(ML_ALGORITHM.max_newton_iterations):
            if near is None:
                stepped, Phi = self._step_slopes(drives, x[:, :-1], h, values)
            else:
                stepped, Phi = self._step(drives, x[:, :-1], h, values), near
            gap = np.empty((1, x.shape[1], x.shape[0]))
            gap[0, 0] = start - x[:, 0]
            gap[0, 1:] = (stepped - x[:, 1:]).T
            change = _solve_bidiagonal(Phi, gap)[0].T
            x += change
            size = np.abs(x)
            if not size.max() < ML_ALGORITHM.divergence_limit:
                return None
            if (np.abs(change) <= settled * np.maximum(size, 1.0)).all():
                return x
        return None

    def _in_sequence(
        self, drives: SegmentForcing, h: float, values: FloatArray, start: FloatArray
    ) -> FloatArray | None:
        """Return the trajectory stepped through time: for motions on which Newton fails."""
        count = drives.samples.states.shape[1]
        x = np.empty((start.size, count))
        x[:, 0] = start
        for k in range(count - 1):
            one = SegmentForcing(
                samples=drives.samples.select_instants(slice(k, k + 2)),
                halfway=drives.halfway.select_instants(slice(k, k + 1)),
            )
            x[:, k + 1 : k + 2] = self._step(one, x[:, k : k + 1], h, values)
            if not np.abs(x[:, k + 1]).max() < ML_ALGORITHM.divergence_limit:
                return None
        return x

    def sensitivities(
        self,
        drives: SegmentForcing,
        h: float,
        values: FloatArray,
        x: FloatArray,
        by_start: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of the states, shape (n_states, n_free + n_start, n), and Phi.

        Parameters
        ----------
        drives, h, values
            As in `trajectory`.
        x : ndarray, shape (n_states, n)
            The states at all samples.
        by_start : ndarray, shape (n_states, n_start)
            Derivatives of the first sample by the free initial states.
        """
        Phi, Gamma = self._step_gradients(drives, x[:, :-1], h, values)
        size, free, steps = Gamma.shape
        columns = np.zeros((free + by_start.shape[1], steps + 1, size))
        columns[free:, 0] = by_start.T
        columns[:free, 1:] = Gamma.transpose(1, 2, 0)
        return np.ascontiguousarray(_solve_bidiagonal(Phi, columns).transpose(2, 0, 1)), Phi


def _solve_bidiagonal(Phi: FloatArray, columns: FloatArray) -> FloatArray:
    """Solve d[0] = b[0], d[k+1] - Phi_k d[k] = b[k+1].

    `Phi`, shape (n_states, n_states, n - 1).
    `columns`, shape (m, n, n_states): right-hand sides; overwritten.
    """
    size, _, steps = Phi.shape
    band = np.zeros((steps + 1, size, 2 * size))
    for i in range(size):
        for j in range(size):
            band[:-1, j, size + i - j] = -Phi[i, j]
    m, count, _ = columns.shape
    flat = columns.reshape(m, count * size).T
    # LAPACK's columns are this array's rows: no copies.
    solved, _ = dtbtrs(
        band.reshape(count * size, 2 * size).T, flat, uplo="L", diag="U", overwrite_b=1
    )
    return np.asarray(solved.T.reshape(m, count, size))
