"""The steady covariance of a filter: its Riccati equation by doubling.

Each round of the structure-preserving doubling algorithm does as many steps of the recursion as
all rounds before it together (E. Chu, H. Fan, W. Lin and C. Wang, International Journal of Control
77, 2004): with matrices of a dozen rows a fraction of what a decomposition of the pencil costs.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are

from gsapp.quantities import FloatArray

_MAX_ITERATIONS = 40
_TOLERANCE = 1e-15
_RESIDUAL_TOLERANCE = 1e-9
"""Share of the covariance by which the equation may be off; else the pencil is decomposed."""


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
    P = _solve_by_doubling(A, C, process, measurement, shared)
    if P is not None:
        crossed = A @ P @ C.T + shared
        left = A @ P @ A.T + process - P
        left -= crossed @ np.linalg.solve(C @ P @ C.T + measurement, crossed.T)
        if np.abs(left).max() <= _RESIDUAL_TOLERANCE * np.abs(P).max():
            return P
    found: FloatArray = solve_discrete_are(A.T, C.T, process, measurement, s=shared)
    return found


def solve_lyapunov(A: FloatArray, first: FloatArray) -> FloatArray:
    """Return X = A' X A + first, for A whose powers die out: twice as many terms each round.

    Parameters
    ----------
    A, first : ndarray, shape (n_x, n_x)

    Raises
    ------
    scipy.linalg.LinAlgError
        If the powers grow.
    """
    total, power = first, A
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(_MAX_ITERATIONS):
            change = power.T @ total @ power
            total = total + change
            if not np.isfinite(total).all():
                break
            if np.abs(change).max() <= _TOLERANCE * np.abs(total).max():
                return total
            power = power @ power
    raise LinAlgError("the sum has no limit: the system does not forget")


def _solve_by_doubling(
    A: FloatArray, C: FloatArray, process: FloatArray, measurement: FloatArray, shared: FloatArray
) -> FloatArray | None:
    """Return the covariance, or None where the rounds do not settle."""
    size = len(A)
    unit = np.eye(size)
    try:
        own = np.linalg.solve(measurement, np.hstack((C, shared.T)))
        # What both noises share is taken out of the process.
        step = (A - shared @ own[:, :size]).T
        seen = C.T @ own[:, :size]
        P = process - shared @ own[:, size:]
        with np.errstate(all="ignore"):
            for _ in range(_MAX_ITERATIONS):
                both = np.linalg.solve(unit + seen @ P, np.hstack((step, seen)))
                change = step.T @ P @ both[:, :size]
                seen = seen + step @ both[:, size:] @ step.T
                P = P + 0.5 * (change + change.T)
                step = step @ both[:, :size]
                if not np.isfinite(P).all():
                    return None
                if np.abs(change).max() <= _TOLERANCE * np.abs(P).max():
                    return P
    except LinAlgError:
        return None
    return None
