"""What residuals tell: how frequencies go together, and what of the rates goes with them."""

from __future__ import annotations

import math

import numpy as np

from gsapp.identification.ftr.axis_dynamics import AxisDynamics
from gsapp.identification.ftr.transform import ComplexArray
from gsapp.quantities import FloatArray


class ScratchBuffer:
    """Memory for the one large matrix: asking the system for it anew costs more than filling it."""

    def __init__(self) -> None:
        self._memory = np.empty(0)

    def array(self, *shape: int) -> FloatArray:
        """Return an array that holds until the next is taken; what is in it is left over."""
        size = math.prod(shape)
        if size > self._memory.size:
            self._memory = np.empty(size)
        return self._memory[:size].reshape(shape)


def frequency_coupling(correlation: ComplexArray, m: int, scratch: ScratchBuffer) -> FloatArray:
    """Return the covariance of real over imaginary residuals of unit level, (U, 2 m, 2 m)."""
    # K of a negative frequency is the conjugate. Running forwards and backwards, and half of it,
    # so that all that is added below lies in memory one after the other.
    half = 0.5 * correlation
    around = np.concatenate((half[:, m - 1 :: -1], half[:, 1:m].conj()), axis=1)
    out = scratch.array(len(correlation), 2 * m, 2 * m)
    above, below = out[:, :m], out[:, m:]
    minus, plus = (
        _sliding_windows(around.real.copy(), m)[:, ::-1],
        _sliding_windows(half.real[:, 2:].copy(), m),
    )
    np.add(minus, plus, out=above[:, :, :m])
    np.subtract(minus, plus, out=below[:, :, m:])
    minus, plus = (
        _sliding_windows(around.imag.copy(), m)[:, ::-1],
        _sliding_windows(half.imag[:, 2:].copy(), m),
    )
    np.add(minus, plus, out=below[:, :, :m])
    np.subtract(plus, minus, out=above[:, :, m:])
    return out


def _sliding_windows(row: FloatArray, m: int) -> FloatArray:
    along, across = row.strides
    return np.ndarray((len(row), m, m), row.dtype, row, 0, (along, across, across))


def rate_response(
    residual: FloatArray,
    theta: FloatArray,
    body: AxisDynamics,
    turning: FloatArray,
    omega: FloatArray,
) -> FloatArray:
    """Return what of the rates goes with the residuals, F e, shape (U, 2 m, number of rates)."""
    half = len(omega)
    rates = body.regressors
    e = [residual[:, :half, k] + 1j * residual[:, half:, k] for k in body.equations]
    A = [
        [
            1j * (inertia * omega) - (theta[:, k, rate] * turning)[:, np.newaxis]
            for rate, inertia in zip(rates, row, strict=True)
        ]
        for k, row in zip(body.equations, body.inertia, strict=True)
    ]
    if len(rates) == 1:
        found = [e[0] / A[0][0]]
    else:
        determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0]
        first = A[1][1] * e[0] - A[0][1] * e[1]
        second = A[0][0] * e[1] - A[1][0] * e[0]
        found = [first / determinant, second / determinant]
    out = np.empty((len(residual), 2 * half, len(found)))
    for k, one in enumerate(found):
        out[:, :half, k], out[:, half:, k] = one.real, one.imag
    return out


def sandwich_meat(X: FloatArray, level: FloatArray, coupling: FloatArray) -> FloatArray:
    """Return X' R X for each equation, (U, 3, p, p); level has shape (U, m, 3)."""
    moments, rows, p = X.shape
    # Rows of a matrix lie along the frequencies: products of rows are what is quick.
    across = np.swapaxes(np.concatenate((level, level), axis=1), 1, 2)[:, :, np.newaxis]
    weighed = np.ascontiguousarray(across) * np.ascontiguousarray(np.swapaxes(X, 1, 2))[:, None]
    spread = weighed.reshape(moments, 3 * p, rows) @ coupling
    return weighed @ np.swapaxes(spread.reshape(moments, 3, p, rows), 2, 3)
