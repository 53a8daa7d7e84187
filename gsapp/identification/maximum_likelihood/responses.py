"""From computed responses to what the instruments record: paths, time shifts, scale, bias.

Each is applied to the values, shape (n,), and to the sensitivities, shape (m, n), and gives the
derivative by its own parameter. Recorded(t) = scale * path(computed)(t - shift) + bias.
"""

from __future__ import annotations

import numpy as np

from gsapp.quantities import FloatArray


def shift_samples(rows: FloatArray, samples: float) -> tuple[FloatArray, FloatArray]:
    """Return rows as they were `samples` samples ago, and the derivative by `samples`.

    Cubic convolution (Catmull-Rom): smooth in the shift, so that Gauss-Newton can find it. Beyond
    the ends the outermost sample holds.

    Parameters
    ----------
    rows : ndarray, shape (..., n)
    samples : float
        Positive: late.
    """
    count = rows.shape[-1]
    place = np.arange(count) - samples
    base = np.floor(place)
    u = float(place[0] - base[0])
    weights = (
        ((-0.5 * u + 1.0) * u - 0.5) * u,
        (1.5 * u - 2.5) * u * u + 1.0,
        ((-1.5 * u + 2.0) * u + 0.5) * u,
        (0.5 * u - 0.5) * u * u,
    )
    slopes = (
        (-1.5 * u + 2.0) * u - 0.5,
        (4.5 * u - 5.0) * u,
        (-4.5 * u + 4.0) * u + 0.5,
        (1.5 * u - 1.0) * u,
    )
    moved = np.zeros_like(rows)
    change = np.zeros_like(rows)
    for offset, (weight, slope) in enumerate(zip(weights, slopes, strict=True)):
        index = np.clip(base.astype(np.intp) + offset - 1, 0, count - 1)
        taken = rows[..., index]
        moved += weight * taken
        # A later shift is an earlier place.
        change -= slope * taken
    return moved, change
