"""Small linear algebra for many moments at once."""

from __future__ import annotations

import numpy as np

from gsapp.identification.ftr.settings import FTR_ALGORITHM
from gsapp.quantities import FloatArray


def sum_of_squares(rows: FloatArray) -> FloatArray:
    """Return the sums of squares over rows, (U, r, e) -> (U, e)."""
    along = np.swapaxes(rows, 1, 2)
    return np.asarray(np.vecdot(along, along), dtype=np.float64)


def orthonormal_basis(columns: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an orthonormal basis of columns, and how many of them were not zero.

    Columns of the nuisance may vanish (the transform of a constant does at multiples of 1/T) or
    repeat: the basis then holds zeros in their place.

    `columns`, shape (U, r, k).
    `sizes`, shape (U, k): what the columns are measured against.

    Returns
    -------
    basis : ndarray, shape (U, r, k)
    used : ndarray, shape (U,)
    """
    basis = np.ascontiguousarray(columns.transpose(2, 0, 1))
    basis /= np.maximum(sizes.T, 1e-300)[:, :, np.newaxis]
    least = np.maximum(1e-6 * np.sqrt(np.vecdot(basis, basis)), FTR_ALGORITHM.zero_column_tolerance)
    used = np.zeros(len(columns))
    for place, column in enumerate(basis):
        left = np.sqrt(np.vecdot(column, column))
        counts = left > least[place]
        column *= (counts / np.where(counts, left, 1.0))[:, np.newaxis]  # noqa: PLW2901 - in place
        used += counts
        rest = basis[place + 1 :]
        if len(rest):
            rest -= np.vecdot(column, rest)[:, :, np.newaxis] * column
    return np.ascontiguousarray(basis.transpose(1, 2, 0)), used


def combine_real_imag(rows: FloatArray) -> FloatArray:
    """Return sums of what belongs to real and imaginary parts, (U, 2 m, e) -> (U, m, e)."""
    half = rows.shape[1] // 2
    return np.asarray(rows[:, :half] + rows[:, half:], dtype=np.float64)


def subtract_white_noise(inverse: FloatArray, white: FloatArray) -> FloatArray:
    """Return the inverse of G with white noise taken off its diagonal.

    Of each variable up to 1/(2p) of what it did on its own is taken off: then at least half of G
    stays, whatever the variables. More is not needed where the variable was excited enough to be
    shown. Four terms of the series I + T + T^2 + ... , T = G^-1 N, leave out no more than the
    fourth power of that share.
    """
    diagonal = np.maximum(np.diagonal(inverse, axis1=-2, axis2=-1), 1e-300)
    less = np.minimum(white, 0.5 / diagonal.shape[-1] / diagonal)
    T = inverse * less[..., np.newaxis, :]
    first = inverse + T @ inverse
    return np.asarray(first + T @ (T @ first), dtype=np.float64)


def invert_normal_matrices(G: FloatArray) -> FloatArray:
    """Return the inverse of scaled normal matrices; a variable that did nothing gets zeros."""
    p = G.shape[-1]
    diagonal = np.diagonal(G, axis1=-2, axis2=-1)
    there = diagonal > 0.0
    scale = there / np.sqrt(np.where(there, diagonal, 1.0))
    scales = scale[..., np.newaxis] * scale[..., np.newaxis, :]
    scaled = G * scales
    # A hair on the diagonal keeps columns that are equal to the last bit from stopping it all.
    scaled.reshape(-1, p * p)[:, :: p + 1] += np.where(there, 1e-12, 1.0).reshape(-1, p)
    return np.asarray(np.linalg.inv(scaled) * scales, dtype=np.float64)
