"""Linear regression of one coefficient, with bounds that believe in colored residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.ndimage import convolve1d

from gsapp.quantities import FloatArray

_LONGEST_CORRELATION = 1.0
"""Of the residuals, s: how far their autocovariance is followed."""
_LEAST_OVER_NOISE = 3.0
"""What the other regressors leave of one, over the noise in it: below, it is noise."""
_LARGEST_INFLATION = 1e7
"""Of a variance by collinearity, where there is no noise to compare with."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equation:
    """y = X theta + e, sampled often enough and no more.

    Attributes
    ----------
    y : ndarray, shape (n,)
    X : ndarray, shape (n, k)
        Both filtered alike.
    names : tuple of str
        Of the columns.
    segments : tuple of slice
        Unbroken stretches of rows.
    dt : float
        Between rows, s.
    stride : int
        Samples of the record for each row.
    noise : ndarray, shape (k, k)
        What measurement noise adds to X'X.
    """

    y: FloatArray
    X: FloatArray
    names: tuple[str, ...]
    segments: tuple[slice, ...]
    dt: float
    stride: int
    noise: FloatArray

    def of(self, columns: Sequence[int]) -> Equation:
        """Return the equation with these columns only."""
        chosen = list(columns)
        return Equation(
            y=self.y,
            X=self.X[:, chosen],
            names=tuple(self.names[index] for index in chosen),
            segments=self.segments,
            dt=self.dt,
            stride=self.stride,
            noise=self.noise[np.ix_(chosen, chosen)],
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Regression:
    """The solution of an `Equation`.

    Attributes
    ----------
    names : tuple of str
    values : ndarray, shape (k,)
    covariance : ndarray, shape (k, k)
        Colored residuals believed.
    white : ndarray, shape (k, k)
        Every sample of the record taken as independent: the uncorrected bound.
    residuals : ndarray, shape (n,)
    """

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    white: FloatArray
    residuals: FloatArray


def solve(equation: Equation) -> Regression:
    """Solve by least squares, the noise of the regressors taken out of X'X.

    Noise in a regressor makes X'X too large and its slope too small. What is known of it is
    subtracted (errors in variables).
    """
    X, y = equation.X, equation.y
    scale = np.sqrt(np.maximum(np.einsum("ij,ij->j", X, X), 1e-300))
    scaled = X / scale
    information = scaled.T @ scaled - equation.noise / scale[:, None] / scale
    factor = cho_factor(information)
    values = cho_solve(factor, scaled.T @ y)
    residuals = y - scaled @ values
    inverse = cho_solve(factor, np.eye(len(scale)))
    middle, white = _middle(scaled, residuals, equation)
    unscale = 1.0 / scale
    covariance = inverse @ middle @ inverse * unscale[:, None] * unscale
    return Regression(
        names=equation.names,
        values=values * unscale,
        covariance=covariance,
        white=white * inverse * unscale[:, None] * unscale,
        residuals=residuals,
    )


def _middle(
    scaled: FloatArray, residuals: FloatArray, equation: Equation
) -> tuple[FloatArray, float]:
    """Return X' C X for the autocovariance C of the residuals, and their variance per sample.

    Bartlett taper (notes, section 7); the variance that the fit itself has taken out of the
    residuals is put back.
    """
    count, width = scaled.shape
    covariances = autocovariance(residuals, equation.segments, _lags(equation))
    taper = 1.0 - np.arange(covariances.size) / covariances.size
    kernel = np.concatenate(((taper * covariances)[:0:-1], taper * covariances))
    spread = np.empty_like(scaled)
    for part in equation.segments:
        spread[part] = convolve1d(scaled[part], kernel, axis=0, mode="constant")
    middle = scaled.T @ spread
    middle = 0.5 * (middle + middle.T)
    if not covariances[0] > 0.0:
        return middle, 0.0
    taken = float(np.trace(middle)) / covariances[0]
    taken = min(max(taken, float(width)), 0.8 * count)
    grown = count / (count - taken)
    return middle * grown, float(covariances[0]) * grown / equation.stride


def _lags(equation: Equation) -> int:
    longest = max((part.stop - part.start for part in equation.segments), default=1)
    return max(1, min(round(_LONGEST_CORRELATION / equation.dt), longest // 4))


def autocovariance(residuals: FloatArray, segments: Sequence[slice], lags: int) -> FloatArray:
    """Return C_0 ... C_lags of a residual, products within segments only, over all samples."""
    total = np.zeros(lags + 1)
    for part in segments:
        piece = residuals[part]
        size = min(lags + 1, piece.size)
        padded = 2 ** int(np.ceil(np.log2(2 * piece.size)))
        power = np.abs(np.fft.rfft(piece, padded)) ** 2
        total[:size] += np.fft.irfft(power, padded)[:size]
    found: FloatArray = total / max(residuals.size, 1)
    return found


def collinear_columns(equation: Equation) -> dict[str, tuple[str, ...]]:
    """Return the parameters that the data cannot tell apart, each with its partners.

    What is left of a regressor after the others explain it must stand out of the noise that is
    left of it; else the regression would share out noise.
    """
    X = equation.X
    scale = np.sqrt(np.maximum(np.einsum("ij,ij->j", X, X), 1e-300))
    scaled = X / scale
    noise = equation.noise / scale[:, None] / scale
    left = list(range(len(scale)))
    found: dict[str, tuple[str, ...]] = {}
    while len(left) > 1:
        information = scaled[:, left].T @ scaled[:, left]
        inverse = np.linalg.pinv(information, rcond=1e-14, hermitian=True)
        alone = 1.0 / np.maximum(np.diag(inverse), 1e-300)
        weights = inverse / np.diag(inverse)
        own = np.einsum("ij,ik,kj->j", weights, noise[np.ix_(left, left)], weights)
        ratio = alone / np.maximum(_LEAST_OVER_NOISE * own, 1.0 / _LARGEST_INFLATION)
        worst = int(np.argmin(ratio))
        if ratio[worst] >= 1.0:
            break
        share = np.abs(weights[:, worst])
        share[worst] = 0.0
        partners = [left[index] for index in np.flatnonzero(share > 0.5 * share.max())]
        names = tuple(equation.names[index] for index in partners)
        name = equation.names[left[worst]]
        found[name] = names
        for partner in names:
            found[partner] = tuple(dict.fromkeys((*found.get(partner, ()), name)))
        left.pop(worst)
    return found
