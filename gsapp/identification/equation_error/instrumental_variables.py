"""Motion that the surfaces alone explain: instruments without the noise of the regressors."""

from __future__ import annotations

import numpy as np

from gsapp.quantities import FloatArray

_ROWS_PER_COLUMN = 8
"""Rows that a stretch must have for each number of its model."""
_LARGEST_GROWTH = 10.0
"""By which an unstable model may grow within a stretch."""


def simulate_instruments(states: FloatArray, surfaces: FloatArray) -> FloatArray | None:
    """Return what the surfaces make of the states, shape (n, n_states), or None.

    A model from row to row, x' = A x + B u + B' u' + c, is fitted to the stretch, and run with the
    surfaces alone from the first row.

    Parameters
    ----------
    states : ndarray, shape (n, n_states)
    surfaces : ndarray, shape (n, n_surfaces)

    Returns
    -------
    ndarray or None
        None where the stretch is too short or the model grows beyond bounds.
    """
    count, order = states.shape
    past = np.column_stack((states[:-1], surfaces[:-1], surfaces[1:], np.ones(count - 1)))
    if count < _ROWS_PER_COLUMN * past.shape[1]:
        return None
    scale = np.maximum(np.linalg.norm(past, axis=0), 1e-300)
    solution = np.linalg.lstsq(past / scale, states[1:], rcond=1e-10)[0] / scale[:, None]
    A = np.ascontiguousarray(solution[:order].T)
    growth = float(np.abs(np.linalg.eigvals(A)).max())
    if growth**count > _LARGEST_GROWTH:
        return None
    drive = past[:, order:] @ solution[order:]
    out = np.empty_like(states)
    now = states[0]
    out[0] = now
    for index in range(count - 1):
        now = A @ now + drive[index]
        out[index + 1] = now
    return out
