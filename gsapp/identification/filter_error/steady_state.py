"""The steady-state Kalman predictor: covariance, innovations, and adjoints of any linear system.

The covariance settles by the structure-preserving doubling algorithm, each round of which does as
many steps of the Riccati recursion as all rounds before it together (E. Chu, H. Fan, W. Lin and
C. Wang, International Journal of Control 77, 2004): with matrices of a dozen rows a fraction of
what a decomposition of the pencil costs. `filter_error` and `compatibility` build on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are
from scipy.linalg.lapack import dtbtrs

from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import BoolArray, FloatArray


def steady_covariance(
    A: FloatArray, C: FloatArray, process: FloatArray, measurement: FloatArray, shared: FloatArray
) -> FloatArray:
    """Return the covariance P of predicted states where it has settled.

    P = A P A' + Q - (A P C' + S)(C P C' + R)^-1 (A P C' + S)'.

    Parameters
    ----------
    A : ndarray, shape (n_x, n_x)
        Transition.
    C : ndarray, shape (n_y, n_x)
    process : ndarray, shape (n_x, n_x)
        Q.
    measurement : ndarray, shape (n_y, n_y)
        R.
    shared : ndarray, shape (n_x, n_y)
        S: covariance of both noises.

    Raises
    ------
    scipy.linalg.LinAlgError
        If there is none.
    """
    try:
        own = np.linalg.solve(measurement, np.hstack((C, shared.T)))
        # What both noises share is taken out of the process.
        P, settled = _double(
            (A - shared @ own[:, : len(A)]).T,
            C.T @ own[:, : len(A)],
            process - shared @ own[:, len(A) :],
            FILTER_ERROR.max_doublings,
        )
    except LinAlgError:
        settled = False
    if settled:
        crossed = A @ P @ C.T + shared
        left = A @ P @ A.T + process - P
        left -= crossed @ np.linalg.solve(C @ P @ C.T + measurement, crossed.T)
        if np.abs(left).max() <= FILTER_ERROR.residual_tolerance * np.abs(P).max():
            return P
    found: FloatArray = solve_discrete_are(A.T, C.T, process, measurement, s=shared)
    return found


def solve_lyapunov(A: FloatArray, first: FloatArray) -> FloatArray:
    """Return X = A' X A + first, for A whose powers die out: twice as many terms each round.

    `A` and `first`, shape (n_x, n_x).

    Raises `scipy.linalg.LinAlgError` if the powers grow.
    """
    total, power = first, A
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(FILTER_ERROR.max_doublings):
            change = power.T @ total @ power
            total = total + change
            if not np.isfinite(total).all():
                break
            if np.abs(change).max() <= FILTER_ERROR.covariance_tolerance * np.abs(total).max():
                return total
            power = power @ power
    raise LinAlgError("the sum has no limit: the system does not forget")


def propagated_covariance(
    A: FloatArray, information: FloatArray, process: FloatArray, doublings: int
) -> FloatArray:
    """Return the covariance P of predicted states after 2**doublings steps from a known state.

    A state that nothing shows grows as its random walk does, without harm.

    Parameters
    ----------
    A : ndarray, shape (n_x, n_x)
        Transition.
    information : ndarray, shape (..., n_x, n_x)
        C' R^-1 C.
    process : ndarray, shape (..., n_x, n_x)
        Q.
    """
    return _double(np.broadcast_to(A.T, process.shape), information, process, doublings)[0]


def _double(A: FloatArray, G: FloatArray, P: FloatArray, rounds: int) -> tuple[FloatArray, bool]:
    """Return the covariance for the transposed transition A, and whether it has settled."""
    size = A.shape[-1]
    unit = np.eye(size)
    with np.errstate(all="ignore"):
        for _ in range(rounds):
            both = np.linalg.solve(unit + G @ P, np.concatenate((A, G), axis=-1))
            change = A.swapaxes(-1, -2) @ P @ both[..., :size]
            G = G + A @ both[..., size:] @ A.swapaxes(-1, -2)
            P = P + 0.5 * (change + change.swapaxes(-1, -2))
            A = A @ both[..., :size]
            if not np.isfinite(P).all():
                return P, False
            if np.abs(change).max() <= FILTER_ERROR.covariance_tolerance * np.abs(P).max():
                return P, True
    return P, False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InnovationsForm:
    """A linear system in innovations form: d[k+1] = M_k d[k] + J_k z[k] + b[k], e = z - C_k d."""

    by_state: FloatArray  # Shape (n, n_y, n_x). C.
    propagation: FloatArray  # Shape (n - 1, n_x, n_x). M = Phi (1 - K C).
    injection: FloatArray  # Shape (n - 1, n_x, n_y). J = Phi K, zero for outputs that do not count.
    valid: BoolArray  # Shape (n, n_y). Which outputs count.

    def predict(
        self, z: FloatArray, b: FloatArray | None = None, start: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the innovations (n, n_y, m) and deviations (n, n_x, m) of m signals.

        Parameters
        ----------
        z : ndarray, shape (n, n_y, m)
        b : ndarray, shape (n - 1, n_b, m), optional
            What enters the first n_b states.
        start : ndarray, shape (n_b, m), optional
            Deviation of the first n_b states at the first sample.
        """
        whole = self.valid.all()
        if not whole:
            z = z * self.valid[:, :, None]
        rows = np.zeros((len(z), self.by_state.shape[2], z.shape[2]))
        np.matmul(self.injection, z[:-1], out=rows[1:])
        if b is not None:
            rows[1:, : b.shape[1]] += b
        if start is not None:
            rows[0, : len(start)] = start
        deviations = solve_forward(self.propagation, rows)
        found = z - self.by_state @ deviations
        if not whole:
            found *= self.valid[:, :, None]
        return found, deviations


def solve_forward(propagation: FloatArray, rows: FloatArray) -> FloatArray:
    """Solve d[0] = b[0], d[k+1] - M_k d[k] = b[k+1].

    `propagation`, shape (n - 1, n_x, n_x).
    `rows`, shape (n, n_x, m): right-hand sides; overwritten with the solution, which is returned.
    """
    steps, size, _ = propagation.shape
    n, _, m = rows.shape
    if m > FILTER_ERROR.max_banded_columns:
        # With many right-hand sides a product a step is quicker than the banded solver.
        for k in range(steps):
            rows[k + 1] += propagation[k] @ rows[k]
        return rows
    band = np.zeros((n, size, 2 * size))
    for i in range(size):
        for j in range(size):
            band[:-1, j, size + i - j] = -propagation[:, i, j]
    flat = np.asfortranarray(rows.reshape(n * size, m))
    solved, _ = dtbtrs(band.reshape(n * size, 2 * size).T, flat, uplo="L", diag="U", overwrite_b=1)
    return np.asarray(solved).reshape(n, size, m)
