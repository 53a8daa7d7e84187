"""Bounds of estimates: Cramer-Rao, and corrected for colored residuals (notes, section 7).

The estimate minimizes sum v'Wv (5.1.4). Its information is H = sum S'WS; its covariance is H^-1
where W is the inverse of the covariance of white noise, and H^-1 B H^-1 for any W and any
noise, B = sum_jk S_k' W C_j W S_(k+j) being the covariance of the gradient.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from gsapp.identification.statistics.correlation import autocovariance, bartlett, usual_lags
from gsapp.quantities import FloatArray

SINGULAR = 1e-11
"""Eigenvalues of the scaled information below this share of the largest are rounding."""


def information(S: FloatArray, W: FloatArray, *, counted: FloatArray | None = None) -> FloatArray:
    """Return H = sum_k S_k' W S_k, shape (n_parameters, n_parameters).

    Parameters
    ----------
    S : ndarray, shape (n, n_responses, n_parameters)
    W : ndarray, shape (n_responses, n_responses)
    counted : ndarray, shape (n, n_responses), optional
        Residuals, or anything else that is NaN where a sample does not count.
    """
    kept = S if counted is None else _counted(S, counted)
    flat = kept.reshape(-1, kept.shape[2])
    found: FloatArray = flat.T @ (W @ kept).reshape(flat.shape)
    return 0.5 * (found + found.T)


def cramer_rao(S: FloatArray, W: FloatArray, *, counted: FloatArray | None = None) -> FloatArray:
    """Return the Cramer-Rao covariance (sum S'WS)^-1, W = R^-1.

    Parameters as in `information`. A parameter that the responses do not see, or that lies in a
    combination of which they see nothing, has an infinite variance.
    """
    return inverse(information(S, W, counted=counted))


def inverse(H: FloatArray) -> FloatArray:
    """Return the inverse of an information matrix; infinite variances where it has none."""
    inverted, lost = _inverse(H)
    inverted[lost, lost] = np.inf
    return inverted


def score_covariance(
    S: FloatArray,
    v: FloatArray,
    W: FloatArray,
    *,
    lags: int | None = None,
    segments: Sequence[slice] | None = None,
) -> FloatArray:
    """Return B, the covariance of the gradient sum S'Wv under colored residuals.

    B = sum_j (1 - |j|/(Lg + 1)) sum_k S_k' W C_j W S_(k+j), by FFT: the cost grows with
    n log n whatever the number of lags.

    Parameters
    ----------
    S, v, W
        As everywhere here.
    lags : int, optional
        Lg. By default `gsapp.identification.statistics.correlation.usual_lags`.
    segments : sequence of slice, optional
        Lags do not cross from one to the next.
    """
    if lags is None:
        lags = usual_lags(len(v))
    weighted = W @ _counted(S, v)
    C, layout = autocovariance(v, lags, segments)
    density = layout.spectrum_of_lags(C * bartlett(lags)[:, None, None])
    if not np.isfinite(v).all():
        density = _positive(density)
    G = layout.spectrum(weighted)
    right = density @ G
    # The spectrum of a real row: each frequency but the first and (even length) the last twice.
    right[1 : (layout.length + 1) // 2] *= 2.0
    width = G.shape[2]
    product = G.conj().reshape(-1, width).T @ right.reshape(-1, width)
    B: FloatArray = product.real / layout.length
    return 0.5 * (B + B.T)


def sandwich(H: FloatArray, B: FloatArray) -> FloatArray:
    """Return H^-1 B H^-1; infinite variances where H has no inverse."""
    inverted, lost = _inverse(H)
    found = inverted @ B @ inverted
    found[lost, lost] = np.inf
    return 0.5 * (found + found.T)


def colored_covariance(
    S: FloatArray,
    v: FloatArray,
    W: FloatArray,
    *,
    lags: int | None = None,
    segments: Sequence[slice] | None = None,
) -> FloatArray:
    """Return the covariance of estimates made with any W under colored residuals.

    Notes, section 7: "Any W, colored". Parameters as in `score_covariance`. For several
    maneuvers fitted together sum `information` and `score_covariance` over them and take their
    `sandwich`.
    """
    B = score_covariance(S, v, W, lags=lags, segments=segments)
    return sandwich(information(S, W, counted=v), B)


def noise_covariance(v: FloatArray, *, diagonal: bool = False) -> FloatArray:
    """Return R = mean of v v', shape (n_responses, n_responses).

    Parameters
    ----------
    v : ndarray, shape (n, n_responses)
        Each element of R is the mean over the samples where both responses count.
    diagonal : bool
        Leave the covariances between responses out.

    Notes
    -----
    With missing samples the means need not fit together; R is then made positive by lifting its
    eigenvalues. A response without any sample has a zero row.
    """
    counted = np.isfinite(v)
    clean = np.where(counted, v, 0.0)
    pairs = counted.T.astype(np.float64) @ counted
    R: FloatArray = clean.T @ clean / np.maximum(pairs, 1.0)
    if diagonal:
        return np.diag(R.diagonal())
    if not counted.all():
        scale = np.sqrt(np.where(R.diagonal() > 0.0, R.diagonal(), 1.0))
        values, vectors = np.linalg.eigh(R / scale / scale[:, None])
        if values[0] < 0.0:
            lifted: FloatArray = (vectors * np.maximum(values, 1e-6)) @ vectors.T
            R = lifted * scale * scale[:, None]
    return R


def _counted(S: FloatArray, v: FloatArray) -> FloatArray:
    counted = np.isfinite(v)
    return S if counted.all() else S * counted[:, :, None]


def _inverse(H: FloatArray) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """Return the inverse on what H sees, and the indices of parameters that it does not."""
    diagonal = H.diagonal()
    seen = diagonal > 0.0
    scale = 1.0 / np.sqrt(np.where(seen, diagonal, 1.0))
    values, vectors = np.linalg.eigh(H * scale * scale[:, None])
    good = values > SINGULAR * max(float(values[-1]), 1e-300)
    reciprocal = np.where(good, 1.0 / np.where(good, values, 1.0), 0.0)
    inverted: FloatArray = (vectors * reciprocal) @ vectors.T * scale * scale[:, None]
    # Taking part in a combination that is not seen: beyond the rounding of the eigenvectors.
    lost = ~seen | (np.abs(vectors[:, ~good]) > 1e-3).any(axis=1)
    return inverted, np.flatnonzero(lost)


def _positive(density: FloatArray) -> FloatArray:
    """Return Hermitian matrices with their negative eigenvalues lifted to zero."""
    values, vectors = np.linalg.eigh(0.5 * (density + density.conj().swapaxes(1, 2)))
    lifted: FloatArray = (vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.conj().swapaxes(
        1, 2
    )
    return lifted
